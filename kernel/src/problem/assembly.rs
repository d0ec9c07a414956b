//! From constraints to a linear system: which columns matter, and which equation is where.

use std::cell::Cell;

use smallvec::SmallVec;

use crate::error::Result;
use crate::functional::{Equation, Shapes, Store, rows_of};
use crate::solve::{Sense, SparseRows, System};

use super::Freedom;
use super::constraint::Constraint;
use super::known::Linear;
use super::metric::Metric;

/// Where one scalar equation of a constraint is in the system, and how large the numbers in it are.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slot {
    pub(crate) row: u32,
    pub(crate) side: u32,
    /// Which of the functional's numbers it is.
    pub(crate) equation: u32,
    /// `Σ |coefficient| · |vertex|`: rounding errors of its value are of this size times ε, whatever the axes.
    pub(crate) magnitude: f64,
}

/// The largest coordinate of a vertex: what its others were rounded beside, if it was ever turned.
fn reach(shapes: &Shapes<'_>, vertex: usize) -> f64 {
    shapes.vertex(vertex).coords.amax()
}

/// The linear system of a problem: which control vertices matter, and which equation of which constraint is in which row.
#[derive(Debug)]
pub struct Assembly {
    pub(crate) system: System,
    /// All slots, constraint after constraint.
    pub(crate) slots: SmallVec<[Slot; 3]>,
    /// Where the slots of each constraint start; one more entry than constraints.
    pub(crate) starts: SmallVec<[usize; 4]>,
    /// The parameters behind the last columns.
    pub(super) parameters: Vec<Parameter>,
}

/// A parameter that floats: an unknown beside the control vertices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Parameter {
    /// The number of the constraint whose location it is.
    pub constraint: usize,
    /// Which parameter of the location: 0, or 1 for the second one on a surface.
    pub axis: usize,
}

impl Assembly {
    /// The rows over the control vertices that they touch and that may move, and the metric.
    pub fn system(&self) -> &System {
        &self.system
    }

