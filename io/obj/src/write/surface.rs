//! Surfaces, trimmed surfaces and Breps: exactly where OBJ has them, and as meshes beside that.

use std::collections::HashSet;
use std::io::Write;

use loftsman_kernel::brep::Brep;
use loftsman_kernel::mesh::{FaceGroup, Mesh};
use loftsman_kernel::plugin::{
    Beside, Fate, Fineness, FormatError, Tessellated, TessellatedBrep, Tessellator, Written,
};
use loftsman_kernel::scene::{Geometry, Object};
use loftsman_kernel::text::a;

use super::{Surfaces, Writer};
use crate::fingerprint;
use loftsman_kernel::text::counted;

/// How finely an object is cut, and what is beside it.
#[derive(Clone, Copy)]
pub(super) struct Fine<'a> {
    pub(super) fineness: Fineness,
    pub(super) beside: Option<Beside<'a>>,
}

/// A surface of whatever kind as a mesh.
struct Cut {
    mesh: Mesh,
    tolerance: f64,
    error: f64,
    /// What faces have instead of the look of their object, slot by slot from 1 on.
    colors: Vec<[f64; 4]>,
    /// What is missing.
    remark: Option<String>,
}

impl From<Tessellated> for Cut {
    fn from(Tessellated { mesh, tolerance, error }: Tessellated) -> Self {
        Self { mesh, tolerance, error, colors: Vec::new(), remark: None }
    }
}

impl Cut {
    /// Faces are groups, so that each can be told apart in the mesh. `scale`: a length of the scene to one here.
    fn of_brep(cut: TessellatedBrep, brep: &Brep, scale: f64) -> Self {
        let (colors, slots) = cut.colors(brep);
        let remarks: Vec<String> = cut.remark(brep).into_iter().chain(cut.excess(scale)).collect();
        let remark = (!remarks.is_empty()).then(|| remarks.join("; "));
        let TessellatedBrep { mut mesh, faces, tolerance, error, .. } = cut;
        // A colour that is none cannot be written, and the object's stands for it.
        let is_color = |slot: u32| colors[slot as usize].is_some_and(|c| c.iter().all(|x| x.is_finite()));
        if slots.iter().any(|&slot| slot != 0) {
            mesh.materials = slots.iter().map(|&slot| if is_color(slot) { slot } else { 0 }).collect();
        }
        let mut first = 0;
        for run in faces.chunk_by(|one, next| one == next) {
            let end = first + run.len() as u32;
            let name = match brep.face_name(run[0]) {
                Some(name) if !name.is_empty() => {
                    format!("face_{}_{}", run[0], name.replace(char::is_whitespace, "_"))
                }
                _ => format!("face_{}", run[0]),
            };
            mesh.groups.push(FaceGroup { name, faces: (first..end).collect() });
            first = end;
        }
        let colors = colors.into_iter().skip(1).map(|color| color.unwrap_or_default()).collect();
        Self { mesh, tolerance, error, colors, remark }
    }
}

fn cut(
    geometry: &Geometry,
    Fine { fineness, beside }: Fine<'_>,
    by: &dyn Tessellator,
    scale: f64,
) -> loftsman_kernel::Result<Option<Cut>> {
    let fineness = &fineness;
    Ok(match geometry {
        Geometry::Surface(surface) => Some(match beside {
            Some(beside) => by.measured_surface_beside(surface, fineness, beside)?.into(),
            None => by.measured_surface(surface, fineness)?.into(),
        }),
        Geometry::Trimmed(trimmed) => Some(by.measured_trimmed(trimmed, fineness)?.into()),
        Geometry::Brep(brep) => Some(Cut::of_brep(by.measured_brep(brep, fineness)?, brep, scale)),
        _ => None,
    })
}

