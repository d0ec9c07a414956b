//! What the whole-program tests share: [`oracle`]s, the [`program`], and [`curves`] to try.
//!
//! Everything here panics with a message when something is wrong, as tests do; nothing outside `tests/` uses it.
#![allow(clippy::panic, reason = "helpers of tests: a panic is how a test says what went wrong")]

pub mod curves;
pub mod oracle;
pub mod program;
