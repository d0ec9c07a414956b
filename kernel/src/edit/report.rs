//! What an edit did, as a value.

use std::fmt;

use crate::text::counted;
use crate::text::figure;
use crate::unit::Unit;

pub use crate::problem::{ConstraintReport, Convergence, Corner, Smoothness};

/// What solving an edit gave: printed by `Display`, kept by serde.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct Report {
    /// The solver that did the work.
    pub solver: String,
    /// Scalar equations: of what was asked, and of what was [kept smooth](Self::smooth) beside it.
    pub equations: usize,
    /// Independent ones among them.
    pub rank: usize,
    /// Constraints (or parts of them) that the others imply: they were dropped, and hold.
    pub redundant: Vec<String>,
    /// Largest error of any constraint after the edit, in document units.
    pub residual: f64,
    /// Estimate of the condition number of the equations, each scaled to unit length.
    pub condition: f64,
    /// `(Σ‖dᵢ‖²)^½`.
    pub adjustment: f64,
    /// Linear solves that were needed: 1 unless something is not linear.
    pub iterations: usize,
    /// How it converged, where something is not linear.
    pub convergence: Option<Convergence>,
    /// The inequalities that hold with equality.
    pub active: Vec<String>,
    /// Whether some constraints are missed because only a best effort was asked for.
    pub best_effort: bool,
    /// Every constraint with its error and its multipliers.
    pub constraints: Vec<ConstraintReport>,
    /// What was kept smooth without being asked, and the corners that the edit made.
    pub smooth: Smoothness,
    /// Anything else worth saying.
    pub notes: Vec<String>,
}

/// So many redundant constraints are named where a report is printed.
const REDUNDANT: usize = 5;

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { solver, equations, rank, residual, adjustment, .. } = self;
        write!(
            f,
            "rank {rank} of {equations} · residual {} · ‖d‖ {adjustment:.4} · {solver}",
            figure(*residual)
        )?;
        if self.iterations > 1 {
            write!(f, " · {}", counted(self.iterations, "iteration[|s]"))?;
        }
        if self.smooth.knots + self.smooth.bonds > 0 {
            write!(f, " · {}", self.smooth)?;
        }
        if !self.active.is_empty() {
            write!(f, " · active: {}", self.active.join(", "))?;
        }
        if !self.redundant.is_empty() {
            let count = self.redundant.len();
            let plural = if count == 1 { "" } else { "s" };
            let named = self.redundant[..count.min(REDUNDANT)].join(", ");
            write!(f, " · {count} constraint{plural} that the others imply: {named}")?;
            if count > REDUNDANT {
                write!(f, " and {} more", count - REDUNDANT)?;
            }
        }
        if self.best_effort {
            write!(f, " · BEST EFFORT, missed: {}", self.missed().join(", "))?;
        }
        for note in &self.notes {
            write!(f, " · {note}")?;
        }
        Ok(())
    }
}

impl Report {
    /// What a best effort has missed, and by how much: `position at 0 by 1`. Rounding is not counted.
    pub fn missed(&self) -> Vec<String> {
        self.missing().map(|c| format!("{} by {}", c.name, figure(c.residual))).collect()
    }

    /// The same with units, where lengths are in this one: `position at 0 by 1 m`, `area by 0.02 m²`; plain numbers where a
    /// constraint's [dimension](ConstraintReport::dimension) is not known.
    pub fn missed_in(&self, unit: Unit) -> Vec<String> {
        self.missing().map(|c| format!("{} by {}", c.name, c.error_in(unit))).collect()
    }

    fn missing(&self) -> impl Iterator<Item = &ConstraintReport> {
        self.constraints.iter().filter(|c| self.best_effort && c.residual > self.tolerance())
    }

    /// Errors below this are rounding.
    pub(crate) fn tolerance(&self) -> f64 {
        1e-9 * self.constraints.iter().fold(self.residual, |m, c| m.max(c.residual))
    }
}
