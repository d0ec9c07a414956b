//! A shape within a distance that meets everything, where the search can begin; or what is to blame that there is none.

use loftsman_kernel::Vector;
use loftsman_kernel::edit::EditError;
use loftsman_kernel::error::Error;
use loftsman_kernel::shape::{Shape, grid_or_row};
use loftsman_kernel::solve::SolveError;

use crate::bounds::Bound;
use crate::problem::{Problem, Stage};
use crate::within::{DistanceLimit, Start};

/// Of the knots that are kept smooth, so many are named.
const NAMED: usize = 3;

impl<S: Shape + Clone> Problem<'_, S> {
    /// A shape within a distance that meets the equations and bounds.
    ///
    /// # Errors
    /// When there is none: naming what is to blame, none of which could be spared.
    pub(crate) fn inside(
        &self,
        limit: &DistanceLimit<'_>,
        stage: &Stage,
        bounds: &[Bound],
    ) -> Result<Vec<Vector>, EditError> {
        let mut rows = self.rows(stage);
        // Which constraint each row is of: entries of equations are told by their constraints, bounds follow.
        let mut owner = vec![0; rows.len()];
        let entries: Vec<f64> = (0..rows.len()).map(|at| at as f64).collect();
        let smooth = stage.account_smooth(&entries);
        let ours = ..smooth.len();
        let mut names = Vec::new();
        for told in smooth.into_iter().chain(stage.account(&[], &entries)) {
            told.multipliers.iter().for_each(|at| owner[*at as usize] = names.len());
            names.push(String::from(told.name));
        }
        for bound in bounds {
            owner.push(names.len());
            names.push(bound.name());
            rows.push(bound.row(&self.among(&self.fair.shape), &self.rest, &self.free)?);
        }
        let grid = grid_or_row(self.fair.shape.as_shape());
        let stuck = |_| {
            SolveError::Unsupported(format!(
                "no shape within {} that meets the constraints was found: they nearly depend on each other; leave some out",
                limit.radius
            ))
        };
        let (mut least, nearest, multipliers) = match limit.start(&rows, &grid).map_err(stuck)? {
            Start::Inside(x) => return Ok(x),
            Start::Beyond { least, nearest, multipliers } => (least, nearest, multipliers),
        };
        if least < limit.radius {
            return Err(Error::Invalid(format!(
                "the constraints alone move some control vertex by {least} at least, and none may move further than {}: a \
                 shape was found where none moves further than {nearest}; allow more than that, or ask for less",
                limit.radius
            ))
            .into());
        }
        // Of what the proof needs, whatever can be spared is left out.
        let proof = rows.iter().zip(&multipliers).zip(&owner).filter(|((_, m), _)| **m != 0.0);
        let mut to_blame: Vec<usize> = proof.map(|(_, k)| *k).collect();
        to_blame.sort_unstable();
        to_blame.dedup();
        let to_blame = needed(to_blame, ours.end, &mut |some| {
            let part: Vec<_> = rows.iter().zip(&owner).filter(|(_, owner)| some.contains(owner)).collect();
            let part: Vec<_> = part.into_iter().map(|(row, _)| row.clone()).collect();
            match limit.start(&part, &grid) {
                Ok(Start::Beyond { least: still, .. }) if still >= limit.radius => {
                    least = still;
                    true
                }
                _ => false,
            }
        });
        let (kept, asked): (Vec<usize>, Vec<usize>) = to_blame.into_iter().partition(|k| *k < ours.end);
        let named = asked.iter().chain(kept.iter().take(NAMED));
        let blamed: Vec<String> = named.map(|&k| format!("\"{}\"", names[k])).collect();
        let (mut what, moves) = match &blamed[..] {
            [] => ("the constraints".to_owned(), "move"),
            [one] => (one.clone(), "moves"),
            all => (all.join(", "), "together move"),
        };
        if kept.len() > NAMED {
            what += &format!(" and {} more smooth knots", kept.len() - NAMED);
        }
        let corners = if kept.is_empty() { "" } else { ", or say smooth = 0 to let corners appear" };
        Err(Error::Invalid(format!(
            "{what} alone {moves} some control vertex by {least} at least, and none may move further than {}: allow more, or \
             ask for less{corners}",
            limit.radius
        ))
        .into())
    }
}

/// Of some culprits, ascending, as many as are `enough`, none of which can be spared. Those before `first` are many and alike:
/// they are spared together where that can be, else half of them, and so on.
fn needed(mut culprits: Vec<usize>, first: usize, enough: &mut dyn FnMut(&[usize]) -> bool) -> Vec<usize> {
    let (alike, others): (Vec<usize>, Vec<usize>) = culprits.iter().partition(|k| **k < first);
    // Taken from the end.
    let mut parts: Vec<Vec<usize>> = others.into_iter().rev().map(|k| vec![k]).collect();
    parts.push(alike);
    while let Some(mut part) = parts.pop() {
        let without: Vec<usize> = culprits.iter().copied().filter(|k| !part.contains(k)).collect();
        if part.is_empty() || without.is_empty() && part.len() == 1 {
            continue;
        }
        if !without.is_empty() && enough(&without) {
            culprits = without;
        } else if part.len() > 1 {
            let half = part.split_off(part.len() / 2);
            parts.extend([half, part]);
        }
    }
    culprits
}

#[cfg(test)]
mod tests {
    use super::needed;

    #[test]
    fn nothing_that_can_be_spared_is_left_and_many_are_spared_at_once() {
        for (wanted, first) in [(vec![3, 40, 101], 100), (vec![105], 100), (vec![7], 100), (vec![1, 2], 0)] {
            let mut calls = 0;
            let mut enough = |some: &[usize]| {
                calls += 1;
                wanted.iter().all(|k| some.contains(k))
            };
            let all: Vec<usize> = (0..if first == 0 { 6 } else { 107 }).collect();
            assert_eq!(needed(all, first, &mut enough), wanted);
            assert!(calls < 40, "{calls}");
        }
    }
}
