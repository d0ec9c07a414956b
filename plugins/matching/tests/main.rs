//! The tests of this crate, as one program.

mod bends;
mod edges;
mod golden;
mod operation;
mod whole;
