//! The B-spline basis functions that do not vanish on a span, and their derivatives.
//!
//! The recurrence of Cox and de Boor, in three forms of the same arithmetic: [`Space::basis_into`] for one order of any
//! degree; rows of all orders up to one for any degree; and both for degrees that the compiler knows, so that the
//! triangle is unrolled.

use super::space::{MAX_ORDER, Space};

impl Space {
    /// Values at `u` of the `order`-th derivatives of the `p + 1` basis functions `span - p ..= span`.
    ///
    /// Cox–de Boor up to degree `p - order` (Bartels and Beatty 1989, with the second term's misprint mended),
    /// then `N'_{i,d} = d (N_{i,d-1}/(t_{i+d}-t_i) - N_{i+1,d-1}/(t_{i+d+1}-t_{i+1}))` for the last `order`
    /// degrees. `out` has at least `p + 1` entries; the rest is left alone. An order above `p` gives zeros.
    /// `O(p²)`.
    pub fn basis_into(&self, span: usize, u: f64, order: usize, out: &mut [f64]) {
        match self.degree() {
            1 => out[..2].copy_from_slice(&climb_known::<2>(self.around(span), u, order)),
            2 => out[..3].copy_from_slice(&climb_known::<3>(self.around(span), u, order)),
            3 => out[..4].copy_from_slice(&climb_known::<4>(self.around(span), u, order)),
            4 => out[..5].copy_from_slice(&climb_known::<5>(self.around(span), u, order)),
            5 => out[..6].copy_from_slice(&climb_known::<6>(self.around(span), u, order)),
            p => climb(p, self.around(span), u, order, &mut out[..=p]),
        }
    }

    /// The rows of [`basis_into`](Self::basis_into) for orders `0, 1, …`, as many as `rows` has room for: the triangle
    /// is climbed once, and left at degree `p - k` for order `k`. The same operations in the same order.
    /// `O(p² + p · orders²)`.
    pub(super) fn rows_into(&self, span: usize, u: f64, rows: &mut [[f64; MAX_ORDER]]) {
        let (p, t) = (self.degree(), self.around(span));
        let mut row = [0.0; MAX_ORDER];
        row[0] = 1.0;
        for d in 0..=p {
            if d > 0 {
                raise(t, p, d, u, &mut row);
            }
            if let Some(kept) = rows.get_mut(p - d) {
                kept[..=p].copy_from_slice(&row[..=p]);
            }
        }
        for (order, row) in rows.iter_mut().enumerate().skip(1) {
            if order > p {
                row[..=p].fill(0.0);
                continue;
            }
            for d in p - order + 1..=p {
                differentiate(t, p, d, row);
            }
        }
    }

    /// [`basis_into`](Self::basis_into) of order 0 for degree `N - 1`.
    #[inline]
    pub(super) fn values<const N: usize>(&self, span: usize, u: f64) -> [f64; N] {
        let t = self.around(span);
        let mut row = [0.0; N];
        row[0] = 1.0;
        for d in 1..N {
            raise(t, N - 1, d, u, &mut row);
        }
        row
    }

    /// The rows of orders `0 .. K` for degree `N - 1`. Each width between knots is divided by once, and multiplied by
    /// for every order: that differs from [`basis_into`](Self::basis_into) by rounding.
    #[inline]
    pub(super) fn rows<const N: usize, const K: usize>(&self, span: usize, u: f64) -> [[f64; N]; K] {
        let (mut rows, (values, over)) = ([[0.0; N]; K], self.triangle::<N>(span, u));
        for (order, row) in rows.iter_mut().enumerate().take(N) {
            *row = values[N - 1 - order];
            for d in N - order..N {
                let mut carry = 0.0;
                for j in 0..d {
                    let share = d as f64 * row[j] * over[d][j];
                    row[j] = carry - share;
                    carry = share;
                }
                row[d] = carry;
            }
        }
        rows
    }

    /// The values of the basis functions of degrees `0 .. N` (`d + 1` of degree `d` at `[d]`), and what the recurrence
    /// divides by, inverted: `[d][j]` is `1 / (t_{j+d} - t_j)` for the `j`-th of the `d` widths over the span.
    #[inline]
    pub(super) fn triangle<const N: usize>(&self, span: usize, u: f64) -> ([[f64; N]; N], [[f64; N]; N]) {
        let t = &self.around(span)[..2 * (N - 1)];
        let (mut values, mut over) = ([[0.0; N]; N], [[0.0; N]; N]);
        let mut row = [0.0; N];
        row[0] = 1.0;
        values[0] = row;
        for d in 1..N {
            let mut carry = 0.0;
            for j in 0..d {
                let (left, right) = (t[N - 1 + j - d], t[N - 1 + j]);
                over[d][j] = 1.0 / (right - left);
                let share = row[j] * over[d][j];
                row[j] = carry + (right - u) * share;
                carry = (u - left) * share;
            }
            row[d] = carry;
            values[d] = row;
        }
        (values, over)
    }

    /// The `2p` knots around a span: `t[span + 1 - p ..= span + p]`.
    #[inline]
    fn around(&self, span: usize) -> &[f64] {
        let p = self.degree();
        &self.flat()[span + 1 - p..=span + p]
    }
}

/// The triangle of [`Space::basis_into`] over the knots around a span, into a row of `p + 1`.
#[inline(always)]
fn climb(p: usize, around: &[f64], u: f64, order: usize, row: &mut [f64]) {
    row.fill(0.0);
    if order > p {
        return;
    }
    row[0] = 1.0;
    for d in 1..=p {
        if d > p - order {
            differentiate(around, p, d, row);
        } else {
            raise(around, p, d, u, row);
        }
    }
}

/// The same for degree `N - 1`.
#[inline]
fn climb_known<const N: usize>(around: &[f64], u: f64, order: usize) -> [f64; N] {
    let mut row = [0.0; N];
    climb(N - 1, &around[..2 * (N - 1)], u, order, &mut row);
    row
}

/// From the `d` functions of degree `d - 1` that do not vanish to the `d + 1` of degree `d`.
#[inline(always)]
fn raise(around: &[f64], p: usize, d: usize, u: f64, row: &mut [f64]) {
    let mut carry = 0.0;
    for j in 0..d {
        let (left, right) = (around[p + j - d], around[p + j]);
        let share = row[j] / (right - left);
        row[j] = carry + (right - u) * share;
        carry = (u - left) * share;
    }
    row[d] = carry;
}

/// From the derivatives of some order of the `d` functions of degree `d - 1` to those of the next order of degree `d`.
#[inline(always)]
fn differentiate(around: &[f64], p: usize, d: usize, row: &mut [f64]) {
    let mut carry = 0.0;
    for j in 0..d {
        let share = d as f64 * (row[j] / (around[p + j] - around[p + j - d]));
        row[j] = carry - share;
        carry = share;
    }
    row[d] = carry;
}
