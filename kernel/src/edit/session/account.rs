//! What solving gave, told.

use std::any::Any;

use super::Session;
use crate::edit::report::{ConstraintReport, Report, Smoothness};
use crate::error::Result;
use crate::functional::{Accuracy, Shapes};
use crate::measure::Measured;
use crate::problem::EditError;
use crate::problem::assembly::Slot;
use crate::problem::bound::Bound;
use crate::problem::judge::reach;
use crate::problem::solution::{overflow, redundant};
use crate::problem::view;
use crate::shape::Shape;
use crate::solve::Dependency;

impl<S: Shape> Session<S> {
    /// What solving gave: residuals (measured afresh on the shapes as they are), rank, condition, multipliers. Not free: not
    /// for every event.
    pub fn report(&self) -> Report {
        self.account_for(&self.measured())
    }

    /// The same, once it is sure that what was solved for holds.
    pub(super) fn judged(&self) -> Result<Report, EditError> {
        let measured = self.measured();
        let report = self.account_for(&measured);
        if !report.adjustment.is_finite() {
            return Err(overflow());
        }
        if self.solved && !report.best_effort {
            self.problem.judge(&report.solver, &measured)?;
        }
        Ok(report)
    }

    /// What each constraint misses on the shapes as they are.
    fn measured(&self) -> Vec<Result<Measured>> {
        let start = self.start.iter().fold(0.0_f64, |m, (_, _, p)| p.coords.amax().max(m));
        let reach = reach(&self.prepared.assembly, &self.prepared.rhs, start);
        self.problem.measured(&view(&self.problem.shapes), reach)
    }

    fn account_for(&self, measured: &[Result<Measured>]) -> Report {
        let shapes = view(&self.problem.shapes);
        let prepared = &self.prepared;
        let diagnosis = prepared.factored.diagnosis();
        let sides = prepared.assembly.system.sides();
        let bordering = prepared.border.as_ref().map_or(0, |border| border.rows.len());
        let mut report = Report {
            solver: prepared.factored.solver().to_owned(),
            equations: prepared.assembly.slots.len() + bordering,
            rank: diagnosis.rank * sides + bordering,
            condition: diagnosis.condition,
            iterations: prepared.iterations,
            convergence: prepared.convergence,
            ..Report::default()
        };
        // Of dependent rows, those that agree with the others are redundant; those that do not are missed, which only a
        // best effort allows.
        let agrees = |dependency: &&Dependency| {
            dependency.agrees(&prepared.assembly.system, &prepared.rhs, &prepared.size, &prepared.d)
        };
        let (implied, against): (Vec<&Dependency>, Vec<&Dependency>) =
            diagnosis.dependencies.iter().partition(|d| !self.problem.best_effort || agrees(d));
        report.best_effort = !against.is_empty();
        let (names, smooth) = redundant(&self.problem.bound, &prepared.assembly, &mut implied.into_iter());
        report.redundant = names;
        for (row, bounds) in prepared.bounds.iter().flat_map(|b| b.active.iter().map(move |row| (*row, b))) {
            let name = self.problem.bound[bounds.full.constraint_of(row)].constraint.label();
            if !report.active.contains(&name) {
                report.active.push(name);
            }
        }
        let mut adjustment = 0.0_f64;
        for &(shape, vertex, before) in &self.start {
            let now = self.problem.shapes[shape as usize].control_vertices()[vertex as usize];
            // Step by step, since squares overflow far below where lengths do.
            adjustment = (now - before).iter().fold(adjustment, |length, d| length.hypot(*d));
        }
        report.adjustment = adjustment;
        for (bound, measured) in self.problem.bound.iter().zip(measured) {
            let nan = Measured { error: f64::NAN, ..Measured::default() };
            let measured = measured.as_ref().unwrap_or(&nan);
            // Not `max`, which would pass over NaN.
            if !report.residual.is_nan() && (measured.error > report.residual || measured.error.is_nan()) {
                report.residual = measured.error;
            }
            report.constraints.push(ConstraintReport {
                name: bound.constraint.label(),
                residual: measured.error,
                location: self.rests_at(bound),
                between: measured.between.map(|between| between.error),
                multipliers: Vec::new(),
            });
        }
        for (constraint, multipliers) in report.constraints.iter_mut().zip(self.multipliers()) {
            constraint.multipliers = multipliers;
        }
        if !self.solved && report.residual > 0.0 {
            report.notes.push("nothing has been solved for since it was asked".into());
        }
        // What is kept smooth comes last, in the account of the constraints too: it is told apart from what was asked.
        report.smooth = Smoothness { redundant: smooth, ..self.problem.smoothness(&shapes) };
        report.constraints.truncate(report.constraints.len().saturating_sub(report.smooth.knots));
        report.notes.extend(report.smooth.notes());
        for bound in &self.problem.bound {
            if let Some(note) = reversed(&shapes, bound) {
                report.notes.push(note);
            }
            report.notes.extend(bound.constraint.functional.notes());
        }
        for (bound, measured) in self.problem.bound.iter().zip(measured) {
            let between = measured.as_ref().ok().and_then(|measured| measured.between);
            if let (Some(between), Accuracy::Within(tolerance)) =
                (between, bound.constraint.functional.accuracy())
            {
                report.notes.push(format!(
                    "{}: {:.3e} apart at most, of the {tolerance:e} allowed",
                    bound.constraint.label(),
                    between.error
                ));
            }
        }
        report
    }

    /// The multipliers of each constraint, one for each equation that is asked of it.
    pub(super) fn multipliers(&self) -> Vec<Vec<f64>> {
        let prepared = &self.prepared;
        let mut multipliers = vec![0.0; prepared.rhs.len()];
        let mut rhs = prepared.rhs.clone();
        if let Some(border) = &prepared.border {
            let mut taken = vec![0.0; rhs.len()];
            border.taken(&mut taken);
            rhs.iter_mut().zip(taken).for_each(|(b, t)| *b -= t);
        }
        // Solving for them needs the factor's scratch; a report is rare enough to factor once more.
        if let Ok(mut factored) = self.solver.factor(&prepared.assembly.system) {
            factored.multipliers_into(&rhs, &mut multipliers);
        }
        let of = |slot: &Slot| multipliers[prepared.assembly.entry(slot)];
        let each = (0..self.problem.bound.len()).map(|k| {
            let part = prepared.assembly.slots(k);
            match &prepared.bounds {
                None => part.iter().map(of).collect(),
                // Zero for an inequality that is not active.
                Some(bounds) => {
                    let known = |all: &Slot| part.iter().find(|s| s.equation == all.equation);
                    bounds.full.slots(k).iter().map(|all| known(all).map_or(0.0, of)).collect()
                }
            }
        });
        let mut each: Vec<Vec<f64>> = each.collect();
        let bordering = prepared.border.iter().flat_map(|border| border.rows.iter().zip(&border.multipliers));
        for (&(k, _), &multiplier) in bordering {
            each[k].push(multiplier);
        }
        each
    }
}

/// A tangent that was asked to be parallel to a direction but came out the other way round.
fn reversed(shapes: &Shapes<'_>, bound: &Bound) -> Option<String> {
    let any: &dyn Any = bound.constraint.functional.as_ref();
    let tangent = any.downcast_ref::<crate::functional::Tangent>()?;
    let along = tangent.sense(shapes)?;
    (along < 0.0).then(|| format!("{} now points against its direction", bound.constraint.describe()))
}
