//! α as a shape, so that it can be asked for things as every shape can.

use loftsman_kernel::Point;
use loftsman_kernel::error::Result;
use loftsman_kernel::shape::{Derivative, Domain, Interval, Location, Shape, Stencil};
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

impl Shape for Scale {
    fn control_vertices(&self) -> &[Point] {
        &self.vertices
    }

    fn control_vertices_mut(&mut self) -> &mut [Point] {
        &mut self.vertices
    }

    fn stencil(&self, at: Location, derivative: Derivative) -> Result<Stencil> {
        let u = self.space.locate(at.on_curve()?)?;
        let (p, span) = (self.space.degree(), self.space.span(u));
        let mut row = vec![0.0; p + 1];
        self.space.basis_into(span, u, derivative.u, &mut row);
        Ok(row.iter().enumerate().map(|(i, c)| (self.space.vertex(span - p + i), *c)).collect())
    }

    fn domain(&self) -> Domain {
        let (start, end) = self.space.domain();
        std::iter::once(Interval { start, end, periodic: self.space.is_periodic() }).collect()
    }

    fn boxed(&self) -> Box<dyn Shape> {
        Box::new(self.clone())
    }
}
