//! Where the cage is a grid, the surface is a bicubic spline.

use loftsman_kernel::Point;
use loftsman_kernel::shape::Stencil;
use loftsman_kernel::space::Space;
use loftsman_kernel::spline::Surface;

use super::limit::check_uniform;
use crate::cage::{Cage, present};
use crate::error::Result;
use crate::row::Row;
use crate::topology::{NONE, Topology};

/// The bicubic piece of the surface over a face: a uniform B-spline patch of 4 × 4 vertices, `u` and `v` in `[0, 1]` from the face's
/// first corner, `u` along its first edge. `None` where the face is [not regular](patch_stencils).
///
/// # Errors
/// When there is no such face; when knot intervals differ; when a coordinate overflows.
pub fn patch(cage: &Cage, face: usize) -> Result<Option<Surface>> {
    let Some(stencils) = patch_stencils(cage, face)? else { return Ok(None) };
    let points = stencils.iter().map(|stencil| Point::from(stencil.apply(cage.points()))).collect();
    let space = Space::floating_uniform(3, 4)?;
    Ok(Some(Surface::new(space.clone(), space, points)?))
}

/// The rows of the 16 vertices of a [`patch`], `u` after `u`: those of the face in the middle. `None` where the face is not regular.
///
/// Regular is a quad at each of whose corners nothing is sharp and four quads meet; or, on the boundary, two, or one at a corner that
/// stays. Beyond the boundary the net is mirrored in it, `2 P - P'`, which is what makes the boundary a spline of its own vertices.
///
/// # Errors
/// When there is no such face; when knot intervals differ.
pub fn patch_stencils(cage: &Cage, face: usize) -> Result<Option<[Stencil; 16]>> {
    let topology = cage.topology();
    present("face", face, topology.face_count())?;
    check_uniform(cage)?;
    let corners = topology.face_corners(face);
    if corners.len() != 4 {
        return Ok(None);
    }
    // Of each corner: its place in the net, and the steps along the edge that follows and away along the one before.
    const PLACES: [([isize; 2], [isize; 2], [isize; 2]); 4] = [
        ([1, 1], [1, 0], [0, 1]),
        ([2, 1], [0, 1], [-1, 0]),
        ([2, 2], [-1, 0], [0, -1]),
        ([1, 2], [0, -1], [1, 0]),
    ];
    let mut net: [Stencil; 16] = std::array::from_fn(|_| Stencil::new());
    for (half, (at, a, b)) in corners.zip(PLACES) {
        let Some(corner) = Corner::new(cage, half as u32) else { return Ok(None) };
        let Corner { own, back_a, back_b, diagonal } = corner;
        for (row, back) in [(own, [0, 0]), (back_a, [1, 0]), (back_b, [0, 1]), (diagonal, [1, 1])] {
            let [i, j] = [0, 1].map(|k| (at[k] - back[0] * a[k] - back[1] * b[k]) as usize);
            net[4 * i + j] = row.into_stencil();
        }
    }
    Ok(Some(net))
}

/// What lies behind a corner of a face: seen from the face, beyond the vertex along the edge that follows, along the one before, and
/// across.
struct Corner {
    own: Row,
    back_a: Row,
    back_b: Row,
    diagonal: Row,
}

impl Corner {
    /// `None` where the vertex is not regular.
    fn new(cage: &Cage, half: u32) -> Option<Self> {
        let topology = cage.topology();
        let vertex = topology.origin(half) as usize;
        let boundary = topology.is_boundary_vertex(vertex);
        let mut faces = 0;
        for h in topology.around(vertex) {
            faces += 1;
            let face = topology.face_of(h) as usize;
            if faces > 4 || topology.face_corners(face).len() != 4 || cage.crease_inside(topology.edge_of(h))
            {
                return None;
            }
        }
        let at = |v: u32| Row(vec![(v, 1.0)]);
        let own = at(vertex as u32);
        let (along, before) = (end(topology, half), topology.origin(topology.previous(half)));
        match (boundary, faces) {
            (false, 4) if cage.corner(vertex) <= 0.0 => {
                let second = turn(topology, turn(topology, half));
                let third = turn(topology, second);
                let (back_a, back_b) = (at(end(topology, second)), at(end(topology, third)));
                Some(Self { own, back_a, back_b, diagonal: at(across(topology, second)) })
            }
            (true, 2) if cage.corner(vertex) <= 0.0 => {
                let left = turn(topology, half);
                if left == NONE {
                    // The face is the second: its other neighbour lies to the right.
                    let right = topology.next(topology.twin(half));
                    let (back_a, back_b) = (mirrored(vertex as u32, along), at(end(topology, right)));
                    let diagonal = mirrored(end(topology, right), across(topology, right));
                    Some(Self { own, back_a, back_b, diagonal })
                } else {
                    let far = topology.origin(topology.previous(left));
                    let diagonal = mirrored(far, across(topology, left));
                    Some(Self { own, back_a: at(far), back_b: mirrored(vertex as u32, before), diagonal })
                }
            }
            (true, 1) if cage.vertex_sharpness(vertex) >= crate::INFINITELY_SHARP => {
                let v = vertex as u32;
                let diagonal =
                    Row(vec![(v, 4.0), (along, -2.0), (before, -2.0), (across(topology, half), 1.0)]);
                Some(Self { own, back_a: mirrored(v, along), back_b: mirrored(v, before), diagonal })
            }
            _ => None,
        }
    }
}

impl Cage {
    /// Whether an inner edge is sharp.
    fn crease_inside(&self, edge: u32) -> bool {
        self.crease(edge as usize) > 0.0 && !self.topology.is_boundary_edge(edge as usize)
    }
}

/// `2 P - P'`.
fn mirrored(point: u32, inside: u32) -> Row {
    Row(vec![(point, 2.0), (inside, -1.0)])
}

/// The next half-edge that leaves the same vertex, counterclockwise.
fn turn(topology: &Topology, half: u32) -> u32 {
    topology.twin(topology.previous(half))
}

/// The vertex at which a half-edge ends.
fn end(topology: &Topology, half: u32) -> u32 {
    topology.origin(topology.next(half))
}

/// The vertex across a quad.
fn across(topology: &Topology, half: u32) -> u32 {
    end(topology, topology.next(half))
}
