//! What solving gave, told.

use crate::text::short;
use std::any::Any;

use smallvec::SmallVec;

use super::Session;
use super::prepared::Prepared;
use super::strategy::Strategy;
use crate::edit::report::{ConstraintReport, Report, Smoothness};
use crate::error::Result;
use crate::functional::{Accuracy, Join, Shapes, Tangent};
use crate::measure::Measured;
use crate::problem::EditError;
use crate::problem::assembly::{Assembly, Slot};
use crate::problem::bound::BoundConstraint;
use crate::problem::check::{NOTABLE, excess, fighting};
use crate::problem::judge::{AllMeasured, reach};
use crate::problem::solution::{overflow, redundant};
use crate::problem::{Numbers, angle, view};
use crate::shape::Shape;
use crate::solve::Dependency;
use crate::text::figure;

impl<S: Shape> Session<S> {
    /// What solving gave: residuals (measured afresh on the shapes as they are), rank, condition, multipliers. Not free: not
    /// for every event.
    pub fn report(&self) -> Report {
        self.account_for(&self.measured(), self.multipliers())
    }

    /// The same, once it is sure that what was solved for holds.
    pub(super) fn judged(&mut self) -> Result<Report, EditError> {
        let measured = self.measured();
        let multipliers = self.own_multipliers();
        let report = self.account_for(&measured, multipliers);
        if !report.adjustment.is_finite() {
            return Err(overflow());
        }
        if self.solved && !report.best_effort {
            self.problem.judge(&report.solver, &view(&self.problem.shapes), &measured)?;
        }
        Ok(report)
    }

    /// What each constraint misses on the shapes as they are.
    fn measured(&self) -> AllMeasured {
        let start = self.start.iter().fold(0.0_f64, |m, (_, _, p)| p.coords.amax().max(m));
        let reach = reach(&self.prepared.assembly, &self.prepared.rhs, start);
        self.problem.measured(&view(&self.problem.shapes), reach)
    }

    fn account_for(&self, measured: &[Result<Measured>], multipliers: Multipliers) -> Report {
        let shapes = view(&self.problem.shapes);
        let prepared = &self.prepared;
        let diagnosis = prepared.factored.diagnosis();
        let sides = prepared.assembly.system.sides();
        let bordering = prepared.strategy.border().map_or(0, |border| border.rows.len());
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
        report.best_effort = prepared.gave_way || !against.is_empty();
        let (names, smooth) = redundant(&self.problem.bound, &prepared.assembly, &mut implied.into_iter());
        report.redundant = names;
        for (row, bounds) in
            prepared.strategy.bounds().into_iter().flat_map(|b| b.active.iter().map(move |row| (*row, b)))
        {
            let name = self.problem.bound[bounds.full.constraint_of(row)].constraint.label();
            if !report.active.contains(&name) {
                report.active.push(name);
            }
        }
        report.adjustment = self.adjustment();
        report.constraints.reserve_exact(self.problem.bound.len());
        for ((bound, measured), multipliers) in self.problem.bound.iter().zip(measured).zip(multipliers) {
            let nan = Measured { error: f64::NAN, ..Measured::default() };
            let measured = measured.as_ref().unwrap_or(&nan);
            // Not `max`, which would pass over NaN.
            if !report.residual.is_nan() && (measured.error > report.residual || measured.error.is_nan()) {
                report.residual = measured.error;
            }
            report.constraints.push(ConstraintReport {
                name: bound.constraint.title(),
                residual: measured.error,
                dimension: bound.constraint.functional.dimension(),
                location: self.rests_at(bound),
                between: measured.between.map(|between| between.error),
                multipliers,
            });
        }
        if report.best_effort {
            // What is missed is neither said by the others nor only touched.
            let rounding = report.tolerance();
            let missed: Vec<String> = (self.problem.bound.iter().zip(&report.constraints))
                .filter(|(_, told)| told.residual > rounding)
                .map(|(bound, _)| bound.constraint.label())
                .collect();
            report.redundant.retain(|name| !missed.contains(name));
            report.active.retain(|name| !missed.contains(name));
        }
        if !self.solved && report.residual > 0.0 {
            report.notes.push("nothing has been solved for since it was asked".into());
        }
        if self.solved && !report.best_effort {
            report.notes.extend(self.strain());
        }
        // What is kept smooth comes last, in the account of the constraints too: it is told apart from what was asked.
        report.smooth = Smoothness { redundant: smooth, ..self.problem.smoothness(&shapes) };
        report
            .constraints
            .truncate(report.constraints.len().saturating_sub(report.smooth.knots + report.smooth.bonds));
        report.notes.extend(report.smooth.notes());
        for bound in &self.problem.bound {
            if let Some(note) = reversed(&shapes, bound) {
                report.notes.push(note);
            }
            report.notes.extend(bound.constraint.functional.notes());
            if let Ok(Some(told)) = bound.constraint.functional.told(&shapes) {
                report.notes.push(format!("{}: {}", bound.constraint.label(), told.found));
            }
        }
        for (bound, measured) in self.problem.bound.iter().zip(measured) {
            let between = measured.as_ref().ok().and_then(|measured| measured.between);
            if let (Some(between), Accuracy::Within(tolerance)) =
                (between, bound.constraint.functional.accuracy())
            {
                let crease = crease(&shapes, bound).map_or_else(String::new, |degrees| {
                    format!("; the angle between them, which nothing bounds, is {} at most", angle(degrees))
                });
                report.notes.push(format!(
                    "{}: {} apart at most, of the {tolerance} allowed{crease}",
                    bound.constraint.label(),
                    figure(between.error)
                ));
            }
        }
        report
    }

