//! Places on shapes: whether they are there, and how parameters run along.

use loftsman_kernel::Point;
use loftsman_kernel::functional::Shapes;
use loftsman_kernel::shape::{Derivative, Interval, Location, Shape};

use crate::body::{Body, extent};
use crate::constraint::Hold;
use crate::error::{DynamicsError, Result};

/// What there is to know of where a parameter may be.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slide {
    pub(crate) interval: Interval,
    /// Parameters a unit of length.
    pub(crate) pace: f64,
}

/// Beyond an end by this share of its interval a parameter has left its shape; nearer, an end at rest touches its place by rounding.
const BEYOND: f64 = 1e-9;

impl Slide {
    /// Where a parameter comes that goes on by a length along the shape: round where that is closed, else to the end at most; and whether it
    /// would go beyond.
    pub(crate) fn moved(&self, at: f64, by: f64) -> (f64, bool) {
        let Self { interval, pace } = *self;
        let (to, length) = (at + by * pace, interval.end - interval.start);
        if interval.periodic {
            let inside = (interval.start..interval.end).contains(&to) || !to.is_finite();
            return (
                if inside { to } else { interval.start + (to - interval.start).rem_euclid(length) },
                false,
            );
        }
        let beyond = to < interval.start - BEYOND * length || to > interval.end + BEYOND * length;
        (to.clamp(interval.start, interval.end), beyond)
    }

    /// The whole length of the shape along the parameter.
    pub(crate) fn length(&self) -> f64 {
        (self.interval.end - self.interval.start) / self.pace
    }

    /// How far it is to where a parameter that goes this way leaves its shape, in lengths.
    pub(crate) fn room(&self, at: f64, forward: bool) -> f64 {
        match (self.interval.periodic, forward) {
            (true, _) => f64::INFINITY,
            (false, true) => (self.interval.end - at) / self.pace,
            (false, false) => (at - self.interval.start) / self.pace,
        }
    }
}

/// Whether a constraint's places are on their shapes, and its times ascend.
pub(crate) fn check_constraint(constraint: &Hold, shapes: &Shapes<'_>) -> Result<()> {
    for place in &constraint.places {
        on_shape(shapes, &constraint.name, place.body, place.location)?;
    }
    if constraint.from >= 0.0 && constraint.until > constraint.from {
        return Ok(());
    }
    Err(DynamicsError::Number {
        what: "the end of a constraint's time",
        value: constraint.until,
        needed: "give times of 0 or more, the end after the start",
    })
}

/// How a parameter of a body runs.
pub(crate) fn slide_of(body: Option<&Body>, axis: usize) -> Result<Slide> {
    let (Some(body), Some(interval)) = (body, body.and_then(|body| body.interval(axis))) else {
        let more = "a location with more parameters than the shape has".into();
        return Err(loftsman_kernel::Error::Invalid(more).into());
    };
    let shape = body.shape.as_ref();
    let extent = extent(shape.control_vertices()).max(f64::MIN_POSITIVE);
    let length = length_along(shape, axis).unwrap_or(extent).max(1e-9 * extent);
    Ok(Slide { interval, pace: (interval.end - interval.start) / length })
}

/// The mean length of a shape along a parameter.
fn length_along(shape: &dyn Shape, axis: usize) -> Option<f64> {
    let domain = shape.domain();
    let between = |k: usize, share: f64| domain.get(k).map(|i| i.start + (i.end - i.start) * share);
    const STEPS: usize = 64;
    let mut length = 0.0;
    let mut last: Option<Point> = None;
    for i in 0..=STEPS {
        let own = between(axis, i as f64 / STEPS as f64)?;
        let at = if domain.len() == 2 {
            let other = between(1 - axis, 0.5)?;
            if axis == 0 { [own, other].into() } else { [other, own].into() }
        } else {
            own.into()
        };
        let point = Point::from(shape.value(at, Derivative::POSITION).ok()?);
        length += last.map_or(0.0, |last| (point - last).norm());
        last = Some(point);
    }
    Some(length).filter(|length| length.is_finite() && *length > 0.0)
}

/// Whether a location is on its shape.
pub(crate) fn on_shape(shapes: &Shapes<'_>, name: &str, body: usize, at: Location) -> Result<()> {
    let shape = shapes.get(body)?;
    let parameters = match at {
        Location::Curve(u) => vec![u],
        Location::Surface(u, v) | Location::Face(_, u, v) => vec![u, v],
        Location::Vertex(_) => Vec::new(),
    };
    for (at, interval) in parameters.into_iter().zip(shape.domain()) {
        if !(at >= interval.start && at <= interval.end) {
            let (constraint, start, end) = (name.to_owned(), interval.start, interval.end);
            return Err(DynamicsError::Outside { constraint, at, start, end });
        }
    }
    shape.stencil(at, Derivative::POSITION)?;
    Ok(())
}
