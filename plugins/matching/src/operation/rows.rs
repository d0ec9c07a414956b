//! Rows of control vertices across the edge: those that move, and those that stay.

use loftsman_kernel::error::Error;
use loftsman_kernel::spline::{Direction, Space, Surface};
use loftsman_kernel::topology::EdgeCurve;

use super::asked::Asked;

impl Asked {
    /// The surface with enough rows across: those that move, and those that stay.
    pub(super) fn with_rows(&self, surface: &Surface, across: Direction) -> Result<Surface, Error> {
        let mut surface = surface.clone();
        let degree = surface.space(across).degree();
        let least = Self::rows(self.continuity);
        if degree < least {
            surface = surface.elevate(across, least - degree)?;
        }
        let rows = |rows: usize| say(surface.space(across), rows);
        let needed = rows(least) + self.keep.map_or(1, |keep| rows(Self::rows(keep)));
        while surface.space(across).len() < needed {
            let breaks = surface.space(across).breakpoints();
            let longest = breaks.windows(2).max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])));
            let Some(&[a, b]) = longest else { break };
            surface = surface.insert_knots(across, &[0.5 * a + 0.5 * b])?;
        }
        Ok(surface)
    }

    /// The rows at the opposite edge that stay.
    pub(super) fn locked(&self, surface: &Surface, along: Direction) -> Result<Vec<i64>, Error> {
        let Some(keep) = self.keep else { return Ok(Vec::new()) };
        let (rows, columns) = (surface.u().len(), surface.v().len());
        let edge = self.edge.number_on(surface)?;
        let edge = EdgeCurve::of(surface, edge, "match")?.edge;
        let across = surface.space(along.other());
        let say = say(across, Self::rows(keep));
        let count = across.len();
        let stays = |i: usize| if edge.at_end { i < say } else { i + say >= count };
        let mut locked = Vec::new();
        for i in 0..rows {
            for j in 0..columns {
                if stays(if along == Direction::U { j } else { i }) {
                    locked.push((i * columns + j) as i64);
                }
            }
        }
        Ok(locked)
    }
}

/// How many rows have a say in so many derivatives at an end: at one that is not clamped, all of the last span.
pub(super) fn say(across: &Space, rows: usize) -> usize {
    if across.is_clamped() { rows } else { across.degree().max(rows) }
}
