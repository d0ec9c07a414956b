//! The library against numbers that other programs computed, and against its own promises of cost.
#![allow(clippy::unwrap_used, clippy::panic, reason = "these are tests, their helpers included")]

mod allocations;
mod colors;
mod conformance;
mod declared;
mod document;
mod edits;
mod figures;
mod formats;
mod instances;
mod joined;
mod losses;
mod mutated;
mod sew;
mod shapes_as_splines;
mod solids;
mod tables;
mod vocabulary;
mod walk;
mod work;
