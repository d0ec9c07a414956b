//! Offsets of planar curves: what lies at a distance from a curve, on one side of it.
//!
//! Every polynomial piece is moved along its normal, corners are joined, and of all that is kept what is no nearer to the
//! curve than the distance: asked of the curve's certified closest points, place after place. What is kept meets where the moved pieces
//! cross, so that loops are cut away and a curve that is moved far inwards falls into several.

mod around;
mod chain;
mod element;
mod keep;
mod measure;
mod operation;
mod plane;
mod straight;
mod tip;

use loftsman_kernel::Vector;
use loftsman_kernel::error::{Error, Figure, Result};
use loftsman_kernel::scene::Unit;
use loftsman_kernel::spline::Curve;

use element::{Element, Elements, elements};
pub use operation::OffsetOf;

/// What happens where the curve has a corner, on the side where its offset falls apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Corners {
    /// An arc about the corner: all of it is as far from the curve as asked for.
    #[default]
    Round,
    /// Both sides are prolonged until they meet, as long as that is no further than four distances from the corner; round else. What they enclose with the corner
    /// counts as nearer than the distance: no other part goes through it, and it ends where it would come to the other side of the curve.
    Sharp,
    /// Nothing: the offset ends there, and begins again.
    Open,
}

/// How an offset is made.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct OffsetOptions {
    /// How far the offset may be from where it should be: a length; `None`: 1e-6 of the curve's size.
    pub tolerance: Option<f64>,
    /// What becomes of corners.
    pub corners: Corners,
    /// Across the plane; needed for straight lines, which lie in many. Of any length.
    pub normal: Option<Vector>,
    /// What messages count lengths in; bare numbers where that is `None`.
    pub unit: Option<Unit>,
}

impl OffsetOptions {
    /// A length as messages tell it: as it was given.
    fn given(&self, length: f64) -> String {
        self.unit.map_or_else(
            || Figure(length).to_string(),
            |unit| format!("{} {}", Figure(length), unit.symbol()),
        )
    }

    /// The same of a length that is found, in about six figures.
    fn found(&self, length: f64) -> String {
        let figure = crate::fields::figure(length);
        self.unit.map_or_else(|| figure.clone(), |unit| format!("{figure} {}", unit.symbol()))
    }
}

/// The offset of a curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Offset {
    /// Its pieces, in the order in which the curve passes them; those that end where they start are closed to the last bit.
    pub curves: Vec<Curve>,
    /// The largest deviation that was measured: of places of the offset from the distance asked for (the tips of sharp corners left out),
    /// and of places that it should pass from it.
    pub deviation: f64,
    /// The tolerance that was used.
    pub tolerance: f64,
    /// How often parts nearer to the curve than the distance were cut away.
    pub cut: usize,
    /// Corners too sharp for a tip, which are round.
    pub blunted: usize,
    /// Whether parts are left out between sides that are twice the distance apart: both run along the middle there, with nothing between them.
    pub strips: bool,
}

