//! What every editable thing has in common: its points depend linearly on its control vertices.

mod bonds;
mod cells;
mod chart;
mod edges;
mod gram;
mod hole;
mod location;
mod neighbours;
mod refine;
pub(crate) mod share;
mod stencil;
mod strip;
mod torn;

use std::any::Any;
use std::fmt::Debug;

use smallvec::SmallVec;

use crate::error::{Error, Result};
use crate::solve::Symmetric;
use crate::{Point, Vector};

pub use bonds::{Bond, Bonds};
pub use cells::{Cell, CellNet, CellSide, Cells, Patch, Splines, cells_of, rows_at};
pub use chart::{Chart, ChartedRow, charted_rows};
pub(crate) use edges::no_edge;
pub use edges::{BoundaryEdge, Edges, Strip, edges_of, strips};
pub use hole::{Border, Hole};
pub use location::{Derivative, Location, Side, Sides};
pub use neighbours::Neighbours;
pub use refine::{Refine, refine_of};
pub use share::{CellPart, Share};
pub use stencil::Stencil;
pub use torn::{Tear, torn};

/// Unit tangents that differ by no more than this, in radians (0.0006°), are those of a smooth curve: what six decimals of
/// a text file leave of it. What is kept is the relation as it is, so that a knot that is less smooth than to rounding
/// becomes no worse and is not moved to be better.
pub(crate) const SMOOTH: f64 = 1e-5;

/// The parameters a shape is defined on: one interval a direction, each perhaps closed onto itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Where it starts.
    pub start: f64,
    /// Where it ends.
    pub end: f64,
    /// Whether the end meets the start (a periodic direction).
    pub periodic: bool,
}

/// A shape: anything whose points depend **linearly** on its control vertices. Curves and surfaces, polynomial
/// and rational (weights fixed), implement it here; other crates add their own, and every functional then works
/// on them.
///
/// What only some shapes can do are further traits, each asked for by a method that answers `None` by default: the
/// [cells](Self::cells) that a shape consists of (integrals, energies, areas, volumes), its [edges](Self::edges) (joins, closed
/// shells), the [neighbours](Self::neighbours) of a control vertex (falloff), and how to [refine](Self::refine) it.
pub trait Shape: Any + Debug + Send + Sync {
    /// The control vertices, in one sequence.
    fn control_vertices(&self) -> &[Point];

    /// The control vertices, to be moved. Their number is fixed.
    fn control_vertices_mut(&mut self) -> &mut [Point];

    /// The row of coefficients whose sum with the control vertices is the shape's `derivative` `at` a location.
    ///
    /// # Errors
    /// When the location is outside the domain, has the wrong number of parameters, or the order is beyond 25.
    fn stencil(&self, at: Location, derivative: Derivative) -> Result<Stencil>;

    /// The same from a side: the limit of the rows of the pieces that end (or begin) at a location. It is another row
    /// than [`stencil`](Self::stencil)'s, which is that from the right, only at knots that are repeated as often as the
    /// degree less the derivative's order, or oftener; at the ends of an open domain there is one side. By default
    /// the sides are alike: right for shapes without such places.
    ///
    /// # Errors
    /// As for [`stencil`](Self::stencil).
    fn stencil_on(&self, at: Location, derivative: Derivative, sides: Sides) -> Result<Stencil> {
        let _ = sides;
        self.stencil(at, derivative)
    }

    /// The domain: one interval for a curve, two for a surface; of a surface of many faces that of each, or of the first where they
    /// [differ](Self::face_domain).
    fn domain(&self) -> Domain;

    /// The domain of a face, of a surface of many: by default they are alike.
    fn face_domain(&self, face: u32) -> Domain {
        let _ = face;
        self.domain()
    }

    /// How many faces it has, where a location needs one ([`Location::Face`]). `None` (the default) for curves, and for surfaces
    /// that are one patch.
    fn faces(&self) -> Option<usize> {
        None
    }

    /// A copy behind a box, so that shapes of any kind can be kept together.
    fn boxed(&self) -> Box<dyn Shape>;

    /// The value (or derivative) at a location: `Σ S_i P_i`.
    ///
    /// # Errors
    /// As for [`stencil`](Self::stencil).
    fn value(&self, at: Location, derivative: Derivative) -> Result<Vector> {
        Ok(self.stencil(at, derivative)?.apply(self.control_vertices()))
    }

