//! An event with constraints that are not linear, beside linear ones that are factored once: Newton's iteration for the
//! least adjustment with all axes together, or one axis an event (paper 2).

use super::Session;
use super::progress::{Progress, looks};
use crate::error::Error;
use crate::functional::Linearity;
use crate::measure::ITERATED;
use crate::problem::EditError;
use crate::problem::bound::{BoundConstraint, right_hand_side};
use crate::problem::conflict::quoted;
use crate::problem::view;
use crate::shape::Shape;
use crate::solve::{Sense, SolveError};
use crate::text::figure;

/// Iterations before an event is given up.
const ITERATIONS: usize = 200;
/// A constraint is met at this error, relative to the value wanted.
const MET: f64 = 2e-13;
/// Where it does not get better than that, it is met at this share of its terms; after more iterations than are usual, at what
/// the answer is judged by ([`ITERATED`]).
const ROUNDED: f64 = 1e-13;
/// A row that misses its target by less than this share of its terms tells no more whether things get better: where the target
/// is zero but for rounding, its error relative to that is any number.
const NOISE: f64 = 16.0 * f64::EPSILON;
/// Most events take no more iterations than these.
const USUAL: usize = 20;
/// After an event the adjustment changes by less than this share of itself: its length, which is flat at the least one, is
/// least to the square of it.
const STILL: f64 = 1e-6;
/// The same when the session ends. The iteration converges linearly: drags by a tenth to the whole of a shape's size take 5 to
/// 13 iterations to the first and 4 to 11 more to this, which would be half as much again for every event.
const SETTLED: f64 = 1e-11;
/// A share of the tangential way below which shortening it further does not help.
const SHORTEST: f64 = 1.0 / 64.0;
/// The most of the tangential way that is taken at once.
const LONGEST: f64 = 8.0;
/// What may be taken beyond all of it, as a share of the adjustment.
const BOLD: f64 = 0.25;

/// Alternating axes are for constraints that are linear in each of them, and for equations: what one axis makes up for may
/// break a bound that only another axis could meet again, so that an event would fail though there is a solution.
pub(super) fn check_alternating(bound: &[BoundConstraint]) -> Result<(), EditError> {
    let with = |linearity| bound.iter().find(|b| b.constraint.functional.linearity() == linearity);
    if let Some(b) = with(Linearity::Nonlinear) {
        return Err(SolveError::Unsupported(format!(
            "{} is not linear in each axis, so the axes cannot alternate; let them move together",
            quoted(&b.constraint.describe())
        ))
        .into());
    }
    let limit = bound.iter().find(|b| b.constraint.sense() != Sense::Equal);
    match (with(Linearity::Multilinear), limit) {
        (Some(kept), Some(limit)) => Err(SolveError::Unsupported(format!(
            "the axes cannot alternate where there are bounds: the one axis that makes up for {} may break {}, and only \
             another axis could meet it again; let them move together",
            quoted(&kept.constraint.describe()),
            quoted(&limit.constraint.label())
        ))
        .into()),
        _ => Ok(()),
    }
}

impl<S: Shape> Session<S> {
    /// Solves for the present targets, the nonlinear constraints as border of the linear ones. The shapes are as before
    /// where it fails.
    pub(super) fn curved_event(&mut self) -> Result<(), EditError> {
        if let Some(border) = self.prepared.strategy.border_mut() {
            border.before.copy_from_slice(&self.prepared.d);
        }
        let mut result = if self.alternating.is_some() { self.one_axis() } else { self.all_axes() };
        // Where whole steps do not arrive, shortened ones may.
        if self.alternating.is_none()
            && let Err(error) = &result
        {
            let on_the_way = matches!(error, EditError::Geometry(_));
            let most = looks(&self.problem.bound);
            let used = match error {
                EditError::Solve(
                    SolveError::NotConverged { iterations, .. } | SolveError::StillMoving { iterations, .. },
                ) => *iterations,
                _ => 0,
            };
            match self.iterate(most.saturating_sub(used).max(most / 4)) {
                Ok(()) => result = Ok(()),
                // That whole steps went where something cannot be asked says less than how far shortened ones came.
                Err(other) if on_the_way => result = Err(other),
                Err(_) => {}
            }
        }
        if result.is_err()
            && let Some(border) = self.prepared.strategy.border()
        {
            self.prepared.d.copy_from_slice(&border.before);
            self.place();
        }
        result
    }

