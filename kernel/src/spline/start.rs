//! Closed curves begun elsewhere.

use super::Curve;
use crate::error::{Error, Result};

impl Curve {
    /// The same closed curve begun at `u`, and gone round once: exact, only knots are inserted. Its domain starts at `u`
    /// and is as long as it was.
    ///
    /// A periodic curve stays periodic: `u` becomes a knot, and its period starts there. An open one that ends where it
    /// starts is cut at `u` and joined again at its old ends, which stay a knot of multiplicity `p`; it is clamped then.
    /// `O(n p)`.
    ///
    /// ```
    /// use loftsman_kernel::{Point, spline::{Curve, Space}};
    /// let points = (0..6).map(|i| Point::new(f64::from(i), f64::from(i * i % 5), 0.0)).collect();
    /// let ring = Curve::new(Space::periodic_uniform(3, 6)?, points)?;
    /// let turned = ring.started_at(2.0)?;
    /// assert_eq!(turned.domain(), (2.0, 8.0));
    /// assert_eq!(turned.points()[0], ring.points()[2]);
    /// # Ok::<(), loftsman_kernel::Error>(())
    /// ```
    ///
    /// # Errors
    /// When `u` is not finite, or outside the domain of an open curve; when an open curve does not end where it starts,
    /// to rounding of its coordinates; when rounding makes knots coincide that were apart.
    pub fn started_at(&self, u: f64) -> Result<Self> {
        let at = self.space().locate(u)?;
        let (a, b) = self.domain();
        if at == a || at == b {
            return Ok(self.clone());
        }
        if self.is_periodic() {
            let ring =
                if self.space().multiplicity(at) == 0 { self.insert_knots(&[at])? } else { self.clone() };
            let by = ring.space().knots().partition_point(|&k| k < at);
            let turning = ring.space().turning(by)?;
            if turning.to().spans().count() != ring.space().spans().count() {
                return Err(Error::Invalid(format!(
                    "knots that are apart would coincide where the curve starts at {at}: start it elsewhere"
                )));
            }
            return ring.convert(&turning);
        }
        let size = self.points().iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()));
        let parts = self.split(at)?;
        let [before, after] = &parts[..] else {
            return Err(Error::Invalid(format!("the curve cannot be cut at {at}")));
        };
        Ok(after.join(before, 64.0 * f64::EPSILON * size)?.shape)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::testing::{any_curve, is_torn, line_of, parameters};
    use super::*;

    proptest! {
        #[test]
        fn it_is_the_same_curve_from_elsewhere(curve in any_curve(), share in 0.0..1.0_f64, knot in any::<bool>()) {
            // Open ones are closed by force.
            let curve = if curve.is_periodic() {
                curve
            } else {
                let (space, mut points, mut weights) = curve.to_clamped().unwrap().into_parts();
                let last = points.len() - 1;
                points[last] = points[0];
                if let Some(weights) = &mut weights {
                    weights[last] *= 1.7;
                }
                Curve::build(space, points, weights).unwrap()
            };
            let (a, b) = curve.domain();
            let u = a + share * (b - a);
            let u = if knot { u.round().clamp(a, b) } else { u };
            prop_assume!(!is_torn(curve.space()));
            let turned = curve.started_at(u).unwrap();
            prop_assert_eq!(turned.is_periodic(), curve.is_periodic());
            let (c, d) = turned.domain();
            prop_assert!((d - c - (b - a)).abs() <= 1e-14 * (b - a).abs().max(d.abs()));
            let size = curve.points().iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()));
            for t in parameters(0.0, 1.0) {
                let along = t * (b - a);
                let old = if u + along <= b { u + along } else { u + along - (b - a) };
                let (old, new) = (old.clamp(a, b), (c + along).min(d));
                let (p, q) = (curve.point(old).unwrap(), turned.point(new).unwrap());
                // High degrees turn sharply: a parameter's rounding shows.
                prop_assert!((p - q).norm() <= 1e-11 * size, "{u} {t}: {p} {q} {curve:?}");
            }
        }
    }

    #[test]
    fn what_is_not_closed_is_refused() {
        let line = line_of(3, 9);
        assert!(line.started_at(2.5).is_err() && line.started_at(f64::NAN).is_err());
        assert_eq!(line.started_at(0.0).unwrap(), line);
    }
}
