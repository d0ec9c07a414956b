//! What solving gave, told.

use std::any::Any;
use std::collections::BTreeMap;

use super::bound::Bound;
use super::check::missed_by;
use super::event::overflow;
use super::{Session, view};
use crate::edit::EditError;
use crate::edit::assembly::Slot;
use crate::edit::report::{ConstraintReport, Report};
use crate::edit::smooth::is_ours;
use crate::error::Result;
use crate::functional::{Accuracy, Shapes};
use crate::measure::{Measured, measure};
use crate::shape::Shape;
use crate::solve::Dependency;

impl<S: Shape> Session<S> {
    /// What solving gave: residuals (measured afresh on the shapes as they are), rank, condition, multipliers. Not free: not
    /// for every event.
    pub fn report(&self) -> Report {
        self.account_for(&self.measured(&view(&self.shapes)))
    }

    /// The same, once it is sure that what was solved for holds.
    pub(super) fn judged(&self) -> Result<Report, EditError> {
        let measured = self.measured(&view(&self.shapes));
        let report = self.account_for(&measured);
        if !report.adjustment.is_finite() {
            return Err(overflow());
        }
        if self.solved && !report.best_effort {
            self.judge(&report.solver, &measured)?;
        }
        Ok(report)
    }

    /// What each constraint misses on shapes of the same kinds as the session's.
    pub(super) fn measured(&self, shapes: &Shapes<'_>) -> Vec<Result<Measured>> {
        let start = self.start.iter().fold(0.0_f64, |m, (_, _, p)| p.coords.amax().max(m));
        let sides = self.prepared.assembly.system.sides();
        let right =
            self.prepared.rhs.chunks_exact(sides).map(|b| b.iter().fold(0.0_f64, |m, b| m.max(b.abs())));
        let rows = self.prepared.assembly.system.rows();
        // The longest way that one of the linear equations asks for by itself.
        let asked = right.enumerate().filter(|(_, b)| *b > 0.0).map(|(row, b)| b / rows.norm(row));
        let reach = start + asked.filter(|way| way.is_finite()).fold(0.0, f64::max);
        let look = |bound: &Bound| {
            let Bound { constraint, target, .. } = bound;
            let asks = |equation| constraint.asks(equation);
            measure(shapes, constraint.functional.as_ref(), constraint.sense(), target, &asks, reach)
        };
        self.bound.iter().map(look).collect()
    }

    /// Whether what was measured is allowed.
    pub(super) fn judge(&self, solver: &str, measured: &[Result<Measured>]) -> Result<(), EditError> {
        for (bound, measured) in self.bound.iter().zip(measured) {
            match measured {
                Err(error) => return Err(error.clone().into()),
                Ok(measured) if measured.holds() => {}
                Ok(measured) => {
                    return Err(missed_by(solver, &bound.constraint, measured.verdict()).into());
                }
            }
        }
        Ok(())
    }

    fn account_for(&self, measured: &[Result<Measured>]) -> Report {
        let shapes = view(&self.shapes);
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
        let (redundant, against): (Vec<&Dependency>, Vec<&Dependency>) =
            diagnosis.dependencies.iter().partition(|d| !self.best_effort || agrees(d));
        report.best_effort = !against.is_empty();
        let mut lost: BTreeMap<usize, usize> = BTreeMap::new();
        for dependency in redundant {
            *lost.entry(prepared.assembly.constraint_of(dependency.row)).or_default() += 1;
        }
        let mut smooth = 0;
        for (k, lost) in lost {
            if is_ours(&self.bound[k].constraint) {
                smooth += lost * sides;
                continue;
            }
            let rows = prepared.assembly.slots(k).len() / sides;
            let name = self.bound[k].constraint.describe();
            report.redundant.push(if lost < rows { format!("{name} ({lost} of {rows} rows)") } else { name });
        }
        for (row, bounds) in prepared.bounds.iter().flat_map(|b| b.active.iter().map(move |row| (*row, b))) {
            let name = self.bound[bounds.full.constraint_of(row)].constraint.label();
            if !report.active.contains(&name) {
                report.active.push(name);
            }
        }
        let mut adjustment = 0.0_f64;
        for &(shape, vertex, before) in &self.start {
            let now = self.shapes[shape as usize].control_vertices()[vertex as usize];
            // Step by step, since squares overflow far below where lengths do.
            adjustment = (now - before).iter().fold(adjustment, |length, d| length.hypot(*d));
        }
        report.adjustment = adjustment;
        for (bound, measured) in self.bound.iter().zip(measured) {
            let nan = Measured { error: f64::NAN, ..Measured::default() };
            let measured = measured.as_ref().unwrap_or(&nan);
            // Not `max`, which would pass over NaN.
            if !report.residual.is_nan() && (measured.error > report.residual || measured.error.is_nan()) {
                report.residual = measured.error;
            }
            report.constraints.push(ConstraintReport {
                name: bound.constraint.label(),
                residual: measured.error,
                between: measured.between.map(|between| between.error),
                multipliers: Vec::new(),
            });
        }
        self.add_multipliers(&mut report);
        if !self.solved && report.residual > 0.0 {
            report.notes.push("nothing has been solved for since it was asked".into());
        }
        self.tell_smoothness(&mut report, smooth);
        for bound in &self.bound {
            if let Some(note) = reversed(&shapes, bound) {
                report.notes.push(note);
            }
            report.notes.extend(bound.constraint.functional.notes());
        }
        for (bound, measured) in self.bound.iter().zip(measured) {
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

    fn add_multipliers(&self, report: &mut Report) {
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
        for (k, constraint) in report.constraints.iter_mut().enumerate() {
            let part = prepared.assembly.slots(k);
            let of = |slot: &Slot| multipliers[prepared.assembly.entry(slot)];
            constraint.multipliers = match &prepared.bounds {
                None => part.iter().map(of).collect(),
                // Zero for an inequality that is not active.
                Some(bounds) => {
                    let known = |all: &Slot| part.iter().find(|s| s.equation == all.equation);
                    bounds.full.slots(k).iter().map(|all| known(all).map_or(0.0, of)).collect()
                }
            };
        }
        let bordering = prepared.border.iter().flat_map(|border| border.rows.iter().zip(&border.multipliers));
        for (&(k, _), &multiplier) in bordering {
            report.constraints[k].multipliers.push(multiplier);
        }
    }
}

/// A tangent that was asked to be parallel to a direction but came out the other way round.
fn reversed(shapes: &Shapes<'_>, bound: &Bound) -> Option<String> {
    let any: &dyn Any = bound.constraint.functional.as_ref();
    let tangent = any.downcast_ref::<crate::functional::Tangent>()?;
    let along = tangent.sense(shapes)?;
    (along < 0.0).then(|| format!("{} now points against its direction", bound.constraint.describe()))
}
