//! Lines, circles, ellipses and their arcs as exact splines.
//!
//! A piece of an ellipse that turns by `2h` is a rational quadratic Bézier curve whose middle vertex lies where the
//! tangents at its ends meet and has weight `cos h` (Piegl and Tiller, *The NURBS Book*, §7.3). Arcs are made of
//! equal pieces of at most a quarter turn each, so that no weight is below `cos 45°`.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::{Curve, Space};
use crate::error::{Error, Result};
use crate::{Point, Vector, direction};

impl Curve {
    /// The straight line from one point to another, of degree 1 over `[0, 1]`.
    ///
    /// # Errors
    /// When a coordinate is not finite.
    pub fn line(from: Point, to: Point) -> Result<Self> {
        Self::bezier(vec![from, to])
    }

    /// The circle about `center` in the plane across `normal`, counterclockwise as seen from its tip: clamped,
    /// degree 2, nine vertices, over the angles `[0, 2π]`. It starts in the direction of the coordinate axis that is
    /// most across `normal`, turned into the plane.
    ///
    /// For a periodic curve, see [`to_periodic`](Self::to_periodic).
    ///
    /// # Errors
    /// When the radius is not positive, `normal` has no direction, or a number is not finite.
    pub fn circle(center: Point, normal: Vector, radius: f64) -> Result<Self> {
        if !(radius > 0.0 && radius.is_finite()) {
            return Err(Error::Invalid(format!("the radius {radius} is no length: give a positive number")));
        }
        let normal = unit(normal, "normal")?;
        let axis = Vector::ith(normal.iamin(), 1.0);
        let x = unit(axis - normal * normal.dot(&axis), "normal")?;
        Self::ellipse(center, x * radius, normal.cross(&x) * radius)
    }

    /// The ellipse `center + x cos t + y sin t`: clamped, degree 2, nine vertices, over the angles `[0, 2π]`.
    ///
    /// # Errors
    /// As for [`elliptic_arc`](Self::elliptic_arc).
    pub fn ellipse(center: Point, x: Vector, y: Vector) -> Result<Self> {
        Self::elliptic_arc(center, x, y, 0.0, TAU)
    }

    /// The arc `center + x cos t + y sin t` from `t = start` on, by the angle `sweep` (backwards where negative):
    /// clamped, degree 2, over `[0, |sweep|]`. `x` and `y` are any two conjugate half diameters; for a circle they
    /// are equally long and at right angles.
    ///
    /// The parameter is the angle gone through at the knots and nearly so between them.
    ///
    /// ```
    /// use loftsman_kernel::{Point, Vector, spline::Curve};
    /// let arc = Curve::elliptic_arc(Point::origin(), Vector::x() * 2.0, Vector::y(), 0.0, 1.2)?;
    /// let p = arc.point(0.7)?;
    /// assert!(((p.x / 2.0).powi(2) + p.y.powi(2) - 1.0).abs() < 1e-15);
    /// # Ok::<(), loftsman_kernel::Error>(())
    /// ```
    ///
    /// # Errors
    /// When `x` and `y` are parallel or zero, the sweep is zero or beyond a full turn, or a number is not finite.
    pub fn elliptic_arc(center: Point, x: Vector, y: Vector, start: f64, sweep: f64) -> Result<Self> {
        if unit(x, "first half diameter")?.cross(&unit(y, "second half diameter")?).norm()
            < 8.0 * f64::EPSILON
        {
            return Err(Error::Invalid(
                "the half diameters of the ellipse are parallel: turn one of them".into(),
            ));
        }
        if !start.is_finite() {
            return Err(Error::Invalid(format!("the start angle {start} is no number: give one in radians")));
        }
        let turn = Turn::new(sweep)?;
        let (sin, cos) = start.sin_cos();
        let (x, y) = (x * cos + y * sin, y * cos - x * sin);
        let points = turn.steps().map(|(c, s, _)| center + x * c + y * s).collect();
        Self::rational(turn.space()?, points, turn.steps().map(|(_, _, weight)| weight).collect())
    }

