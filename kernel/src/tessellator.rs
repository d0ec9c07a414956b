//! Splines as segments and triangles: the interface that formats ask for.

use std::collections::HashMap;

use crate::Point;
use crate::brep::Brep;
use crate::error::{Error, Figure, Result};
use crate::mesh::{Mesh, Polyline};
use crate::spline::{Curve, Surface, Trimmed};
use crate::text::{clip, short};

/// How far a chord may be from the shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Chord {
    /// A length, in the scene's unit.
    Absolute(f64),
    /// A fraction of the diagonal of the shape's bounding box. Formats that write a whole scene take the box of all surfaces that
    /// hang together by common edges ([`Scene::joined`](crate::scene::Scene::joined)), so that these stay joined.
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

impl Fineness {
    /// That both bounds are positive and finite.
    ///
    /// # Errors
    /// When one is not: which one, and what it is; the angle in degrees, as people ask for it.
    pub fn check(&self) -> Result<()> {
        let (Chord::Absolute(chord) | Chord::Relative(chord)) = self.chord;
        let both =
            [("chord tolerance", chord, ""), ("tessellation angle", self.angle.to_degrees(), " degrees")];
        match both.into_iter().find(|(_, value, _)| !(value.is_finite() && *value > 0.0)) {
            Some((what, value, unit)) => Err(Error::Invalid(format!(
                "a {what} of {}{unit} cannot be met: give a positive number",
                Figure(value)
            ))),
            None => Ok(()),
        }
    }
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

/// What meshes beside a surface's have on its border.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beside<'a> {
    /// Their points, in the coordinates of the surface, its own among them; those that are not on its border do not matter.
    pub points: &'a [Point],
    /// Points nearer than this are one, a length in the unit of the surface.
    pub near: f64,
}

/// How far an edge is from the surface of one of its faces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Apart {
    /// The edge.
    pub edge: usize,
    /// The face.
    pub face: usize,
    /// The distance, in the Brep's unit.
    pub distance: f64,
}

/// A Brep as a mesh, and how near the two are.
#[derive(Debug, Clone, PartialEq)]
pub struct TessellatedBrep {
    /// Triangles with unit normals and `uvs` by corner. Each edge is cut once and its points are one for all faces along it, so that
    /// what closes is watertight.
    pub mesh: Mesh,
    /// The face of each triangle, ascending.
    pub faces: Vec<usize>,
    /// For each edge the numbers of its points in the mesh, from its start to its end; empty where none of its faces is there.
    pub edges: Vec<Vec<u32>>,
    /// The faces that could not be cut, and why. Where there is one, the mesh is open along its edges.
    pub left_out: Vec<(usize, Error)>,
    /// The chord asked for, as a length in the Brep's unit.
    pub tolerance: f64,
    /// The largest distance of a point of the mesh from its face, and of the face from the mesh, in the Brep's unit: bounded, not
    /// sampled; it includes how far the edges are from the surfaces.
    pub error: f64,
    /// The edge that was found furthest from the surface of a face; `None` where all are on theirs.
    pub furthest: Option<Apart>,
}

impl TessellatedBrep {
    /// What to say where the mesh is not as near as was asked for: because of which edge, that no finer mesh brings nearer. `None` where it is
    /// near enough. `scale`: a length in the unit of who reads it to one of the Brep.
    pub fn excess(&self, scale: f64) -> Option<String> {
        // What is asked for is met to rounding.
        if self.error <= self.tolerance * (1.0 + 1e-9) {
            return None;
        }
        let (error, tolerance) = (short(self.error * scale), short(self.tolerance * scale));
        Some(match self.furthest.filter(|apart| 2.0 * apart.distance > self.error - self.tolerance) {
            Some(Apart { edge, face, distance }) => format!(
                "it is within {error} only, not the {tolerance} asked for: edge {edge} is {} off the surface of face {face}, which no finer mesh changes; mend the edge where it was made, or ask for no less",
                short(distance * scale)
            ),
            None => format!("it is within {error} only, not the {tolerance} asked for"),
        })
    }

    /// The colours that faces have of their own, and for each triangle the number of its colour among them: 0, whose entry is `None`, where its face
    /// has none. In the order of the triangles; `O(triangles)`.
    pub fn colors(&self, brep: &Brep) -> (Vec<Option<[f64; 4]>>, Vec<u32>) {
        let mut colors = vec![None];
        let mut known: HashMap<[u64; 4], u32> = HashMap::new();
        let mut of_face = |face: usize| match brep.face_color(face) {
            None => 0,
            Some(color) => *known.entry(color.map(f64::to_bits)).or_insert_with(|| {
                colors.push(Some(color));
                colors.len() as u32 - 1
            }),
        };
        let of_triangles = self.faces.iter().map(|&face| of_face(face)).collect();
        (colors, of_triangles)
    }

