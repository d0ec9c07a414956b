//! Shapes of plug-ins: the splines that they are, beside segments or triangles.

use std::io::Write;

use loftsman_kernel::plugin::{CustomShape, Drawn, Fate, Fineness, FormatError, Splines, Written};
use loftsman_kernel::scene::Object;

use super::{Surfaces, Writer};
use loftsman_kernel::text::counted;

/// Whether a shape is drawn as triangles.
pub(super) fn is_surface(custom: &CustomShape) -> bool {
    custom.shape().is_ok_and(|shape| shape.domain().len() == 2)
}

impl<W: Write> Writer<'_, W> {
    /// A plug-in's shape: its exact splines, where it is some, and what its kind draws of it, as far as these are
    /// asked for. OBJ has no word for its kind, so that it comes back as what it became.
    pub(super) fn custom(
        &mut self,
        object: &Object,
        custom: &CustomShape,
        mirrored: bool,
        fineness: &Fineness,
        written: &mut Written,
    ) -> Result<(), FormatError> {
        if let Err(unknown) = custom.shape() {
            written.leave_out(unknown.to_string());
            return Ok(());
        }
        let kind = custom.kind();
        let splines = custom.splines().filter(|_| self.surfaces != Surfaces::Mesh || !is_surface(custom));
        let (mut forms, mut reasons) = (Vec::new(), Vec::new());
        // Curves are read by everybody; surfaces by few.
        let drawn = !matches!(splines, Some(Splines::Curves(_)))
            && (self.surfaces != Surfaces::Exact || !is_surface(custom));
        if drawn {
            match custom.tessellate(fineness) {
                Ok(found) => {
                    reasons.extend(found.remark(1.0 / self.scale));
                    let error = reasons.is_empty().then_some(found.error / self.scale);
                    written.cut(self.chord.length(found.tolerance / self.scale), error);
                    self.name(object.name())?;
                    forms.push(self.drawn(object, found.drawn, mirrored)?);
                }
                Err(problem) => reasons.push(format!("it could not be tessellated: {problem}")),
            }
        }
        if let Some(splines) = &splines {
            self.element_material(object)?;
            self.name(object.name())?;
            match splines {
                Splines::Curves(curves) => {
                    curves.iter().try_for_each(|curve| self.curve(curve))?;
                    forms.push(counted(curves.len(), "NURBS curve[|s]"));
                }
                Splines::Surfaces(surfaces) => {
                    for surface in surfaces {
                        if mirrored {
                            self.surface(object.name(), &super::exchange::surface(surface)?)?;
                        } else {
                            self.surface(object.name(), surface)?;
                        }
                    }
                    self.notes.exchanged += if mirrored { surfaces.len() } else { 0 };
                    forms.push(counted(surfaces.len(), "NURBS surface[|s] (surf)"));
                }
            }
        }
        if forms.is_empty() {
            if reasons.is_empty() {
                reasons.push(format!("a {kind} is no spline, and only exact surfaces were asked for"));
            }
            written.leave_out(reasons.join("; "));
            return Ok(());
        }
        forms.reverse();
        written.form = forms.join(" beside ");
        written.fate = Fate::Approximated;
        reasons.insert(0, format!("OBJ has no {kind}: it is read as what it became"));
        written.reason = Some(reasons.join("; "));
        Ok(())
    }

    fn drawn(&mut self, object: &Object, drawn: Drawn, mirrored: bool) -> Result<String, FormatError> {
        match drawn {
            Drawn::Line(line) => {
                self.element_material(object)?;
                Ok(format!("line of {}", counted(self.polyline(&line)?, "segment[|s]")))
            }
            Drawn::Mesh(mut mesh) => {
                if mirrored {
                    mesh.turn_inside_out();
                }
                let looks = self.looks(&object.materials);
                self.mesh(&mesh, &looks)?;
                Ok(counted(mesh.face_count(), "triangle[|s]"))
            }
        }
    }
}
