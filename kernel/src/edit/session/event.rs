//! One event: new targets, new vertices.

use super::Session;
use super::prepared::{Prepared, prepare};
use super::progress::looks;
use super::strategy::Strategy;
use crate::measure::Error;
use crate::problem::EditError;
use crate::problem::check::{Miss, Moved, missed_by, near_conflict};
use crate::problem::conflict::{explain, involved};
use crate::problem::constraint::Constraint;
use crate::problem::effort::soften;
use crate::problem::known::Known;
use crate::problem::solution::overflow;
use crate::shape::Shape;
use crate::solve::{HouseholderQr, Sense, SolveError, Solver, System};

impl<S: Shape> Session<S> {
    /// Solves for the present targets and moves the vertices, those among them that something reaches on the way.
    pub(super) fn event(&mut self) -> Result<(), EditError> {
        match self.event_on_columns() {
            Ok(()) => Ok(()),
            Err(error) => self.event_farther(error),
        }
    }

    /// The same once more for as long as it failed because something was reached that had no column.
    #[cold]
    fn event_farther(&mut self, mut error: EditError) -> Result<(), EditError> {
        while self.grow()? {
            match self.event_on_columns() {
                Ok(()) => return Ok(()),
                Err(other) => error = other,
            }
        }
        Err(error)
    }

    /// The same for the vertices that have columns.
    fn event_on_columns(&mut self) -> Result<(), EditError> {
        self.prepared.gave_way = false;
        match &mut self.prepared.strategy {
            Strategy::Linear => self.linear_event(),
            Strategy::Bordered(_) => self.curved_event(),
            Strategy::Bounded(_) => self.bounded_event().or_else(|why| self.least_squares(why)),
            Strategy::Sequential(_) => {
                self.iterate(looks(&self.problem.bound)).or_else(|why| self.least_squares(why))
            }
        }
    }

    /// All constraints are linear equations.
    fn linear_event(&mut self) -> Result<(), EditError> {
        while self.solve_linear()? {
            let finite = self.place();
            let Err(error) = self.check_rows(finite) else { return Ok(()) };
            std::mem::swap(&mut self.prepared.d, &mut self.prepared.other);
            self.place();
            // What others nearly imply was left out, and is missed by more than rounding: it is not implied.
            if !self.look_closer()? {
                return Err(error);
            }
        }
        self.place();
        Ok(())
    }

    /// The adjustment that the system's constraints ask for, into `d`; whether it should meet them all (a best effort need
    /// not). Where it fails, `d` is the last one.
    pub(super) fn solve_linear(&mut self) -> Result<bool, EditError> {
        let prepared = self.prepared.as_mut();
        std::mem::swap(&mut prepared.d, &mut prepared.other);
        prepared.meet(&self.problem.bound, self.handle.as_ref());
        if let Some(at) = prepared.disagreement() {
            if self.problem.best_effort {
                let softened = soften(&prepared.assembly, &prepared.dependencies, &prepared.rhs);
                prepared.factored.solve_into(&softened, &mut prepared.d);
                self.check_finite()?;
                return Ok(false);
            }
            std::mem::swap(&mut prepared.d, &mut prepared.other);
            // Before it is called a conflict: what is nearly implied is not implied.
            return if self.look_closer()? { self.solve_linear() } else { Err(self.conflict(at).into()) };
        }
        // What is only linear has its rows checked next, which what is not finite does not pass.
        let linear = matches!(self.prepared.strategy, Strategy::Linear);
        let finite = if linear { Ok(()) } else { self.check_finite() };
        let checked = finite.and_then(|()| self.check_proportion());
        if checked.is_err() {
            std::mem::swap(&mut self.prepared.d, &mut self.prepared.other);
        }
        checked.map(|()| true)
    }

    /// Whether the adjustment is in proportion to what is asked.
    fn check_proportion(&mut self) -> Result<(), EditError> {
        let Prepared { check, assembly, factored, rhs, size, d, .. } = self.prepared.as_mut();
        if check.proportionate {
            return Ok(());
        }
        let slots = self.handle.as_ref().map(|handle| assembly.slots(handle.at)).unwrap_or_default();
        let entries = slots.iter().map(|slot| assembly.entry(slot));
        match check.excess(assembly.system.sides(), (rhs, size), d, entries) {
            Some(excess) if !self.problem.forced => {
                Err(near_conflict(&self.problem.bound, assembly, factored.as_mut(), rhs, excess).into())
            }
            _ => Ok(()),
        }
    }

