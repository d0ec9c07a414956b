//! One event: new targets, new vertices.

use super::Session;
use super::effort::soften;
use super::prepared::{Prepared, response_of};
use super::program::Bounds;
use crate::edit::EditError;
use crate::edit::ask::Constraint;
use crate::edit::conflict::{agrees, explain, involved};
use crate::error::Error;
use crate::functional::Linearity;
use crate::shape::Shape;
use crate::solve::SolveError;

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
        if let Some(bounds) = self.prepared.bounds.take() {
            return self.bounded(bounds);
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
            let Prepared { refinement, assembly, factored, rhs, d, .. } = prepared;
            refinement.solve(assembly, factored.as_mut(), rhs, d);
        }
        Ok(())
    }

    pub(super) fn check_finite(&self) -> Result<(), EditError> {
        if self.prepared.d.iter().any(|d| !d.is_finite()) {
            return Err(overflow());
        }
        Ok(())
    }

    /// The same where there are inequalities: which are active is found anew at every event.
    fn bounded(&mut self, mut bounds: Bounds) -> Result<(), EditError> {
        if let Some(handle) = self.handle {
            let target = &self.bound[handle].target;
            for slot in bounds.full.slots(handle) {
                let at = bounds.full.entry(slot);
                bounds.rhs[at] = target[slot.equation as usize] - self.handle_start[slot.equation as usize];
            }
        }
        let solved = self.program(&bounds.full, &bounds.rhs, &bounds.size);
        let prepared = &mut self.prepared;
        let solved = match solved {
            Ok(solved) if solved.d.iter().all(|d| d.is_finite()) => solved,
            other => {
                prepared.bounds = Some(bounds);
                other?;
                return Err(overflow());
            }
        };
        bounds.active = solved.active;
        if let Some((part, _)) = solved.part {
            prepared.assembly = part;
        }
        (prepared.factored, prepared.dependencies) = (solved.factored, solved.dependencies);
        (prepared.rhs, prepared.size, prepared.d) = (solved.rhs, solved.size, solved.d);
        prepared.bounds = Some(bounds);
        self.place();
        Ok(())
    }

    pub(super) fn conflict(&self, at: usize) -> SolveError {
        let constraints: Vec<&Constraint> = self.bound.iter().map(|b| &b.constraint).collect();
        let dependency = &self.prepared.dependencies[at];
        debug_assert!(!involved(&self.prepared.assembly, dependency).is_empty());
        explain(&self.shapes, &constraints, &self.freedom, &self.prepared.assembly, dependency)
    }
}

pub(super) fn overflow() -> EditError {
    Error::Invalid("the adjustment overflows: ask for a smaller change".into()).into()
}
