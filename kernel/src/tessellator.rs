//! Splines as segments and triangles: the interface that formats ask for.

use crate::Point;
use crate::error::{Error, Result};
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

impl Chord {
    /// The length that was asked for; of a part of a size, the length that it `became`.
    pub fn length(self, became: f64) -> f64 {
        match self {
            Self::Absolute(length) => length,
            Self::Relative(_) => became,
        }
    }
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
    /// The chord asked for, as a length in the surface's unit.
    pub tolerance: f64,
    /// The largest distance that a point of either can have from the other, in the surface's unit: bounded, not sampled,
    /// and never more than the chord asked for.
    pub error: f64,
}

/// A curve in each of its states (the frames of an animation) as segments, cut at the same parameters in all of them.
#[derive(Debug, Clone, PartialEq)]
pub struct MovingLine {
    /// The points of each state, in the order of the parameters; as many in all.
    pub states: Vec<Vec<Point>>,
    /// The parameter of each point, ascending. Where the curve is torn, two points have one: the end of the part before, and
    /// the start of the next.
    pub parameters: Vec<f64>,
    /// The first point of each part: 0, and those before which the curve is torn in any state.
    pub starts: Vec<usize>,
    /// Whether the last point is joined to the first (which is not repeated): the curve closes in all states.
    pub closed: bool,
    /// The chord asked for, as a length: that of the largest state.
    pub tolerance: f64,
    /// The largest distance that a point of the curve or of its segments can have from the other in any state: bounded, not
    /// sampled.
    pub error: f64,
}

/// A surface in each of its states (the frames of an animation) as triangles between the same parameters in all of them.
#[derive(Debug, Clone, PartialEq)]
pub struct MovingMesh {
    /// The first state, as [`Tessellated::mesh`]; where all of that is one point, its normals are those of the first state
    /// that has any extent.
    pub mesh: Mesh,
    /// The points of each state, in the order of the mesh's.
    pub states: Vec<Vec<Point>>,
    /// The chord asked for, as a length: that of the largest state.
    pub tolerance: f64,
    /// The largest distance that a point of the surface or of its triangles can have from the other in any state: bounded,
    /// not sampled.
    pub error: f64,
}

/// Turns curves into polylines and surfaces into meshes.
pub trait Tessellator: Send + Sync {
    /// Points of the curve, in order, so that no point of it is further from the segments than the chord.
    ///
    /// # Errors
    /// [`Error::NoExtent`] where all of the curve is one point; otherwise when the fineness is not positive, or so small that
    /// the result would be beyond reason, or when the shape cannot be resolved.
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

    /// One set of parameters for all states of a curve: frames of an animation, or a single one. Every state is held to the
    /// fineness; a relative chord is relative to the state's own size, but not finer than for one a thousandth as large as the
    /// largest. The states have one [`Space`](crate::spline::Space) and the same weights.
    ///
    /// # Errors
    /// As for [`curve`](Self::curve), [`Error::NoExtent`] only where that is so in all states; when there are no states or they
    /// do not belong together. A tessellator need not know how, and then says so: so does this, unless it is replaced.
    fn moving_curve(&self, states: &[Curve], fineness: &Fineness) -> Result<MovingLine> {
        let _ = (states, fineness);
        Err(Error::Invalid(
            "this tessellator cannot cut several states of a curve alike: use another".to_owned(),
        ))
    }

    /// As [`moving_curve`](Self::moving_curve), for surfaces.
    ///
    /// # Errors
    /// As for [`moving_curve`](Self::moving_curve).
    fn moving_surface(&self, states: &[Surface], fineness: &Fineness) -> Result<MovingMesh> {
        let _ = (states, fineness);
        Err(Error::Invalid(
            "this tessellator cannot cut several states of a surface alike: use another".to_owned(),
        ))
    }

    /// The mesh of [`measured_surface`](Self::measured_surface) alone.
    ///
    /// # Errors
    /// As for [`curve`](Self::curve).
    fn surface(&self, surface: &Surface, fineness: &Fineness) -> Result<Mesh> {
        Ok(self.measured_surface(surface, fineness)?.mesh)
    }
}
