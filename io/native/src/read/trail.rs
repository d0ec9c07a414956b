//! Where in a document an error is: a path that is put together only when there is one.

use std::cell::RefCell;
use std::fmt::Write as _;

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
}

/// What is wrong, as far as JSON itself did not say it.
#[derive(Debug)]
pub(super) struct Problem {
    /// What is wrong and what to do.
    pub(super) text: String,
    /// Whether the reader stands at the spot itself, or at the end of the table that is wrong as a whole.
    pub(super) at_end: bool,
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
        self.keep(String::new(), problem.into(), false)
    }

    /// An error of a table that has been read to its end; `below` leads from it to the field at fault.
    pub(super) fn refuse_table<E: Error>(&self, below: impl Into<String>, problem: impl Into<String>) -> E {
        self.keep(below.into(), problem.into(), true)
    }

    fn keep<E: Error>(&self, below: String, text: String, at_end: bool) -> E {
        if !below.is_empty() {
            self.steps.borrow_mut().push(Step::Below(below));
        }
        *self.problem.borrow_mut() = Some(Problem { text, at_end });
        E::custom("refused")
    }

    /// Notes the object that is being read, once its name is known; `None` between objects.
    pub(super) fn set_object(&self, name: Option<&str>) {
        *self.object.borrow_mut() = name.map(str::to_owned);
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
