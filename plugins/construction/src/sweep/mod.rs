//! Sweeps: the surface that a curve goes through when moved along another one.
//!
//! With frames that turn with the path, `S(u, v) = C(u) + A(u) (P(v) - C(a))`, where `A` turns the frame at the path's start into that
//! at `u`. Each control vertex of the profile goes along a curve `X_j(u)`; cubics with its places and derivatives follow it, all with the same
//! knots. Between knots the surface is off by no more than the worst of these curves is, since its points are their convex combinations.

mod frames;
mod operation;

use loftsman_kernel::error::{Error, Figure, Result};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::text;
use loftsman_kernel::{Point, Vector};

use crate::sense::signed_area;
use frames::{Frame, Walk};
pub use operation::Sweep;

/// Derivatives that differ by more than this part of them have their knot three times.
const SMOOTH: f64 = 1e-9;

/// A closed profile that goes round less than this part of its size squared has no side that is outwards.
const FLAT: f64 = 1e-9;

/// Places on both sides of a corner that are one differ by rounding, of their size.
const CORNERED: f64 = 1e-9;

/// How the profile turns on its way.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Turning {
    /// With the path's tangent, and about it as little as can be (rotation-minimising). Round a closed path what is missing at the end is
    /// spread evenly over its length.
    #[default]
    Least,
    /// With the path's tangent; and so that what is across the path and this direction stays so.
    Upright(Vector),
    /// Not at all: it is only moved.
    Parallel,
}

/// How far a mitre reaches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mitre {
    /// The parameter of the corner on the path.
    pub at: f64,
    /// By how much the path turns there: radians.
    pub turn: f64,
    /// How far from the corner it reaches.
    pub reach: f64,
    /// How far from the path the profile reaches where it is not mitred.
    pub profile: f64,
}

/// A mitre that reaches beyond so many times its profile is a spike: that of a centred profile does where the path turns by more than 120 degrees.
const SPIKE: f64 = 2.0;
/// So much of that is rounding.
const AS_FAR: f64 = 1e-9;

/// A sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct Swept {
    /// The surface: along `u` the path, along `v` the profile in its own space, or backwards.
    pub surface: Surface,
    /// Whether the profile is run through from its end to its start, so that the surface's normal points outwards.
    pub reversed: bool,
    /// Whether the profile is closed and goes round no area about the path's direction where that starts: it lies along the path, and the surface is a
    /// flat sheet, laid double.
    pub flat: bool,
    /// The largest distance from the sweep that was measured between the knots, with frames carried along anew; 0 of a parallel one, which is exact.
    pub deviation: f64,
    /// The tolerance that was used.
    pub tolerance: f64,
    /// How far the frames of a closed path were turned about it, all in all, so that the last meets the first: radians.
    pub twist: f64,
    /// At how many corners of the path the surface is mitred.
    pub corners: usize,
    /// The mitre that reaches furthest; none without corners.
    pub mitre: Option<Mitre>,
    /// The mitres that reach beyond twice as far as the profile, furthest first.
    pub spikes: Vec<Mitre>,
    /// By how much the plane of a closed profile, across the area that it goes round, leans off the one across the path where that starts: radians, at most a
    /// right angle; none of an open one.
    pub off: Option<f64>,
    /// Beside corners where the path is not straight sections lean: how far that takes the surface from the sweep of sections that do not, at most,
    /// measured; 0 where there are none.
    pub leaned: f64,
    /// Where the surface folds back, since the profile reaches beyond the path's centre of curvature: a parameter of the path.
    pub folds: Option<f64>,
}

