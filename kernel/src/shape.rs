//! What every editable thing has in common: its points depend linearly on its control vertices.

use std::any::Any;
use std::fmt::{self, Debug};

use smallvec::SmallVec;

use crate::error::{Error, Result};
use crate::solve::Symmetric;
use crate::{Point, Vector};

/// Where on a shape: `u` on a curve, `(u, v)` on a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Location {
    /// A parameter of a curve.
    Curve(f64),
    /// A pair of parameters of a surface.
    Surface(f64, f64),
}

impl Location {
    /// The number of parameters: 1 or 2.
    pub fn parameters(self) -> usize {
        match self {
            Self::Curve(_) => 1,
            Self::Surface(..) => 2,
        }
    }

    /// The parameter on a curve.
    ///
    /// # Errors
    /// [`Error::LocationKind`] where this is a location on a surface.
    pub fn on_curve(self) -> Result<f64> {
        match self {
            Self::Curve(u) => Ok(u),
            Self::Surface(..) => Err(Error::LocationKind { found: 2, expected: 1 }),
        }
    }

    /// The two parameters on a surface.
    ///
    /// # Errors
    /// [`Error::LocationKind`] where this is a location on a curve.
    pub fn on_surface(self) -> Result<(f64, f64)> {
        match self {
            Self::Surface(u, v) => Ok((u, v)),
            Self::Curve(_) => Err(Error::LocationKind { found: 1, expected: 2 }),
        }
    }
}

impl From<f64> for Location {
    fn from(u: f64) -> Self {
        Self::Curve(u)
    }
}

impl From<[f64; 2]> for Location {
    fn from([u, v]: [f64; 2]) -> Self {
        Self::Surface(u, v)
    }
}

impl From<(f64, f64)> for Location {
    fn from((u, v): (f64, f64)) -> Self {
        Self::Surface(u, v)
    }
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Curve(u) => write!(f, "{u}"),
            Self::Surface(u, v) => write!(f, "[{u}, {v}]"),
        }
    }
}

/// The order of a derivative: how often by `u` and, on a surface, by `v`. The default is the position itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Derivative {
    /// Times by `u`.
    pub u: usize,
    /// Times by `v`; 0 on a curve.
    pub v: usize,
}

impl Derivative {
    /// No derivative: the position.
    pub const POSITION: Self = Self { u: 0, v: 0 };
}

impl From<usize> for Derivative {
    fn from(u: usize) -> Self {
        Self { u, v: 0 }
    }
}

impl From<[usize; 2]> for Derivative {
    fn from([u, v]: [usize; 2]) -> Self {
        Self { u, v }
    }
}

/// Unit tangents that differ by no more than this, in radians (0.0006°), are those of a smooth curve: what six decimals of
/// a text file leave of it. What is kept is the relation as it is, so that a knot that is less smooth than to rounding
/// becomes no worse and is not moved to be better.
pub(crate) const SMOOTH: f64 = 1e-5;

/// From which side of a knot a derivative is taken: where a knot is repeated often enough, the two differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash, PartialOrd, Ord)]
pub enum Side {
    /// That of the piece which ends at the knot; at the start of a periodic direction, of the piece that ends its period.
    Left,
    /// That of the piece which begins at the knot, as everywhere where no side is said.
    #[default]
    Right,
}

/// A side in each parameter; a curve looks at the first only.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash, PartialOrd, Ord)]
pub struct Sides {
    /// In `u`.
    pub u: Side,
    /// In `v`.
    pub v: Side,
}

impl From<Side> for Sides {
    /// The same side in both parameters.
    fn from(side: Side) -> Self {
        Self { u: side, v: side }
    }
}

impl From<[Side; 2]> for Sides {
    fn from([u, v]: [Side; 2]) -> Self {
        Self { u, v }
    }
}

/// The sparse row `S` with `value = Σ S_i P_i`: which control vertices a point (or derivative) of a shape is
/// made of, and how much of each. On the stack up to bicubic surfaces. Vertices ascend and do not repeat.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Stencil {
    vertices: SmallVec<[usize; 16]>,
    coefficients: SmallVec<[f64; 16]>,
}

impl Stencil {
    /// An empty stencil: the value zero.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds `coefficient` at `vertex`, to what is there already where the vertex repeats.
    pub fn add(&mut self, vertex: usize, coefficient: f64) {
        match self.vertices.last() {
            Some(&last) if last >= vertex => match self.vertices.binary_search(&vertex) {
                Ok(at) => self.coefficients[at] += coefficient,
                Err(at) => {
                    self.vertices.insert(at, vertex);
                    self.coefficients.insert(at, coefficient);
                }
            },
            _ => {
                self.vertices.push(vertex);
                self.coefficients.push(coefficient);
            }
        }
    }

    /// The vertices, ascending.
    pub fn vertices(&self) -> &[usize] {
        &self.vertices
    }

    /// The coefficient of each vertex.
    pub fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    /// `(vertex, coefficient)` pairs.
    pub fn iter(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.vertices.iter().copied().zip(self.coefficients.iter().copied())
    }

    /// `Σ S_i P_i`. Vertices that do not exist count as zero.
    pub fn apply(&self, points: &[Point]) -> Vector {
        self.iter().fold(Vector::zeros(), |sum, (i, c)| points.get(i).map_or(sum, |p| sum + p.coords * c))
    }

    /// The stencil times a factor.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        for c in &mut self.coefficients {
            *c *= factor;
        }
        self
    }
}

impl FromIterator<(usize, f64)> for Stencil {
    fn from_iter<I: IntoIterator<Item = (usize, f64)>>(pairs: I) -> Self {
        let mut stencil = Self::new();
        for (vertex, coefficient) in pairs {
            stencil.add(vertex, coefficient);
        }
        stencil
    }
}

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

    /// The domain: one interval for a curve, two for a surface.
    fn domain(&self) -> Domain;

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
    /// `L` the length of the domain; positive definite, and independent of how the domain is scaled. `None` where the
    /// shape does not know one.
    fn smoothness(&self, order: usize) -> Option<Symmetric> {
        let _ = order;
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

    fn boxed(&self) -> Box<dyn Shape> {
        self.as_ref().boxed()
    }

    fn value(&self, at: Location, derivative: Derivative) -> Result<Vector> {
        self.as_ref().value(at, derivative)
    }

    fn smoothness(&self, order: usize) -> Option<Symmetric> {
        self.as_ref().smoothness(order)
    }

    fn type_name(&self) -> &'static str {
        self.as_ref().type_name()
    }

    fn grid(&self) -> Option<Grid> {
        self.as_ref().grid()
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
