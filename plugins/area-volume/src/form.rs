//! The area's bilinear form (paper 2, equation (3)): antisymmetric, banded, exact.

use loftsman_kernel::Result;
use loftsman_kernel::error::Error;
use loftsman_kernel::spline::gram::gauss_legendre;
use loftsman_kernel::spline::space::MAX_ORDER;
use loftsman_kernel::spline::{Curve, Space};

use crate::rule::Basis;

/// `Φ` with `2A = xᵀΦy`, `Φ_ij = ∫ (R_i R'_j - R'_i R_j) du` over the domain, `R` the curve's (rational) basis functions.
///
/// Antisymmetric and banded, wrapping where the curve is periodic: kept as `p` diagonals, `O(n p)`. Computed once for a
/// space; independent of the control vertices.
#[derive(Debug, Clone, PartialEq)]
pub struct AreaForm {
    vertices: usize,
    degree: usize,
    periodic: bool,
    /// Diagonal `k = 1 …= p` after another: entry `(i, i + k)` at `p + i`, the `p` before `i = 0` repeated from the end
    /// (zero where open), so that row `i` reads `Φ_{i,i+k} = d_k[p + i]` and `Φ_{i,i-k} = -d_k[p + i - k]`.
    diagonals: Vec<f64>,
}

/// Points of a panel's rule for rational functions, beyond the degree: see [`AreaForm::of_curve`].
const EXTRA: usize = 4;
/// Halvings of a span for rational functions, after which the integral is taken as it is.
const DEPTH: usize = 40;
/// What is apart by no more than this part of the largest entry, and hardly less than before the last halving, is rounding.
const NOISE: f64 = 1e-11;

impl AreaForm {
    /// The form of the polynomial curves of a space. Exact: Gauss–Legendre quadrature of `p` points a span, for an
    /// integrand of degree `2p - 1`. `O(n p³)`.
    pub fn new(space: &Space) -> Self {
        let p = space.degree();
        let (nodes, weights) = gauss_legendre(p);
        let mut basis = Basis::default();
        Self::sum(space, |span, block| {
            let (a, h) = (space.flat()[span], space.flat()[span + 1] - space.flat()[span]);
            basis.enter(space, span);
            for (x, w) in nodes.iter().zip(&weights) {
                basis.at(a + h * x);
                add_products(block, &basis.values[..=p], &basis.slopes[..=p], w * h);
            }
        })
    }

    /// The form of the curves that differ from this one in their control vertices only. For a rational curve
    /// `Φ_ij = w_i w_j ∫ (N_i N'_j - N'_i N_j) / W² du`: spans are halved until both halves agree with the whole to 1e-14
    /// of the largest entry.
    ///
    /// # Errors
    /// When weights differ so much that the integral overflows.
    pub fn of_curve(curve: &Curve) -> Result<Self> {
        Self::of_splines(curve.space(), curve.weights())
    }

    /// The same from what the curves have in common.
    pub(crate) fn of_splines(space: &Space, weights: Option<&[f64]>) -> Result<Self> {
        let Some(weights) = weights else { return Ok(Self::new(space)) };
        let p = space.degree();
        let (nodes, shares) = gauss_legendre(p + EXTRA);
        let mut basis = Basis::default();
        let form = Self::sum(space, |span, block| {
            basis.enter(space, span);
            let own: Vec<f64> = (span - p..=span).map(|k| weights[space.vertex(k)]).collect();
            let mut part = |a: f64, b: f64| -> Vec<f64> {
                let mut block = vec![0.0; (p + 1) * (p + 1)];
                for (x, share) in nodes.iter().zip(&shares) {
                    basis.at(a + (b - a) * x);
                    let total: f64 = basis.values[..=p].iter().zip(&own).map(|(n, w)| n * w).sum();
                    let factor = share * (b - a) / (total * total);
                    add_products(&mut block, &basis.values[..=p], &basis.slopes[..=p], factor);
                }
                for i in 0..=p {
                    for j in 0..=p {
                        block[i * (p + 1) + j] *= own[i] * own[j];
                    }
                }
                block
            };
            let (a, b) = (space.flat()[span], space.flat()[span + 1]);
            let whole = part(a, b);
            let mut todo = vec![(a, b, whole, f64::INFINITY, 0)];
            while let Some((a, b, whole, before, depth)) = todo.pop() {
                let middle = 0.5 * a + 0.5 * b;
                let (left, right) = (part(a, middle), part(middle, b));
                // An entry is of the order of 1 at most over a whole span: absolute errors will do.
                let apart = whole.iter().zip(left.iter().zip(&right)).map(|(w, (l, r))| (w - l - r).abs());
                let apart = apart.fold(0.0, f64::max);
                // Where weights differ much, rounding is more than that; halving does not take it away.
                let largest = whole.iter().fold(0.0, |m: f64, w| m.max(w.abs()));
                let rounding = apart <= NOISE * largest && apart >= 0.25 * before;
                if apart <= 1e-14 || rounding || depth >= DEPTH || !(a < middle && middle < b) {
                    block.iter_mut().zip(left.iter().zip(&right)).for_each(|(s, (l, r))| *s += l + r);
                } else {
                    todo.push((middle, b, right, apart, depth + 1));
                    todo.push((a, middle, left, apart, depth + 1));
                }
            }
        });
        if form.diagonals.iter().all(|d| d.is_finite()) {
            Ok(form)
        } else {
            Err(Error::Invalid("the curve's weights differ too much for its area to be told".into()))
        }
    }

