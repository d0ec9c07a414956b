//! Constraints that ask different things of the same: named before a step is taken. What only drifts apart agrees.

use loftsman_kernel::solve::{HouseholderQr, Solver, SparseRows, System, SystemMetric};

use super::Simulation;
use crate::error::{DynamicsError, Result};
use crate::link::Desk;

/// Rows that depend on one another may miss their positions by this share of the scene's size; more is a contradiction.
const APART: f64 = 1e-6;
/// Nearly the same it is where what they ask for would take the vertices farther than so many times the size, or than the places are away
/// that they ask for.
const FAR: f64 = 1e3;
/// All are named that have this share of the largest part in a combination.
const NAMED: f64 = 1e-2;

/// Looks whether the constraints that hold now can hold together, where things are.
///
/// # Errors
/// Naming those that cannot, and how far apart what they ask for is.
pub(crate) fn contradictions(simulation: &mut Simulation, desk: &mut Desk) -> Result<()> {
    simulation.collect(desk)?;
    let rows = simulation.space.rows();
    let count = rows.len();
    if count == 0 {
        return Ok(());
    }
    let touched = (0..rows.width()).collect();
    let system = System::new(rows, touched, 1, SystemMetric::Least);
    let factored = HouseholderQr.factor(&system).map_err(beyond)?;
    let diagnosis = factored.diagnosis();
    // Of the first constraint that cannot be, all equations together: as far apart as they are, in whatever direction.
    let mut first: Option<(usize, f64, Vec<usize>)> = None;
    for dependency in &diagnosis.dependencies {
        let implied: f64 = dependency.combination.iter().map(|(row, c)| c * desk.gap[*row]).sum();
        let apart = (desk.gap[dependency.row] - implied).abs();
        let Some(link) = owner(simulation, dependency.row) else { continue };
        if !(apart.is_nan() || apart > APART * simulation.size) {
            continue;
        }
        let (found, whole, rows) = first.get_or_insert((link, 0.0, Vec::new()));
        if *found == link {
            *whole = whole.hypot(apart);
            rows.push(dependency.row);
            rows.extend(dependency.combination.iter().filter(|(_, c)| c.abs() > 1e-9).map(|(row, _)| *row));
        }
    }
    if let Some((_, apart, rows)) = first {
        let mut links: Vec<usize> = rows.into_iter().filter_map(|row| owner(simulation, row)).collect();
        links.sort_unstable();
        links.dedup();
        return Err(conflict(simulation, links, apart));
    }
    nearly(simulation, &system, &desk.gap, diagnosis.condition)
}

fn beyond(error: loftsman_kernel::solve::SolveError) -> loftsman_kernel::Error {
    loftsman_kernel::Error::Invalid(format!("the constraints cannot be looked at together: {error}"))
}

fn conflict(simulation: &Simulation, links: Vec<usize>, apart: f64) -> DynamicsError {
    let mut names: Vec<String> = links.into_iter().map(|link| simulation.links[link].name.clone()).collect();
    names.sort();
    DynamicsError::Conflict { names, apart }
}

/// The constraint that a row belongs to.
fn owner(simulation: &Simulation, row: usize) -> Option<usize> {
    simulation
        .links
        .iter()
        .position(|link| link.is_held() && (link.first..link.first + link.equations).contains(&row))
}

/// Rows that are nearly the same agree to a millionth without anything going far, or contradict one another. Of unit rows `F`, asked for `b`:
/// for any combination `t` of them `t·b = (Fᵀt)·d + t·m`, so that no `d` up to [`FAR`] misses by `m` up to [`APART`] (both in lengths of the size, or of
/// `b`) where `t·b > |Fᵀt| FAR + |t| APART`. The combination that is tried is that of `F d + μ t = b` with `|d|² + |t|²` least, `μ = APART/FAR`: `Fᵀt = μ d`.
fn nearly(simulation: &Simulation, system: &System, gaps: &[f64], condition: f64) -> Result<()> {
    let rows = system.rows();
    let (count, width) = (rows.len(), rows.width());
    let norms: Vec<f64> = (0..count).map(|row| rows.norm(row)).collect();
    let asked: Vec<f64> =
        gaps.iter().zip(&norms).map(|(gap, norm)| if *norm > 0.0 { -gap / norm } else { 0.0 }).collect();
    let length = asked.iter().map(|gap| gap * gap).sum::<f64>().sqrt();
    let reach = asked.iter().fold(simulation.size, |most, gap| most.max(gap.abs()));
    // So far it goes at most, where rows are as near to one another as the condition says, or a tenth of it.
    if length * condition < 0.1 * FAR * reach {
        return Ok(());
    }
    let share = APART / FAR;
    let mut slack = SparseRows::new(width + count);
    for (row, norm) in norms.iter().enumerate() {
        let scale = if *norm > 0.0 { 1.0 / norm } else { 0.0 };
        slack.push(
            rows.iter_row(row).map(|(column, value)| (column, value * scale)).chain([(width + row, share)]),
        );
    }
    let slack = System::new(slack, (0..width + count).collect(), 1, SystemMetric::Least);
    let mut factored = HouseholderQr.factor(&slack).map_err(beyond)?;
    let mut answer = vec![0.0; width + count];
    factored.solve_into(&asked, &mut answer);
    let (way, slack) = answer.split_at(width);
    let square = |all: &[f64]| all.iter().map(|v| v * v).sum::<f64>();
    let (way, whole) = (square(way), square(slack));
    let agrees = share * (way + whole) <= (share * way.sqrt() * FAR + whole.sqrt() * APART) * reach;
    if agrees {
        return Ok(());
    }
    // Of each constraint all its equations together.
    let mut parts = vec![0.0_f64; simulation.links.len()];
    for (row, t) in slack.iter().enumerate() {
        if let Some(link) = owner(simulation, row) {
            parts[link] = parts[link].hypot(t / norms[row].max(f64::MIN_POSITIVE));
        }
    }
    let most = parts.iter().fold(0.0_f64, |most, part| if *part <= most { most } else { *part });
    // What the combination asks for, the largest part of it being one, in rows as they are.
    let apart = slack.iter().zip(&asked).map(|(t, asked)| t * asked).sum::<f64>().abs() / most;
    let at_odds = (0..parts.len()).filter(|link| parts[*link] >= NAMED * most).collect();
    Err(conflict(simulation, at_odds, apart))
}
