//! The pieces that a shape consists of: what integrals need.

use std::ops::Range;

use smallvec::SmallVec;

use super::{Chart, Derivative, Hole, Location, Shape, Share, Stencil};
use crate::error::{Error, Result};
use crate::quadrature::gauss_legendre;
use crate::space::Space;
use crate::{Point, Vector};

/// The interval of one parameter that a [`Cell`] covers, and the degree in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CellSide {
    /// Where it starts.
    pub start: f64,
    /// Where it ends; more than `start`.
    pub end: f64,
    /// The degree in this parameter: of numerator and denominator where the cell is rational.
    pub degree: usize,
}

/// A box of parameters on which a shape is one polynomial in each of them, or one quotient of two.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Cell {
    /// The face that it is on, of a surface of many.
    pub face: Option<u32>,
    /// One side for a curve; for a surface that in `u`, then that in `v`.
    pub sides: SmallVec<[CellSide; 2]>,
    /// Whether the shape is a quotient of polynomials there: Gauss points are then not exact.
    pub rational: bool,
    /// The control vertices that a point of the cell depends on, ascending, each once.
    pub vertices: SmallVec<[usize; 16]>,
}

impl Cell {
    /// The location with these shares (0 at the start, 1 at the end) of each side.
    pub fn at(&self, shares: [f64; 2]) -> Location {
        let place = |side: &CellSide, share: f64| side.start + (side.end - side.start) * share;
        match self.sides[..] {
            [ref u, ref v, ..] => {
                let (u, v) = (place(u, shares[0]), place(v, shares[1]));
                self.face.map_or(Location::Surface(u, v), |face| Location::Face(face, u, v))
            }
            [ref u] => Location::Curve(place(u, shares[0])),
            [] => Location::Curve(0.0),
        }
    }

    /// The length of its interval, or the area of its box.
    pub fn size(&self) -> f64 {
        self.sides.iter().map(|side| side.end - side.start).product()
    }

    /// Gauss–Legendre points of the cell with their weights, `counts` in each parameter, along the last parameter first: exact
    /// for polynomials of degree `2 counts - 1` in each. `O(counts²)`, and as much again for the nodes.
    pub fn gauss_points(&self, counts: [usize; 2]) -> Vec<(Location, f64)> {
        let (nodes, weights) = gauss_legendre(counts[0].max(1));
        let size = self.size();
        if self.sides.len() < 2 {
            return nodes.iter().zip(&weights).map(|(x, w)| (self.at([*x, 0.0]), w * size)).collect();
        }
        let (others, by) = gauss_legendre(counts[1].max(1));
        let rows = nodes.iter().zip(&weights);
        rows.flat_map(|(x, w)| others.iter().zip(&by).map(move |(y, b)| (self.at([*x, *y]), w * b * size)))
            .collect()
    }

    /// Where each vertex of a stencil stands among the cell's own, with its coefficient; those without influence are left out.
    ///
    /// # Errors
    /// When the stencil has a vertex that the cell does not name, or a coefficient that is no number: the shape's cells are
    /// wrong, and its type `name` is said.
    pub fn places(&self, stencil: &Stencil, name: &str) -> Result<SmallVec<[(usize, f64); 16]>> {
        let mut all = SmallVec::new();
        for (vertex, c) in stencil.iter().filter(|(_, c)| *c != 0.0) {
            match self.vertices.binary_search(&vertex) {
                Ok(at) if c.is_finite() => all.push((at, c)),
                _ => {
                    return Err(Error::Invalid(format!(
                        "a shape ({name}) depends on control vertex {vertex} ({c} times) in a cell that does not name it, or on no \
                         number of it: its cells or its stencils are wrong"
                    )));
                }
            }
        }
        Ok(all)
    }
}

/// A polynomial cell of a surface with its points as they are: what integrals need that are asked for once, and no gradient.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CellNet<'a> {
    /// The number of the [`Cell`].
    pub number: usize,
    /// The face that it is on, of a surface of many.
    pub face: Option<u32>,
    /// Its side in `u`, then that in `v`, with the degrees `p` and `q`.
    pub sides: [CellSide; 2],
    /// The `(p + 1)(q + 1)` points of the Bézier patch over these sides, less the origin that was asked for: `b_ij` is number `i (q + 1) + j`.
    pub points: &'a [Vector],
}

