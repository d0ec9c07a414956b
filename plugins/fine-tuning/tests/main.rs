//! The tests of this crate, as one program.

mod bends;
mod curves;
mod operation;
mod ranges;
mod rims;
mod springs;
mod surfaces;
mod together;
