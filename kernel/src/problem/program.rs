//! The least adjustment under linear rows: equations, and inequalities where there are any.

use super::assembly::Assembly;
use super::bound::BoundConstraint;
use super::conflict::{contradiction, explain};
use super::constraint::Constraint;
use super::effort::soften;
use super::{EditError, Numbers, Problem};
use crate::solve::{Dependency, Factored, Outcome, Program, Sense, Solver, System};

/// The rows of a problem with inequalities, of which the prepared system holds the equations and the active ones.
#[derive(Debug)]
pub(crate) struct Bounds {
    pub(crate) full: Assembly,
    pub(crate) rhs: Numbers,
    pub(crate) size: Numbers,
    /// The active inequalities' rows.
    pub(crate) active: Vec<usize>,
}

/// Linear rows solved.
pub(crate) struct Solved {
    /// The rows that hold with equality, where that is not all of them, and which they are.
    pub(crate) part: Option<(Assembly, Vec<usize>)>,
    pub(crate) active: Vec<usize>,
    pub(crate) factored: Box<dyn Factored>,
    pub(crate) dependencies: Vec<Dependency>,
    /// Of these rows.
    pub(crate) rhs: Numbers,
    pub(crate) size: Numbers,
    pub(crate) d: Vec<f64>,
    /// Whether rows are missed because only a best effort was asked for.
    pub(crate) softened: bool,
    /// The tolerance at which rows count as implied by others.
    pub(crate) tolerance: f64,
}

/// Whether some constraints are inequalities.
pub(crate) fn has_inequalities(bound: &[BoundConstraint]) -> bool {
    bound.iter().any(|b| b.constraint.sense() != Sense::Equal)
}

/// Which side of its right-hand side each row must be on.
pub(crate) fn senses(assembly: &Assembly, constraints: &[&Constraint]) -> Vec<Sense> {
    (0..assembly.system.rows().len()).map(|row| constraints[assembly.constraint_of(row)].sense()).collect()
}

/// The rows that are equations.
pub(crate) fn equations(senses: &[Sense]) -> Vec<usize> {
    (0..senses.len()).filter(|&row| senses[row] == Sense::Equal).collect()
}

/// The entries of some rows of a system with one side.
pub(crate) fn gather(values: &[f64], rows: &[usize]) -> Numbers {
    rows.iter().map(|&row| values[row]).collect()
}

impl Problem {
    /// The least adjustment that meets linear rows, each on its side of its right-hand side.
    pub(crate) fn program(
        &self,
        solver: &dyn Solver,
        full: &Assembly,
        rhs: &[f64],
        size: &[f64],
    ) -> Result<Solved, EditError> {
        let constraints: Vec<&Constraint> = self.bound.iter().map(|b| &b.constraint).collect();
        let senses = senses(full, &constraints);
        let mut kept = equations(&senses);
        if kept.len() == senses.len() {
            return self.equal(solver, full, rhs.into(), size.into());
        }
        let part = full.select(&kept);
        let mut solved = self.equal(solver, &part, gather(rhs, &kept), gather(size, &kept))?;
        // What a best effort makes of the equations is what the inequalities stand beside.
        let mut softened = rhs.to_vec();
        kept.iter().zip(&solved.rhs).for_each(|(&row, b)| softened[row] = *b);
        // Equations that others imply, as just found, are none: to a finer tolerance some would be, and the bounds would be met beside other equations
        // than the answer is.
        let mut implied: Vec<usize> = solved.dependencies.iter().map(|d| kept[d.row]).collect();
        implied.sort_unstable();
        let outcome = if implied.is_empty() {
            solver.program(&Program { system: &full.system, rhs: &softened, senses: &senses, size })?
        } else {
            let asked: Vec<usize> =
                (0..senses.len()).filter(|row| implied.binary_search(row).is_err()).collect();
            let (rhs, size) = (gather(&softened, &asked), gather(size, &asked));
            let own: Vec<Sense> = asked.iter().map(|&row| senses[row]).collect();
            let system = full.system.select(&asked);
            let all = |rows: Vec<usize>| rows.into_iter().map(|row| asked[row]).collect();
            match solver.program(&Program { system: &system, rhs: &rhs, senses: &own, size: &size })? {
                Outcome::Infeasible { rows } => Outcome::Infeasible { rows: all(rows) },
                Outcome::Active { rows, steps } => Outcome::Active { rows: all(rows), steps },
            }
        };
        match outcome {
            Outcome::Infeasible { rows } => Err(contradiction(self, full, &rows).into()),
            Outcome::Active { rows, .. } if rows.is_empty() => {
                solved.part = Some((part, kept));
                Ok(solved)
            }
            Outcome::Active { rows, .. } => {
                kept.extend(&rows);
                kept.sort_unstable();
                let part = full.select(&kept);
                let softened = solved.softened;
                // From what was asked: softened once more, what was softened would be the least squares of other equations.
                solved = self.equal(solver, &part, gather(rhs, &kept), gather(size, &kept))?;
                solved.part = Some((part, kept));
                solved.active = rows;
                solved.softened |= softened;
                Ok(solved)
            }
        }
    }

    /// The least adjustment that meets equations.
    fn equal(
        &self,
        solver: &dyn Solver,
        assembly: &Assembly,
        rhs: Numbers,
        size: Numbers,
    ) -> Result<Solved, EditError> {
        let closer = assembly.system.finely();
        let mut solved = meet(solver, &assembly.system, rhs, size)?;
        let disagrees = |solved: &Solved| {
            let Solved { dependencies, rhs, size, d, .. } = solved;
            dependencies.iter().position(|dependency| !dependency.agrees(&assembly.system, rhs, size, d))
        };
        let Some(mut at) = disagrees(&solved) else { return Ok(solved) };
        if self.best_effort {
            solved.rhs = soften(assembly, &solved.dependencies, &solved.rhs).into();
            solved.factored.solve_into(&solved.rhs, &mut solved.d);
            solved.softened = true;
            return Ok(solved);
        }
        // Before it is called a conflict: what is nearly implied is not implied.
        if assembly.system.tolerance() > closer.tolerance() {
            solved = meet(solver, &closer, solved.rhs, solved.size)?;
            match disagrees(&solved) {
                None => return Ok(solved),
                Some(still) => at = still,
            }
        }
        Err(explain(self, assembly, &solved.dependencies[at]).into())
    }
}

/// The least adjustment that meets the independent rows of a system.
fn meet(solver: &dyn Solver, system: &System, rhs: Numbers, size: Numbers) -> Result<Solved, EditError> {
    let mut factored = solver.factor(system)?;
    let dropped = factored.rank() < system.rows().len();
    let dependencies = if dropped { factored.diagnosis().dependencies } else { Vec::new() };
    let mut d = vec![0.0; system.touched().len() * system.sides()];
    factored.solve_into(&rhs, &mut d);
    let (part, active, softened, tolerance) = (None, Vec::new(), false, system.tolerance());
    Ok(Solved { part, active, factored, dependencies, rhs, size, d, softened, tolerance })
}
