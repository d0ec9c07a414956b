//! What an object is, as items of a representation.

use std::borrow::Cow;

use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::plugin::Splines;
use loftsman_kernel::scene::Geometry;

use super::paint::Paint;
use super::print::{Printer, references};
use super::style::Carrier;
use crate::part21::encode;

/// The items of one object.
pub(crate) struct Items {
    pub(crate) items: Vec<u64>,
    /// What a colour of all is given to.
    pub(crate) colored: Vec<u64>,
    /// Faces of colours of their own.
    pub(crate) faces: Vec<(u64, [f64; 4])>,
    pub(crate) carrier: Carrier,
    /// Whether what a colour of all is given to has one.
    pub(crate) has_color: bool,
    /// The type of the representation.
    pub(crate) representation: &'static str,
    /// How it went out, and what comes back changed.
    pub(crate) form: &'static str,
    pub(crate) changes: Vec<&'static str>,
    /// How exact it says it is.
    pub(crate) uncertainty: f64,
}

/// What was written, or why nothing.
pub(crate) enum Put {
    Items(Items),
    /// Nothing of its own, as a group.
    Nothing,
    LeftOut(Cow<'static, str>),
}

const WIRES: &str = "GEOMETRICALLY_BOUNDED_WIREFRAME_SHAPE_REPRESENTATION";
const SURFACES: &str = "GEOMETRICALLY_BOUNDED_SURFACE_SHAPE_REPRESENTATION";

impl Items {
    fn one(
        p: &mut Printer,
        kind: &str,
        name: &str,
        elements: &[u64],
        carrier: Carrier,
        form: &'static str,
    ) -> Self {
        let set = p.put(&format!("{kind}({},{})", encode(name), references(elements)));
        let representation = if kind == "GEOMETRIC_SET" { SURFACES } else { WIRES };
        Self {
            items: vec![set],
            colored: elements.to_vec(),
            faces: Vec::new(),
            carrier,
            has_color: false,
            representation,
            form,
            changes: Vec::new(),
            uncertainty: 0.0,
        }
    }
}

/// A mesh without faces: its lines, or its points where it has none.
fn bare(p: &mut Printer, mesh: &Mesh, name: &str) -> Items {
    let at = |index: u32| mesh.points()[index as usize];
    let lines: Vec<u64> = mesh
        .lines()
        .map(|line| {
            let points: Vec<_> = line.iter().map(|&index| at(index)).collect();
            let list = p.points(&points);
            p.put(&format!("POLYLINE('',{list})"))
        })
        .collect();
    if !lines.is_empty() {
        return Items::one(p, "GEOMETRIC_CURVE_SET", name, &lines, Carrier::Curve, "polylines");
    }
    let points: Vec<u64> = mesh.points().iter().map(|point| p.point(point)).collect();
    let mut items = Items::one(p, "GEOMETRIC_SET", name, &points, Carrier::Point, "points");
    items.colored.clone_from(&items.items);
    items
}

/// The splines that a plug-in's shape is.
fn of_splines(p: &mut Printer, splines: &Splines, name: &str) -> loftsman_kernel::Result<Items> {
    let (mut numbers, mut changes) = (Vec::new(), vec!["the splines that it is exactly"]);
    let mut changed = |change: Option<&'static str>| match change {
        Some(change) if !changes.contains(&change) => changes.push(change),
        _ => {}
    };
    let mut items = match splines {
        Splines::Curves(curves) => {
            for curve in curves {
                numbers.push(p.curve(curve.clamped()?.as_ref()));
                changed(curve.change_when_clamped());
            }
            Items::one(p, "GEOMETRIC_CURVE_SET", name, &numbers, Carrier::Curve, "B-spline curves")
        }
        Splines::Surfaces(surfaces) => {
            for surface in surfaces {
                numbers.push(p.surface(surface.clamped()?.as_ref()));
                changed(surface.change_when_clamped());
            }
            Items::one(p, "GEOMETRIC_SET", name, &numbers, Carrier::Surface, "B-spline surfaces")
        }
    };
    items.changes = changes;
    Ok(items)
}

