//! `completions SHELL`

use std::process::ExitCode;

use clap::CommandFactory;

use crate::program::args::{Arguments, CompletionsArgs};
use crate::program::console;

pub(crate) fn run(args: &CompletionsArgs) -> anyhow::Result<ExitCode> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Arguments::command(), "loftsman", &mut script);
    console::print_bytes(&script)?;
    Ok(ExitCode::SUCCESS)
}
