//! What is wrong with a recipe, and where.

use std::fmt;

use loftsman_kernel::plugin::OperationError;

/// A recipe that is malformed, or a step of it that cannot be done: where, what, and what to do.
#[derive(Debug, Clone, PartialEq)]
pub struct RecipeError {
    /// The recipe, as messages name it.
    pub file: String,
    /// Line and column, counted from 1, where they are known.
    pub position: Option<(usize, usize)>,
    /// The path inside the recipe: `step[0].constraints[2].at`; empty for the recipe as a whole.
    pub path: String,
    /// What is wrong and what to do.
    pub problem: String,
    /// The operation's own error, where a step failed.
    pub cause: Option<OperationError>,
}

impl RecipeError {
    pub(crate) fn at(file: &str, path: impl Into<String>, problem: impl Into<String>) -> Box<Self> {
        let (path, problem) = (path.into(), problem.into());
        Box::new(Self { file: file.to_owned(), position: None, path, problem, cause: None })
    }

    pub(crate) fn in_line(mut self: Box<Self>, position: Option<(usize, usize)>) -> Box<Self> {
        self.position = position;
        self
    }
}

impl fmt::Display for RecipeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file)?;
        if let Some((line, column)) = self.position {
            write!(f, ", line {line}, column {column}")?;
        }
        if !self.path.is_empty() {
            write!(f, ", {}", self.path)?;
        }
        write!(f, ": {}", self.problem)
    }
}

impl std::error::Error for RecipeError {}
