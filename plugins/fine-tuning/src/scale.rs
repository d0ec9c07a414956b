//! α as a shape, so that it can be asked for things as every shape can.

use loftsman_kernel::Point;
use loftsman_kernel::error::Result;
use loftsman_kernel::shape::{Derivative, Domain, Interval, Location, Shape, Side, Sides, Stencil};
use loftsman_kernel::spline::Space;
use loftsman_kernel::spline::algebra::Function;

/// A scalar spline function as a shape: its values are the x coordinates of its control vertices, y and z are zero. Any linear
/// functional may be asked of it: `position(u).axis(X)` is α's value, `derivative(u, 1).axis(X)` its slope.
#[derive(Debug, Clone)]
pub struct Scale {
    space: Space,
    vertices: Vec<Point>,
}

impl Scale {
    pub(crate) fn new(alpha: &Function<f64>) -> Self {
        let vertices = alpha.coefficients().iter().map(|c| Point::new(*c, 0.0, 0.0)).collect();
        Self { space: alpha.space().clone(), vertices }
    }

    /// The function.
    ///
    /// # Errors
    /// When a value is not finite.
    pub fn function(&self) -> Result<Function<f64>> {
        Function::new(self.space.clone(), self.vertices.iter().map(|p| p.x).collect())
    }
}

/// The values of the B-splines of a space, or of a derivative of them, on one side of a place.
pub(crate) fn row(space: &Space, at: f64, derivative: usize, side: Side) -> Result<Stencil> {
    let (span, u) = space.span_on(space.locate(at)?, side);
    let p = space.degree();
    let mut row = vec![0.0; p + 1];
    space.basis_into(span, u, derivative, &mut row);
    Ok(row.iter().enumerate().map(|(i, c)| (space.vertex(span - p + i), *c)).collect())
}

impl Shape for Scale {
    fn control_vertices(&self) -> &[Point] {
        &self.vertices
    }

    fn control_vertices_mut(&mut self) -> &mut [Point] {
        &mut self.vertices
    }

    fn stencil(&self, at: Location, derivative: Derivative) -> Result<Stencil> {
        row(&self.space, at.on_curve()?, derivative.u, Side::Right)
    }

    fn stencil_on(&self, at: Location, derivative: Derivative, sides: Sides) -> Result<Stencil> {
        row(&self.space, at.on_curve()?, derivative.u, sides.u)
    }

    fn domain(&self) -> Domain {
        let (start, end) = self.space.domain();
        std::iter::once(Interval { start, end, periodic: self.space.is_periodic() }).collect()
    }

    fn boxed(&self) -> Box<dyn Shape> {
        Box::new(self.clone())
    }
}
