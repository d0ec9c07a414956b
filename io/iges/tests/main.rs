//! The tests of this crate, as one program.

mod common;
mod files;
mod forms;
mod geometry;
mod hostile;
mod round_trip;
mod seams;
mod sweeps;
mod torn;
