//! Suites that say whether something may call itself a shape, a kind of shape, a solver, a functional, a format or an operation.
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

mod declaration;
mod dependent;
mod format;
mod forms;
mod functional;
mod holes;
mod kind;
mod nets;
mod operation;
mod patches;
mod program;
mod shape;
mod solver;

pub use declaration::{declaration_conformance, declared_functional_conformance};
pub use format::{format_conformance, sample_assembly, sample_scene};
pub use forms::{same_forms, sample_forms};
pub use functional::{functional_conformance, sample_shapes};
pub use kind::kind_conformance;
pub use operation::operation_conformance;
pub use patches::Patches;
pub use shape::shape_conformance;
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

impl Verdict {
    /// What came of something that must succeed; a failure where it does not.
    pub(crate) fn take<T, E>(
        &mut self,
        result: Result<T, E>,
        failure: impl FnOnce(E) -> String,
    ) -> Option<T> {
        match result {
            Ok(value) => {
                self.checks += 1;
                Some(value)
            }
            Err(error) => {
                self.check(false, || failure(error));
                None
            }
        }
    }
}

/// Runs a suite on something of another's making: what panics in there is a failure like others.
pub(crate) fn guarded(suite: impl FnOnce(&mut Verdict) -> Option<()>) -> Verdict {
    let mut verdict = Verdict::default();
    let run = std::panic::AssertUnwindSafe(|| suite(&mut verdict));
    if let Err(panic) = std::panic::catch_unwind(run) {
        let text = panic.downcast_ref::<String>().cloned();
        let text = text.or_else(|| panic.downcast_ref::<&str>().map(|&text| text.to_owned()));
        verdict.failures.push(format!("it panics: {}", text.as_deref().unwrap_or("without a word")));
    }
    verdict
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
