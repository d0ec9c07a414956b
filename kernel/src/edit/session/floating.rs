//! Locations that float: unknowns of the problem beside the control vertices, without weight.
//!
//! With every location at rest an event is what it is without them; the adjustment `d(u)` that it gives is the least for these
//! parameters `u`. Of `φ(u) = ½ dᵀWd` the derivative is known from the multipliers `λ`: in
//! `½ dᵀWd - λᵀ(f(P + d, u) - b)` all else is stationary, so `∂φ/∂u = -λᵀ ∂f/∂u`, on the adjusted shapes. So `φ` goes downhill by a
//! quasi-Newton iteration (Broyden, Fletcher, Goldfarb and Shanno 1970) from the second derivative `L_sᵀ (F W⁻¹Fᵀ)⁻¹ L_s`,
//! `L_s = ∂f/∂u`, which is right where the adjustment vanishes. Steps stay within half of a control vertex's share of the
//! domain, and go downhill always: what is found is the nearest local minimum, whatever strategy the event needs inside.

use nalgebra::{DMatrix, DVector};
use smallvec::SmallVec;

use super::Session;
use crate::edit::EditError;
use crate::error::{Error, Result};
use crate::functional::{Functional, Store, rows_of, value_of};
use crate::problem::ConstraintId;
use crate::problem::bound::BoundConstraint;
use crate::problem::conflict::quoted;
use crate::shape::{Derivative, Interval, Location, Shape, grid_or_row};
use crate::solve::Sense;

/// Steps, and how often one is halved.
const STEPS: usize = 200;
const HALVINGS: usize = 40;
/// The share of the decrease that the derivative promises, which a step must bring.
const SHARE: f64 = 1e-4;
/// A step that promises to gain less than this part of `φ` is the last, and need not prove it: rounding hides it.
const ROUNDING: f64 = 1e-13;
/// An adjustment of this part of the largest coordinate is none.
const NOTHING: f64 = 4.0 * f64::EPSILON;
/// Locations nearer than this share of a control vertex's part of the domain are one.
const ONE: f64 = 2e-2;
/// Steps to the foot of a target, where what is asked cannot hold where it starts.
const FEET: usize = 60;

/// Puts the constraints from number `first` on whose locations float where they start; which they are.
///
/// # Errors
/// When one says that it floats and cannot move.
pub(super) fn anchor(bound: &mut [BoundConstraint], first: usize) -> Result<Vec<ConstraintId>> {
    let mut floating = Vec::new();
    for BoundConstraint { constraint, id, .. } in &mut bound[first..] {
        let functional = &constraint.functional;
        if !functional.floats() {
            continue;
        }
        let place = functional.location();
        let Some(anchored) =
            place.and_then(|(_, location)| functional.moved(location)).filter(|f| !f.floats())
        else {
            let name = functional.describe();
            return Err(Error::Invalid(format!("{name} says that its location floats, and cannot be moved")));
        };
        constraint.functional = anchored;
        floating.push(*id);
    }
    Ok(floating)
}

/// A parameter that floats: of which constraint it is the location's first or second, and where it may be.
#[derive(Debug, Clone)]
struct Parameter {
    constraint: usize,
    second: bool,
    interval: Interval,
    /// The longest step.
    limit: f64,
}

impl Parameter {
    fn order(&self) -> Derivative {
        Derivative { u: usize::from(!self.second), v: usize::from(self.second) }
    }

    fn confined(&self, value: f64) -> f64 {
        let Interval { start, end, periodic } = self.interval;
        if periodic { start + (value - start).rem_euclid(end - start) } else { value.clamp(start, end) }
    }
}

/// What an event found with the locations where they are.
struct Found {
    half: f64,
    slope: DVector<f64>,
}

type Values = SmallVec<[f64; 4]>;

impl<S: Shape> Session<S> {
    /// Where a constraint whose location floated came to rest.
    pub(super) fn rests_at(&self, bound: &BoundConstraint) -> Option<Vec<f64>> {
        let floats = self.floating.contains(&bound.id);
        let (_, location) = bound.constraint.functional.location().filter(|_| floats)?;
        Some(match location {
            Location::Curve(u) => vec![u],
            Location::Surface(u, v) | Location::Face(_, u, v) => vec![u, v],
            Location::Vertex(_) => return None,
        })
    }

