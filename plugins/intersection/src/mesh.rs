//! Sections of meshes by planes.

use std::collections::{BTreeMap, BTreeSet};

use loftsman_kernel::Point;
use loftsman_kernel::mesh::{Mesh, Polyline};

use crate::intersections::Plane;

/// The section of a mesh by a plane: polylines from face to face, closed where the mesh goes all round.
///
/// A vertex on the plane counts as above it, so that each face is crossed at an even number of edges and what lies in
/// the plane is bounded by its lower neighbours; where nothing lies below, as below it. Where the plane passes a vertex the section has that vertex, to the last
/// bit. A face that bends is cut along its edges only. Points in one place are one, as files that keep normals by point have several of. `O(n log n)`.
pub fn mesh_section(mesh: &Mesh, plane: &Plane) -> Vec<Polyline> {
    let points = mesh.points();
    let mut distances: Vec<f64> = points.iter().map(|p| plane.distance(p)).collect();
    if distances.iter().all(|d| *d >= 0.0) {
        distances.iter_mut().for_each(|d| *d = -*d);
    }
    let same = mesh.welded();
    // The edges that are crossed, and which of them each is joined to by a face.
    let mut joined: BTreeMap<(u32, u32), Vec<(u32, u32)>> = BTreeMap::new();
    for face in mesh.faces() {
        let mut crossed: Vec<(u32, u32)> = Vec::new();
        for (k, &a) in face.iter().enumerate() {
            let b = face[(k + 1) % face.len()];
            if (distances[a as usize] < 0.0) != (distances[b as usize] < 0.0) {
                let (a, b) = (same[a as usize], same[b as usize]);
                crossed.push((a.min(b), a.max(b)));
            }
        }
        if crossed.len() > 2 {
            // Along the line, first with second, third with fourth: what is inside a face that is not convex.
            let at = |e: &(u32, u32)| crossing(points, &distances, *e);
            let spread = at(&crossed[crossed.len() - 1]) - at(&crossed[0]);
            crossed.sort_by(|x, y| at(x).coords.dot(&spread).total_cmp(&at(y).coords.dot(&spread)));
        }
        for pair in crossed.chunks_exact(2) {
            joined.entry(pair[0]).or_default().push(pair[1]);
            joined.entry(pair[1]).or_default().push(pair[0]);
        }
    }
    // Open lines from their ends first, then the loops. Where more than two faces share an edge, lines end there.
    let ends: Vec<_> = joined.iter().filter(|(_, next)| next.len() != 2).map(|(e, _)| *e).collect();
    let all: Vec<_> = joined.keys().copied().collect();
    let mut lines = Vec::new();
    for start in ends.into_iter().chain(all) {
        while let Some(mut next) = joined.get_mut(&start).and_then(Vec::pop) {
            let mut line = vec![crossing(points, &distances, start)];
            let mut here = start;
            let closed = loop {
                if let Some(back) = joined.get_mut(&next)
                    && let Some(k) = back.iter().position(|e| *e == here)
                {
                    back.swap_remove(k);
                }
                if next == start {
                    break true;
                }
                line.push(crossing(points, &distances, next));
                here = next;
                let onward = joined.get_mut(&here).filter(|n| n.len() == 1).and_then(Vec::pop);
                let Some(onward) = onward else { break false };
                next = onward;
            };
            line.dedup();
            if closed && line.len() > 1 && line.first() == line.last() {
                line.pop();
            }
            if line.len() > 1 {
                lines.push(Polyline { points: line, closed });
            }
        }
    }
    lines
}

/// On which side of the plane what [`mesh_section`] cuts is, where a face of the mesh lies in the plane: whether just above it, where its normal points, or
/// just below. `None` where no face does. `O(n)`.
pub fn mesh_section_above(mesh: &Mesh, plane: &Plane) -> Option<bool> {
    let distances: Vec<f64> = mesh.points().iter().map(|p| plane.distance(p)).collect();
    let lies = mesh.faces().any(|face| face.iter().all(|&k| distances[k as usize] == 0.0));
    lies.then(|| distances.iter().all(|d| *d >= 0.0))
}

/// Where the loose lines of a mesh meet a plane.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LineMeetings {
    /// The points, along the lines; one where several lines meet there. Points on the plane are these, to the last bit.
    pub points: Vec<Point>,
    /// How many segments lie in the plane; their ends are not among the points.
    pub lying: usize,
}

