//! The derivative of a polynomial spline as a spline.

use super::{Curve, Space};
use crate::error::{Error, Result};

impl Space {
    /// The space of the derivatives: degree `p - 1`, an open space's knots without the first and the last, a
    /// periodic one's own knots.
    ///
    /// # Errors
    /// When the degree is 0, or a knot inside the domain is repeated so often that the functions jump, or, in a
    /// periodic space, have a corner.
    pub fn derived(&self) -> Result<Self> {
        let Some(degree) = self.degree().checked_sub(1) else { return Err(Error::Degree { degree: 0 }) };
        let knots = self.knots();
        if self.is_periodic() {
            Self::periodic(degree, knots.to_vec())
        } else {
            Self::open(degree, knots[1..knots.len() - 1].to_vec())
        }
    }
}

impl Curve {
    /// The hodograph: the curve whose points are this one's derivatives, `C'(u) = Σ M_i(u) Q_i` with
    /// `Q_i = p (P_{i+1} - P_i) / (t_{i+p+1} - t_{i+1})`, in the space [`Space::derived`]. It is torn where an open
    /// curve has a corner (a knot of multiplicity `p`). `O(n)`.
    ///
    /// # Errors
    /// When the curve is rational (its derivative then has twice the degree), of degree 1 (the derivative is then
    /// constant between knots, and no curve), or torn (a knot of multiplicity `p + 1`), or numbers overflow.
    pub fn hodograph(&self) -> Result<Self> {
        if self.weights().is_some() {
            return Err(Error::Invalid(
                "the derivative of a rational curve is no spline of lower degree: evaluate its derivatives instead"
                    .into(),
            ));
        }
        self.function()?.derivative()?.into_curve()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::testing::{any_curve, line_of, parameters};
    use super::*;

    proptest! {
        #[test]
        fn its_points_are_the_derivatives(curve in any_curve()) {
            let (space, points, _) = curve.into_parts();
            let curve = Curve::new(space, points).unwrap();
            let Ok(hodograph) = curve.hodograph() else {
                let p = curve.degree();
                let allowed = if curve.is_periodic() { p - 1 } else { p };
                let (a, b) = curve.domain();
                let mut torn = curve.space().breakpoints();
                torn.retain(|&t| curve.is_periodic() || t > a && t < b || !curve.space().is_clamped());
                prop_assert!(p == 1 || torn.iter().any(|&t| curve.space().multiplicity(t) > allowed));
                return Ok(());
            };
            let (a, b) = curve.domain();
            for u in parameters(a, b) {
                let expected = curve.derivative(u, 1).unwrap();
                let size = hodograph.points().iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()));
                prop_assert!((hodograph.point(u).unwrap().coords - expected).norm() < 1e-12 * size);
            }
        }
    }

    #[test]
    fn jumping_and_rational_derivatives_are_refused() {
        assert!(matches!(line_of(1, 5).hodograph(), Err(Error::Degree { .. } | Error::Multiplicity { .. })));
        let curve = line_of(3, 9);
        let cornered = curve.insert_knots(&[2.0, 2.0]).unwrap();
        assert!(cornered.hodograph().is_ok());
        let torn = Space::open(2, vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0]).unwrap();
        assert!(matches!(torn.derived(), Err(Error::Multiplicity { .. })));
        let (space, points, _) = curve.into_parts();
        let weights = vec![1.0; points.len()];
        assert!(Curve::rational(space, points, weights).unwrap().hodograph().is_err());
    }
}