    /// The matrix of `(1/L) ∫ |f|² + L^(2k) |f^(k)|²` over the basis functions, for `k = order` (1 stretch, 2 bend),
    /// `L` the length of the domain; positive definite, and independent of how the domain is scaled. By default from the
    /// shape's [cells](Self::cells), by Gauss points, `L` of a shape of [faces](Self::faces) times the square root of their number; `None` where it has no cells,
    /// or they are wrong.
    fn smoothness(&self, order: usize) -> Option<Symmetric> {
        gram::smoothness(self, order).ok()
    }

    /// The pieces on which it is one polynomial, or one quotient of two: from these integrals over it are computed. `None`
    /// (the default) where they are not known.
    fn cells(&self) -> Option<&dyn Cells> {
        None
    }

    /// The boundary of a surface: what can be joined, and closed. `None` (the default) where it is not known, and of curves.
    fn edges(&self) -> Option<&dyn Edges> {
        None
    }

    /// Which control vertices are next to one another, where that is not a [grid](Self::grid); a shape that has one need not say
    /// it again. `None` (the default) where it is not known.
    fn neighbours(&self) -> Option<&dyn Neighbours> {
        None
    }

    /// What gives it more control vertices without changing it. `None` (the default) where nothing does.
    fn refine(&self) -> Option<&dyn Refine> {
        None
    }

    /// What it is in Rust, for messages about shapes that are wrong.
    fn type_name(&self) -> &'static str {
        std::any::type_name::<Self>()
    }

    /// How the control vertices neighbour one another, where they do as a grid of `rows × columns`, row after row, each direction
    /// perhaps closed. `None` (the default) where they do not, or it is not known: nobody guesses then which are neighbours.
    fn grid(&self) -> Option<Grid> {
        None
    }

    /// How its pieces hang together while some of them move. `None` (the default) where it is one piece, or nothing has to be done for
    /// that.
    fn bonds(&self) -> Option<&dyn Bonds> {
        None
    }

    /// Brings what [follows](Bonds) from other control vertices to where these are now. Whoever moves control vertices says it when
    /// they are all in place. Allocates nothing.
    fn follow(&mut self) {}

    /// Ends an edit: what was [ready](Bonds::ready) to move is a shape as any other again. What there is to tell of how its pieces hang
    /// together now, for the report.
    ///
    /// # Errors
    /// When it cannot be measured.
    fn settle(&mut self) -> Result<Vec<String>> {
        Ok(Vec::new())
    }

    /// The shape itself: of a box, what is in it, so that whoever asks what a shape is sees that.
    fn as_shape(&self) -> &dyn Shape
    where
        Self: Sized,
    {
        self
    }

    /// The shape in a box: of a box, itself.
    fn into_box(self) -> Box<dyn Shape>
    where
        Self: Sized,
    {
        Box::new(self)
    }

    /// What is in a box, where it is of this type: [`into_box`](Self::into_box)'s way back.
    fn from_box(shape: Box<dyn Shape>) -> Option<Self>
    where
        Self: Sized,
    {
        let any: Box<dyn Any> = shape;
        any.downcast().ok().map(|shape| *shape)
    }

    /// The same, looked at.
    #[allow(clippy::borrowed_box, reason = "a box is itself a shape, and what is looked for")]
    fn in_box(shape: &Box<dyn Shape>) -> Option<&Self>
    where
        Self: Sized,
    {
        let any: &dyn Any = shape.as_ref();
        any.downcast_ref()
    }
}

/// A shape of any kind is a shape: edits and fairings take it as it comes.
impl Shape for Box<dyn Shape> {
    fn control_vertices(&self) -> &[Point] {
        self.as_ref().control_vertices()
    }

    fn control_vertices_mut(&mut self) -> &mut [Point] {
        self.as_mut().control_vertices_mut()
    }

    fn stencil(&self, at: Location, derivative: Derivative) -> Result<Stencil> {
        self.as_ref().stencil(at, derivative)
    }

    fn stencil_on(&self, at: Location, derivative: Derivative, sides: Sides) -> Result<Stencil> {
        self.as_ref().stencil_on(at, derivative, sides)
    }

    fn domain(&self) -> Domain {
        self.as_ref().domain()
    }

    fn face_domain(&self, face: u32) -> Domain {
        self.as_ref().face_domain(face)
    }

    fn faces(&self) -> Option<usize> {
        self.as_ref().faces()
    }

