//! The boundary of a Doo-Sabin surface.

use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::shape::{BoundaryEdge, Edges, Strip};

use super::{DooSabinSurface, kind};

/// The sides of faces that have nothing beyond them. The name of one is that of its face and its side, `"12 v=0"`.
impl Edges for DooSabinSurface {
    fn count(&self) -> usize {
        self.layout.edges.len()
    }

    fn edge(&self, index: usize) -> Option<BoundaryEdge> {
        let &(face, side) = self.layout.edges.get(index)?;
        let at_end = matches!(side, 1 | 2);
        let name = ["v=0", "u=1", "v=1", "u=0"].get(usize::from(side))?;
        Some(BoundaryEdge {
            name: format!("{face} {name}").into(),
            face: Some(face),
            along_u: side.is_multiple_of(2),
            start: 0.0,
            end: 1.0,
            periodic: false,
            fixed: if at_end { 1.0 } else { 0.0 },
            at_end,
        })
    }

    /// From the cells along it, but where it ends at an extraordinary point and they are without number.
    fn strips(&self, index: usize, _: usize) -> Option<Result<Vec<Strip>>> {
        let &(face, side) = self.layout.edges.get(index)?;
        let edge = self.edge(index)?;
        let kind = kind(&self.cage, *self.layout.corners.get(face as usize)?);
        // Sides 0 and 3 begin at the middle of the cage's face, 1 and 2 end at its vertex.
        let ends = kind & if matches!(side, 0 | 3) { 1 } else { 2 } != 0;
        ends.then(|| {
            Err(Error::Invalid(format!(
                "{} ends at an extraordinary point, with pieces without number along it: join places of it one by one, or refine the cage and \
                 join the half away from that point",
                edge.called()
            )))
        })
    }
}
