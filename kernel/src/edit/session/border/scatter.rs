//! Gradients of vertices as those of the columns that move.

use super::Moving;

/// Vertices without a column.
pub(super) struct Stray<'a> {
    pub(super) fixed: &'a [usize],
    pub(super) strayed: &'a mut Vec<usize>,
}

impl Stray<'_> {
    pub(super) fn add(&mut self, vertex: usize, influence: f64) {
        if influence != 0.0 && self.fixed.binary_search(&vertex).is_err() {
            self.strayed.push(vertex);
        }
    }
}

/// Adds gradients of vertices to those of columns.
pub(super) fn scatter(
    moving: &Moving,
    vertices: &[usize],
    vectors: &[crate::Vector],
    gradient: &mut [f64],
    stray: &mut Stray<'_>,
) {
    let run = match (vertices.first(), vertices.last()) {
        (Some(&a), Some(&b)) => vertices.len() == b.wrapping_sub(a).wrapping_add(1) && b >= a,
        _ => return,
    };
    // Neighbours in order, all of which move: no need to look each of them up.
    let start = moving.place(vertices[0]);
    if let (true, Some(start), Some(end)) = (run, start, moving.place(vertices[vertices.len() - 1]))
        && end - start + 1 == vertices.len()
        && vertices.is_sorted()
    {
        for (g, v) in gradient[3 * start..].chunks_exact_mut(3).zip(vectors) {
            g[0] += v.x;
            g[1] += v.y;
            g[2] += v.z;
        }
        return;
    }
    for (&vertex, vector) in vertices.iter().zip(vectors) {
        match moving.place(vertex) {
            Some(at) => (0..3).for_each(|axis| gradient[3 * at + axis] += vector[axis]),
            None => stray.add(vertex, vector.lp_norm(1)),
        }
    }
}
