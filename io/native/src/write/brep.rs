//! Breps.

use std::io;

use loftsman_kernel::brep::{Brep, CurveForm, Frame, SurfaceForm, Use};
use loftsman_kernel::spline::{CurvePiece, SurfacePiece};

use super::layout::Layout;
use super::spline;

/// The fields of a Brep.
pub(super) fn brep(brep: &Brep, out: &mut Layout<'_>) -> io::Result<()> {
    let parts = brep.parts();
    list("vertices", &parts.vertices, out, |vertex, out| {
        out.key("at")?;
        out.row(vertex.point.coords.as_slice())?;
        tolerance(vertex.tolerance, out)
    })?;
    list("edges", &parts.edges, out, |edge, out| {
        table("curve", out, |out| spline::curve(&edge.curve, out))?;
        out.key("from")?;
        out.number(edge.range.0)?;
        out.key("to")?;
        out.number(edge.range.1)?;
        numbers("vertices", &edge.ends, out)?;
        tolerance(edge.tolerance, out)?;
        curve_form(&edge.form, out)
    })?;
    list("faces", &parts.faces, out, |face, out| {
        name(face.name.as_deref(), out)?;
        if let Some(color) = &face.color {
            out.key("color")?;
            out.row(color)?;
        }
        table("surface", out, |out| spline::surface(&face.surface, out))?;
        surface_form(&face.form, out)?;
        if face.reversed {
            out.key("reversed")?;
            out.flag(true)?;
        }
        out.key("loops")?;
        out.open_list()?;
        for chain in &face.loops {
            out.entry()?;
            uses(chain, out)?;
        }
        out.close_list()?;
        if !face.points.is_empty() {
            numbers("points", &face.points, out)?;
        }
        Ok(())
    })?;
    out.key("shells")?;
    out.open_list()?;
    for shell in &parts.shells {
        out.entry()?;
        out.indices(shell.faces.iter().map(|&face| u32::try_from(face).ok()))?;
    }
    out.close_list()?;
    list("solids", &parts.solids, out, |solid, out| {
        name(solid.name.as_deref(), out)?;
        out.key("outer")?;
        out.count(solid.outer as u64)?;
        if !solid.voids.is_empty() {
            numbers("voids", &solid.voids, out)?;
        }
        Ok(())
    })
}

fn uses(chain: &[Use], out: &mut Layout<'_>) -> io::Result<()> {
    out.open_list()?;
    for one in chain {
        out.entry()?;
        out.open_table()?;
        out.key("edge")?;
        out.count(one.edge as u64)?;
        if one.reversed {
            out.key("reversed")?;
            out.flag(true)?;
        }
        if let Some(parameters) = &one.parameters {
            table("parameters", out, |out| spline::piece(parameters, out))?;
        }
        out.close_table()?;
    }
    out.close_list()
}

