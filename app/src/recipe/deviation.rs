//! How far a shape is from what it was.

use loftsman_kernel::Point;
use loftsman_kernel::scene::Geometry;
use loftsman_kernel::spline::{Curve, Space, Surface};

/// Places of a curve at which its distance from another is taken, about as many.
const ON_CURVES: usize = 256;
/// The same of a surface, in each direction.
const ON_SURFACES: usize = 12;
/// The most places of a direction of a surface with very many spans.
const ON_GRIDS: usize = 1000;
/// The most pieces of the other shape, all places together, that a search for closest points looks at.
const EFFORT: usize = 1_000_000;
/// From so many of these places, the furthest that are not beside one another, further ones are looked for.
const CLIMBED: usize = 3;
/// Halvings of the step of such a search.
const HALVINGS: usize = 12;
/// A closest place is known to this part of its distance: what is further by less is no further.
const KNOWN: f64 = 1e-10;
/// Steps of one length at most.
const STEPS: usize = 16;

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
        (Geometry::Surface(before), Geometry::Surface(after)) => between(before, after),
        (Geometry::Trimmed(before), Geometry::Trimmed(after)) => between(before.surface(), after.surface()),
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
            let near = |p: &Point| from_surface(surface, *p);
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

fn between(before: &Surface, after: &Surface) -> Option<f64> {
    let domains = [before, after].map(|surface| [surface.u().domain(), surface.v().domain()]);
    both(before, after, domains[0] == domains[1], of_surfaces)
}

/// One way, or both ways.
fn both<S>(before: &S, after: &S, whole: bool, one: fn(&S, &S) -> Option<f64>) -> Option<f64> {
    let there = one(before, after)?;
    Some(if whole { there.max(one(after, before)?) } else { there })
}

fn of_curves(before: &Curve, after: &Curve) -> Option<f64> {
    let grid = places(&after.space().breakpoints(), ON_CURVES);
    let most =
        moved_most(before.points(), after.points()).and_then(|k| middle(after.space(), k)).map(|u| [u]);
    if before.space().spans().count().saturating_mul(grid.len()) <= EFFORT {
        return furthest([&grid], most, |[u]| Some(before.closest(after.point(u).ok()?).ok()?.distance));
    }
    // The way of each point: it bounds the distance. A place of each span at least.
    let same = before.space() == after.space();
    same.then(|| {
        let grid = places(&after.space().breakpoints(), ON_CURVES.max(after.space().spans().count()));
        furthest([&grid], most, |[u]| Some(distance(&before.point(u).ok()?, &after.point(u).ok()?)))
    })?
}

fn of_surfaces(before: &Surface, after: &Surface) -> Option<f64> {
    let [u, v] = [after.u(), after.v()].map(|space| places(&space.breakpoints(), ON_SURFACES));
    let most = moved_most(before.points(), after.points()).and_then(|k| {
        let columns = after.v().len();
        Some([middle(after.u(), k / columns)?, middle(after.v(), k % columns)?])
    });
    let pieces = before.u().spans().count().saturating_mul(before.v().spans().count());
    if pieces.saturating_mul(u.len() * v.len()) <= EFFORT {
        return furthest([&u, &v], most, |[u, v]| from_surface(before, after.point(u, v).ok()?));
    }
    let same = before.u() == after.u() && before.v() == after.v();
    let way = |[u, v]: [f64; 2]| Some(distance(&before.point(u, v).ok()?, &after.point(u, v).ok()?));
    same.then(|| {
        let [u, v] = [after.u(), after.v()]
            .map(|space| places(&space.breakpoints(), ON_SURFACES.max(space.spans().count().min(ON_GRIDS))));
        furthest([&u, &v], most, way)
    })?
}

