//! The bicubic pieces of a surface.

use std::ops::Range;

use loftsman_kernel::Point;
use loftsman_kernel::error::Result;
use loftsman_kernel::shape::{Cell, CellNet, CellSide, Cells, Chart, Hole, Location};

use super::SubdivisionSurface;
use super::leaf::leaf;
use crate::INFINITELY_SHARP;
use crate::natural::seen_from;
use crate::topology::NONE;

/// A regular face is one cell. Of another the quadrants of its levels are that are bicubic, down to the surface's
/// [depth](SubdivisionSurface::with_depth) below the last level on which anything is sharp to a finite degree; what is left out lies
/// round extraordinary vertices.
impl Cells for SubdivisionSurface {
    fn count(&self) -> usize {
        self.layout.cells.last().copied().unwrap_or(0)
    }

    fn cell(&self, index: usize) -> Option<Cell> {
        if index >= Cells::count(self) {
            return None;
        }
        // A face may have no cell: the last of those that start here has.
        let face = self.layout.cells.partition_point(|&first| first <= index).checked_sub(1)?;
        let quadrants = self.layout.quadrants.get(*self.layout.pattern_of.get(face)? as usize)?;
        let quadrant = *quadrants.get(index - self.layout.cells[face])?;
        let size = 0.5_f64.powi(quadrant.level as i32);
        let side = |k: u64| CellSide { start: k as f64 * size, end: (k + 1) as f64 * size, degree: 3 };
        let middle = |k: u64| (k as f64 + 0.5) * size;
        let place = (middle(quadrant.i), middle(quadrant.j));
        // Where a neighbourhood is too large for rows, the cell has no vertices, and whoever asks for rows there is told why.
        let vertices = match leaf(&self.cage, &self.layout, face, place, quadrant.level) {
            Ok(Some(leaf)) => leaf.vertices.iter().copied().collect(),
            _ => Default::default(),
        };
        let sides = [side(quadrant.i), side(quadrant.j)].into_iter().collect();
        Some(Cell { face: Some(face as u32), sides, rational: false, vertices })
    }

    /// The quadrants of the last level at extraordinary vertices. Neighbours may have them on different levels, for their own level is counted from
    /// where nothing on the face is sharp: then the larger one has the rest of their common side as border, too.
    fn holes(&self) -> Vec<Hole> {
        self.all_holes()
    }

    /// A limit surface has no gaps.
    fn always_meet(&self) -> bool {
        true
    }

    fn nets(
        &self,
        numbers: Range<usize>,
        origin: &Point,
        each: &mut dyn FnMut(CellNet<'_>),
    ) -> Option<Result<()>> {
        Some(self.nets_of(numbers, origin, each))
    }

    /// The characteristic map of the extraordinary vertex that is nearest, from the level on at which it is alone and nothing round it is sharp to a
    /// finite degree. Elsewhere, at creases and on the boundary, where the eigenvectors are none of a map that is smooth, and with knot intervals
    /// the parameters serve.
    fn chart(&self, at: Location) -> Option<Chart> {
        let Location::Face(face, u, v) = at else { return None };
        let pattern = self.layout.patterns.get(*self.layout.pattern_of.get(face as usize)? as usize)?;
        if self.cage.has_intervals() {
            return None;
        }
        let reach = 0.5_f64.powi(pattern.steps().max(1) as i32);
        let corner = (0..4).filter(|&k| pattern.corners[k].extraordinary).find(|&k| {
            let [a, b] = seen_from(k, [u, v]);
            a.max(b) <= reach
        })?;
        self.layout.naturals.chart(self.edges_at(face as usize, corner)?, corner, [u, v], reach)
    }
}

impl SubdivisionSurface {
    /// The number of edges of the vertex at a corner of a face where the surface is smooth round it, whatever is sharp to a finite degree.
    fn edges_at(&self, face: usize, corner: usize) -> Option<usize> {
        let topology = self.cage.topology();
        let [of, part] = *self.layout.faces.get(face)?;
        let corners = topology.face(of as usize);
        let vertex = match (part, corner) {
            (NONE, _) => *corners.get(corner)? as usize,
            (part, 0) => *corners.get(part as usize)? as usize,
            _ => return Some(corners.len()),
        };
        let sharp = |e: u32| self.cage.sharpness(e as usize) >= INFINITELY_SHARP;
        let is_smooth = !topology.is_boundary_vertex(vertex)
            && self.cage.vertex_sharpness(vertex) < INFINITELY_SHARP
            && !topology.vertex_edges(vertex).any(sharp);
        is_smooth.then(|| topology.around(vertex).count())
    }
}
