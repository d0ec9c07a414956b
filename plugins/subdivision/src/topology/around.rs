//! Round a vertex.

use super::{NONE, Pairing, Topology};

/// The half-edges that leave a vertex, counterclockwise: of a boundary vertex from the boundary edge on its right side to the
/// last that has a face; of an inner one once round.
#[derive(Debug, Clone)]
pub struct Around<'a> {
    topology: &'a Topology,
    pairing: &'a Pairing,
    first: u32,
    next: u32,
}

impl Iterator for Around<'_> {
    type Item = u32;

    #[inline]
    fn next(&mut self) -> Option<u32> {
        if self.next == NONE {
            return None;
        }
        let half = self.next;
        let next = self.pairing.twin(self.topology.previous(half));
        self.next = if next == self.first { NONE } else { next };
        Some(half)
    }
}

impl Topology {
    /// The half-edges that leave a vertex, counterclockwise: one for each face there. Nothing for a vertex that is not there.
    #[inline]
    pub fn around(&self, vertex: usize) -> Around<'_> {
        let pairing = self.pairing();
        let first = pairing.leaving.get(vertex).copied().unwrap_or(NONE);
        Around { topology: self, pairing, first, next: first }
    }

    /// The faces at a vertex, counterclockwise: face `i` lies between edges `i` and `i + 1` of
    /// [`vertex_edges`](Self::vertex_edges).
    pub fn vertex_faces(&self, vertex: usize) -> impl Iterator<Item = u32> + '_ {
        self.around(vertex).map(|h| self.face_of(h))
    }

    /// The edges at a vertex, counterclockwise; of a boundary vertex from one boundary edge to the other.
    pub fn vertex_edges(&self, vertex: usize) -> impl Iterator<Item = u32> + '_ {
        let mut last = None;
        let mut around = self.around(vertex);
        let boundary = self.is_boundary_vertex(vertex);
        std::iter::from_fn(move || match around.next() {
            Some(half) => {
                last = Some(half);
                Some(self.edge_of(half))
            }
            None => last.take().filter(|_| boundary).map(|half| self.edge_of(self.previous(half))),
        })
    }
}
