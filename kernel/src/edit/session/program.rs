//! The least adjustment under linear rows: equations, and inequalities where there are any.

use super::Session;
use super::bound::Bound;
use super::effort::soften;
use crate::edit::EditError;
use crate::edit::ask::Constraint;
use crate::edit::assembly::Assembly;
use crate::edit::conflict::{agrees, contradiction, explain};
use crate::shape::Shape;
use crate::solve::{Dependency, Factored, Outcome, Program, Sense};

/// The rows of a problem with inequalities, of which the prepared system holds the equations and the active ones.
#[derive(Debug)]
pub(super) struct Bounds {
    pub(super) full: Assembly,
    pub(super) rhs: Vec<f64>,
    pub(super) size: Vec<f64>,
    /// The active inequalities' rows.
    pub(super) active: Vec<usize>,
}

/// A solved problem.
pub(super) struct Solved {
    /// The rows that hold with equality, where that is not all of them, and which they are.
    pub(super) part: Option<(Assembly, Vec<usize>)>,
    pub(super) active: Vec<usize>,
    pub(super) factored: Box<dyn Factored>,
    pub(super) dependencies: Vec<Dependency>,
    /// Of these rows.
    pub(super) rhs: Vec<f64>,
    pub(super) size: Vec<f64>,
    pub(super) d: Vec<f64>,
    /// Whether rows are missed because only a best effort was asked for.
    pub(super) softened: bool,
}

/// Whether some constraints are inequalities.
pub(super) fn has_inequalities(bound: &[Bound]) -> bool {
    bound.iter().any(|b| b.constraint.sense() != Sense::Equal)
}

/// Which side of its right-hand side each row must be on.
pub(super) fn senses(assembly: &Assembly, constraints: &[&Constraint]) -> Vec<Sense> {
    (0..assembly.system.rows().len()).map(|row| constraints[assembly.constraint_of(row)].sense()).collect()
}

/// The rows that are equations.
pub(super) fn equations(senses: &[Sense]) -> Vec<usize> {
    (0..senses.len()).filter(|&row| senses[row] == Sense::Equal).collect()
}

/// The entries of some rows of a system with one side.
pub(super) fn gather(values: &[f64], rows: &[usize]) -> Vec<f64> {
    rows.iter().map(|&row| values[row]).collect()
}

impl<S: Shape> Session<S> {
    /// The least adjustment that meets linear rows, each on its side of its right-hand side.
    pub(super) fn program(&self, full: &Assembly, rhs: &[f64], size: &[f64]) -> Result<Solved, EditError> {
        let constraints: Vec<&Constraint> = self.bound.iter().map(|b| &b.constraint).collect();
        let senses = senses(full, &constraints);
        let mut kept = equations(&senses);
        if kept.len() == senses.len() {
            return self.equal(&constraints, full, rhs.to_vec(), size.to_vec());
        }
        let part = full.select(&kept);
        let mut solved = self.equal(&constraints, &part, gather(rhs, &kept), gather(size, &kept))?;
        let mut rhs = rhs.to_vec();
        kept.iter().zip(&solved.rhs).for_each(|(&row, b)| rhs[row] = *b);
        let program = Program { system: &full.system, rhs: &rhs, senses: &senses, size };
        match self.solver.program(&program)? {
            Outcome::Infeasible { rows } => Err(contradiction(&constraints, full, &rows).into()),
            Outcome::Active { rows, .. } if rows.is_empty() => {
                solved.part = Some((part, kept));
                Ok(solved)
            }
            Outcome::Active { rows, .. } => {
                kept.extend(&rows);
                kept.sort_unstable();
                let part = full.select(&kept);
                let softened = solved.softened;
                solved = self.equal(&constraints, &part, gather(&rhs, &kept), gather(size, &kept))?;
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
        constraints: &[&Constraint],
        assembly: &Assembly,
        mut rhs: Vec<f64>,
        size: Vec<f64>,
    ) -> Result<Solved, EditError> {
        let mut factored = self.solver.factor(&assembly.system)?;
        let dropped = factored.rank() < assembly.system.rows().len();
        let dependencies = if dropped { factored.diagnosis().dependencies } else { Vec::new() };
        let disagrees = dependencies.iter().find(|d| !agrees(assembly, d, &rhs, &size));
        if let (Some(dependency), false) = (disagrees, self.best_effort) {
            return Err(explain(&self.shapes, constraints, &self.freedom, assembly, dependency).into());
        }
        let softened = disagrees.is_some();
        if softened {
            rhs = soften(assembly, &dependencies, &rhs);
        }
        let mut d = vec![0.0; assembly.system.touched().len() * assembly.system.sides()];
        factored.solve_into(&rhs, &mut d);
        Ok(Solved { part: None, active: Vec::new(), factored, dependencies, rhs, size, d, softened })
    }
}
