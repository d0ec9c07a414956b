//! A point of a limit surface and its tangents, as rows and as they are.

use loftsman_kernel::shape::Stencil;
use loftsman_kernel::{Point, Vector};

/// The rows of a point of a limit surface, over the vertices of the cage.
#[derive(Debug, Clone, PartialEq)]
pub struct LimitStencils {
    /// The point; its coefficients sum to one.
    pub position: Stencil,
    /// Two tangents, the second to the left of the first seen from outside; coefficients sum to zero. Their lengths say nothing.
    pub tangents: [Stencil; 2],
}

impl LimitStencils {
    /// The same over other vertices.
    pub(crate) fn map(self, back: impl Fn(&Stencil) -> Stencil) -> Self {
        let [u, v] = &self.tangents;
        Self { position: back(&self.position), tangents: [back(u), back(v)] }
    }
}

/// A point of a limit surface and its tangent plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimitFrame {
    /// The point.
    pub point: Point,
    /// Two tangents, the second to the left of the first seen from outside. Their lengths say nothing.
    pub tangents: [Vector; 2],
}

impl LimitFrame {
    /// The unit normal, outwards; `None` where the tangents do not span a plane but by rounding (coincident vertices, a flat corner).
    pub fn normal(&self) -> Option<Vector> {
        const ROUNDING: f64 = 16.0 * f64::EPSILON;
        let [a, b] = self.tangents;
        let (long, short) = (a.norm().max(b.norm()), a.norm().min(b.norm()));
        if short <= ROUNDING * long {
            return None;
        }
        // By unit vectors, so that what counts is the angle between them.
        let (a, b) = (a.try_normalize(0.0)?, b.try_normalize(0.0)?);
        a.cross(&b).try_normalize(ROUNDING).filter(|n| n.iter().all(|c| c.is_finite()))
    }
}
