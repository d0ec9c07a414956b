//! Constraints that are not linear: sequential quadratic programming.

use super::mixing::Mixing;
use super::progress::Progress;
use super::strategy::Strategy;
use super::support::strayed;
use super::{Session, put, snapshot};
use crate::edit::report::Convergence;
use crate::error::Error;
use crate::functional::Linearity;
use crate::measure::{PROPORTION, ROUNDING, error_of};
use crate::problem::EditError;
use crate::problem::assembly::{Assembly, Slot};
use crate::problem::bound::{BoundConstraint, right_hand_side};
use crate::problem::check::{excess, near_conflict};
use crate::problem::conflict::quoted;
use crate::problem::constraint::Constraint;
use crate::problem::program::{Bounds, Solved, senses};
use crate::problem::solution::overflow;
use crate::problem::{Numbers, view};
use crate::shape::Shape;
use crate::solve::{Sense, SolveError};
use crate::text::figure;

/// Iterations before a problem is given up.
const ITERATIONS: usize = 100;
/// A constraint that is not linear is met at this error, relative to the numbers it is made of; one that is, to rounding.
const MET: f64 = 1e-12;
/// The adjustment stands still where a whole step would change it by no more than this, relative to itself; after half of
/// the iterations, where rounding keeps an ill-conditioned one moving, by no more than that.
const STILL: [f64; 2] = [1e-10, 1e-7];
/// So does one that a whole step would change by no more than this part of the shapes' size: where everything holds to rounding from the start, the adjustment
/// is rounding, and a share of itself says nothing.
const REST: f64 = 1e-12;
/// The share of the decrease that the linear problem promises, which a step must bring.
const SHARE: f64 = 1e-4;
/// The shortest step, as a share of the whole one.
const SHORTEST: f64 = 1e-6;
/// A step may be worse than the one before, but not worse than the worst of so many.
const MEMORY: usize = 5;

/// The constraints at the present shapes: rows, wanted minus present values, the sizes of these numbers.
pub(super) struct Linearized {
    pub(super) assembly: Assembly,
    pub(super) rhs: Numbers,
    pub(super) size: Numbers,
    /// The largest error of each constraint, and the size to measure it by.
    errors: Vec<(f64, f64)>,
    /// What error of each is none.
    allowed: Vec<f64>,
}

/// `½ dᵀWd + Σ μ|violation|`, exact for `μ` above the multipliers (Han 1977): where it is least, so is the adjustment
/// under the constraints.
struct Merit {
    penalty: Vec<f64>,
    /// `½ dᵀWd` and the violations of the last points.
    points: Vec<(f64, Vec<f64>)>,
}

impl Merit {
    fn value(&self, half: f64, violations: &[f64]) -> f64 {
        half + self.penalty.iter().zip(violations).map(|(p, v)| p * v).sum::<f64>()
    }

    /// The worst of the last points. Accepting what is worse than the last one only keeps whole steps near a curved
    /// constraint from being cut down (Grippo, Lampariello and Lucidi 1986).
    fn reference(&self) -> f64 {
        self.points.iter().map(|(half, violations)| self.value(*half, violations)).fold(f64::MIN, f64::max)
    }

    fn remember(&mut self, half: f64, violations: Vec<f64>) {
        if self.points.len() == MEMORY {
            self.points.remove(0);
        }
        self.points.push((half, violations));
    }

    /// Keeps the penalties above the multipliers of a solved problem.
    fn cover(&mut self, solved: &mut Solved) {
        let mut multipliers = vec![0.0; solved.rhs.len()];
        solved.factored.multipliers_into(&solved.rhs, &mut multipliers);
        for (k, multiplier) in multipliers.iter().enumerate() {
            let entry = solved.part.as_ref().map_or(k, |(_, kept)| kept[k]);
            if let Some(penalty) = self.penalty.get_mut(entry).filter(|p| **p < 1.5 * multiplier.abs()) {
                *penalty = 3.0 * multiplier.abs();
            }
        }
    }
}

