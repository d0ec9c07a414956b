//! Splines as segments and triangles that are never further from the shape than asked.
//!
//! [`Adaptive`] is the kernel's [`Tessellator`]: it bounds the distance between chord and curve (or triangle and
//! surface) from control points, so that no wiggle between samples can be missed, and says how it rounds:
//!
//! * *curves* ([`Adaptive::curve_parameters`]): each Bézier piece is divided until its control polygon is within
//!   the chord tolerance and the angle, or a bound on the second derivative says that it is;
//! * *surfaces*: a grid of parameter lines, finer where the surface bends more, whose cells are bounded by the
//!   second derivatives of their Bézier patches; seams and poles share their vertices, so that a closed surface
//!   gives a closed mesh.
//!
//! The same input gives the same bytes. [`Tessellation`] registers it.

mod bezier;
mod bounds;
mod curve;
mod evaluate;
mod fineness;
mod lines;
mod normals;
mod surface;
mod weld;

use loftsman_kernel::Result;
use loftsman_kernel::mesh::{Mesh, Polyline};
use loftsman_kernel::plugin::{Fineness, Plugin, Registry, Tessellator};
use loftsman_kernel::spline::{Curve, Surface};

/// The tessellator with a guaranteed chord tolerance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Adaptive {
    /// The largest number of segments or triangles of one shape; a tolerance that would need more is refused.
    pub budget: usize,
}

impl Default for Adaptive {
    /// At most 50 million segments or triangles a shape.
    fn default() -> Self {
        Self { budget: 50_000_000 }
    }
}

impl Adaptive {
    /// The parameters whose points make the polyline of [`curve`](Tessellator::curve), from one end of the
    /// domain to the other (both included; every knot among them). `O(points · p³)`.
    ///
    /// # Errors
    /// When the fineness is not positive, is below what the coordinates resolve, or needs more than
    /// [`budget`](Self::budget) segments; when all control vertices coincide.
    pub fn curve_parameters(&self, curve: &Curve, fineness: &Fineness) -> Result<Vec<f64>> {
        curve::parameters(curve, fineness, self.budget)
    }
}

impl Tessellator for Adaptive {
    /// Every point of the curve is within the chord tolerance of its segment and every point of a segment within
    /// it of the curve; neighbouring segments turn by no more than the angle, except at real corners and cusps
    /// (where pieces shorter than 1e-5 of the curve's size are left alone).
    ///
    /// Curves that end where they start, periodic or not, give closed polylines.
    fn curve(&self, curve: &Curve, fineness: &Fineness) -> Result<Polyline> {
        curve::polyline(curve, fineness, self.budget)
    }

    /// Those of [`Adaptive::curve_parameters`], the method of the type itself.
    fn curve_parameters(&self, curve: &Curve, fineness: &Fineness) -> Result<Vec<f64>> {
        curve::parameters(curve, fineness, self.budget)
    }

    /// Every point of a triangle is within the chord tolerance of the surface at the same parameters, so that
    /// the bound holds both ways; the surface's normals at neighbouring vertices differ by no more than the angle
    /// (measured at the vertices, creases and singular points excepted).
    ///
    /// Seams (periodic, or edges that coincide) and poles share their vertices. At a seam the shared vertex keeps
    /// the parameter of the start, so that `uvs` run back from nearly 1 to 0 over the last row of triangles; at a
    /// pole it keeps the first. Across a crease (an interior knot of full multiplicity) the normals of both sides
    /// are averaged.
    fn surface(&self, surface: &Surface, fineness: &Fineness) -> Result<Mesh> {
        surface::mesh(surface, fineness, self.budget)
    }
}

/// Registers [`Adaptive`] as the tessellator.
#[derive(Debug, Clone, Copy, Default)]
pub struct Tessellation;

impl Plugin for Tessellation {
    fn register(&self, registry: &mut Registry) {
        registry.set_tessellator(Adaptive::default());
    }
}
