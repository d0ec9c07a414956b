//! The tests of this crate, as one program.

mod corners;
mod evenly;
mod golden;
mod healing;
mod offset;
mod operations;
mod outlines;
mod sweep;
mod symmetrize;
