//! What a session keeps smooth beside what is asked of it.

use std::sync::Arc;

use super::bound::{Bound, bind};
use super::{ConstraintId, Session, view};
use crate::edit::EditError;
use crate::edit::ask::{Constraint, Wanted};
use crate::edit::assembly::Freedom;
use crate::edit::metric::Metric;
use crate::edit::report::{Report, Smoothness};
use crate::edit::smooth::{Watched, find, is_ours};
use crate::functional::On;
use crate::shape::Shape;

/// How many corners a report's notes tell one by one.
const TOLD: usize = 3;

/// How smooth a session keeps its shapes, and the places where that may fail.
#[derive(Debug)]
pub(super) struct Smoothing {
    level: u8,
    /// What messages call the shapes.
    names: Vec<On>,
    watched: Watched,
}

impl Smoothing {
    pub(super) fn new(level: u8, names: Vec<On>) -> Self {
        Self { level, names, watched: Watched::default() }
    }

    /// Puts the rows that keep what is smooth *now* behind what is asked, in place of those that were there. What was there
    /// before, if that has changed, for the case that the new ones cannot be prepared.
    pub(super) fn renew(
        &mut self,
        boxes: &[Box<dyn Shape>],
        bound: &mut Vec<Bound>,
        freedom: &Freedom,
        metric: &Metric,
    ) -> Result<Option<Vec<Bound>>, EditError> {
        let shapes = view(boxes);
        let asked = bound.iter().filter(|b| !is_ours(&b.constraint));
        let asked = asked.map(|b| b.constraint.functional.as_ref());
        let mut found = find(&shapes, asked, &self.names, freedom, metric, self.level)?;
        self.watched.add(&mut found);
        let mut fresh = Vec::with_capacity(found.kept.len());
        for smooth in found.kept {
            fresh.push(bind(
                &shapes,
                Constraint::new(Arc::new(smooth), Wanted::Keep),
                ConstraintId(u64::MAX),
            )?);
        }
        if fresh.is_empty() && !bound.iter().any(|b| is_ours(&b.constraint)) {
            return Ok(None);
        }
        let before = bound.clone();
        bound.retain(|b| !is_ours(&b.constraint));
        bound.append(&mut fresh);
        Ok(Some(before))
    }
}

impl<S: Shape> Session<S> {
    /// What was kept smooth, and what corners there are all the same: apart from what was asked. Of its equations the others
    /// imply so many.
    pub(super) fn tell_smoothness(&self, report: &mut Report, redundant: usize) {
        let ours = self.bound.iter().filter(|b| is_ours(&b.constraint));
        let (mut knots, mut equations) = (0, 0);
        for bound in ours {
            knots += 1;
            equations += bound.constraint.functional.equations();
        }
        // They come last, in the account of the constraints too.
        report.constraints.truncate(report.constraints.len().saturating_sub(knots));
        let corners = self.smoothing.watched.corners(&view(&self.shapes));
        let mut worst: Vec<_> = corners.iter().collect();
        worst.sort_by(|a, b| b.change().total_cmp(&a.change()));
        report.notes.extend(worst.iter().take(TOLD).map(ToString::to_string));
        if worst.len() > TOLD {
            report.notes.push(format!("and {} more corners", worst.len() - TOLD));
        }
        report.smooth = Smoothness { knots, equations, redundant, corners };
    }
}