/// The offset of a planar curve at a signed distance: outwards of a closed curve where positive, else to the right of its
/// way as seen from the tip of the normal (without one given: the tip whose largest component is positive).
///
/// Lines, arcs of circles and the joins between pieces come out exact; all else are cubics through places of the offset and
/// along its derivatives, with the curve's own parameters, halved until they are near enough. A straight curve that turns back has lines and half circles, too, on
/// each side along all that its passes in one direction cover, evenly passed. Then the deviation is measured afresh,
/// both ways, on the curves that are handed out.
///
/// A part is kept where no place of the curve is nearer than the distance and no tip of another sharp corner goes over it, to 2e-9 of it and 1e-11 of the size. Between the places
/// where that is asked the rest of the curve is too far away to be nearer by more than the tolerance. Where two sides are twice the distance apart, to some 1e-8 of it, the
/// strip of no width between their offsets is left out, so that none runs over itself. `O(n k)` closest points for `n` pieces and `k` places.
///
/// ```
/// use loftsman_construction::{OffsetOptions, offset};
/// use loftsman_kernel::{Point, Vector, spline::Curve};
/// let ring = Curve::circle(Point::origin(), Vector::z(), 2.0)?;
/// let wider = offset(&ring, 0.5, &OffsetOptions::default())?;
/// assert!((wider.curves[0].length(1e-12)?.value - 5.0 * std::f64::consts::PI).abs() < 1e-10);
/// # Ok::<(), loftsman_kernel::Error>(())
/// ```
///
/// # Errors
/// When the distance is 0 or the tolerance no length, or either less than 1e-10 of the size of curve and distance; the curve is a point, leaves its plane by more than 1e-9 of its size and a tenth of the tolerance (by less it is put there first, and the deviation counts that), or is straight
/// and no normal is given; it stops on its way; more than some seconds' work is needed to follow it; or nothing is left at that distance (the message says up to where something is).
pub fn offset(curve: &Curve, distance: f64, options: &OffsetOptions) -> Result<Offset> {
    if !distance.is_finite() || distance == 0.0 {
        let problem = "give a distance that is not 0, positive outwards or to the right";
        return Err(Error::Invalid(format!("{} is no distance to move by: {problem}", Figure(distance))));
    }
    let allowance = |size: f64| FLATTENED * options.tolerance.unwrap_or(1e-6 * size);
    let plane = plane::Plane::of(curve, options, &allowance)?;
    let tolerance = options.tolerance.unwrap_or(1e-6 * plane.size);
    if !(tolerance > 0.0 && tolerance.is_finite()) {
        return Err(Error::Invalid(format!("{} is no tolerance: give a length above 0", Figure(tolerance))));
    }
    let size = plane.size + distance.abs();
    if !(size < 1e150 && size > 1e-150) {
        return Err(Error::Invalid(
            "the curve and the distance are too large or too small for their squares to be numbers: scale them"
                .into(),
        ));
    }
    if distance.abs() < FINEST * size {
        return Err(Error::Invalid(format!(
            "a distance of {} is less than the parts of an offset are found to, which is {} here: take the curve itself, or a larger distance",
            options.given(distance.abs()),
            options.found(FINEST * size)
        )));
    }
    if tolerance < FINEST * size {
        return Err(Error::Invalid(format!(
            "a tolerance of {} is finer than the parts of an offset are found, which is to {} here: give that or more",
            options.found(tolerance),
            options.found(FINEST * size)
        )));
    }
    if let Some((flat, leaves)) = plane.flattened(curve)? {
        let options = OffsetOptions { tolerance: Some(tolerance - leaves), ..*options };
        let found = offset(&flat, distance, &options)?;
        return Ok(Offset { deviation: found.deviation + leaves, tolerance, ..found });
    }
    if let Some(found) = narrow(curve, &plane, distance, tolerance, options)? {
        return Ok(found);
    }
    let around = around::Around::new(curve, 1e-14 * size)?;
    let job = Job { curve, around: &around, plane: &plane, distance, tolerance, size, options };
    if let Some(found) = straight::folded(&job)? {
        return if found.deviation <= tolerance { Ok(found) } else { Err(misses(&job, found.deviation)) };
    }
    let (Elements { all: elements, blunted, .. }, tips) = elements(&job)?;
    let mut missed = Missed::Nothing;
    let mut looked = 0;
    let mut strips = false;
    for round in 0..ROUNDS {
        let kept = keep::kept(&job, &elements, &tips, round, &mut looked)?;
        let cut = kept.cut;
        strips |= kept.strips;
        let chains = if kept.intervals.is_empty() {
            Vec::new()
        } else {
            chain::chains(&job, &elements, kept.intervals, round)?
        };
        // What is left may be too short to be seen by wider steps.
        if chains.is_empty() {
            // Where circles of nearly the distance have some of the curve inside, steps are not what is too wide.
            if round == 0 && keep::reach(&job, &elements)? < FAR * distance.abs() {
                break;
            }
            if kept.strips && round > 0 {
                missed = Missed::Strip;
                break;
            }
            continue;
        }
        if !measure::complete(&job, &elements, &tips, &chains)? {
            missed = Missed::Parts;
            continue;
        }
        let deviation = measure::deviation(&job, &elements, &chains)?;
        if deviation <= tolerance {
            let curves = chains.into_iter().map(|c| c.curve).collect();
            return Ok(Offset { curves, deviation, tolerance, cut, blunted, strips });
        }
        missed = Missed::Place(deviation);
    }
    Err(Error::Invalid(match missed {
        Missed::Nothing => format!(
            "nothing of the curve is {} away on that side: what is longer than the tolerance of {} ends at a distance of about {}",
            options.given(distance.abs()),
            options.found(tolerance),
            options.found(ends(&job, &elements)?)
        ),
        Missed::Strip => format!(
            "nothing of the curve is {} away on that side but a strip of no width, along which opposite places of the curve are twice as far apart: give a smaller distance",
            options.given(distance.abs())
        ),
        Missed::Parts => format!(
            "what is left at {} is in parts too short to be followed: give a smaller tolerance, or another distance",
            options.given(distance)
        ),
        Missed::Place(by) => return Err(misses(&job, by)),
    }))
}

/// The offset of an open curve that turns back on a line, but for a part of the tolerance: that of the curve on the line, which has a closed form. Its passes are so near to one another
/// that which of them lies further out is less than what may be missed.
fn narrow(
    curve: &Curve,
    plane: &plane::Plane,
    distance: f64,
    tolerance: f64,
    options: &OffsetOptions,
) -> Result<Option<Offset>> {
    // What closes has an inside, however narrow that is.
    let flat = if plane.closed { None } else { plane.straightened(curve)? };
    let Some((flat, leaves)) = flat.filter(|(_, leaves)| *leaves <= NARROW * tolerance) else {
        return Ok(None);
    };
    let options =
        OffsetOptions { tolerance: Some(tolerance - leaves), normal: Some(plane.normal), ..*options };
    let plane = plane::Plane::of(&flat, &options, &|_| 0.0)?;
    let size = plane.size + distance.abs();
    let around = around::Around::new(&flat, 1e-14 * size)?;
    let own = tolerance - leaves;
    let job = Job {
        curve: &flat,
        around: &around,
        plane: &plane,
        distance,
        tolerance: own,
        size,
        options: &options,
    };
    let found = straight::folded(&job)?.filter(|found| found.deviation <= own);
    Ok(found.map(|found| Offset { deviation: found.deviation + leaves, tolerance, ..found }))
}

