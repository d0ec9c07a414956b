//! The tests of this crate, as one program.

mod contacts;
mod curves;
mod cuts;
mod golden;
mod hits;
mod itself;
mod operations;
mod sections;
mod shells;
mod together;
