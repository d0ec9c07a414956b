//! Segments and triangles of any shape, from its values alone: what a plug-in gets that brings no tessellation of its
//! own.

mod line;
mod net;

use super::facets::Faceted;
use crate::Point;
use crate::error::{Error, Result};
use crate::shape::{Derivative, Domain, Location, Shape};
use crate::tessellator::{Chord, Fineness};
use crate::text::short;

/// Pieces of a direction in which nothing bends are so many times halved at most for the sake of the angle: corners
/// stay.
const HALVED_FOR_ANGLE: u32 = 8;
/// So many times for the sake of the chord; what is still apart then has a gap.
const HALVED: u32 = 40;
/// Points that a tessellation may have.
const MOST: usize = 1 << 18;

/// A shape in several states (frames of an animation, or a single one) as segments, or as triangles between the lines
/// of a grid: whatever it is, as long as it has values. Pieces are halved until, in all states, at the quarters of
/// each the shape is no further from them than the chord asked for, and does not turn by more than the angle. What it
/// does between these places is not seen: the error in the result is measured, not certified. Relative chords are
/// those of [`Tessellator::moving_curve`](crate::tessellator::Tessellator::moving_curve). Costs some 25 values a cell
/// and state, in each of as many rounds as pieces are halved.
///
/// # Errors
/// [`Error::NoExtent`] where the shape is one point in all states; when there are no states or they have different
/// domains, a value is refused or not finite, the fineness is not positive or would take more than a quarter of a
/// million points, or the shape has a gap.
pub fn sampled(states: &[&dyn Shape], fineness: &Fineness) -> Result<Faceted> {
    let Some(first) = states.first() else {
        return Err(Error::Invalid("there is no state of the shape to tessellate".into()));
    };
    let domain = first.domain();
    if states.iter().any(|state| state.domain() != domain) {
        return Err(Error::Invalid(
            "the states of the shape have different domains: they are not one shape".into(),
        ));
    }
    fineness.check()?;
    // Where a shape has more vertices, more may happen between places.
    let vertices = first.control_vertices().len();
    match domain.len() {
        1 => line::sampled(&Sampler::new(states, domain, fineness, vertices.clamp(8, 512))?),
        2 => {
            let start = ((vertices as f64).sqrt().ceil() as usize).clamp(4, 64);
            net::sampled(&Sampler::new(states, domain, fineness, start)?)
        }
        count => Err(Error::Invalid(format!("the shape has {count} parameters: 1 or 2 can be tessellated"))),
    }
}

/// The states, and what is asked of their pieces.
struct Sampler<'s> {
    states: &'s [&'s dyn Shape],
    domain: Domain,
    /// Pieces of each direction to begin with.
    start: usize,
    /// The chord of each state, as a length.
    chords: Vec<f64>,
    /// The largest of these.
    tolerance: f64,
    angle: f64,
}

impl<'s> Sampler<'s> {
    fn new(states: &'s [&'s dyn Shape], domain: Domain, fineness: &Fineness, start: usize) -> Result<Self> {
        let mut sampler =
            Self { states, domain, start, chords: Vec::new(), tolerance: 0.0, angle: fineness.angle };
        let sizes: Vec<f64> = (0..states.len()).map(|state| sampler.size(state)).collect::<Result<_>>()?;
        let largest = sizes.iter().copied().fold(0.0, f64::max);
        if largest <= 0.0 {
            return Err(Error::NoExtent("all of the shape is one point".into()));
        }
        let chord = |size: &f64| match fineness.chord {
            Chord::Absolute(length) => length,
            Chord::Relative(fraction) => fraction * size.max(largest * 1e-3),
        };
        sampler.chords = sizes.iter().map(chord).collect();
        sampler.tolerance = sampler.chords.iter().copied().fold(0.0, f64::max);
        Ok(sampler)
    }

    /// The parameter at a fraction of a direction.
    fn parameter(&self, direction: usize, fraction: f64) -> f64 {
        let interval = &self.domain[direction];
        // The ends to the last bit: beyond them there is nothing.
        if fraction >= 1.0 {
            return interval.end;
        }
        (interval.start + (interval.end - interval.start) * fraction).clamp(interval.start, interval.end)
    }

    fn on_line(&self, state: usize, u: f64) -> Result<Point> {
        self.at(state, Location::Curve(self.parameter(0, u)))
    }

    fn on_net(&self, state: usize, u: f64, v: f64) -> Result<Point> {
        self.at(state, Location::Surface(self.parameter(0, u), self.parameter(1, v)))
    }

    fn at(&self, state: usize, at: Location) -> Result<Point> {
        let value = Point::from(self.states[state].value(at, Derivative::POSITION)?);
        if value.iter().all(|c| c.is_finite()) {
            return Ok(value);
        }
        Err(Error::Invalid(format!("the shape has no finite value at {at}")))
    }

    /// The diagonal of the box around places all over a state.
    fn size(&self, state: usize) -> Result<f64> {
        let count = 4 * self.start;
        let (mut low, mut high) = (Point::from([f64::INFINITY; 3]), Point::from([f64::NEG_INFINITY; 3]));
        for i in 0..=count {
            let u = i as f64 / count as f64;
            for j in 0..=if self.domain.len() == 2 { count } else { 0 } {
                let v = j as f64 / count as f64;
                let p =
                    if self.domain.len() == 2 { self.on_net(state, u, v)? } else { self.on_line(state, u)? };
                (low, high) = (low.inf(&p), high.sup(&p));
            }
        }
        let d = high - low;
        Ok(d.x.hypot(d.y).hypot(d.z))
    }

    /// Whether the chain through three points turns by more than a piece may: half of what neighbours may differ by.
    fn turns(&self, a: &Point, b: &Point, c: &Point) -> bool {
        let (p, q) = (b - a, c - b);
        let (p, q) = (p.try_normalize(0.0), q.try_normalize(0.0));
        p.zip(q).is_some_and(|(p, q)| p.cross(&q).norm().atan2(p.dot(&q)) > 0.5 * self.angle)
    }

    fn too_many(&self) -> Error {
        Error::Invalid(format!(
            "more than {MOST} points would be needed to come within {} of the shape: \
             ask for a larger tolerance or angle",
            short(self.tolerance)
        ))
    }

    fn gap(&self, direction: usize, fraction: f64) -> Error {
        let (letter, at) = (["u", "v"][direction.min(1)], self.parameter(direction, fraction));
        Error::Invalid(format!(
            "the shape has a gap near {letter} = {at}: it cannot be tessellated in one piece"
        ))
    }
}

/// Whether nearly all of a piece that is longer than the chord lies between two neighbouring quarters, as it does
/// where the shape has a gap, however often it is halved.
fn leaps(points: &[Point; 5], chord: f64) -> bool {
    let whole = (points[4] - points[0]).norm();
    whole > chord && points.windows(2).any(|pair| (pair[1] - pair[0]).norm() > 0.95 * whole)
}