fn misses(job: &Job<'_>, by: f64) -> Error {
    Error::Invalid(format!(
        "the offset at {} misses its place by {} where {} is allowed: give a larger tolerance, or split the curve",
        job.options.given(job.distance),
        job.options.found(by),
        job.options.found(job.tolerance)
    ))
}

/// Up to which distance something longer than the tolerance is left, where nothing is at the one asked for. Circles that touch the curve say that unless tips of sharp
/// corners go over what they leave: then it is found by halving, to a millionth.
fn ends(job: &Job<'_>, all: &[Element]) -> Result<f64> {
    let reach = keep::reach(job, all)?;
    if job.options.corners != Corners::Sharp {
        return Ok(reach);
    }
    let mut looked = 0;
    let mut is_left = |away: f64| -> Result<bool> {
        let nearer = Job { distance: away.copysign(job.distance), ..*job };
        let (Elements { all, .. }, tips) = elements(&nearer)?;
        let kept = keep::kept(&nearer, &all, &tips, 0, &mut looked)?;
        Ok(!kept.intervals.is_empty() && !chain::chains(&nearer, &all, kept.intervals, 0)?.is_empty())
    };
    let (mut low, mut high) = (0.0, reach);
    for _ in 0..ENDS {
        let middle = 0.5 * low + 0.5 * high;
        match is_left(middle) {
            Ok(true) => low = middle,
            Ok(false) => high = middle,
            // What takes too much work is not found any nearer.
            Err(_) => break,
        }
    }
    Ok(high)
}

/// A curve that leaves its plane by no more than this part of the tolerance is put into it.
const FLATTENED: f64 = 0.1;
/// A curve that turns back is put on a line that it leaves by no more than this part of the tolerance.
const NARROW: f64 = 0.5;
/// Nothing is left at a distance of which the largest circle that touches the curve from there is so much smaller.
const FAR: f64 = 0.99;
/// The least tolerance, as a part of the size: the parts that are kept are found to a hundredth of it.
const FINEST: f64 = 1e-10;
/// So many places are looked at on the ways along a curve of degree 0, divided by `(p + 1)²` for one of degree `p`, of which each costs as much more:
/// some seconds.
const PLACES: f64 = 2e7;
/// So many an element in any case.
const AN_ELEMENT: usize = 256;
/// So many nearest places of its pieces are asked for, divided alike: where passes of the curve lie beside one another each place asks all of them.
const NEAREST: f64 = 8e6;
/// So many an element in any case.
const NEAREST_AN_ELEMENT: usize = 2048;
/// So often are the steps along the curve made shorter, four times each.
const ROUNDS: u32 = 5;
/// Halvings of the distance at which nothing is left any more.
const ENDS: usize = 20;

/// Why an offset is not handed out.
enum Missed {
    /// Nothing was found.
    Nothing,
    /// Only strips of no width were found.
    Strip,
    /// It ends where it should go on.
    Parts,
    /// It is so far from where it should be.
    Place(f64),
}

/// What is to be done, checked.
#[derive(Clone, Copy)]
struct Job<'a> {
    curve: &'a Curve,
    around: &'a around::Around,
    plane: &'a plane::Plane,
    distance: f64,
    tolerance: f64,
    /// Of the curve and the distance together.
    size: f64,
    options: &'a OffsetOptions,
}

impl Job<'_> {
    /// What the distance to the curve may lack by rounding.
    fn slack(&self) -> f64 {
        2e-9 * self.distance.abs() + 1e-11 * self.size
    }

    /// What comes nearer than the distance by the tolerance does so over this length.
    fn blind(&self) -> f64 {
        2.0 * (2.0 * self.distance.abs() * self.tolerance.min(self.distance.abs())).sqrt()
    }

    /// How many places are looked at on the way along so many elements, at most.
    fn places(&self, elements: usize) -> usize {
        let order = self.curve.degree() as f64 + 1.0;
        ((PLACES / (order * order)) as usize).max(AN_ELEMENT.saturating_mul(elements))
    }

    /// How many nearest places of pieces are asked for along so many elements, at most.
    fn searches(&self, elements: usize) -> usize {
        let order = self.curve.degree() as f64 + 1.0;
        ((NEAREST / (order * order)) as usize).max(NEAREST_AN_ELEMENT.saturating_mul(elements))
    }

    /// How far pieces may be apart where they are put together.
    fn snap(&self) -> f64 {
        0.1 * self.tolerance
    }
}