/// Writes a geometry, in its own coordinates. Faces of a mesh have the colours of the materials that they name, where these are several.
pub(crate) fn put(
    p: &mut Printer,
    geometry: &Geometry,
    name: &str,
    paint: &Paint,
) -> loftsman_kernel::Result<Put> {
    let written = match geometry {
        Geometry::Group | Geometry::Instance(_) => return Ok(Put::Nothing),
        Geometry::Curve(curve) => {
            let formed = p.formed(curve);
            let (number, form) = match formed {
                Some(formed) => formed,
                None => (p.curve(curve.clamped()?.as_ref()), "B-spline curve"),
            };
            let mut items = Items::one(p, "GEOMETRIC_CURVE_SET", name, &[number], Carrier::Curve, form);
            items.changes.extend(curve.change_when_clamped());
            items
        }
        Geometry::Surface(surface) => {
            let formed = p.formed_surface(surface);
            let (number, form) = match formed {
                Some(formed) => formed,
                None => (p.surface(surface.clamped()?.as_ref()), "B-spline surface"),
            };
            let mut items = Items::one(p, "GEOMETRIC_SET", name, &[number], Carrier::Surface, form);
            items.changes.extend(surface.change_when_clamped());
            items
        }
        Geometry::Polyline(line) => {
            let count = line.points.len();
            if count < 2 {
                return Ok(Put::LeftOut("a polyline of fewer than two points".into()));
            }
            let mut points = line.points.clone();
            if line.closed {
                points.push(points[0]);
            }
            let list = p.points(&points);
            let number = p.put(&format!("POLYLINE('',{list})"));
            let mut items = Items::one(p, "GEOMETRIC_CURVE_SET", name, &[number], Carrier::Curve, "polyline");
            let there_and_back = line.closed && count < 3;
            let closes = !line.closed && count > 3 && points.first() == points.last();
            items.changes.extend(there_and_back.then_some("there and back, as it closes on two points"));
            items.changes.extend(closes.then_some("closed, as its first point is its last"));
            items
        }
        Geometry::Cloud(cloud) => {
            if cloud.points.is_empty() {
                return Ok(Put::LeftOut("a cloud without points".into()));
            }
            let points: Vec<u64> = cloud.points.iter().map(|point| p.point(point)).collect();
            let mut items = Items::one(p, "GEOMETRIC_SET", name, &points, Carrier::Point, "points");
            // One colour for all of them.
            items.colored.clone_from(&items.items);
            items
        }
        Geometry::Trimmed(trimmed) => {
            let written = match p.trimmed(trimmed, name)? {
                Ok(written) => written,
                Err(why) => return Ok(Put::LeftOut(why.into())),
            };
            let mut items = Items::one(
                p,
                "GEOMETRIC_SET",
                name,
                &written.items,
                Carrier::Surface,
                "surface that curves bound",
            );
            items.changes = written.changes;
            items
        }
        Geometry::Mesh(mesh) => {
            if mesh.points().is_empty() {
                return Ok(Put::LeftOut("a mesh without points".into()));
            }
            if mesh.face_count() == 0 {
                return Ok(Put::Items(bare(p, mesh, name)));
            }
            let groups = paint.groups(mesh);
            let (shell, numbers, fan) = p.mesh(mesh, &encode(name), &groups);
            let changes = fan.then_some("faces of very many corners are cut as fans");
            let faces = numbers.into_iter().zip(&groups);
            Items {
                items: vec![shell],
                colored: vec![shell],
                faces: faces.filter_map(|(number, group)| Some((number, group.color?))).collect(),
                carrier: Carrier::Surface,
                has_color: false,
                representation: "TESSELLATED_SHAPE_REPRESENTATION",
                form: "triangles",
                changes: changes.into_iter().collect(),
                uncertainty: 0.0,
            }
        }
        Geometry::Brep(brep) => {
            if brep.face_count() == 0 {
                return Ok(Put::LeftOut("a brep without faces".into()));
            }
            let written = p.brep(brep, name)?;
            let faces = written.faces.iter().enumerate();
            let faces = faces.filter_map(|(face, &number)| Some((number, brep.face_color(face)?))).collect();
            Items {
                colored: written.items.clone(),
                items: written.items,
                faces,
                carrier: Carrier::Surface,
                has_color: false,
                representation: if written.solid {
                    "ADVANCED_BREP_SHAPE_REPRESENTATION"
                } else {
                    "MANIFOLD_SURFACE_SHAPE_REPRESENTATION"
                },
                form: if written.solid { "solid" } else { "shell" },
                changes: written.changes,
                uncertainty: written.uncertainty,
            }
        }
        Geometry::Custom(custom) => match custom.splines() {
            Some(splines) => of_splines(p, &splines, name)?,
            None => return Ok(Put::LeftOut(custom.without_splines("STEP").into())),
        },
        _ => return Ok(Put::LeftOut("STEP files that are written here have no such thing".into())),
    };
    Ok(Put::Items(written))
}
