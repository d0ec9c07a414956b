//! The tests of this crate, as one program.

mod operations;
mod passages;
mod placed;
mod simplify;
mod tessellate;
mod transforms;
mod tube;
