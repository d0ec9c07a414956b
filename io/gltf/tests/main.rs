//! The tests of this crate, as one program.

mod bare;
mod frames;
mod hostile;
mod layers;
mod noted;
mod read;
mod round_trip;
mod shared;
mod solids;
mod write;
