//! Fair shapes: the least energy that meets what is asked.
//!
//! `min ‖A P - r‖²` subject to `F P = b`: the squares are integrals of derivatives (stretch, bend, variation), distances from
//! the old shape or from points, and any weighted sum of them ([`EnergySum`]); the constraints are all linear functionals of
//! the kernel and of other plug-ins. [`Fair`] says and does it; in recipes it is the operation `fair` ([`FairOperation`]),
//! brought by the plug-in [`Fairing`]. An edit can make the same energies least while it is dragged
//! ([`Edit::minimise`](loftsman_kernel::edit::Edit::minimise)), with any solver, where the energy sees every motion.
//!
//! An energy looks within the spans of a spline only. Where its knots let corners appear and it has none (Bézier chains, exact
//! circles and revolutions, closed seams), what is smooth is kept by the equations that an edit keeps it by, unless
//! [`Fair::smooth`] says otherwise.
//!
//! Bounds (`at_least`, `at_most`) are met by proximal steps, each a strictly convex program that a dual active-set method solves,
//! and sharpened until the conditions of Karush, Kuhn and Tucker confirm the answer; bounds that contradict each other are
//! named. A distance from the old shape is kept by tethers or, where they only creep, by planes: both with a certified gap.
//!
//! The search under equations is one of projected conjugate gradients with an envelope Cholesky factor as preconditioner: work is
//! linear in the control vertices of a curve. Energies that do not see some motions (a stretched line may be anywhere, a
//! bent one anywhere and as steep as it likes, and where knots are so many that pieces hang on a point, each piece for itself)
//! need no care: these motions are found, and what neither energy nor constraints say anything about stays as near as it can.
//!
//! Whatever was found is measured afresh on the shape that is handed out: every equation, every bound, how far it went,
//! and that the energy is not more than it was.

mod active;
mod between;
mod bounds;
mod convex;
mod damped;
mod energy;
mod fair;
mod form;
mod inside;
mod integrals;
mod minimise;
mod null_space;
mod operation;
mod orthogonal;
mod precondition;
mod problem;
mod solve;
mod squares;
mod within;

use loftsman_kernel::plugin::{Plugin, Registry};

pub use energy::{Datum, EnergySum, bend, data, near, stretch, variation};
pub use fair::{Fair, FairReport, Faired};
pub use operation::FairOperation;

/// The plug-in: registers the operation `fair`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Fairing;

impl Plugin for Fairing {
    fn register(&self, registry: &mut Registry) {
        registry.operation(FairOperation);
    }
}