/// The spaces, and the weights if there are any, of a shape that is a tensor-product spline: from them what is said by
/// cells one by one follows for all at once.
#[derive(Debug, Clone, Copy)]
pub struct Splines<'a> {
    /// The space along `u`.
    pub u: &'a Space,
    /// The space along `v`, of a surface: vertex `(i, j)` is number `i · v.len() + j`.
    pub v: Option<&'a Space>,
    /// The weights of a rational shape, one a vertex.
    pub weights: Option<&'a [f64]>,
}

/// A tensor-product spline that is a part of a shape.
#[derive(Debug, Clone, Copy)]
pub struct Patch<'a> {
    /// The face that it is, of a shape of many.
    pub face: Option<u32>,
    /// Its spaces and weights.
    pub splines: Splines<'a>,
    /// The number of its first control vertex.
    pub first: usize,
}

/// What a shape can say that consists of cells. From these all integrals over it are computed: Gram matrices and energies,
/// areas, volumes, lengths.
///
/// Cells do not overlap, and together they cover the domain. They are asked for by number; a shape that has infinitely many
/// (around an extraordinary vertex of a subdivision surface) serves as many as it chooses to, and its integrals are those of
/// what these cover. It says where the [holes](Self::holes) are that these leave: cones over them make volumes those of a closed surface,
/// which do not depend on the origin.
pub trait Cells {
    /// Cells have numbers below this one.
    fn count(&self) -> usize;

    /// Cell number `index`, in as little time whatever their number. `None` from [`count`](Self::count) on, and where a number
    /// has no cell (a span between equal knots).
    fn cell(&self, index: usize) -> Option<Cell>;

    /// The shape's spaces and weights, where it is a tensor-product spline; its cells are then the products of their spans.
    fn splines(&self) -> Option<Splines<'_>> {
        None
    }

    /// The tensor-product spline that a face is, or the shape itself where it has none; its cells are the products of the patch's spans. `None` where it is
    /// no such spline, or there is no such face: by default, of a shape with faces.
    fn patch(&self, face: Option<u32>) -> Option<Patch<'_>> {
        let own = self.splines().filter(|_| face.is_none())?;
        Some(Patch { face: None, splines: own, first: 0 })
    }

    /// The tensor-product splines that the shape consists of, each with its face, where it has many, and the number of its first control
    /// vertex: by default its [own](Self::splines). Of a shape that is [ready](super::Bonds) for an edit, those that may move.
    fn patches(&self) -> Vec<Patch<'_>> {
        self.patch(None).into_iter().collect()
    }

    /// The coordinates in which the energies of first and second derivatives are taken at a location, where these are not the parameters: of a whole
    /// cell or of none of it. `None` (the default) where they are.
    fn chart(&self, at: Location) -> Option<Chart> {
        let _ = at;
        None
    }

    /// Whether only a part of what the cells cover counts as the shape: of a trimmed surface. Energies are taken over the
    /// whole of it, areas and volumes over its [shares](Self::shares).
    fn is_partial(&self) -> bool {
        false
    }

    /// How much of each cell counts as the shape, cell by cell; `None` (the default) where all of all cells does. It depends on loops
    /// in parameter planes, which stay as they are while control vertices move: ask once.
    ///
    /// # Errors
    /// When loops do not say what is inside.
    fn shares(&self) -> Result<Option<Vec<Share>>> {
        Ok(None)
    }

    /// What the cells leave out, face by face: nothing by default. No vertex has to be looked at for it. Of a shape that is
    /// [partial](Self::is_partial) they are not asked for, nor of one that is rational there.
    fn holes(&self) -> Vec<Hole> {
        Vec::new()
    }

    /// Whether the cells on both sides of any place inside the domain meet there, whatever the control vertices are: then nobody looks whether the
    /// shape is [torn](super::torn()), at many stencils a cell. `false` (the default) where that has to be looked for.
    fn always_meet(&self) -> bool {
        false
    }

    /// The Bézier nets of the cells of a surface with numbers in a range, one after another, by its control vertices as they are, taken from `origin`
    /// (far from it nothing cancels then). `None` (the default) where the shape does not say them: integrals then go by stencils, at many times the
    /// cost. A shape that says them does so for all its cells, none of which is rational, whatever the range; an empty one asks whether it does.
    ///
    /// What a net costs should be little more than to write it down, so that it need not be kept: it is asked for again.
    ///
    /// # Errors
    /// Where a stencil in the cell could not be had.
    fn nets(
        &self,
        numbers: Range<usize>,
        origin: &Point,
        each: &mut dyn FnMut(CellNet<'_>),
    ) -> Option<Result<()>> {
        let _ = (numbers, origin, each);
        None
    }

    /// Of a shape of faces that says itself what volume it bounds, for each face 1 where `S_u × S_v` points out of it, -1 where it
    /// points in, 0 where the face bounds none. `None` (the default) where that is found from where edges meet.
    ///
    /// # Errors
    /// When it bounds no volume, in words that say where it is open.
    fn senses(&self) -> Option<Result<Vec<f64>>> {
        None
    }
}

