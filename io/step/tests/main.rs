//! The tests of this crate, as one program.

mod common;
mod edges;
mod editing;
mod exact;
mod files;
mod flags;
mod forms;
mod geometry;
mod held;
mod hostile;
mod nothing;
mod occurrences;
mod painted;
mod parameters;
mod placed;
mod round_trip;
mod seams;
mod sweeps;
mod swept;
mod twice;
mod wound;
