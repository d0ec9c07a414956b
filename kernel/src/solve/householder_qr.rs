//! The solver that sees the system as it is: Householder reflections from the right.

use super::rank::{Dependency, Diagnosis, Reflections};
use super::refine::Refinement;
use super::system::System;
use super::{DenseLu, Factored, SolveError, Solver};
use crate::text::short;

/// Householder QR of `Fᵀ` (reflections applied to `F` from the right, paper 4 §3–4): `F H₁H₂… = L`, forward
/// substitution, and the reflections undone. Rows are pivoted, so that rank shows; the condition number is not
/// squared. Rows that share no columns are separate blocks. Work: `O(c² m)` a block of `c` rows and `m` columns. Reflections
/// leave residuals of rounding at the size of the whole answer; where rows are nearly dependent, these are corrected until they
/// are rounding at the size of each row's own terms.
#[derive(Debug, Clone, Copy, Default)]
pub struct HouseholderQr;

struct FactoredQr {
    core: Core,
    dependencies: Vec<Dependency>,
    refinement: Option<Box<Refinement>>,
}

struct Core {
    reflections: Reflections,
    sides: usize,
    work: Vec<f64>,
}

impl Solver for HouseholderQr {
    fn name(&self) -> &'static str {
        "householder-qr"
    }

    fn help(&self) -> &'static str {
        "nearly dependent equations: the condition is not squared"
    }

    fn factor_minimum_norm(&self, system: &System) -> Result<Box<dyn Factored>, SolveError> {
        let rows = system.rows();
        self.with(system, Reflections::new(rows, 0..rows.len(), system.tolerance(), self.name())?)
    }
}

impl HouseholderQr {
    /// By the reflections of all rows of the system to its tolerance.
    pub(super) fn with(
        self,
        system: &System,
        reflections: Reflections,
    ) -> Result<Box<dyn Factored>, SolveError> {
        let dependencies = reflections.dependencies();
        let work = vec![0.0; reflections.scratch()];
        let mut core = Core { reflections, sides: system.sides(), work };
        let mut refinement = None;
        if core.reflections.weakest() < SUSPECT && !system.is_corrected_elsewhere() {
            let kept = core.reflections.independent().into_iter().map(|row| row as u32);
            refinement = Refinement::new(system, kept, |rhs, d| core.solve_into(rhs, d));
            if refinement.is_none() {
                return Err(beyond(system, core.reflections.condition()));
            }
        }
        Ok(Box::new(FactoredQr { core, dependencies, refinement }))
    }
}

/// With a row whose part outside the span of the others is shorter than this, answers are corrected, and tried whether they
/// hold.
const SUSPECT: f64 = 1e-2;

/// Where reflections mix rows of very different answers, elimination may still keep them apart.
pub(super) fn beyond(system: &System, condition: f64) -> SolveError {
    if DenseLu::takes(system) {
        return SolveError::IllConditioned { solver: HouseholderQr.name().into(), condition, better: "lu" };
    }
    SolveError::Unsupported(format!(
        "the constraints are so nearly dependent (condition {condition}) that they are not met to rounding: take \
         away one of those that nearly coincide, or ask for fewer at once",
        condition = short(condition)
    ))
}

impl Core {
    fn solve_into(&mut self, rhs: &[f64], d: &mut [f64]) {
        self.reflections.solve_into(rhs, self.sides, d, &mut self.work);
    }
}

impl Factored for FactoredQr {
    fn solver(&self) -> &'static str {
        "householder-qr"
    }

    fn rank(&self) -> usize {
        self.core.reflections.rank()
    }

    fn diagnosis(&self) -> Diagnosis {
        let reflections = &self.core.reflections;
        let (rank, condition) = (reflections.rank(), reflections.condition());
        Diagnosis { rank, condition, dependencies: self.dependencies.clone() }
    }

    fn solve_into(&mut self, rhs: &[f64], d: &mut [f64]) {
        let Self { core, refinement, .. } = self;
        core.solve_into(rhs, d);
        if let Some(refinement) = refinement {
            refinement.refine(rhs, d, |missed, more| core.solve_into(missed, more));
        }
    }

    fn multipliers_into(&mut self, rhs: &[f64], multipliers: &mut [f64]) {
        let Core { reflections, sides, work, .. } = &mut self.core;
        reflections.multipliers_into(rhs, *sides, multipliers, work);
    }
}
