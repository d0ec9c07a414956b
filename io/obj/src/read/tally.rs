//! What is counted in the report with the line of the first.

use std::collections::BTreeMap;

/// How many there are of something, and the line of the first.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Tally {
    pub(crate) count: usize,
    line: usize,
}

impl Tally {
    /// So many, the first of them in that line.
    pub(crate) fn new(count: usize, line: usize) -> Self {
        Self { count, line }
    }

    /// So many more, the first of them in that line.
    pub(crate) fn add(&mut self, count: usize, line: usize) {
        if count > 0 {
            self.line = if self.count == 0 { line } else { self.line.min(line) };
            self.count += count;
        }
    }

    /// Those of another as well.
    pub(crate) fn and(&mut self, other: Self) {
        self.add(other.count, other.line);
    }

    /// What they are, with the line.
    pub(crate) fn told(&self, what: &str) -> String {
        match self.count {
            0 => what.to_owned(),
            1 => format!("{what} (line {})", self.line),
            count => format!("{what} (line {} and {} more)", self.line, count - 1),
        }
    }
}

/// Tallies by what they are of.
pub(crate) type Tallies = BTreeMap<String, Tally>;