    fn sum(space: &Space, mut fill: impl FnMut(usize, &mut [f64])) -> Self {
        let (p, n) = (space.degree(), space.len());
        let stride = n + p;
        let mut diagonals = vec![0.0; p * stride];
        let mut block = [0.0; MAX_ORDER * MAX_ORDER];
        let block = &mut block[..(p + 1) * (p + 1)];
        for span in space.spans() {
            block.fill(0.0);
            fill(span, block);
            for i in 0..=p {
                let vertex = space.vertex(span - p + i);
                for j in i + 1..=p {
                    diagonals[(j - i - 1) * stride + p + vertex] += block[i * (p + 1) + j];
                }
            }
        }
        if space.is_periodic() {
            for diagonal in diagonals.chunks_exact_mut(stride) {
                for i in 0..p {
                    // From the back, so that a period shorter than the degree repeats more than once.
                    diagonal[p - 1 - i] = diagonal[p - 1 - i + n];
                }
            }
        }
        Self { vertices: n, degree: p, periodic: space.is_periodic(), diagonals }
    }

    /// The number of control vertices.
    pub fn vertices(&self) -> usize {
        self.vertices
    }

    /// `Φ_ij`.
    pub fn entry(&self, i: usize, j: usize) -> f64 {
        let (n, p) = (self.vertices, self.degree);
        let up = |i: usize, j: usize| -> f64 {
            let distance = if self.periodic { (j + n - i) % n } else { j.wrapping_sub(i) };
            // Around a short period, the same vertex is met again after n.
            let all = (distance..=p).step_by(if self.periodic { n } else { p + 1 }).filter(|&k| k > 0);
            all.map(|k| self.diagonals[(k - 1) * (n + p) + p + i]).sum()
        };
        up(i, j) - up(j, i)
    }

    /// `Φx` and `Φy`, given the coordinates as [`padded`](Self::padded).
    pub(crate) fn apply(&self, x: &[f64], y: &[f64], out_x: &mut [f64], out_y: &mut [f64]) {
        match self.degree {
            1 => self.fixed::<1>(x, y, out_x, out_y),
            2 => self.fixed::<2>(x, y, out_x, out_y),
            3 => self.fixed::<3>(x, y, out_x, out_y),
            4 => self.fixed::<4>(x, y, out_x, out_y),
            5 => self.fixed::<5>(x, y, out_x, out_y),
            _ => self.any(x, y, out_x, out_y),
        }
    }

    fn fixed<const P: usize>(&self, x: &[f64], y: &[f64], out_x: &mut [f64], out_y: &mut [f64]) {
        let n = self.vertices;
        // Slices of one length each, so that the loop needs no checks and runs over several rows at once.
        let ahead: [&[f64]; P] = std::array::from_fn(|k| &self.diagonals[k * (n + P) + P..][..n]);
        let behind: [&[f64]; P] = std::array::from_fn(|k| &self.diagonals[k * (n + P) + P - k - 1..][..n]);
        let (xa, xb): ([&[f64]; P], [&[f64]; P]) =
            (std::array::from_fn(|k| &x[P + k + 1..][..n]), std::array::from_fn(|k| &x[P - k - 1..][..n]));
        let (ya, yb): ([&[f64]; P], [&[f64]; P]) =
            (std::array::from_fn(|k| &y[P + k + 1..][..n]), std::array::from_fn(|k| &y[P - k - 1..][..n]));
        let (out_x, out_y) = (&mut out_x[..n], &mut out_y[..n]);
        for i in 0..n {
            let (mut sx, mut sy) = (0.0, 0.0);
            for k in 0..P {
                let (f, g) = (ahead[k][i], behind[k][i]);
                sx += f * xa[k][i] - g * xb[k][i];
                sy += f * ya[k][i] - g * yb[k][i];
            }
            out_x[i] = sx;
            out_y[i] = sy;
        }
    }