impl<S: Shape> Session<S> {
    /// The least adjustment under constraints that are not linear: a sequence of linear problems, linearized where the
    /// shapes are, with the whole adjustment since the start as unknown, so that it converges to the least one. Steps are
    /// mixed with those before, or shortened, until a merit function decreases. A failure leaves the shapes as they were.
    /// `looks`: how often the constraints may be looked at.
    pub(super) fn iterate(&mut self, looks: usize) -> Result<(), EditError> {
        if self.alternating.is_some() {
            return Err(SolveError::Unsupported(
                "the axes cannot alternate here: a constraint that is not linear depends on the others, there are \
                 inequalities, or they are too many; let all axes move together"
                    .into(),
            )
            .into());
        }
        let state = snapshot(&self.problem.shapes, &self.prepared);
        let d = self.prepared.d.clone();
        let result = self.iterate_from_start(looks);
        if result.is_err() {
            put(&mut self.problem.shapes, &state);
            self.prepared.d = d;
        }
        result
    }

    fn iterate_from_start(&mut self, most: usize) -> Result<(), EditError> {
        self.restore();
        let mut here = self.linearize()?;
        let sides = here.assembly.system.sides();
        // The metric alone, without rows.
        let mut metric = here.assembly.system.select(&[]).whitened()?;
        let mut half = |d: &[f64]| match &mut metric {
            None => 0.5 * d.iter().map(|v| v * v).sum::<f64>(),
            Some(whitened) => 0.5 * whitened.squared_length(d, sides),
        };
        let constraints: Vec<&Constraint> = self.problem.constraints().collect();
        let senses = senses(&here.assembly, &constraints);
        let mut merit = Merit { penalty: vec![0.0; here.rhs.len()], points: Vec::new() };
        merit.remember(0.0, violations(&senses, sides, &here.rhs));
        let mut convergence = Convergence { change: f64::INFINITY, ..Convergence::default() };
        let mut mixing = Mixing::default();
        let mut progress = Progress::new(most);
        for iteration in 1..=ITERATIONS {
            convergence.iterations = iteration;
            // b + F d: the unknown is the adjustment from the start, not from here.
            let from = self.prepared.d.clone();
            let mut wanted = Numbers::from_elem(0.0, here.rhs.len());
            here.assembly.system.rows().multiply(&from, sides, &mut wanted);
            wanted.iter_mut().zip(&here.rhs).for_each(|(w, b)| *w += b);
            let mut solved =
                self.problem.program(self.solver.as_ref(), &here.assembly, &wanted, &here.size)?;
            if solved.d.iter().any(|d| !d.is_finite()) {
                return Err(overflow());
            }
            let step: Vec<f64> = solved.d.iter().zip(&from).map(|(to, from)| to - from).collect();
            convergence.change = match (largest(&step), largest(&solved.d)) {
                (0.0, _) => 0.0,
                (step, whole) => step / whole,
            };
            let gave_way = solved.softened && self.linear_ones_give_way(&here, &wanted, &solved.d);
            let met = here.errors.iter().zip(&here.allowed).enumerate().all(|(k, ((error, _), allowed))| {
                error <= allowed
                    || gave_way
                        && self.problem.bound[k].constraint.functional.linearity() == Linearity::Linear
            });
            let still = convergence.change <= STILL[usize::from(iteration > ITERATIONS / 2)]
                || largest(&step) <= REST * self.prepared.check.reach;
            if met && still {
                let right = (&solved.rhs[..], &solved.size[..]);
                let part = solved.part.as_ref().map_or(&here.assembly, |(part, _)| part);
                let out = excess(&part.system, solved.factored.as_ref(), right, &solved.d, PROPORTION)?;
                if let Some(out) = out.filter(|_| !self.problem.forced && !solved.softened) {
                    let error =
                        near_conflict(&self.problem.bound, part, solved.factored.as_mut(), &solved.rhs, out);
                    return Err(error.into());
                }
                self.prepared.iterations = iteration;
                self.prepared.gave_way = gave_way;
                self.prepared.convergence = Some(convergence);
                self.keep(
                    solved,
                    Bounds { full: here.assembly, rhs: wanted, size: here.size, active: Vec::new() },
                );
                return Ok(());
            }
            merit.cover(&mut solved);
            let missed = violations(&senses, sides, &here.rhs);
            // dᵀW(d⁺ - d) from three lengths; the linear problem takes all violations away.
            let slope = half(&solved.d) - half(&from) - half(&step);
            let promised = slope - merit.value(0.0, &missed);
            let reference = merit.reference();
            let rounding = MET * (reference.abs() + merit.value(0.0, &here.size));
            // First what the last steps taught, then the whole step, then ever shorter ones.
            let mut mixed = mixing.next(&from, &step);
            let mut share = 1.0;
            // The rows and the values where the shapes will be, and the values at each point tried.
            let mut looks = 2;
            let mut failure = None;
            loop {
                match &mixed {
                    Some(mixed) => self.prepared.d.copy_from_slice(mixed),
                    None => {
                        let points = from.iter().zip(&solved.d).zip(&step);
                        for (d, ((from, to), step)) in self.prepared.d.iter_mut().zip(points) {
                            *d = if share < 1.0 { from + share * step } else { *to };
                        }
                    }
                }
                self.place();
                looks += 1;
                // Where something cannot be asked (a tangent that vanishes), the step is too long.
                match self.violations(&here.assembly, &senses) {
                    Err(error) => failure = Some(error),
                    Ok(violations) => {
                        let half = half(&self.prepared.d);
                        let reached = merit.value(half, &violations);
                        if solved.softened || reached <= reference + SHARE * share * promised + rounding {
                            merit.remember(half, violations);
                            break;
                        }
                    }
                }
                if mixed.take().is_some() {
                    mixing.forget();
                    continue;
                }
                share *= 0.5;
                if share < SHORTEST {
                    return Err(failure.map_or_else(|| self.given_up(&here, &convergence), EditError::from));
                }
            }
            convergence.shortened += usize::from(share < 1.0);
            let error = here.errors.iter().fold(0.0_f64, |m, (error, size)| m.max(error / size));
            if !progress.goes_on(looks, error, convergence.change) {
                break;
            }
            here = self.linearize()?;
        }
        Err(self.given_up(&here, &convergence))
    }

