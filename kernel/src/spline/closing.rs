//! What is one in the plane of a surface's parameters: where the surface closes, where it ends in a point.

use super::{Direction, Surface};
use crate::Point;
use crate::error::Result;

/// A direction of a surface's parameters, and what the surface does at its two ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterSide {
    /// Where the domain starts.
    pub low: f64,
    /// Where it ends.
    pub high: f64,
    /// Whether the surface is the same at both ends, so that it goes on there: it closes, or is periodic.
    pub closed: bool,
    /// Whether all of the surface at the start, and at the end, is one point.
    pub poles: [bool; 2],
}

impl ParameterSide {
    /// The length of the domain: the period, where it closes.
    pub fn length(&self) -> f64 {
        self.high - self.low
    }

    /// The same place within the domain: less than [`high`](Self::high) where the surface closes; the nearest one where it does not. What is an end, but for the rounding
    /// of the turns to it, is [`low`](Self::low) to the bit.
    pub fn wrapped(&self, x: f64) -> f64 {
        if !self.closed {
            return x.clamp(self.low, self.high);
        }
        let rounding = ROUNDING * x.abs().max(self.low.abs()).max(self.high.abs());
        let x = x - self.length() * ((x - self.low) / self.length()).floor();
        if x >= self.high - rounding || x <= self.low + rounding { self.low } else { x }
    }

    /// The same place, as near to another one as it can be.
    pub fn unwrapped(&self, x: f64, near: f64) -> f64 {
        if self.closed { x + self.length() * ((near - x) / self.length()).round() } else { x }
    }
}

/// What one turn more or less makes of a place, as a part of the largest number in it.
const ROUNDING: f64 = 4.0 * f64::EPSILON;
/// Weights of two ends that differ by less than this part are the same.
const SAME_WEIGHT: f64 = 1e-6;

impl Surface {
    /// What its two directions do at their ends: it closes where the curves at both ends are the same control vertex for control vertex,
    /// and has a pole where such a curve is a point, both to within a distance. `O(n p)` for the `n` vertices of a side.
    ///
    /// # Errors
    /// When an evaluation overflows.
    pub fn parameter_sides(&self, within: f64) -> Result<[ParameterSide; 2]> {
        Ok([self.parameter_side(Direction::U, within)?, self.parameter_side(Direction::V, within)?])
    }

    fn parameter_side(&self, direction: Direction, within: f64) -> Result<ParameterSide> {
        let space = self.space(direction);
        let (low, high) = space.domain();
        if space.is_periodic() {
            return Ok(ParameterSide { low, high, closed: true, poles: [false; 2] });
        }
        let (first, last) = (self.isocurve(direction, low)?, self.isocurve(direction, high)?);
        let near = |a: &Point, b: &Point| (a - b).norm() <= within;
        let is_point = |points: &[Point]| points.iter().all(|p| near(p, &points[0]));
        let poles = [is_point(first.points()), is_point(last.points())];
        let same = first.points().iter().zip(last.points()).all(|(a, b)| near(a, b));
        let alike = match (first.weights(), last.weights()) {
            (Some(a), Some(b)) => a.iter().zip(b).all(|(x, y)| {
                let (x, y) = (x / a[0], y / b[0]);
                (x - y).abs() <= SAME_WEIGHT * x.max(y)
            }),
            _ => true,
        };
        Ok(ParameterSide { low, high, closed: same && alike && poles == [false; 2], poles })
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::super::Curve;
    use super::*;
    use crate::Vector;

    #[test]
    fn spheres_cones_and_tori_close_where_they_do() {
        let (o, x, z) = (Point::origin(), Vector::x(), Vector::z());
        let turned = |profile: &Curve, angle: f64| Surface::revolution(profile, o, z, angle).unwrap();
        let sides =
            |surface: &Surface| surface.parameter_sides(1e-12).unwrap().map(|side| (side.closed, side.poles));
        let meridian = Curve::elliptic_arc(o, -z, x, 0.0, PI).unwrap();
        assert_eq!(sides(&turned(&meridian, TAU)), [(true, [false; 2]), (false, [true; 2])]);
        assert_eq!(sides(&turned(&meridian, 1.0)), [(false, [false; 2]), (false, [true; 2])]);
        let cone = Curve::line(Point::new(2.0, 0.0, 0.0), Point::new(0.0, 0.0, 3.0)).unwrap();
        assert_eq!(sides(&turned(&cone, TAU)), [(true, [false; 2]), (false, [false, true])]);
        let tube = Curve::elliptic_arc(Point::new(3.0, 0.0, 0.0), x, z, 0.0, TAU).unwrap();
        assert_eq!(sides(&turned(&tube, TAU)), [(true, [false; 2]); 2]);
        let periodic = turned(&tube, TAU).to_periodic(Direction::V, 1e-12).unwrap().shape;
        assert_eq!(sides(&periodic), [(true, [false; 2]); 2]);
    }

    #[test]
    fn places_are_wrapped_and_unwrapped() {
        let side = ParameterSide { low: 1.0, high: 3.0, closed: true, poles: [false; 2] };
        assert_eq!([1.0, 2.5, 3.0, 4.5, -0.5].map(|x| side.wrapped(x)), [1.0, 2.5, 1.0, 2.5, 1.5]);
        assert_eq!([side.unwrapped(1.2, 5.0), side.unwrapped(2.9, 1.0)], [5.2, 0.8999999999999999]);
        let open = ParameterSide { closed: false, ..side };
        assert_eq!((open.wrapped(4.0), open.unwrapped(1.2, 5.0)), (3.0, 1.2));
    }

    /// Both ends of any domain are its start to the bit, however many turns away; what is inside stays as it is.
    #[test]
    fn ends_of_what_closes_are_its_start() {
        let mut seed = 0x9e37_79b9_u64;
        let mut number = || {
            seed = seed.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        // As in a file where it was not so, and faces could not be cut.
        let mut ends = vec![(-0.035_084_662_984_84, 2.896_637_204_233)];
        ends.extend((0..2000).map(|k| {
            let low = (number() - 0.5) * 10.0_f64.powi(k % 13 - 6);
            (low, low + (number() + 1e-3) * 10.0_f64.powi(k % 7 - 3))
        }));
        for (low, high) in ends {
            let side = ParameterSide { low, high, closed: true, poles: [false; 2] };
            for turns in -5..6 {
                let by = f64::from(turns) * side.length();
                assert_eq!(side.wrapped(low + by), low, "{low} {high} {turns}");
                assert_eq!(side.wrapped(high + by), low, "{low} {high} {turns}");
                let x = low + side.length() * (0.001 + 0.998 * number());
                assert_eq!(side.wrapped(x), x);
                let near = 1e-12 * (side.length() + by.abs() + low.abs() + high.abs());
                assert!((side.wrapped(x + by) - x).abs() <= near, "{low} {high} {turns} {x}");
            }
        }
    }
}
