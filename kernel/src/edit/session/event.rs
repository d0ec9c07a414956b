//! One event: new targets, new vertices.

use super::Session;
use super::effort::soften;
use super::prepared::{Prepared, prepare};
use super::program::Bounds;
use crate::edit::EditError;
use crate::edit::ask::Constraint;
use crate::edit::conflict::{explain, involved};
use crate::error::Error;
use crate::functional::Linearity;
use crate::shape::Shape;
use crate::solve::{SolveError, System};

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
        std::mem::swap(&mut prepared.d, &mut prepared.other);
        prepared.meet(&self.bound, self.handle, &self.handle_start);
        let Some(at) = prepared.disagreement() else { return Ok(()) };
        if self.best_effort {
            let softened = soften(&prepared.assembly, &prepared.dependencies, &prepared.rhs);
            prepared.factored.solve_into(&softened, &mut prepared.d);
            return Ok(());
        }
        std::mem::swap(&mut prepared.d, &mut prepared.other);
        // Before it is called a conflict: what is nearly implied is not implied.
        if self.look_closer()? { self.solve_linear() } else { Err(self.conflict(at).into()) }
    }

    /// Prepares anew with rank decided [finely](crate::solve::System::finely), where that leaves fewer rows out.
    fn look_closer(&mut self) -> Result<bool, EditError> {
        let coarse = &self.prepared;
        if coarse.assembly.system.tolerance() <= System::FINE {
            return Ok(false);
        }
        let d = coarse.d.clone();
        self.restore();
        let fine = prepare(
            &self.shapes,
            &self.bound,
            self.handle,
            &self.freedom,
            &self.metric,
            self.solver.as_ref(),
            !self.best_effort,
            true,
        );
        self.prepared.d = d;
        self.place();
        let (coarse, mut fine) = (&mut self.prepared, fine?);
        if fine.factored.rank() <= coarse.factored.rank() || fine.border.is_some() != coarse.border.is_some()
        {
            return Ok(false);
        }
        if let (Some(border), Some(before)) = (&mut fine.border, &mut coarse.border) {
            std::mem::swap(&mut border.before, &mut before.before);
            border.moved = before.moved;
        }
        let d = std::mem::take(&mut coarse.d);
        self.prepared = Prepared { d, ..fine };
        Ok(true)
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
        prepared.assembly.decide(solved.tolerance);
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
