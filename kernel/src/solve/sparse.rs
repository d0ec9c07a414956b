//! The solver for many equations: Cholesky of `F Fᵀ` within its envelope.

use super::rank::{Dependency, Diagnosis, Reflections};
use super::refine::Refinement;
use super::system::{SparseRows, System};
use super::unit::{Failure, UnitRows};
use super::{Factored, SolveError, Solver};

/// Sparse Cholesky of `F̂ = F Fᵀ`. Rows that touch nearby vertices are put side by side, so that `F̂` is a band
/// (or a narrow envelope) and the work is linear in the number of equations; neither preparing nor solving
/// depends on the number of control vertices. The condition number is squared: where that makes rank doubtful, reflections
/// decide it; answers are corrected by their own residuals where that matters, and where it is not enough, refused.
#[derive(Debug, Clone, Copy, Default)]
pub struct Sparse;

/// Rows whose smallest eigenvalue is below this are looked at by reflections.
const SUSPECT: f64 = 1e-8;
/// Below this the answer is not to be had from `F̂` at all.
const HOPELESS: f64 = 1e-12;
/// Below this an answer is corrected once. That is enough for all that is not suspect: it leaves the share `ε` over the
/// smallest eigenvalue of what was missing. Suspects are corrected until they hold, and tried whether they do.
const CORRECT: f64 = 1e-3;

struct FactoredSparse {
    core: Core,
    /// Corrections without a look at what they are for.
    corrections: usize,
    refinement: Option<Box<Refinement>>,
    dependencies: Vec<Dependency>,
}

struct Core {
    rows: UnitRows,
    sides: usize,
}

impl Solver for Sparse {
    fn name(&self) -> &'static str {
        "sparse"
    }

    fn help(&self) -> &'static str {
        "many equations: work in proportion to what they touch"
    }

    fn factor_minimum_norm(&self, system: &System) -> Result<Box<dyn Factored>, SolveError> {
        self.factor_or_reflect(system).map_err(|refused| refused.error)
    }
}

/// Why the answer is not to be had, and the reflections of all rows where these were needed to see that.
pub(super) struct Refused {
    pub(super) error: SolveError,
    pub(super) reflections: Option<Box<Reflections>>,
}

impl From<SolveError> for Refused {
    fn from(error: SolveError) -> Self {
        Self { error, reflections: None }
    }
}

impl Sparse {
    /// As [`factor_minimum_norm`](Solver::factor_minimum_norm). For many rows that hang together reflections are by far the dearest: who goes on with
    /// these need not make them again.
    pub(super) fn factor_or_reflect(self, system: &System) -> Result<Box<dyn Factored>, Refused> {
        let mut done = Box::new(FactoredSparse {
            core: Core { rows: UnitRows::empty(), sides: system.sides() },
            corrections: 0,
            refinement: None,
            dependencies: Vec::new(),
        });
        let reflections = done.factor(system)?;
        match done.correct(system) {
            Ok(()) => Ok(done),
            Err(error) => Err(Refused { error, reflections }),
        }
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
    /// With the reflections of all rows where these had to decide which are independent.
    fn factor(&mut self, system: &System) -> Result<Option<Box<Reflections>>, Refused> {
        let rows = system.rows();
        match self.core.rows.factor(rows, 0..rows.len() as u32, system.sides(), SUSPECT) {
            Ok(()) => Ok(None),
            Err(Failure::TooLarge) => Err(too_large(rows).into()),
            Err(Failure::Pivot) => {
                let all = 0..rows.len();
                let reflections =
                    Reflections::new(rows, all, system.tolerance(), Sparse.name()).map_err(undecided)?;
                let independent = reflections.independent().into_iter().map(|r| r as u32);
                match self.core.rows.factor(rows, independent, system.sides(), HOPELESS) {
                    Ok(()) => {
                        self.dependencies = reflections.dependencies();
                        Ok(Some(Box::new(reflections)))
                    }
                    Err(Failure::TooLarge) => Err(too_large(rows).into()),
                    Err(Failure::Pivot) => {
                        let error = ill_conditioned(reflections.condition());
                        Err(Refused { error, reflections: Some(Box::new(reflections)) })
                    }
                }
            }
        }
    }

    /// How answers are to be corrected.
    #[inline]
    fn correct(&mut self, system: &System) -> Result<(), SolveError> {
        if system.is_corrected_elsewhere() {
            return Ok(());
        }
        let weakness = self.core.rows.weakness();
        let core = &mut self.core;
        if weakness < SUSPECT {
            let kept: Vec<u32> = core.rows.kept().collect();
            let refinement = Refinement::new(system, kept.into_iter(), |rhs, d| core.solve_into(rhs, d));
            self.refinement = Some(refinement.ok_or_else(|| ill_conditioned(core.rows.condition()))?);
        } else {
            self.corrections = usize::from(weakness < CORRECT);
        }
        Ok(())
    }
}

impl Core {
    fn solve_into(&mut self, rhs: &[f64], d: &mut [f64]) {
        d.fill(0.0);
        self.rows.adjust(rhs, self.sides, d, false);
    }
}

fn ill_conditioned(condition: f64) -> SolveError {
    SolveError::IllConditioned { solver: Sparse.name().into(), condition, better: "householder-qr" }
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
        self.core.rows.len()
    }

    fn diagnosis(&self) -> Diagnosis {
        let (rank, condition) = (self.core.rows.len(), self.core.rows.condition());
        Diagnosis { rank, condition, dependencies: self.dependencies.clone() }
    }

    fn solve_into(&mut self, rhs: &[f64], d: &mut [f64]) {
        let Self { core, refinement, .. } = self;
        if let Some(refinement) = refinement {
            core.solve_into(rhs, d);
            refinement.refine(rhs, d, |missed, more| core.solve_into(missed, more));
            return;
        }
        d.fill(0.0);
        for round in 0..=self.corrections {
            core.rows.adjust(rhs, core.sides, d, round > 0);
        }
    }

    fn multipliers_into(&mut self, rhs: &[f64], multipliers: &mut [f64]) {
        multipliers.fill(0.0);
        self.core.rows.multipliers(rhs, self.core.sides, multipliers);
    }
}
