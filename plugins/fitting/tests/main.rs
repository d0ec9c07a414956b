//! The tests of this crate, as one program.

mod anything;
mod astray;
mod blade;
mod cloud;
mod common;
mod degenerate;
mod exactness;
mod golden;
mod held;
mod noise;
mod operation;
mod plain;
mod scattered;
mod shape_operation;
