//! Surfaces of straight lines: extrusions and ruled surfaces.

use super::{Curve, Space, Surface};
use crate::error::{Error, Result};
use crate::{Point, Vector};

impl Surface {
    /// The surface that a curve goes through when moved along a vector: along `u` the curve in its own space, along
    /// `v` the way, of degree 1 over `[0, 1]`. Exact.
    ///
    /// # Errors
    /// When `along` is zero or a number is not finite.
    pub fn extrusion(curve: &Curve, along: Vector) -> Result<Self> {
        if along == Vector::zeros() {
            return Err(Error::Invalid("the extrusion has no length: give a vector that is not zero".into()));
        }
        let moved = curve.points().iter().map(|p| p + along).collect();
        Self::between_curves(
            curve,
            &Curve::build(curve.space().clone(), moved, curve.weights().map(<[f64]>::to_vec))?,
        )
    }

    /// The surface of the straight lines between points of two curves at the same share of their domains: along `u`
    /// the curves, brought to a space in common ([`Space::common`]), along `v` from the first (0) to the second (1).
    ///
    /// # Errors
    /// When the second curve's knots cannot be told apart in the first one's domain.
    pub fn ruled(first: &Curve, second: &Curve) -> Result<Self> {
        let (first, second) = first.in_common_space(second)?;
        Self::between_curves(&first, &second)
    }

    /// The lines between two curves of one space.
    fn between_curves(first: &Curve, second: &Curve) -> Result<Self> {
        let pairs = |i: usize| [first.points()[i], second.points()[i]];
        let points: Vec<Point> = (0..first.points().len()).flat_map(pairs).collect();
        let weight = |curve: &Curve, i: usize| curve.weights().map_or(1.0, |w| w[i]);
        let rational = first.weights().is_some() || second.weights().is_some();
        let weights = rational
            .then(|| (0..first.points().len()).flat_map(|i| [weight(first, i), weight(second, i)]).collect());
        Self::build(first.space().clone(), Space::clamped(1, &[0.0, 1.0])?, points, weights)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::testing::{any_curve, is_torn, line_of, parameters};
    use super::*;

    proptest! {
        #[test]
        fn extrusions_and_ruled_surfaces(first in any_curve(), second in any_curve()) {
            prop_assume!(!is_torn(second.space()));
            let along = Vector::new(1.0, 2.0, -0.5);
            let extruded = Surface::extrusion(&first, along).unwrap();
            let ruled = Surface::ruled(&first, &second).unwrap();
            let ((a, b), (c, d)) = (first.domain(), second.domain());
            for s in parameters(0.0, 1.0).step_by(3) {
                let (u, w) = ((a + s * (b - a)).min(b), (c + s * (d - c)).min(d));
                let (p, q) = (first.point(u).unwrap(), second.point(w).unwrap());
                prop_assert!((extruded.point(u, 0.3).unwrap() - (p + along * 0.3)).norm() < 1e-11);
                prop_assert!((ruled.point(u, 0.0).unwrap() - p).norm() < 1e-11);
                prop_assert!((ruled.point(u, 1.0).unwrap() - q).norm() < 1e-10);
                let middle = ruled.point(u, 0.5).unwrap();
                prop_assert!((middle - p).cross(&(q - p)).norm() < 1e-9, "off the line");
            }
        }
    }

    #[test]
    fn no_way_no_surface() {
        let curve = line_of(3, 5);
        assert!(Surface::extrusion(&curve, Vector::zeros()).is_err());
        assert!(Surface::extrusion(&curve, Vector::new(f64::NAN, 0.0, 0.0)).is_err());
    }
}
