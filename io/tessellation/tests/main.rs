//! The tests of this crate, as one program.

mod beside;
mod breps;
mod common;
mod cones;
mod curves;
mod hostile;
mod narrow;
mod solids;
mod surfaces;
mod trims;
