//! How far a shape is from what it was.

use loftsman_kernel::Point;
use loftsman_kernel::scene::Geometry;
use loftsman_kernel::spline::part::Part;
use loftsman_kernel::spline::{Curve, Space, Surface};

/// Places of a curve at which its distance from another is taken, about as many.
const ON_CURVES: usize = 256;
/// The same of a surface, in each direction.
const ON_SURFACES: usize = 12;
/// The most pieces of the other shape, all places together, that a search for closest points looks at.
const EFFORT: usize = 1_000_000;
/// The most places of a direction of a surface at which the ways of points of the same parameters are compared, which cost little; and of a curve.
const ON_WAYS: usize = 500;
const ON_WAYS_OF_CURVES: usize = 100_000;
/// Of so many places where such a way is longest among those around, the distance is taken.
const SUSPECTS: usize = 32;
/// From so many of all these places, the furthest that are further than those around them, further ones are looked for.
const CLIMBED: usize = 4;
/// The most faces of a Brep that have moved: of all of them it would take long.
const MOVED_FACES: usize = 8;
/// Places of each span of a border.
const ON_BORDERS: usize = 4;
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
        (Geometry::Surface(before), Geometry::Surface(after)) => {
            let domains = [before, after].map(|surface| [surface.u().domain(), surface.v().domain()]);
            both(before, after, domains[0] == domains[1], of_surfaces)
        }
        (Geometry::Trimmed(before), Geometry::Trimmed(after)) => {
            let [before, after] = [before.part().ok()?, after.part().ok()?];
            both(&before, &after, true, of_parts)
        }
        // Face by face: the place on another face that is nearer, if there is one, is not looked for.
        (Geometry::Brep(before), Geometry::Brep(after)) => {
            let count = after.face_count();
            let moved = |face: &usize| before.surface(*face) != after.surface(*face);
            let of_face =
                |face: usize| both(&before.part(face).ok()?, &after.part(face).ok()?, true, of_parts);
            if before.face_count() != count {
                return None;
            }
            let faces: Vec<usize> = (0..count).filter(moved).collect();
            (faces.len() <= MOVED_FACES).then(|| largest(faces.into_iter().map(of_face)))?
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
        let mut more = if alike { suspects(&dense, way, away)? } else { Vec::new() };
        more.extend(most);
        return furthest(&[grid], &more, away);
    }
    // The way of each point: it bounds the distance.
    (before.space() == after.space()).then(|| furthest(&dense, most.as_slice(), way))?
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
        let away = |[u, v]: [f64; 2]| from_surface(before, after.point(u, v).ok()?);
        let alike = before.u().domain() == after.u().domain() && before.v().domain() == after.v().domain();
        let mut more = if alike { suspects(&dense, way, away)? } else { Vec::new() };
        more.extend(most);
        return furthest(&grid, &more, away);
    }
    let same = before.u() == after.u() && before.v() == after.v();
    same.then(|| furthest(&dense, most.as_slice(), way))?
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
        more = suspects(&dense, way, inside)?;
    }
    // Places of the border itself are neither inside nor outside.
    let edge = largest(border.iter().map(|at| away(*at)))?;
    Some(edge.max(furthest(&grid, &more, inside)?))
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

/// Places of a grid in a box.
struct Places<'a, const N: usize>(&'a [Vec<f64>; N]);

