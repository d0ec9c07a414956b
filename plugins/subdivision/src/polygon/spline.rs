//! The curve of a polygon, and the polygon of a curve.

use loftsman_kernel::space::Space;
use loftsman_kernel::spline::Curve;

use super::{Polygon, Scheme};
use crate::error::{Result, SubdivisionError};

impl Polygon {
    /// The limit curve: a spline with the polygon's vertices as control vertices, of degree 2 or 3, periodic or clamped. Knots are
    /// sums of the intervals; of a closed polygon, 0 is at vertex 0 (cubic) or where the interval of vertex 0 begins (Chaikin).
    ///
    /// # Errors
    /// When the intervals are no knots: all zero, or more zeros in a row than the degree has room for.
    pub fn to_curve(&self) -> Result<Curve> {
        let degree = self.scheme.degree();
        let space = if self.closed {
            let n = self.intervals.len();
            // The support of vertex 0 starts so many intervals before its own place.
            let before = degree - 1;
            let mut at = -self.intervals[n - before..].iter().sum::<f64>();
            let mut knots = vec![at];
            for k in 0..n {
                // The place itself is met to the last bit.
                at = if k + 1 == before { 0.0 } else { at + self.intervals[(k + n - before) % n] };
                knots.push(at);
            }
            Space::periodic(degree, knots)?
        } else {
            let mut at = 0.0;
            let mut knots = vec![at; degree + 1];
            for d in self.spans() {
                at += d;
                knots.push(at);
            }
            knots.extend(std::iter::repeat_n(at, degree));
            Space::open(degree, knots)?
        };
        Ok(Curve::new(space, self.points.clone())?)
    }

    /// The polygon whose limit is a curve: of degree 2 or 3, polynomial, periodic or clamped. The way back of
    /// [`to_curve`](Self::to_curve), but for where parameters begin.
    ///
    /// # Errors
    /// When the curve is another.
    pub fn from_curve(curve: &Curve) -> Result<Self> {
        let refused = |problem: String| Err(SubdivisionError::Polygon { problem });
        let scheme = match curve.degree() {
            2 => Scheme::Chaikin,
            3 => Scheme::Cubic,
            degree => {
                return refused(format!(
                    "cannot have a curve of degree {degree}: convert it to degree 2 or 3 first"
                ));
            }
        };
        if curve.weights().is_some() {
            return refused("cannot have a rational curve: take points along it (operation `sample`) and fit a polynomial one to them (operation `fit`) first".to_owned());
        }
        let (space, degree) = (curve.space(), curve.degree());
        let spans = |knots: &[f64]| knots.windows(2).map(|pair| pair[1] - pair[0]).collect::<Vec<_>>();
        let intervals = if space.is_periodic() {
            let mut spans = spans(space.knots());
            let shift = (degree - 1) % spans.len().max(1);
            spans.rotate_left(shift);
            spans
        } else if space.is_clamped() {
            spans(&space.knots()[degree..=space.len()])
        } else {
            return refused("cannot have a curve whose ends float: clamp it first (`to_clamped`)".to_owned());
        };
        Self::new(scheme, curve.points().to_vec(), space.is_periodic())?.with_intervals(intervals)
    }
}
