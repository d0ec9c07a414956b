//! What was smooth stays smooth when it is made fair: shapes with knots at which corners can appear, looked at by an evaluator
//! of the tests' own, and beside another program's least under the same relations.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic, reason = "tests")]

mod curves;
#[path = "../../../../kernel/tests/smooth/dice.rs"]
mod dice;
#[path = "../../../../kernel/tests/smooth/evaluator.rs"]
mod evaluator;
#[path = "../../../../kernel/tests/smooth/families.rs"]
mod families;
mod surfaces;
mod told;

use dice::Dice;
use loftsman_fairing::{EnergySum, bend, near, stretch, variation};

/// An energy, and what it is made of: weights and orders of derivatives, 0 for nearness.
fn energy(dice: &mut Dice, degree: usize) -> (EnergySum, Vec<(f64, usize)>) {
    match dice.below(8) {
        0 | 1 if degree > 1 => (bend(), vec![(1.0, 2)]),
        2 | 3 if degree > 2 => (variation(), vec![(1.0, 3)]),
        4 if degree > 1 => (bend() + 0.1 * stretch(), vec![(1.0, 2), (0.1, 1)]),
        5 => (stretch() + 2.0 * near(), vec![(1.0, 1), (2.0, 0)]),
        6 if degree > 2 => (variation() + 0.01 * near(), vec![(1.0, 3), (0.01, 0)]),
        _ => (stretch(), vec![(1.0, 1)]),
    }
}
