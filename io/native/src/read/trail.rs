//! Where in a document an error is: a path that is put together only when there is one.

use std::cell::RefCell;
use std::fmt::Write as _;

use loftsman_kernel::plugin::{FormatError, FormatErrorKind};
use serde::de::Error;

/// One step of a path, outermost last while it is being collected.
#[derive(Debug)]
enum Step {
    Field(&'static str),
    Index(usize),
    /// A path below the table that was refused: `weights[3]`.
    Below(String),
}

/// Collects the path of an error on its way out of the nested lists and tables, the problem where we found it
/// ourselves, and the object that is being read. Nothing happens here as long as all is well.
#[derive(Debug, Default)]
pub(super) struct Trail {
    steps: RefCell<Vec<Step>>,
    problem: RefCell<Option<Problem>>,
    object: RefCell<Option<String>>,
    /// What ended it that is no matter of a place.
    stopped: RefCell<Option<FormatError>>,
}

/// What is wrong, as far as JSON itself did not say it.
#[derive(Debug)]
pub(super) struct Problem {
    /// What is wrong and what to do.
    pub(super) text: String,
    /// Whether the reader stands at the spot itself, or at the end of the table that is wrong as a whole.
    pub(super) at_end: bool,
    /// What kind of thing is wrong.
    pub(super) kind: FormatErrorKind,
}

impl Trail {
    /// Passes a result on; an error gets the step `field`.
    pub(super) fn field<T, E>(&self, field: &'static str, result: Result<T, E>) -> Result<T, E> {
        result.inspect_err(|_| self.steps.borrow_mut().push(Step::Field(field)))
    }

    /// Passes a result on; an error gets the step `[index]`.
    pub(super) fn index<T, E>(&self, index: usize, result: Result<T, E>) -> Result<T, E> {
        result.inspect_err(|_| self.steps.borrow_mut().push(Step::Index(index)))
    }

    /// An error right where the reader stands.
    pub(super) fn refuse<E: Error>(&self, problem: impl Into<String>) -> E {
        self.refuse_as(FormatErrorKind::Malformed, problem)
    }

    /// The same, of another kind.
    pub(super) fn refuse_as<E: Error>(&self, kind: FormatErrorKind, problem: impl Into<String>) -> E {
        self.keep(String::new(), Problem { text: problem.into(), at_end: false, kind })
    }

    /// Reading ends here, with this error as it stands.
    pub(super) fn stop<E: Error>(&self, error: impl Into<FormatError>) -> E {
        *self.stopped.borrow_mut() = Some(error.into());
        E::custom("stopped")
    }

    /// An error of a table that has been read to its end; `below` leads from it to the field at fault.
    pub(super) fn refuse_table<E: Error>(&self, below: impl Into<String>, problem: impl Into<String>) -> E {
        let kind = FormatErrorKind::Malformed;
        self.keep(below.into(), Problem { text: problem.into(), at_end: true, kind })
    }

    fn keep<E: Error>(&self, below: String, problem: Problem) -> E {
        if !below.is_empty() {
            self.steps.borrow_mut().push(Step::Below(below));
        }
        *self.problem.borrow_mut() = Some(problem);
        E::custom("refused")
    }

    /// Notes the object that is being read, once its name is known; `None` between objects.
    pub(super) fn set_object(&self, name: Option<&str>) {
        *self.object.borrow_mut() = name.map(str::to_owned);
    }

    /// What ended reading, where that was not the document.
    pub(super) fn stopped(&self) -> Option<FormatError> {
        self.stopped.borrow_mut().take()
    }

    /// The path, the object and the problem of the error that came out.
    pub(super) fn into_parts(self) -> (String, Option<String>, Option<Problem>) {
        let mut path = String::new();
        for step in self.steps.into_inner().iter().rev() {
            let dot = if path.is_empty() { "" } else { "." };
            // Writing to a string cannot fail.
            let _ = match step {
                Step::Field(name) => write!(path, "{dot}{name}"),
                Step::Index(index) => write!(path, "[{index}]"),
                Step::Below(below) => write!(path, "{dot}{below}"),
            };
        }
        (path, self.object.into_inner(), self.problem.into_inner())
    }
}
