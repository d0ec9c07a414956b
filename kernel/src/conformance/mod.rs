//! Suites that say whether something may call itself a solver, a functional, a format or an operation.
//!
//! They are what our own pass, and what others run in their tests:
//!
//! ```
//! use loftsman_kernel::conformance::solver_conformance;
//! use loftsman_kernel::solve::Sparse;
//!
//! let verdict = solver_conformance(&Sparse);
//! assert!(verdict.passed(), "{verdict}");
//! ```

mod dependent;
mod format;
mod functional;
mod operation;
mod program;
mod solver;

pub use format::{format_conformance, sample_scene};
pub use functional::{functional_conformance, sample_shapes};
pub use operation::operation_conformance;
pub use solver::{solver_conformance, solver_conformance_counting};

use std::fmt;

/// What a suite found.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Verdict {
    /// Checks that were made.
    pub checks: usize,
    /// Those that failed, each with what was found.
    pub failures: Vec<String>,
}

impl Verdict {
    /// Whether nothing failed (and something was checked at all).
    pub fn passed(&self) -> bool {
        self.failures.is_empty() && self.checks > 0
    }

    /// Makes a check.
    pub(crate) fn check(&mut self, holds: bool, failure: impl FnOnce() -> String) {
        self.checks += 1;
        // One defect tends to fail everywhere: some are enough.
        if !holds && self.failures.len() < 20 {
            self.failures.push(failure());
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} checks, {} failed", self.checks, self.failures.len())?;
        for failure in &self.failures {
            write!(f, "\n  {failure}")?;
        }
        Ok(())
    }
}

/// A linear congruential generator (Numerical Recipes' constants): the same numbers on every machine.
pub(crate) struct Lcg(u32);

impl Lcg {
    pub(crate) fn new(seed: u32) -> Self {
        Self(seed)
    }

    /// The next number, in `[-1, 1)`.
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(self.0) / 2_147_483_648.0 - 1.0
    }

    /// The next whole number below `limit`.
    pub(crate) fn below(&mut self, limit: usize) -> usize {
        (((self.next() + 1.0) / 2.0) * limit as f64) as usize % limit.max(1)
    }
}