/// A list of tables.
fn list<T>(
    key: &str,
    items: &[T],
    out: &mut Layout<'_>,
    fields: impl Fn(&T, &mut Layout<'_>) -> io::Result<()>,
) -> io::Result<()> {
    out.key(key)?;
    out.open_list()?;
    for item in items {
        out.entry()?;
        out.open_table()?;
        fields(item, out)?;
        out.close_table()?;
    }
    out.close_list()
}

fn table(
    key: &str,
    out: &mut Layout<'_>,
    fields: impl FnOnce(&mut Layout<'_>) -> io::Result<()>,
) -> io::Result<()> {
    out.key(key)?;
    out.open_table()?;
    fields(out)?;
    out.close_table()
}

fn numbers(key: &str, numbers: &[usize], out: &mut Layout<'_>) -> io::Result<()> {
    out.key(key)?;
    out.indices(numbers.iter().map(|&number| u32::try_from(number).ok()))
}

fn name(name: Option<&str>, out: &mut Layout<'_>) -> io::Result<()> {
    let Some(name) = name else { return Ok(()) };
    out.key("name")?;
    out.text(name)
}

fn tolerance(tolerance: f64, out: &mut Layout<'_>) -> io::Result<()> {
    if tolerance == 0.0 {
        return Ok(());
    }
    out.key("tolerance")?;
    out.number(tolerance)
}

fn curve_form(form: &CurveForm, out: &mut Layout<'_>) -> io::Result<()> {
    curve_form_as("form", form, out)
}

/// A line or conic and from where to where, as a field of a curve.
pub(super) fn curve_piece(piece: &CurvePiece, out: &mut Layout<'_>) -> io::Result<()> {
    curve_table("form", &piece.form, out, |out| {
        if piece.form != CurveForm::Line {
            out.key("from")?;
            out.number(piece.range[0])?;
            out.key("to")?;
            out.number(piece.range[1])?;
        }
        Ok(())
    })
}

/// Under a key; nothing of a spline.
fn curve_form_as(key: &str, form: &CurveForm, out: &mut Layout<'_>) -> io::Result<()> {
    curve_table(key, form, out, |_| Ok(()))
}

/// The same, with what more there is to say.
fn curve_table(
    key: &str,
    form: &CurveForm,
    out: &mut Layout<'_>,
    more: impl FnOnce(&mut Layout<'_>) -> io::Result<()>,
) -> io::Result<()> {
    let (frame, radii, size) = match form {
        CurveForm::Spline => return Ok(()),
        CurveForm::Line => (None, None, None),
        CurveForm::Circle { frame, radius } => (Some(frame), None, Some(("radius", *radius))),
        CurveForm::Parabola { frame, focal } => (Some(frame), None, Some(("focal", *focal))),
        CurveForm::Ellipse { frame, radii } | CurveForm::Hyperbola { frame, radii } => {
            (Some(frame), Some(radii), None)
        }
    };
    table(key, out, |out| {
        place(form.name(), frame, out)?;
        if let Some(radii) = radii {
            out.key("radii")?;
            out.row(radii)?;
        }
        if let Some((name, size)) = size {
            out.key(name)?;
            out.number(size)?;
        }
        more(out)
    })
}

fn surface_form(form: &SurfaceForm, out: &mut Layout<'_>) -> io::Result<()> {
    surface_table(form, out, |_| Ok(()))
}

/// A rectangle of an elementary or swept surface, as a field of a surface.
pub(super) fn surface_piece(piece: &SurfacePiece, out: &mut Layout<'_>) -> io::Result<()> {
    surface_table(&piece.form, out, |out| {
        for (key, range) in ["u", "v"].into_iter().zip(&piece.ranges) {
            out.key(key)?;
            out.row(range)?;
        }
        Ok(())
    })
}

/// What a surface is, with what more there is to say; nothing of a spline.
fn surface_table(
    form: &SurfaceForm,
    out: &mut Layout<'_>,
    more: impl FnOnce(&mut Layout<'_>) -> io::Result<()>,
) -> io::Result<()> {
    let (frame, sizes): (&Frame, &[(&str, f64)]) = match form {
        SurfaceForm::Spline => return Ok(()),
        SurfaceForm::Plane { frame } => (frame, &[]),
        SurfaceForm::Cylinder { frame, radius } | SurfaceForm::Sphere { frame, radius } => {
            (frame, &[("radius", *radius)])
        }
        SurfaceForm::Cone { frame, radius, angle } => (frame, &[("radius", *radius), ("angle", *angle)]),
        SurfaceForm::Torus { frame, major, minor } => (frame, &[("major", *major), ("minor", *minor)]),
        SurfaceForm::Extrusion { along, profile } => {
            return table("form", out, |out| {
                place(form.name(), None, out)?;
                out.key("along")?;
                out.row(along.as_slice())?;
                curve_form_as("profile", profile, out)?;
                more(out)
            });
        }
        SurfaceForm::Revolution { frame, profile } => {
            return table("form", out, |out| {
                place(form.name(), Some(frame), out)?;
                curve_form_as("profile", profile, out)?;
                more(out)
            });
        }
    };
    table("form", out, |out| {
        place(form.name(), Some(frame), out)?;
        for (name, size) in sizes {
            out.key(name)?;
            out.number(*size)?;
        }
        more(out)
    })
}

fn place(kind: &str, frame: Option<&Frame>, out: &mut Layout<'_>) -> io::Result<()> {
    out.key("kind")?;
    out.text(kind)?;
    let Some(frame) = frame else { return Ok(()) };
    for (key, numbers) in [("origin", frame.origin.coords), ("x", frame.x), ("z", frame.z)] {
        out.key(key)?;
        out.row(numbers.as_slice())?;
    }
    Ok(())
}