    /// Solves for the present targets, the locations that float being unknowns too. They start where the last event left them.
    /// Where it fails, they and the shapes are as before.
    pub(super) fn floating_event(&mut self) -> Result<(), EditError> {
        let parameters = self.parameters()?;
        let (before, d) = (self.values(&parameters), self.prepared.d.clone());
        // A best effort is for what cannot be met anywhere.
        let effort = std::mem::replace(&mut self.problem.best_effort, false);
        let result = self.float(&parameters);
        self.problem.best_effort = effort;
        let Err(error) = result else { return Ok(()) };
        self.locate(&parameters, &before)?;
        if effort {
            return self.event();
        }
        self.prepared.d = d;
        self.place();
        Err(error)
    }

    fn parameters(&self) -> Result<Vec<Parameter>> {
        let mut all = Vec::new();
        for (constraint, bound) in self.problem.bound.iter().enumerate() {
            if !self.floating.contains(&bound.id) {
                continue;
            }
            let Some((shape, location)) = bound.constraint.functional.location() else { continue };
            if location.is_on_face() {
                return Err(Error::Invalid(format!(
                    "{}: a location on a surface of many faces does not float yet: give \"at\"",
                    bound.constraint.describe()
                )));
            }
            let shape = self.problem.shapes().get(shape)?;
            let (domain, grid) = (shape.domain(), grid_or_row(shape));
            for (k, interval) in domain.iter().enumerate().take(location.parameters()) {
                let along = if k == 0 && domain.len() == 2 { grid.rows } else { grid.columns };
                let limit = 0.5 * (interval.end - interval.start) / along.max(1) as f64;
                all.push(Parameter { constraint, second: k == 1, interval: *interval, limit });
            }
        }
        Ok(all)
    }

    /// The parameters' present values.
    fn values(&self, parameters: &[Parameter]) -> Values {
        let value = |p: &Parameter| match self.functional(p.constraint).location() {
            Some((_, Location::Curve(u))) => u,
            Some((_, Location::Surface(u, v))) => {
                if p.second {
                    v
                } else {
                    u
                }
            }
            _ => 0.0,
        };
        parameters.iter().map(value).collect()
    }

    fn functional(&self, constraint: usize) -> &dyn Functional {
        self.problem.bound[constraint].constraint.functional.as_ref()
    }

    /// Puts the parameters to these values, the shapes back to where they start, and prepares there.
    fn locate(&mut self, parameters: &[Parameter], values: &[f64]) -> Result<(), EditError> {
        self.restore();
        self.put_at(parameters, values);
        self.prepare_again()
    }

    fn put_at(&mut self, parameters: &[Parameter], values: &[f64]) {
        for (k, p) in parameters.iter().enumerate() {
            let to = match (p.second, parameters.get(k + 1)) {
                (true, _) => continue,
                (false, Some(other)) if other.second => Location::Surface(values[k], values[k + 1]),
                _ => Location::Curve(values[k]),
            };
            let bound = &mut self.problem.bound[p.constraint];
            if let Some(moved) = bound.constraint.functional.moved(to) {
                bound.constraint.functional = moved;
            }
        }
    }

