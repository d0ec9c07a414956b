//! How far a shape is from what it was.

mod cells;
mod furthest;
#[cfg(test)]
pub(super) mod tests;

use std::cell::Cell;

use loftsman_kernel::nalgebra::Matrix3;
use loftsman_kernel::scene::Geometry;
use loftsman_kernel::spline::part::Part;
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};

use cells::of_shapes;
use furthest::{furthest, suspects};

/// Places of a curve at which its distance from another is taken, about as many.
const ON_CURVES: usize = 256;
/// The same of a surface, in each direction.
const ON_SURFACES: usize = 12;
/// The most pieces of the other shape, all places together, that a search for closest points looks at.
const EFFORT: usize = 1_000_000;
/// The most that one search over a surface looks at, and how many when all together have looked at that many.
const SEARCH: usize = 200_000;
const FEW: usize = 256;
/// The part of a distance by which a place found may be further than the nearest, before it goes downhill from there.
const NEARLY: f64 = 1e-9;
/// The most places of a direction of a surface at which the ways of points of the same parameters are compared, which cost little; and of a curve.
const ON_WAYS: usize = 500;
const ON_WAYS_OF_CURVES: usize = 100_000;
/// The most faces of a Brep that have moved: of all of them it would take long.
const MOVED_FACES: usize = 32;
/// Places of each span of a border.
const ON_BORDERS: usize = 4;

/// The largest distance between places of the new shape and the old shape: for curves and surfaces from each to the nearest point of the other (of what has another
/// domain, as a part, from the new one only), from points to the nearest of a shape that was fitted to them, for points to the point of the same number. `None` where the two are of different kinds, or a search would take long.
pub(super) fn deviation(before: &Geometry, after: &Geometry) -> Option<f64> {
    match (before, after) {
        (Geometry::Curve(before), Geometry::Curve(after)) => {
            // One that is begun elsewhere is whole, too.
            let [old, new] = [before, after].map(|curve| curve.space().length());
            let whole = (old - new).abs() <= 1e-12 * old;
            both(before, after, whole, of_curves)
        }
        (Geometry::Surface(before), Geometry::Surface(after)) => {
            let domains = [before, after].map(|surface| [surface.u().domain(), surface.v().domain()]);
            both(before, after, domains[0] == domains[1], of_surfaces)
        }
        (Geometry::Trimmed(before), Geometry::Trimmed(after)) => {
            let [before, after] = [before.part().ok()?, after.part().ok()?];
            both(&before, &after, true, of_parts)
        }
        // Face by face: the place on another face that is nearer, if there is one, is not looked for. How far one is that was moved, turned or scaled as a whole the
        // step says, and finding it out would take long: each place is far from where all were.
        (Geometry::Brep(before), Geometry::Brep(after)) => {
            let count = after.face_count();
            let moved = |face: &usize| before.surface(*face) != after.surface(*face);
            let of_face =
                |face: usize| both(&before.part(face).ok()?, &after.part(face).ok()?, true, of_parts);
            if before.face_count() != count {
                return None;
            }
            let faces: Vec<usize> = (0..count).filter(moved).collect();
            if !faces.is_empty() && is_similar(before.points(), after.points()) {
                return None;
            }
            (faces.len() <= MOVED_FACES).then(|| largest(faces.into_iter().map(of_face)))?
        }
        (Geometry::Custom(before), Geometry::Custom(after)) => {
            of_shapes(before.shape().ok()?, after.shape().ok()?)
        }
        (Geometry::Custom(_), _) | (_, Geometry::Custom(_)) => None,
        // What was fitted to points is as far off as the furthest of them.
        (Geometry::Polyline(_) | Geometry::Cloud(_), Geometry::Curve(curve)) => {
            let points = before.points();
            let effort = curve.space().spans().count().saturating_mul(points.len());
            let near = |p: &Point| Some(curve.closest(*p).ok()?.distance);
            (effort <= EFFORT).then(|| largest(points.iter().map(near)))?
        }
        (Geometry::Cloud(_), Geometry::Surface(surface)) => {
            let points = before.points();
            let pieces = surface.u().spans().count().saturating_mul(surface.v().spans().count());
            let near = |p: &Point| Some(surface.closest_foot(*p).ok()?.distance);
            (pieces.saturating_mul(points.len()) <= EFFORT).then(|| largest(points.iter().map(near)))?
        }
        (before, after) if before.kind() == after.kind() => {
            let (before, after) = (before.points(), after.points());
            (before.len() == after.len() && !after.is_empty())
                .then(|| largest(before.iter().zip(after).map(|(a, b)| Some(distance(a, b)))))?
        }
        _ => None,
    }
}

