//! Pairs of parameters anywhere on a surface.

use super::cursor::Cursor;
use super::sample::Outcome;
use super::{OrientedPoint, Sample, in_blocks, same_length};
use crate::Point;
use crate::error::Result;
use crate::spline::Surface;

impl Surface {
    /// The points at many pairs `(u, v)`, in the order given; fastest where each is on the patch of the one before.
    /// `O(p² + q² + pq)` a pair, and `O(log n)` where the patch changes. The same to the bit as
    /// [`point`](Self::point).
    ///
    /// # Errors
    /// When the slices differ in length or a parameter is outside the domain; `out` then holds some of the points.
    pub fn points_into(&self, at: &[(f64, f64)], out: &mut [Point]) -> Result<()> {
        same_length(at.len(), out.len())?;
        in_blocks(at, out, 1, |at, out| {
            let (mut row, mut column) = (Cursor::new(self.u()), Cursor::new(self.v()));
            for (&(u, v), out) in at.iter().zip(out) {
                let place = (row.find(u)?, column.find(v)?);
                *out = self.point_on((row.span, column.span), place);
            }
            Ok(())
        })
    }

    /// Points and unit normals at many pairs `(u, v)`, as [`points_into`](Self::points_into).
    ///
    /// # Errors
    /// As for [`points_into`](Self::points_into).
    pub fn oriented_into(&self, at: &[(f64, f64)], out: &mut [OrientedPoint]) -> Result<()> {
        self.outcomes_into(at, out)
    }

    /// Points, first derivatives and unit normals at many pairs `(u, v)`, as [`points_into`](Self::points_into).
    ///
    /// # Errors
    /// As for [`points_into`](Self::points_into).
    pub fn frames_into(&self, at: &[(f64, f64)], out: &mut [Sample]) -> Result<()> {
        self.outcomes_into(at, out)
    }

    fn outcomes_into<T: Outcome>(&self, at: &[(f64, f64)], out: &mut [T]) -> Result<()> {
        same_length(at.len(), out.len())?;
        in_blocks(at, out, 1, |at, out| {
            let (mut row, mut column) = (Cursor::new(self.u()), Cursor::new(self.v()));
            for (&(u, v), out) in at.iter().zip(out) {
                let place = (row.find(u)?, column.find(v)?);
                let [[point, dv], [du, _]] = self.jet::<2>((row.span, column.span), place);
                *out = if self.weights().is_some() {
                    T::of::<true>(&[point, du, dv])
                } else {
                    T::of::<false>(&[point, du, dv])
                };
            }
            Ok(())
        })
    }
}
