//! `run RECIPE [-o OUT]… [--solver NAME] [--json]`

use std::process::ExitCode;

use crate::recipe::{Recipe, Runner};
use loftsman_kernel::plugin::{Fate, Registry};

use super::report;
use crate::program::Usage;
use crate::program::args::RunArgs;
use crate::program::console;
use crate::program::progress::Progress;

pub(crate) fn run(args: &RunArgs, registry: &Registry) -> anyhow::Result<ExitCode> {
    if let Some(solver) = &args.solver {
        registry.find_solver(solver, "--solver").map_err(|e| Usage(e.to_string()))?;
    }
    for file in &args.outputs {
        super::convert::check_output(file, registry)?;
    }
    let recipe = Recipe::read_beside(&args.recipe, registry)?;
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
        // People read it in the report below; programs get it beside their JSON.
        for input in report.input.iter().chain(&report.more_inputs) {
            report::warn(&input.path, &input.report);
        }
        for output in &report.outputs {
            for object in output.objects.iter().filter(|o| o.fate == Fate::LeftOut) {
                let reason = object.reason.as_deref().unwrap_or("the format cannot hold it");
                console::warning(&format!("{}: \"{}\" was left out: {reason}", output.path, object.object));
            }
        }
        console::print_json(&report)?;
    } else {
        console::print(&report::run(&report, args.verbose))?;
    }
    for step in &report.steps {
        step.warnings.iter().for_each(|warning| console::warning(&format!("{}: {warning}", step.op)));
    }
    Ok(ExitCode::SUCCESS)
}
