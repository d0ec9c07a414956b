//! Constraints that ask different things of the same: named before a step is taken. What only drifts apart agrees.

use loftsman_kernel::solve::{HouseholderQr, Solver, System, SystemMetric};

use super::Simulation;
use crate::error::{DynamicsError, Result};
use crate::link::Desk;

/// Rows that depend on one another may miss their positions by this share of the scene's size; more is a contradiction.
const APART: f64 = 1e-6;

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
    let factored = HouseholderQr.factor(&system).map_err(|e| {
        loftsman_kernel::Error::Invalid(format!("the constraints cannot be looked at together: {e}"))
    })?;
    let name = |row: usize| {
        let held = simulation.links.iter().filter(|link| link.is_held());
        held.into_iter()
            .find(|link| (link.first..link.first + link.equations).contains(&row))
            .map(|link| link.name.clone())
    };
    for dependency in factored.diagnosis().dependencies {
        let implied: f64 = dependency.combination.iter().map(|(row, c)| c * desk.gap[*row]).sum();
        let apart = (desk.gap[dependency.row] - implied).abs();
        if apart.is_nan() || apart > APART * simulation.size {
            let own = std::iter::once(dependency.row);
            let all =
                own.chain(dependency.combination.iter().filter(|(_, c)| c.abs() > 1e-9).map(|(row, _)| *row));
            let mut names: Vec<String> = all.filter_map(name).collect();
            names.sort();
            names.dedup();
            return Err(DynamicsError::Conflict { names, apart });
        }
    }
    Ok(())
}
