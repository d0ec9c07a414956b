//! Solvers: the least adjustment that meets linear equations.

use thiserror::Error;

/// Turns a system into something that can be solved again and again.
pub trait Solver: Send + Sync {
    /// Its name in recipes.
    fn name(&self) -> &str;
}

/// Why a system could not be solved.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SolveError {
    /// Placeholder of the text.
    #[error("{0}")]
    Invalid(String),
}
