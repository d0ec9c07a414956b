//! What solving gave, told.

use std::any::Any;
use std::collections::BTreeMap;

use super::bound::{Bound, error_of};
use super::{Session, view};
use crate::edit::assembly::Slot;
use crate::edit::conflict::agrees;
use crate::edit::report::{ConstraintReport, Report};
use crate::functional::{Shapes, value_of};
use crate::shape::Shape;

impl<S: Shape> Session<S> {
    /// What solving gave: residuals, rank, condition, multipliers. Not free: not for every event.
    pub fn report(&self) -> Report {
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
        let mut lost: BTreeMap<usize, usize> = BTreeMap::new();
        for dependency in &diagnosis.dependencies {
            *lost.entry(prepared.assembly.constraint_of(dependency.row)).or_default() += 1;
        }
        for (k, lost) in lost {
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
            adjustment = adjustment.hypot((now - before).norm());
        }
        report.adjustment = adjustment;
        for bound in &self.bound {
            let mut value = vec![0.0; bound.constraint.functional.equations()];
            let residual = match value_of(bound.constraint.functional.as_ref(), &shapes, &mut value) {
                Err(_) => f64::NAN,
                Ok(()) => (0..value.len())
                    .filter(|&e| bound.constraint.asks(e))
                    .map(|e| error_of(bound.constraint.sense(), bound.target[e] - value[e]))
                    .fold(0.0, f64::max),
            };
            report.residual = report.residual.max(residual);
            report.constraints.push(ConstraintReport {
                name: bound.constraint.label(),
                residual,
                multipliers: Vec::new(),
            });
        }
        self.add_multipliers(&mut report);
        report.best_effort = self.best_effort
            && diagnosis
                .dependencies
                .iter()
                .any(|d| !agrees(&prepared.assembly, d, &prepared.rhs, &prepared.size));
        for bound in &self.bound {
            if let Some(note) = reversed(&shapes, bound) {
                report.notes.push(note);
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
