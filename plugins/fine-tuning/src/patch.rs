//! A region of a surface, and its way back.

use loftsman_kernel::spline::{Direction, Space, Surface};

use crate::error::{FineTuneError, Result};
use crate::lines::{index, name};

pub(crate) type Region = [Option<(f64, f64)>; 2];

/// The patch over a region.
pub(crate) fn patch(surface: &Surface, region: &Region) -> Result<Surface> {
    let mut own = surface.clone();
    for direction in [Direction::U, Direction::V] {
        if let Some((a, b)) = region[index(direction)] {
            own = own.between(direction, a, b)?;
        }
    }
    Ok(own)
}

/// The surface in the degrees and with the knots of a tuned patch, and the patch's control vertices in the place of its own: all
/// but those of the borders that are `kept` (at the start and at the end of `u`, of `v`), which stay the rest's. Of the rest not a bit changes.
pub(crate) fn put_back(
    surface: &Surface,
    tuned: &Surface,
    region: &Region,
    kept: [[bool; 2]; 2],
) -> Result<Surface> {
    let mut whole = surface.clone();
    let mut places = Vec::with_capacity(2);
    for direction in [Direction::U, Direction::V] {
        let (part, range) = (tuned.space(direction), region[index(direction)]);
        whole = refined(whole, direction, part, range.is_some())?;
        let count = part.len();
        let place = match range {
            Some((a, b)) => {
                place(whole.space(direction), a, b).filter(|(first, last)| *last + 1 == first + count)
            }
            None => (whole.space(direction) == part).then_some((0, count - 1)),
        };
        let Some((first, _)) = place else {
            return Err(FineTuneError::Contradiction(format!(
                "the region has knots along {} too near to others of the surface to be put back: choose another region",
                name(direction)
            )));
        };
        places.push((first, range.is_some()));
    }
    let [(row, in_u), (column, in_v)] = places[..] else { return Ok(whole) };
    let [[top, bottom], [left, right]] = kept.map(|ends| ends.map(usize::from));
    let (u, v, mut points, _) = whole.into_parts();
    let (height, width) = (tuned.u().len(), tuned.v().len());
    for i in top..height - bottom {
        for j in left..width - right {
            let (to_row, to_column) = (row + i, column + j);
            // A direction that is whole keeps its numbers; only a part's may pass the seam.
            let to_row = if in_u { u.vertex(to_row) } else { to_row };
            let to_column = if in_v { v.vertex(to_column) } else { to_column };
            points[to_row * v.len() + to_column] = tuned.points()[i * width + j];
        }
    }
    Ok(Surface::new(u, v, points)?)
}

/// The unrolled numbers of the first and the last vertex of a part whose ends are knots of full multiplicity.
fn place(space: &Space, a: f64, b: f64) -> Option<(usize, usize)> {
    let (p, flat) = (space.degree(), space.flat());
    // The vertex at a is the first one that the span behind the last copy of a knows; the one at b the last before b.
    let first = flat[..=space.unrolled_len()].partition_point(|k| *k <= a).checked_sub(1 + p)?;
    let last = (flat[p..].partition_point(|k| *k < b) + p).checked_sub(1)?;
    Some((first, last))
}

/// The surface in one direction of the degree of a part and with its knots, at a part's ends as many as the degree.
fn refined(surface: Surface, direction: Direction, part: &Space, partly: bool) -> Result<Surface> {
    let own = surface.space(direction);
    if own == part {
        return Ok(surface);
    }
    let mut raised = surface.clone();
    if !own.is_periodic() {
        raised = raised.convert(direction, &own.clamping()?)?;
    }
    raised = raised.elevate(direction, part.degree() - own.degree())?;
    let (space, degree) = (raised.space(direction), part.degree());
    let ((a, b), ends) = (part.domain(), space.domain());
    let lacking = |t: f64| {
        let wanted = if partly && (t == a || t == b) { degree } else { part.multiplicity(t) };
        let open_end = !space.is_periodic() && (t == ends.0 || t == ends.1);
        // Around a period both ends are one knot.
        let again = space.is_periodic() && t == ends.1 && (!partly || a == ends.0);
        let times = if open_end || again { 0 } else { wanted.saturating_sub(space.multiplicity(t)) };
        std::iter::repeat_n(t, times)
    };
    let missing: Vec<f64> = part.breakpoints().into_iter().flat_map(lacking).collect();
    let raised = raised.insert_knots(direction, &missing)?;
    if partly || !part.is_periodic() { Ok(raised) } else { renumbered(raised, direction, part) }
}

/// A surface that is closed in a direction with its control vertices numbered from where another space over the same knots numbers
/// them: copies of the seam's knot may stand at its start or at its end.
fn renumbered(surface: Surface, direction: Direction, part: &Space) -> Result<Surface> {
    let own = surface.space(direction);
    let often = |space: &Space| {
        let each = space.breakpoints();
        each.into_iter().map(|t| (t, space.multiplicity(t))).collect::<Vec<_>>()
    };
    if !own.is_periodic() || own.degree() != part.degree() || often(own) != often(part) {
        return Ok(surface);
    }
    let at_start = |space: &Space| space.knots().iter().take_while(|t| **t == space.domain().0).count();
    let n = own.len();
    let shift = n + at_start(own) % n - at_start(part) % n;
    let from = |k: usize| (k + shift) % n;
    let (rows, columns) = (surface.u().len(), surface.v().len());
    let points = surface.points();
    let each = (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j)));
    Ok(match direction {
        Direction::U => {
            let points = each.map(|(i, j)| points[from(i) * columns + j]).collect();
            Surface::new(part.clone(), surface.v().clone(), points)?
        }
        Direction::V => {
            let points = each.map(|(i, j)| points[i * columns + from(j)]).collect();
            Surface::new(surface.u().clone(), part.clone(), points)?
        }
    })
}