    fn any(&self, x: &[f64], y: &[f64], out_x: &mut [f64], out_y: &mut [f64]) {
        let (n, p) = (self.vertices, self.degree);
        out_x[..n].fill(0.0);
        out_y[..n].fill(0.0);
        for k in 1..=p {
            let diagonal = &self.diagonals[(k - 1) * (n + p)..];
            let (ahead, behind) = (&diagonal[p..][..n], &diagonal[p - k..][..n]);
            for i in 0..n {
                out_x[i] += ahead[i] * x[p + i + k] - behind[i] * x[p + i - k];
                out_y[i] += ahead[i] * y[p + i + k] - behind[i] * y[p + i - k];
            }
        }
    }

    /// Coordinates with `p` more on either side: those that follow around a periodic curve, zeros at open ends.
    pub(crate) fn padded(&self, values: impl Iterator<Item = f64>, out: &mut Vec<f64>) {
        let (n, p) = (self.vertices, self.degree);
        out.clear();
        out.reserve(n + 2 * p);
        out.resize(p, 0.0);
        out.extend(values.take(n));
        out.resize(n + p, 0.0);
        for i in 0..p {
            out.push(if self.periodic { out[p + i] } else { 0.0 });
        }
        if self.periodic {
            for i in 0..p {
                out[p - 1 - i] = out[p - 1 - i + n];
            }
        }
    }
}

fn add_products(block: &mut [f64], values: &[f64], slopes: &[f64], factor: f64) {
    let width = values.len();
    for i in 0..width {
        let (value, slope) = (factor * values[i], factor * slopes[i]);
        for j in i + 1..width {
            block[i * width + j] += value * slopes[j] - slope * values[j];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniform_cubic_entries_are_the_theory_s() {
        let form = AreaForm::new(&Space::periodic_uniform(3, 12).unwrap());
        for i in 0..12 {
            for (k, expected) in [0.0, 49.0 / 72.0, 7.0 / 45.0, 1.0 / 360.0, 0.0].into_iter().enumerate() {
                assert!((form.entry(i, (i + k) % 12) - expected).abs() < 1e-15);
                assert!((form.entry((i + k) % 12, i) + expected).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn degree_1_is_the_shoelace_formula() {
        let form = AreaForm::new(&Space::periodic(1, vec![0.0, 0.1, 1.0, 1.5, 7.0]).unwrap());
        for i in 0..4 {
            assert!((form.entry(i, (i + 1) % 4) - 1.0).abs() < 1e-15 && form.entry(i, i) == 0.0);
        }
    }

    #[test]
    fn applying_is_multiplying() {
        for (degree, n) in [(1, 4), (2, 2), (3, 3), (3, 9), (4, 5), (5, 11), (7, 3), (8, 20)] {
            let knots =
                |count: usize| (0..count).map(|i| i as f64 + 0.4 * (i % 3) as f64).collect::<Vec<_>>();
            let mut spaces = vec![Space::periodic(degree, knots(n + 1)).unwrap()];
            spaces.extend(Space::open(degree, knots(n + degree + 1)));
            for space in spaces {
                let form = AreaForm::new(&space);
                let x: Vec<f64> = (0..n).map(|i| (1.3 * i as f64).sin()).collect();
                let y: Vec<f64> = (0..n).map(|i| (0.7 * i as f64).cos()).collect();
                let (mut px, mut py) = (Vec::new(), Vec::new());
                form.padded(x.iter().copied(), &mut px);
                form.padded(y.iter().copied(), &mut py);
                let (mut fx, mut fy) = (vec![0.0; n], vec![0.0; n]);
                form.apply(&px, &py, &mut fx, &mut fy);
                for i in 0..n {
                    let product = |v: &[f64]| (0..n).map(|j| form.entry(i, j) * v[j]).sum::<f64>();
                    assert!((fx[i] - product(&x)).abs() < 1e-13 && (fy[i] - product(&y)).abs() < 1e-13);
                    if space.is_periodic() {
                        assert!((0..n).map(|j| form.entry(i, j)).sum::<f64>().abs() < 1e-13, "constants");
                    }
                }
            }
        }
    }
}