    fn float(&mut self, parameters: &[Parameter]) -> Result<(), EditError> {
        let mut at = self.values(parameters);
        let mut solves = 0;
        let mut here = match self.look(parameters, &mut solves) {
            Ok(found) => found,
            // What cannot hold where it starts may hold at the foot of its target.
            Err(error) => {
                let Some(feet) = self.feet(parameters, &at)? else { return Err(error) };
                self.locate(parameters, &feet)?;
                at = feet;
                self.look(parameters, &mut solves).map_err(|_| error)?
            }
        };
        let mut bend = self.bend(parameters)?;
        let rest = NOTHING * self.prepared.check.reach;
        for _ in 0..STEPS {
            // What is asked holds there, or all but holds, without a change.
            if (2.0 * here.half).sqrt() <= rest {
                break;
            }
            let Some(step) = downhill(parameters, &at, &here.slope, &bend) else { break };
            let promised = -step.dot(&here.slope);
            if promised.is_nan() || promised <= f64::MIN_POSITIVE {
                break;
            }
            let sure = promised <= ROUNDING * here.half;
            let (mut share, mut found) = (1.0, None);
            for _ in 0..HALVINGS {
                let to: Values = parameters
                    .iter()
                    .zip(&at)
                    .zip(&step)
                    .map(|((p, u), s)| p.confined(u + share * s))
                    .collect();
                if to == at {
                    break;
                }
                let tried = self.locate(parameters, &to).and_then(|()| self.look(parameters, &mut solves));
                match tried {
                    Ok(next) if sure || next.half <= here.half - SHARE * share * promised => {
                        found = Some((to, next));
                        break;
                    }
                    // Uphill, or where what is asked cannot hold, or not be prepared.
                    _ => share *= 0.5,
                }
            }
            let Some((to, next)) = found else {
                self.locate(parameters, &at)?;
                self.look(parameters, &mut solves)?;
                break;
            };
            bend = updated(bend, &(&step * share), &(&next.slope - &here.slope))
                .map_or_else(|| self.bend(parameters), Ok)?;
            (at, here) = (to, next);
            if sure {
                break;
            }
        }
        self.prepared.iterations = solves;
        self.check_apart(parameters)
    }

    /// Whether locations that are to meet one target on one shape came to rest apart. Where they meet, the shape stands still and
    /// turns back between them: that is a stationary point of the least adjustment, and nothing that anybody asks for.
    fn check_apart(&self, parameters: &[Parameter]) -> Result<(), EditError> {
        let firsts = || parameters.iter().enumerate().filter(|(_, p)| !p.second);
        for (i, p) in firsts() {
            for (_, q) in firsts().skip_while(|(k, _)| *k <= i) {
                let (one, other) = (&self.problem.bound[p.constraint], &self.problem.bound[q.constraint]);
                let (own, second) = (&one.constraint.functional, &other.constraint.functional);
                let (Some((_, at)), Some((_, beside))) = (own.location(), second.location()) else {
                    continue;
                };
                if one.constraint.axis != other.constraint.axis
                    || one.target != other.target
                    || !self.near(p, at, beside)
                    || self.is_implied(p.constraint)
                    || self.is_implied(q.constraint)
                {
                    continue;
                }
                if own.moved(beside).is_some_and(|moved| self.asks_the_same(moved.as_ref(), second.as_ref()))
                {
                    return Err(Error::Invalid(format!(
                        "{} and {} come to hold at one place ({at}), where the shape would stand still and turn back: leave one of \
                         them out, or start it where the shape should pass a second time",
                        quoted(&one.constraint.label()),
                        quoted(&other.constraint.label())
                    ))
                    .into());
                }
            }
        }
        Ok(())
    }

    /// Whether rows of a constraint follow from others, so that it asks for nothing by itself.
    fn is_implied(&self, constraint: usize) -> bool {
        let assembly = &self.prepared.assembly;
        self.prepared.dependencies.iter().any(|row| assembly.constraint_of(row.row) == constraint)
    }

    /// Whether two functionals have the same rows on the shapes as they are.
    fn asks_the_same(&self, one: &dyn Functional, other: &dyn Functional) -> bool {
        let shapes = self.problem.shapes();
        let [mut first, mut second] = [Store::default(), Store::default()];
        let rows = |functional: &dyn Functional, store: &mut Store| {
            rows_of(functional, &shapes, &mut store.rows(&shapes)).is_ok()
        };
        rows(one, &mut first) && rows(other, &mut second) && first.equations().eq(second.equations())
    }