impl<const N: usize> Places<'_, N> {
    fn count(&self) -> usize {
        self.0.iter().map(Vec::len).product()
    }

    fn indices(&self, mut k: usize) -> [usize; N] {
        let mut all = [0; N];
        for d in (0..N).rev() {
            (all[d], k) = (k % self.0[d].len(), k / self.0[d].len());
        }
        all
    }

    fn place(&self, k: usize) -> [f64; N] {
        let at = self.indices(k);
        std::array::from_fn(|d| self.0[d][at[d]])
    }

    /// Those at which a value is larger than at all places around (of equal ones the first), the largest first.
    fn peaks(&self, values: &[f64]) -> Vec<usize> {
        let is_peak = |k: usize| {
            let at = self.indices(k);
            // The neighbours are counted with a digit for each direction: before, beside, after.
            (0..3_usize.pow(N as u32)).all(|mut which| {
                let mut other = 0;
                for (d, here) in at.into_iter().enumerate() {
                    let Some(there) = (here + which % 3).checked_sub(1).filter(|t| *t < self.0[d].len())
                    else {
                        return true;
                    };
                    which /= 3;
                    other = other * self.0[d].len() + there;
                }
                values[k] > values[other] || (values[k] == values[other] && k <= other)
            })
        };
        let mut peaks: Vec<usize> = (0..values.len()).filter(|k| is_peak(*k)).collect();
        peaks.sort_by(|a, b| values[*b].total_cmp(&values[*a]));
        peaks
    }
}

