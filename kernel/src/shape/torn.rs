//! Where a shape's pieces need not even meet.

use super::{Cell, Derivative, Location, Shape, Side, Sides, Stencil, cells_of};
use crate::error::Result;
use crate::space::Space;

/// A place inside the domain where the pieces on both sides need not be one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tear {
    /// The parameter that is fixed there: 0 for `u`.
    pub direction: usize,
    /// Its value.
    pub at: f64,
    /// Of a spline: how often the knot is repeated, more often than its degree.
    pub repeated: Option<usize>,
}

/// The first place where a shape may be torn, whatever its vertices: where the points of the cells on both sides are not the
/// same combination of control vertices. Of splines, knots that are repeated more often than the degree. The seam of a
/// periodic direction counts. None where the shape [says so](super::Cells::always_meet); else `O(n p)` for a curve, `O(n p²)` for a surface that is no spline.
///
/// # Errors
/// When the shape has no cells, or a stencil cannot be asked for; `what` needs to know.
pub fn torn(shape: &dyn Shape, what: &str) -> Result<Option<Tear>> {
    let cells = cells_of(shape, what)?;
    if let Some(splines) = cells.splines() {
        let of = |direction: usize, space: &Space| {
            let breaks = space.breakpoints();
            let inner = breaks.get(1..breaks.len().saturating_sub(1)).unwrap_or_default();
            let at = inner.iter().copied().find(|&t| space.multiplicity(t) > space.degree())?;
            Some(Tear { direction, at, repeated: Some(space.multiplicity(at)) })
        };
        return Ok(of(0, splines.u).or_else(|| splines.v.and_then(|v| of(1, v))));
    }
    if cells.always_meet() {
        return Ok(None);
    }
    let domain = shape.domain();
    for cell in cells.checked(shape)? {
        for (direction, (side, interval)) in cell.sides.iter().zip(&domain).enumerate() {
            if side.start == interval.start && !interval.periodic {
                continue;
            }
            let whole = places(&cell, direction).all(|at| meet(shape, at, direction).unwrap_or(false));
            if !whole {
                return Ok(Some(Tear { direction, at: side.start, repeated: None }));
            }
        }
    }
    Ok(None)
}

/// Places along the side of a cell where a direction starts, enough to determine what it is there.
fn places(cell: &Cell, direction: usize) -> impl Iterator<Item = Location> + '_ {
    let other = cell.sides.get(1 - direction);
    let count = other.map_or(1, |side| side.degree + 1);
    (0..count).map(move |k| {
        let share = (k as f64 + 0.5) / count as f64;
        cell.at(if direction == 0 { [0.0, share] } else { [share, 0.0] })
    })
}

/// Whether the points on both sides of a place are one combination of control vertices.
fn meet(shape: &dyn Shape, at: Location, direction: usize) -> Result<bool> {
    let on = |side| {
        if direction == 0 { Sides { u: side, v: Side::Right } } else { Sides { u: Side::Right, v: side } }
    };
    let row = |side| shape.stencil_on(at, Derivative::POSITION, on(side));
    let (left, right) = (row(Side::Left)?, row(Side::Right)?);
    let difference: Stencil = left.iter().chain(right.iter().map(|(v, c)| (v, -c))).collect();
    Ok(difference.coefficients().iter().all(|c| c.abs() <= 1e-9))
}
