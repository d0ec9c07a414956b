//! One edge of a surface: where it is, and which control vertices its cross derivatives are made of.

use std::any::Any;

use super::Edge;
use crate::Point;
use crate::error::{Error, Result};
use crate::functional::{On, Shapes};
use crate::shape::{Derivative, Location, Shape, Stencil};
use crate::spline::space::MAX_ORDER;
use crate::spline::{Space, Surface};

/// A whole edge of a B-spline surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Side<'a> {
    surface: &'a Surface,
    along_u: bool,
    pub(super) at_end: bool,
    fixed: f64,
    /// The largest weight: all are divided by it, so that no product of two overflows.
    heaviest: f64,
}

impl<'a> Side<'a> {
    pub(super) fn new(shapes: &Shapes<'a>, on: &On, edge: Edge) -> Result<Self> {
        let any: &dyn Any = shapes.get(on.shape)?;
        let Some(surface) = any.downcast_ref::<Surface>() else {
            let what = match shapes.get(on.shape)?.domain().len() {
                1 => {
                    "a curve has ends, no edges: join it at one parameter, such as its domain's start or end"
                }
                _ => "only B-spline surfaces can be joined along an edge",
            };
            return Err(Error::Invalid(format!("{what}{on}")));
        };
        let (along_u, at_end) = match edge {
            Edge::UStart => (false, false),
            Edge::UEnd => (false, true),
            Edge::VStart => (true, false),
            Edge::VEnd => (true, true),
        };
        let (start, end) = if along_u { surface.v().domain() } else { surface.u().domain() };
        let heaviest = surface.weights().map_or(1.0, |w| w.iter().fold(0.0, |m: f64, w| m.max(*w)));
        Ok(Self { surface, along_u, at_end, fixed: if at_end { end } else { start }, heaviest })
    }

    /// The space along the edge.
    pub(super) fn space(&self) -> &'a Space {
        if self.along_u { self.surface.u() } else { self.surface.v() }
    }

    fn across_space(&self) -> &'a Space {
        if self.along_u { self.surface.v() } else { self.surface.u() }
    }

    pub(super) fn is_rational(&self) -> bool {
        self.surface.weights().is_some()
    }

    pub(super) fn at(&self, t: f64) -> Location {
        if self.along_u { Location::Surface(t, self.fixed) } else { Location::Surface(self.fixed, t) }
    }

    pub(super) fn across(&self, order: usize) -> Derivative {
        if self.along_u { Derivative { u: 0, v: order } } else { Derivative { u: order, v: 0 } }
    }

    pub(super) fn point(&self, t: f64) -> Result<Point> {
        let Location::Surface(u, v) = self.at(t) else { return Ok(Point::origin()) };
        self.surface.point(u, v)
    }

    /// The cross derivative at `t` in terms of the control vertices.
    pub(super) fn stencil(&self, t: f64, order: usize) -> Result<Stencil> {
        self.surface.stencil(self.at(t), self.across(order))
    }

    /// The cross derivative of each basis function across the edge that has one there: its vertex across, and how much.
    pub(super) fn basis(&self, order: usize) -> Result<Vec<(usize, f64)>> {
        let space = self.across_space();
        let t = space.locate(self.fixed)?;
        let (p, span) = (space.degree(), space.span(t));
        let mut row = [0.0; MAX_ORDER];
        space.basis_into(span, t, order, &mut row);
        let terms = (0..=p).map(|i| (space.vertex(span - p + i), row[i]));
        Ok(terms.filter(|(_, c)| *c != 0.0).collect())
    }

    fn vertex(&self, across: usize, along: usize) -> usize {
        let n = self.surface.v().len();
        if self.along_u { along * n + across } else { across * n + along }
    }

    /// The weight of a vertex, at most 1.
    fn weight(&self, vertex: usize) -> f64 {
        self.surface.weights().map_or(1.0, |w| w[vertex] / self.heaviest)
    }

    /// The cross derivative of `w S` along the edge is a spline in the edge's own space: each of its coefficients in terms
    /// of the control vertices, times `factor`.
    pub(super) fn strip(&self, basis: &[(usize, f64)], factor: f64) -> Vec<Stencil> {
        let coefficient = |along: usize| {
            let term = |&(across, c): &(usize, f64)| {
                let vertex = self.vertex(across, along);
                (vertex, factor * c * self.weight(vertex))
            };
            basis.iter().map(term).collect()
        };
        (0..self.space().len()).map(coefficient).collect()
    }
}

/// As many parameters as the space has vertices, at which a function of it is determined (Schoenberg and Whitney): the
/// Greville abscissae, for a floating space those of the clamped one that spans the same functions on the domain.
pub(super) fn places(space: &Space) -> Vec<f64> {
    if space.is_periodic() {
        return (0..space.len()).map(|i| space.greville(i)).collect();
    }
    let ((a, b), p, flat) = (space.domain(), space.degree(), space.flat());
    let inside = |k: f64| k.max(a).min(b);
    (0..space.len())
        .map(|i| inside(flat[i + 1..=i + p].iter().map(|&k| inside(k) / p as f64).sum()))
        .collect()
}
