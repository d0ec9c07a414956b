//! The program as a whole: what it prints, how it exits, what it leaves on the disk; the examples, the figures and the manual, run.
#![allow(clippy::unwrap_used, clippy::panic, reason = "these are tests, their helpers included")]

mod aftermath;
mod animation;
mod batches;
mod examples;
mod faults;
mod figures;
mod files;
mod fineness;
mod found;
mod golden;
mod hostile;
#[cfg(feature = "iges")]
mod iges;
mod labels;
mod manual;
mod measures;
mod merge;
mod output;
mod own;
mod pictures;
mod placed;
mod recipes;
mod scenes;
mod showpieces;
mod solids;
mod truncated;
mod untunable;
mod weld;

use loftsman_tests::program::Program;

/// The program, as cargo has built it for these tests.
const LOFTSMAN: Program = Program::at(env!("CARGO_BIN_EXE_loftsman"));
