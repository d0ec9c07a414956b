//! Gauss–Legendre rules on the spans of a space, with the basis functions' values and slopes at their points.

use loftsman_kernel::spline::Space;
use loftsman_kernel::spline::gram::gauss_legendre;
use loftsman_kernel::spline::space::MAX_ORDER;

/// Points and weights on every span of a space, and the `p + 1` basis functions there.
#[derive(Debug, Clone)]
pub(crate) struct Rule {
    /// `p + 1`.
    pub(crate) width: usize,
    /// Points on each panel (a span or an even part of one).
    pub(crate) per: usize,
    /// The control vertices of each panel's functions, `width` a panel.
    pub(crate) vertices: Vec<u32>,
    /// Values at each point, `width` a point.
    pub(crate) values: Vec<f64>,
    /// First derivatives, likewise.
    pub(crate) slopes: Vec<f64>,
    /// Weights, one a point.
    pub(crate) weights: Vec<f64>,
}

impl Rule {
    /// `per` points on each of `parts` even parts of every span.
    pub(crate) fn new(space: &Space, per: usize, parts: usize) -> Self {
        let (nodes, shares) = gauss_legendre(per);
        let width = space.degree() + 1;
        let count = space.spans().count() * parts;
        let mut rule = Self {
            width,
            per,
            vertices: Vec::with_capacity(count * width),
            values: Vec::with_capacity(count * per * width),
            slopes: Vec::with_capacity(count * per * width),
            weights: Vec::with_capacity(count * per),
        };
        let mut basis = Basis::default();
        for span in space.spans() {
            let (a, b) = (space.flat()[span], space.flat()[span + 1]);
            basis.enter(space, span);
            let h = (b - a) / parts as f64;
            for part in 0..parts {
                let first = span + 1 - width;
                rule.vertices.extend((first..=span).map(|k| space.vertex(k) as u32));
                for (x, share) in nodes.iter().zip(&shares) {
                    basis.at(a + h * (part as f64 + x));
                    rule.values.extend_from_slice(&basis.values[..width]);
                    rule.slopes.extend_from_slice(&basis.slopes[..width]);
                    rule.weights.push(share * h);
                }
            }
        }
        rule
    }

    /// The number of panels.
    pub(crate) fn panels(&self) -> usize {
        self.vertices.len() / self.width
    }

    /// The vertices of a panel.
    pub(crate) fn vertices_of(&self, panel: usize) -> &[u32] {
        &self.vertices[panel * self.width..(panel + 1) * self.width]
    }

    /// Values and slopes at a point (counted through all panels).
    pub(crate) fn functions(&self, point: usize) -> (&[f64], &[f64]) {
        let range = point * self.width..(point + 1) * self.width;
        (&self.values[range.clone()], &self.slopes[range])
    }

    /// The same with rational functions `w_i N_i / Σ w_j N_j` in place of the basis functions.
    #[must_use]
    pub(crate) fn weighted(mut self, weights: &[f64]) -> Self {
        for panel in 0..self.panels() {
            let own: Vec<f64> = self.vertices_of(panel).iter().map(|&v| weights[v as usize]).collect();
            for point in panel * self.per..(panel + 1) * self.per {
                let range = point * self.width..(point + 1) * self.width;
                let (values, slopes) = (&mut self.values[range.clone()], &mut self.slopes[range]);
                let (mut total, mut slope) = (0.0, 0.0);
                for k in 0..own.len() {
                    values[k] *= own[k];
                    slopes[k] *= own[k];
                    total += values[k];
                    slope += slopes[k];
                }
                for k in 0..own.len() {
                    values[k] /= total;
                    slopes[k] = (slopes[k] - values[k] * slope) / total;
                }
            }
        }
        self
    }
}

/// Values and slopes of the basis functions of one span, with the quotients of knots taken once.
#[derive(Debug, Clone)]
pub(crate) struct Basis {
    degree: usize,
    /// The `2p` knots around the span.
    knots: [f64; 2 * MAX_ORDER],
    /// `1 / (t_right - t_left)` of every step of the recurrence, in its order.
    reciprocals: [f64; MAX_ORDER * MAX_ORDER / 2],
    pub(crate) values: [f64; MAX_ORDER],
    pub(crate) slopes: [f64; MAX_ORDER],
}

impl Default for Basis {
    fn default() -> Self {
        Self {
            degree: 0,
            knots: [0.0; 2 * MAX_ORDER],
            reciprocals: [0.0; MAX_ORDER * MAX_ORDER / 2],
            values: [0.0; MAX_ORDER],
            slopes: [0.0; MAX_ORDER],
        }
    }
}

impl Basis {
    /// Goes to a span.
    pub(crate) fn enter(&mut self, space: &Space, span: usize) {
        let p = space.degree();
        self.degree = p;
        self.knots[..2 * p].copy_from_slice(&space.flat()[span + 1 - p..=span + p]);
        let mut at = 0;
        for d in 1..=p {
            for j in 0..d {
                self.reciprocals[at] = 1.0 / (self.knots[p + j] - self.knots[p + j - d]);
                at += 1;
            }
        }
    }

    /// Values and slopes at `u`: the recurrence of Cox and de Boor up to degree `p - 1`, from which both follow.
    #[inline]
    pub(crate) fn at(&mut self, u: f64) {
        match self.degree {
            1 => self.fixed::<1>(u),
            2 => self.fixed::<2>(u),
            3 => self.fixed::<3>(u),
            4 => self.fixed::<4>(u),
            5 => self.fixed::<5>(u),
            p => self.any(u, p),
        }
    }

    #[inline]
    fn fixed<const P: usize>(&mut self, u: f64) {
        self.any(u, P);
    }

    #[inline(always)]
    fn any(&mut self, u: f64, p: usize) {
        let (t, row) = (&self.knots[..2 * p], &mut self.values[..=p]);
        row[0] = 1.0;
        let mut at = 0;
        for d in 1..p {
            let mut carry = 0.0;
            for j in 0..d {
                let share = row[j] * self.reciprocals[at];
                at += 1;
                row[j] = carry + (t[p + j] - u) * share;
                carry = (u - t[p + j - d]) * share;
            }
            row[d] = carry;
        }
        let slopes = &mut self.slopes[..=p];
        let (mut carry, mut slope) = (0.0, 0.0);
        for j in 0..p {
            let share = row[j] * self.reciprocals[at];
            at += 1;
            row[j] = carry + (t[p + j] - u) * share;
            carry = (u - t[j]) * share;
            slopes[j] = slope - p as f64 * share;
            slope = p as f64 * share;
        }
        (row[p], slopes[p]) = (carry, slope);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_and_slopes_are_the_kernel_s() {
        for p in 1..=8 {
            let knots = (0..=p + 6).map(|i| f64::from(i as u32) + 0.3 * f64::from(i as u32 % 3)).collect();
            let space = Space::periodic(p, knots).unwrap();
            let mut basis = Basis::default();
            let (mut values, mut slopes) = ([0.0; MAX_ORDER], [0.0; MAX_ORDER]);
            for span in space.spans() {
                basis.enter(&space, span);
                let u = 0.3 * space.flat()[span] + 0.7 * space.flat()[span + 1];
                basis.at(u);
                space.basis_into(span, u, 0, &mut values);
                space.basis_into(span, u, 1, &mut slopes);
                for k in 0..=p {
                    assert!((values[k] - basis.values[k]).abs() < 1e-15);
                    assert!((slopes[k] - basis.slopes[k]).abs() < 1e-14 * p as f64);
                }
            }
        }
    }
}
