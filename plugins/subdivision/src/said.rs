//! What is said of a cage's edges and vertices, each once.

use std::collections::BTreeMap;

use crate::cage::{between, end};
use crate::error::{Result, SubdivisionError};

/// The numbers that were said of edges or vertices.
#[derive(Debug)]
pub(crate) struct Once {
    what: &'static str,
    said: BTreeMap<Vec<usize>, f64>,
}

impl Once {
    pub(crate) fn new(what: &'static str) -> Self {
        Self { what, said: BTreeMap::new() }
    }

    /// Takes note of what is said of a vertex, or of the edge between two.
    ///
    /// # Errors
    /// When something else was said of it before.
    pub(crate) fn say(&mut self, of: &[usize], value: f64) -> Result<()> {
        let mut key = of.to_vec();
        key.sort_unstable();
        self.keep(key, value, || match of {
            &[from, to] => between(from, to),
            _ => format!("vertex {}", of.first().copied().unwrap_or_default()),
        })
    }

    /// Takes note of what is said of a vertex in the direction of its edge to another.
    ///
    /// # Errors
    /// When something else was said of it before.
    pub(crate) fn say_towards(&mut self, at: usize, towards: usize, value: f64) -> Result<()> {
        self.keep(vec![at, towards], value, || end(at, towards))
    }

    fn keep(&mut self, key: Vec<usize>, value: f64, place: impl FnOnce() -> String) -> Result<()> {
        match self.said.insert(key, value) {
            Some(before) if before != value => {
                Err(SubdivisionError::Twice { what: self.what, place: place(), values: [before, value] })
            }
            _ => Ok(()),
        }
    }
}