impl<W: Write> Writer<'_, W> {
    /// A surface, trimmed or not, exactly, beside its tessellation, or one of both; a Brep as its tessellation.
    pub(super) fn tessellated(
        &mut self,
        object: &Object,
        geometry: &Geometry,
        fine: Fine<'_>,
        written: &mut Written,
    ) -> Result<(), FormatError> {
        let is_brep = matches!(geometry, Geometry::Brep(_));
        let exact = self.surfaces != Surfaces::Mesh && !is_brep;
        let mesh = match self.tessellator {
            _ if self.surfaces == Surfaces::Exact && is_brep => {
                Err("OBJ has no brep, and only exact surfaces were asked for".to_owned())
            }
            _ if self.surfaces == Surfaces::Exact => Err("only exact surfaces were asked for".to_owned()),
            None => Err(format!("{} needs a tessellator, and none is registered", a(&geometry.noun()))),
            Some(tessellator) => match cut(geometry, fine, tessellator, 1.0 / self.scale) {
                Ok(Some(cut)) => Ok(cut),
                Ok(None) => Err(format!("OBJ has no {}", geometry.kind())),
                Err(error) => Err(format!("it could not be tessellated: {error}")),
            },
        };
        let mut mark = None;
        match mesh {
            Ok(Cut { mesh, tolerance, error, colors, remark }) => {
                let name = self.name(object.name())?;
                if exact {
                    // Who reads both reads one object, which has the name of the mesh.
                    let fingerprint = fingerprint::mesh(&mesh);
                    self.line(&format!("# Loftsman mesh {fingerprint:016x}"))?;
                    mark = Some((name, fingerprint));
                }
                let mut looks = self.looks(&object.materials);
                if !colors.is_empty() {
                    looks.truncate(1);
                    // Only what some face has is in the library.
                    let used: HashSet<u32> = mesh.materials.iter().copied().collect();
                    if looks.is_empty() {
                        let own = self.paint.filter(|_| used.is_empty() || used.contains(&0));
                        looks.push(own.map(|color| self.library.paint(color)));
                    }
                    for (slot, color) in (1..).zip(colors) {
                        looks.push(used.contains(&slot).then(|| self.library.paint(color)));
                    }
                }
                self.mesh(&mesh, &looks)?;
                written.form = counted(mesh.face_count(), "triangle[|s]");
                written.cut(self.chord.length(tolerance / self.scale), Some(error / self.scale));
                if !exact {
                    written.fate = Fate::Approximated;
                    let what = if is_brep { "brep" } else { "surface" };
                    written.reason = Some(format!("the {what} was tessellated"));
                }
                remark.iter().for_each(|remark| written.change(remark));
            }
            Err(problem) if exact => {
                let what = "programs that read no surf, as Blender and MeshLab, show nothing";
                written.reason = Some(format!("{problem}: {what}"));
            }
            Err(problem) => written.leave_out(problem),
        }
        if exact {
            self.beside(object, geometry, mark, written)?;
        }
        Ok(())
    }

    /// The surface itself, beside the mesh of a name and a mark that shows it.
    fn beside(
        &mut self,
        object: &Object,
        geometry: &Geometry,
        mark: Option<(String, u64)>,
        written: &mut Written,
    ) -> Result<(), FormatError> {
        let is_shown = mark.is_some();
        // An object of its own: Blender makes a curve of what follows a cstype.
        self.element_material(object)?;
        self.name(mark.as_ref().map_or(object.name(), |(name, _)| name))?;
        if let Some((_, mark)) = mark {
            let own = match geometry {
                Geometry::Surface(surface) => fingerprint::surface(surface),
                Geometry::Trimmed(trimmed) => fingerprint::trimmed(trimmed),
                _ => return Ok(()),
            };
            self.line(&format!("# Loftsman surface {own:016x} of mesh {mark:016x}"))?;
        }
        let form = match geometry {
            Geometry::Surface(surface) => {
                self.surface(object.name(), surface)?;
                "NURBS surface (surf)".to_owned()
            }
            Geometry::Trimmed(trimmed) => {
                self.trimmed(object.name(), trimmed)?;
                format!("trimmed surface of {} (surf)", counted(trimmed.loops().count(), "loop[|s]"))
            }
            _ => return Ok(()),
        };
        let beside = if is_shown { format!(" beside {}", written.form) } else { String::new() };
        written.form = format!("{form}{beside}");
        Ok(())
    }
}
