//! The program, run as a user runs it.
#![allow(clippy::unwrap_used, clippy::panic, reason = "these are tests, their helpers included")]

mod examples;
mod figures;
mod golden;
mod manual;
mod measures;
mod truncated;
