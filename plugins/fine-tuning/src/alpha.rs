//! The scalar function α: its space, its values, where it is positive.

use std::borrow::Cow;

use loftsman_kernel::error::{Figure, MAX_DEGREE};
use loftsman_kernel::spline::algebra::Function;
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

use crate::error::{FineTuneError, Result};
use crate::flat::within;

/// The largest α that ends are kept with: they are kept to rounding of the curve that α gives without them.
pub(crate) const MOST: f64 = 1e9;

/// The derivative of a polynomial curve as a spline function; of a closed one with corners opened at its seam. `O(n)`.
///
/// # Errors
/// When the curve is rational (weights that are all the same are none), or torn.
pub fn derivative(curve: &Curve) -> Result<Function<Vector>> {
    check_torn(curve.space(), "curve")?;
    let curve = polynomial(curve)?;
    let function = curve.function()?;
    within(function.derivative().or_else(|_| function.opened()?.derivative())?, &curve)
}

/// Refuses what is torn where a knot is repeated more often than its degree.
pub(crate) fn check_torn(space: &Space, what: &'static str) -> Result<()> {
    let breaks = space.breakpoints();
    let inner = breaks.get(1..breaks.len().saturating_sub(1)).unwrap_or_default();
    let torn = inner.iter().find(|t| space.multiplicity(**t) > space.degree());
    torn.map_or(Ok(()), |at| {
        Err(FineTuneError::Torn { what, at: *at, copies: space.multiplicity(*at), degree: space.degree() })
    })
}

/// The space in which α is given by its values alone: that of the derivative, degree `p - 1` on the curve's knots, so that the
/// tuned curve is as smooth as the curve is (paper 5, §2).
///
/// # Errors
/// As for [`derivative`].
pub fn alpha_space(curve: &Curve) -> Result<Space> {
    Ok(derivative(curve)?.space().clone())
}

/// α with these values in the [space](alpha_space) of a curve's derivative: `n - 1` for an open curve of `n` vertices, `n` for a
/// periodic one.
///
/// # Errors
/// When there are not as many values; as for [`alpha_space`].
pub fn alpha_of(curve: &Curve, values: Vec<f64>) -> Result<Function<f64>> {
    let space = alpha_space(curve)?;
    if values.len() != space.len() {
        return Err(FineTuneError::Values {
            found: values.len(),
            needed: space.len(),
            degree: space.degree(),
        });
    }
    Ok(Function::new(space, values)?)
}

/// The curve itself, or without its weights where all are the same.
///
/// # Errors
/// When the curve is rational.
pub(crate) fn polynomial(curve: &Curve) -> Result<Cow<'_, Curve>> {
    match curve.weights() {
        None => Ok(Cow::Borrowed(curve)),
        Some(weights) if same(weights) => {
            Ok(Cow::Owned(Curve::new(curve.space().clone(), curve.points().to_vec())?))
        }
        Some(_) => Err(FineTuneError::Rational { what: "curve" }),
    }
}

/// Whether weights are all one number, so that nothing is rational.
pub(crate) fn same(weights: &[f64]) -> bool {
    weights.iter().all(|w| *w == weights[0])
}

/// α over a curve that is not closed: one whose values all count on its domain, none of them beyond its ends.
pub(crate) fn clamped(alpha: &Function<f64>) -> Result<Function<f64>> {
    let space = alpha.space();
    if space.is_clamped() && !space.is_periodic() { Ok(alpha.clone()) } else { Ok(alpha.opened()?) }
}

/// The smallest and the largest value on the domain, found as the sides of a box are, to `1e-12` of the size of the coefficients.
pub(crate) fn extremes(alpha: &Function<f64>) -> Result<[f64; 2]> {
    let values = alpha.coefficients();
    if alpha.space().degree() == 0 {
        let most = |m: [f64; 2], c: &f64| [m[0].min(*c), m[1].max(*c)];
        return Ok(values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], most));
    }
    let points = values.iter().map(|c| Point::new(*c, 0.0, 0.0)).collect();
    let (low, high) = Curve::new(alpha.space().clone(), points)?.bounds();
    Ok([low.x, high.x])
}

/// Refuses a degree that the tuned curve could not have.
pub(crate) fn check_degree(derivative: &Space, alpha: &Space) -> Result<()> {
    let (derivative, alpha) = (derivative.degree(), alpha.degree());
    if derivative + alpha + 1 > MAX_DEGREE {
        Err(FineTuneError::Degree { derivative, alpha })
    } else {
        Ok(())
    }
}

/// A function on a part of its domain; of a periodic one also over its seam.
///
/// # Errors
/// When it is not there.
pub(crate) fn restricted(alpha: &Function<f64>, a: f64, b: f64) -> Result<Function<f64>> {
    let space = alpha.space();
    if space.domain() == (a, b) {
        return Ok(alpha.clone());
    }
    let over = b > space.domain().1;
    if over && !space.is_periodic() {
        return Err(FineTuneError::Contradiction(format!(
            "α is over [{}, {}] and not periodic, and what is tuned goes over the seam, to {}: give α over what is tuned, [{}, {}]",
            Figure(space.domain().0),
            Figure(space.domain().1),
            Figure(b),
            Figure(a),
            Figure(b)
        )));
    }
    if space.degree() > 0 && over {
        let points = alpha.coefficients().iter().map(|c| Point::new(*c, 0.0, 0.0)).collect();
        let part = Curve::new(space.clone(), points)?.started_at(a)?.between(a, b)?;
        let values = part.points().iter().map(|p| p.x).collect();
        return Ok(Function::new(part.space().clone(), values)?);
    }
    if space.degree() > 0 {
        return Ok(alpha.convert(&space.restricting(a, b)?)?);
    }
    // Steps: those between the ends and the knots between them, of the next period, too.
    let mut knots = vec![a];
    let own = space.breakpoints();
    let again = if over { own.iter().skip(1).map(|t| t + space.length()).collect() } else { Vec::new() };
    knots.extend(own.into_iter().chain(again).filter(|t| *t > a && *t < b));
    knots.push(b);
    let value = |pair: &[f64]| alpha.value(0.5 * (pair[0] + pair[1]));
    let values = knots.windows(2).map(value).collect::<Result<Vec<_>, _>>()?;
    Ok(Function::new(Space::open(0, knots)?, values)?)
}
