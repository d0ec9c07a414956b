//! What a problem keeps smooth beside what is asked of it.

use std::sync::Arc;

use super::Freedom;
use super::bound::{BoundConstraint, bind};
use super::constraint::{Constraint, Wanted};
use super::known::Known;
use super::metric::Metric;
use super::smooth::{Found, Smooth, SmoothKnot, Watched, find, has_places, is_ours, ours};
use super::{ConstraintId, EditError, Problem, view};
use crate::functional::{Functional, On, Shapes};
use crate::problem::Smoothness;
use crate::shape::Shape;

/// How smooth a problem keeps its shapes, and the places where that may fail.
#[derive(Debug)]
pub(crate) struct Smoothing {
    level: u8,
    /// Whether not only where something is asked, but wherever vertices may move.
    everywhere: bool,
    /// What messages call some of the shapes; what is said last counts.
    names: Vec<(usize, Arc<str>)>,
    watched: Watched,
}

impl Smoothing {
    pub(crate) fn new(level: u8, everywhere: bool, names: Vec<(usize, Arc<str>)>) -> Self {
        Self { level, everywhere, names, watched: Watched::default() }
    }

    /// How messages name a shape.
    fn on(&self, shape: usize) -> On {
        let named = self.names.iter().rev().find(|(s, _)| *s == shape);
        On { shape, name: named.map(|(_, name)| Arc::clone(name)) }
    }

    /// Puts the rows that keep what is smooth *now* behind what is asked, in place of those that were there. What was there
    /// before, if that has changed, for the case that the new ones cannot be prepared.
    pub(crate) fn renew(
        &mut self,
        boxes: &[Box<dyn Shape>],
        bound: &mut Vec<BoundConstraint>,
        freedom: &Freedom,
        metric: &Metric,
    ) -> Result<Option<Vec<BoundConstraint>>, EditError> {
        let shapes = view(boxes);
        // Mostly an edit is of a curve that has no such places: it pays for finding that out, and no more.
        let (places, bonded) =
            (has_places(&shapes, self.level), boxes.iter().any(|shape| shape.bonds().is_some()));
        if !places && !bonded && bound.iter().all(|b| b.id != ConstraintId::OURS) {
            return Ok(None);
        }
        let bonds: Vec<Smooth> = (0..boxes.len())
            .flat_map(|index| Smooth::of_bonds(boxes[index].as_ref(), &self.on(index)))
            .collect();
        let asked = bound.iter().filter(|b| !is_ours(&b.constraint));
        let asked = asked.map(|b| b.constraint.functional.as_ref());
        let asked = asked.chain(bonds.iter().map(|bond| bond as &dyn Functional));
        let names = |shape| self.on(shape);
        let mut found = match places {
            true => find(&shapes, asked, &names, freedom, metric, self.level, self.everywhere)?
                .unwrap_or_default(),
            false => Found::default(),
        };
        self.watched.add(&mut found);
        let mut fresh = Vec::with_capacity(found.kept.len() + bonds.len());
        for smooth in found.kept.into_iter().chain(bonds) {
            fresh.push(bind(
                &shapes,
                Constraint::new(Arc::new(smooth), Wanted::Keep),
                ConstraintId::OURS,
                &mut Known::default(),
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

impl Problem {
    /// What is kept smooth beside what is asked, and the corners that other shapes of the same kinds have where these were
    /// smooth (or other corners) when the problem was said.
    pub fn smoothness(&self, shapes: &Shapes<'_>) -> Smoothness {
        let (mut knots, mut bonds, mut equations) = (0, 0, 0);
        for smooth in self.bound.iter().filter_map(|b| ours(&b.constraint)) {
            let which = if smooth.is_bond() { &mut bonds } else { &mut knots };
            *which += 1;
            equations += smooth.equations();
        }
        Smoothness { knots, bonds, equations, redundant: 0, corners: self.smoothing.watched.corners(shapes) }
    }

    /// The knots at which something is kept smooth.
    pub fn smooth_knots(&self) -> impl Iterator<Item = SmoothKnot> + '_ {
        self.bound.iter().filter_map(|b| ours(&b.constraint)).filter_map(Smooth::knot)
    }

    /// Keeps smooth what is smooth *now*. What was asked before, if that has changed.
    pub(crate) fn renew_smoothness(&mut self) -> Result<Option<Vec<BoundConstraint>>, EditError> {
        self.smoothing.renew(&self.shapes, &mut self.bound, &self.freedom, &self.metric)
    }
}