    /// The circular arc that `from` goes through when turned about an axis by an angle: clamped, degree 2, over
    /// `[0, |sweep|]`. Positive angles turn counterclockwise as seen from the tip of `direction`.
    ///
    /// # Errors
    /// When `from` lies on the axis, `direction` has none, the sweep is zero or beyond a full turn, or a number is
    /// not finite.
    pub fn arc(from: Point, on_axis: Point, direction: Vector, sweep: f64) -> Result<Self> {
        let direction = unit(direction, "direction of the axis")?;
        let foot = on_axis + direction * direction.dot(&(from - on_axis));
        let x = from - foot;
        if x == Vector::zeros() {
            return Err(Error::Invalid(
                "the arc would start on the axis that it turns about, and so stand still: move its start, or the axis".into(),
            ));
        }
        Self::elliptic_arc(foot, x, direction.cross(&x), 0.0, sweep)
    }
}

/// A turn by an angle in pieces of at most a quarter: what arcs and surfaces of revolution have in common.
pub(super) struct Turn {
    sweep: f64,
    pieces: usize,
}

impl Turn {
    /// A turn by a signed angle in radians.
    pub(super) fn new(sweep: f64) -> Result<Self> {
        let size = sweep.abs();
        // An angle worked out from others may exceed the full turn by its rounding.
        if !(size > 0.0 && size <= TAU * (1.0 + 4.0 * f64::EPSILON)) {
            return Err(Error::Invalid(format!(
                "the angle {sweep} is no turn: give one that is not zero and at most a full turn, 2π = {TAU}"
            )));
        }
        let sweep = if size > TAU { TAU.copysign(sweep) } else { sweep };
        let pieces = (size / FRAC_PI_2 * (1.0 - 8.0 * f64::EPSILON)).ceil().max(1.0) as usize;
        Ok(Self { sweep, pieces })
    }

    /// Whether the turn ends where it starts.
    pub(super) fn is_full(&self) -> bool {
        self.sweep.abs() == TAU
    }

    /// The space of the turn: degree 2 over `[0, |sweep|]`, knots doubled between the pieces.
    pub(super) fn space(&self) -> Result<Space> {
        let size = self.sweep.abs();
        let at = |i: usize| if i == self.pieces { size } else { size * i as f64 / self.pieces as f64 };
        let mut knots = vec![0.0];
        knots.extend((0..=self.pieces).flat_map(|i| [at(i); 2]));
        knots.push(size);
        Space::open(2, knots)
    }

    /// For each control vertex its place `(x, y)`, where the turn starts at `(1, 0)`, and its weight.
    pub(super) fn steps(&self) -> impl Iterator<Item = (f64, f64, f64)> + '_ {
        // Quarter turns are exact, so that full circles close to the last bit.
        const QUARTERS: [(f64, f64); 8] = [
            (1.0, 0.0),
            (1.0, 1.0),
            (0.0, 1.0),
            (-1.0, 1.0),
            (-1.0, 0.0),
            (-1.0, -1.0),
            (0.0, -1.0),
            (1.0, -1.0),
        ];
        let quarters = self.sweep.abs() == FRAC_PI_2 * self.pieces as f64;
        let half = 0.5 * self.sweep / self.pieces as f64;
        (0..=2 * self.pieces).map(move |i| {
            let middle = i % 2 == 1;
            let weight = if middle { half.cos() } else { 1.0 };
            if quarters {
                let (c, s) = QUARTERS[i % 8];
                return (c, s * self.sweep.signum(), weight);
            }
            let (s, c) = (half * i as f64).sin_cos();
            (c / weight, s / weight, weight)
        })
    }
}

