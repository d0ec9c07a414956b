//! What was smooth stays smooth: shapes with knots at which corners can appear, edited in every way with every solver, and
//! looked at by an evaluator of the tests' own.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic, reason = "tests")]

mod curves;
mod evaluator;
mod families;
mod poles;
mod sides;
mod surfaces;
mod told;

use std::sync::Arc;

use loftsman_kernel::solve::{Adjoint, Automatic, DenseLu, HouseholderQr, Solver, Sparse};

/// Every solver there is.
fn solvers() -> Vec<Arc<dyn Solver>> {
    vec![Arc::new(Automatic), Arc::new(Sparse), Arc::new(HouseholderQr), Arc::new(DenseLu), Arc::new(Adjoint)]
}

/// Numbers that look random and are the same in every run (splitmix64).
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    fn between(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn vector(&mut self, size: f64) -> loftsman_kernel::Vector {
        loftsman_kernel::Vector::from_fn(|_, _| self.between(-size, size))
    }
}
