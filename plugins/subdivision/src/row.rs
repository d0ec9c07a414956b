//! Sums over vertices: of points, or of the coefficients that a point has.

use loftsman_kernel::shape::Stencil;
use loftsman_kernel::{Point, Vector};

/// What a rule adds up: multiples of vertices and of the new points of faces.
pub(crate) trait Sum {
    /// Adds a multiple of a vertex.
    fn vertex(&mut self, vertex: u32, weight: f64);
    /// Adds a multiple of the new point of a face.
    fn face(&mut self, face: u32, weight: f64);
}

/// The sum itself.
pub(crate) struct Sums<'a> {
    pub(crate) points: &'a [Point],
    pub(crate) faces: &'a [Point],
    pub(crate) sum: Vector,
}

impl Sum for Sums<'_> {
    #[inline]
    fn vertex(&mut self, vertex: u32, weight: f64) {
        self.sum += self.points[vertex as usize].coords * weight;
    }

    #[inline]
    fn face(&mut self, face: u32, weight: f64) {
        self.sum += self.faces[face as usize].coords * weight;
    }
}

/// Coefficients of vertices, in any order and with repetitions until it is [`tidied`](Self::tidy).
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Row(pub(crate) Vec<(u32, f64)>);

impl Row {
    pub(crate) fn add(&mut self, vertex: u32, weight: f64) {
        if weight != 0.0 {
            self.0.push((vertex, weight));
        }
    }

    /// Brings the vertices in order, each once. The order of sums is that in which they were added, so that it is always the same.
    pub(crate) fn tidy(&mut self) {
        self.0.sort_by_key(|(vertex, _)| *vertex);
        self.0.dedup_by(|next, kept| {
            let same = next.0 == kept.0;
            kept.1 += if same { next.1 } else { 0.0 };
            same
        });
    }

    pub(crate) fn into_stencil(mut self) -> Stencil {
        self.tidy();
        self.0.into_iter().map(|(vertex, weight)| (vertex as usize, weight)).collect()
    }
}
