//! Sweeps: the surface that a curve goes through when moved along another one.
//!
//! With frames that turn with the path, `S(u, v) = C(u) + A(u) (P(v) - C(a))`, where `A` turns the frame at the path's start into that
//! at `u`. Each control vertex of the profile goes along a curve `X_j(u)`; cubics with its places and derivatives follow it, all with the same
//! knots. Between knots the surface is off by no more than the worst of these curves is, since its points are their convex combinations.

mod frames;
mod operation;

use loftsman_kernel::error::{Error, Figure, Result};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};

use frames::{Frame, Walk};
pub use operation::Sweep;

/// Derivatives that differ by more than this part of them have their knot three times.
const SMOOTH: f64 = 1e-9;

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

/// A sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct Swept {
    /// The surface: along `u` the path, along `v` the profile in its own space.
    pub surface: Surface,
    /// The largest distance from the sweep that was measured between the knots, with frames carried along anew; 0 of a parallel one, which is exact.
    pub deviation: f64,
    /// The tolerance that was used.
    pub tolerance: f64,
    /// How far the frames of a closed path were turned about it, all in all, so that the last meets the first: radians.
    pub twist: f64,
    /// Where the surface folds back, since the profile reaches beyond the path's centre of curvature: a parameter of the path.
    pub folds: Option<f64>,
}

/// The surface that a profile goes through when moved along a path, from where it is: `S(a, v) = P(v)` at the path's start `a`.
/// `tolerance` is the largest deviation, a length; `None`: 1e-6 of the size of both.
///
/// At a corner between straight pieces of the path the surface is mitred: both sides go on, or stop earlier, until they meet in the plane between them. A
/// closed path is mitred where it starts, too; the profile is then cut there, and not where it is.
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
/// When the tolerance is no length; or, but for a parallel sweep, the path has a corner that is not straight on both sides, or that folds, stops, or runs along
/// the upright direction.
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
    if turning == Turning::Parallel {
        let surface = parallel(profile, path)?;
        return Ok(Swept { surface, deviation: 0.0, tolerance, twist: 0.0, folds: None });
    }
    if !(size < 1e150 && size > 1e-150) {
        return Err(Error::Invalid(
            "the curves are too large or too small for their squares to be numbers: scale them".into(),
        ));
    }
    let walk = Walk::new(path, turning, size)?;
    let mut last = 0.0;
    for fit in [0.5, 0.1, 0.02] {
        let surface = moved(profile, path, &walk, fit * tolerance)?;
        let (deviation, folds) = measured(&surface, profile, &walk)?;
        if deviation <= tolerance {
            return Ok(Swept { surface, deviation, tolerance, twist: walk.twist(), folds });
        }
        last = deviation;
    }
    Err(Error::Invalid(format!(
        "the sweep misses its place by {} where {} is allowed: give a larger tolerance",
        crate::fields::figure(last),
        Figure(tolerance)
    )))
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

/// Where a vertex is when the frame is there, and its derivative.
fn carried(walk: &Walk<'_>, frame: &Frame, arm: &Vector) -> (Point, Vector) {
    let (ahead, faster) = walk.ahead(frame, arm);
    let point = frame.point + frame.turn * arm + frame.tangent * ahead;
    (point, frame.speed + frame.turning * arm + frame.tangent * faster)
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
            // Between corners that are too near to one another, or too sharp, what is on their inner side would run back.
            let ahead = walk.ahead(begin, arm).1;
            if ahead != 0.0 && begin.speed.norm() + ahead <= 0.0 {
                return Err(Error::Invalid(format!(
                    "between the corners around {} of the path the profile reaches too far to their inner side, so that the surface would fold: make \
                     the path longer there, the corners blunter, or the profile smaller",
                    Figure(0.5 * (begin.at + end.at))
                )));
            }
            let ((p, dp), (q, dq)) = (carried(walk, begin, arm), carried(walk, end, arm));
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
                if (carried(walk, frame, arm).0.coords - there).norm() > tolerance {
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
                let apart = |arm: &Vector| (carried(walk, before, arm).0 - carried(walk, begin, arm).0).norm();
                let reach = arms.iter().map(|arm| arm.norm()).fold(0.0, f64::max);
                if walk.is_mitred() && arms.iter().any(|arm| apart(arm) > CORNERED * (reach + begin.point.coords.norm())) {
                    return Err(Error::Invalid(format!(
                        "the path has a corner at {} that leaves the plane across the upright direction, where both sides of the surface would \
                         not meet: take frame = \"least\", or another direction",
                        Figure(begin.at)
                    )));
                }
                knots.extend([begin.at; 2]);
                let smooth = arms.iter().all(|arm| {
                    let (a, b) = (carried(walk, before, arm).1, carried(walk, begin, arm).1);
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
    rows.push(arms.iter().map(|arm| carried(walk, &end, arm).0).collect());
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

/// The largest distance between the surface and the sweep at places between the knots, and where it folds back.
fn measured(surface: &Surface, profile: &Curve, walk: &Walk<'_>) -> Result<(f64, Option<f64>)> {
    let start = walk.start();
    let mut places = Vec::new();
    for span in profile.space().breakpoints().windows(2) {
        for k in 0..=4 {
            let v = if k == 4 { span[1] } else { span[0] + (span[1] - span[0]) * f64::from(k) / 4.0 };
            places.push((v, profile.point(v)? - start));
        }
    }
    let breaks = surface.u().breakpoints();
    let (mut largest, mut folds) = (0.0_f64, None);
    let mut at = Vec::new();
    for span in breaks.windows(2) {
        at.extend([0.15, 0.4, 0.65, 0.9].map(|x| span[0] + (span[1] - span[0]) * x));
    }
    for frame in walk.frames_at(&at)? {
        for (v, arm) in &places {
            let (point, speed) = carried(walk, &frame, arm);
            largest = largest.max((surface.point(frame.at, *v)? - point).norm());
            if speed.dot(&frame.tangent) < 0.0 && folds.is_none() {
                folds = Some(frame.at);
            }
        }
    }
    Ok((largest, folds))
}