    /// Sequential least adjustments: each linearizes where the last one arrived and asks for the least adjustment *since the
    /// start*, so that what it converges to does not depend on the way there.
    fn all_axes(&mut self) -> Result<(), EditError> {
        self.solve_linear()?;
        let Some(border) = self.prepared.strategy.border_mut() else { return Ok(()) };
        border.linear.copy_from_slice(&self.prepared.d);
        border.step_from_base(&self.problem.bound, &mut self.prepared.d);
        self.check_finite()?;
        self.descend(STILL)?;
        self.check_linear()?;
        if let Some(border) = self.prepared.strategy.border_mut() {
            border.moved = true;
        }
        Ok(())
    }

    /// Brings the last event's adjustment nearer to the least one than an event does, for good. Where that fails, the shapes
    /// stay as the event left them: all constraints hold there.
    pub(super) fn polish(&mut self) {
        let Some(border) = self.prepared.strategy.border_mut().filter(|border| border.moved) else { return };
        if self.alternating.is_some() {
            return;
        }
        border.before.copy_from_slice(&self.prepared.d);
        let iterations = self.prepared.iterations;
        let mut result = self.solve_linear().map(|_| ());
        if let Some(border) = self.prepared.strategy.border_mut() {
            border.linear.copy_from_slice(&self.prepared.d);
            self.prepared.d.copy_from_slice(&border.before);
        }
        result = result.and_then(|()| self.descend(SETTLED));
        if result.is_ok() {
            self.prepared.iterations += iterations;
        } else if let Some(border) = self.prepared.strategy.border() {
            self.prepared.d.copy_from_slice(&border.before);
            self.prepared.iterations = iterations;
            self.place();
        }
    }

    /// Goes on from an adjustment near the least one until all constraints hold and it changes by less than `still` of itself,
    /// or by no less than before where only rounding is left.
    fn descend(&mut self, still: f64) -> Result<(), EditError> {
        let (mut share, mut tangential, mut missed) = (1.0, f64::INFINITY, f64::INFINITY);
        let mut changed = f64::INFINITY;
        let mut progress = Progress::new(looks(&self.problem.bound));
        for iteration in 1..=ITERATIONS {
            self.place();
            let prepared = self.prepared.as_mut();
            let Some(border) = prepared.strategy.border_mut() else { return Ok(()) };
            border.evaluate(&view(&self.problem.shapes), &self.problem.bound)?;
            let (mut error, mut worst) = border.error(&self.problem.bound);
            if error >= 0.5 * missed {
                (error, worst) = border.error_above(&self.problem.bound, NOISE, &prepared.base, &prepared.d);
            }
            // Below 1e-12 there may be no more to gain than rounding; each row for itself, as one may never do better.
            let stalled = error >= 0.5 * missed;
            let rounded = if iteration > USUAL { ITERATED } else { ROUNDED };
            let rounding =
                |row| border.is_rounding(&self.problem.bound, row, rounded, &prepared.base, &prepared.d);
            let met = error <= MET
                || stalled
                    && (0..border.rows.len())
                        .all(|row| border.error_of(&self.problem.bound, row) <= MET || rounding(row));
            match border.project(&prepared.assembly, prepared.factored.as_mut()) {
                Ok(true) => {}
                Ok(false) => return Err(self.vanished(worst).into()),
                Err(row) => return Err(self.overflow(row)),
            }
            let prepared = self.prepared.as_mut();
            let Some(border) = prepared.strategy.border_mut() else { return Ok(()) };
            let step = border.step_from_here(&self.problem.bound, share, &prepared.d);
            // What most events never come to, and need not pay for.
            let lingers = iteration >= USUAL;
            let turned = if lingers { border.remember_way() } else { 0.0 };
            if lingers && share != 1.0 {
                border.stay(&prepared.assembly, prepared.factored.as_mut());
            }
            let floor = 4.0 * f64::EPSILON * border.reach;
            let rests = step.change <= STILL * step.whole && step.change >= changed;
            if met && (rests || step.change <= (still * step.whole).max(floor)) {
                prepared.iterations = iteration;
                return Ok(());
            }
            if !step.whole.is_finite() {
                return Err(self.overflow(worst));
            }
            if iteration == ITERATIONS || !progress.goes_on(1, error, step.change / step.whole) {
                let change = step.change / step.whole;
                return Err(if met {
                    self.still_moving(iteration, change).into()
                } else {
                    self.not_converged(iteration, worst).into()
                });
            }
            // Where the tangential way hardly gets shorter, it is too long: the shape is bent more than the metric says.
            // Where shorter ways do not help for long, the way tells by how it has turned: back, and it is still too long;
            // or it goes on as before, and more of it is needed. A way that even gets longer leaves a place where the
            // adjustment is stationary and not least.
            if step.tangential > 0.8 * tangential {
                if iteration > USUAL && turned > 0.0 {
                    share = (2.0 * share).min((BOLD * step.whole / step.tangential).clamp(1.0, LONGEST));
                } else if share > SHORTEST {
                    share *= 0.5;
                }
            }
            (tangential, missed, changed) = (step.tangential, error, step.change);
            std::mem::swap(&mut prepared.d, &mut border.next);
        }
        Ok(())
    }

