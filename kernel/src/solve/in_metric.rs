//! A metric taken out before any solver, and put back into its answers.

use std::sync::Arc;

use super::householder_qr::beyond;
use super::metric::{SystemMetric, Whitened};
use super::rank::{Dependency, Diagnosis, reduce};
use super::refine::Refinement;
use super::system::System;
use super::{Factored, HouseholderQr, SolveError, Solver};

/// What a solver made of the rows in the coordinates of the metric.
struct InMetric {
    core: Core,
    refinement: Box<Refinement>,
    dependencies: Vec<Dependency>,
}

struct Core {
    inner: Box<dyn Factored>,
    whitened: Box<Whitened>,
    /// The answer in the coordinates of the metric.
    e: Vec<f64>,
    sides: usize,
    /// The rows that were kept, where that is not all of them, and room for their right-hand sides and multipliers.
    kept: Option<Vec<usize>>,
    part: Vec<f64>,
}

/// A solver for systems whose metric is the identity.
pub(super) type MinimumNorm<'a> = dyn Fn(&System) -> Result<Box<dyn Factored>, SolveError> + 'a;

/// Factors a system whose metric is not the identity with a solver for those where it is. Which rows depend on others is asked
/// of the rows as they were given: the metric does not matter to it, and would add its condition to the rounding.
///
/// # Errors
/// The solver's own; when the metric is not positive definite, or so ill-conditioned that answers do not meet the rows.
pub(super) fn factor(
    solver: &str,
    factor: &MinimumNorm<'_>,
    system: &System,
) -> Result<Box<dyn Factored>, SolveError> {
    let Some(whitened) = system.whitened()? else { return factor(system) };
    let (count, sides) = (system.rows().len(), system.sides());
    // What unknowns cannot tell apart depends on one another, whatever the rows say of the columns.
    let through = matches!(system.metric(), SystemMetric::Through(_));
    let plain = system.in_metric(Arc::clone(&whitened.rows));
    // Rows without anything, as of a plane curve's third coordinate, depend on the others whatever these are.
    let is_empty = |row: &usize| plain.rows().row(*row).1.iter().all(|value| *value == 0.0);
    let (empty, some): (Vec<usize>, Vec<usize>) = (0..count).partition(is_empty);
    let mut inner = if empty.is_empty() { factor(&plain)? } else { factor(&plain.select(&some))? };
    let (mut kept, mut dependencies) = (None, Vec::new());
    if !empty.is_empty() {
        dependencies = empty.into_iter().map(|row| Dependency { row, combination: Vec::new() }).collect();
    }
    if inner.rank() < some.len() {
        let (independent, others) = reduce(if through { &plain } else { system }, solver)?;
        inner = factor(&plain.select(&independent).finely())?;
        if inner.rank() < independent.len() {
            return Err(ill_conditioned(solver, system, inner.as_ref()));
        }
        (kept, dependencies) = (Some(independent), others);
    } else if some.len() < count {
        kept = Some(some);
    }
    let part = vec![0.0; kept.as_ref().map_or(0, |kept| kept.len() * sides)];
    let e = vec![0.0; whitened.rows.width() * sides];
    let mut core = Core { inner, whitened, e, sides, kept, part };
    let rows: Vec<u32> = match &core.kept {
        None => (0..count as u32).collect(),
        Some(kept) => kept.iter().map(|&row| row as u32).collect(),
    };
    match Refinement::new(system, rows.into_iter(), |rhs, d| core.solve_into(rhs, d)) {
        Some(refinement) => Ok(Box::new(InMetric { core, refinement, dependencies })),
        None => Err(ill_conditioned(solver, system, core.inner.as_ref())),
    }
}

#[cold]
fn ill_conditioned(solver: &str, system: &System, inner: &dyn Factored) -> SolveError {
    let condition = inner.diagnosis().condition;
    if solver == HouseholderQr.name() {
        return beyond(system, condition);
    }
    SolveError::IllConditioned { solver: solver.into(), condition, better: "householder-qr" }
}

impl Core {
    fn solve_into(&mut self, rhs: &[f64], d: &mut [f64]) {
        match &self.kept {
            None => self.inner.solve_into(rhs, &mut self.e),
            Some(kept) => {
                gather(kept, self.sides, rhs, &mut self.part);
                self.inner.solve_into(&self.part, &mut self.e);
            }
        }
        self.whitened.finish(&self.e, d, self.sides);
    }
}

/// The entries of some rows.
fn gather(kept: &[usize], sides: usize, all: &[f64], part: &mut [f64]) {
    for (part, &row) in part.chunks_exact_mut(sides).zip(kept) {
        part.copy_from_slice(&all[row * sides..(row + 1) * sides]);
    }
}

impl Factored for InMetric {
    fn solver(&self) -> &str {
        self.core.inner.solver()
    }

    fn rank(&self) -> usize {
        self.core.inner.rank()
    }

    fn diagnosis(&self) -> Diagnosis {
        Diagnosis { dependencies: self.dependencies.clone(), ..self.core.inner.diagnosis() }
    }

    fn solve_into(&mut self, rhs: &[f64], d: &mut [f64]) {
        let Self { core, refinement, .. } = self;
        core.solve_into(rhs, d);
        refinement.refine(rhs, d, |missed, more| core.solve_into(missed, more));
    }

    /// `F W⁻¹ Fᵀ λ = b` is the same equation in the metric's coordinates.
    fn multipliers_into(&mut self, rhs: &[f64], multipliers: &mut [f64]) {
        let Core { inner, kept, part, sides, .. } = &mut self.core;
        let Some(kept) = kept else { return inner.multipliers_into(rhs, multipliers) };
        gather(kept, *sides, rhs, part);
        let mut some = vec![0.0; part.len()];
        inner.multipliers_into(part, &mut some);
        multipliers.fill(0.0);
        for (some, &row) in some.chunks_exact(*sides).zip(&*kept) {
            multipliers[row * *sides..(row + 1) * *sides].copy_from_slice(some);
        }
    }
}