/// Whether a shape was fitted to points, so that nothing but these is compared with it.
pub(super) fn is_of_points(before: &Geometry, after: &Geometry) -> bool {
    let points = matches!(before, Geometry::Polyline(_) | Geometry::Cloud(_));
    points && matches!(after, Geometry::Curve(_) | Geometry::Surface(_))
}

/// One way, or both ways.
fn both<S>(before: &S, after: &S, whole: bool, one: fn(&S, &S) -> Option<f64>) -> Option<f64> {
    let there = one(before, after)?;
    Some(if whole { there.max(one(after, before)?) } else { there })
}

fn of_curves(before: &Curve, after: &Curve) -> Option<f64> {
    let breaks = after.space().breakpoints();
    let way = |[u]: [f64; 1]| Some(distance(&before.point(u).ok()?, &after.point(u).ok()?));
    let spans = after.space().spans().count();
    let dense = [places(&breaks, (2 * spans).clamp(ON_CURVES, ON_WAYS_OF_CURVES))];
    let most =
        moved_most(before.points(), after.points()).and_then(|k| middle(after.space(), k)).map(|u| [u]);
    let grid = places(&breaks, ON_CURVES);
    if before.space().spans().count().saturating_mul(grid.len()) <= EFFORT {
        let away = |[u]: [f64; 1]| Some(before.closest(after.point(u).ok()?).ok()?.distance);
        let alike = before.domain() == after.domain();
        let mut more = if alike { suspects(&dense, way, &away, &unbounded)? } else { Vec::new() };
        more.extend(most);
        return furthest(&[grid], &more, &away, &unbounded);
    }
    // The way of each point: it bounds the distance.
    (before.space() == after.space()).then(|| furthest(&dense, most.as_slice(), &way, &unbounded))?
}

/// No bound of a distance is known.
fn unbounded<const N: usize>(_: [f64; N]) -> Option<f64> {
    None
}

fn of_surfaces(before: &Surface, after: &Surface) -> Option<f64> {
    let directions = [after.u(), after.v()];
    let dense = directions
        .map(|space| places(&space.breakpoints(), (2 * space.spans().count()).clamp(ON_SURFACES, ON_WAYS)));
    let way = |[u, v]: [f64; 2]| Some(distance(&before.point(u, v).ok()?, &after.point(u, v).ok()?));
    let most = moved_most(before.points(), after.points()).and_then(|k| {
        let columns = after.v().len();
        Some([middle(after.u(), k / columns)?, middle(after.v(), k % columns)?])
    });
    let grid = directions.map(|space| places(&space.breakpoints(), ON_SURFACES));
    let pieces = before.u().spans().count().saturating_mul(before.v().spans().count());
    if pieces.saturating_mul(grid[0].len() * grid[1].len()) <= EFFORT {
        // Downhill from the same parameters a place is found that is as near as the nearest, or not as near, for next to nothing.
        let bound = |[u, v]: [f64; 2]| Some(before.foot(after.point(u, v).ok()?, (u, v)).ok()?.distance);
        // Where a surface folds over or bends round the places of the other, a search may look at all of it, again and again: when together they have looked
        // at so many pieces, what a few more say is no less than the distance.
        let left = Cell::new(EFFORT);
        let away = |[u, v]: [f64; 2]| {
            let point = after.point(u, v).ok()?;
            let most = left.get().min(SEARCH).max(pieces.max(FEW));
            let (found, looked) = before.nearly_closest_of(point, 0.0, NEARLY, most).ok()?;
            left.set(left.get().saturating_sub(looked));
            let near =
                before.foot(point, found.at).map_or(found.distance, |foot| foot.distance.min(found.distance));
            Some(bound([u, v]).map_or(near, |bound| bound.min(near)))
        };
        let alike = before.u().domain() == after.u().domain() && before.v().domain() == after.v().domain();
        let mut more = if alike { suspects(&dense, way, &away, &bound)? } else { Vec::new() };
        more.extend(most);
        return furthest(&grid, &more, &away, &bound);
    }
    let same = before.u() == after.u() && before.v() == after.v();
    same.then(|| furthest(&dense, most.as_slice(), &way, &unbounded))?
}

