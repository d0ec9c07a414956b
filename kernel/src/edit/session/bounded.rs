//! An event with inequalities, all linear.

use super::Session;
use super::event::is_finite;
use super::prepared::Prepared;
use super::strategy::Strategy;
use crate::measure::PROPORTION;
use crate::problem::EditError;
use crate::problem::check::{Miss, Moved, excess, missed_by, near_conflict};
use crate::problem::constraint::Constraint;
use crate::problem::program::{Bounds, Solved, senses};
use crate::problem::solution::overflow;
use crate::shape::Shape;

impl<S: Shape> Session<S> {
    /// The same where there are inequalities: which are active is found anew at every event.
    pub(super) fn bounded_event(&mut self) -> Result<(), EditError> {
        let strategy = std::mem::replace(&mut self.prepared.strategy, Strategy::Linear);
        let Strategy::Bounded(mut bounds) = strategy else {
            self.prepared.strategy = strategy;
            return Ok(());
        };
        if let Some(handle) = &self.handle {
            let target = &self.problem.bound[handle.at].target;
            for slot in bounds.full.slots(handle.at) {
                let at = bounds.full.entry(slot);
                bounds.rhs[at] = target[slot.equation as usize] - handle.start[slot.equation as usize];
            }
        }
        let solved = self.problem.program(self.solver.as_ref(), &bounds.full, &bounds.rhs, &bounds.size);
        let solved = match solved.and_then(|solved| self.check_program(&bounds, solved)) {
            Ok(solved) => solved,
            Err(error) => {
                self.prepared.strategy = Strategy::Bounded(bounds);
                return Err(error);
            }
        };
        let prepared = self.prepared.as_mut();
        bounds.active = solved.active;
        if let Some((part, _)) = solved.part {
            prepared.assembly = part;
        }
        prepared.assembly.decide(solved.tolerance);
        (prepared.factored, prepared.dependencies) = (solved.factored, solved.dependencies);
        (prepared.rhs, prepared.size, prepared.d) = (solved.rhs, solved.size, solved.d);
        prepared.strategy = Strategy::Bounded(bounds);
        self.place();
        Ok(())
    }

    /// A solved quadratic program as it is, if it is finite, in proportion, and all its rows hold where the vertices will be.
    fn check_program(&mut self, bounds: &Bounds, mut solved: Solved) -> Result<Solved, EditError> {
        if !is_finite(&solved.d) {
            return Err(overflow());
        }
        if solved.softened {
            return Ok(solved);
        }
        let part = solved.part.as_ref().map_or(&bounds.full, |(part, _)| part);
        let right = (&solved.rhs[..], &solved.size[..]);
        if !self.problem.forced
            && let Some(excess) =
                excess(&part.system, solved.factored.as_ref(), right, &solved.d, PROPORTION)?
        {
            let error =
                near_conflict(&self.problem.bound, part, solved.factored.as_mut(), &solved.rhs, excess);
            return Err(error.into());
        }
        let constraints: Vec<&Constraint> = self.problem.constraints().collect();
        let senses = senses(&bounds.full, &constraints);
        let Prepared { check, base, way, .. } = self.prepared.as_mut();
        let right = (&bounds.rhs[..], &bounds.size[..]);
        let moved = Moved::by(base, &solved.d, way);
        let asked = |row: usize| {
            (senses[row], constraints[bounds.full.constraint_of(row)].functional().accuracy().tolerance())
        };
        match check.missed(&bounds.full.system, asked, right, &moved) {
            None => Ok(solved),
            Some(Miss::Overflow) => Err(overflow()),
            Some(Miss::Row(row, error)) => {
                let constraint = constraints[bounds.full.constraint_of(row)];
                Err(missed_by(solved.factored.solver(), constraint, error).into())
            }
        }
    }
}
