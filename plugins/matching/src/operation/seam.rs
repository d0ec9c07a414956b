//! What stays closed and smooth of a surface where the other edge has corners.

use std::collections::BTreeSet;

use loftsman_kernel::Vector;
use loftsman_kernel::edit::{Ask, Constraint};
use loftsman_kernel::error::Error;
use loftsman_kernel::functional::linear;
use loftsman_kernel::spline::{Direction, Surface};

use super::asked::Asked;

/// Rows at both ends that are nearer to one another than this part of the size meet.
const MEETS: f64 = 1e-9;

/// What stays as it is at knots where corners can appear.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kept {
    /// What is smooth.
    Smooth,
    /// What meets along a seam.
    Shut,
    /// Nothing.
    Nothing,
}

impl Kept {
    /// The next that asks for less.
    pub(super) fn less(self) -> Option<Self> {
        match self {
            Self::Smooth => Some(Self::Shut),
            Self::Shut => Some(Self::Nothing),
            Self::Nothing => None,
        }
    }
}

impl Asked {
    /// That the rows at both ends go on meeting, of a surface that closes along its edge: three equations for each column that may move.
    pub(super) fn seam(&self, surface: &Surface, along: Direction) -> Result<Vec<Constraint>, Error> {
        let (rows, columns) = (surface.u().len(), surface.v().len());
        let (last, across) = if along == Direction::U { (rows - 1, columns) } else { (columns - 1, rows) };
        let at =
            |end: usize, k: usize| if along == Direction::U { end * columns + k } else { k * columns + end };
        let points = surface.points();
        let size = points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max);
        let meets = |k: usize| (points[at(0, k)] - points[at(last, k)]).norm() <= MEETS * size;
        let closes = !surface.space(along).is_periodic() && (0..across).all(meets);
        if !closes {
            return Ok(Vec::new());
        }
        let locked: BTreeSet<i64> = self.locked(surface, along)?.into_iter().collect();
        let moving = (0..across).map(|k| (at(0, k) as i64, at(last, k) as i64));
        let moving = moving.filter(|(first, last)| !locked.contains(first) && !locked.contains(last));
        let tie = |(first, last)| {
            [Vector::x(), Vector::y(), Vector::z()].map(|axis| linear([(first, axis), (last, -axis)]).to(0.0))
        };
        Ok(moving.flat_map(tie).collect())
    }
}
