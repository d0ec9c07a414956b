//! How far a surface is from triangles between limits of vertices, as found in the middles of their edges and faces.

use loftsman_kernel::Point;

use super::triangle::{from_segment, from_triangle};
use crate::cage::Cage;

/// The largest distance of the limits of the middles of edges and faces, which are vertices of the next level, from the triangles
/// that they are the middles of.
pub(super) fn sampled(cage: &Cage, limits: &[Point], finer: &[Point]) -> f64 {
    let topology = cage.topology();
    let (vertices, edges) = (topology.vertex_count(), topology.edge_count());
    let mut most: f64 = 0.0;
    for face in (0..topology.face_count()).filter(|&f| !cage.is_hole(f)) {
        let corners = topology.face(face);
        let corner = |k: usize| limits[corners[k % corners.len()] as usize];
        for (k, &edge) in topology.face_edges(face).iter().enumerate() {
            most = most.max(from_segment(&finer[vertices + edge as usize], &corner(k), &corner(k + 1)));
        }
        let middle = &finer[vertices + edges + face];
        let triangles = (1..corners.len() - 1).map(|k| [corner(0), corner(k), corner(k + 1)]);
        most = most.max(triangles.map(|t| from_triangle(middle, &t)).fold(f64::INFINITY, f64::min));
    }
    most
}
