//! `compare RECIPE [--json]`

use std::fmt::Write;
use std::process::ExitCode;

use crate::compare::{Comparison, compare};
use crate::recipe::Recipe;
use loftsman_kernel::plugin::{Registry, StepReport};

use super::report;
use crate::program::args::CompareArgs;
use crate::program::console::{self, BOLD, DIM, figure, seconds, styled};
use crate::program::progress::Progress;

pub(crate) fn run(args: &CompareArgs, registry: &Registry) -> anyhow::Result<ExitCode> {
    let recipe = Recipe::read_beside(&args.recipe, registry)?;
    let progress = Progress::start();
    let comparison = compare(&recipe, registry, &progress, &progress)?;
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
        let did = |step: &&StepReport| step.solver.as_ref().is_some_and(|s| s.contains(&trial.solver));
        if trial.solver != "automatic" && !trial.steps.iter().any(|step| did(&step)) {
            let _ = writeln!(text, "  nothing for it to do by itself: others did the work");
        }
        for step in trial.steps.iter().filter(|s| s.solver.is_some()) {
            let object = step.object.as_ref().map(|o| format!(" \"{o}\"")).unwrap_or_default();
            let _ = writeln!(
                text,
                "  {}{object}  {}",
                step.op,
                styled(DIM, &report::facts(step, true).join(" · "))
            );
        }
    }
    let _ = writeln!(text, "{}", agreed(comparison));
    for unlike in &comparison.unlike {
        let _ = writeln!(text, "cannot be compared: {unlike}");
    }
    text
}

/// Who agrees with whom, and who refuses what others do.
fn agreed(comparison: &Comparison) -> String {
    let answers: Vec<&str> =
        comparison.solvers.iter().filter(|t| t.error.is_none()).map(|t| t.solver.as_str()).collect();
    let refused: Vec<&str> = comparison.refused.iter().map(String::as_str).collect();
    let unsuited: Vec<&str> = comparison.unsuited.iter().map(String::as_str).collect();
    let mut found = match (comparison.agreement, refused.is_empty() && unsuited.is_empty()) {
        _ if answers.len() < 2 => format!("only {} has an answer", answers.join("")),
        (None, true) => "what the solvers made does not correspond".to_owned(),
        (None, false) => format!("what {} made does not correspond", list(&answers)),
        (Some(apart), alone) => {
            let who = if alone { "all".to_owned() } else { list(&answers) };
            let where_alike = if comparison.unlike.is_empty() { "" } else { ", where they can be compared" };
            if apart == 0.0 {
                format!("{who} agree to the last bit{where_alike}")
            } else {
                format!("{who} agree to {} of the size{where_alike}", figure(apart))
            }
        }
    };
    let verb = |names: &[&str], verb: &str| {
        format!("{} {verb}{}", list(names), if names.len() == 1 { "s" } else { "" })
    };
    if !unsuited.is_empty() {
        found = format!("{found}; {} this to others", verb(&unsuited, "leave"));
    }
    if refused.is_empty() {
        return found;
    }
    format!("the solvers disagree on whether it can be done: {}; {found}", verb(&refused, "refuse"))
}

/// `a`, `a and b`, `a, b and c`.
fn list(names: &[&str]) -> String {
    match names {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [many @ .., last] => format!("{} and {last}", many.join(", ")),
    }
}
