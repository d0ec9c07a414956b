//! Whether faces of a brep have moved through others.

use loftsman_kernel::brep::Brep;
use loftsman_kernel::scene::Unit;
use loftsman_kernel::spline::Surface;
use loftsman_kernel::spline::curvature::Normal;
use loftsman_kernel::text::{figure, measured};
use loftsman_kernel::{Point, Vector};
use nalgebra::Matrix3;

use crate::paths::{Path, cuts};

/// Strips of a surface in each direction, and at most so many of one of many spans.
const STRIPS: usize = 32;
const MOST: usize = 128;
/// What is no further beyond a face than this part of the size, or so many times what edges are off, has not passed it.
const ROUNDING: f64 = 1e-6;
const LOOSE: f64 = 4.0;
/// Steps of Newton's method, and how near, as a part of the size, a passage is found.
const ITERATIONS: usize = 16;
const FOUND: f64 = 1e-10;
/// So many are told one by one.
const TOLD: usize = 3;

/// The place of a face that is furthest beyond another one, on the way there.
struct Passage {
    path: Path,
    through: usize,
    beyond: f64,
}

/// Warnings that a face has moved through one that stands still: which ones, how far it is beyond at most and where, what to do. The straight ways of these places
/// are cut with the faces that stand still, each drawn as strips of triangles and where one is met with its surface. Faces that move are not looked at as what others pass
/// through. About `O(√triangles)` for a way.
pub(crate) fn passages(before: &Brep, after: &Brep, paths: &[Path], scale: f64, unit: Unit) -> Vec<String> {
    let points = before.points();
    let Some(first) = points.first() else { return Vec::new() };
    let size = points.iter().map(|p| (p - first).amax()).fold(0.0, f64::max);
    let off = |face: usize| {
        let edges = before.loops(face).iter().flatten().filter_map(|one| before.edge(one.edge));
        edges.map(|edge| edge.tolerance).fold(0.0, f64::max)
    };
    let mut found: Vec<Passage> = Vec::new();
    for through in 0..after.face_count() {
        let Some(surface) =
            before.surface(through).filter(|old| after.surface(through).as_ref() == Some(old))
        else {
            continue;
        };
        let around = surface.hull_bounds();
        let near: Vec<&Path> = paths
            .iter()
            .filter(|path| meet(around, (path.from.inf(&path.to), path.from.sup(&path.to))))
            .collect();
        if near.is_empty() {
            continue;
        }
        let Some(drawn) = Drawn::new(&surface) else { continue };
        let (mut part, mut own) = (None, Vec::new());
        for path in near {
            let Some((at, share)) = drawn.passed(&surface, path, size) else { continue };
            if part.is_none() {
                part = Some(before.part(through));
            }
            let Some(Ok(part)) = &part else { break };
            let normal = surface.normal(at[0], at[1]).ok().and_then(Normal::vector);
            let (Some(normal), true) = (normal, part.has(at)) else { continue };
            let rest = (path.to - path.from) * (1.0 - share);
            own.push(Passage { path: *path, through, beyond: rest.dot(&normal).abs() });
        }
        own.sort_by(|a, b| a.path.face.cmp(&b.path.face).then(b.beyond.total_cmp(&a.beyond)));
        own.dedup_by_key(|one| one.path.face);
        own.retain(|one| one.beyond > (ROUNDING * size).max(LOOSE * off(one.path.face).max(off(through))));
        found.extend(own);
    }
    found.sort_by(|a, b| b.beyond.total_cmp(&a.beyond).then(a.path.face.cmp(&b.path.face)));
    let mut told: Vec<String> = found.iter().take(TOLD).map(|one| one.told(scale, unit)).collect();
    match found.len().saturating_sub(TOLD) {
        0 => {}
        1 => told.push("one more face has moved through another".to_owned()),
        more => told.push(format!("{more} more faces have moved through others")),
    }
    told
}

impl Passage {
    fn told(&self, scale: f64, unit: Unit) -> String {
        let Self { path: Path { face, at: [u, v], to, .. }, through, beyond } = self;
        format!(
            "face {face} has moved through face {through}, which stands still: its place uv = [{}, {}], near [{}, {}, {}], is {} beyond it; move it by less, \
             let face {through} go along (\"faces\", \"neighbours\"), or keep places of it",
            measured(*u),
            measured(*v),
            figure(to.x),
            figure(to.y),
            figure(to.z),
            unit.quantity(scale * beyond, 1),
        )
    }
}

