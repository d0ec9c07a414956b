//! What the whole-program tests share: [`oracle`]s, the [`program`] and a [`bench`](mod@bench) for it, [`curves`] to try, and an
//! [`exact`] evaluator of documents.
//!
//! Everything here panics with a message when something is wrong, as tests do; nothing outside `tests/` uses it.
#![allow(
    clippy::panic,
    clippy::expect_used,
    clippy::unwrap_used,
    reason = "helpers of tests: a panic is how a test says what went wrong"
)]

pub mod bench;
pub mod curves;
pub mod exact;
pub mod oracle;
pub mod program;

/// The top folder of the repository.
///
/// # Panics
/// Never: this crate lies inside it.
pub fn repository() -> &'static std::path::Path {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
}