    /// How far all vertices have moved: `(Σ‖dᵢ‖²)^½`.
    fn adjustment(&self) -> f64 {
        let moves = || {
            self.start.iter().flat_map(|&(shape, vertex, before)| {
                let now = self.problem.shapes[shape as usize].control_vertices()[vertex as usize];
                <[f64; 3]>::from(now - before)
            })
        };
        let squares: f64 = moves().map(|d| d * d).sum();
        if squares.is_nan() || (squares > 1e-280 && squares < f64::INFINITY) {
            return squares.sqrt();
        }
        // Squares overflow and vanish far before lengths do.
        let largest = moves().fold(0.0_f64, |most, d| most.max(d.abs()));
        let part = |d: f64| (d / largest) * (d / largest);
        if largest > 0.0 && largest.is_finite() {
            largest * moves().map(part).sum::<f64>().sqrt()
        } else {
            largest
        }
    }

    /// What is worth saying of an adjustment that is long beside what its linear equations ask one by one: no near conflict
    /// yet, or one that is forced.
    fn strain(&self) -> Option<String> {
        let Prepared { assembly, factored, rhs, size, d, strategy, .. } = self.prepared.as_ref();
        if self.alternating.is_some() {
            return None;
        }
        let d = strategy.border().map_or(&d[..], |border| &border.linear);
        let found = excess(&assembly.system, factored.as_ref(), (rhs, size), d, NOTABLE).ok()??;
        let mut again = self.solver.factor(&assembly.system).ok()?;
        let names = fighting(&self.problem.bound, assembly, again.as_mut(), rhs);
        Some(format!(
            "the adjustment is {} times what its equations ask one by one: nearly contradictory: {}",
            short(found.times),
            names.join(", ")
        ))
    }

    /// The multipliers of each constraint, one for each equation that is asked of it.
    pub(super) fn multipliers(&self) -> Multipliers {
        let Prepared { assembly, rhs, strategy, .. } = self.prepared.as_ref();
        // Solving for them needs the factor's scratch; a report is rare enough to factor once more.
        let again = self.solver.factor(&assembly.system).ok();
        multipliers(self.problem.bound.len(), assembly, rhs, strategy, |rhs, out| {
            if let Some(mut factored) = again {
                factored.multipliers_into(rhs, out);
            }
        })
    }

    /// The same by the factor that there is.
    pub(super) fn own_multipliers(&mut self) -> Multipliers {
        let Prepared { assembly, rhs, strategy, factored, .. } = self.prepared.as_mut();
        multipliers(self.problem.bound.len(), assembly, rhs, strategy, |rhs, out| {
            factored.multipliers_into(rhs, out);
        })
    }
}

/// The multipliers of each constraint.
pub(super) type Multipliers = SmallVec<[Vec<f64>; 1]>;

fn multipliers(
    constraints: usize,
    assembly: &Assembly,
    rhs: &Numbers,
    strategy: &Strategy,
    solve: impl FnOnce(&[f64], &mut [f64]),
) -> Multipliers {
    let (border, bounds) = (strategy.border(), strategy.bounds());
    let mut multipliers = Numbers::from_elem(0.0, rhs.len());
    match border {
        None => solve(rhs, &mut multipliers),
        Some(border) => {
            let (mut rhs, mut taken) = (rhs.clone(), vec![0.0; rhs.len()]);
            border.taken(&mut taken);
            rhs.iter_mut().zip(taken).for_each(|(b, t)| *b -= t);
            solve(&rhs, &mut multipliers);
        }
    }
    let of = |slot: &Slot| multipliers[assembly.entry(slot)];
    let each = (0..constraints).map(|k| {
        let part = assembly.slots(k);
        match bounds {
            None => part.iter().map(of).collect(),
            // Zero for an inequality that is not active.
            Some(bounds) => {
                let known = |all: &Slot| part.iter().find(|s| s.equation == all.equation);
                bounds.full.slots(k).iter().map(|all| known(all).map_or(0.0, of)).collect()
            }
        }
    });
    let mut each: Multipliers = each.collect();
    for (&(k, _), &multiplier) in border.iter().flat_map(|b| b.rows.iter().zip(&b.multipliers)) {
        each[k].push(multiplier);
    }
    each
}

/// The largest angle in degrees between two surfaces that are joined along an edge.
fn crease(shapes: &Shapes<'_>, bound: &BoundConstraint) -> Option<f64> {
    let any: &dyn Any = bound.constraint.functional.as_ref();
    any.downcast_ref::<Join>()?.crease(shapes).ok()?.map(f64::to_degrees)
}

/// A tangent that was asked to be parallel to a direction but came out the other way round.
fn reversed(shapes: &Shapes<'_>, bound: &BoundConstraint) -> Option<String> {
    let any: &dyn Any = bound.constraint.functional.as_ref();
    let tangent = any.downcast_ref::<Tangent>()?;
    let along = tangent.sense(shapes)?;
    (along < 0.0).then(|| format!("{} now points against its direction", bound.constraint.describe()))
}
