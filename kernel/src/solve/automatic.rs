//! The default: the fastest solver that is safe for the system at hand.

use super::{Adjoint, Factored, HouseholderQr, SolveError, Solver, Sparse, System};

/// Chooses by size: [`Adjoint`] up to three equations, [`Sparse`] above; and [`HouseholderQr`] where they find the
/// system too ill-conditioned. [`Factored::solver`] says which one did the work.
#[derive(Debug, Clone, Copy, Default)]
pub struct Automatic;

impl Solver for Automatic {
    fn name(&self) -> &'static str {
        "automatic"
    }

    fn factor(&self, system: &System) -> Result<Box<dyn Factored>, SolveError> {
        let first: &dyn Solver = if system.rows().len() <= 3 { &Adjoint } else { &Sparse };
        match first.factor(system) {
            Err(SolveError::IllConditioned { .. } | SolveError::TooLarge { .. }) => {
                HouseholderQr.factor(system)
            }
            other => other,
        }
    }
}