type Bounds = (Point, Point);

fn meet(a: Bounds, b: Bounds) -> bool {
    (0..3).all(|k| a.0[k] <= b.1[k] && b.0[k] <= a.1[k])
}

/// A surface as strips of cells, each of two triangles.
struct Drawn {
    parameters: [Vec<f64>; 2],
    points: Vec<Point>,
    strips: Vec<Bounds>,
}

impl Drawn {
    fn new(surface: &Surface) -> Option<Self> {
        let parameters = [surface.u(), surface.v()].map(|space| cuts(space, STRIPS, MOST));
        let mut points = Vec::with_capacity(parameters[0].len() * parameters[1].len());
        for &u in &parameters[0] {
            for &v in &parameters[1] {
                points.push(surface.point(u, v).ok()?);
            }
        }
        let columns = parameters[1].len();
        let strips = points.chunks(columns).zip(points.chunks(columns).skip(1));
        let strips = strips.map(|(a, b)| bounds(a.iter().chain(b))).collect();
        Some(Self { parameters, points, strips })
    }

    /// The parameters where a way passes the surface first, and the share of the way up to there.
    fn passed(&self, surface: &Surface, path: &Path, size: f64) -> Option<([f64; 2], f64)> {
        let own = (path.from.inf(&path.to), path.from.sup(&path.to));
        let columns = self.parameters[1].len();
        let mut first: Option<([f64; 2], f64)> = None;
        for (i, strip) in self.strips.iter().enumerate() {
            if !meet(*strip, own) {
                continue;
            }
            for j in 0..columns - 1 {
                let corner = |a: usize, b: usize| self.points[(i + a) * columns + j + b];
                let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)];
                if !meet(bounds([a, b, c, d].iter()), own) {
                    continue;
                }
                let halves = [([a, b, c], [0.0, 1.0]), ([d, c, b], [1.0, -1.0])];
                for (triangle, [start, way]) in halves {
                    let Some(shares) = crossed(triangle, path) else { continue };
                    let place = [0, 1].map(|k| {
                        let (number, cuts) = ([i, j][k], &self.parameters[k]);
                        cuts[number] + (cuts[number + 1] - cuts[number]) * (start + way * shares[k])
                    });
                    let found = settled(surface, path, place, shares[2], size);
                    first = match (first, found) {
                        (Some(known), Some(new)) if known.1 <= new.1 => Some(known),
                        (known, new) => new.or(known),
                    };
                }
            }
        }
        first
    }
}

fn bounds<'p>(points: impl Iterator<Item = &'p Point>) -> Bounds {
    let empty = (Point::from(Vector::repeat(f64::INFINITY)), Point::from(Vector::repeat(f64::NEG_INFINITY)));
    points.fold(empty, |(low, high), p| (low.inf(p), high.sup(p)))
}

/// Where a way crosses a triangle: the shares of its two sides, and that of the way.
fn crossed([a, b, c]: [Point; 3], path: &Path) -> Option<[f64; 3]> {
    let system = Matrix3::from_columns(&[b - a, c - a, path.from - path.to]);
    let found = system.lu().solve(&(path.from - a))?;
    let [s, t, share] = [found.x, found.y, found.z];
    // What is not a number is not inside.
    let inside = s >= 0.0 && t >= 0.0 && s + t <= 1.0 && (0.0..=1.0).contains(&share);
    inside.then_some([s, t, share])
}

/// The same on the surface, by Newton's method from a place of its triangles.
fn settled(
    surface: &Surface,
    path: &Path,
    [mut u, mut v]: [f64; 2],
    mut share: f64,
    size: f64,
) -> Option<([f64; 2], f64)> {
    let way = path.to - path.from;
    let ((a, b), (c, d)) = (surface.u().domain(), surface.v().domain());
    let mut jet = [Vector::zeros(); 4];
    for _ in 0..ITERATIONS {
        surface.derivatives_into(u, v, [1, 1], &mut jet).ok()?;
        let off = Point::from(jet[0]) - (path.from + way * share);
        if off.norm() <= FOUND * size {
            return (0.0..=1.0).contains(&share).then_some(([u, v], share));
        }
        let step = Matrix3::from_columns(&[jet[2], jet[1], -way]).lu().solve(&-off)?;
        (u, v, share) = ((u + step.x).clamp(a, b), (v + step.y).clamp(c, d), share + step.z);
    }
    None
}
