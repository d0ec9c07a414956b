//! Splines as segments and triangles: the interface that formats ask for.

use crate::error::Result;
use crate::mesh::{Mesh, Polyline};
use crate::spline::{Curve, Surface};

/// How far a chord may be from the shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Chord {
    /// A length, in the scene's unit.
    Absolute(f64),
    /// A fraction of the diagonal of the shape's bounding box. Formats that write a whole scene take the box of all surfaces that
    /// hang together by common edges ([`Scene::joined_diagonals`](crate::scene::Scene::joined_diagonals)), so that these stay joined.
    Relative(f64),
}

/// How fine a tessellation is: both bounds hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fineness {
    /// The largest distance between the shape and its segments or triangles.
    pub chord: Chord,
    /// The largest angle between neighbouring segments, in radians.
    pub angle: f64,
}

impl Default for Fineness {
    /// A thousandth of the diagonal, and 15 degrees.
    fn default() -> Self {
        Self { chord: Chord::Relative(1e-3), angle: 15_f64.to_radians() }
    }
}

/// A surface as a mesh, and how near the two are.
#[derive(Debug, Clone, PartialEq)]
pub struct Tessellated {
    /// Triangles with unit normals and `uvs` (the surface's parameters scaled to `[0, 1]²`).
    pub mesh: Mesh,
    /// The largest distance that a point of either can have from the other, in the surface's unit: bounded, not sampled,
    /// and never more than the chord asked for.
    pub error: f64,
}

/// Turns curves into polylines and surfaces into meshes.
pub trait Tessellator: Send + Sync {
    /// Points of the curve, in order, so that no point of it is further from the segments than the chord.
    ///
    /// # Errors
    /// When the fineness is not positive, or so small that the result would be beyond reason.
    fn curve(&self, curve: &Curve, fineness: &Fineness) -> Result<Polyline>;

    /// The parameters of the points of [`curve`](Self::curve), in their order, from one end of the domain to the other
    /// (both included, also where the polyline closes). Where the curve stands still, points may be fewer.
    ///
    /// # Errors
    /// As for [`curve`](Self::curve).
    fn curve_parameters(&self, curve: &Curve, fineness: &Fineness) -> Result<Vec<f64>>;

    /// Triangles of the surface, and how far they are from it at most.
    ///
    /// # Errors
    /// As for [`curve`](Self::curve).
    fn measured_surface(&self, surface: &Surface, fineness: &Fineness) -> Result<Tessellated>;

    /// The mesh of [`measured_surface`](Self::measured_surface) alone.
    ///
    /// # Errors
    /// As for [`curve`](Self::curve).
    fn surface(&self, surface: &Surface, fineness: &Fineness) -> Result<Mesh> {
        Ok(self.measured_surface(surface, fineness)?.mesh)
    }
}
