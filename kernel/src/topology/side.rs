//! One whole edge of a surface: where it is, and what its cross derivatives are made of.

use crate::Point;
use crate::error::Result;
use crate::shape::{BoundaryEdge, Derivative, Location, Shape, Stencil, Strip, edges_of, no_edge, strips};
use crate::spline::Space;

/// A whole edge of a surface, with its derivatives across up to an order.
#[derive(Debug, Clone)]
pub(crate) struct SurfaceEdge<'a> {
    shape: &'a dyn Shape,
    edge: BoundaryEdge,
    rational: bool,
    space: Space,
    strips: Vec<Strip>,
}

impl<'a> SurfaceEdge<'a> {
    /// Edge number `index` of a shape, with its derivatives across up to `order`.
    ///
    /// # Errors
    /// As for [`strips`].
    pub(crate) fn new(shape: &'a dyn Shape, index: usize, order: usize, what: &str) -> Result<Self> {
        let edges = edges_of(shape, what)?;
        let none = || no_edge(shape, index, edges.count());
        let edge = edges.edge(index).ok_or_else(none)?;
        let strips = strips(shape, index, order)?;
        let space = strips.first().ok_or_else(none)?.space.clone();
        let rational = shape.cells().is_some_and(|cells| cells.is_rational());
        Ok(Self { shape, edge, rational, space, strips })
    }

    /// The space along the edge.
    pub(crate) fn space(&self) -> &Space {
        &self.space
    }

    pub(crate) fn is_rational(&self) -> bool {
        self.rational
    }

    /// Whether it lies at the end of the parameter across it.
    pub(crate) fn at_end(&self) -> bool {
        self.edge.at_end
    }

    pub(crate) fn at(&self, t: f64) -> Location {
        self.edge.at(t)
    }

    pub(crate) fn across(&self, order: usize) -> Derivative {
        self.edge.across(order)
    }

    pub(crate) fn point(&self, t: f64) -> Result<Point> {
        self.shape.value(self.at(t), Derivative::POSITION).map(Point::from)
    }

    /// The cross derivative at `t` in terms of the control vertices.
    pub(crate) fn stencil(&self, t: f64, order: usize) -> Result<Stencil> {
        self.shape.stencil(self.at(t), self.across(order))
    }

    /// The cross derivatives of `w S` along the edge, each a spline in the edge's own space.
    pub(crate) fn strips(&self) -> &[Strip] {
        &self.strips
    }
}