    /// One axis makes up for what the others change (paper 2): the linear constraints are met from where the shape is, then
    /// the multilinear ones, linear in that axis, by it alone. The next event takes the next axis.
    fn one_axis(&mut self) -> Result<(), EditError> {
        let turn = self.alternating.unwrap_or(0);
        self.rebase()?;
        let Some(border) = self.prepared.strategy.border_mut() else { return Ok(()) };
        border.linear.copy_from_slice(&self.prepared.d);
        let mut axis = None;
        for iteration in 1..=ITERATIONS {
            self.check_finite()?;
            self.place();
            let prepared = self.prepared.as_mut();
            let Some(border) = prepared.strategy.border_mut() else { return Ok(()) };
            let mut worst = 0;
            let candidates = match axis {
                Some(axis) => axis..axis + 1,
                None => turn..turn + 3,
            };
            let mut sound = false;
            for candidate in candidates {
                border.evaluate(&view(&self.problem.shapes), &self.problem.bound)?;
                let error;
                (error, worst) = border.error(&self.problem.bound);
                if error <= MET && iteration > 1 {
                    prepared.iterations = iteration - 1;
                    self.check_linear()?;
                    self.alternating = Some((candidate + 1) % 3);
                    return Ok(());
                }
                border.narrow(candidate % 3);
                match border.project(&prepared.assembly, prepared.factored.as_mut()) {
                    Ok(true) => {
                        (axis, sound) = (Some(candidate), true);
                        break;
                    }
                    Ok(false) => {}
                    Err(row) => return Err(self.overflow(row)),
                }
            }
            if !sound {
                return Err(self.vanished(worst).into());
            }
            border.restore(&self.problem.bound, &mut prepared.d);
            if iteration == ITERATIONS {
                return Err(self.not_converged(iteration, worst).into());
            }
        }
        Ok(())
    }

    /// The shapes as they are become those that are adjusted; `d` what meets the linear constraints from there.
    fn rebase(&mut self) -> Result<(), EditError> {
        let prepared = self.prepared.as_mut();
        for (base, d) in prepared.base.iter_mut().zip(prepared.d.chunks_exact(3)) {
            *base += crate::Vector::new(d[0], d[1], d[2]);
        }
        prepared.d.fill(0.0);
        if let Some(border) = prepared.strategy.border_mut() {
            border.before.fill(0.0);
        }
        let shapes = view(&self.problem.shapes);
        right_hand_side(
            &shapes,
            &self.problem.bound,
            &prepared.assembly,
            &mut prepared.rhs,
            &mut prepared.size,
        )?;
        prepared.meet(&self.problem.bound, None);
        match prepared.disagreement() {
            None => Ok(()),
            Some(at) => {
                self.prepared.d.fill(0.0);
                Err(self.conflict(at).into())
            }
        }
    }

    fn vanished(&self, row: usize) -> SolveError {
        let name = quoted(&self.border_name(row));
        let how = if self.alternating.is_some() { " by moving vertices along one axis" } else { "" };
        let text = format!(
            "{name} cannot be met{how}: where the shape has come to, what could change it is all held by the other \
             constraints (or nothing can); release one of them, or ask for less at once"
        );
        SolveError::Conflict { constraints: vec![self.border_name(row)], knot: None, text }
    }

    fn overflow(&self, row: usize) -> EditError {
        let name = self.border_name(row);
        Error::Invalid(format!("{name}: the numbers on the way there overflow; ask for less at once")).into()
    }

    fn not_converged(&self, iterations: usize, row: usize) -> SolveError {
        let (wanted, residual) = self.prepared.strategy.border().map_or((0.0, 0.0), |border| {
            let (k, e) = border.rows[row];
            (
                self.problem.bound[k].target[e],
                (self.problem.bound[k].target[e] - border.here.value[row]).abs(),
            )
        });
        let worst = format!("{}, {wanted} wanted", quoted(&self.border_name(row)), wanted = figure(wanted));
        SolveError::NotConverged { iterations, residual, worst }
    }

    fn border_name(&self, row: usize) -> String {
        let row = self.prepared.strategy.border().and_then(|border| border.rows.get(row));
        row.map_or_else(String::new, |&(k, _)| self.problem.bound[k].constraint.describe())
    }
}
