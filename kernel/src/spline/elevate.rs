//! Degree elevation: the same shape as one of higher degree.

use super::conversion::{Conversion, Direction};
use super::space::Space;
use super::{Curve, Surface};
use crate::error::{Error, MAX_DEGREE, Result};

impl Space {
    /// The conversion to the space of the next degree with the same continuity: every knot is repeated once more.
    /// An open space that is not clamped stays so; a periodic one stays periodic. `O(n p³)`, all coefficients
    /// non-negative.
    ///
    /// # Errors
    /// When the degree is 0 or already 25.
    pub fn elevating(&self) -> Result<Conversion> {
        let degree = self.degree() + 1;
        if degree > MAX_DEGREE || degree == 1 {
            return Err(Error::Degree { degree: if degree == 1 { 0 } else { degree } });
        }
        let raised = |knots: &[f64]| {
            let mut all = Vec::with_capacity(2 * knots.len());
            for (i, &knot) in knots.iter().enumerate() {
                all.push(knot);
                if knots.get(i + 1) != Some(&knot) {
                    all.push(knot);
                }
            }
            all
        };
        if self.is_periodic() {
            // The first knot and the last are one knot of the closed line, raised at the end only.
            let (knots, (start, _)) = (self.knots(), self.domain());
            let first = knots.partition_point(|&k| k == start);
            let mut all = knots[..first].to_vec();
            all.extend(raised(&knots[first..]));
            return Conversion::elevating(self, Self::periodic(degree, all)?);
        }
        let (a, b) = self.domain();
        let mut all = raised(self.flat());
        // Repeated outer knots are more than the new space needs: its domain starts at the last copy of `a` and
        // ends at the first copy of `b`, with `degree` knots beyond either.
        all.truncate(all.partition_point(|&k| k < b) + degree + 1);
        all.drain(..all.partition_point(|&k| k <= a).saturating_sub(degree + 1));
        Conversion::elevating(self, Self::open(degree, all)?)
    }
}

impl Curve {
    /// The same curve with a degree higher by `by`, as smooth at its knots as before: an interior knot is then
    /// repeated `by` times more. `O(by · n p³)`.
    ///
    /// One degree at a time, each time by averages only, so that no step amplifies errors.
    ///
    /// # Errors
    /// When the degree would exceed 25.
    pub fn elevate(&self, by: usize) -> Result<Self> {
        check_elevation(self.degree(), by)?;
        (0..by).try_fold(self.clone(), |curve, _| curve.convert(&curve.space().elevating()?))
    }
}

impl Surface {
    /// The same surface with a degree higher by `by` in one direction; see [`Curve::elevate`].
    ///
    /// # Errors
    /// When the degree would exceed 25.
    pub fn elevate(&self, direction: Direction, by: usize) -> Result<Self> {
        check_elevation(self.space(direction).degree(), by)?;
        (0..by).try_fold(self.clone(), |surface, _| {
            surface.convert(direction, &surface.space(direction).elevating()?)
        })
    }
}

/// Refuses before any work is done: the steps up to degree 25 of a large shape would take a while.
fn check_elevation(degree: usize, by: usize) -> Result<()> {
    let degree = degree.saturating_add(by);
    if degree > MAX_DEGREE { Err(Error::Degree { degree }) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::testing::{any_curve, any_surface, assert_same_curve, assert_same_surface, line_of};
    use super::*;

    proptest! {
        #[test]
        fn a_higher_degree_changes_nothing(curve in any_curve(), by in 1..4_usize) {
            prop_assume!(curve.degree() + by <= MAX_DEGREE);
            let raised = curve.elevate(by).unwrap();
            prop_assert_eq!(raised.degree(), curve.degree() + by);
            prop_assert_eq!(raised.domain(), curve.domain());
            prop_assert_eq!(raised.is_periodic(), curve.is_periodic());
            prop_assert_eq!(raised.space().is_clamped(), curve.space().is_clamped());
            let spans = curve.space().spans().count();
            prop_assert_eq!(raised.space().breakpoints(), curve.space().breakpoints());
            if curve.is_periodic() {
                prop_assert_eq!(raised.space().len(), curve.space().len() + by * spans);
            } else if curve.space().is_clamped() {
                prop_assert_eq!(raised.space().len(), curve.space().len() + by * spans);
            }
            assert_same_curve(&curve, &raised, 1e-12);
        }

        #[test]
        fn surfaces_in_either_direction(surface in any_surface()) {
            let raised = surface.elevate(Direction::U, 1).unwrap().elevate(Direction::V, 2).unwrap();
            assert_same_surface(&surface, &raised, 1e-12);
        }
    }

    #[test]
    fn up_to_the_highest_degree() {
        let curve = line_of(2, 7);
        let raised = curve.elevate(23).unwrap();
        assert_same_curve(&curve, &raised, 1e-13);
        assert_eq!(raised.elevate(1), Err(Error::Degree { degree: 26 }));
        assert!(matches!(curve.elevate(usize::MAX), Err(Error::Degree { .. })));
    }

    #[test]
    fn the_smallest_periodic_spaces() {
        for (degree, vertices) in [(1, 2), (2, 2), (3, 2), (5, 2), (24, 2), (7, 3)] {
            let space = Space::periodic_uniform(degree, vertices).unwrap();
            let points = (0..vertices).map(|i| crate::Point::new(i as f64, (i * i) as f64, 1.0)).collect();
            let curve = Curve::new(space, points).unwrap();
            assert_same_curve(&curve, &curve.elevate(1).unwrap(), 1e-13);
        }
    }
}
