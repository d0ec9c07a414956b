//! The tests of this crate, as one program.

mod apart;
mod bends;
mod corners;
mod edges;
mod golden;
mod operation;
mod turned;
mod whole;
