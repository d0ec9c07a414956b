//! How far a face of a surface is from its two triangles, as found in the middles of its edges and in its own.

use loftsman_kernel::Point;
use loftsman_kernel::mesh::distance::{from_segment, from_triangle};

/// The largest distance of the limits of the middles of the edges from the segments between the corners, and of that of the face from the
/// triangles. `at` are corners, middles of edges and the face's own.
pub(super) fn sampled(at: &[Point; 9]) -> f64 {
    let edges = (0..4).map(|k| from_segment(&at[4 + k], &at[k], &at[(k + 1) % 4]));
    let triangles = [[0, 1, 2], [0, 2, 3]].map(|t| from_triangle(&at[8], &t.map(|k: usize| at[k])));
    edges.fold(triangles[0].min(triangles[1]), f64::max)
}
