//! What an object is itself, in entities.

use std::borrow::Cow;

use loftsman_kernel::plugin::{FormatError, FormatErrorKind, Splines};
use loftsman_kernel::scene::{Geometry, Object};
use nalgebra::Matrix4;

use super::print::{Look, Record};
use super::{Writer, tolerances};

/// How an object went out of itself: the entities, as what, and what comes back changed.
pub(super) struct Out {
    pub(super) items: Vec<u32>,
    pub(super) form: &'static str,
    pub(super) changes: Vec<&'static str>,
}

impl Writer<'_, '_> {
    /// What an object is itself, or why nothing of it goes out.
    pub(super) fn own(
        &mut self,
        object: &Object,
        baked: Option<&Matrix4<f64>>,
        named: bool,
        owned: bool,
    ) -> Result<Result<Out, Cow<'static, str>>, FormatError> {
        let moved = baked.map(|map| object.geometry().transformed(map)).transpose()?;
        let geometry = moved.as_ref().unwrap_or(object.geometry());
        check_finite(geometry)?;
        if matches!(geometry, Geometry::Group) {
            return Ok(Ok(Out { items: Vec::new(), form: "group", changes: Vec::new() }));
        }
        let color = self.scene.color_of(object);
        let look = Look { owned, ..self.styles.look(&mut self.printer, object, color) };
        let mut changes = Vec::new();
        // The first of a group that has no name is what the others hang under: several entities all have one.
        let splines = match geometry {
            Geometry::Custom(custom) => custom.splines(),
            _ => None,
        };
        let single = match geometry {
            Geometry::Brep(brep) => items_of(brep) == 1,
            Geometry::Trimmed(trimmed) => trimmed.regions().len() < 2,
            Geometry::Cloud(_) => false,
            Geometry::Custom(_) => match &splines {
                Some(Splines::Curves(curves)) => curves.len() < 2,
                Some(Splines::Surfaces(surfaces)) => surfaces.len() < 2,
                None => true,
            },
            _ => true,
        };
        let is_cloud = matches!(geometry, Geometry::Cloud(_));
        let properties = self.properties(((named || !single) && !is_cloud).then(|| object.name()));
        let p = &mut self.printer;
        let (items, form) = match geometry {
            Geometry::Curve(curve) => {
                changes.extend(curve.change_when_clamped());
                match p.formed(curve, look, &properties) {
                    Some((number, form)) => (vec![number], form),
                    None => (vec![p.curve(curve.clamped()?.as_ref(), look, &properties)], "B-spline curve"),
                }
            }
            Geometry::Surface(surface) => {
                changes.extend(surface.change_when_clamped());
                match p.formed_surface(surface, look, &properties) {
                    Some((number, form)) => (vec![number], form),
                    None => {
                        (vec![p.surface(surface.clamped()?.as_ref(), look, &properties)], "B-spline surface")
                    }
                }
            }
            Geometry::Trimmed(trimmed) => match p.trimmed(trimmed, look, &properties)? {
                Ok(written) => {
                    changes.extend(written.changes);
                    (written.items, "trimmed surface")
                }
                Err(why) => return Ok(Err(why.into())),
            },
            Geometry::Polyline(line) => {
                if line.points.is_empty() {
                    return Ok(Err("a polyline without points".into()));
                }
                let mut points = line.points.clone();
                let closes = !line.closed && points.len() > 3 && points.first() == points.last();
                changes.extend(closes.then_some("closed, as its first point is its last"));
                if line.closed {
                    points.push(points[0]);
                    changes
                        .extend((points.len() < 4).then_some("there and back, as it closes on two points"));
                }
                let record =
                    Record::new(106).whole(2).count(points.len()).reals(points.iter().flat_map(|p| p.iter()));
                (vec![p.put(record.properties(&properties), look.form(12))], "polyline")
            }
            Geometry::Cloud(cloud) => {
                if cloud.points.is_empty() {
                    return Ok(Err("a cloud without points".into()));
                }
                let part = Look { owned: true, ..look };
                let points: Vec<u32> = cloud.points.iter().map(|point| p.point(point, part, &[])).collect();
                let properties = self.properties(named.then(|| object.name()));
                let record = Record::new(402).count(points.len()).entities(&points).properties(&properties);
                (vec![self.printer.put(record, look.form(7))], "points")
            }
            Geometry::Brep(brep) => {
                if brep.face_count() == 0 {
                    return Ok(Err("a brep without faces".into()));
                }
                let (low, _) = tolerances(geometry);
                if low < self.tolerance {
                    changes.push("its tolerances are the largest of the file");
                }
                let written = p.brep(brep, &mut self.styles, look, &properties)?;
                self.tolerance = self.tolerance.max(written.off);
                changes.extend(written.changes);
                (written.items, if written.solid { "solid" } else { "shell" })
            }
            Geometry::Custom(custom) => {
                let Some(splines) = splines else { return Ok(Err(custom.without_splines("IGES").into())) };
                let (items, form, changed) = p.splines(&splines, look, &properties)?;
                changes.extend(changed);
                (items, form)
            }
            _ => return Ok(Err("IGES files have no such thing".into())),
        };
        Ok(Ok(Out { items, form, changes }))
    }
}

/// Refuses a geometry whose numbers cannot be written, with the first of these.
fn check_finite(geometry: &Geometry) -> Result<(), FormatError> {
    let points = geometry.points();
    match points.iter().enumerate().find(|(_, p)| !p.iter().all(|c| c.is_finite())) {
        None => Ok(()),
        Some((k, p)) => {
            let problem =
                format!("point {k} is at ({}, {}, {}): every coordinate must be finite", p.x, p.y, p.z);
            Err(FormatError::whole(problem).as_kind(FormatErrorKind::Unsupported))
        }
    }
}

/// How many entities a Brep is.
fn items_of(brep: &loftsman_kernel::brep::Brep) -> usize {
    let mut in_shell = vec![false; brep.face_count()];
    brep.shells().iter().flat_map(|shell| &shell.faces).for_each(|&face| in_shell[face] = true);
    let voids: usize = brep.solids().iter().map(|solid| solid.voids.len()).sum();
    brep.shells().len() - voids + usize::from(in_shell.contains(&false))
}
