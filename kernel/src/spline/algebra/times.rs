//! The exact product of two splines made once: piece by piece, with nothing kept for others.

use smallvec::{SmallVec, smallvec};

use super::bernstein::{mixed, partition};
use super::product::{Runs, product_space};
use super::{Coefficient, Function};
use crate::error::Result;

/// The product of two functions, where each of its coefficients is a Bernstein coefficient of one of its pieces: where no factor is more than once
/// continuously differentiable at its knots, as the derivative of a cubic is. `None` where one is; [`Space::product`] has those, too.
///
/// On each piece both factors are brought to Bernstein form by inserting its ends, and multiplied (see [`Product`](super::Product)).
/// `O(n (p² + q² + (p+1)(q+1)))`, with no memory but the answer's.
pub(super) fn times<A: Coefficient, B: Coefficient, C: Coefficient>(
    a: &Function<A>,
    b: &Function<B>,
    multiply: impl Fn(A, B) -> C,
) -> Result<Option<Function<C>>> {
    let (p, q) = (a.space().degree(), b.space().degree());
    let (degree, partition) = (p + q, partition(a.space(), b.space())?);
    let space = product_space(a.space(), b.space(), &partition)?;
    let (knots, count) = (space.knots(), space.len());
    let (inside, mut runs) = (&partition[..partition.len() - 1], Runs::new(knots));
    if !inside.iter().all(|knot| runs.at(*knot) + 1 >= degree) {
        return Ok(None);
    }
    let weights = mixed(p, q);
    let (mut first, mut second) = (Segments::new(a), Segments::new(b));
    let mut all = vec![C::zero(); count];
    let mut runs = Runs::new(knots);
    let seam = runs.at(partition[0]);
    // Where the knots at the start of a piece begin, and how many they are.
    let (mut start, mut times) = (0, seam);
    for (k, ends) in partition.windows(2).enumerate() {
        let (first, second) = (first.on(ends[0], ends[1]), second.on(ends[0], ends[1]));
        let is_last = k + 2 == partition.len();
        let next = if is_last && space.is_periodic() { seam } else { runs.at(ends[1]) };
        let from = usize::from(times <= degree);
        let to = if next < degree { degree.saturating_sub(1) } else { degree };
        for m in from..=to {
            let mut sum = C::zero();
            for s in m.saturating_sub(q)..=m.min(p) {
                sum = sum + multiply(first[s], second[m - s]) * weights[s * (q + 1) + m - s];
            }
            // Its knots are `degree - m` times the start and `m` times the end, and its support begins one before: over the seam perhaps.
            let after = start + times + m;
            let vertex = if after > degree { after - degree - 1 } else { after + count - degree - 1 };
            all[if vertex < count { vertex } else { vertex - count }] = sum;
        }
        (start, times) = (start + times, next);
    }
    Function::new(space, all).map(Some)
}

/// A function's pieces in Bernstein form, asked for in ascending order.
struct Segments<'a, T> {
    of: &'a Function<T>,
    span: usize,
    own: SmallVec<[T; 8]>,
}

impl<'a, T: Coefficient> Segments<'a, T> {
    fn new(of: &'a Function<T>) -> Self {
        let degree = of.space().degree();
        Self { of, span: degree, own: smallvec![T::zero(); degree + 1] }
    }

    /// The `p + 1` Bernstein coefficients `f(x, …, x, y, …, y)` (polar forms, Ramshaw 1987) over `[x, y]`, which no knot is within. Each of
    /// the B-spline coefficients there, the polar form at `p` neighbouring knots, has its knots up to `x` replaced by `x`, one at a time,
    /// and those from `y` on by `y`. `O(p²)`.
    fn on(&mut self, x: f64, y: f64) -> &[T] {
        let space = self.of.space();
        let (p, t, end) = (space.degree(), space.flat(), space.unrolled_len());
        while self.span + 1 < end && t[self.span + 1] <= x {
            self.span += 1;
        }
        let span = self.span;
        let own = &mut self.own[..];
        for (j, own) in own.iter_mut().enumerate() {
            *own = self.of.at(space.vertex(span - p + j));
        }
        // Where an end is a knot one of those to be replaced is it already.
        let (left, right) = (usize::from(t[span] == x), usize::from(t[span + 1] == y));
        for round in 1..=p - left.min(p) {
            for j in 0..=p - left - round {
                let (low, high) = (t[span + j + round - p], t[span + 1 + j]);
                let share = (x - low) / (high - low);
                own[j] = own[j] * (1.0 - share) + own[j + 1] * share;
            }
        }
        for round in 1..=p - right.min(p) {
            for j in (right + round..=p).rev() {
                let high = t[span + 1 + j - round];
                let share = (y - x) / (high - x);
                own[j] = own[j - 1] * (1.0 - share) + own[j] * share;
            }
        }
        own
    }
}
