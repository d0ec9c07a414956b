//! One event: new targets, new vertices.

use super::bound::right_hand_side;
use super::effort::soften;
use super::prepared::response_of;
use super::{Session, put, snapshot, view};
use crate::edit::EditError;
use crate::edit::ask::Constraint;
use crate::edit::assembly::Assembly;
use crate::edit::conflict::{agrees, explain, involved};
use crate::error::Error;
use crate::functional::Linearity;
use crate::shape::Shape;
use crate::solve::SolveError;

/// Iterations before a nonlinear problem is given up.
const ITERATIONS: usize = 60;
/// A nonlinear constraint is met at this error, relative to the numbers it is made of.
const MET: f64 = 1e-12;

impl<S: Shape> Session<S> {
    fn is_linear(&self) -> bool {
        self.bound.iter().all(|b| b.constraint.functional.linearity() == Linearity::Linear)
    }

    /// Solves for the present targets and moves the vertices.
    pub(super) fn event(&mut self) -> Result<(), EditError> {
        if self.prepared.border.is_some() {
            return self.curved_event();
        }
        if !self.is_linear() {
            return self.iterate();
        }
        self.solve_linear()?;
        self.check_finite()?;
        self.place();
        Ok(())
    }

    /// The adjustment that the system's constraints ask for, into `d`.
    pub(super) fn solve_linear(&mut self) -> Result<(), EditError> {
        let prepared = &mut self.prepared;
        if let Some(handle) = self.handle {
            let target = &self.bound[handle].target;
            for slot in prepared.assembly.slots(handle) {
                let at = prepared.assembly.entry(slot);
                prepared.rhs[at] = target[slot.equation as usize] - self.handle_start[slot.equation as usize];
            }
        }
        let conflict = prepared
            .dependencies
            .iter()
            .position(|d| !agrees(&prepared.assembly, d, &prepared.rhs, &prepared.size));
        if let Some(at) = conflict {
            if !self.best_effort {
                return Err(self.conflict(at).into());
            }
            let softened = soften(&prepared.assembly, &prepared.dependencies, &prepared.rhs);
            prepared.factored.solve_into(&softened, &mut prepared.d);
        } else if let Some(handle) = self.handle {
            // d = C₀b₀ + Σ response · change: only the columns of C whose b is ever non-zero.
            prepared.d.copy_from_slice(&prepared.still);
            let sides = prepared.assembly.system.sides();
            for (slot, response) in
                prepared.assembly.slots(handle).iter().zip(response_of(&prepared.response, sides))
            {
                let change = prepared.rhs[prepared.assembly.entry(slot)];
                if sides == 3 {
                    let side = slot.side as usize;
                    for (d, r) in prepared.d.chunks_exact_mut(3).zip(response) {
                        d[side] += change * r;
                    }
                } else {
                    for (d, r) in prepared.d.iter_mut().zip(response) {
                        *d += change * r;
                    }
                }
            }
        } else {
            prepared.factored.solve_into(&prepared.rhs, &mut prepared.d);
        }
        Ok(())
    }

    pub(super) fn check_finite(&self) -> Result<(), EditError> {
        if self.prepared.d.iter().any(|d| !d.is_finite()) {
            return Err(Error::Invalid("the adjustment overflows: ask for a smaller change".into()).into());
        }
        Ok(())
    }

    /// Newton's iteration for the least adjustment under constraints that are not linear: linearized where the shapes
    /// are, with the whole adjustment since the start as unknown, so that it converges to the least one.
    fn iterate(&mut self) -> Result<(), EditError> {
        if self.alternating.is_some() {
            return Err(SolveError::Unsupported(
                "the axes cannot alternate here: a constraint that is not linear depends on the others, or they are too \
                 many; let all axes move together"
                    .into(),
            )
            .into());
        }
        let state = snapshot(&self.shapes, &self.prepared);
        let result = self.iterate_from_here();
        if result.is_err() {
            put(&mut self.shapes, &state);
        }
        result
    }

    fn iterate_from_here(&mut self) -> Result<(), EditError> {
        self.restore();
        let mut worst = (f64::INFINITY, String::new());
        let mut previous = vec![0.0; self.prepared.d.len()];
        for iteration in 1..=ITERATIONS {
            let shapes = view(&self.shapes);
            let constraints: Vec<&Constraint> = self.bound.iter().map(|b| &b.constraint).collect();
            let assembly = Assembly::new(&shapes, &constraints, &self.freedom, &self.metric)?;
            if assembly.system.touched() != self.prepared.assembly.system.touched() {
                return Err(Error::Invalid(
                    "a constraint touches other control vertices than when the edit was prepared; prepare anew".into(),
                )
                .into());
            }
            let (mut rhs, mut size) = (Vec::new(), Vec::new());
            let error = right_hand_side(&shapes, &self.bound, &assembly, &mut rhs, &mut size)?;
            let met = error.iter().all(|(e, s)| *e <= MET * s);
            let step = {
                let change =
                    previous.iter().zip(&self.prepared.d).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                let whole = self.prepared.d.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
                iteration > 1 && change <= 1e-10 * whole
            };
            if met && (step || iteration > ITERATIONS / 2) {
                self.prepared.iterations = iteration - 1;
                self.prepared.rhs = rhs;
                return Ok(());
            }
            worst = error.iter().zip(&self.bound).fold((0.0, String::new()), |w, ((e, _), b)| {
                if *e > w.0 { (*e, b.constraint.describe()) } else { w }
            });
            // b + F (P - P₀): the unknown is the adjustment from the start, not from here.
            let mut sofar = vec![0.0; rhs.len()];
            if iteration > 1 {
                assembly.system.rows().multiply(&self.prepared.d, assembly.system.sides(), &mut sofar);
            }
            rhs.iter_mut().zip(&sofar).for_each(|(b, s)| *b += s);
            let mut factored = self.solver.factor(&assembly.system)?;
            let dependencies = factored.diagnosis().dependencies;
            self.prepared.assembly = assembly;
            self.prepared.dependencies = dependencies;
            let disagree = self
                .prepared
                .dependencies
                .iter()
                .position(|d| !agrees(&self.prepared.assembly, d, &rhs, &size));
            if let Some(at) = disagree {
                if !self.best_effort {
                    return Err(self.conflict(at).into());
                }
                rhs = soften(&self.prepared.assembly, &self.prepared.dependencies, &rhs);
            }
            previous.copy_from_slice(&self.prepared.d);
            factored.solve_into(&rhs, &mut self.prepared.d);
            self.prepared.factored = factored;
            self.prepared.rhs = rhs;
            self.prepared.size = size;
            self.place();
        }
        let (residual, worst) = worst;
        Err(SolveError::NotConverged { iterations: ITERATIONS, residual, worst }.into())
    }

    pub(super) fn conflict(&self, at: usize) -> SolveError {
        let constraints: Vec<&Constraint> = self.bound.iter().map(|b| &b.constraint).collect();
        let dependency = &self.prepared.dependencies[at];
        debug_assert!(!involved(&self.prepared.assembly, dependency).is_empty());
        explain(&self.shapes, &constraints, &self.freedom, &self.prepared.assembly, dependency)
    }
}
