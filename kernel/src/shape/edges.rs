//! The boundary of a surface: what joins and closed shells need.

use std::borrow::Cow;

use smallvec::SmallVec;

use super::{Cell, CellSide, Derivative, Location, Shape, Stencil};
use crate::error::{Error, Result};
use crate::space::Space;

/// A piece of a surface's boundary: one parameter runs, the other is fixed.
#[derive(Debug, Clone, PartialEq)]
pub struct BoundaryEdge {
    /// What recipes and messages call it: `u0`, `u1`, `v0`, `v1` where the domain's four sides are the edges.
    pub name: Cow<'static, str>,
    /// The face that it bounds, of a surface of many.
    pub face: Option<u32>,
    /// Whether `u` runs (and `v` is fixed).
    pub along_u: bool,
    /// Where the running parameter starts.
    pub start: f64,
    /// Where it ends.
    pub end: f64,
    /// Whether its end meets its start, because that direction is periodic.
    pub periodic: bool,
    /// The parameter that is fixed.
    pub fixed: f64,
    /// Whether the surface lies at smaller values of that one: the edge is at the end of it.
    pub at_end: bool,
}

impl BoundaryEdge {
    /// The edge in a sentence: `edge u1`, `edge 3`.
    pub fn called(&self) -> Cow<'_, str> {
        // The edges of a cage are named by their numbers, "edge 3".
        if self.name.starts_with("edge ") {
            Cow::Borrowed(&self.name)
        } else {
            format!("edge {}", self.name).into()
        }
    }

    /// The place of the edge at `t`.
    pub fn at(&self, t: f64) -> Location {
        let (u, v) = if self.along_u { (t, self.fixed) } else { (self.fixed, t) };
        self.face.map_or(Location::Surface(u, v), |face| Location::Face(face, u, v))
    }

    /// Its two ends: one corner of the surface each, one and the same place where it is periodic.
    pub fn corners(&self) -> [Location; 2] {
        [self.at(self.start), self.at(self.end)]
    }

    /// The derivative of this order across the edge, by the fixed parameter. It points inwards where the edge is at the start of
    /// that parameter, outwards where it is [at its end](Self::at_end).
    pub fn across(&self, order: usize) -> Derivative {
        if self.along_u { Derivative { u: 0, v: order } } else { Derivative { u: order, v: 0 } }
    }

    /// The derivative of this order along the edge.
    pub fn along(&self, order: usize) -> Derivative {
        if self.along_u { Derivative { u: order, v: 0 } } else { Derivative { u: 0, v: order } }
    }

    /// Whether the surface lies on the left where the edge is run through from start to end, seen in the parameter plane: so
    /// that it runs as the boundary does.
    pub fn runs_with_the_boundary(&self) -> bool {
        self.along_u != self.at_end
    }
}

/// A derivative across an edge, `∂ᵏ(w S)` (`w` the denominator of a rational surface, else 1), as a spline along it.
#[derive(Debug, Clone, PartialEq)]
pub struct Strip {
    /// The functions along the edge, over its interval.
    pub space: Space,
    /// Each coefficient in terms of the control vertices: as many as the space has. Of a rational surface, with weights divided
    /// by the largest one of the whole surface.
    pub coefficients: Vec<Stencil>,
    /// The largest coefficient of the basis functions' derivative across the edge, weights left out.
    pub largest: f64,
}

/// What a surface can say that has a boundary. Its edges are what joins are asked of, and what a closed shell is put together
/// by; a surface that is periodic in both directions has none.
pub trait Edges {
    /// The number of edges.
    fn count(&self) -> usize;

    /// BoundaryEdge number `index`; `None` from [`count`](Self::count) on.
    fn edge(&self, index: usize) -> Option<BoundaryEdge>;

    /// The derivatives across an edge up to an order, as splines along it, all in one space. `None` (the default) where they
    /// follow from the shape's cells and stencils: see [`strips`].
    ///
    /// # Errors
    /// When there is no such edge, or a number overflows.
    fn strips(&self, index: usize, order: usize) -> Option<Result<Vec<Strip>>> {
        let _ = (index, order);
        None
    }
}

impl dyn Edges + '_ {
    /// All edges, one after another.
    pub fn iter(&self) -> impl Iterator<Item = BoundaryEdge> + '_ {
        (0..self.count()).map_while(|index| self.edge(index))
    }
}

/// The edges of a shape; `what` needs them.
///
/// # Errors
/// When it has none that it can name, in words.
pub fn edges_of<'a>(shape: &'a dyn Shape, what: &str) -> Result<&'a dyn Edges> {
    shape.edges().ok_or_else(|| {
        let name = shape.type_name();
        Error::Invalid(match shape.domain().len() {
            1 => "a curve has ends, no edges: join it at a parameter, such as the start of its domain; the edge of a surface is brought onto a curve by the constraint `edge`"
                .into(),
            _ if shape.cells().is_some_and(|cells| cells.is_partial()) => {
                format!(
                    "{what}: the loops of a trimmed surface are its boundary, not the edges of the surface that carries it; untrim it \
                     first"
                )
            }
            _ => format!("{what}: a surface ({name}) does not say which edges it has; convert it to a B-spline first"),
        })
    })
}

/// The derivatives across an edge up to an order, as splines along it in one space: the shape's own where it
/// [has them](Edges::strips), else found from its cells and stencils. The space is then as smooth at each place where cells
/// meet as these derivatives are, their stencils compared on both sides. `O(p³)` a cell along the edge.
///
/// # Errors
/// When there is no such edge or no cell at it, when these are rational and the shape does not say its strips itself, or a stencil
/// cannot be asked for.
pub fn strips(shape: &dyn Shape, index: usize, order: usize) -> Result<Vec<Strip>> {
    let what = "an edge";
    let edges = edges_of(shape, what)?;
    if let Some(own) = edges.strips(index, order) {
        let own = own?;
        let sound = own.len() == order + 1 && own.iter().all(|s| s.coefficients.len() == s.space.len());
        return if sound {
            Ok(own)
        } else {
            Err(Error::Invalid(format!(
                "edge {index} of a shape ({}) has strips that are not as many as asked, or do not fit their space",
                shape.type_name()
            )))
        };
    }
    let edge = edges.edge(index).ok_or_else(|| no_edge(shape, index, edges.count()))?;
    super::strip::from_cells(shape, &edge, super::cells_of(shape, what)?, order)
}

/// That a shape has no edge of this number.
pub(crate) fn no_edge(shape: &dyn Shape, index: usize, count: usize) -> Error {
    Error::Invalid(format!("a shape ({}) has no edge {index}: it has {count}", shape.type_name()))
}

/// The cells that lie at an edge, with their sides along it and across it, in the order in which it runs.
pub(super) fn cells_at(edge: &BoundaryEdge, cells: &[Cell]) -> Vec<(CellSide, CellSide)> {
    let [run, other] = if edge.along_u { [0, 1] } else { [1, 0] };
    let mut all: SmallVec<[(CellSide, CellSide); 8]> = SmallVec::new();
    for cell in cells.iter().filter(|cell| cell.face == edge.face) {
        let (Some(run), Some(other)) = (cell.sides.get(run), cell.sides.get(other)) else { continue };
        let touches = if edge.at_end { other.end == edge.fixed } else { other.start == edge.fixed };
        if touches && run.start < edge.end && run.end > edge.start {
            all.push((*run, *other));
        }
    }
    all.sort_by(|a, b| a.0.start.total_cmp(&b.0.start));
    all.into_vec()
}