/// The distance of a point from a surface: of its foot, which is found from the certified closest place to rounding.
fn from_surface(surface: &Surface, point: Point) -> Option<f64> {
    let closest = surface.closest(point).ok()?;
    let foot = surface.foot(point, closest.at).ok().map_or(closest.distance, |foot| foot.distance);
    Some(closest.distance.min(foot))
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

/// The largest of distances over a box: at the places of a grid, and uphill from the largest of these and from one `more`, by steps that are halved. `None` where one is not
/// known.
fn furthest<const N: usize>(
    grid: [&[f64]; N],
    more: Option<[f64; N]>,
    distance: impl Fn([f64; N]) -> Option<f64>,
) -> Option<f64> {
    let count = grid.iter().map(|places| places.len()).product();
    let indices = |mut k: usize| {
        let mut all = [0; N];
        for d in (0..N).rev() {
            (all[d], k) = (k % grid[d].len(), k / grid[d].len());
        }
        all
    };
    let place = |k: [usize; N]| std::array::from_fn(|d| grid[d][k[d]]);
    let mut found: Vec<(f64, [usize; N])> = Vec::with_capacity(count);
    for k in (0..count).map(indices) {
        found.push((distance(place(k))?, k));
    }
    // The sort is stable: of equal ones the first.
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut starts: Vec<(f64, [usize; N])> = Vec::with_capacity(CLIMBED);
    for (at, k) in found {
        let beside = |(_, other): &(f64, [usize; N])| (0..N).all(|d| k[d].abs_diff(other[d]) <= 1);
        if starts.len() < CLIMBED && !starts.iter().any(beside) {
            starts.push((at, k));
        }
    }
    let mut starts: Vec<(f64, [f64; N])> = starts.into_iter().map(|(at, k)| (at, place(k))).collect();
    if let Some(more) = more {
        starts.push((distance(more)?, more));
    }
    let ends: [(f64, f64); N] = std::array::from_fn(|d| (grid[d][0], grid[d][grid[d].len() - 1]));
    let mut most = 0.0_f64;
    for (mut at, mut here) in starts {
        let mut step: [f64; N] = std::array::from_fn(|d| (ends[d].1 - ends[d].0) / grid[d].len() as f64);
        for _ in 0..HALVINGS {
            for _ in 0..STEPS {
                let mut better = (at, here);
                for (d, way) in (0..N).flat_map(|d| [(d, 1.0), (d, -1.0)]) {
                    let mut there = here;
                    there[d] = (here[d] + way * step[d]).clamp(ends[d].0, ends[d].1);
                    let far = distance(there)?;
                    if far > better.0 * (1.0 + KNOWN) {
                        better = (far, there);
                    }
                }
                if better.0 <= at {
                    break;
                }
                (at, here) = better;
            }
            step = step.map(|s| 0.5 * s);
        }
        most = most.max(at);
    }
    Some(most).filter(|d| d.is_finite())
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

#[cfg(test)]
pub(super) mod tests {
    use loftsman_kernel::Vector;
    use loftsman_kernel::mesh::Cloud;

    use super::*;

    pub(crate) fn arch(degree: usize, lift: f64) -> Curve {
        let count = degree + 4;
        let at = |k: usize| Point::new(k as f64, (k * (count - 1 - k)) as f64 / 4.0, lift);
        Curve::new(Space::clamped_uniform(degree, count).unwrap(), (0..count).map(at).collect()).unwrap()
    }

    pub(crate) fn sheet(lift: f64) -> Surface {
        let space = || Space::clamped_uniform(3, 5).unwrap();
        let at = |k: usize| Point::new((k / 5) as f64, (k % 5) as f64, lift + (k % 3) as f64 / 9.0);
        Surface::new(space(), space(), (0..25).map(at).collect()).unwrap()
    }

    /// To the nearest point, not the one of the same parameter: a shape that only runs otherwise has not moved.
    #[test]
    fn the_deviation_is_a_distance_of_shapes() {
        for degree in [1, 2, 3, 5, 7] {
            let old = arch(degree, 0.0);
            for (new, off) in [
                (arch(degree, 0.5), 0.5),
                (old.elevate(1).unwrap(), 0.0),
                (old.insert_knots(&[0.25, 0.5]).unwrap(), 0.0),
                (old.reverse().unwrap(), 0.0),
            ] {
                let found = deviation(&old.clone().into(), &new.into()).unwrap();
                assert!((found - off).abs() < 1e-12, "degree {degree}: {found}, {off}");
            }
        }
        let found = deviation(&sheet(0.0).into(), &sheet(0.125).into()).unwrap();
        assert!((found - 0.125).abs() < 1e-12, "{found}");
        let cloud =
            |by: Vector| Geometry::from(Cloud { points: vec![Point::origin() + by, Point::origin()] });
        assert_eq!(deviation(&cloud(Vector::zeros()), &cloud(Vector::new(0.0, 3.0, 4.0))), Some(5.0));
        assert_eq!(deviation(&cloud(Vector::new(0.0, 0.0, -0.5)), &arch(3, 0.0).into()), Some(0.5));
        assert_eq!(deviation(&arch(3, 0.0).into(), &cloud(Vector::zeros())), None);
        let fewer = Geometry::from(Cloud { points: vec![Point::origin()] });
        assert_eq!(deviation(&cloud(Vector::zeros()), &fewer), None);
    }

    /// The furthest place is found, wherever between the places of the grid it is: against half a million places of a bump that one vertex makes, of a
    /// curve and of a surface with few and with many spans.
    #[test]
    fn the_furthest_place_is_found_between_the_places_of_the_grid() {
        for (count, which) in [(6, 1), (6, 3), (40, 17), (600, 301), (4003, 1777)] {
            let space = Space::clamped_uniform(3, count).unwrap();
            let points: Vec<Point> = (0..count).map(|k| Point::new(k as f64, 0.0, 0.0)).collect();
            let mut moved = points.clone();
            moved[which].y += 0.3;
            let [old, new] = [points, moved].map(|p| Curve::new(space.clone(), p).unwrap());
            let (a, b) = space.domain();
            let far = (0..=500_000).map(|k| new.point(a + (b - a) * f64::from(k) / 500_000.0).unwrap().y);
            let far = far.fold(0.0, f64::max);
            let found = deviation(&old.into(), &new.into()).unwrap();
            assert!((found - far).abs() < 1e-6 * far, "{count}: {found} {far}");
        }
        for (count, which) in [(4, 6), (7, 15), (30, 317), (123, 7001)] {
            let space = || Space::clamped_uniform(3, count).unwrap();
            let flat: Vec<Point> =
                (0..count * count).map(|k| Point::new((k / count) as f64, (k % count) as f64, 0.0)).collect();
            let mut moved = flat.clone();
            moved[which].z += 0.05;
            let [old, new] = [flat, moved].map(|p| Surface::new(space(), space(), p).unwrap());
            // What a vertex moves is the product of two basis functions, each with a peak of its own.
            let peak = |vertex: usize| {
                let mut high = vec![Point::origin(); count];
                high[vertex].y = 1.0;
                let basis = Curve::new(space(), high).unwrap();
                let (a, b) = space().domain();
                (0..=200_000)
                    .map(|k| basis.point(a + (b - a) * f64::from(k) / 200_000.0).unwrap().y)
                    .fold(0.0, f64::max)
            };
            let far = 0.05 * peak(which / count) * peak(which % count);
            let found = deviation(&old.into(), &new.into()).unwrap();
            assert!((found - far).abs() < 1e-6 * far, "{count}: {found} {far}");
        }
    }
}