/// The surface that a profile goes through when moved along a path, from where it is: `S(a, v) = P(v)` at the path's start `a`.
/// `tolerance` is the largest deviation, a length; `None`: 1e-6 of the size of both.
///
/// A closed profile gives a surface whose normal points outwards, whatever way the profile runs: where it runs counterclockwise about the path's direction
/// at its start it is taken backwards, `S(a, v) = P(b - v)`. An open profile keeps its way, and the normal is the path's direction times the profile's.
///
/// At a corner of the path the surface is mitred: both sides end in the plane halfway between them. Beside the corner each place of the profile is moved
/// along the path's tangent, so far that at the corner it lies in that plane, and evenly less away from it: over one straight piece, where that is long
/// enough, or twice as far as the profile is moved, but not beyond the next corner. A straight side is thereby prolonged or cut off
/// exactly; on a bent one sections lean, and [`Swept::leaned`] says how far they are then from the sweep. A closed path is mitred where it starts, too; the
/// profile is then cut there, and not where it is.
///
/// Along `u` the path's parameter, along `v` the profile's. Parallel sweeps are exact, of degree `p × q`:
/// `S_ij = C_i + P_j - C(a)` with weights `w_i ω_j`. All else are cubic along `u` and exact along `v` at the knots.
///
/// ```
/// use loftsman_construction::{Turning, sweep};
/// use loftsman_kernel::{Point, Vector, spline::Curve};
/// let path = Curve::circle(Point::origin(), Vector::z(), 3.0)?;
/// let ring = Curve::circle(Point::new(3.0, 0.0, 0.0), Vector::y(), 1.0)?;
/// let torus = sweep(&ring, &path, Turning::Least, Some(1e-7))?;
/// let p = torus.surface.point(1.0, 2.0)?;
/// assert!(((p.x.hypot(p.y) - 3.0).hypot(p.z) - 1.0).abs() < 1e-7);
/// # Ok::<(), loftsman_kernel::Error>(())
/// ```
///
/// # Errors
/// When the tolerance is no length; or, but for a parallel sweep, the path turns straight back, has corners too near to one another for the profile, stops,
/// or runs along the upright direction.
pub fn sweep(profile: &Curve, path: &Curve, turning: Turning, tolerance: Option<f64>) -> Result<Swept> {
    let size = [profile, path]
        .iter()
        .flat_map(|c| c.points())
        .map(|p| (p - path.points()[0]).amax())
        .fold(0.0, f64::max);
    let tolerance = tolerance.unwrap_or(1e-6 * size);
    if !(tolerance > 0.0 && tolerance.is_finite()) {
        return Err(Error::Invalid(format!("{} is no tolerance: give a length above 0", Figure(tolerance))));
    }
    if turning != Turning::Parallel && !(size < 1e150 && size > 1e-150) {
        return Err(Error::Invalid(
            "the curves are too large or too small for their squares to be numbers: scale them".into(),
        ));
    }
    let round = goes_round(profile, path)?;
    let off = round.map(|round| round.off);
    let (reversed, flat) = (round.is_some_and(|r| r.way == 1.0), round.is_some_and(|r| r.way == 0.0));
    let backwards;
    let profile = if reversed {
        backwards = profile.reverse()?;
        &backwards
    } else {
        profile
    };
    if turning == Turning::Parallel {
        let surface = parallel(profile, path)?;
        return Ok(Swept {
            surface,
            reversed,
            flat,
            deviation: 0.0,
            tolerance,
            twist: 0.0,
            corners: 0,
            mitre: None,
            spikes: Vec::new(),
            off,
            leaned: 0.0,
            folds: None,
        });
    }
    let walk = Walk::new(path, profile, turning, size)?;
    let mut last = 0.0;
    for fit in [0.5, 0.1, 0.02] {
        let surface = moved(profile, path, &walk, fit * tolerance)?;
        let places = places(profile, &walk)?;
        let (deviation, folds) = measured(&surface, &places, &walk)?;
        if deviation <= tolerance {
            let (twist, corners) = (walk.twist(), walk.corners());
            let arms: Vec<Vector> = places.iter().map(|(_, arm)| *arm).collect();
            let leaned = walk.leaned(&arms)?;
            let mut spikes = walk.mitres(&arms)?;
            let mitre = spikes.first().copied();
            spikes.retain(|mitre| mitre.reach > SPIKE * mitre.profile * (1.0 + AS_FAR));
            return Ok(Swept {
                surface,
                reversed,
                flat,
                deviation,
                tolerance,
                twist,
                corners,
                mitre,
                spikes,
                off,
                leaned,
                folds,
            });
        }
        last = deviation;
    }
    Err(Error::Invalid(format!(
        "the sweep misses its place by {} where {} is allowed: give a larger tolerance",
        crate::fields::figure(last),
        Figure(tolerance)
    )))
}

/// How a closed profile lies to the path's direction at its start.
#[derive(Clone, Copy)]
struct Round {
    /// Which way round it runs about that: 1 counterclockwise, -1 the other way, 0 where it lies along the path.
    way: f64,
    /// By how much its plane leans off the one across the path: radians.
    off: f64,
}

