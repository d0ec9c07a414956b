//! The same shape run through backwards, or with other parameters.

use super::conversion::{Conversion, Direction};
use super::space::Space;
use super::{Curve, Surface};
use crate::error::{Error, Result};

impl Space {
    /// The conversion to the mirrored space over the same domain `[a, b]`: what was at `u` is then at `a + b - u`.
    ///
    /// # Errors
    /// When rounding makes knots coincide that were apart, or the space has degree 0.
    pub fn reversing(&self) -> Result<Conversion> {
        let (a, b) = self.domain();
        // The ends are mapped onto each other exactly, and outer knots measured from the end they lie beyond.
        let mirrored = |&k: &f64| {
            if k <= a {
                b + (a - k)
            } else if k >= b {
                a - (k - b)
            } else {
                (a + (b - k)).clamp(a, b)
            }
        };
        let to = self.with_knots(self.knots().iter().rev().map(mirrored).collect())?;
        Conversion::reordering(self, to, |k| self.mirrored(k))
    }

    /// The vertex that becomes number `k` where the parameter runs backwards.
    pub(super) fn mirrored(&self, k: usize) -> usize {
        let (n, p) = (self.len(), self.degree());
        // The function whose support started at knot i then starts where that support ended, at knot i + p + 1.
        let shift = if self.is_periodic() { (p / n + 1) * n - p } else { 0 };
        (2 * n + shift - 1 - k) % n
    }

    /// The conversion to the space stretched and moved to another domain, `u ↦ a' + (u - a) (b' - a') / (b - a)`.
    ///
    /// # Errors
    /// When `start < end` does not hold, the new domain has no usable length, rounding makes knots coincide that
    /// were apart, or the space has degree 0.
    pub fn reparametrising(&self, start: f64, end: f64) -> Result<Conversion> {
        let (a, b) = self.domain();
        let scale = (end - start) / (b - a);
        if !(scale > 0.0 && scale.is_finite()) {
            return Err(Error::EmptyDomain { start, end });
        }
        let moved = |&k: &f64| {
            if k < b { (start + (k - a) * scale).min(end) } else { end + (k - b) * scale }
        };
        let to = self.with_knots(self.knots().iter().map(moved).collect())?;
        Conversion::reordering(self, to, |k| k)
    }

    /// A space of the same kind and multiplicities over other knots.
    pub(super) fn with_knots(&self, knots: Vec<f64>) -> Result<Self> {
        let p = self.degree();
        let space = if self.is_periodic() { Self::periodic(p, knots)? } else { Self::open(p, knots)? };
        if space.spans().count() == self.spans().count() {
            return Ok(space);
        }
        let (start, end) = space.domain();
        Err(Error::Invalid(format!(
            "knots that are apart would coincide in the domain [{start}, {end}], whose numbers are too coarse for \
             them: choose a longer domain, or one nearer to zero"
        )))
    }
}

impl Curve {
    /// The same curve from its end to its start, over the same domain; see [`Space::reversing`].
    ///
    /// # Errors
    /// When rounding makes knots coincide that were apart.
    pub fn reverse(&self) -> Result<Self> {
        self.convert(&self.space().reversing()?)
    }

    /// The same curve over the domain `[start, end]`; see [`Space::reparametrising`].
    ///
    /// # Errors
    /// When `start < end` does not hold, or rounding makes knots coincide that were apart.
    pub fn reparametrise(&self, start: f64, end: f64) -> Result<Self> {
        self.convert(&self.space().reparametrising(start, end)?)
    }
}

impl Surface {
    /// The same surface with one direction reversed; its normal then points the other way.
    ///
    /// # Errors
    /// As for [`Curve::reverse`].
    pub fn reverse(&self, direction: Direction) -> Result<Self> {
        self.convert(direction, &self.space(direction).reversing()?)
    }

    /// The same surface with another domain in one direction.
    ///
    /// # Errors
    /// As for [`Curve::reparametrise`].
    pub fn reparametrise(&self, direction: Direction, start: f64, end: f64) -> Result<Self> {
        self.convert(direction, &self.space(direction).reparametrising(start, end)?)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::testing::{any_curve, any_surface, is_torn, line_of, parameters};
    use super::*;

    proptest! {
        #[test]
        fn backwards_and_stretched(curve in any_curve(), start in -1e3..1e3_f64, length in 1e-2..1e4_f64) {
            prop_assume!(!is_torn(curve.space()));
            let (a, b) = curve.domain();
            let reversed = curve.reverse().unwrap();
            let stretched = curve.reparametrise(start, start + length).unwrap();
            prop_assert_eq!(reversed.domain(), (a, b));
            prop_assert_eq!(stretched.domain(), (start, start + length));
            // A parameter known to 1e-16 of its size moves the point by that much times the speed.
            let tolerance = 1e-12 * 10.0 * (1.0 + (start / length).abs()) * curve.degree() as f64;
            for (s, u) in parameters(0.0, 1.0).zip(parameters(a, b)) {
                let expected = curve.point(u).unwrap();
                let back = reversed.point((a + (b - u)).clamp(a, b)).unwrap();
                let there = stretched.point((start + s * length).min(start + length)).unwrap();
                prop_assert!((back - expected).norm() < 1e-11 * curve.degree() as f64, "reversed at {u}");
                prop_assert!((there - expected).norm() < tolerance * 20.0, "stretched at {u}");
            }
            let again = reversed.reverse().unwrap();
            prop_assert_eq!(again.points(), curve.points());
        }

        #[test]
        fn surfaces_in_either_direction(surface in any_surface()) {
            prop_assume!(!is_torn(surface.u()) && !is_torn(surface.v()));
            let ((a, b), (c, d)) = (surface.u().domain(), surface.v().domain());
            let other = surface.reverse(Direction::U).unwrap().reparametrise(Direction::V, 0.0, 1.0).unwrap();
            for s in parameters(0.0, 1.0).step_by(4) {
                let (u, v) = ((a + s * (b - a)).min(b), (c + s * (d - c)).min(d));
                let (expected, found) = (surface.point(u, v).unwrap(), other.point((a + (b - u)).clamp(a, b), s).unwrap());
                prop_assert!((found - expected).norm() < 1e-11 * 4.0);
            }
        }
    }

    #[test]
    fn domains_that_cannot_be_are_refused() {
        let curve = line_of(3, 900);
        for (start, end) in
            [(1.0, 1.0), (2.0, 1.0), (f64::NAN, 1.0), (0.0, f64::INFINITY), (1e15, 1e15 + 4.0)]
        {
            assert!(curve.reparametrise(start, end).is_err(), "[{start}, {end}]");
        }
    }
}
