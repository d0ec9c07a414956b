//! Clear text of ISO 10303-21: what a file is made of, whatever its schema.

mod file;
mod lexer;
mod text;

pub(crate) use file::{File, Kind, line};
pub(crate) use lexer::{Entity, Part, Value};
pub(crate) use text::{decode, encode};
