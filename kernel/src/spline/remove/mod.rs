//! Knot removal: fewer control vertices for nearly the same shape.

mod net;
mod passes;
mod sweep;

use net::{ALL, Net, ONE};

use super::conversion::Direction;
use super::space::Space;
use super::{Curve, Surface};
use crate::error::{Error, Result};

/// What removing knots gave.
#[derive(Debug, Clone, PartialEq)]
pub struct Removal<T> {
    /// The shape with fewer knots, over the same domain.
    pub shape: T,
    /// How many knots are gone.
    pub removed: usize,
    /// No point of the shape has moved further than this: the largest distance between the old control vertices
    /// and those that the new shape has once the knots are inserted again.
    pub deviation: f64,
}

impl Curve {
    /// The curve without the knots that it can do without: as many are removed, those that matter least first, as
    /// keep every point within `tolerance` of where it was (at the same parameter). `tolerance` is a length in the
    /// unit of the points; with zero go only knots that not even rounding errors show.
    ///
    /// The knots at the ends of the domain stay (one copy of the seam's, where periodic). `O(n p)`, seven times; where
    /// rounding alone is left of the deviation, a few times more, to take that away as well.
    ///
    /// ```
    /// use loftsman_kernel::{Point, spline::{Curve, Space}};
    /// let points = (0..6).map(|i| Point::new(f64::from(i), f64::from(i * i % 5), 0.0)).collect();
    /// let curve = Curve::new(Space::clamped_uniform(3, 6)?, points)?;
    /// let finer = curve.insert_knots(&[0.5, 1.25, 1.25])?;
    /// let removal = finer.remove_knots(1e-12)?;
    /// assert_eq!((removal.removed, removal.shape.space()), (3, curve.space()));
    /// assert!(removal.deviation < 1e-14);
    /// # Ok::<(), loftsman_kernel::Error>(())
    /// ```
    ///
    /// # Errors
    /// When the tolerance is negative or not a number.
    pub fn remove_knots(&self, tolerance: f64) -> Result<Removal<Self>> {
        self.remove(tolerance, ALL, |_, multiplicity| multiplicity)
    }

    /// The curve without up to `times` copies of the knot `u`, as many as keep every point within `tolerance` of
    /// where it was; see [`remove_knots`](Self::remove_knots).
    ///
    /// # Errors
    /// When `u` is not a knot inside the domain (or the seam of a periodic one), or the tolerance is negative or not
    /// a number.
    pub fn remove_knot(&self, u: f64, times: usize, tolerance: f64) -> Result<Removal<Self>> {
        let u = removable(self.space(), u)?;
        self.remove_copies(u, times, tolerance)
    }

    /// Removes up to `times` copies of the knot `u`.
    pub(super) fn remove_copies(&self, u: f64, times: usize, tolerance: f64) -> Result<Removal<Self>> {
        self.remove(tolerance, ONE, |knot, _| if knot == u { times } else { 0 })
    }

    fn remove(
        &self,
        tolerance: f64,
        passes: &[f64],
        copies: impl Fn(f64, usize) -> usize,
    ) -> Result<Removal<Self>> {
        let net =
            Net { space: self.space(), points: self.points(), weights: self.weights(), outer: 1, inner: 1 };
        let (space, points, weights, removed, deviation) = net.remove(tolerance, passes, copies)?;
        Ok(Removal { shape: Self::build(space, points, weights)?, removed, deviation })
    }
}

impl Surface {
    /// The surface without the knots of one direction that it can do without; see [`Curve::remove_knots`].
    ///
    /// # Errors
    /// When the tolerance is negative or not a number.
    pub fn remove_knots(&self, direction: Direction, tolerance: f64) -> Result<Removal<Self>> {
        self.remove(direction, tolerance, ALL, |_, multiplicity| multiplicity)
    }

