//! `run RECIPE [-o OUT]… [--solver NAME] [--json]`

use std::process::ExitCode;

use loftsman::recipe::{Recipe, Runner};

use super::report;
use crate::Usage;
use crate::args::RunArgs;
use crate::console;
use crate::progress::Progress;

pub(crate) fn run(args: &RunArgs) -> anyhow::Result<ExitCode> {
    let registry = loftsman::registry();
    if let Some(solver) = &args.solver {
        registry.find_solver(solver, "--solver").map_err(|e| Usage(e.to_string()))?;
    }
    for file in &args.outputs {
        super::convert::check_output(file)?;
    }
    let recipe = Recipe::read(&args.recipe)?;
    let progress = Progress::start();
    let mut runner = Runner::new(registry).watched(&progress, &progress);
    if let Some(solver) = &args.solver {
        runner = runner.with_solver(solver);
    }
    if !args.outputs.is_empty() {
        runner = runner.with_outputs(args.outputs.clone());
    }
    let report = runner.run(&recipe)?;
    drop(runner);
    drop(progress);
    if args.json.wanted {
        console::print_json(&report)?;
    } else {
        console::print(&report::run(&report))?;
    }
    Ok(ExitCode::SUCCESS)
}
