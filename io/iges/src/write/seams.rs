//! Faces that meet themselves: their edges in the parameters of their surfaces, as the format counts these.
//!
//! Which side of a seam the edges beside it start from is for readers to guess where nothing says it: OpenCASCADE read a third of such balls with a bite as the bite, or as nothing.

use std::borrow::Cow;

use loftsman_kernel::Result;
use loftsman_kernel::brep::drawn::{Drawings, Manner, Sheet};
use loftsman_kernel::brep::{Brep, SurfaceForm, UsePlace};
use loftsman_kernel::spline::{Curve, Surface};

use super::shape::elementary;

/// Conics are written as splines, and each use has a parameter curve of its own.
const MANNER: Manner = Manner { conics: false, backs: false };

/// Edges in the parameters of faces.
pub(super) struct Seams(Drawings);

impl Seams {
    /// Those of a Brep: where a face meets itself along a seam of a sphere, a torus or a spline.
    ///
    /// Cylinders and cones have none: their second parameter is a length, which OpenCASCADE takes for millimetres whatever the file's unit.
    pub(super) fn of(brep: &Brep) -> Result<Self> {
        let mut drawings = Drawings::default();
        for number in 0..brep.face_count() {
            if brep.loops(number).is_empty() {
                continue;
            }
            let (form, Some(surface)) = (brep.surface_form(number), brep.surface(number)) else { continue };
            match elementary(&surface, &form)? {
                Some((_, same)) => {
                    if matches!(form, SurfaceForm::Sphere { .. } | SurfaceForm::Torus { .. }) {
                        drawings.add(brep, number, &Sheet { same, elementary: true, spline: None }, MANNER);
                    }
                }
                None => {
                    let plain: Cow<'_, Surface> = surface.clamped()?;
                    let sheet = Sheet { same: true, elementary: false, spline: Some(&plain) };
                    drawings.add(brep, number, &sheet, MANNER);
                }
            }
        }
        Ok(Self(drawings))
    }

    /// Whether a face should have curves in parameters and has none, as they were not found.
    pub(super) fn unsaid(&self) -> bool {
        self.0.unsaid
    }

    /// By how much curves are off their edges, where the tolerances of these say less.
    pub(super) fn off(&self) -> f64 {
        self.0.off
    }

    /// A use in the parameters of the file, the way the loop runs there: along its edge, or against it.
    pub(super) fn curve(&self, place: UsePlace, form: &SurfaceForm, with: bool) -> Result<Option<Curve>> {
        let Some(drawn) = self.0.curves.get(&place) else { return Ok(None) };
        let own = if with { drawn.clone() } else { drawn.reverse()? };
        let (space, mut points, weights) = own.into_parts();
        for p in &mut points {
            // Angles are in degrees, those of a torus about the tube first, and then about the axis, the other way round.
            (p.x, p.y) = match form {
                SurfaceForm::Sphere { .. } => (p.x.to_degrees(), p.y.to_degrees()),
                SurfaceForm::Torus { .. } => (p.y.to_degrees(), 360.0 - p.x.to_degrees()),
                _ => (p.x, p.y),
            };
        }
        Curve::build(space, points, weights).map(Some)
    }
}
