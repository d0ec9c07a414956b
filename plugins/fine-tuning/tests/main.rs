//! The tests of this crate, as one program.

mod bends;
mod curves;
mod identities;
mod jagged;
mod motions;
mod numbers;
mod operation;
mod positive;
mod ranges;
mod rims;
mod springs;
mod springs_at_random;
mod surfaces;
mod together;
