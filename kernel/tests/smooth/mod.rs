//! What was smooth stays smooth: shapes with knots at which corners can appear, edited in every way with every solver, and
//! looked at by an evaluator of the tests' own.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic, reason = "tests")]

mod creases;
mod curves;
pub(crate) mod dice;
mod evaluator;
mod families;
mod poles;
mod sides;
mod surfaces;
mod told;

use std::sync::Arc;

use dice::Dice;
use loftsman_kernel::solve::{Adjoint, Automatic, DenseLu, HouseholderQr, SaddlePoint, Solver, Sparse};

/// Every solver there is.
pub(crate) fn solvers() -> Vec<Arc<dyn Solver>> {
    vec![
        Arc::new(Automatic),
        Arc::new(Sparse),
        Arc::new(HouseholderQr),
        Arc::new(SaddlePoint),
        Arc::new(DenseLu),
        Arc::new(Adjoint),
    ]
}
