//! What is asked, measured on an answer and told.

use smallvec::SmallVec;

use super::bound::right_hand_side;
use super::check::missed_by;
use super::conflict::quoted;
use super::smooth::is_ours;
use super::{Assembly, EditError, Numbers, Problem, view};
use crate::error::Result;
use crate::functional::{Shapes, Store, Told};
use crate::measure::{Measured, measure_in};
use crate::problem::ConstraintReport;
use crate::solve::SolveError;

/// What was found of each constraint.
pub(crate) type AllMeasured = SmallVec<[Result<Measured>; 1]>;

impl Problem {
    /// Wanted minus present values of an assembly's equations, for other control vertices of the same shapes: entry
    /// `row · sides + side`.
    ///
    /// # Errors
    /// When what is asked cannot be asked of these shapes.
    pub fn misfit(&self, assembly: &Assembly, shapes: &Shapes<'_>) -> Result<Vec<f64>> {
        let (mut rhs, mut size) = (Numbers::new(), Numbers::new());
        right_hand_side(shapes, &self.bound, assembly, &mut rhs, &mut size)?;
        Ok(rhs.into_vec())
    }

    /// Measures all that is asked on other shapes of the same kinds, by the functionals themselves, and judges it: what those
    /// do who look for another answer than the least adjustment, before they hand it out. `solver` is named where something does
    /// not hold.
    ///
    /// # Errors
    /// The first constraint that does not hold to the accuracy that it promises, or cannot be asked of these shapes.
    pub fn verify(&self, assembly: &Assembly, shapes: &Shapes<'_>, solver: &str) -> Result<(), EditError> {
        let own = view(&self.shapes);
        let start = assembly.vertices().fold(0.0_f64, |m, v| own.vertex(v).coords.amax().max(m));
        let reach = reach(assembly, &self.misfit(assembly, &own)?, start);
        self.judge(solver, shapes, &self.measured(shapes, reach))
    }

    /// What each constraint misses on shapes of the same kinds; `reach` as in [`measure`].
    pub(crate) fn measured(&self, shapes: &Shapes<'_>, reach: f64) -> AllMeasured {
        let mut store = Store::default();
        let each = self.bound.iter().map(|bound| {
            let constraint = &bound.constraint;
            let asks = |equation| constraint.asks(equation);
            let (functional, sense) = (constraint.functional.as_ref(), constraint.sense());
            measure_in(&mut store, shapes, functional, sense, &bound.target, &asks, reach)
        });
        each.collect()
    }

    /// Whether what was measured on these shapes is allowed.
    pub(crate) fn judge(
        &self,
        solver: &str,
        shapes: &Shapes<'_>,
        measured: &[Result<Measured>],
    ) -> Result<(), EditError> {
        for (bound, measured) in self.bound.iter().zip(measured) {
            let measured = match measured {
                Err(error) => return Err(error.clone().into()),
                Ok(measured) if measured.holds() => continue,
                Ok(measured) => measured,
            };
            let constraint = &bound.constraint;
            if measured.worst.holds()
                && let Some(Told { found, remedy }) = constraint.functional.told(shapes)?
            {
                let constraint = quoted(&constraint.label());
                return Err(SolveError::Between { constraint, found, remedy }.into());
            }
            return Err(missed_by(solver, constraint, measured.verdict()).into());
        }
        Ok(())
    }

    /// Each constraint (what is kept smooth beside them left out) with the largest of its errors, and its part of `multipliers`:
    /// both with an entry for each equation of the assembly.
    pub fn account(&self, assembly: &Assembly, misfit: &[f64], multipliers: &[f64]) -> Vec<ConstraintReport> {
        self.accounts(assembly, false, misfit, multipliers)
    }

    /// The same for what is kept smooth beside them.
    pub fn account_smooth(
        &self,
        assembly: &Assembly,
        misfit: &[f64],
        multipliers: &[f64],
    ) -> Vec<ConstraintReport> {
        self.accounts(assembly, true, misfit, multipliers)
    }

    fn accounts(
        &self,
        assembly: &Assembly,
        smooth: bool,
        misfit: &[f64],
        multipliers: &[f64],
    ) -> Vec<ConstraintReport> {
        let of = |numbers: &[f64], k: usize| -> Vec<f64> {
            let entries = assembly.slots(k).iter().map(|slot| assembly.entry(slot));
            entries.filter_map(|at| numbers.get(at).copied()).collect()
        };
        let asked = self.bound.iter().enumerate().filter(|(_, bound)| is_ours(&bound.constraint) == smooth);
        let each = asked.map(|(k, bound)| ConstraintReport {
            name: bound.constraint.name(),
            residual: of(misfit, k).iter().fold(0.0, |m, e| m.max(e.abs())),
            dimension: bound.constraint.functional.dimension(),
            location: None,
            between: None,
            multipliers: of(multipliers, k),
        });
        each.collect()
    }
}

/// The size of what went in: where the vertices were (`start`), and the longest way that one of the linear equations asks for by
/// itself.
pub(crate) fn reach(assembly: &Assembly, right: &[f64], start: f64) -> f64 {
    let rows = assembly.system().rows();
    let right =
        right.chunks_exact(assembly.system().sides()).map(|b| b.iter().fold(0.0_f64, |m, b| m.max(b.abs())));
    let asked = right.enumerate().filter(|(_, b)| *b > 0.0).map(|(row, b)| b / rows.norm(row));
    start + asked.filter(|way| way.is_finite()).fold(0.0, f64::max)
}
