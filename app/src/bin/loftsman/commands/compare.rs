//! `compare RECIPE [--json]`

use std::fmt::Write;
use std::process::ExitCode;

use loftsman::compare::{Comparison, compare};
use loftsman::recipe::Recipe;

use super::report;
use crate::args::CompareArgs;
use crate::console::{self, BOLD, DIM, figure, seconds, styled};
use crate::progress::Progress;

pub(crate) fn run(args: &CompareArgs) -> anyhow::Result<ExitCode> {
    let recipe = Recipe::read(&args.recipe)?;
    let progress = Progress::start();
    let comparison = compare(&recipe, loftsman::registry(), &progress, &progress)?;
    drop(progress);
    if args.json.wanted {
        console::print_json(&comparison)?;
    } else {
        console::print(&text(&comparison))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn text(comparison: &Comparison) -> String {
    let mut text = String::new();
    for trial in &comparison.solvers {
        let head = styled(BOLD, &format!("{:16}", trial.solver));
        if let Some(error) = &trial.error {
            let _ = writeln!(text, "{head}  {error}");
            continue;
        }
        let difference = trial.difference.map(|d| format!(" · differs by {}", figure(d))).unwrap_or_default();
        let _ = writeln!(text, "{head}  {}{difference}", seconds(trial.seconds));
        for step in trial.steps.iter().filter(|s| s.solver.is_some()) {
            let object = step.object.as_ref().map(|o| format!(" \"{o}\"")).unwrap_or_default();
            let _ =
                writeln!(text, "  {}{object}  {}", step.op, styled(DIM, &report::facts(step).join(" · ")));
        }
    }
    if let Some(agreement) = comparison.agreement {
        let _ = writeln!(text, "{}", agreed(comparison, agreement));
    }
    text
}

fn agreed(comparison: &Comparison, agreement: f64) -> String {
    let refused = comparison.solvers.iter().filter(|t| t.error.is_some()).count();
    let who = if refused == 0 { "all agree" } else { "the others agree" };
    if agreement == 0.0 {
        format!("{who} to the last bit")
    } else {
        format!("{who} to {} of the size", figure(agreement))
    }
}