    /// The control vertices behind the columns, by their numbers through all shapes: each column of a system with three sides is
    /// one, each three columns of one with a single side are.
    pub fn vertices(&self) -> impl ExactSizeIterator<Item = usize> + '_ {
        let alike = self.system.sides() == 3;
        let touched = self.system.touched();
        touched[..touched.len() - self.parameters.len()]
            .iter()
            .step_by(if alike { 1 } else { 3 })
            .map(move |&c| if alike { c } else { c / 3 })
    }

    /// The parameters that float, behind the vertices' columns in this order: of an assembly [with them](super::Problem::assemble_floating).
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// The slots of constraint `k`.
    pub(crate) fn slots(&self, k: usize) -> &[Slot] {
        &self.slots[self.starts[k]..self.starts[k + 1]]
    }

    /// The constraint that a row belongs to.
    pub(crate) fn constraint_of(&self, row: usize) -> usize {
        let slot = self.slots.partition_point(|s| (s.row as usize) < row);
        self.starts.partition_point(|&s| s <= slot).saturating_sub(1)
    }

    /// The index of a slot's entry in right-hand sides.
    pub(crate) fn entry(&self, slot: &Slot) -> usize {
        slot.row as usize * self.system.sides() + slot.side as usize
    }

    /// Decides rank at this [`tolerance`](System::tolerance).
    pub(crate) fn decide(&mut self, tolerance: f64) {
        if tolerance < self.system.tolerance() {
            self.system = self.system.finely();
        }
    }

    /// The rows `kept` (ascending) of it; constraints keep their numbers.
    pub(crate) fn select(&self, kept: &[usize]) -> Self {
        let mut slots = SmallVec::with_capacity(self.slots.len());
        let mut starts = SmallVec::with_capacity(self.starts.len());
        for k in 0..self.starts.len() - 1 {
            starts.push(slots.len());
            slots.extend(self.slots(k).iter().filter_map(|slot| {
                let row = kept.binary_search(&(slot.row as usize)).ok()? as u32;
                Some(Slot { row, ..*slot })
            }));
        }
        starts.push(slots.len());
        Self { system: self.system.select(kept), slots, starts, parameters: self.parameters.clone() }
    }

    pub(crate) fn new(
        shapes: &Shapes<'_>,
        constraints: &[&Constraint],
        freedom: &Freedom,
        metric: &Metric,
    ) -> Result<Self> {
        let constraints = constraints.iter().copied();
        Self::beside(shapes, constraints, &mut Linear::default(), (freedom, metric), &|_| false, true)
    }

    /// The same without the rows of the constraints that are on the `border`: they have no slots, but the vertices that
    /// they touch are among those that move. Of the first constraints, none of them on the border, the rows may be `known`;
    /// those of the others are from now on.
    /// `may_be_alike`: x, y and z may share their rows, where they can.
    pub(crate) fn beside<'c>(
        shapes: &Shapes<'_>,
        constraints: impl ExactSizeIterator<Item = &'c Constraint> + Clone,
        known: &mut Linear,
        (freedom, metric): (&Freedom, &Metric),
        border: &dyn Fn(usize) -> bool,
        may_be_alike: bool,
    ) -> Result<Self> {
        let first = known.constraints();
        known.reserve(constraints.len());
        let (Linear { store, blocks }, mut aside) = (known, Store::default());
        if first < constraints.len() {
            let (mut rows, mut bordering) = (store.rows(shapes), aside.rows(shapes));
            for (k, constraint) in constraints.clone().enumerate().skip(first) {
                let into = if border(k) { &mut bordering } else { &mut rows };
                rows_of(constraint.functional.as_ref(), shapes, into)?;
                blocks.push(rows.blocks());
            }
        }
        let alike = may_be_alike
            && constraints
                .clone()
                .enumerate()
                .all(|(k, c)| c.axis.is_none() && c.sense() == Sense::Equal || border(k))
            && store.is_alike()
            && freedom.is_alike();
        let sides = if alike { 3 } else { 1 };

        // The vertices that move: touched ones that may, and those that the metric takes along.
        let touched = touched(store.touched(), aside.touched(), freedom);
        let moving = freedom.widen(metric, shapes, touched, &|v| freedom.may_move(v))?;
        let next = Cell::new(0);
        // Rows mostly touch runs of vertices: after one comes the next.
        let local = |vertex: usize| {
            let at = next.get();
            let found =
                if moving.get(at) == Some(&vertex) { at } else { moving.binary_search(&vertex).ok()? };
            next.set(found + 1);
            Some(found)
        };

        let entries = store.touched().len() * if alike { 1 } else { 3 };
        let width = if alike { moving.len() } else { moving.len() * 3 };
        let mut rows = SparseRows::with_capacity(width, store.blocks(), entries);
        let mut slots = SmallVec::with_capacity(store.equations_from(0));
        let mut starts = SmallVec::with_capacity(blocks.len());
        starts.push(0);
        for (k, constraint) in constraints.enumerate() {
            let mut equation = 0;
            for i in blocks[k]..blocks[k + 1] {
                match store.block(i) {
                    Equation::Alike { vertices, coefficients, .. } => {
                        let magnitude =
                            vertices.iter().zip(coefficients).map(|(&v, c)| reach(shapes, v) * c.abs()).sum();
                        if alike {
                            let row = rows.len() as u32;
                            rows.push(
                                vertices.iter().zip(coefficients).filter_map(|(&v, &c)| Some((local(v)?, c))),
                            );
                            for side in 0..3 {
                                slots.push(Slot { row, side, equation: equation + side, magnitude });
                            }
                        } else {
                            for axis in 0..3 {
                                if !constraint.asks(axis) {
                                    continue;
                                }
                                let row = rows.len() as u32;
                                let terms = vertices.iter().zip(coefficients);
                                rows.push(terms.filter_map(|(&v, &c)| Some((3 * local(v)? + axis, c))));
                                slots.push(Slot {
                                    row,
                                    side: 0,
                                    equation: equation + axis as u32,
                                    magnitude,
                                });
                            }
                        }
                        equation += 3;
                    }
                    Equation::Coupled { .. } if !constraint.asks(equation as usize) => equation += 1,
                    Equation::Coupled { vertices, vectors, .. } => {
                        let row = rows.len() as u32;
                        rows.push(
                            vertices.iter().zip(vectors).filter_map(|(&v, a)| Some((local(v)?, a))).flat_map(
                                |(v, a)| {
                                    (0..3).map(move |axis| (3 * v + axis, a[axis])).filter(|(_, c)| *c != 0.0)
                                },
                            ),
                        );
                        let size = |(&v, a): (&usize, &crate::Vector)| reach(shapes, v) * a.lp_norm(1);
                        let magnitude = vertices.iter().zip(vectors).map(size).sum();
                        slots.push(Slot { row, side: 0, equation, magnitude });
                        equation += 1;
                    }
                }
            }
            starts.push(slots.len());
        }
        let metric = freedom.resolve(metric, shapes, &moving, !alike)?;
        let touched =
            if alike { moving } else { moving.iter().flat_map(|&v| [3 * v, 3 * v + 1, 3 * v + 2]).collect() };
        let parameters = Vec::new();
        Ok(Self { system: System::new(rows, touched, sides, metric), slots, starts, parameters })
    }
}

/// The vertices that rows touch and that may move, ascending.
fn touched(rows: &[usize], aside: &[usize], freedom: &Freedom) -> Vec<usize> {
    let alone = aside.is_empty() && freedom.reached.is_empty();
    if alone && freedom.is_all() && rows.is_sorted_by(|a, b| a < b) {
        return rows.to_vec();
    }
    // Rows that come along a curve touch mostly what the last ones touched, or what comes behind: only where they do not, all
    // are sorted.
    const RECENT: usize = 8;
    let (mut all, mut sorted): (Vec<usize>, _) = (Vec::with_capacity(rows.len().max(aside.len())), true);
    for &vertex in rows.iter().chain(aside).chain(&freedom.reached) {
        let behind = all.last().is_none_or(|&last| last < vertex);
        let recent = |all: &[usize]| all[all.len().saturating_sub(RECENT)..].contains(&vertex);
        let known = || recent(&all) || sorted && all.binary_search(&vertex).is_ok();
        if (behind || !known()) && freedom.may_move(vertex) {
            sorted &= behind;
            all.push(vertex);
        }
    }
    if !sorted {
        // Stable, because that merges runs: a handle's vertices are the last, wherever along the curve it is.
        all.sort();
        all.dedup();
    }
    all
}
