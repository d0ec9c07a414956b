//! A curve, or a surface looked at across one of its directions: columns of control vertices.

use smallvec::SmallVec;

use crate::Point;
use crate::functional::Shapes;
use crate::shape::{Patch, Splines};
use crate::spline::Space;

/// A shape's control vertices as columns *across* the knots of one direction; a curve is one column.
#[derive(Debug, Clone, Copy)]
pub(super) struct Columns<'a> {
    /// The number of the shape in the problem.
    pub(super) shape: usize,
    /// Which of the shape's splines it is, its face where the shape has many, and the number of its first vertex.
    pub(super) patch: usize,
    pub(super) face: Option<u32>,
    first: usize,
    /// 0 across the knots of `u`, 1 across those of `v`.
    pub(super) direction: usize,
    /// Whose knots are meant.
    pub(super) across: &'a Space,
    /// The other direction of a surface.
    pub(super) along: Option<&'a Space>,
    pub(super) points: &'a [Point],
    weights: Option<&'a [f64]>,
}

impl Columns<'_> {
    /// The number of columns.
    pub(super) fn columns(&self) -> usize {
        self.along.map_or(1, Space::len)
    }

    /// The number of a column's vertex in the shape.
    pub(super) fn index(&self, vertex: usize, column: usize) -> usize {
        self.first
            + match self.direction {
                0 => vertex * self.columns() + column,
                _ => column * self.across.len() + vertex,
            }
    }

    /// Whether one of the shape's vertices is one of its own.
    pub(super) fn has(&self, index: usize) -> bool {
        (self.first..self.first + self.columns() * self.across.len()).contains(&index)
    }

    /// The place of a joint on its left among those of the shape.
    pub(super) fn line(&self, left: usize) -> super::Line {
        (self.shape, self.patch, self.direction, left)
    }

    /// Which vertex of which column one of the shape's vertices is.
    pub(super) fn place(&self, index: usize) -> (usize, usize) {
        let index = index - self.first;
        match self.direction {
            0 => (index / self.columns(), index % self.columns()),
            _ => (index % self.across.len(), index / self.across.len()),
        }
    }

    /// A vertex of a column.
    pub(super) fn point(&self, vertex: usize, column: usize) -> Point {
        self.points[self.index(vertex, column)]
    }

    /// Whether there are weights.
    pub(super) fn is_rational(&self) -> bool {
        self.weights.is_some()
    }

    /// The weight of a column's vertex.
    pub(super) fn weight(&self, vertex: usize, column: usize) -> f64 {
        self.weights.map_or(1.0, |w| w[self.index(vertex, column) - self.first])
    }

    /// The spans (of the other direction) on which a column has influence; one, 0, of a curve.
    pub(super) fn spans(&self, column: usize) -> SmallVec<[usize; 8]> {
        let Some(along) = self.along else { return SmallVec::from_slice(&[0]) };
        let (q, last) = (along.degree(), along.unrolled_len());
        unrolled(along, column)
            .flat_map(|k| k.max(q)..=(k + q).min(last - 1))
            .filter(|&s| along.flat()[s] < along.flat()[s + 1])
            .collect()
    }

    /// The columns that have influence on a span.
    pub(super) fn columns_on(&self, span: usize) -> SmallVec<[usize; 8]> {
        match self.along {
            None => SmallVec::from_slice(&[0]),
            Some(along) => (span - along.degree()..=span).map(|k| along.vertex(k)).collect(),
        }
    }
}

/// The unrolled basis functions that belong to a control vertex.
pub(super) fn unrolled(space: &Space, vertex: usize) -> impl Iterator<Item = usize> {
    let (first, step) = if space.is_periodic() {
        ((vertex + space.degree()) % space.len(), space.len())
    } else {
        (vertex, space.len())
    };
    (first..space.unrolled_len()).step_by(step)
}

/// One net for a curve, two for a surface and for each face of a shape of many, none for what is no tensor-product spline: where its pieces
/// may part is not known here.
pub(super) fn nets<'a>(shapes: &Shapes<'a>, shape: usize) -> SmallVec<[Columns<'a>; 2]> {
    let mut nets = SmallVec::new();
    let Ok(any) = shapes.get(shape) else { return nets };
    let Some(cells) = any.cells() else { return nets };
    let points = any.control_vertices();
    let mut add = |patch: usize, face: Option<u32>, first: usize, splines: Splines<'a>| {
        let Splines { u, v, weights } = splines;
        nets.push(Columns { shape, patch, face, first, direction: 0, across: u, along: v, points, weights });
        if let Some(v) = v {
            nets.push(Columns {
                shape,
                patch,
                face,
                first,
                direction: 1,
                across: v,
                along: Some(u),
                points,
                weights,
            });
        }
    };
    if let Some(splines) = cells.splines() {
        add(0, None, 0, splines);
        return nets;
    }
    for (patch, Patch { face, splines, first }) in cells.patches().into_iter().enumerate() {
        add(patch, face, first, splines);
    }
    nets
}
