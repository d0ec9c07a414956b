//! The operations that edit: `edit` and `drag` under constraints, and the small ones that change how a shape is
//! represented or where it is (`refine`, `elevate`, `simplify`, `reverse`, `split`, `untrim`, `transform`, `tessellate`,
//! `tube`, `copy`, `delete`, `rename`).
//!
//! [`Editing`] registers them, with the kernel's functionals and solvers.

mod away;
mod cut;
mod drag;
mod edit;
mod furthest;
mod passages;
mod paths;
mod problem;
mod representation;
mod scene;
mod simplify;
mod tessellate;
mod transform;
mod tube;

use loftsman_kernel::plugin::{Plugin, Registry};
use loftsman_kernel::solve::{Adjoint, Automatic, DenseLu, HouseholderQr, SaddlePoint, Sparse};

pub use cut::{Reverse, Split};
pub use drag::Drag;
pub use edit::EditOperation;
pub use representation::{Elevate, Refine, Untrim};
pub use scene::{Delete, Duplicate, Rename};
pub use simplify::Simplify;
pub use tessellate::Tessellate;
pub use transform::Transform;
pub use tube::Tube;

/// The plug-in: the operations of this crate, the functionals and the solvers of the kernel.
#[derive(Debug, Clone, Copy, Default)]
pub struct Editing;

impl Plugin for Editing {
    fn register(&self, registry: &mut Registry) {
        loftsman_kernel::plugin::register_functionals(registry);
        registry.solver(Automatic);
        registry.solver(Adjoint);
        registry.solver(Sparse);
        registry.solver(HouseholderQr);
        registry.solver(SaddlePoint);
        registry.solver(DenseLu);
        registry.operation(EditOperation);
        registry.operation(Drag);
        registry.operation(Refine);
        registry.operation(Elevate);
        registry.operation(Simplify);
        registry.operation(Reverse);
        registry.operation(Split);
        registry.operation(Untrim);
        registry.operation(Transform);
        registry.operation(Tessellate);
        registry.operation(Tube);
        registry.operation(Duplicate);
        registry.operation(Delete);
        registry.operation(Rename);
    }
}
