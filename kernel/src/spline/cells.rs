//! The cells of splines: products of the spans between their knots.

use smallvec::{SmallVec, smallvec};

use super::surface::Product;
use super::{Curve, Space, Surface, Trimmed};
use crate::error::Result;
use crate::shape::{Cell, CellSide, Cells, Share, Splines};

/// How many spans a space has, empty ones counted.
fn spans(space: &Space) -> usize {
    space.unrolled_len() - space.degree()
}

/// The interval of one of them and its unrolled functions; `None` where it is empty.
fn side(space: &Space, index: usize) -> Option<(CellSide, std::ops::RangeInclusive<usize>)> {
    let p = space.degree();
    let (start, end) = (*space.flat().get(p + index)?, *space.flat().get(p + index + 1)?);
    (index < spans(space) && start < end).then_some((CellSide { start, end, degree: p }, index..=index + p))
}

/// Ascending and without repetition: around a short period functions meet themselves.
fn sorted(vertices: impl Iterator<Item = usize>) -> SmallVec<[usize; 16]> {
    let mut all: SmallVec<[usize; 16]> = vertices.collect();
    all.sort_unstable();
    all.dedup();
    all
}

impl Cells for Curve {
    fn count(&self) -> usize {
        spans(self.space())
    }

    fn cell(&self, index: usize) -> Option<Cell> {
        let (own, functions) = side(self.space(), index)?;
        let vertices = sorted(functions.map(|k| self.space().vertex(k)));
        Some(Cell { face: None, sides: smallvec![own], rational: self.weights().is_some(), vertices })
    }

    fn splines(&self) -> Option<Splines<'_>> {
        Some(Splines { u: self.space(), v: None, weights: self.weights() })
    }
}

impl Product<'_> {
    /// How many cells it has, empty ones counted.
    pub(crate) fn cell_count(&self) -> usize {
        spans(self.u) * spans(self.v)
    }

    /// One of them, on a face of a shape of many; `None` where it is empty.
    pub(crate) fn cell(&self, index: usize, face: Option<u32>) -> Option<Cell> {
        let columns = spans(self.v);
        let (u, rows) = side(self.u, index / columns)?;
        let (v, functions) = side(self.v, index % columns)?;
        let vertex = |i: usize, j: usize| self.first + self.u.vertex(i) * self.v.len() + self.v.vertex(j);
        let vertices = sorted(rows.flat_map(|i| functions.clone().map(move |j| vertex(i, j))));
        Some(Cell { face, sides: smallvec![u, v], rational: self.weights.is_some(), vertices })
    }
}

impl Cells for Surface {
    fn count(&self) -> usize {
        self.product().cell_count()
    }

    fn cell(&self, index: usize) -> Option<Cell> {
        self.product().cell(index, None)
    }

    fn splines(&self) -> Option<Splines<'_>> {
        Some(Splines { u: self.u(), v: Some(self.v()), weights: self.weights() })
    }
}

/// Those of the surface that carries it; a part of them, where there are loops.
impl Cells for Trimmed {
    fn count(&self) -> usize {
        Cells::count(self.surface())
    }

    fn cell(&self, index: usize) -> Option<Cell> {
        self.surface().cell(index)
    }

    fn splines(&self) -> Option<Splines<'_>> {
        self.surface().splines()
    }

    fn is_partial(&self) -> bool {
        !self.regions().is_empty()
    }

    fn shares(&self) -> Result<Option<Vec<Share>>> {
        if self.regions().is_empty() {
            return Ok(None);
        }
        let region = self.region()?;
        let share = |index: usize| match self.surface().cell(index).as_ref().map(|cell| &cell.sides[..]) {
            Some([u, v]) => region.share([u.start, v.start]).clone(),
            _ => Share::Nothing,
        };
        Ok(Some((0..Cells::count(self)).map(share).collect()))
    }
}
