//! What a session asks, for those who look for another answer than the least adjustment (fairing).

use std::sync::Arc;

use super::bound::right_hand_side;
use super::{Session, view};
use crate::edit::EditError;
use crate::edit::smooth::is_ours;
use crate::error::Result;
use crate::functional::{Functional, Linearity, Shapes};
use crate::plugin::ConstraintReport;
use crate::shape::Shape;
use crate::solve::System;

impl<S: Shape> Session<S> {
    /// The linear equations of what is asked, over the control vertices that it touches and that may move (numbered through
    /// all shapes). Complete where [`nonlinear`](Self::nonlinear) finds nothing.
    pub fn system(&self) -> &System {
        &self.prepared.assembly.system
    }

    /// The first thing asked that is not linear.
    pub fn nonlinear(&self) -> Option<&Arc<dyn Functional>> {
        let functionals = self.bound.iter().map(|b| &b.constraint.functional);
        functionals.into_iter().find(|f| f.linearity() != Linearity::Linear)
    }

    /// All shapes of the problem as they are now.
    pub fn shapes(&self) -> Shapes<'_> {
        view(&self.shapes)
    }

    /// Wanted minus present values of the [`system`](Self::system)'s equations, for other control vertices of the same
    /// shapes: entry `row · sides + side`.
    ///
    /// # Errors
    /// When what is asked cannot be asked of these shapes.
    pub fn misfit(&self, shapes: &Shapes<'_>) -> Result<Vec<f64>> {
        let (mut rhs, mut size) = (Vec::new(), Vec::new());
        right_hand_side(shapes, &self.bound, &self.prepared.assembly, &mut rhs, &mut size)?;
        Ok(rhs)
    }

    /// Measures all that is asked on other shapes of the same kinds, by the functionals themselves, and judges it: what those
    /// do who look for another answer, before they hand it out. `solver` is named where something does not hold.
    ///
    /// # Errors
    /// The first constraint that does not hold to the accuracy that it promises, or cannot be asked of these shapes.
    pub fn verify(&self, shapes: &Shapes<'_>, solver: &str) -> Result<(), EditError> {
        self.judge(solver, &self.measured(shapes))
    }

    /// Each constraint (what is kept smooth beside them left out) with the largest of its errors, and its part of `multipliers`:
    /// both with an entry for each equation of the [`system`](Self::system).
    pub fn account(&self, misfit: &[f64], multipliers: &[f64]) -> Vec<ConstraintReport> {
        self.accounts(false, misfit, multipliers)
    }

    /// The same for what is kept smooth beside them.
    pub fn account_smooth(&self, misfit: &[f64], multipliers: &[f64]) -> Vec<ConstraintReport> {
        self.accounts(true, misfit, multipliers)
    }

    fn accounts(&self, smooth: bool, misfit: &[f64], multipliers: &[f64]) -> Vec<ConstraintReport> {
        let assembly = &self.prepared.assembly;
        let of = |numbers: &[f64], k: usize| -> Vec<f64> {
            let entries = assembly.slots(k).iter().map(|slot| assembly.entry(slot));
            entries.filter_map(|at| numbers.get(at).copied()).collect()
        };
        let asked = self.bound.iter().enumerate().filter(|(_, bound)| is_ours(&bound.constraint) == smooth);
        let each = asked.map(|(k, bound)| ConstraintReport {
            name: bound.constraint.describe(),
            residual: of(misfit, k).iter().fold(0.0, |m, e| m.max(e.abs())),
            between: None,
            multipliers: of(multipliers, k),
        });
        each.collect()
    }
}
