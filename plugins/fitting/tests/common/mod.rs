//! What tests of fits share: families of points, and an evaluator that has no line in common with the kernel's.

#![allow(
    dead_code,
    clippy::unwrap_used,
    reason = "each test takes what it needs; helpers of tests may fail it"
)]

pub(crate) mod evaluator;
pub(crate) mod families;
