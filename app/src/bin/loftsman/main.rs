//! The program `loftsman`: recipes, conversions and facts from the command line.
//!
//! [`args`] is what was typed; each of [`commands`] is what it means. Everything it can do, the library can.

mod args;
mod commands;
mod console;
mod failure;
mod progress;

use std::process::ExitCode;

use clap::FromArgMatches;

use crate::args::{Arguments, Command};

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

/// What was typed.
fn typed() -> Arguments {
    let matches = args::command().try_get_matches();
    matches.and_then(|matches| Arguments::from_arg_matches(&matches)).unwrap_or_else(|error| {
        // Help that was asked for is no error.
        if error.use_stderr() && failure::asked_for() {
            let text = error.render().to_string();
            let problem = text.lines().next().unwrap_or_default();
            failure::print(&failure::Failure::usage(problem.trim_start_matches("error: ")));
        }
        error.exit()
    })
}

fn main() -> ExitCode {
    let arguments = typed();
    progress::listen();
    let result = match arguments.command {
        Command::Run(args) => commands::run::run(&args),
        Command::Convert(args) => commands::convert::run(&args),
        Command::Info(args) => commands::info::run(&args),
        Command::Fit(args) => commands::fit::run(&args),
        Command::Plot(args) => commands::plot::run(&args),
        Command::Compare(args) => commands::compare::run(&args),
        Command::Plugins(args) => commands::plugins::run(&args),
        Command::Completions(args) => commands::completions::run(&args),
    };
    match result {
        Ok(code) => code,
        // Whoever read our output has seen enough (`| head`).
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) if is_cancelled(&error) => {
            failure::tell(&error, 130);
            console::error("interrupted: nothing was written");
            ExitCode::from(progress::INTERRUPTED)
        }
        Err(error) if error.is::<Interrupted>() => {
            console::error(&error.to_string());
            ExitCode::from(progress::INTERRUPTED)
        }
        Err(error) => {
            let status = if error.is::<Usage>() { 2 } else { 1 };
            failure::tell(&error, status);
            console::error(&error.to_string());
            ExitCode::from(status)
        }
    }
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.downcast_ref::<std::io::Error>().is_some_and(|e| e.kind() == std::io::ErrorKind::BrokenPipe)
}

fn is_cancelled(error: &anyhow::Error) -> bool {
    error.downcast_ref::<loftsman::Error>().is_some_and(loftsman::Error::is_cancelled)
}
