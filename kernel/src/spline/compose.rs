//! The same shape as a function of another parameter, of which the first is a linear map.

use super::conversion::{Conversion, Direction};
use super::space::Space;
use super::{Curve, Surface};
use crate::error::{Error, Result};

impl Space {
    /// The conversion to the space of `t ↦ f(slope · t + offset)`, `f` being a spline of this space: the knots `(u - offset) / slope`, and the same vertices, in
    /// reverse where the slope is negative. Knots that are equal stay so; each is rounded once for the difference and once for the quotient.
    ///
    /// # Errors
    /// When the slope is zero, or a number is not finite; when knots overflow; when rounding makes knots coincide that were apart, as where the
    /// offset is so large that the domain's numbers are too coarse for them; when the space has degree 0.
    pub fn composing(&self, slope: f64, offset: f64) -> Result<Conversion> {
        let to = self.composed(slope, offset)?;
        Conversion::reordering(self, to, |k| if slope < 0.0 { self.mirrored(k) } else { k })
    }

    /// The space of `t ↦ f(slope · t + offset)`.
    pub(super) fn composed(&self, slope: f64, offset: f64) -> Result<Self> {
        if slope == 0.0 || !slope.is_finite() || !offset.is_finite() {
            return Err(Error::Invalid(format!(
                "a parameter that is {slope} times another and {offset}: the factor has to be a number that is not zero, and what is added a number"
            )));
        }
        // Not by the reciprocal, which would be rounded once more, and is infinite where the slope is smallest.
        let moved = |k: &f64| (k - offset) / slope;
        let knots = self.knots().iter();
        self.with_knots(if slope < 0.0 {
            knots.rev().map(moved).collect()
        } else {
            knots.map(moved).collect()
        })
    }
}

impl Curve {
    /// The curve `t ↦ C(slope · t + offset)`, over the `t` for which that is in the domain; backwards where the slope is negative. See
    /// [`Space::composing`].
    ///
    /// ```
    /// use loftsman_kernel::Point;
    /// use loftsman_kernel::spline::{Curve, Space};
    ///
    /// let points = (0..5).map(|k| Point::new(f64::from(k), f64::from(k * k), 0.0)).collect();
    /// let curve = Curve::new(Space::clamped_uniform(3, 5)?, points)?;
    /// let backwards = curve.compose(-0.5, 1.0)?;
    /// assert_eq!(backwards.domain(), (-2.0, 2.0));
    /// assert_eq!(backwards.point(0.5)?, curve.point(0.75)?);
    /// # Ok::<(), loftsman_kernel::Error>(())
    /// ```
    ///
    /// # Errors
    /// As for [`Space::composing`].
    pub fn compose(&self, slope: f64, offset: f64) -> Result<Self> {
        self.convert(&self.space().composing(slope, offset)?)
    }
}

