//! The solver that sees the system as it is: Householder reflections from the right.

use super::metric::Whitened;
use super::rank::{Diagnosis, Reflections};
use super::system::System;
use super::{Factored, SolveError, Solver};

/// Householder QR of `Fᵀ` (reflections applied to `F` from the right, paper 4 §3–4): `F H₁H₂… = L`, forward
/// substitution, and the reflections undone. Rows are pivoted, so that rank shows; the condition number is not
/// squared. Rows that share no columns are separate blocks. Work: `O(c² m)` a block of `c` rows and `m` columns.
#[derive(Debug, Clone, Copy, Default)]
pub struct HouseholderQr;

struct FactoredQr {
    whitened: Option<Box<Whitened>>,
    reflections: Reflections,
    sides: usize,
    work: Vec<f64>,
}

impl Solver for HouseholderQr {
    fn name(&self) -> &'static str {
        "householder-qr"
    }

    fn factor(&self, system: &System) -> Result<Box<dyn Factored>, SolveError> {
        let whitened = system.whitened()?;
        let rows = whitened.as_ref().map_or(system.rows(), |w| &w.rows);
        let reflections = Reflections::new(rows, self.name())?;
        let work = vec![0.0; reflections.scratch()];
        Ok(Box::new(FactoredQr { whitened, reflections, sides: system.sides(), work }))
    }
}

impl Factored for FactoredQr {
    fn solver(&self) -> &'static str {
        "householder-qr"
    }

    fn rank(&self) -> usize {
        self.reflections.rank()
    }

    fn diagnosis(&self) -> Diagnosis {
        self.reflections.diagnosis()
    }

    fn solve_into(&mut self, rhs: &[f64], d: &mut [f64]) {
        self.reflections.solve_into(rhs, self.sides, d, &mut self.work);
        if let Some(whitened) = &mut self.whitened {
            whitened.finish(d, self.sides);
        }
    }

    fn multipliers_into(&mut self, rhs: &[f64], multipliers: &mut [f64]) {
        self.reflections.multipliers_into(rhs, self.sides, multipliers, &mut self.work);
    }
}
