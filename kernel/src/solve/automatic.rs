//! The default: the fastest solver that is safe for the system at hand.

use super::sparse::Refused;
use super::{
    Adjoint, DenseLu, Factored, HouseholderQr, SaddlePoint, SolveError, Solver, Sparse, System, SystemMetric,
};
use crate::text::short;

/// Chooses by size: [`Adjoint`] up to three equations, [`Sparse`] above ([`SaddlePoint`] in a metric that is a sparse matrix,
/// where no row depends on others); [`HouseholderQr`] where they find the system too ill-conditioned, and [`DenseLu`] where that does. [`Factored::solver`] says which one did the work.
#[derive(Debug, Clone, Copy, Default)]
pub struct Automatic;

impl Solver for Automatic {
    fn name(&self) -> &'static str {
        "automatic"
    }

    fn help(&self) -> &'static str {
        "everything: the fastest solver that is safe for the system at hand; the default"
    }

    fn takes(&self, _: &SystemMetric) -> bool {
        true
    }

    fn factor_minimum_norm(&self, system: &System) -> Result<Box<dyn Factored>, SolveError> {
        let few = system.rows().len() <= 3;
        if !few
            && matches!(system.metric(), SystemMetric::Matrix(_))
            && let Ok(factored) = SaddlePoint.factor(system)
            && factored.rank() == system.rows().len()
        {
            return Ok(factored);
        }
        let plain = matches!(system.metric(), SystemMetric::Least) && system.free() == 0;
        let first = match (few, plain) {
            (true, _) => Adjoint.factor(system).map_err(Refused::from),
            (false, true) => Sparse.factor_or_reflect(system),
            (false, false) => Sparse.factor(system).map_err(Refused::from),
        };
        match first {
            Err(Refused {
                error: error @ (SolveError::IllConditioned { .. } | SolveError::TooLarge { .. }),
                reflections,
            }) => {
                let second = match reflections {
                    Some(reflections) => HouseholderQr.with(system, *reflections),
                    None => HouseholderQr.factor(system),
                };
                match second {
                    Err(SolveError::IllConditioned { better: "lu", .. }) => {
                        DenseLu.factor(system).map_err(|last| neither(&error, last))
                    }
                    other => other.map_err(|second| neither(&error, second)),
                }
            }
            other => other.map_err(|refused| refused.error),
        }
    }
}

/// What no solver can do is not to be sent from one to the other.
fn neither(first: &SolveError, last: SolveError) -> SolveError {
    match (first, last) {
        (_, SolveError::IllConditioned { condition, .. }) => SolveError::Unsupported(format!(
            "the constraints are so nearly dependent (condition {condition}) that no solver meets them to rounding: \
             take away one of those that nearly coincide, or ask for fewer at once",
            condition = short(condition)
        )),
        (SolveError::IllConditioned { .. }, SolveError::TooLarge { equations, unknowns, .. }) => {
            SolveError::Unsupported(format!(
                "{equations} equations with {unknowns} unknowns that hang together are nearly dependent, and too many for \
                 the solvers that are made for that: ask for fewer at once, or take away those that nearly coincide"
            ))
        }
        (_, SolveError::TooLarge { equations, unknowns, .. }) => SolveError::Unsupported(format!(
            "{equations} equations with {unknowns} unknowns that hang together are too many: ask for fewer at once"
        )),
        (_, last) => last,
    }
}
