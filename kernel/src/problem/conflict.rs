//! Constraints that cannot all hold: which, and what could be done.

use std::collections::BTreeSet;

use super::Problem;
use super::assembly::Assembly;
use super::constraint::Constraint;
use super::knots::knot_that_helps;
use super::smooth::{ADVICE, BONDS, Smooth, is_ours, ours as smooth_of};
use crate::solve::{Dependency, SolveError};

/// The constraints of a dependency: those of the rows it is made of, and its own, ascending.
pub(crate) fn involved(assembly: &Assembly, dependency: &Dependency) -> Vec<usize> {
    let mut set: BTreeSet<usize> =
        dependency.combination.iter().map(|&(row, _)| assembly.constraint_of(row)).collect();
    set.insert(assembly.constraint_of(dependency.row));
    set.into_iter().collect()
}

/// The error for a dependency whose right-hand sides disagree.
pub(crate) fn explain(problem: &Problem, assembly: &Assembly, dependency: &Dependency) -> SolveError {
    let (constraints, freedom) = (problem.constraints().collect::<Vec<_>>(), &problem.freedom);
    let all = involved(assembly, dependency);
    // Two constraints of one name are told apart by their number.
    let stated = |k: &usize| {
        let name = constraints[*k].describe();
        let twin = all.iter().any(|other| other != k && constraints[*other].describe() == name);
        let name = quoted(&name);
        if twin { format!("{name} (constraints[{k}])") } else { name }
    };
    let own = constraints[assembly.constraint_of(dependency.row)].describe();
    if dependency.combination.is_empty() {
        let text = format!(
            "{} cannot be met: no control vertex that may move has any influence there; {}",
            quoted(&own),
            freedom.advice()
        );
        return SolveError::Conflict { constraints: vec![own], knot: None, text };
    }
    let labels = all.iter().map(|&k| constraints[k].label()).collect();
    let (ours, theirs): (Vec<usize>, Vec<usize>) = all.iter().partition(|k| is_ours(constraints[**k]));
    let names: Vec<String> = theirs.iter().chain(ours.iter().take(NAMED)).map(stated).collect();
    let kept: Vec<&Smooth> = ours.iter().filter_map(|&k| smooth_of(constraints[k])).collect();
    let still = companions(theirs.iter().map(|&k| constraints[k]));
    // Distinct vertices behind the rows: fewer than the equations means that refinement can help.
    let rows = assembly.system.rows();
    let columns: BTreeSet<u32> = dependency
        .combination
        .iter()
        .map(|&(row, _)| row)
        .chain([dependency.row])
        .flat_map(|row| rows.row(row).0.iter().copied())
        .collect();
    let per_vertex = if assembly.system.sides() == 3 { 1 } else { 3 };
    let vertices = columns.iter().map(|c| *c as usize / per_vertex).collect::<BTreeSet<_>>().len();
    let equations = dependency.combination.len() + 1;
    let release = match names.len() {
        1 => format!("{} contradicts itself", names[0]),
        _ => format!(
            "{}{} cannot all hold; release one of them{}{still}",
            names.join(", "),
            more(&kept),
            advice(&kept)
        ),
    };
    if equations <= columns.len() {
        return SolveError::Conflict { constraints: labels, knot: None, text: release };
    }
    let involved: Vec<&Constraint> = all.iter().map(|&k| constraints[k]).collect();
    let knot = knot_that_helps(&problem.shapes(), &involved, freedom);
    let insert = knot.map_or_else(String::new, |knot| format!(", or insert a knot at {knot}"));
    let each = if per_vertex == 1 { " for each coordinate" } else { "" };
    let vertices = match vertices {
        1 => "only 1 control vertex that may move has".to_owned(),
        n => format!("only {n} control vertices that may move have"),
    };
    let text = format!(
        "{release}{insert}: together they are {equations} equations{each}, and {vertices} a part in them"
    );
    SolveError::Conflict { constraints: labels, knot, text }
}

/// A constraint's name in quotes, unless it has some itself: `"position at 0.25"`, `area of "section"`.
pub(crate) fn quoted(name: &str) -> String {
    if name.contains('"') { name.to_owned() } else { format!("\"{name}\"") }
}

/// What to do about those that nobody asked for: they stand still beside others unless they are asked for.
fn companions<'c>(constraints: impl Iterator<Item = &'c Constraint>) -> String {
    let mut beside = None;
    let mut still = Vec::new();
    for constraint in constraints {
        if let Some(own) = &constraint.companion {
            beside.get_or_insert(own);
            still.push(quoted(&constraint.describe()));
        }
    }
    let Some(beside) = beside else { return String::new() };
    let [stands, it, its] =
        if still.len() == 1 { ["stands", "it", "its value"] } else { ["stand", "them", "their values"] };
    format!(
        " ({} {stands} still beside {} unless asked for: to let {it} go, ask for {it} and say {its})",
        still.join(" and "),
        quoted(beside)
    )
}

/// Of the knots that are kept smooth, so many are named.
const NAMED: usize = 3;

fn more(ours: &[&Smooth]) -> String {
    let what = match ours.iter().filter(|smooth| smooth.is_bond()).count() {
        0 => "smooth knots",
        bonds if bonds == ours.len() => "edges",
        _ => "edges and smooth knots",
    };
    if ours.len() > NAMED { format!(" and {} more {what}", ours.len() - NAMED) } else { String::new() }
}

/// What to do about what is kept smooth or together, though nobody asked for it.
fn advice(ours: &[&Smooth]) -> String {
    let some = |bond: bool| ours.iter().any(|smooth| smooth.is_bond() == bond);
    [(some(true), BONDS), (some(false), ADVICE)]
        .into_iter()
        .filter(|(some, _)| *some)
        .map(|(_, advice)| advice)
        .collect()
}

/// The error for rows that cannot all hold, some of them inequalities.
pub(crate) fn contradiction(problem: &Problem, assembly: &Assembly, rows: &[usize]) -> SolveError {
    let constraints: Vec<&Constraint> = problem.constraints().collect();
    let all: BTreeSet<usize> = rows.iter().map(|&row| assembly.constraint_of(row)).collect();
    let stated = |k: &usize| {
        let name = constraints[*k].label();
        let twin = all.iter().any(|other| other != k && constraints[*other].label() == name);
        let name = quoted(&name);
        if twin { format!("{name} (constraints[{k}])") } else { name }
    };
    let (ours, theirs): (Vec<usize>, Vec<usize>) = all.iter().partition(|k| is_ours(constraints[**k]));
    let names: Vec<String> = theirs.iter().chain(ours.iter().take(NAMED)).map(stated).collect();
    let untouched = |row: &usize| assembly.system.rows().row(*row).1.iter().all(|v| *v == 0.0);
    let kept: Vec<&Smooth> = ours.iter().filter_map(|&k| smooth_of(constraints[k])).collect();
    let still = companions(theirs.iter().map(|&k| constraints[k]));
    let labels = all.iter().map(|&k| constraints[k].label()).collect();
    let text = match (&names[..], rows) {
        ([only], [row]) if untouched(row) => format!(
            "{only} does not hold, and no control vertex that may move has any influence there; {}",
            problem.freedom.advice()
        ),
        ([only], _) => format!("{only} cannot hold; move the bound"),
        _ => format!(
            "{}{} cannot all hold; release one of them, or move a bound{}{still}",
            names.join(", "),
            more(&kept),
            advice(&kept)
        ),
    };
    SolveError::Conflict { constraints: labels, knot: None, text }
}
