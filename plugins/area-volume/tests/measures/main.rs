//! Areas, volumes and the rest: closed forms, numbers of other programs, edits, bad input.
#![allow(
    missing_docs,
    clippy::unwrap_used,
    clippy::panic,
    reason = "these are tests, their helpers included"
)]

mod bounded;
mod breps;
mod cells;
mod conformance;
mod effort;
mod errors;
mod folded;
mod kept;
mod patches;
mod polyline;
mod recipes;
mod samples;
mod sessions;
mod told;
mod trims;
mod values;
