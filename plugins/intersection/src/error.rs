//! What can be wrong with a question about intersections.

use loftsman_kernel::Error;
use loftsman_kernel::error::Figure;
use loftsman_kernel::plugin::OperationError;

/// The result of looking for intersections.
pub type Result<T, E = IntersectionError> = std::result::Result<T, E>;

/// Why intersections cannot be looked for.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum IntersectionError {
    /// A tolerance that is no length.
    #[error("the tolerance is {}: give a positive length", Figure(*.0))]
    Tolerance(f64),
    /// A plane without a direction, or one that is not anywhere.
    #[error("the plane has no usable {0}: give three finite numbers, for the normal not all of them 0")]
    Plane(&'static str),
    /// A shape whose size overflows.
    #[error("the shapes are too large for their distances to be numbers: scale them down")]
    TooLarge,
    /// A shape that cannot be evaluated.
    #[error(transparent)]
    Geometry(#[from] Error),
}

impl From<IntersectionError> for OperationError {
    fn from(error: IntersectionError) -> Self {
        match error {
            IntersectionError::Geometry(error) => error.into(),
            other => Error::Invalid(other.to_string()).into(),
        }
    }
}