    fn boxed(&self) -> Box<dyn Shape> {
        self.as_ref().boxed()
    }

    fn value(&self, at: Location, derivative: Derivative) -> Result<Vector> {
        self.as_ref().value(at, derivative)
    }

    fn smoothness(&self, order: usize) -> Option<Symmetric> {
        self.as_ref().smoothness(order)
    }

    fn cells(&self) -> Option<&dyn Cells> {
        self.as_ref().cells()
    }

    fn edges(&self) -> Option<&dyn Edges> {
        self.as_ref().edges()
    }

    fn neighbours(&self) -> Option<&dyn Neighbours> {
        self.as_ref().neighbours()
    }

    fn refine(&self) -> Option<&dyn Refine> {
        self.as_ref().refine()
    }

    fn type_name(&self) -> &'static str {
        self.as_ref().type_name()
    }

    fn grid(&self) -> Option<Grid> {
        self.as_ref().grid()
    }

    fn bonds(&self) -> Option<&dyn Bonds> {
        self.as_ref().bonds()
    }

    fn follow(&mut self) {
        self.as_mut().follow();
    }

    fn settle(&mut self) -> Result<Vec<String>> {
        self.as_mut().settle()
    }

    fn as_shape(&self) -> &dyn Shape {
        self.as_ref()
    }

    fn into_box(self) -> Box<dyn Shape> {
        self
    }

    fn from_box(shape: Box<dyn Shape>) -> Option<Self> {
        Some(shape)
    }

    fn in_box(shape: &Box<dyn Shape>) -> Option<&Self> {
        Some(shape)
    }
}

impl Clone for Box<dyn Shape> {
    fn clone(&self) -> Self {
        self.boxed()
    }
}

/// The grid of a shape's control vertices; one open row where there is none, for those to whom it is an order and no more.
pub fn grid_or_row(shape: &dyn Shape) -> Grid {
    let columns = shape.control_vertices().len();
    shape.grid().unwrap_or(Grid { rows: 1, columns, rows_wrap: false, columns_wrap: false })
}

/// Whether a shape hangs together: as many control vertices to move as to look at, a grid of just these, a domain.
///
/// # Errors
/// When it does not, naming its type.
pub(crate) fn check_shape(shape: &mut dyn Shape) -> Result<()> {
    let (count, name) = (shape.control_vertices().len(), shape.type_name());
    let wrong = |what: String| Err(Error::Invalid(format!("a shape ({name}) {what}")));
    let movable = shape.control_vertices_mut().len();
    if movable != count {
        return wrong(format!(
            "has {count} control vertices to look at and {movable} to move: these must be the same"
        ));
    }
    let Grid { rows, columns, .. } = grid_or_row(shape);
    if rows.checked_mul(columns) != Some(count) {
        return wrong(format!("has {count} control vertices in a grid of {rows} × {columns}"));
    }
    let domain = shape.domain();
    let sound = |i: &Interval| i.start.is_finite() && i.end.is_finite() && i.start < i.end;
    if !(1..=2).contains(&domain.len()) || !domain.iter().all(sound) {
        let found: Vec<String> = domain.iter().map(|i| format!("[{}, {}]", i.start, i.end)).collect();
        return wrong(format!(
            "has the domain {}: one interval for a curve or two for a surface are needed, each with a length",
            if found.is_empty() { "of nothing".to_owned() } else { found.join(" × ") }
        ));
    }
    Ok(())
}

/// The intervals of a shape's parameters.
pub type Domain = SmallVec<[Interval; 2]>;

/// The neighbourhood of control vertices: vertex `i` is at row `i / columns`, column `i % columns`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Grid {
    /// Rows (along `u` of a surface; 1 for a curve).
    pub rows: usize,
    /// Columns (along `v` of a surface; all vertices of a curve).
    pub columns: usize,
    /// Whether the last row neighbours the first.
    pub rows_wrap: bool,
    /// Whether the last column neighbours the first.
    pub columns_wrap: bool,
}

/// The index of a control vertex, where negative numbers count from the end (`-1` is the last).
///
/// # Errors
/// [`Error::NoVertex`] where there is none.
pub fn vertex_index(index: i64, count: usize) -> Result<usize> {
    let resolved = if index < 0 { index + count as i64 } else { index };
    if resolved >= 0 && (resolved as usize) < count {
        Ok(resolved as usize)
    } else {
        Err(Error::NoVertex { index, count })
    }
}
