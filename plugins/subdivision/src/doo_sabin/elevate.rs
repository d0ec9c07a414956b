//! The bicubic cage of a biquadratic surface.

use std::f64::consts::TAU;

use loftsman_kernel::{Point, Vector, parallel};

use super::limit::check_uniform;
use super::refine::{dual, waves};
use crate::cage::Cage;
use crate::error::Result;
use crate::topology::{NONE, Topology};

/// The cage of the same surface for Catmull-Clark refinement by knot intervals: each knot line of the biquadratic surface becomes two, so
/// that intervals are 0 across them (round each face of the cage) and 1 between them.
///
/// Vertices and faces are those of [`refine`](super::refine): corner `h` becomes vertex `h`; then come the faces of faces, of inner
/// edges and of inner vertices. On a grid a curve of the polygon `Q` has the control vertices `(Q₋ + 5 Q)/6` and `(5 Q + Q₊)/6`, which
/// makes it the same curve; a quad's corner has their tensor product. A face of `n` corners is taken apart into its middle, its first
/// waves, and, where `n` is even, what alternates from corner to corner; of these a corner keeps 1, 2/3 and 4/9, as on a quad, and of
/// what else there is nothing, for only then the surface has a tangent plane in the middle of the face. Along the boundary control
/// vertices are on the outermost knot line, so that the surface of a grid ends where Doo and Sabin's does.
///
/// *What is kept.* Over an inner vertex of four quads the surface is Doo and Sabin's, exactly. In the middle of any face none of whose
/// vertices is on the boundary so are point and tangent plane. Near faces and vertices of another number, and on the boundary near faces
/// that are no quads, it is a surface nearby. Cost: linear.
///
/// # Errors
/// When end intervals differ, for then it is of other knots; when 32 bits cannot count what would be there.
pub fn elevated(cage: &Cage) -> Result<Cage> {
    check_uniform(cage)?;
    let old = cage.topology();
    let points: Vec<Point> = parallel::map(old.face_count(), |face| of_face(cage, face)).concat();
    let topology = dual(old)?;
    let mut child = Cage::from_topology(points, topology.into())?;
    child.boundary = cage.boundary();
    if cage.holes.contains(&true) {
        child.holes = cage.holes.clone();
    }
    let crosses = |edge: usize| {
        let [a, b] = child.topology().ends(edge);
        old.next(a) == b || old.next(b) == a
    };
    child.intervals =
        (0..child.topology().edge_count()).map(|edge| if crosses(edge) { 0.0 } else { 1.0 }).collect();
    Ok(child)
}

/// What of a face its corners keep when it becomes bicubic: its middle, so much of its first waves and so much of what alternates.
struct Shares {
    wave: f64,
    alternating: f64,
}

/// The corners of a face with no more than these shares of it.
fn corners(cage: &Cage, face: usize, shares: &Shares) -> Vec<Vector> {
    let vertices = cage.topology().face(face);
    let n = vertices.len() as f64;
    let [centre, cosines, sines] = waves(cage, face, &Point::origin());
    let sign = |i: usize| if i.is_multiple_of(2) { 1.0 } else { -1.0 };
    let mut alternating = Vector::zeros();
    if vertices.len().is_multiple_of(2) {
        let arm = |(i, &v): (usize, &u32)| (cage.points()[v as usize].coords - centre) * sign(i);
        alternating = vertices.iter().enumerate().map(arm).sum::<Vector>() / n;
    }
    let corner = |i: usize| {
        let (sin, cos) = (TAU * i as f64 / n).sin_cos();
        let wave = (cosines * cos + sines * sin) * (2.0 / n);
        centre + wave * shares.wave + alternating * (sign(i) * shares.alternating)
    };
    (0..vertices.len()).map(corner).collect()
}

/// Takes out of a face of an elevated cage what keeps the surface from having a tangent plane in its middle: nothing but of faces of five
/// corners and more.
pub(super) fn settle(cage: &mut Cage, face: usize) {
    let vertices = cage.topology().face(face).to_vec();
    if vertices.len() > 4 {
        let settled = corners(cage, face, &Shares { wave: 1.0, alternating: 1.0 });
        vertices.iter().zip(settled).for_each(|(&v, p)| cage.points[v as usize] = Point::from(p));
    }
}

/// The new points of a face's corners.
fn of_face(cage: &Cage, face: usize) -> Vec<Point> {
    let topology = cage.topology();
    let all = corners(cage, face, &Shares { wave: 2.0 / 3.0, alternating: 4.0 / 9.0 });
    let count = all.len();
    let centre = all.iter().sum::<Vector>() / count as f64;
    let inner = |i: usize| all[i];
    let first = topology.face_corners(face).start;
    let corner = |i: usize| {
        let half = (first + i) as u32;
        let own = inner(i);
        // On the boundary: from the middle half the way from the knot line across at the edge's other end to that at this one.
        let side = |a: usize, b: usize| inner(a % count) + inner(b % count);
        let along = |to: Vector, from: Vector| centre + (to - from) * 0.25;
        Point::from(match ends(topology, half) {
            [false, false] => own,
            [true, false] => along(side(i, i + count - 1), side(i + 1, i + 2)),
            [false, true] => along(side(i, i + 1), side(i + count - 1, i + count - 2)),
            [true, true] => centre,
        })
    };
    (0..count).map(corner).collect()
}

/// Whether the edges of a corner are on the boundary: the one that follows, and the one before.
pub(super) fn ends(topology: &Topology, half: u32) -> [bool; 2] {
    [half, topology.previous(half)].map(|h| topology.twin(h) == NONE)
}