    pub(super) fn linearize(&mut self) -> Result<Linearized, EditError> {
        let assembly = self.problem.assemble(false)?;
        if !assembly.vertices().eq(self.prepared.assembly.vertices()) {
            self.prepared.strayed = assembly.vertices().chain(self.prepared.assembly.vertices()).collect();
            return Err(strayed().into());
        }
        let shapes = view(&self.problem.shapes);
        let (mut rhs, mut size) = (Numbers::new(), Numbers::new());
        let errors = right_hand_side(&shapes, &self.problem.bound, &assembly, &mut rhs, &mut size)?;
        let each = self.problem.bound.iter().zip(&errors).enumerate();
        let allowed = each.map(|(k, (bound, (_, size)))| {
            let functional = &bound.constraint.functional;
            let own = functional.accuracy().tolerance();
            if functional.linearity() != Linearity::Linear {
                return own + MET * size;
            }
            // As events without anything that is not linear judge them.
            let rough = |slot: &Slot| {
                assembly.system.rows().row(slot.row as usize).1.iter().map(|v| v.abs()).sum::<f64>()
            };
            let rough = assembly.slots(k).iter().map(rough).fold(0.0, f64::max);
            own + ROUNDING * (size + rough * self.prepared.check.reach)
        });
        let allowed = allowed.collect();
        Ok(Linearized { assembly, rhs, size, errors, allowed })
    }

    /// Whether equations that are linear are all that a best effort misses: the least squares are those of linear rows then, wherever the
    /// shapes are, and what is not linear holds beside them.
    fn linear_ones_give_way(&self, here: &Linearized, wanted: &[f64], d: &[f64]) -> bool {
        let (assembly, sides) = (&here.assembly, here.assembly.system.sides());
        let mut reached = Numbers::from_elem(0.0, wanted.len());
        assembly.system.rows().multiply(d, sides, &mut reached);
        self.problem.bound.iter().enumerate().all(|(k, bound)| {
            let sense = bound.constraint.sense();
            let holds = |slot: &Slot| {
                let at = assembly.entry(slot);
                error_of(sense, wanted[at] - reached[at]) <= here.allowed[k]
            };
            let linear = bound.constraint.functional.linearity() == Linearity::Linear;
            (linear && sense == Sense::Equal) || assembly.slots(k).iter().all(holds)
        })
    }

