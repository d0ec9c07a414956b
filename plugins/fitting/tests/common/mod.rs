//! What tests of fits share: families of points, and an evaluator that has no line in common with the kernel's.

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail the test")]

pub(crate) mod evaluator;
pub(crate) mod families;