    /// Whether two locations are so near to one another, beside a control vertex's share of the domain, that they are one.
    fn near(&self, p: &Parameter, a: Location, b: Location) -> bool {
        let close = |a: f64, b: f64, p: &Parameter| {
            let Interval { start, end, periodic } = p.interval;
            let apart = (a - b).abs();
            (if periodic { apart.min(end - start - apart) } else { apart }) <= ONE * p.limit
        };
        match (a, b) {
            (Location::Curve(a), Location::Curve(b)) => close(a, b, p),
            (Location::Surface(a, c), Location::Surface(b, d)) => {
                let second = self.parameters().ok().and_then(|all| {
                    all.into_iter().find(|other| other.constraint == p.constraint && other.second)
                });
                close(a, b, p) && second.is_some_and(|second| close(c, d, &second))
            }
            _ => false,
        }
    }

    /// The event with the locations where they are: half the squared length of its adjustment, and how that changes with the
    /// parameters.
    fn look(&mut self, parameters: &[Parameter], solves: &mut usize) -> Result<Found, EditError> {
        self.event()?;
        *solves += self.prepared.iterations;
        let (system, d) = (&self.prepared.assembly.system, &self.prepared.d);
        let half = match system.whitened()? {
            None => 0.5 * d.iter().map(|v| v * v).sum::<f64>(),
            Some(mut whitened) => 0.5 * whitened.squared_length(d, system.sides()),
        };
        let multipliers = self.multipliers();
        let mut slope = DVector::zeros(parameters.len());
        for (slope, p) in slope.iter_mut().zip(parameters) {
            let along = self.along(p)?;
            *slope = -multipliers[p.constraint].iter().zip(&along).map(|(m, a)| m * a).sum::<f64>();
        }
        Ok(Found { half, slope })
    }

    /// How the numbers that a constraint asks for change along a parameter, on the shapes as they are.
    fn along(&self, p: &Parameter) -> Result<Vec<f64>> {
        let (constraint, functional) =
            (&self.problem.bound[p.constraint].constraint, self.functional(p.constraint));
        let mut all = vec![0.0; functional.equations()];
        functional.along(&self.problem.shapes(), p.order(), &mut all)?;
        Ok(all.into_iter().enumerate().filter(|(e, _)| constraint.asks(*e)).map(|(_, a)| a).collect())
    }

    /// `L_sᵀ (F W⁻¹Fᵀ)⁻¹ L_s`, on the shapes as they are.
    fn bend(&mut self, parameters: &[Parameter]) -> Result<DMatrix<f64>, EditError> {
        let along: Vec<Vec<f64>> = parameters.iter().map(|p| self.along(p)).collect::<Result<_>>()?;
        let prepared = self.prepared.as_mut();
        let (mut right, mut answer) = (vec![0.0; prepared.rhs.len()], vec![0.0; prepared.rhs.len()]);
        let n = parameters.len();
        let mut bend = DMatrix::zeros(n, n);
        for (j, p) in parameters.iter().enumerate() {
            right.fill(0.0);
            for (slot, a) in prepared.assembly.slots(p.constraint).iter().zip(&along[j]) {
                right[prepared.assembly.entry(slot)] = *a;
            }
            prepared.factored.multipliers_into(&right, &mut answer);
            for (i, q) in parameters.iter().enumerate() {
                let slots = prepared.assembly.slots(q.constraint).iter().zip(&along[i]);
                bend[(i, j)] = slots.map(|(slot, a)| answer[prepared.assembly.entry(slot)] * a).sum();
            }
        }
        Ok(0.5 * (&bend + bend.transpose()))
    }