impl dyn Cells + '_ {
    /// All cells, one after another.
    pub fn iter(&self) -> impl Iterator<Item = Cell> + '_ {
        (0..self.count()).filter_map(|index| self.cell(index))
    }

    /// Whether any cell is rational. `O(1)` for splines.
    pub fn is_rational(&self) -> bool {
        match self.splines() {
            Some(splines) => splines.weights.is_some(),
            None => self.iter().any(|cell| cell.rational),
        }
    }

    /// The largest degree in each parameter; 0 in one that there is not.
    pub fn degrees(&self) -> [usize; 2] {
        if let Some(splines) = self.splines() {
            return [splines.u.degree(), splines.v.map_or(0, Space::degree)];
        }
        self.iter().fold([0; 2], |[p, q], cell| {
            let degree = |k: usize| cell.sides.get(k).map_or(0, |side| side.degree);
            [p.max(degree(0)), q.max(degree(1))]
        })
    }

    /// The cells of which something counts, checked, with how much that is.
    ///
    /// # Errors
    /// As for [`Cells::shares`], and when the cells are wrong.
    pub fn counted(&self, shape: &dyn Shape) -> Result<Vec<(Cell, Share)>> {
        let cells = self.checked(shape)?;
        let Some(shares) = self.shares()? else {
            return Ok(cells.into_iter().map(|cell| (cell, Share::Whole)).collect());
        };
        let there = (0..self.count()).filter(|&index| self.cell(index).is_some());
        let shares = there.map(|index| shares.get(index).cloned().unwrap_or(Share::Nothing));
        Ok(cells.into_iter().zip(shares).filter(|(_, share)| *share != Share::Nothing).collect())
    }

    /// The cells as far as they hang together: as many sides as the shape has parameters, each with a length, and vertices that
    /// there are. `O(n)`.
    ///
    /// # Errors
    /// When they do not, naming the shape's type.
    pub fn checked(&self, shape: &dyn Shape) -> Result<Vec<Cell>> {
        let (parameters, vertices, name) =
            (shape.domain().len(), shape.control_vertices().len(), shape.type_name());
        let mut all = Vec::with_capacity(self.count());
        for (index, cell) in self.iter().enumerate() {
            let sound =
                |side: &CellSide| side.start.is_finite() && side.end.is_finite() && side.start < side.end;
            let known = cell.vertices.last().is_none_or(|&v| v < vertices);
            let ascending = cell.vertices.windows(2).all(|pair| pair[0] < pair[1]);
            if cell.sides.len() != parameters || !cell.sides.iter().all(sound) || !known || !ascending {
                return Err(Error::Invalid(format!(
                    "cell {index} of a shape ({name}) needs {parameters} sides with a length, and vertices below {vertices} in \
                     ascending order: it is {cell:?}"
                )));
            }
            all.push(cell);
        }
        Ok(all)
    }
}

/// The cells of a shape; `what` needs them.
///
/// # Errors
/// When the shape does not say of which pieces it consists, in words that name `what` and the shape's type.
pub fn cells_of<'a>(shape: &'a dyn Shape, what: &str) -> Result<&'a dyn Cells> {
    shape.cells().ok_or_else(|| {
        Error::Invalid(format!(
            "{what}: a shape ({}) does not say of which polynomial pieces it consists, so that nothing can be integrated over it; \
             convert it to a B-spline first",
            shape.type_name()
        ))
    })
}

/// The rows of a derivative over a cell's own vertices at some of its points: `width` numbers a point, one after another.
///
/// # Errors
/// As for [`Shape::stencil`] and [`Cell::places`].
pub fn rows_at(
    shape: &dyn Shape,
    cell: &Cell,
    points: &[(Location, f64)],
    derivative: Derivative,
) -> Result<Vec<f64>> {
    let width = cell.vertices.len();
    let mut rows = vec![0.0; width * points.len()];
    for (number, (at, _)) in points.iter().enumerate() {
        let stencil = shape.stencil(*at, derivative)?;
        // Also where the cell names none: then there is no row to go into, and that is told.
        for (k, c) in cell.places(&stencil, shape.type_name())? {
            rows[number * width + k] += c;
        }
    }
    Ok(rows)
}
