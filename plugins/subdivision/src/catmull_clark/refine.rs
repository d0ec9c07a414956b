//! One cage from another.

use std::sync::Arc;

use loftsman_kernel::{Point, Vector, parallel};

use super::weights::Weights;
use crate::cage::{Cage, decayed};
use crate::error::Result;
use crate::row::Sums;

/// The cage refined once: every face becomes as many quads as it has corners. Which vertex, edge and face comes from which is that of
/// [`Topology::split`](crate::Topology::split): face `h` is corner `h` of the parent.
///
/// Sharpness becomes one less, infinite stays; faces of a hole are holes. Knot intervals are halved; between the points of an edge and
/// of a face stands the mean of the halves on either side. End intervals, which are Doo-Sabin's, are left out. Cost: linear, in
/// parallel with the feature `parallel`.
///
/// # Errors
/// When 32 bits cannot count what would be there.
pub fn refine(cage: &Cage) -> Result<Cage> {
    let topology = Arc::new(cage.topology.split_deferred()?);
    let mut child = Cage {
        points: refined_points(cage),
        topology,
        creases: Vec::new(),
        corners: Vec::new(),
        holes: Vec::new(),
        intervals: Vec::new(),
        end_intervals: Vec::new(),
        boundary: cage.boundary,
    };
    if cage.creases.iter().any(|&s| decayed(s) > 0.0) {
        child.creases = cage.creases.iter().flat_map(|&s| [decayed(s); 2]).collect();
    }
    if cage.corners.iter().any(|&s| decayed(s) > 0.0) {
        child.corners = cage.corners.iter().map(|&s| decayed(s)).collect();
    }
    let old = cage.topology();
    if cage.holes.contains(&true) {
        child.holes = parallel::map(old.corner_count(), |h| cage.is_hole(old.face_of(h as u32) as usize));
    }
    if cage.has_intervals() {
        child.intervals = refined_intervals(cage);
    }
    Ok(child)
}

/// The cage refined so many times; those between are not kept. Cost: linear in the last, which has four times the faces for every
/// time: some 100 bytes a face.
///
/// # Errors
/// As for [`refine`].
pub fn refine_times(cage: &Cage, times: usize) -> Result<Cage> {
    let mut finest = cage.clone();
    for _ in 0..times {
        finest = refine(&finest)?;
    }
    Ok(finest)
}

/// The points of the cage refined once, without its topology.
pub(super) fn refined_points(cage: &Cage) -> Vec<Point> {
    let topology = cage.topology();
    let (vertices, edges) = (topology.vertex_count(), topology.edge_count());
    let weights = Weights::new(cage);
    let points = cage.points();
    let uniform = !cage.has_intervals();
    let faces = face_points(cage, &weights);
    parallel::map(vertices + edges + faces.len(), |k| {
        if k >= vertices + edges {
            return faces[k - vertices - edges];
        }
        let mut sums = Sums { points, faces: &faces, sum: Vector::zeros() };
        if k >= vertices && uniform && weights.is_smooth_edge(k - vertices) {
            return smooth_edge_point(cage, &faces, k - vertices);
        } else if k >= vertices {
            weights.edge(k - vertices, &mut sums);
        } else if uniform && weights.is_smooth(k) {
            return smooth_point(cage, &faces, k);
        } else {
            weights.vertex(k, &mut sums);
        }
        Point::from(sums.sum)
    })
}

/// The new points of all faces.
pub(super) fn face_points(cage: &Cage, weights: &Weights) -> Vec<Point> {
    let (topology, points, uniform) = (cage.topology(), cage.points(), !cage.has_intervals());
    parallel::map(topology.face_count(), |f| {
        let mut sum = Vector::zeros();
        if uniform {
            let corners = topology.face(f);
            for &v in corners {
                sum += points[v as usize].coords;
            }
            sum /= corners.len() as f64;
        } else {
            weights.face(f, |v, w| sum += points[v as usize].coords * w);
        }
        Point::from(sum)
    })
}

/// The new point of a smooth inner vertex of a uniform cage, in one pass round it.
#[inline]
fn smooth_point(cage: &Cage, faces: &[Point], vertex: usize) -> Point {
    let topology = cage.topology();
    let (mut sum, mut n) = (Vector::zeros(), 0.0);
    for half in topology.around(vertex) {
        sum += cage.points[topology.origin(topology.next(half)) as usize].coords
            + faces[topology.face_of(half) as usize].coords;
        n += 1.0;
    }
    Point::from(cage.points[vertex].coords * ((n - 2.0) / n) + sum / (n * n))
}

/// The new point of a smooth inner edge of a uniform cage: the mean of its ends and of its faces' points.
#[inline]
fn smooth_edge_point(cage: &Cage, faces: &[Point], edge: usize) -> Point {
    let topology = cage.topology();
    let [one, other] = topology.halves(edge);
    let [a, b] = [one, topology.next(one)].map(|half| cage.points[topology.origin(half) as usize].coords);
    let [left, right] = [one, other].map(|half| faces[topology.face_of(half) as usize].coords);
    Point::from((a + b + left + right) * 0.25)
}

/// The knot intervals of the cage refined once.
pub(crate) fn refined_intervals(cage: &Cage) -> Vec<f64> {
    let topology = cage.topology();
    let d = |half: u32| cage.interval(topology.edge_of(half) as usize);
    let halved = 2 * topology.edge_count();
    parallel::map(halved + topology.corner_count(), |k| {
        if k < halved {
            return cage.interval(k / 2) / 2.0;
        }
        let half = (k - halved) as u32;
        (d(topology.previous(half)) + d(topology.next(half))) / 4.0
    })
}
