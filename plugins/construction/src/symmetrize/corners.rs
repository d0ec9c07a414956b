//! Corners and creases that a symmetric shape has where what it was made of has none.
//!
//! Only at a knot as often as the degree may a spline turn; its control vertices on both sides say how: `P_i - P_(i-1)` before and `P_(i+1) - P_i` after it,
//! whatever their weights. Of a surface these are curves, the rows of its net, and what turns is its normal.

use loftsman_kernel::error::Result;
use loftsman_kernel::spline::{Curve, Direction, Space, Surface};
use loftsman_kernel::{Point, Vector};

use super::{SAMPLES, long};

/// A smaller turn is none, in radians.
const SMOOTH: f64 = 1e-5;

/// A place where a shape turns that was smooth there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    /// Where it is; of a crease along a surface where it is sharpest.
    pub place: Point,
    /// By how much it turns there, in radians.
    pub angle: f64,
}

/// The corners of a clamped curve where another one in its space has none; where it begins, too, if it is closed.
pub(super) fn of_curve(space: &Space, points: &[Point], old: &[Point], closed: bool) -> Vec<Corner> {
    let p = space.degree();
    let at = |points: &[Point], k: usize| {
        turn(&points[k], points[..k].iter().rev().take(p), points[k + 1..].iter().take(p))
    };
    let seam = |points: &[Point]| match points {
        [first, inner @ .., _] => turn(first, inner.iter().rev().take(p), inner.iter().take(p)),
        _ => 0.0,
    };
    let start = closed.then(|| new(points[0], seam(points), seam(old))).flatten();
    let inner = joints(space).filter_map(|k| new(points[k], at(points, k), at(old, k)));
    start.into_iter().chain(inner).collect()
}

/// The corner, if any, where a clamped curve ends and another one begins; the original turns there by `was`.
pub(super) fn between(before: &Curve, after: &Curve, was: f64) -> Option<Corner> {
    new(*after.points().first()?, turn_between(before, after), was)
}

/// By how much a curve turns where it ends and another one begins.
pub(super) fn turn_between(before: &Curve, after: &Curve) -> f64 {
    after.points().split_first().map_or(0.0, |(middle, next)| {
        turn(
            middle,
            before.points().iter().rev().skip(1).take(before.degree()),
            next.iter().take(after.degree()),
        )
    })
}

/// The creases along the lines of a surface, clamped in a direction, where another one in its spaces has none; where it begins, too, if it is closed. Of each the sharpest place.
pub(super) fn of_surface(
    surface: &Surface,
    old: &Surface,
    direction: Direction,
    closed: bool,
) -> Result<Vec<Corner>> {
    let n = surface.space(direction).len();
    let seam = (closed && n > 2).then_some([n - 2, 0, 1]);
    let lines = seam.into_iter().chain(joints(surface.space(direction)).map(|k| [k - 1, k, k + 1]));
    let mut found = Vec::new();
    for line in lines {
        let [now, was] = [surface, old].map(|s| -> Result<_> {
            let [before, middle, after] = line.map(|k| row(s, direction, k));
            turns(&before?, &middle?, &after?)
        });
        found.extend(sharpest(&now?, &was?));
    }
    Ok(found)
}

/// The crease, if any, where a surface, clamped in a direction, ends and another one begins; `was` is how the original turns there, or nothing where it ended.
pub(super) fn along(
    before: &Surface,
    after: &Surface,
    direction: Direction,
    was: &[(Point, f64)],
) -> Result<Option<Corner>> {
    Ok(sharpest(&turns_along(before, after, direction)?, was))
}

/// How a surface turns where it ends and another one begins: places, and by how much.
pub(super) fn turns_along(
    before: &Surface,
    after: &Surface,
    direction: Direction,
) -> Result<Vec<(Point, f64)>> {
    let last = before.space(direction).len() - 2;
    turns(&row(before, direction, last)?, &row(after, direction, 0)?, &row(after, direction, 1)?)
}