    /// By how much each entry misses its side at the present shapes.
    fn violations(&self, assembly: &Assembly, senses: &[Sense]) -> Result<Vec<f64>, Error> {
        let (mut rhs, mut size) = (Numbers::new(), Numbers::new());
        right_hand_side(&view(&self.problem.shapes), &self.problem.bound, assembly, &mut rhs, &mut size)?;
        Ok(violations(senses, assembly.system.sides(), &rhs))
    }

    /// What was solved last, for reports and for the next event.
    fn keep(&mut self, solved: Solved, full: Bounds) {
        let prepared = self.prepared.as_mut();
        (prepared.factored, prepared.dependencies) = (solved.factored, solved.dependencies);
        (prepared.rhs, prepared.size) = (solved.rhs, solved.size);
        let (part, bounds) = match solved.part {
            None => (full.full, None),
            Some((part, _)) => (part, Some(Box::new(Bounds { active: solved.active, ..full }))),
        };
        (prepared.assembly, prepared.strategy) = (part, Strategy::Sequential(bounds));
        prepared.assembly.decide(solved.tolerance);
    }

    /// Why it is given up: where what is asked is out of all proportion, that says more than where the iteration has come to.
    #[cold]
    fn given_up(&self, here: &Linearized, convergence: &Convergence) -> EditError {
        let mut wanted = Numbers::from_elem(0.0, here.rhs.len());
        here.assembly.system.rows().multiply(&self.prepared.d, here.assembly.system.sides(), &mut wanted);
        wanted.iter_mut().zip(&here.rhs).for_each(|(w, b)| *w += b);
        let solved = self.problem.program(self.solver.as_ref(), &here.assembly, &wanted, &here.size);
        if let Some(mut solved) = solved.ok().filter(|solved| !solved.softened && !self.problem.forced) {
            let part = solved.part.as_ref().map_or(&here.assembly, |(part, _)| part);
            let right = (&solved.rhs[..], &solved.size[..]);
            let out = excess(&part.system, solved.factored.as_ref(), right, &solved.d, PROPORTION);
            if let Ok(Some(out)) = out {
                return near_conflict(&self.problem.bound, part, solved.factored.as_mut(), &solved.rhs, out)
                    .into();
            }
        }
        self.unsolved(here, convergence)
    }

    fn unsolved(&self, here: &Linearized, convergence: &Convergence) -> EditError {
        let iterations = convergence.iterations;
        let missed = here.errors.iter().zip(&here.allowed);
        let each = missed.map(|((error, _), allowed)| if error <= allowed { 0.0 } else { *error });
        let worst = each
            .zip(&self.problem.bound)
            .fold((0.0, None), |worst, (error, b)| if error > worst.0 { (error, Some(b)) } else { worst });
        match worst {
            (residual, Some(bound)) => {
                let mut worst = quoted(&bound.constraint.label());
                if let [wanted] = bound.target[..] {
                    worst = format!("{worst}, {wanted} wanted", wanted = figure(wanted));
                }
                SolveError::NotConverged { iterations, residual, worst }.into()
            }
            _ => self.still_moving(iterations, convergence.change).into(),
        }
    }

    /// All holds, but the adjustment is not the least one yet.
    pub(super) fn still_moving(&self, iterations: usize, change: f64) -> SolveError {
        let curved = |b: &&BoundConstraint| b.constraint.functional.linearity() != Linearity::Linear;
        let named = self.problem.bound.iter().filter(curved).map(|b| quoted(&b.constraint.label()));
        SolveError::StillMoving { iterations, change, beside: named.collect::<Vec<_>>().join(", ") }
    }
}

fn largest(v: &[f64]) -> f64 {
    v.iter().fold(0.0, |m, v| m.max(v.abs()))
}

fn violations(senses: &[Sense], sides: usize, rhs: &[f64]) -> Vec<f64> {
    rhs.iter().enumerate().map(|(entry, wanted)| error_of(senses[entry / sides], *wanted)).collect()
}
