//! Splines as segments and triangles that are never further from the shape than asked.
//!
//! [`Adaptive`] is the kernel's [`Tessellator`]: it bounds the distance between chord and curve (or triangle and
//! surface) from control points, so that no wiggle between samples can be missed, and says how it rounds:
//!
//! * *curves* ([`Adaptive::curve_parameters`]): as few chords as the tolerance permits, across knots, with the error
//!   spread evenly; corners are kept;
//! * *surfaces* ([`Tessellator::measured_surface`]): each Bézier patch is divided into cells until every triangle is
//!   certified to be near enough, measured across its plane; patches share their edges' points, seams and poles are
//!   one, so that a closed surface gives a closed mesh.
//!
//! An edge of a surface is cut by its own control points, the tolerance and the angle, and by nothing else: surfaces
//! whose edges coincide (the same Bézier pieces, run through either way) get the same points there when the tolerance
//! is a length. A relative one is a length of its own for each surface.
//!
//! *Trimmed surfaces and Breps* ([`Tessellator::measured_trimmed`], [`Tessellator::measured_brep`]) are triangulated in the plane of their surfaces'
//! parameters, by constrained Delaunay triangulations (crate `spade`, whose predicates are exact); each edge of a Brep is cut once for all of its
//! faces.
//!
//! What moves is cut at the same parameters in all its states ([`Tessellator::moving_curve`]), as finely as the worst of them
//! asks at each place.
//!
//! The same input gives the same bytes. [`Tessellation`] registers it.

mod assemble;
mod beside;
mod bezier;
mod brep;
mod cell;
mod curve;
mod distinct;
mod edge;
mod fineness;
mod flat;
mod form;
mod forms;
mod normals;
mod patch;
mod refine;
mod state;
mod surface;
mod topology;
mod tree;
mod triangulation;
mod weights;
mod weld;

use loftsman_kernel::brep::Brep;
use loftsman_kernel::mesh::Polyline;
use loftsman_kernel::plugin::{
    Beside, Fineness, MovingLine, MovingMesh, Plugin, Registry, Tessellated, TessellatedBrep, Tessellator,
};
use loftsman_kernel::spline::{Curve, Surface, Trimmed};
use loftsman_kernel::{Point, Result};

/// The tessellator with a guaranteed chord tolerance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Adaptive {
    /// The largest number of segments or triangles of one shape; a tolerance that would need more is refused.
    pub budget: usize,
}

impl Default for Adaptive {
    /// At most ten million segments or triangles a shape.
    fn default() -> Self {
        Self { budget: 10_000_000 }
    }
}

impl Adaptive {
    /// The parameters whose points make the polyline of [`curve`](Tessellator::curve), from one end of the domain to
    /// the other, both included. (Where the curve jumps the polyline also has the point before.) A chord costs some
    /// ten decisions of `O(p²)`.
    ///
    /// # Errors
    /// When the fineness is not positive, is below what the coordinates resolve, or needs more than
    /// [`budget`](Self::budget) segments; when all control vertices coincide.
    pub fn curve_parameters(&self, curve: &Curve, fineness: &Fineness) -> Result<Vec<f64>> {
        curve::parameters(curve, fineness, self.budget)
    }
}

impl Tessellator for Adaptive {
    /// Every point of the curve is within the chord tolerance of its segment and every point of a segment within it
    /// of the curve; neighbouring segments turn by no more than the angle, except at corners and where segments are
    /// no longer than twice the tolerance (at a cusp the angle is never met).
    ///
    /// Curves that end where they start, periodic or not, give closed polylines.
    fn curve(&self, curve: &Curve, fineness: &Fineness) -> Result<Polyline> {
        curve::polyline(curve, fineness, self.budget)
    }

    /// Those of [`Adaptive::curve_parameters`], the method of the type itself.
    fn curve_parameters(&self, curve: &Curve, fineness: &Fineness) -> Result<Vec<f64>> {
        curve::parameters(curve, fineness, self.budget)
    }

    /// No point of the surface is further than the chord tolerance from the mesh, and none of the mesh from the
    /// surface. Normals at the ends of a cell's edge differ by no more than the angle, except where the edge is no
    /// longer than twice the tolerance, along the surface's own edges, and at singular points.
    ///
    /// Seams (periodic, or edges that coincide) and poles share their points. Normals are split only where tangent
    /// planes differ by more than 2e-3; `uvs` differ at seams, and at poles by triangle.
    fn measured_surface(&self, surface: &Surface, fineness: &Fineness) -> Result<Tessellated> {
        surface::mesh(surface, fineness, self.budget, None)
    }

    /// The ends of its pieces and where these are cut.
    fn border(&self, surface: &Surface, fineness: &Fineness) -> Result<Vec<Point>> {
        surface::border(surface, fineness, self.budget)
    }

    /// As [`measured_surface`](Tessellator::measured_surface), and with the points beside it: a triangle along the border is divided where one of
    /// them lies between its ends. They are no further from its side than not quite half the chord that all is cut with, so that is taken
    /// smaller by that share, and the whole is certified to be within what was asked for.
    fn measured_surface_beside(
        &self,
        surface: &Surface,
        fineness: &Fineness,
        beside: Beside<'_>,
    ) -> Result<Tessellated> {
        surface::mesh(surface, fineness, self.budget, Some(beside))
    }

    /// Triangles of the regions, certified as those of [`measured_surface`](Tessellator::measured_surface). Loops are cut by how the
    /// surface bends along them; what is inside is what an odd number of loops separates from the end of the domain. Special curves and
    /// points are followed, but for chords that cross loops or one another. Where a surface that is not periodic closes, it is left open.
    fn measured_trimmed(&self, trimmed: &Trimmed, fineness: &Fineness) -> Result<Tessellated> {
        brep::trimmed_mesh(trimmed, fineness, self.budget)
    }

    /// Each edge is cut once, and each face certified as an untrimmed surface is. What is inside a face is what lies to the left of its
    /// loops; where these disagree, what an odd number of them separates from the end of the surface. Distances of edges from surfaces are
    /// found at the ends and in the middles of chords. Normals and `uvs` (the parameters scaled to `[0, 1]²`) are by corner: faces are
    /// smooth within, and split where they meet.
    fn measured_brep(&self, brep: &Brep, fineness: &Fineness) -> Result<TessellatedBrep> {
        brep::mesh(brep, fineness, self.budget)
    }

    /// A chord holds where it does in all states, so that each is as near as [`curve`](Tessellator::curve) would make it, with
    /// as many chords as the worst of them needs at each place. `O(states)` times that.
    fn moving_curve(&self, states: &[Curve], fineness: &Fineness) -> Result<MovingLine> {
        curve::moving(states, fineness, self.budget)
    }

    /// A cell is cut until its triangles are certified in all states. Seams and poles are one where they are in all states.
    fn moving_surface(&self, states: &[Surface], fineness: &Fineness) -> Result<MovingMesh> {
        surface::moving(states, fineness, self.budget)
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
