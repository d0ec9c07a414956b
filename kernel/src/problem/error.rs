//! Why an edit could not be done.

use crate::error::Error;
use crate::solve::SolveError;

/// Why an edit could not be done: its geometry, or its constraints.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EditError {
    /// Something cannot be asked of these shapes.
    #[error(transparent)]
    Geometry(#[from] Error),
    /// The constraints cannot be met.
    #[error(transparent)]
    Solve(#[from] SolveError),
}
