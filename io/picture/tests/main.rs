//! The tests of this crate, as one program.

mod drawn;
mod painted;
mod pictures;
mod shown;
mod solids;
mod torn;