/// Of what loops leave of two surfaces: what is cut away counts on neither. Beyond the border of the old one the nearest place is one of the border, which is no less.
fn of_parts(before: &Part, after: &Part) -> Option<f64> {
    let (old, new) = (before.surface(), after.surface());
    let directions = [new.u(), new.v()];
    let grid = directions.map(|space| places(&space.breakpoints(), ON_SURFACES));
    let mut border = Vec::new();
    for curve in after.border() {
        let (from, to) = curve.range();
        let spans = curve.curve().space().spans().count();
        let count = (ON_BORDERS * spans).min(ON_CURVES);
        for k in 0..count {
            let at = curve.curve().point(from + (to - from) * (k as f64 / count as f64)).ok()?;
            border.push(after.wrapped([at.x, at.y]));
        }
    }
    let spans: usize = before.border().iter().map(|curve| curve.curve().space().spans().count()).sum();
    let pieces = old.u().spans().count().saturating_mul(old.v().spans().count()).saturating_add(spans);
    if pieces.saturating_mul(grid[0].len() * grid[1].len() + border.len()) > EFFORT {
        return None;
    }
    let away = |[u, v]: [f64; 2]| -> Option<f64> {
        let point = new.point(u, v).ok()?;
        before.distance_at_most(point).ok()
    };
    let inside = |at: [f64; 2]| if after.has(at) { away(at) } else { Some(0.0) };
    let domains = [old, new].map(|surface| [surface.u().domain(), surface.v().domain()]);
    let mut more = Vec::new();
    if domains[0] == domains[1] {
        let way = |at: [f64; 2]| {
            let there = || Some(distance(&old.point(at[0], at[1]).ok()?, &new.point(at[0], at[1]).ok()?));
            if after.has(at) { there() } else { Some(0.0) }
        };
        let dense = directions.map(|space| {
            places(&space.breakpoints(), (2 * space.spans().count()).clamp(ON_SURFACES, ON_WAYS))
        });
        more = suspects(&dense, way, &inside, &unbounded)?;
    }
    // Places of the border itself are neither inside nor outside.
    let edge = largest(border.iter().map(|at| away(*at)))?;
    Some(edge.max(furthest(&grid, &more, &inside, &unbounded)?))
}

/// Points are where a map takes them that differ from there by no more than this part of their size.
const SIMILAR: f64 = 1e-9;

/// Whether all points have gone where one similarity takes them: found from four of them that are far from lying in a plane. `O(n)`. (A face of a block that is
/// pulled out takes all points where an affine map does.)
fn is_similar(before: &[Point], after: &[Point]) -> bool {
    let (Some(&from), Some(&to)) = (before.first(), after.first()) else { return false };
    if before.len() != after.len() {
        return false;
    }
    let furthest = |away: &dyn Fn(&Vector) -> f64| {
        (0..before.len()).max_by(|&a, &b| away(&(before[a] - from)).total_cmp(&away(&(before[b] - from))))
    };
    let Some(x) = furthest(&|d| d.norm()) else { return false };
    let one = (before[x] - from).normalize();
    let Some(y) = furthest(&|d| d.cross(&one).norm()) else { return false };
    let normal = one.cross(&(before[y] - from)).normalize();
    let Some(z) = furthest(&|d| d.dot(&normal).abs()) else { return false };
    let columns = |points: &[Point], from: Point| Matrix3::from_columns(&[x, y, z].map(|k| points[k] - from));
    let Some(inverse) = columns(before, from).try_inverse() else { return false };
    let map = columns(after, to) * inverse;
    let scale = map.norm_squared() / 3.0;
    if (map.transpose() * map - Matrix3::identity() * scale).amax() > SIMILAR * scale {
        return false;
    }
    let size =
        before.iter().zip(after).map(|(p, q)| (p - from).amax().max((q - to).amax())).fold(0.0, f64::max);
    before.iter().zip(after).all(|(p, q)| (to + map * (p - from) - q).amax() <= SIMILAR * size)
}

/// The vertex that has moved most, where they are as many.
fn moved_most(before: &[Point], after: &[Point]) -> Option<usize> {
    let ways = before.iter().zip(after).map(|(p, q)| distance(p, q));
    let most = ways.enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).map(|(k, _)| k);
    most.filter(|_| before.len() == after.len())
}

/// Where a vertex counts most, about, if that is within the domain.
fn middle(space: &Space, vertex: usize) -> Option<f64> {
    let (a, b) = space.domain();
    let at = (vertex < space.len()).then(|| space.greville(vertex));
    at.filter(|at| (a..=b).contains(at))
}

/// At least so many parameters, evenly between breakpoints; of very many breakpoints some.
fn places(breaks: &[f64], count: usize) -> Vec<f64> {
    let spans = breaks.len().saturating_sub(1).max(1);
    let (each, stride) = (count.div_ceil(spans), spans.div_ceil(count));
    let pairs = breaks.windows(2).step_by(stride);
    let inside = pairs.flat_map(|pair| {
        (0..each).map(move |k| {
            let t = k as f64 / each as f64;
            pair[0] * (1.0 - t) + pair[1] * t
        })
    });
    inside.chain(breaks.last().copied()).collect()
}

fn largest(mut distances: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    distances.try_fold(0.0, |most: f64, distance| Some(most.max(distance?))).filter(|d| d.is_finite())
}

/// A distance whose squares neither overflow nor vanish.
pub(super) fn distance(p: &Point, q: &Point) -> f64 {
    let d = q - p;
    d.x.hypot(d.y).hypot(d.z)
}
