//! Which surfaces look the other way than those beside them, so that the sign of their curvature changes where they meet.

use std::collections::{BTreeMap, VecDeque};

use loftsman_kernel::shape::{Location, Shape};
use loftsman_kernel::spline::Surface;
use loftsman_kernel::topology::{CommonEdges, SAMPLES};
use loftsman_kernel::{Point, Vector};

/// Edges are one where they are no further apart than this part of what is drawn.
const NEAR: f64 = 1e-3;
/// The cosine of the angle beyond which surfaces do not go on in one another.
const SMOOTH: f64 = 0.5;

/// An edge at some of its points, and its surface's normal in its middle.
struct Side {
    owner: usize,
    points: [Point; SAMPLES],
    normal: Vector,
}

/// The surfaces whose normals point to the other side than those of most that hang together with them by smooth common edges, of as many those
/// that come later. `O(n log n)` edges, those apart that have their middles at one place.
pub(super) fn turned(surfaces: &[&Surface]) -> Vec<usize> {
    let points = || surfaces.iter().flat_map(|surface| surface.points());
    let Some(first) = points().next() else { return Vec::new() };
    let (low, high) = points().fold((*first, *first), |(low, high), p| (low.inf(p), high.sup(p)));
    let near = NEAR * (high - low).amax();
    if !(near > 0.0 && near.is_finite()) {
        return Vec::new();
    }
    let mut places: BTreeMap<[i64; 3], Vec<Side>> = BTreeMap::new();
    // Who is beside whom, and whether both look the same way.
    let mut beside: Vec<Vec<(usize, bool)>> = vec![Vec::new(); surfaces.len()];
    for (owner, surface) in surfaces.iter().enumerate() {
        for side in sides(owner, surface, near) {
            let middle = side.points[SAMPLES / 2];
            let cell = |shift: f64| [0, 1, 2].map(|k| ((middle[k] + shift) / (16.0 * near)).floor() as i64);
            let (below, above) = (cell(-near), cell(near));
            let mut keys: Vec<[i64; 3]> = (0..8)
                .map(|corner| [0, 1, 2].map(|k| if corner >> k & 1 == 0 { below[k] } else { above[k] }))
                .collect();
            keys.sort_unstable();
            keys.dedup();
            let found = keys.iter().filter_map(|key| places.get(key)).flatten();
            let found = found.filter(|other| other.owner != owner && is_one(&side, other, near)).take(1);
            for other in found {
                let along = side.normal.dot(&other.normal);
                if along.abs() > SMOOTH {
                    beside[owner].push((other.owner, along > 0.0));
                    beside[other.owner].push((owner, along > 0.0));
                }
            }
            places.entry(cell(0.0)).or_default().push(side);
        }
    }
    against(&beside)
}

/// Those that look against most of their group.
fn against(beside: &[Vec<(usize, bool)>]) -> Vec<usize> {
    let mut way: Vec<Option<bool>> = vec![None; beside.len()];
    let mut turned = Vec::new();
    for first in 0..beside.len() {
        if way[first].is_some() {
            continue;
        }
        way[first] = Some(true);
        let (mut group, mut next) = (vec![first], VecDeque::from([(first, true)]));
        while let Some((k, here)) = next.pop_front() {
            for &(other, same) in &beside[k] {
                if way[other].is_none() {
                    let there = here == same;
                    way[other] = Some(there);
                    group.push(other);
                    next.push_back((other, there));
                }
            }
        }
        let with = group.iter().filter(|k| way[**k] == Some(true)).count();
        let most = 2 * with >= group.len();
        turned.extend(group.into_iter().filter(|k| way[*k] != Some(most)));
    }
    turned.sort_unstable();
    turned
}

/// A surface's edges that are no points, where they have a normal in their middle.
fn sides(owner: usize, surface: &Surface, near: f64) -> Vec<Side> {
    let Some(edges) = surface.edges() else { return Vec::new() };
    let point = |at: Location| match at {
        Location::Surface(u, v) => surface.point(u, v).ok(),
        _ => None,
    };
    let Some(all) = CommonEdges::sampled(edges, &point) else { return Vec::new() };
    let sides = edges.iter().zip(all).filter_map(|(edge, points)| {
        let Location::Surface(u, v) = edge.at(0.5 * edge.start + 0.5 * edge.end) else { return None };
        let normal = surface.normal(u, v).ok()?.vector()?;
        let is_point = points.iter().all(|p| (p - points[0]).norm() <= near);
        (!is_point).then_some(Side { owner, points, normal })
    });
    sides.collect()
}

fn is_one(side: &Side, other: &Side, near: f64) -> bool {
    let together = |(a, b): (&Point, &Point)| (a - b).norm() <= near;
    side.points.iter().zip(&other.points).all(together)
        || side.points.iter().zip(other.points.iter().rev()).all(together)
}