    /// What to say where faces are left out: how many, and of the first of them which and why. `None` where all are there.
    pub fn remark(&self, brep: &Brep) -> Option<String> {
        const NAMED: usize = 3;
        if self.left_out.is_empty() {
            return None;
        }
        let named = self.left_out.iter().take(NAMED).map(|(face, why)| {
            let name = brep.face_name(*face).map(|name| format!(" \"{}\"", clip(name))).unwrap_or_default();
            format!("face {face}{name}: {why}")
        });
        let named: Vec<String> = named.collect();
        let more = if self.left_out.len() > NAMED { "; …" } else { "" };
        Some(format!(
            "{} of {} faces could not be cut and are left out ({}{more})",
            self.left_out.len(),
            brep.face_count(),
            named.join("; "),
        ))
    }
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

    /// The points at which the border of a surface is cut by [`measured_surface_beside`](Self::measured_surface_beside), where nothing is
    /// beside it. A tessellator need not know them, and then gives none: so does this, unless it is replaced.
    ///
    /// # Errors
    /// As for [`curve`](Self::curve).
    fn border(&self, surface: &Surface, fineness: &Fineness) -> Result<Vec<Point>> {
        let _ = (surface, fineness);
        Ok(Vec::new())
    }

    /// Triangles of a surface that hangs together with others along edges that are the same as sets of points only (with other knots, of
    /// other degree, or one a part of the other): its mesh has the points of theirs that are on its border as vertices, so that where all
    /// are cut so nothing gapes. What it takes to do so is part of the chord, for it and for all that it hangs together with. A tessellator
    /// need not know how: this is [`measured_surface`](Self::measured_surface), unless it is replaced.
    ///
    /// # Errors
    /// As for [`curve`](Self::curve).
    fn measured_surface_beside(
        &self,
        surface: &Surface,
        fineness: &Fineness,
        beside: Beside<'_>,
    ) -> Result<Tessellated> {
        let _ = beside;
        self.measured_surface(surface, fineness)
    }

    /// Triangles of the part of a surface that its loops bound, and how far they are from it at most. A tessellator need not know how,
    /// and then says so: so does this, unless it is replaced.
    ///
    /// # Errors
    /// As for [`curve`](Self::curve); also where loops cross one another or themselves.
    fn measured_trimmed(&self, trimmed: &Trimmed, fineness: &Fineness) -> Result<Tessellated> {
        let _ = (trimmed, fineness);
        Err(Error::Invalid("this tessellator cannot cut trimmed surfaces: use another".to_owned()))
    }

    /// Triangles of all faces of a Brep, joined along its edges. A face that cannot be cut is left out, and said to be. As with
    /// [`measured_trimmed`](Self::measured_trimmed), a tessellator need not know how.
    ///
    /// # Errors
    /// As for [`curve`](Self::curve), where that is so for the whole; [`Error::Invalid`] where no face can be cut.
    fn measured_brep(&self, brep: &Brep, fineness: &Fineness) -> Result<TessellatedBrep> {
        let _ = (brep, fineness);
        Err(Error::Invalid("this tessellator cannot cut breps: use another".to_owned()))
    }

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_slots_and_what_is_left_out_is_named() {
        let mut parts = Brep::block(Point::origin(), Point::new(3.0, 2.0, 1.0)).unwrap().parts();
        let (red, blue) = (Some([1.0, 0.0, 0.0, 1.0]), Some([0.0, 0.0, 1.0, 1.0]));
        (parts.faces[1].color, parts.faces[4].color, parts.faces[5].color) = (red, blue, red);
        parts.faces[4].name = Some("front".into());
        let brep = Brep::new(parts).unwrap();
        let cut = |faces: &[usize], left_out: &[usize]| TessellatedBrep {
            mesh: Mesh::new(vec![Point::origin(); 3], &vec![[0, 1, 2]; faces.len()]).unwrap(),
            faces: faces.to_vec(),
            edges: Vec::new(),
            left_out: left_out.iter().map(|&face| (face, Error::Invalid("why".into()))).collect(),
            tolerance: 0.1,
            error: 0.05,
            furthest: None,
        };
        let all = cut(&[0, 1, 1, 4, 5], &[]);
        assert_eq!(all.colors(&brep), (vec![None, red, blue], vec![0, 1, 1, 2, 1]));
        assert_eq!(all.remark(&brep), None);
        let said = cut(&[0], &[1, 4]).remark(&brep).unwrap();
        assert_eq!(
            said,
            "2 of 6 faces could not be cut and are left out (face 1: why; face 4 \"front\": why)"
        );
        assert!(cut(&[], &[0, 1, 2, 3]).remark(&brep).unwrap().contains("face 2: why; …)"));
        assert_eq!(all.excess(1.0), None);
        let furthest = Some(Apart { edge: 7, face: 4, distance: 0.25 });
        let said = TessellatedBrep { error: 0.3, furthest, ..cut(&[0], &[]) }.excess(10.0).unwrap();
        assert!(
            said.contains("within 3 only, not the 1 asked for: edge 7 is 2.5 off the surface of face 4"),
            "{said}"
        );
    }
}
