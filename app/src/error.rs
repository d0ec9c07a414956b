//! What can go wrong between files, recipes and the kernel.

use std::io::ErrorKind;

use loftsman_kernel::plugin::{FormatError, FormatErrorKind, OperationError};

use crate::recipe_error::RecipeError;

/// The result of reading, writing or running a recipe.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Why something could not be read, written or run. Every message names the file and says what to do.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The system will not give or take a file: it is missing, a directory, protected, …
    #[error("{path}: {problem}")]
    File {
        /// The file, as it was given.
        path: String,
        /// What is wrong and what to do.
        problem: String,
        /// What the system calls it; [`InvalidInput`](ErrorKind::InvalidInput) where the name or what is asked of it is wrong.
        kind: ErrorKind,
    },
    /// No format is known for a file.
    #[error("{file}: {problem}")]
    UnknownFormat {
        /// The file, as it was given.
        file: String,
        /// What was looked for, and what is known.
        problem: String,
    },
    /// A file breaks the rules of its format, or a format cannot hold a scene.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// A recipe is malformed, or one of its steps cannot be done.
    #[error(transparent)]
    Recipe(#[from] Box<RecipeError>),
    /// Whoever watched stopped it. Nothing was written.
    #[error("{}", loftsman_kernel::plugin::Cancelled)]
    Cancelled,
    /// The geometry does not allow what was asked.
    #[error(transparent)]
    Geometry(#[from] loftsman_kernel::Error),
}

impl From<loftsman_kernel::plugin::Cancelled> for Error {
    fn from(_: loftsman_kernel::plugin::Cancelled) -> Self {
        Self::Cancelled
    }
}

impl Error {
    /// Whether it is that whoever watched wanted no more.
    pub fn is_cancelled(&self) -> bool {
        match self {
            Self::Cancelled => true,
            Self::Format(error) => error.kind == FormatErrorKind::Cancelled,
            Self::Recipe(error) => matches!(error.cause, Some(OperationError::Cancelled)),
            _ => false,
        }
    }

    pub(crate) fn file(path: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::File { path: path.into(), problem: problem.into(), kind: ErrorKind::InvalidInput }
    }

    /// The system's error, in words that say what to do.
    pub(crate) fn system(path: impl Into<String>, doing: &str, error: &std::io::Error) -> Self {
        let problem = match error.kind() {
            ErrorKind::NotFound => "there is no such file; check the name and the folder".to_owned(),
            ErrorKind::PermissionDenied => format!("may not be {doing}: permission denied"),
            ErrorKind::StorageFull => format!("cannot be {doing}: the disk is full"),
            _ => format!("cannot be {doing}: {error}"),
        };
        Self::File { path: path.into(), problem, kind: error.kind() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_is_not_there_is_told_from_one_that_is_wrong() {
        let kind = |path: &str| match crate::read(path).map(|_| ()).unwrap_err() {
            Error::File { kind, .. } => Some(kind),
            _ => None,
        };
        assert_eq!(kind("no/such/file.obj"), Some(ErrorKind::NotFound));
        assert_eq!(kind(env!("CARGO_MANIFEST_DIR")), Some(ErrorKind::InvalidInput), "a folder");
        assert_eq!(
            kind(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml")),
            None,
            "of no format that is known"
        );
    }
}