    /// Where the values at the parameters are nearest to what is wanted, on the shapes as they start: Gauss and Newton's
    /// iteration, each step halved until the distance decreases. `None` where nothing moves.
    fn feet(&mut self, parameters: &[Parameter], from: &Values) -> Result<Option<Values>, EditError> {
        self.restore();
        let mut at = from.clone();
        let mut k = 0;
        while k < parameters.len() {
            let count = 1 + usize::from(parameters.get(k + 1).is_some_and(|next| next.second));
            let own = k..k + count;
            k += count;
            if self.problem.bound[parameters[own.start].constraint].constraint.sense() != Sense::Equal {
                continue;
            }
            let mut best = self.distance(&parameters[own.start])?;
            for _ in 0..FEET {
                let wanted = DVector::from_vec(self.missing(&parameters[own.start])?);
                let columns: Vec<Vec<f64>> =
                    parameters[own.clone()].iter().map(|p| self.along(p)).collect::<Result<_>>()?;
                let jacobian = DMatrix::from_fn(wanted.len(), count, |i, j| columns[j][i]);
                let normal = jacobian.transpose() * &jacobian;
                let Some(step) = normal.cholesky().map(|c| c.solve(&(jacobian.transpose() * &wanted))) else {
                    break;
                };
                let (mut share, mut moved) = (1.0, false);
                for _ in 0..HALVINGS {
                    let mut to = at.clone();
                    for (i, p) in own.clone().zip(&parameters[own.clone()]) {
                        to[i] = p.confined(at[i] + (share * step[i - own.start]).clamp(-p.limit, p.limit));
                    }
                    self.put_at(parameters, &to);
                    let reached = self.distance(&parameters[own.start])?;
                    if reached < best {
                        (at, best, moved) = (to, reached, true);
                        break;
                    }
                    share *= 0.5;
                }
                if !moved {
                    self.put_at(parameters, &at);
                    break;
                }
            }
        }
        Ok((at != *from).then_some(at))
    }

    /// Wanted minus present numbers of a constraint.
    fn missing(&self, p: &Parameter) -> Result<Vec<f64>> {
        let BoundConstraint { constraint, target, .. } = &self.problem.bound[p.constraint];
        let mut value = vec![0.0; target.len()];
        value_of(constraint.functional.as_ref(), &self.problem.shapes(), &mut value)?;
        let asked = target.iter().zip(value).enumerate().filter(|(e, _)| constraint.asks(*e));
        Ok(asked.map(|(_, (target, value))| target - value).collect())
    }

    fn distance(&self, p: &Parameter) -> Result<f64> {
        Ok(self.missing(p)?.iter().fold(0.0_f64, |m, v| m.hypot(*v)))
    }
}

/// The step downhill: `-B⁻¹g` for the parameters that are not held at an end of their domain, no longer than each may go. `None`
/// where all rest.
fn downhill(
    parameters: &[Parameter],
    at: &Values,
    slope: &DVector<f64>,
    bend: &DMatrix<f64>,
) -> Option<DVector<f64>> {
    let held = |k: usize| {
        let Interval { start, end, periodic } = parameters[k].interval;
        !periodic && (at[k] <= start && slope[k] > 0.0 || at[k] >= end && slope[k] < 0.0)
    };
    let free: Vec<usize> = (0..parameters.len()).filter(|&k| slope[k] != 0.0 && !held(k)).collect();
    if free.is_empty() {
        return None;
    }
    let part = DMatrix::from_fn(free.len(), free.len(), |i, j| bend[(free[i], free[j])]);
    let right = DVector::from_fn(free.len(), |i, _| -slope[free[i]]);
    let newton = part.cholesky().map(|c| c.solve(&right)).filter(|s| s.iter().all(|v| v.is_finite()));
    // Where nothing is known of the second derivative: as far as may be.
    let some = newton.unwrap_or_else(|| right.map(|v| v.signum() * f64::MAX));
    let excess = some.iter().zip(&free).fold(1.0_f64, |m, (s, &k)| m.max(s.abs() / parameters[k].limit));
    let mut step = DVector::zeros(parameters.len());
    for (s, &k) in some.iter().zip(&free) {
        step[k] = if excess > 1e100 { s.signum() * parameters[k].limit } else { s / excess };
    }
    Some(step)
}

/// The second derivative that a step taught; `None` where it taught nothing that is positive definite.
fn updated(bend: DMatrix<f64>, step: &DVector<f64>, change: &DVector<f64>) -> Option<DMatrix<f64>> {
    let gained = step.dot(change);
    let taken = &bend * step;
    let own = step.dot(&taken);
    let learned = gained > 1e-8 * own && own > 0.0 && gained.is_finite();
    learned.then(|| bend - &taken * taken.transpose() / own + change * change.transpose() / gained)
}