    /// The surface without up to `times` copies of a knot of one direction; see [`Curve::remove_knot`].
    ///
    /// # Errors
    /// As for [`Curve::remove_knot`].
    pub fn remove_knot(
        &self,
        direction: Direction,
        knot: f64,
        times: usize,
        tolerance: f64,
    ) -> Result<Removal<Self>> {
        let u = removable(self.space(direction), knot)?;
        self.remove_copies(direction, u, times, tolerance)
    }

    /// Removes up to `times` copies of the knot `u` of a direction.
    pub(super) fn remove_copies(
        &self,
        direction: Direction,
        u: f64,
        times: usize,
        tolerance: f64,
    ) -> Result<Removal<Self>> {
        self.remove(direction, tolerance, ONE, |knot, _| if knot == u { times } else { 0 })
    }

    fn remove(
        &self,
        direction: Direction,
        tolerance: f64,
        passes: &[f64],
        copies: impl Fn(f64, usize) -> usize,
    ) -> Result<Removal<Self>> {
        let (space, (outer, inner)) = match direction {
            Direction::U => (self.u(), (1, self.v().len())),
            Direction::V => (self.v(), (self.u().len(), 1)),
        };
        let net = Net { space, points: self.points(), weights: self.weights(), outer, inner };
        let (space, points, weights, removed, deviation) = net.remove(tolerance, passes, copies)?;
        let shape = match direction {
            Direction::U => Self::build(space, self.v().clone(), points, weights)?,
            Direction::V => Self::build(self.u().clone(), space, points, weights)?,
        };
        Ok(Removal { shape, removed, deviation })
    }
}

