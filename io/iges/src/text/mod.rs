//! The text of a file: its sections, its entities and their parameters, without what these mean.

mod file;
mod global;
mod lines;
mod params;

pub(crate) use file::{Entry, File};
pub(crate) use global::{Global, Length};
pub(crate) use params::{Params, Value};

/// Why a text is no such file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Fault {
    /// The line, counted from 1; 0 for the file as a whole.
    pub(crate) line: usize,
    /// What is wrong and what to do.
    pub(crate) problem: String,
}

impl Fault {
    pub(crate) fn new(line: usize, problem: impl Into<String>) -> Self {
        Self { line, problem: problem.into() }
    }
}

/// Bytes as text: UTF-8, as newer files have them, else Latin-1; ends of lines are none of it.
pub(crate) fn decode(raw: &[u8]) -> String {
    match std::str::from_utf8(raw) {
        Ok(text) => text.chars().filter(|c| !matches!(c, '\n' | '\r')).collect(),
        Err(_) => raw.iter().map(|&b| char::from(b)).filter(|c| !matches!(c, '\n' | '\r')).collect(),
    }
}

/// How sure the first bytes are those of such a file: whether the first line has its letter.
pub(crate) fn confidence(head: &[u8]) -> loftsman_kernel::plugin::Confidence {
    use loftsman_kernel::plugin::Confidence;
    let Some(first) = lines::lines(head).next() else { return Confidence::No };
    match (lines::section(&first.text), first.text.get(72)) {
        (Some((lines::Section::Start | lines::Section::Global, 72, _)), _) => Confidence::Sure,
        (Some((lines::Section::Start, ..)), _) => Confidence::Maybe,
        // The forms that are refused by name.
        (None, Some(b'C')) if first.text[73..].iter().all(|b| b.is_ascii_digit() || *b == b' ') => {
            Confidence::Maybe
        }
        _ => Confidence::No,
    }
}