    /// Whether the vertices that the adjustment leads to meet every prepared row.
    ///
    /// # Errors
    /// The constraint that is missed, or the constraints that contradict one another.
    pub(super) fn check_linear(&mut self) -> Result<(), EditError> {
        let Prepared { base, way, d, .. } = self.prepared.as_mut();
        let finite = Moved::by(base, d, way).finite;
        self.check_rows(finite)
    }

    /// The same where the vertices were just placed, and went `way`.
    fn check_rows(&self, finite: bool) -> Result<(), EditError> {
        let Prepared { check, assembly, rhs, size, base, way, .. } = self.prepared.as_ref();
        let moved = Moved { base, way, finite };
        match check.missed(&assembly.system, |_| (Sense::Equal, 0.0), (rhs, size), &moved) {
            None => Ok(()),
            Some(Miss::Overflow) => Err(overflow()),
            Some(Miss::Row(row, error)) => Err(self.missed(row, error).into()),
        }
    }

    /// Why an answer is not handed out: a contradiction that the solver did not see, or its inaccuracy.
    #[cold]
    fn missed(&self, row: usize, error: Error) -> SolveError {
        let Prepared { assembly, rhs, size, factored, .. } = self.prepared.as_ref();
        let constraints: Vec<&Constraint> = self.problem.constraints().collect();
        if let Ok(mut second) = HouseholderQr.factor(&assembly.system) {
            let dependencies = second.diagnosis().dependencies;
            let mut d = vec![0.0; self.prepared.d.len()];
            second.solve_into(rhs, &mut d);
            let disagrees = dependencies.iter().find(|one| !one.agrees(&assembly.system, rhs, size, &d));
            if let Some(dependency) = disagrees {
                return explain(&self.problem, assembly, dependency);
            }
        }
        missed_by(factored.solver(), constraints[assembly.constraint_of(row)], error)
    }

    /// Prepares anew with rank decided [finely](crate::solve::System::finely), where that leaves fewer rows out.
    fn look_closer(&mut self) -> Result<bool, EditError> {
        let coarse = &self.prepared;
        if coarse.assembly.system.tolerance() <= System::FINE {
            return Ok(false);
        }
        let d = coarse.d.clone();
        self.restore();
        let fine = prepare(&self.problem, self.dragged(), self.solver.as_ref(), &mut Known::default(), true);
        self.prepared.d = d;
        self.place();
        let (coarse, mut fine) = (self.prepared.as_mut(), fine?);
        if fine.factored.rank() <= coarse.factored.rank()
            || fine.strategy.border().is_some() != coarse.strategy.border().is_some()
        {
            return Ok(false);
        }
        if let (Some(border), Some(before)) = (fine.strategy.border_mut(), coarse.strategy.border_mut()) {
            std::mem::swap(&mut border.before, &mut before.before);
            border.moved = before.moved;
        }
        fine.d = std::mem::take(&mut coarse.d);
        self.prepared = fine;
        Ok(true)
    }

    pub(super) fn check_finite(&self) -> Result<(), EditError> {
        if is_finite(&self.prepared.d) { Ok(()) } else { Err(overflow()) }
    }

    pub(super) fn conflict(&self, at: usize) -> SolveError {
        let Prepared { assembly, dependencies, .. } = self.prepared.as_ref();
        debug_assert!(!involved(assembly, &dependencies[at]).is_empty());
        explain(&self.problem, assembly, &dependencies[at])
    }
}

/// Whether all numbers are finite. Zero times what is not is NaN, and NaN stays in a sum: eight sums at a time, without a branch.
pub(super) fn is_finite(d: &[f64]) -> bool {
    let (eights, rest) = d.as_chunks::<8>();
    let mut sums = [0.0_f64; 8];
    for eight in eights {
        sums.iter_mut().zip(eight).for_each(|(sum, d)| *sum += d * 0.0);
    }
    sums.iter().chain(rest).all(|d| d.is_finite())
}
