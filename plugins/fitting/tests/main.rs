//! The tests of this crate, as one program.

mod anything;
mod astray;
mod blade;
mod cloud;
mod common;
mod degenerate;
mod exactness;
mod few_steps;
mod folded;
mod golden;
mod held;
mod noise;
mod noisy_curves;
mod operation;
mod plain;
mod scattered;
mod shape_operation;
mod sheets;