/// How a closed profile lies; nothing of an open one.
fn goes_round(profile: &Curve, path: &Curve) -> Result<Option<Round>> {
    let (a, b) = profile.domain();
    let middle = profile.points().iter().map(|p| p.coords / profile.points().len() as f64).sum::<Vector>();
    let size = profile.points().iter().map(|p| (p.coords - middle).amax()).fold(0.0, f64::max);
    if !(profile.is_periodic() || (profile.point(a)? - profile.point(b)?).amax() <= 1e-12 * size) {
        return Ok(None);
    }
    if !(size > 0.0 && size.is_finite()) {
        return Ok(None);
    }
    // The first leg that has a direction: a parallel sweep takes paths that stop.
    let segments = path.bezier_segments()?;
    let legs = segments.iter().flat_map(|s| s.points().windows(2).map(|w| w[1] - w[0]));
    let Some(along) = legs.map(|leg| leg / leg.amax()).find(|leg| leg.iter().all(|x| x.is_finite())) else {
        return Ok(None);
    };
    // At the size 1, at which squares are numbers.
    let points = profile.points().iter().map(|p| Point::from((p.coords - middle) / size)).collect();
    let unit = Curve::build(profile.space().clone(), points, profile.weights().map(<[f64]>::to_vec))?;
    let along = along.normalize();
    let twice = signed_area(&unit, &Point::origin(), &along)?;
    let axes = [Vector::x(), Vector::y(), Vector::z()];
    let mut area = Vector::zeros();
    for axis in axes {
        area += axis * signed_area(&unit, &Point::origin(), &axis)?;
    }
    let off = area.cross(&along).norm().atan2(area.dot(&along).abs());
    Ok(Some(Round { way: if twice.abs() <= FLAT { 0.0 } else { twice.signum() }, off }))
}

/// The exact sweep without turning.
fn parallel(profile: &Curve, path: &Curve) -> Result<Surface> {
    let start = path.point(path.domain().0)?;
    let moved = |p: &Point| profile.points().iter().map(|q| p + (q - start)).collect::<Vec<_>>();
    let points = path.points().iter().flat_map(moved).collect();
    let weight = |curve: &Curve, k: usize| curve.weights().map_or(1.0, |w| w[k]);
    let rational = profile.weights().is_some() || path.weights().is_some();
    let weights = rational.then(|| {
        (0..path.points().len())
            .flat_map(|i| (0..profile.points().len()).map(move |j| weight(path, i) * weight(profile, j)))
            .collect()
    });
    Surface::build(path.space().clone(), profile.space().clone(), points, weights)
}

