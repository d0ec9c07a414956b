//! What went wrong, as the one JSON object that `--json` promises.

use std::ffi::OsString;

use crate::Error;
use loftsman_kernel::plugin::Place;

use crate::program::console;

/// Why a command failed. What is not known is left out.
#[derive(serde::Serialize, Default)]
pub(crate) struct Failure {
    /// The exit status.
    status: u8,
    /// The file at fault.
    #[serde(skip_serializing_if = "Option::is_none")]
    file: Option<String>,
    /// The line in it, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    line: Option<usize>,
    /// The column in the line, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    column: Option<usize>,
    /// The place in what the file says: `step[0].constraints[2].at`.
    #[serde(skip_serializing_if = "Option::is_none")]
    path: Option<String>,
    /// What is wrong there and what to do.
    problem: String,
    /// All of it in one text, as it is printed without `--json`.
    message: String,
}

#[derive(serde::Serialize)]
struct Whole<'a> {
    error: &'a Failure,
}

impl Failure {
    /// A command line that is wrong.
    pub(crate) fn usage(problem: &str) -> Self {
        Self { status: 2, problem: problem.to_owned(), message: problem.to_owned(), ..Self::default() }
    }

    fn of(error: &anyhow::Error, status: u8) -> Self {
        let message = error.to_string();
        let plain = Self { status, problem: message.clone(), message, ..Self::default() };
        match error.downcast_ref::<Error>() {
            Some(Error::File { path, problem, .. }) => {
                Self { file: Some(path.clone()), problem: problem.clone(), ..plain }
            }
            Some(Error::UnknownFormat { file, problem }) => {
                Self { file: Some(file.clone()), problem: problem.clone(), ..plain }
            }
            Some(Error::Format(error)) => Self {
                file: Some(error.file.clone()),
                line: match error.place {
                    Place::Line(line) => Some(line),
                    _ => None,
                },
                path: match &error.place {
                    Place::Path(path) => Some(path.clone()),
                    _ => None,
                },
                problem: error.problem.clone(),
                ..plain
            },
            Some(Error::Recipe(error)) => Self {
                file: Some(error.file.clone()),
                line: error.position.map(|(line, _)| line),
                column: error.position.map(|(_, column)| column),
                path: Some(error.path.clone()).filter(|path| !path.is_empty()),
                problem: error.problem.clone(),
                ..plain
            },
            _ => plain,
        }
    }
}

/// Whether `--json` was typed: an error on the command line comes before it is read.
pub(crate) fn asked_for(arguments: &[OsString]) -> bool {
    arguments.iter().skip(1).take_while(|arg| *arg != "--").any(|arg| arg == "--json")
}

/// Prints why a command failed, where JSON is asked for.
pub(crate) fn tell(error: &anyhow::Error, status: u8, json: bool) {
    if json {
        print(&Failure::of(error, status));
    }
}

/// Prints it.
pub(crate) fn print(failure: &Failure) {
    // Nobody is left to be told when this fails.
    let _ = console::print_json(&Whole { error: failure });
}
