//! A part of a curve, and its way back.

use loftsman_kernel::Point;
use loftsman_kernel::spline::{Curve, Space};

use crate::alpha::polynomial;
use crate::error::{FineTuneError, Result};

/// The part from `a` to `b`.
pub(crate) fn part(curve: &Curve, a: f64, b: f64) -> Result<Curve> {
    Ok(polynomial(curve)?.between(a, b)?)
}

/// A curve in the degree and with the knots of a tuned part of it, and which of its control vertices that part's are.
#[derive(Debug, Clone)]
pub(crate) struct Host {
    curve: Curve,
    /// The control vertices that are the part's, but for the two at its ends, which are those of the rest.
    inner: Vec<usize>,
}

impl Host {
    /// For a part whose control vertices are in a space. `O(n)`.
    pub(crate) fn new(curve: &Curve, part: &Space) -> Result<Self> {
        let (a, b) = part.domain();
        let curve = polynomial(curve)?;
        let raised = if curve.is_periodic() { curve.into_owned() } else { curve.to_clamped()? };
        let raised = raised.elevate(part.degree() - raised.degree())?;
        let raised = raised.insert_knots(&missing(raised.space(), part))?;
        let space = raised.space();
        let (p, flat) = (space.degree(), space.flat());
        // The vertex at a is the first one that the span behind the last copy of a knows; the one at b the last before b.
        let first = flat[..=space.unrolled_len()].partition_point(|k| *k <= a) - 1 - p;
        let last = flat[p..].partition_point(|k| *k < b) + p - 1;
        if last != first + part.len() - 1 {
            return Err(FineTuneError::Contradiction(format!(
                "the part from {a} to {b} has knots too near to others to be put back: choose other ends"
            )));
        }
        let inner = (first + 1..last).map(|k| space.vertex(k)).collect();
        Ok(Self { curve: raised, inner })
    }

    /// The curve, as it was given.
    pub(crate) fn curve(&self) -> &Curve {
        &self.curve
    }

    /// The control vertex of the curve that each of the part's is, but for the part's first and last.
    pub(crate) fn inner(&self) -> &[usize] {
        &self.inner
    }

    /// The curve with the part's control vertices in the place of its own. Of the rest not a bit changes.
    ///
    /// # Errors
    /// When a coordinate is not finite.
    pub(crate) fn with(&self, part: &[Point]) -> loftsman_kernel::error::Result<Curve> {
        let mut points = self.curve.points().to_vec();
        self.inner.iter().zip(part.iter().skip(1)).for_each(|(&k, point)| points[k] = *point);
        Curve::new(self.curve.space().clone(), points)
    }
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
