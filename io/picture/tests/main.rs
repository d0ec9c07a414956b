//! The tests of this crate, as one program.

mod drawn;
mod laid;
mod painted;
mod pictures;
mod shown;
mod solids;
mod torn;
