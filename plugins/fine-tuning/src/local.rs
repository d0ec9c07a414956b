//! A part of a curve, and its way back.

use loftsman_kernel::Point;
use loftsman_kernel::spline::{Curve, Space};

use crate::alpha::polynomial;
use crate::error::{FineTuneError, Result};

/// The part from `a` to `b`, of a closed curve over its seam where `b` is beyond it.
pub(crate) fn part(curve: &Curve, a: f64, b: f64) -> Result<Curve> {
    let curve = polynomial(curve)?;
    if b > curve.domain().1 {
        return Ok(curve.started_at(a)?.between(a, b)?);
    }
    Ok(curve.between(a, b)?)
}

/// A parameter as a part from `a` to `b` knows it that may go over the seam of a closed curve; `None` where it is not inside.
pub(crate) fn within(space: &Space, (a, b): (f64, f64), u: f64) -> Option<f64> {
    let again = space.is_periodic().then(|| u + space.length());
    std::iter::once(u).chain(again).find(|u| a < *u && *u < b)
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
        let seam = Seam::new(&curve, (a, b))?;
        let raised = if curve.is_periodic() { curve.into_owned() } else { curve.to_clamped()? };
        let raised = raised.elevate(part.degree() - raised.degree())?;
        let raised = raised.insert_knots(&missing(raised.space(), part, &seam))?;
        let space = raised.space();
        let (p, flat) = (space.degree(), space.flat());
        // The vertex at a is the first one that the span behind the last copy of a knows; the one at b the last before b.
        let first = flat[..=space.unrolled_len()].partition_point(|k| *k <= a) - 1 - p;
        // One beyond the seam is there once more, as many later as there are.
        let beyond = if b > space.domain().1 { space.len() } else { 0 };
        let end = seam.wrapped(b);
        let last = flat[p..].partition_point(|k| *k < end) + p - 1 + beyond;
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

/// Parameters of a part that goes over the seam of a closed curve as those of its period.
struct Seam {
    start: f64,
    end: f64,
    /// What knots of the next period are in this one, to the bit.
    again: Vec<(f64, f64)>,
}

impl Seam {
    fn new(curve: &Curve, (a, b): (f64, f64)) -> Result<Self> {
        let (start, end) = curve.domain();
        if b <= end {
            return Ok(Self { start, end, again: Vec::new() });
        }
        let (own, turned) = (curve.space().breakpoints(), curve.started_at(a)?.space().breakpoints());
        let beyond = turned.partition_point(|t| *t < end);
        let mut again: Vec<_> = turned[beyond..].iter().copied().zip(own).collect();
        // The last is where the part starts, which need be no knot.
        if let (Some(last), Some(t)) = (again.last_mut(), turned.last()) {
            *last = (*t, a);
        }
        Ok(Self { start, end, again })
    }

    /// A parameter in the period; its end only where the part ends there.
    fn wrapped(&self, t: f64) -> f64 {
        let known = self.again.binary_search_by(|(knot, _)| knot.total_cmp(&t));
        match known {
            Ok(at) => self.again[at].1,
            Err(_) if t <= self.end => t,
            Err(_) => t - (self.end - self.start),
        }
    }
}

/// The knots that a space lacks to have those of a part inside it, and at its ends as many as the degree.
fn missing(space: &Space, part: &Space, seam: &Seam) -> Vec<f64> {
    let ((a, b), degree) = (part.domain(), space.degree());
    let ends = space.domain();
    let wanted = |t: f64| if t == a || t == b { degree } else { part.multiplicity(t) };
    let lacking = |t: f64| {
        let own = seam.wrapped(t);
        let open_end = !space.is_periodic() && (t == ends.0 || t == ends.1);
        // Around a period both ends are one knot.
        let again = space.is_periodic() && t == b && ((a, t) == ends || own == a);
        let times = if open_end || again { 0 } else { wanted(t).saturating_sub(space.multiplicity(own)) };
        std::iter::repeat_n(own, times)
    };
    let mut all: Vec<f64> = part.breakpoints().into_iter().flat_map(lacking).collect();
    all.sort_by(f64::total_cmp);
    all
}