/// All vertices of the profile followed by cubics within a tolerance.
fn moved(profile: &Curve, path: &Curve, walk: &Walk<'_>, tolerance: f64) -> Result<Surface> {
    let start = walk.start();
    let arms: Vec<Vector> = profile.points().iter().map(|p| p - start).collect();
    let mut rows: Vec<Vec<Point>> = Vec::new();
    let mut knots: Vec<f64> = Vec::new();
    let mut arrived: Option<Frame> = None;
    walk.each(false, |begin, end, inner| {
        let third = (end.at - begin.at) / 3.0;
        let mut cubic = [Vec::new(), Vec::new(), Vec::new(), Vec::new()];
        for arm in &arms {
            if [begin, end].into_iter().chain(inner).any(|frame| runs_back(walk, frame, arm)) {
                return Err(Error::Invalid(format!(
                    "beside the corners around {} of the path the profile reaches too far to their inner side, so that the surface would fold: make \
                     the path longer there, the corners blunter, or the profile smaller",
                    text::measured(0.5 * (begin.at + end.at))
                )));
            }
            let ((p, dp), (q, dq)) = (walk.carried(begin, arm), walk.carried(end, arm));
            for (row, point) in cubic.iter_mut().zip([p, p + dp * third, q - dq * third, q]) {
                row.push(point);
            }
        }
        for frame in inner {
            let x = (frame.at - begin.at) / (end.at - begin.at);
            let y = 1.0 - x;
            let factors = [y * y * y, 3.0 * y * y * x, 3.0 * y * x * x, x * x * x];
            for (j, arm) in arms.iter().enumerate() {
                let there: Vector = (0..4).map(|k| cubic[k][j].coords * factors[k]).sum();
                if (walk.carried(frame, arm).0.coords - there).norm() > tolerance {
                    return Ok(false);
                }
            }
        }
        match &arrived {
            None => {
                knots.extend([begin.at; 4]);
                rows.push(cubic[0].clone());
            }
            Some(before) => {
                // Both sides of a corner meet where the frame goes round it by the least turn.
                let apart = |arm: &Vector| (walk.carried(before, arm).0 - walk.carried(begin, arm).0).norm();
                let reach = arms.iter().map(|arm| arm.norm()).fold(0.0, f64::max);
                if walk.is_mitred() && arms.iter().any(|arm| apart(arm) > CORNERED * (reach + begin.point.coords.norm())) {
                    return Err(Error::Invalid(format!(
                        "the path has a corner at {} that leaves the plane across the upright direction, where both sides of the surface would \
                         not meet: take frame = \"least\", or another direction",
                        text::measured(begin.at)
                    )));
                }
                knots.extend([begin.at; 2]);
                let smooth = arms.iter().all(|arm| {
                    let (a, b) = (walk.carried(before, arm).1, walk.carried(begin, arm).1);
                    (a - b).norm() <= SMOOTH * (a.norm() + b.norm())
                });
                if !smooth {
                    knots.push(begin.at);
                    rows.push(cubic[0].clone());
                }
            }
        }
        let [_, second, third, _] = cubic;
        rows.extend([second, third]);
        arrived = Some(end.clone());
        Ok(true)
    })?;
    let Some(end) = arrived else {
        return Err(Error::NoExtent("the path is a point: there is no way to go".into()));
    };
    knots.extend([end.at; 4]);
    rows.push(arms.iter().map(|arm| walk.carried(&end, arm).0).collect());
    // What is where it was, to the last bit.
    if !walk.is_mitred_at_start() {
        rows[0] = profile.points().to_vec();
    }
    if walk.closed() {
        let last = rows.len() - 1;
        rows[last] = rows[0].clone();
    }
    let points: Vec<Point> = rows.concat();
    let count = points.len() / arms.len();
    let weights = profile.weights().map(|w| w.repeat(count));
    let surface = Surface::build(Space::open(3, knots)?, profile.space().clone(), points, weights)?;
    if walk.closed() && path.is_periodic() {
        return Ok(surface.to_periodic(loftsman_kernel::spline::Direction::U, 0.1 * tolerance)?.shape);
    }
    Ok(surface)
}

/// Whether a place of the profile runs back because of how it is moved beside corners: between such that are too near to one another, or too sharp, what is on
/// their inner side would.
fn runs_back(walk: &Walk<'_>, frame: &Frame, arm: &Vector) -> bool {
    let faster = walk.ahead(frame, arm).1;
    let along = (frame.speed + frame.turning * arm).dot(&frame.tangent);
    faster < 0.0 && along > 0.0 && along + faster <= 0.0
}

/// Each span of the profile is measured at so many places: where its deviation is between two of them it is larger by a few parts in a thousand.
const ACROSS: u32 = 8;

/// Places of a profile, along each of its spans, seen from the path's start.
fn places(profile: &Curve, walk: &Walk<'_>) -> Result<Vec<(f64, Vector)>> {
    let mut places = Vec::new();
    for span in profile.space().breakpoints().windows(2) {
        for k in 0..=ACROSS {
            let share = f64::from(k) / f64::from(ACROSS);
            let v = if k == ACROSS { span[1] } else { span[0] + (span[1] - span[0]) * share };
            places.push((v, profile.point(v)? - walk.start()));
        }
    }
    Ok(places)
}

/// The largest distance between the surface and the sweep at places between the knots, and where it folds back.
fn measured(surface: &Surface, places: &[(f64, Vector)], walk: &Walk<'_>) -> Result<(f64, Option<f64>)> {
    let breaks = surface.u().breakpoints();
    let (mut largest, mut folds) = (0.0_f64, None);
    let mut at = Vec::new();
    for span in breaks.windows(2) {
        // What a cubic with given places and derivatives at both ends misses between them grows like x² (1 - x)²: most in the middle.
        at.extend([0.15, 0.35, 0.5, 0.65, 0.85].map(|x| span[0] + (span[1] - span[0]) * x));
    }
    for frame in walk.frames_at(&at)? {
        for (v, arm) in places {
            let (point, speed) = walk.carried(&frame, arm);
            largest = largest.max((surface.point(frame.at, *v)? - point).norm());
            if speed.dot(&frame.tangent) < 0.0 && folds.is_none() {
                folds = Some(frame.at);
            }
        }
    }
    Ok((largest, folds))
}
