//! The solver for many equations: Cholesky of `F W⁻¹ Fᵀ` within its envelope.

use std::sync::Arc;

use super::metric::Whitened;
use super::rank::{Dependency, Diagnosis, reduce};
use super::system::{SparseRows, System};
use super::unit::{Stuck, UnitRows};
use super::{Factored, SolveError, Solver};

/// Sparse Cholesky of `F̂ = F W⁻¹ Fᵀ`. Rows that touch nearby vertices are put side by side, so that `F̂` is a band
/// (or a narrow envelope) and the work is linear in the number of equations; neither preparing nor solving
/// depends on the number of control vertices. The condition number is squared, so answers are corrected by their
/// own residuals where that matters, and nearly dependent systems are refused.
#[derive(Debug, Clone, Copy, Default)]
pub struct Sparse;

/// Below this relative pivot the rows are looked at by reflections.
const SUSPECT: f64 = 1e-8;
/// Below this relative pivot the answer is not to be had from `F̂` at all.
const HOPELESS: f64 = 1e-12;
/// Below this relative pivot an answer is corrected once, and twice below its square root of `SUSPECT`.
const CORRECT: f64 = 1e-2;

struct FactoredSparse {
    rows: UnitRows,
    whitened: Option<Box<Whitened>>,
    sides: usize,
    corrections: usize,
    dependencies: Vec<Dependency>,
}

impl Solver for Sparse {
    fn name(&self) -> &'static str {
        "sparse"
    }

    fn factor(&self, system: &System) -> Result<Box<dyn Factored>, SolveError> {
        let whitened = system.whitened()?;
        let mut done = Box::new(FactoredSparse {
            rows: UnitRows::empty(),
            whitened: None,
            sides: system.sides(),
            corrections: 0,
            dependencies: Vec::new(),
        });
        done.factor(whitened.as_ref().map_or(system.rows(), |w| &w.rows))?;
        done.whitened = whitened;
        Ok(done)
    }
}

/// Dependent rows in a block that is too large to find out which: no solver can.
fn undecided(error: SolveError) -> SolveError {
    match error {
        SolveError::TooLarge { equations, unknowns, .. } => SolveError::Unsupported(format!(
            "{equations} equations with {unknowns} unknowns depend on one another, too many to find out which do: ask for \
             fewer constraints at once"
        )),
        other => other,
    }
}

impl FactoredSparse {
    fn factor(&mut self, rows: &Arc<SparseRows>) -> Result<(), SolveError> {
        let solver = Sparse.name();
        match self.rows.factor(rows, 0..rows.len() as u32, self.sides, SUSPECT) {
            Ok(()) => {}
            Err(Stuck::TooLarge) => return Err(too_large(rows)),
            Err(Stuck::Pivot) => {
                let (kept, diagnosis) = reduce(rows, solver).map_err(undecided)?;
                let kept = kept.iter().map(|&r| r as u32);
                self.rows.factor(rows, kept, self.sides, HOPELESS).map_err(|stuck| match stuck {
                    Stuck::TooLarge => too_large(rows),
                    Stuck::Pivot => SolveError::IllConditioned {
                        solver: solver.into(),
                        condition: diagnosis.condition,
                        better: "householder-qr",
                    },
                })?;
                self.dependencies = diagnosis.dependencies;
            }
        }
        let pivot = self.rows.smallest_pivot();
        self.corrections =
            usize::from(pivot < CORRECT) + usize::from(pivot < SUSPECT.sqrt()) + usize::from(pivot < SUSPECT);
        Ok(())
    }
}

fn too_large(rows: &SparseRows) -> SolveError {
    SolveError::TooLarge {
        solver: Sparse.name().into(),
        equations: rows.len(),
        unknowns: rows.width(),
        better: "householder-qr",
    }
}

impl Factored for FactoredSparse {
    fn solver(&self) -> &'static str {
        "sparse"
    }

    fn rank(&self) -> usize {
        self.rows.len()
    }

    fn diagnosis(&self) -> Diagnosis {
        let condition = self.rows.condition();
        Diagnosis { rank: self.rows.len(), condition, dependencies: self.dependencies.clone() }
    }

    fn solve_into(&mut self, rhs: &[f64], d: &mut [f64]) {
        d.fill(0.0);
        self.rows.adjust(rhs, self.sides, d, false);
        for _ in 0..self.corrections {
            self.rows.adjust(rhs, self.sides, d, true);
        }
        if let Some(whitened) = &mut self.whitened {
            whitened.finish(d, self.sides);
        }
    }

    fn multipliers_into(&mut self, rhs: &[f64], multipliers: &mut [f64]) {
        multipliers.fill(0.0);
        self.rows.multipliers(rhs, self.sides, multipliers);
    }
}
