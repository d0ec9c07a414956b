//! What the whole-program tests share: [`oracle`]s, the [`program`], [`curves`] to try, and an [`exact`] evaluator of documents.
//!
//! Everything here panics with a message when something is wrong, as tests do; nothing outside `tests/` uses it.
#![allow(
    clippy::panic,
    clippy::expect_used,
    reason = "helpers of tests: a panic is how a test says what went wrong"
)]

pub mod curves;
pub mod exact;
pub mod oracle;
pub mod program;
