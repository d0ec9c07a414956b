//! One span of a curve of any degree in Bernstein form, for the point and as many derivatives as are asked.

use super::LANES;
use super::curve::Local;
use crate::spline::space::MAX_ORDER;
use crate::spline::{Curve, binomial};

/// The value and the derivatives on one span, each as `Σ C(m,i) b_i x^i y^(m-i)` with `x = (u - start) / length` and
/// `y = 1 - x`. Both are at least 0, so that, unlike with powers, no degree loses digits: a sum is wrong by rounding of
/// the sizes of the `b_i`, which are averages of control vertices. `L` is 3, or 4 with the weight.
pub(super) struct Bernstein<const L: usize> {
    start: f64,
    stop: f64,
    rows: Vec<Row<L>>,
}

/// One derivative: its degree `m`, the `C(m,i)`, and `C(m,i) b_i`.
struct Row<const L: usize> {
    degree: usize,
    binomials: [f64; MAX_ORDER],
    terms: [[f64; L]; MAX_ORDER],
}

impl<const L: usize> Bernstein<L> {
    /// Room for the point and `orders - 1` derivatives of degree `p`, to be filled span by span.
    pub(super) fn new(p: usize, orders: usize) -> Self {
        let row = |order: usize| {
            let (degree, mut binomials) = (p.saturating_sub(order), [0.0; MAX_ORDER]);
            for (i, value) in binomials[..=degree].iter_mut().enumerate() {
                *value = binomial(degree, i);
            }
            Row { degree, binomials, terms: [[0.0; L]; MAX_ORDER] }
        };
        Self { start: 0.0, stop: 0.0, rows: (0..orders).map(row).collect() }
    }
}

impl<const L: usize> Local for Bernstein<L> {
    const PAYS: usize = 5;

    /// Takes a span. `O(p²)` an order: knots are inserted at both ends of the span until it is a Bézier curve, each time
    /// as an average of two neighbours with weights that are not negative (Boehm 1980).
    fn take(&mut self, curve: &Curve, span: usize) {
        let (t, p) = (curve.space().flat(), curve.degree());
        (self.start, self.stop) = (t[span], t[span + 1]);
        let mut net: [[f64; L]; MAX_ORDER] = curve.net_on(span);
        // Orders above the degree stay the zeros they were made as.
        for (order, row) in self.rows.iter_mut().enumerate().take(p + 1) {
            if order > 0 {
                // The derivative's vertices from those of the derivative before.
                let d = p - order + 1;
                for j in 0..d {
                    let scale = d as f64 / (t[span + 1 + j] - t[span + 1 + j - d]);
                    for lane in 0..L {
                        net[j][lane] = (net[j + 1][lane] - net[j][lane]) * scale;
                    }
                }
            }
            let m = row.degree;
            let terms = &mut row.terms[..=m];
            terms.copy_from_slice(&net[..=m]);
            to_bezier(&t[span + 1 - m..=span + m], terms);
            for (b, c) in terms.iter_mut().zip(&row.binomials) {
                *b = b.map(|value| value * c);
            }
        }
    }

    fn run<T: From<[f64; 3]>>(&self, us: &[f64], out: &mut [T]) {
        let orders = self.rows.len();
        let over = 1.0 / (self.stop - self.start);
        let mut jets = [[[0.0; LANES]; L]; MAX_ORDER];
        let mut jet = [[0.0; L]; MAX_ORDER];
        for (us, out) in us.chunks(LANES).zip(out.chunks_mut(LANES * orders)) {
            let mut at = [us[0]; LANES];
            at[..us.len()].copy_from_slice(us);
            let (x, y) = (at.map(|u| (u - self.start) * over), at.map(|u| (self.stop - u) * over));
            for (row, sums) in self.rows.iter().zip(&mut jets) {
                horner(&row.terms[..=row.degree], &x, &y, sums);
            }
            for (i, out) in out.chunks_exact_mut(orders).enumerate() {
                for (value, sums) in jet[..orders].iter_mut().zip(&jets) {
                    *value = sums.map(|lanes| lanes[i]);
                }
                if L == 4 {
                    quotient(&mut jet[..orders]);
                }
                for (out, value) in out.iter_mut().zip(&jet) {
                    *out = T::from([value[0], value[1], value[2]]);
                }
            }
        }
    }
}

/// `Σ c_i x^i y^(m-i)`: Horner's rule in both, without a division and for all of `[0, 1]` alike.
#[inline(always)]
fn horner<const L: usize>(
    row: &[[f64; L]],
    x: &[f64; LANES],
    y: &[f64; LANES],
    sums: &mut [[f64; LANES]; L],
) {
    *sums = row[0].map(|c| [c; LANES]);
    let mut power = *x;
    for c in &row[1..] {
        for (sum, c) in sums.iter_mut().zip(c) {
            for i in 0..LANES {
                sum[i] = sum[i] * y[i] + c * power[i];
            }
        }
        for i in 0..LANES {
            power[i] *= x[i];
        }
    }
}

/// Derivatives of `A / W` from those of `A` (in place) and of `W` (the last lane), as
/// [`derivatives_into`](Curve::derivatives_into) has them.
fn quotient<const L: usize>(jet: &mut [[f64; L]]) {
    let over = 1.0 / jet[0][L - 1];
    for order in 0..jet.len() {
        for j in 1..=order {
            let factor = binomial(order, j) * jet[j][L - 1];
            for lane in 0..L - 1 {
                jet[order][lane] -= factor * jet[order - j][lane];
            }
        }
        for lane in 0..L - 1 {
            jet[order][lane] *= over;
        }
    }
}

/// From the vertices of the B-splines of degree `m` on a span to its Bézier vertices. `around` has the `m` knots up to
/// the span's start and the `m` from its end on. In blossoms: vertex `j` is `f` of `m` consecutive knots from
/// `around[j]` on, and becomes `f` of `m - j` times the start and `j` times the end.
fn to_bezier<const L: usize>(around: &[f64], net: &mut [[f64; L]]) {
    let m = net.len() - 1;
    if m == 0 {
        return;
    }
    let (start, end) = (around[m - 1], around[m]);
    for r in 0..m - 1 {
        // The farthest knot to the left becomes the start of the span.
        let left = around[r];
        if left == start {
            continue;
        }
        for j in (0..=r).rev() {
            let right = around[m + j];
            let share = (start - left) / (right - left);
            for lane in 0..L {
                net[j][lane] = (1.0 - share) * net[j][lane] + share * net[j + 1][lane];
            }
        }
    }
    for r in 0..m - 1 {
        // The farthest knot to the right becomes its end; to the left there are only starts by now.
        let right = around[2 * m - 1 - r];
        if right == end {
            continue;
        }
        let share = (right - end) / (right - start);
        for j in m - r..=m {
            for lane in 0..L {
                net[j][lane] = (1.0 - share) * net[j][lane] + share * net[j - 1][lane];
            }
        }
    }
}