/// Where the loose lines of a mesh meet a plane. Points in one place are one. `O(n log n)`.
pub fn mesh_lines_section(mesh: &Mesh, plane: &Plane) -> LineMeetings {
    let mut found = LineMeetings::default();
    if mesh.lines().next().is_none() {
        return found;
    }
    let (points, same) = (mesh.points(), mesh.welded());
    let distances: Vec<f64> = points.iter().map(|p| plane.distance(p)).collect();
    let on = |k: u32| distances[k as usize] == 0.0;
    let segments = || mesh.lines().flat_map(|line| line.windows(2)).map(|w| [w[0], w[1]]);
    let mut along = BTreeSet::new();
    for ends in segments().filter(|ends| ends.iter().all(|&k| on(k))) {
        along.extend(ends.map(|k| same[k as usize]));
        found.lying += 1;
    }
    let mut known = BTreeSet::new();
    for [a, b] in segments() {
        let (p, q) = (same[a as usize], same[b as usize]);
        let place = match (on(a), on(b)) {
            (true, true) => continue,
            (true, false) => (p, p),
            (false, true) => (q, q),
            _ if (distances[a as usize] < 0.0) != (distances[b as usize] < 0.0) => (p.min(q), p.max(q)),
            _ => continue,
        };
        if !(place.0 == place.1 && along.contains(&place.0)) && known.insert(place) {
            found.points.push(crossing(points, &distances, place));
        }
    }
    found
}

/// The area inside the loops of a mesh's section, what an even number of them goes around left out; `None` where a line does not
/// close or there is none. `O(l n)` for `l` loops of `n` points.
pub fn mesh_section_area(lines: &[Polyline], plane: &Plane) -> Option<f64> {
    if lines.is_empty() || !lines.iter().all(|line| line.closed) {
        return None;
    }
    // In the plane, by the two coordinates in which it is widest.
    let normal = plane.normal();
    let across = normal.iamax();
    let flat = |p: &Point| [p[(across + 1) % 3], p[(across + 2) % 3]];
    let loops: Vec<Vec<[f64; 2]>> = lines.iter().map(|line| line.points.iter().map(flat).collect()).collect();
    let doubled = |points: &[[f64; 2]]| -> f64 {
        let [x, y] = points[0];
        let turned = |(p, q): (&[f64; 2], &[f64; 2])| (p[0] - x) * (q[1] - y) - (p[1] - y) * (q[0] - x);
        points.iter().zip(points.iter().skip(1)).map(turned).sum()
    };
    let own: Vec<f64> = loops.iter().map(|points| 0.5 * doubled(points) / normal[across]).collect();
    Some(nested(&loops, &own))
}

/// The area inside loops, given as polygons and by the area of each, where what an even number of them goes around is left out. `O(l n)` for
/// `l` loops of `n` points.
pub(crate) fn nested(loops: &[Vec<[f64; 2]>], own: &[f64]) -> f64 {
    let holds = |points: &[[f64; 2]], [x, y]: [f64; 2]| {
        let next = points.iter().cycle().skip(1);
        let passed = points.iter().zip(next).filter(|(p, q)| {
            (p[1] > y) != (q[1] > y) && x < p[0] + (y - p[1]) / (q[1] - p[1]) * (q[0] - p[0])
        });
        passed.count() % 2 == 1
    };
    let mut sum = 0.0;
    for (k, (points, own)) in loops.iter().zip(own).enumerate() {
        // A place beside a vertex may be on another loop; the middle of a side seldom is.
        let [p, q] = match points[..] {
            [p, q, ..] => [p, q],
            _ => continue,
        };
        let middle = [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])];
        let around = loops.iter().enumerate().filter(|(j, other)| *j != k && holds(other, middle)).count();
        sum += if around % 2 == 0 { own.abs() } else { -own.abs() };
    }
    sum
}

/// Where an edge, given by its lesser end first, passes the plane.
fn crossing(points: &[Point], distances: &[f64], (a, b): (u32, u32)) -> Point {
    let (p, q) = (points[a as usize], points[b as usize]);
    let (d, e) = (distances[a as usize], distances[b as usize]);
    if d == 0.0 {
        return p;
    }
    if e == 0.0 {
        return q;
    }
    let share = d / (d - e);
    Point::from(p.coords * (1.0 - share) + q.coords * share)
}
