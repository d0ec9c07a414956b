//! The program as a whole: what it prints, how it exits, and what it leaves on the disk.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on has failed")]

mod aftermath;
mod batches;
mod bench;
mod files;
mod found;
mod hostile;
mod output;
mod pictures;
mod recipes;
mod scenes;
