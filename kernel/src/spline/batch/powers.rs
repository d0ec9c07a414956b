//! One span of a curve of low degree in powers, and Horner's rule on several parameters at once.

use super::LANES;
use super::curve::Local;
use crate::spline::Curve;

/// One span of a curve of degree `N - 1` in powers of `x = (u - middle) / half`, `x` in `[-1, 1]`: of all places to
/// expand about, the middle has the smallest powers, and up to degree 5 the sum of the coefficients' sizes stays within
/// a small factor of the curve's size, so that Horner's rule loses at most a digit. `L` is 3, or 4 with the weight; `K` is
/// how many of the point, the first and the second derivative are asked.
pub(super) struct Powers<const N: usize, const L: usize, const K: usize> {
    middle: f64,
    over_half: f64,
    coefficients: [[f64; L]; N],
}

impl<const N: usize, const L: usize, const K: usize> Powers<N, L, K> {
    /// Room for a span.
    pub(super) fn new() -> Self {
        Self { middle: 0.0, over_half: 1.0, coefficients: [[0.0; L]; N] }
    }

    /// Horner's rule for the value, and for the derivatives by the same rule on what it leaves: after a step with the
    /// coefficient `c_k`, the quotient's value at `x` is the derivative (over its factorial) of the sum so far.
    #[inline(always)]
    fn several<T: From<[f64; 3]>>(&self, us: &[f64; LANES], out: &mut [T]) {
        let x = us.map(|u| (u - self.middle) * self.over_half);
        let mut jets = [[[0.0; LANES]; L]; K];
        for lane in 0..L {
            let mut sums = [[0.0; LANES]; K];
            sums[0] = [self.coefficients[N - 1][lane]; LANES];
            for k in (0..N - 1).rev() {
                for order in (1..K).rev() {
                    // The quotient of order `order` has its first coefficient after as many steps.
                    if order < N - 1 - k {
                        for i in 0..LANES {
                            sums[order][i] = sums[order][i] * x[i] + sums[order - 1][i];
                        }
                    } else if order == N - 1 - k {
                        sums[order] = sums[order - 1];
                    }
                }
                for i in 0..LANES {
                    sums[0][i] = sums[0][i] * x[i] + self.coefficients[k][lane];
                }
            }
            let mut scale = 1.0;
            for order in 0..K {
                if order > 0 {
                    scale *= order as f64 * self.over_half;
                }
                for i in 0..LANES {
                    jets[order][lane][i] = sums[order][i] * scale;
                }
            }
        }
        if L == 4 {
            quotient(&mut jets);
        }
        for (i, out) in out.chunks_exact_mut(K).enumerate() {
            for (jet, out) in jets.iter().zip(out) {
                *out = T::from([jet[0][i], jet[1][i], jet[2][i]]);
            }
        }
    }
}

impl<const N: usize, const L: usize, const K: usize> Local for Powers<N, L, K> {
    /// For derivatives one by one costs more.
    const PAYS: usize = if K == 1 { 3 } else { 2 };

    /// Taylor's expansion about the middle: the `k`-th derivative is a spline of degree `p - k`, whose vertices are
    /// differences `(p - k + 1) (Q_{j+1} - Q_j) / (t_{j+p-k+1} - t_j)` of those of the derivative before. `O(p³)` for
    /// degrees `p` as small as here.
    fn take(&mut self, curve: &Curve, span: usize) {
        let space = curve.space();
        let (a, b) = (space.flat()[span], space.flat()[span + 1]);
        let (middle, half) = (0.5 * a + 0.5 * b, 0.5 * (b - a));
        let (values, over) = space.triangle::<N>(span, middle);
        let mut net: [[f64; L]; N] = curve.net_on(span);
        let mut coefficients = [[0.0; L]; N];
        for k in 0..N {
            let degree = N - 1 - k;
            for j in 0..=degree {
                for lane in 0..L {
                    coefficients[k][lane] += values[degree][j] * net[j][lane];
                }
            }
            // The next derivative by x, over its factorial.
            let scale = degree as f64 * half / (k + 1) as f64;
            for j in 0..degree {
                let scale = scale * over[degree][j];
                for lane in 0..L {
                    net[j][lane] = (net[j + 1][lane] - net[j][lane]) * scale;
                }
            }
        }
        *self = Self { middle, over_half: 1.0 / half, coefficients };
    }

    fn run<T: From<[f64; 3]>>(&self, us: &[f64], out: &mut [T]) {
        let (mut us, mut out) = (us.chunks_exact(LANES), out.chunks_exact_mut(LANES * K));
        for (us, out) in us.by_ref().zip(out.by_ref()) {
            let mut at = [0.0; LANES];
            at.copy_from_slice(us);
            self.several::<T>(&at, out);
        }
        let (rest, out) = (us.remainder(), out.into_remainder());
        if let Some(last) = rest.last() {
            let mut at = [*last; LANES];
            at[..rest.len()].copy_from_slice(rest);
            self.several::<T>(&at, out);
        }
    }
}

/// Derivatives of `A / W` from those of `A` (in place) and of `W` (the last lane), up to the second:
/// `C = A / W`, `C' = (A' - W' C) / W`, `C'' = (A'' - 2 W' C' - W'' C) / W`.
#[inline(always)]
fn quotient<const L: usize, const K: usize>(jets: &mut [[[f64; LANES]; L]; K]) {
    for i in 0..LANES {
        let over = 1.0 / jets[0][L - 1][i];
        for lane in 0..3 {
            jets[0][lane][i] *= over;
            if K > 1 {
                jets[1][lane][i] = (jets[1][lane][i] - jets[1][L - 1][i] * jets[0][lane][i]) * over;
            }
            if K > 2 {
                let lower = 2.0 * jets[1][L - 1][i] * jets[1][lane][i] + jets[2][L - 1][i] * jets[0][lane][i];
                jets[2][lane][i] = (jets[2][lane][i] - lower) * over;
            }
        }
    }
}
