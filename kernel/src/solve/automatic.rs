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
            Err(error @ (SolveError::IllConditioned { .. } | SolveError::TooLarge { .. })) => {
                HouseholderQr.factor(system).map_err(|second| neither(&error, second))
            }
            other => other,
        }
    }
}

/// What no solver can do is not to be sent from one to the other.
fn neither(first: &SolveError, second: SolveError) -> SolveError {
    let SolveError::TooLarge { equations, unknowns, .. } = second else { return second };
    let how = match first {
        SolveError::IllConditioned { .. } => "nearly dependent, and ",
        _ => "",
    };
    SolveError::Unsupported(format!(
        "{equations} equations with {unknowns} unknowns that hang together are {how}too many: ask for fewer at once, or \
         take away constraints that nearly coincide"
    ))
}