/// Where points of the same parameters are furthest from one another among those around: no distance of such a place is larger than the `way`, so that
/// they are looked at in the order of their ways until no other one can be further.
fn suspects<const N: usize>(
    dense: &[Vec<f64>; N],
    way: impl Fn([f64; N]) -> Option<f64>,
    away: impl Fn([f64; N]) -> Option<f64>,
) -> Option<Vec<[f64; N]>> {
    let places = Places(dense);
    let ways: Vec<f64> = (0..places.count()).map(|k| way(places.place(k))).collect::<Option<_>>()?;
    let (mut most, mut found) = (0.0_f64, Vec::new());
    for k in places.peaks(&ways).into_iter().take(SUSPECTS) {
        if ways[k] <= most {
            break;
        }
        let here = places.place(k);
        let far = away(here)?;
        most = most.max(far);
        found.push((far, here));
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found.truncate(CLIMBED);
    Some(found.into_iter().map(|(_, here)| here).collect())
}

/// The largest of distances over a box: at the places of a grid, and uphill from the largest of these and of `more`, by steps that are halved. `None` where one is not
/// known.
fn furthest<const N: usize>(
    grid: &[Vec<f64>; N],
    more: &[[f64; N]],
    distance: impl Fn([f64; N]) -> Option<f64>,
) -> Option<f64> {
    let places = Places(grid);
    let values: Vec<f64> = (0..places.count()).map(|k| distance(places.place(k))).collect::<Option<_>>()?;
    let peaks = places.peaks(&values).into_iter().take(CLIMBED).map(|k| (values[k], places.place(k)));
    let mut starts: Vec<(f64, [f64; N])> = peaks.collect();
    for at in more {
        starts.push((distance(*at)?, *at));
    }
    // The sort is stable: of equal ones the first.
    starts.sort_by(|a, b| b.0.total_cmp(&a.0));
    starts.truncate(CLIMBED);
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
    use loftsman_kernel::brep::Brep;
    use loftsman_kernel::mesh::Cloud;
    use loftsman_kernel::spline::trimmed::{ParameterCurve, Region, Trimmed};

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

    /// Of several bumps the highest, although a lower one is where a grid has its places, or where the vertex is that has moved most.
    #[test]
    fn of_several_bumps_the_highest_is_found() {
        let mut state = 3_u32;
        let mut noise = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state) / f64::from(u32::MAX)
        };
        for (count, bumps) in [(50, 3), (400, 7), (2503, 12)] {
            let space = Space::clamped_uniform(3, count).unwrap();
            let points: Vec<Point> = (0..count).map(|k| Point::new(k as f64, 0.0, 0.0)).collect();
            let mut moved = points.clone();
            // One vertex far, beside others that move further together.
            moved[count / 3].y += 1.0;
            for _ in 0..bumps {
                let k = (noise() * (count - 4) as f64) as usize;
                let height = 0.5 + 0.4 * noise();
                moved[k..k + 4].iter_mut().for_each(|p| p.y = height);
            }
            let [old, new] = [points, moved].map(|p| Curve::new(space.clone(), p).unwrap());
            let (a, b) = space.domain();
            let far = (0..=800_000).map(|k| new.point(a + (b - a) * f64::from(k) / 800_000.0).unwrap().y);
            let far = far.fold(0.0, f64::max);
            let found = deviation(&old.into(), &new.into()).unwrap();
            assert!((found - far).abs() < 1e-5 * far, "{count}: {found} {far}");
        }
        for (count, bumps) in [(20, 3), (60, 8)] {
            let space = || Space::clamped_uniform(2, count).unwrap();
            let flat: Vec<Point> =
                (0..count * count).map(|k| Point::new((k / count) as f64, (k % count) as f64, 0.0)).collect();
            let mut moved = flat.clone();
            moved[count * 7 + 9].z += 1.0;
            for _ in 0..bumps {
                let [i, j] = [(); 2].map(|()| (noise() * (count - 3) as f64) as usize);
                let height = 0.6 + 0.35 * noise();
                for k in (i..i + 3).flat_map(|i| (j..j + 3).map(move |j| i * count + j)) {
                    moved[k].z = height;
                }
            }
            let [old, new] = [flat, moved].map(|p| Surface::new(space(), space(), p).unwrap());
            let (a, b) = space().domain();
            let at = |k: u32| a + (b - a) * f64::from(k) / 1200.0;
            let far = (0..=1200 * 1201).map(|k: u32| new.point(at(k / 1201), at(k % 1201)).unwrap().z);
            let far = far.fold(0.0, f64::max);
            let found = deviation(&old.into(), &new.into()).unwrap();
            // At a flat top but for rounding.
            assert!(found > far * (1.0 - 1e-12) && found < far * (1.0 + 1e-3), "{count}: {found} {far}");
        }
    }

    /// What loops cut away has not moved, whatever its surface does there; a border that cuts a bump in two is where it is highest. A Brep's faces are such parts.
    #[test]
    fn what_is_cut_away_does_not_count() {
        let space = || Space::clamped_uniform(3, 12).unwrap();
        let (_, end) = space().domain();
        let greville = |k: usize| space().greville(k);
        let flat: Vec<Point> =
            (0..144).map(|k| Point::new(greville(k / 12), greville(k % 12), 0.0)).collect();
        let corners = [[0.0, 0.0], [0.5 * end, 0.0], [0.5 * end, end], [0.0, end]];
        let at = |k: usize| Point::new(corners[k % 4][0], corners[k % 4][1], 0.0);
        let outer =
            (0..4).map(|k| ParameterCurve::whole(Curve::line(at(k), at(k + 1)).unwrap()).unwrap()).collect();
        let regions = vec![Region { outer, holes: Vec::new() }];
        for (row, counts) in [(10, false), (6, true), (2, true)] {
            let mut moved = flat.clone();
            moved[row * 12 + 5].z = 0.25;
            let [old, new] = [&flat, &moved].map(|p| Surface::new(space(), space(), p.clone()).unwrap());
            let places = |k: u32| end * f64::from(k) / 1000.0;
            let far = (0..=500)
                .flat_map(|i| (0..=1000).map(move |j| (i, j)))
                .map(|(i, j)| new.point(places(i), places(j)).unwrap().z)
                .fold(0.0, f64::max);
            assert_eq!(far > 0.0, counts);
            let [old, new] = [old, new]
                .map(|s| Geometry::from(Trimmed::new(s, regions.clone(), Vec::new(), Vec::new()).unwrap()));
            let found = deviation(&old, &new).unwrap();
            // What has not moved is where it was to rounding, on a sheet of 9.
            assert!((found - far).abs() <= 1e-4 * far + 1e-13 * end, "{row}: {found} {far}");
        }
        let block = |by: f64| {
            Geometry::from(Brep::block(Point::new(by, 0.0, 0.0), Point::new(2.0, 3.0, 4.0)).unwrap())
        };
        let found = deviation(&block(0.0), &block(0.5)).unwrap();
        assert!((found - 0.5).abs() < 1e-9, "{found}");
        assert_eq!(deviation(&block(0.5), &block(0.5)), Some(0.0));
    }
}
