//! Surfaces of revolution.

use super::conic::{Turn, unit};
use super::{Curve, Surface};
use crate::error::Result;
use crate::{Point, Vector};

impl Surface {
    /// The surface that a curve goes through when turned about an axis by an angle (backwards where negative): along
    /// `u` the angle, over `[0, |sweep|]`, degree 2, clamped; along `v` the curve, in its own space. Exact.
    ///
    /// `on_axis` is a point of the axis, `direction` points along it; positive angles turn counterclockwise as seen
    /// from its tip. Vertices on the axis stay there: the surface is then degenerate along that row, as a sphere is
    /// at its poles. A full turn closes, clamped; [`to_periodic`](Self::to_periodic) makes it periodic.
    ///
    /// ```
    /// use loftsman_kernel::{Point, Vector, spline::{Curve, Surface}};
    /// use std::f64::consts::{PI, TAU};
    /// let meridian = Curve::elliptic_arc(Point::origin(), -Vector::z(), Vector::x(), 0.0, PI)?;
    /// let sphere = Surface::revolution(&meridian, Point::origin(), Vector::z(), TAU)?;
    /// assert!((sphere.point(1.0, 0.4)?.coords.norm() - 1.0).abs() < 1e-15);
    /// # Ok::<(), loftsman_kernel::Error>(())
    /// ```
    ///
    /// # Errors
    /// When `direction` has none, the sweep is zero or beyond a full turn, or a number is not finite.
    pub fn revolution(profile: &Curve, on_axis: Point, direction: Vector, sweep: f64) -> Result<Self> {
        let direction = unit(direction, "direction of the axis")?;
        let turn = Turn::new(sweep)?;
        let n = profile.points().len();
        let mut points = Vec::with_capacity((2 * 4 + 1) * n);
        let mut weights = Vec::with_capacity(points.capacity());
        for (c, s, weight) in turn.steps() {
            for (j, &point) in profile.points().iter().enumerate() {
                let foot = on_axis + direction * direction.dot(&(point - on_axis));
                let x = point - foot;
                points.push(foot + x * c + direction.cross(&x) * s);
                weights.push(weight * profile.weights().map_or(1.0, |w| w[j]));
            }
        }
        // The first row is the curve itself, to the last bit; and the last one, where the turn is full.
        points[..n].copy_from_slice(profile.points());
        if turn.is_full() {
            let last = points.len() - n;
            points.copy_within(..n, last);
        }
        Self::rational(turn.space()?, profile.space().clone(), points, weights)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use nalgebra::{Rotation3, Unit};
    use proptest::prelude::*;

    use super::super::testing::{any_curve, parameters};
    use super::*;

    proptest! {
        #[test]
        fn every_point_is_one_of_the_curve_turned(curve in any_curve(), sweep in -TAU..=TAU, tilt in -3.0..3.0_f64) {
            prop_assume!(sweep.abs() > 1e-3);
            let (base, axis) = (Point::new(1.0, -2.0, 0.5), Vector::new(1.0, tilt, 2.0));
            let surface = Surface::revolution(&curve, base, axis, sweep).unwrap();
            prop_assert_eq!(surface.v(), curve.space());
            let (a, b) = curve.domain();
            for v in parameters(a, b).step_by(4) {
                let start = curve.point(v).unwrap();
                prop_assert!((surface.point(0.0, v).unwrap() - start).norm() < 1e-12);
                for u in surface.u().breakpoints() {
                    let turn = Rotation3::from_axis_angle(&Unit::new_normalize(axis), u * sweep.signum());
                    let expected = base + turn * (start - base);
                    prop_assert!((surface.point(u, v).unwrap() - expected).norm() < 1e-12 * 20.0);
                }
                for u in parameters(0.0, sweep.abs()).step_by(5) {
                    // Between the knots the angle is not quite the parameter: distance from the axis and height stay.
                    let (p, k) = (surface.point(u, v).unwrap() - base, axis.normalize());
                    let q = start - base;
                    prop_assert!((p.dot(&k) - q.dot(&k)).abs() < 1e-12 * 20.0);
                    prop_assert!((p.cross(&k).norm() - q.cross(&k).norm()).abs() < 1e-12 * 20.0);
                }
            }
        }
    }

    #[test]
    fn full_turns_close_to_the_bit() {
        let profile = Curve::line(Point::new(1.0, 0.1, 0.0), Point::new(2.0, 0.3, 1.0)).unwrap();
        let surface =
            Surface::revolution(&profile, Point::origin(), Vector::new(0.1, 0.2, 1.0), TAU).unwrap();
        assert_eq!(surface.points()[..2], surface.points()[16..]);
        assert!(Surface::revolution(&profile, Point::origin(), Vector::zeros(), TAU).is_err());
        assert!(Surface::revolution(&profile, Point::origin(), Vector::z(), -7.0).is_err());
    }
}
