//! The tests of this crate, as one program.

mod lofts;
mod regions;
