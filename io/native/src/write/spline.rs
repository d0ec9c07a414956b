//! Splines: curves, surfaces, trimmed surfaces and where they meet.

use std::io;

use loftsman_kernel::connection::{Connection, Side};
use loftsman_kernel::spline::trimmed::ParameterCurve;
use loftsman_kernel::spline::{Curve, Space, Surface, Trimmed};

use super::layout::Layout;

/// The fields of a curve.
pub(super) fn curve(curve: &Curve, out: &mut Layout<'_>) -> io::Result<()> {
    space(curve.space(), out)?;
    out.key("points")?;
    out.points(curve.points())?;
    if let Some(weights) = curve.weights() {
        out.key("weights")?;
        out.numbers(weights)?;
    }
    Ok(())
}

/// The fields of a surface.
pub(super) fn surface(surface: &Surface, out: &mut Layout<'_>) -> io::Result<()> {
    for (key, side) in [("u", surface.u()), ("v", surface.v())] {
        out.key(key)?;
        out.open_table()?;
        space(side, out)?;
        out.close_table()?;
    }
    let columns = surface.v().len();
    out.key("points")?;
    out.open_list()?;
    for row in surface.points().chunks(columns) {
        out.entry()?;
        out.points(row)?;
    }
    out.close_list()?;
    if let Some(weights) = surface.weights() {
        out.key("weights")?;
        out.open_list()?;
        for row in weights.chunks(columns) {
            out.entry()?;
            out.numbers(row)?;
        }
        out.close_list()?;
    }
    Ok(())
}

fn space(space: &Space, out: &mut Layout<'_>) -> io::Result<()> {
    out.key("degree")?;
    out.count(space.degree() as u64)?;
    out.key("periodic")?;
    out.flag(space.is_periodic())?;
    out.key("knots")?;
    out.numbers(space.knots())
}

/// The fields of a trimmed surface.
pub(super) fn trimmed(trimmed: &Trimmed, out: &mut Layout<'_>) -> io::Result<()> {
    out.key("surface")?;
    out.open_table()?;
    surface(trimmed.surface(), out)?;
    out.close_table()?;
    out.key("regions")?;
    out.open_list()?;
    for region in trimmed.regions() {
        out.entry()?;
        out.open_table()?;
        out.key("outer")?;
        chain(&region.outer, out)?;
        out.key("holes")?;
        chains(&region.holes, out)?;
        out.close_table()?;
    }
    out.close_list()?;
    if !trimmed.curves().is_empty() {
        out.key("curves")?;
        chains(trimmed.curves(), out)?;
    }
    if !trimmed.points().is_empty() {
        out.key("points")?;
        out.rows(trimmed.points().iter().copied())?;
    }
    Ok(())
}

fn chains(chains: &[Vec<ParameterCurve>], out: &mut Layout<'_>) -> io::Result<()> {
    out.open_list()?;
    for curves in chains {
        out.entry()?;
        chain(curves, out)?;
    }
    out.close_list()
}

fn chain(curves: &[ParameterCurve], out: &mut Layout<'_>) -> io::Result<()> {
    out.open_list()?;
    for curve in curves {
        out.entry()?;
        out.open_table()?;
        piece(curve, out)?;
        out.close_table()?;
    }
    out.close_list()
}

/// The fields of a curve in a parameter plane.
pub(super) fn piece(piece: &ParameterCurve, out: &mut Layout<'_>) -> io::Result<()> {
    out.key("curve")?;
    out.open_table()?;
    curve(piece.curve(), out)?;
    out.close_table()?;
    let (from, to) = piece.range();
    out.key("from")?;
    out.number(from)?;
    out.key("to")?;
    out.number(to)
}

/// Where surfaces meet.
pub(super) fn connections(connections: &[Connection], out: &mut Layout<'_>) -> io::Result<()> {
    out.open_list()?;
    for connection in connections {
        out.entry()?;
        out.open_table()?;
        for (key, side) in [("first", &connection.first), ("second", &connection.second)] {
            out.key(key)?;
            out.open_table()?;
            let Side { object, curve } = side;
            out.key("object")?;
            out.text(object)?;
            piece(curve, out)?;
            out.close_table()?;
        }
        out.close_table()?;
    }
    out.close_list()
}
