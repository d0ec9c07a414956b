//! A part of a curve, and its way back.

use loftsman_kernel::spline::{Curve, Space};

use crate::alpha::polynomial;
use crate::error::{FineTuneError, Result};

/// The part from `a` to `b`.
pub(crate) fn part(curve: &Curve, a: f64, b: f64) -> Result<Curve> {
    Ok(polynomial(curve)?.between(a, b)?)
}

/// The curve in the degree and with the knots of a tuned part of it, and that part's control vertices in the place of its own:
/// all but the two at its ends, which are those of the rest. Of the rest not a bit changes.
pub(crate) fn put_back(curve: &Curve, tuned: &Curve) -> Result<Curve> {
    let (a, b) = tuned.domain();
    let curve = polynomial(curve)?;
    let raised = if curve.is_periodic() { curve.into_owned() } else { curve.to_clamped()? };
    let raised = raised.elevate(tuned.degree() - raised.degree())?;
    let missing = missing(raised.space(), tuned.space());
    let raised = raised.insert_knots(&missing)?;
    let (space, mut points, _) = raised.into_parts();
    let (p, flat) = (space.degree(), space.flat());
    // The vertex at a is the first one that the span behind the last copy of a knows; the one at b the last before b.
    let first = flat[..=space.unrolled_len()].partition_point(|k| *k <= a) - 1 - p;
    let last = flat[p..].partition_point(|k| *k < b) + p - 1;
    if last != first + tuned.points().len() - 1 {
        return Err(FineTuneError::Contradiction(format!(
            "the part from {a} to {b} has knots too near to others to be put back: choose other ends"
        )));
    }
    for (k, point) in (first..=last).zip(tuned.points()).skip(1).take(tuned.points().len() - 2) {
        points[space.vertex(k)] = *point;
    }
    Ok(Curve::new(space, points)?)
}

/// The knots that a space lacks to have those of a part inside it, and at its ends as many as the degree.
fn missing(space: &Space, part: &Space) -> Vec<f64> {
    let ((a, b), degree) = (part.domain(), space.degree());
    let ends = space.domain();
    let wanted = |t: f64| if t == a || t == b { degree } else { part.multiplicity(t) };
    let lacking = |t: f64| {
        let open_end = !space.is_periodic() && (t == ends.0 || t == ends.1);
        // Around a period both ends are one knot.
        let again = space.is_periodic() && (a, t) == ends;
        let times = if open_end || again { 0 } else { wanted(t).saturating_sub(space.multiplicity(t)) };
        std::iter::repeat_n(t, times)
    };
    part.breakpoints().into_iter().flat_map(lacking).collect()
}