/// The knot that `u` names: it must be one that can be removed.
fn removable(space: &Space, u: f64) -> Result<f64> {
    let ((a, b), u) = (space.domain(), space.locate_knot(u)?);
    let inside = space.is_periodic() || u > a && u < b;
    if inside && space.multiplicity(u) > 0 {
        return Ok(if u == b { a } else { u });
    }
    Err(Error::Invalid(format!(
        "{u} is not a knot inside the domain [{a}, {b}]: only those can be removed; name one of them exactly"
    )))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::testing::{any_curve, any_surface, assert_same_curve, is_torn, line_of, parameters};
    use super::*;
    use crate::Point;

    proptest! {
        #[test]
        fn what_was_inserted_comes_out_again(
            curve in any_curve(),
            shares in prop::collection::vec((0.001..0.999_f64, 1..3_usize), 1..12),
        ) {
            // Beyond degree 5 the curve no longer tells which knot was inserted: others go as well as it.
            prop_assume!(curve.degree() <= 5);
            let (a, b) = curve.domain();
            let mut new = Vec::new();
            let mut space = curve.space().clone();
            for (share, times) in shares {
                if let Ok(conversion) = space.inserting(&vec![a + share * (b - a); times]) {
                    space = conversion.to().clone();
                    new.extend(vec![a + share * (b - a); times]);
                }
            }
            let finer = curve.insert_knots(&new).unwrap();
            let removal = finer.remove_knots(1e-11 * 10.0).unwrap();
            prop_assert!(removal.removed >= new.len(), "{} of {}: {:?}", removal.removed, new.len(), curve.space());
            prop_assert!(removal.deviation <= 1e-10);
            prop_assert_eq!(removal.shape.domain(), (a, b));
            prop_assert_eq!(removal.shape.points().len(), finer.points().len() - removal.removed);
            assert_same_curve(&curve, &removal.shape, 1e-10);
            let mut one = finer.clone();
            for &u in &new {
                let removal = one.remove_knot(u, 1, 1e-10).unwrap();
                prop_assert_eq!(removal.removed, 1);
                one = removal.shape;
            }
            prop_assert_eq!(one.space(), curve.space());
            assert_same_curve(&curve, &one, 1e-10);
        }

        #[test]
        fn the_deviation_is_a_bound_and_within_the_tolerance(curve in any_curve(), tolerance in 0.1..8.0_f64) {
            let removal = curve.remove_knots(tolerance).unwrap();
            prop_assert!(removal.deviation <= tolerance * (1.0 + 1e-12));
            prop_assert_eq!(removal.removed, curve.points().len() - removal.shape.points().len());
            let (a, b) = curve.domain();
            for u in parameters(a, b) {
                let moved = (removal.shape.point(u).unwrap() - curve.point(u).unwrap()).norm();
                prop_assert!(moved <= removal.deviation + 1e-12, "{moved} > {}", removal.deviation);
            }
        }

        #[test]
        fn surfaces_in_either_direction(surface in any_surface(), s in 0.01..0.99_f64) {
            for direction in [Direction::U, Direction::V] {
                let (a, b) = surface.space(direction).domain();
                let new = [a + s * (b - a)];
                prop_assume!(surface.space(direction).multiplicity(new[0]) == 0);
                let finer = surface.insert_knots(direction, &new).unwrap();
                let removal = finer.remove_knot(direction, new[0], 1, 1e-10).unwrap();
                prop_assert_eq!(removal.removed, 1);
                prop_assert_eq!(removal.shape.space(direction), surface.space(direction));
                for (p, q) in removal.shape.points().iter().zip(surface.points()) {
                    prop_assert!((p - q).norm() < 1e-10);
                }
                let all = surface.remove_knots(direction, 0.5).unwrap();
                prop_assert!(all.deviation <= 0.5 * (1.0 + 1e-12));
                if is_torn(surface.u()) || is_torn(surface.v()) {
                    continue;
                }
                let (u, v) = (surface.u().domain(), surface.v().domain());
                for s in parameters(0.0, 1.0).step_by(4) {
                    let at = ((u.0 + s * (u.1 - u.0)).min(u.1), (v.0 + s * s * (v.1 - v.0)).min(v.1));
                    let moved = (all.shape.point(at.0, at.1).unwrap() - surface.point(at.0, at.1).unwrap()).norm();
                    prop_assert!(moved <= all.deviation + 1e-12);
                }
            }
        }
    }

    #[test]
    fn many_knots_in_linear_time_and_far_apart_from_rounding() {
        let curve = line_of(3, 50);
        let new: Vec<f64> = (0..20_000).map(|i| 47.0 * (f64::from(i) + 0.5) / 20_000.0).collect();
        let finer = curve.insert_knots(&new).unwrap();
        let removal = finer.remove_knots(1e-9).unwrap();
        assert_eq!(removal.removed, new.len());
        assert!(removal.deviation < 1e-11, "{}", removal.deviation);
        assert_eq!(removal.shape.space(), curve.space());
    }

    #[test]
    fn a_smooth_curve_needs_few_knots() {
        let points =
            (0..=400).map(|i| f64::from(i) / 40.0).map(|t| Point::new(t, t.sin(), t.cos())).collect();
        let curve = Curve::new(Space::clamped_uniform(3, 401).unwrap(), points).unwrap();
        let removal = curve.remove_knots(1e-4).unwrap();
        assert!(removal.deviation <= 1e-4);
        assert!(removal.shape.points().len() < 100, "{}", removal.shape.points().len());
    }

    #[test]
    fn what_cannot_be_removed_is_refused() {
        let curve = line_of(3, 9);
        assert!(curve.remove_knots(f64::NAN).is_err() && curve.remove_knots(-1.0).is_err());
        assert!(curve.remove_knot(0.0, 1, 1.0).is_err() && curve.remove_knot(6.0, 1, 1.0).is_err());
        assert!(curve.remove_knot(2.5, 1, 1.0).is_err() && curve.remove_knot(f64::NAN, 1, 1.0).is_err());
        assert_eq!(curve.remove_knot(2.0, 1, 0.0).unwrap().removed, 0);
        assert_eq!(curve.remove_knots(0.0).unwrap().shape, curve);
    }
}
