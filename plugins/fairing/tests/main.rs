//! The tests of this crate, as one program.

mod book;
mod bounds;
mod closed_forms;
mod dice;
mod families;
mod foreign;
mod golden;
mod minimise;
mod operation;
mod patches;
mod regressions;
mod smooth;
