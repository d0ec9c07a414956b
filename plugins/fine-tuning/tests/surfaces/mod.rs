//! Fine tuning of surfaces: the identities of theory §5, edges and regions that stay, and what is refused.

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail the test")]

mod alike;
mod edges;
mod family;
mod lines;
mod refused;
mod regions;
mod squares;
