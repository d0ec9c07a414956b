//! Constraints that reach other control vertices than when the edit was prepared.

use std::collections::BTreeSet;

use super::Session;
use super::prepared::prepare;
use crate::Vector;
use crate::error::Error;
use crate::problem::EditError;
use crate::problem::known::Known;
use crate::shape::Shape;

/// That something reaches vertices that have no column. Told nobody: whoever solves grows and begins again.
pub(super) fn strayed() -> Error {
    Error::Invalid("a constraint reaches other control vertices than when the edit was prepared".into())
}

impl<S: Shape> Session<S> {
    /// Prepares anew, from where the edit began, with the vertices that were reached on the way and may move; false where there
    /// are none. The shapes are as they were. As many times as there are vertices at most, since each adds one.
    pub(super) fn grow(&mut self) -> Result<bool, EditError> {
        let mut reached = std::mem::take(&mut self.prepared.strayed);
        let mut fixed = false;
        if let Some(border) = self.prepared.strategy.border_mut() {
            reached.extend_from_slice(&border.strayed);
            // Those among them that may not move are known from now on.
            fixed = !border.strayed.is_empty();
            border.fix();
        }
        if reached.is_empty() {
            return Ok(false);
        }
        let freedom = &mut self.problem.freedom;
        reached.retain(|&v| freedom.may_move(v));
        let old: Vec<usize> = self.prepared.assembly.vertices().collect();
        let all: BTreeSet<usize> = old.iter().chain(&reached).chain(&freedom.reached).copied().collect();
        if reached.is_empty() || all.len() == freedom.reached.len() {
            return Ok(fixed);
        }
        freedom.reached = all.into_iter().collect();
        let d = self.prepared.d.clone();
        self.restore();
        let fresh =
            prepare(&self.problem, self.dragged(), self.solver.as_ref(), &mut Known::default(), false);
        self.prepared.d.clone_from(&d);
        let mut fresh = match fresh {
            Ok(fresh) => fresh,
            Err(error) => {
                self.place();
                return Err(error);
            }
        };
        // What is reached for the first time belongs to the way back, too.
        let seen: BTreeSet<(u32, u32)> = self.start.iter().map(|&(s, v, _)| (s, v)).collect();
        let first = fresh.state();
        self.start.extend(first.into_iter().filter(|&(s, v, _)| !seen.contains(&(s, v))));
        let ways: Vec<Vector> = d.chunks_exact(3).map(Vector::from_column_slice).collect();
        let places: Vec<usize> = fresh.assembly.vertices().collect();
        for (slot, vertex) in fresh.d.chunks_exact_mut(3).zip(places) {
            if let Ok(at) = old.binary_search(&vertex) {
                slot.copy_from_slice(ways[at].as_slice());
            }
        }
        self.prepared = fresh;
        self.place();
        Ok(true)
    }
}
