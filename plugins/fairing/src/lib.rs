//! Fair shapes: the least energy that meets what is asked.
//!
//! `min ‖A P - r‖²` subject to `F P = b`: the squares are integrals of derivatives (stretch, bend, variation), distances from
//! the old shape or from points, and any weighted sum of them ([`Energy`]); the constraints are all linear functionals of
//! the kernel and of other plug-ins. [`Fair`] says and does it; in recipes it is the operation `fair` ([`FairOperation`]),
//! brought by the plug-in [`Fairing`].
//!
//! Bounds (`at_least`, `at_most`) are met by an active set that the conditions of Karush, Kuhn and Tucker confirm; a distance from the old
//! shape by tethers, with a certified gap.
//!
//! The search is one of projected conjugate gradients with an envelope Cholesky factor as preconditioner: work is linear in the control
//! vertices of a curve. Energies that do not see some motions (a stretched line may be anywhere, a bent one anywhere and
//! as steep as it likes) need no care: what neither energy nor constraints say anything about stays as near as it can.

mod bounds;
mod energy;
mod fair;
mod idle;
mod minimise;
mod operation;
mod precondition;
mod squares;
mod within;

use loftsman_kernel::plugin::{Plugin, Registry};

pub use energy::{Datum, Energy, bend, data, near, stretch, variation};
pub use fair::{Fair, FairReport, Fairer};
pub use operation::FairOperation;

/// The plug-in: registers the operation `fair`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Fairing;

impl Plugin for Fairing {
    fn register(&self, registry: &mut Registry) {
        registry.operation(FairOperation);
    }
}