fn new(place: Point, angle: f64, was: f64) -> Option<Corner> {
    (angle > SMOOTH && was <= SMOOTH).then_some(Corner { place, angle })
}

fn sharpest(now: &[(Point, f64)], was: &[(Point, f64)]) -> Option<Corner> {
    let was = was.iter().map(|(_, angle)| *angle).chain(std::iter::repeat(0.0));
    let found = now.iter().zip(was).filter_map(|((place, angle), was)| new(*place, *angle, was));
    found.max_by(|a, b| a.angle.total_cmp(&b.angle))
}

/// The inner vertices of a clamped space that are on the curve: those of knots as often as the degree.
fn joints(space: &Space) -> impl Iterator<Item = usize> + '_ {
    let (p, flat) = (space.degree(), space.flat());
    (p + 1..flat.len() - p - 1)
        .filter(move |&k| flat[k - 1] < flat[k] && flat[k] == flat[k + p - 1])
        .map(|k| k - 1)
}

/// By how much a curve turns at a vertex between those before and behind it, from near to far; 0 where either side is but a point.
fn turn<'a>(
    middle: &Point,
    before: impl Iterator<Item = &'a Point>,
    after: impl Iterator<Item = &'a Point>,
) -> f64 {
    match (away(middle, before), away(middle, after)) {
        (Some(from), Some(to)) => angle(&-from, &to),
        _ => 0.0,
    }
}

/// The direction to the first of some points that is not there to rounding.
fn away<'a>(from: &Point, mut points: impl Iterator<Item = &'a Point>) -> Option<Vector> {
    points.find_map(|point| way(from, point))
}

/// The direction between two points that rounding turns by less than what counts.
fn way(from: &Point, to: &Point) -> Option<Vector> {
    let way = to - from;
    let length = long(&way);
    let rounding = 8.0 * f64::EPSILON * (from.coords.amax() + to.coords.amax());
    (length * SMOOTH > rounding).then(|| way / length)
}

fn angle(a: &Vector, b: &Vector) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

/// A row of a surface's net as a curve: the line of a vertex of the direction.
fn row(surface: &Surface, direction: Direction, k: usize) -> Result<Curve> {
    let (columns, other) = (surface.v().len(), surface.space(direction.other()));
    let index = |j: usize| if direction == Direction::U { k * columns + j } else { j * columns + k };
    let points = (0..other.len()).map(|j| surface.points()[index(j)]).collect();
    let weights = surface.weights().map(|w| (0..other.len()).map(|j| w[index(j)]).collect());
    Curve::build(other.clone(), points, weights)
}

/// By how much the normal of a surface turns over a line of it, `middle`, which has rows of its net on both sides.
fn turns(before: &Curve, middle: &Curve, after: &Curve) -> Result<Vec<(Point, f64)>> {
    let mut found = Vec::new();
    let mut there = [Vector::zeros(); 2];
    for span in middle.space().breakpoints().windows(2) {
        for k in 0..=SAMPLES {
            let x = k as f64 / SAMPLES as f64;
            let at = (span[0] * (1.0 - x) + span[1] * x).clamp(span[0], span[1]);
            middle.derivatives_into(at, &mut there)?;
            let place = Point::from(there[0]);
            let size = long(&there[1]);
            let sides = way(&before.point(at)?, &place).zip(way(&place, &after.point(at)?));
            let angle = sides.filter(|_| size > 0.0).map_or(0.0, |(from, to)| {
                let tangent = there[1] / size;
                let (n, m) = (from.cross(&tangent), to.cross(&tangent));
                // Where the rows run along the line there is no normal.
                let flat = n.norm().min(m.norm()) < SMOOTH;
                if flat { 0.0 } else { angle(&n, &m) }
            });
            found.push((place, angle));
        }
    }
    Ok(found)
}
