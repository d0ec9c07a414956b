//! Two points that must stay one.

use loftsman_kernel::functional::Shapes;
use loftsman_kernel::shape::Stencil;
use loftsman_kernel::{Result, Vector};

/// Two combinations of control vertices that are one point: `Σ a_i P_i - Σ b_j Q_j = 0`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Tie {
    pub(crate) first: (usize, Stencil),
    pub(crate) second: (usize, Stencil),
}

impl Tie {
    /// How far they are apart.
    pub(crate) fn gap(&self, shapes: &Shapes<'_>) -> Result<Vector> {
        let value = |(shape, stencil): &(usize, Stencil)| -> Result<Vector> {
            Ok(stencil.apply(shapes.get(*shape)?.control_vertices()))
        };
        Ok(value(&self.first)? - value(&self.second)?)
    }
}