/// The direction of a vector, which has a name.
pub(super) fn unit(vector: Vector, name: &str) -> Result<Vector> {
    direction(&vector).ok_or_else(|| {
        let [x, y, z] = [vector.x, vector.y, vector.z];
        Error::Invalid(format!(
            "the {name} ({x}, {y}, {z}) has no direction: give a finite vector that is not zero"
        ))
    })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use proptest::prelude::*;

    use super::super::testing::parameters;
    use super::*;
    use crate::shape::Shape;

    proptest! {
        #[test]
        fn arcs_lie_on_their_ellipse(
            scale in -9.0..9.0_f64, flat in 0.01..1.0_f64, start in -7.0..7.0_f64, sweep in -TAU..TAU,
        ) {
            prop_assume!(sweep.abs() > 1e-3);
            let size = 10.0_f64.powf(scale);
            let (x, y) = (Vector::new(size, 0.0, size), Vector::new(0.0, flat * size, 0.0));
            let center = Point::new(0.3 * size, -size, 0.0);
            let arc = Curve::elliptic_arc(center, x, y, start, sweep).unwrap();
            prop_assert_eq!(Shape::domain(&arc)[0].end, sweep.abs());
            for u in parameters(0.0, sweep.abs()) {
                let d = arc.point(u).unwrap() - center;
                let (c, s) = (d.dot(&x) / x.norm_squared(), d.dot(&y) / y.norm_squared());
                // The coordinates are rounded to 1e-16 of the longer half diameter.
                prop_assert!((c.hypot(s) - 1.0).abs() < 4e-15 / flat, "at {u}");
            }
            for &u in &arc.space().breakpoints() {
                let t = start + u * sweep.signum();
                let expected = center + x * t.cos() + y * t.sin();
                prop_assert!((arc.point(u).unwrap() - expected).norm() < 1e-14 * size);
            }
        }
    }

    #[test]
    fn circles_close_to_the_bit_and_are_round() {
        for normal in [Vector::z(), Vector::new(1.0, -2.0, 0.5) * 1e-300, Vector::new(0.0, 1e200, 1e200)] {
            let circle = Curve::circle(Point::new(1.0, 2.0, 3.0), normal, 2.5).unwrap();
            assert_eq!(circle.points().len(), 9);
            assert_eq!(circle.points().first(), circle.points().last());
            for u in parameters(0.0, TAU) {
                let (p, d) =
                    (circle.point(u).unwrap() - Point::new(1.0, 2.0, 3.0), circle.derivative(u, 1).unwrap());
                assert!((p.norm() - 2.5).abs() < 2e-15 && p.dot(&d).abs() < 1e-14);
                assert!(p.cross(&d).dot(&(normal / normal.amax())) > 0.0);
            }
        }
    }

    #[test]
    fn a_quarter_and_a_half_turn_have_the_known_vertices() {
        let half = Curve::arc(Point::new(2.0, 0.0, 5.0), Point::origin(), Vector::z(), PI).unwrap();
        let expected = [[2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [-2.0, 2.0], [-2.0, 0.0]];
        for (p, [x, y]) in half.points().iter().zip(expected) {
            assert_eq!(*p, Point::new(x, y, 5.0));
        }
        let back = Curve::arc(Point::new(2.0, 0.0, 5.0), Point::origin(), -Vector::z(), -FRAC_PI_2).unwrap();
        assert_eq!(back.points(), &half.points()[..3]);
    }

    #[test]
    fn what_is_no_conic_is_refused() {
        let (o, x, y) = (Point::origin(), Vector::x(), Vector::y());
        assert!(Curve::circle(o, Vector::zeros(), 1.0).is_err());
        assert!(Curve::circle(o, x, 0.0).is_err() && Curve::circle(o, x, f64::NAN).is_err());
        assert!(Curve::ellipse(o, x, x * 3.0).is_err());
        assert!(Curve::elliptic_arc(o, x, y, 0.0, 0.0).is_err());
        assert!(Curve::elliptic_arc(o, x, y, 0.0, 7.0).is_err());
        assert!(Curve::elliptic_arc(o, x, y, f64::INFINITY, 1.0).is_err());
        assert!(Curve::elliptic_arc(o, x, y, 0.0, f64::NAN).is_err());
        assert!(Curve::arc(o, o, x, 1.0).is_err());
        assert!(Curve::line(o, Point::new(f64::NAN, 0.0, 0.0)).is_err());
    }
}
