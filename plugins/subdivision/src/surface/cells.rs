//! The bicubic pieces of a surface.

use loftsman_kernel::shape::{Cell, CellSide, Cells};

use super::SubdivisionSurface;
use super::leaf::leaf;

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
}
