//! The program `loftsman`: recipes, conversions and facts from the command line, for any [registry](main).
//!
//! `args` is what was typed; each of `commands` is what it means. Everything it can do, the library can.

mod args;
mod commands;
mod console;
mod failure;
mod progress;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::FromArgMatches;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use loftsman_kernel::plugin::Registry;

use crate::program::args::{Arguments, Command};

/// The command line is at fault: exit status 2.
#[derive(Debug)]
struct Usage(String);

impl std::fmt::Display for Usage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Usage {}

/// Ctrl-C stopped it: exit status 130.
#[derive(Debug)]
struct Interrupted(String);

impl std::fmt::Display for Interrupted {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Interrupted {}

/// What clap refused, with the way to what was meant where the word is no command and the name of an operation or of a constraint: those are written in recipes.
fn hinted(mut error: clap::Error, registry: &Registry) -> clap::Error {
    let word = match (error.kind(), error.get(ContextKind::InvalidSubcommand)) {
        (ErrorKind::InvalidSubcommand, Some(ContextValue::String(word))) => word.clone(),
        _ => return error,
    };
    let hint = if registry.operations().iter().any(|operation| operation.declaration().name == word) {
        format!(
            "{word} is an operation of recipes: `[[step]]` with `op = \"{word}\"` in a file for `loftsman run`; `loftsman plugins {word}` lists its fields"
        )
    } else if registry.functionals().any(|constraint| constraint.name == word) {
        format!("{word} is a constraint of steps such as edit; `loftsman plugins {word}` lists its fields")
    } else {
        return error;
    };
    error.remove(ContextKind::SuggestedSubcommand);
    error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![hint.into()]));
    error
}

/// What was typed.
fn typed(arguments: &[OsString], registry: &Registry) -> Arguments {
    let matches = args::command().try_get_matches_from(arguments);
    matches.and_then(|matches| Arguments::from_arg_matches(&matches)).unwrap_or_else(|error| {
        let error = hinted(error, registry);
        // Help that was asked for is no error.
        if error.use_stderr() && failure::asked_for(arguments) {
            let text = error.render().to_string();
            failure::print(&failure::Failure::usage(&problem_of(&text)));
        }
        error.exit()
    })
}

/// What is wrong, of what is printed for people: its first paragraph, in which the arguments that it speaks of may be lines of their own.
fn problem_of(text: &str) -> String {
    let paragraph: Vec<&str> = text.lines().map(str::trim).take_while(|line| !line.is_empty()).collect();
    paragraph.join(" ").trim_start_matches("error: ").to_owned()
}

/// Runs the program with what was typed and with what a registry knows: what a plug-in's author needs for a command line of
/// the same commands with more formats, operations, constraints and solvers.
///
/// ```no_run
/// use std::process::ExitCode;
///
/// fn main() -> ExitCode {
///     let registry = loftsman::registry().clone();
///     // registry.add(&MyPlugin);
///     loftsman::program::main(&registry)
/// }
/// ```
///
/// It ends the process where help or the version is asked for, or what was typed cannot be understood.
pub fn main(registry: &Registry) -> ExitCode {
    main_with(registry, std::env::args_os())
}

/// The same with other arguments, the program's own name first.
pub fn main_with(registry: &Registry, arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let given: Vec<OsString> = arguments.into_iter().collect();
    let arguments = typed(&given, registry);
    let json = failure::asked_for(&given);
    progress::listen();
    let result = match arguments.command {
        Command::Run(args) => commands::run::run(&args, registry),
        Command::Convert(args) => commands::convert::run(&args, registry),
        Command::Info(args) => commands::info::run(&args, registry),
        Command::Fit(args) => commands::fit::run(&args, registry),
        Command::Plot(args) => commands::plot::run(&args, registry),
        Command::Compare(args) => commands::compare::run(&args, registry),
        Command::Plugins(args) => commands::plugins::run(&args, registry),
        Command::Completions(args) => commands::completions::run(&args),
    };
    match result {
        Ok(code) => code,
        // Whoever read our output has seen enough (`| head`).
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) if is_cancelled(&error) => {
            failure::tell(&error, 130, json);
            console::error("interrupted: nothing was written");
            ExitCode::from(progress::INTERRUPTED)
        }
        Err(error) if error.is::<Interrupted>() => {
            console::error(&error.to_string());
            ExitCode::from(progress::INTERRUPTED)
        }
        Err(error) => {
            let status = if error.is::<Usage>() { 2 } else { 1 };
            failure::tell(&error, status, json);
            console::error(&error.to_string());
            ExitCode::from(status)
        }
    }
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.downcast_ref::<std::io::Error>().is_some_and(|e| e.kind() == std::io::ErrorKind::BrokenPipe)
}

fn is_cancelled(error: &anyhow::Error) -> bool {
    error.downcast_ref::<crate::Error>().is_some_and(crate::Error::is_cancelled)
}
