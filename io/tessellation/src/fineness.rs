//! A fineness as two numbers, checked against what the shape's coordinates can resolve.

use loftsman_kernel::plugin::{Chord, Fineness};
use loftsman_kernel::text::{figure, short};
use loftsman_kernel::{Error, Point, Result};

/// A shape's own frame: control points are taken about `centre` and divided by `size`, so that no square of a
/// coordinate overflows or vanishes and 1 is the size of everything.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame {
    pub(crate) centre: Point,
    pub(crate) size: f64,
    /// The largest absolute coordinate: what rounding is relative to.
    largest: f64,
}

/// What a piece must meet, in the units of the shape's [`Frame`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Target {
    /// Chord tolerance.
    pub(crate) chord: f64,
    /// Angle, in radians.
    pub(crate) angle: f64,
    /// The unit, in the shape's own.
    pub(crate) size: f64,
}

impl Frame {
    /// The frame of a control net: the middle and the diagonal of its box.
    pub(crate) fn of(points: &[Point]) -> Result<Self> {
        let Some(&first) = points.first() else {
            return Err(Error::Invalid("a shape without control vertices cannot be tessellated".into()));
        };
        let (low, high) = points.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
        let size = diagonal(&low, &high);
        if !size.is_finite() {
            return Err(Error::Invalid("the shape is too large to be tessellated: scale it down".into()));
        }
        if size == 0.0 {
            return Err(Error::NoExtent(
                "all control vertices coincide: there is nothing to tessellate".into(),
            ));
        }
        let largest = low.coords.amax().max(high.coords.amax());
        Ok(Self { centre: low + (high - low) * 0.5, size, largest })
    }

    /// The frame in which coordinates are what they are.
    pub(crate) fn absolute() -> Self {
        Self { centre: Point::origin(), size: 1.0, largest: 0.0 }
    }

    /// The chord that a fineness asks of a shape, as a length; `samples` are points of the shape itself, whose box is never
    /// larger than the shape's own, so that a relative tolerance is never wider than promised.
    fn length(fineness: &Fineness, samples: impl IntoIterator<Item = Point>) -> Result<f64> {
        fineness.check()?;
        match fineness.chord {
            Chord::Absolute(length) => Ok(length),
            Chord::Relative(fraction) => {
                let (mut low, mut high) = (Point::from([f64::MAX; 3]), Point::from([f64::MIN; 3]));
                for p in samples {
                    (low, high) = (low.inf(&p), high.sup(&p));
                }
                Ok(fraction * diagonal(&low, &high))
            }
        }
    }

    /// A chord, as a length, and an angle in this frame.
    fn target(&self, length: f64, angle: f64) -> Result<Target> {
        // Below a few units in the last place of the coordinates a chord cannot be told from its curve.
        let resolved = 8.0 * f64::EPSILON * self.largest;
        if length < resolved {
            return Err(Error::Invalid(format!(
                "a chord tolerance of {length:e} is less than the coordinates resolve ({resolved:e}): choose a coarser one"
            )));
        }
        Ok(Target { chord: length / self.size, angle, size: self.size })
    }
}

/// Of the states of a moving shape the smallest are held to a relative chord as if they were this part of the largest: what
/// is smaller cannot be seen beside it.
const LEAST: f64 = 1e-3;

/// What a fineness asks of each state of a shape, of which some points are known, and the largest chord as a length.
pub(crate) fn targets<'s>(
    states: impl Iterator<Item = (&'s Frame, Vec<Point>)>,
    fineness: &Fineness,
) -> Result<(Vec<Target>, f64)> {
    let mut lengths = Vec::new();
    for (frame, samples) in states {
        lengths.push((frame, Frame::length(fineness, samples)?));
    }
    let largest = lengths.iter().map(|(_, length)| *length).fold(0.0, f64::max);
    let least = LEAST * largest;
    let targets = lengths.iter().map(|(frame, length)| frame.target(length.max(least), fineness.angle));
    Ok((targets.collect::<Result<_>>()?, largest))
}

/// The error for a tolerance that needs more than the budget of segments or triangles: `needed` of them, where that is
/// known beforehand; their number goes with the tolerance to the power of minus `power`.
pub(crate) fn over_budget(
    fineness: &Fineness,
    needed: Option<f64>,
    (what, power): (&str, f64),
    budget: usize,
) -> Error {
    let (tolerance, of) = match fineness.chord {
        Chord::Absolute(length) => (length, ""),
        Chord::Relative(fraction) => (fraction, " of the diagonal"),
    };
    let degrees = figure(fineness.angle.to_degrees());
    let asked = format!("a chord tolerance of {tolerance:e}{of} with an angle of {degrees} degrees needs");
    Error::Invalid(match needed {
        Some(needed) => {
            let enough = tolerance * (needed / budget as f64).powf(1.0 / power);
            format!(
                "{asked} about {needed} {what}, more than {budget}: choose a coarser one, {enough}{of} or more",
                needed = short(needed),
                enough = short(enough)
            )
        }
        None => format!(
            "{asked} more than {budget} {what}: choose a coarser tolerance or angle (a tolerance {:.0} times as coarse takes half as many)",
            2_f64.powf(1.0 / power)
        ),
    })
}

/// The distance between two corners, without overflow in between.
fn diagonal(low: &Point, high: &Point) -> f64 {
    let d = high - low;
    let largest = d.amax();
    if largest > 0.0 && largest.is_finite() { largest * (d / largest).norm() } else { largest }
}
