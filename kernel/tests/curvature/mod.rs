//! Curvature means κ and its plane, whatever else is asked: judged by an evaluator that shares no code with the kernel.
#![allow(missing_docs, clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests")]

mod book;
mod contradictions;
mod cusps;
mod family;
mod sessions;
mod sides;