impl Surface {
    /// The surface with a linear map of one parameter before it, `S(slope · t + offset, v)` or `S(u, slope · t + offset)`; with a negative slope its normal
    /// points the other way. See [`Space::composing`].
    ///
    /// # Errors
    /// As for [`Space::composing`].
    pub fn compose(&self, direction: Direction, slope: f64, offset: f64) -> Result<Self> {
        self.convert(direction, &self.space(direction).composing(slope, offset)?)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::algebra::Function;
    use super::super::testing::{any_curve, any_space, any_surface};
    use super::*;

    /// Places inside the pieces of a space, where it does not matter to which side rounding goes.
    fn inside(space: &Space) -> Vec<f64> {
        let all = space.breakpoints();
        all.windows(2).flat_map(|w| [0.07, 0.5, 0.93].map(|s| w[0] + s * (w[1] - w[0]))).collect()
    }

    fn slopes() -> impl Strategy<Value = f64> {
        let sizes = prop_oneof![0.1..10.0_f64, Just(1.0), Just(2.0), Just(1e-9), Just(1e9)];
        (sizes, any::<bool>()).prop_map(|(size, back)| if back { -size } else { size })
    }

    proptest! {
        /// With the derivative `slope^k C^(k)`; the knots move by two roundings of the largest number there is.
        #[test]
        fn curves_of_a_map(curve in any_curve(), slope in slopes(), offset in prop_oneof![Just(0.0), -1e3..1e3_f64]) {
            let found = curve.compose(slope, offset).unwrap();
            prop_assert_eq!(found.space().most_repeated(), curve.space().most_repeated());
            prop_assert_eq!(found.is_periodic(), curve.is_periodic());
            let shortest = curve.space().breakpoints().windows(2).fold(f64::INFINITY, |m, w| m.min(w[1] - w[0]));
            // A parameter that is off by `ε` of its own size, on a span so long; the derivative is at most `2 p` times the size over the span.
            let p = curve.degree() as f64;
            let shift = 4.0 * f64::EPSILON * (offset.abs() + 30.0) / shortest;
            for u in inside(curve.space()) {
                let t = (u - offset) / slope;
                let off = (found.point(t).unwrap() - curve.point(u).unwrap()).norm();
                prop_assert!(off < 20.0 * (2.0 * p * shift * 25.0 + 1e-14 * p), "{off:e} at {u}");
                if p <= 5.0 {
                    let [a, b] = [(&found, t), (&curve, u)].map(|(c, x)| c.derivative(x, 1).unwrap());
                    let scale = 20.0 * 25.0 * p / shortest;
                    let off = (a / slope - b).norm();
                    prop_assert!(off < scale * (1e-13 * p + 10.0 * p * shift), "{off:e} of {scale:e} at {u}");
                }
            }
            // With numbers that are exact, there and back is where it was.
            let (slope, offset) = (4.0_f64.copysign(slope), -8.0);
            if curve.space().knots().iter().all(|k| k.fract() == 0.0) {
                let back = curve.compose(slope, offset).unwrap().compose(1.0 / slope, -offset / slope).unwrap();
                prop_assert_eq!(back, curve);
            }
        }

        /// Steps, too, at which a function that runs backwards has what is on the other side.
        #[test]
        fn functions_of_a_map(space in any_space(prop_oneof![8 => 1..=7_usize, 1 => Just(25_usize)]), slope in slopes(), to_steps in any::<bool>()) {
            let space = if to_steps {
                let mut knots = space.breakpoints();
                knots.dedup();
                if knots.len() > 2 && space.is_periodic() {
                    Space::periodic(0, knots).unwrap()
                } else {
                    Space::open(0, knots).unwrap()
                }
            } else {
                space
            };
            let numbers = (0..space.len()).map(|k| (k * 37 % 23) as f64 - 11.0).collect();
            let f = Function::new(space.clone(), numbers).unwrap();
            let g = f.compose(slope, 1.5).unwrap();
            let p = space.degree() as f64;
            for u in inside(&space) {
                let off = (g.value((u - 1.5) / slope).unwrap() - f.value(u).unwrap()).abs();
                prop_assert!(off < 1e-11 * (p + 1.0), "{off:e} at {u} of {space:?}");
            }
            // The integral is that of the values over the slope.
            let [a, b] = [&g, &f].map(|f| f.total().unwrap());
            prop_assert!((a * slope.abs() - b).abs() < 1e-11 * (p + 1.0), "{a} {b}");
        }

        #[test]
        fn surfaces_and_fields_in_either_direction(surface in any_surface(), slope in slopes(), in_u in any::<bool>()) {
            let direction = if in_u { Direction::U } else { Direction::V };
            let found = surface.compose(direction, slope, -0.75).unwrap();
            let field = surface.function().ok().map(|field| field.compose(direction, slope, -0.75).unwrap());
            for u in inside(surface.u()).into_iter().step_by(2) {
                for v in inside(surface.v()).into_iter().step_by(2) {
                    let wanted = surface.point(u, v).unwrap();
                    let map = |x: f64| (x + 0.75) / slope;
                    let (s, t) = if in_u { (map(u), v) } else { (u, map(v)) };
                    prop_assert!((found.point(s, t).unwrap() - wanted).norm() < 1e-10);
                    if let Some(field) = &field {
                        prop_assert!((field.value(s, t).unwrap() - wanted.coords).norm() < 1e-10);
                    }
                }
            }
        }
    }

    #[test]
    fn maps_that_cannot_be_are_refused() {
        let curve = super::super::testing::line_of(3, 900);
        for (slope, offset) in [
            (0.0, 1.0),
            (f64::NAN, 1.0),
            (1.0, f64::NAN),
            (f64::INFINITY, 0.0),
            (1.0, f64::INFINITY),
            (1e-308, 0.0),
            (1.0, 1e18),
        ] {
            assert!(curve.compose(slope, offset).is_err(), "{slope}, {offset}");
        }
        let said = curve.compose(0.0, 1.0).unwrap_err().to_string();
        assert!(said.contains("not zero"), "{said}");
    }
}
