//! One direction of a carrier's parameters, and how much searching is left.

use loftsman_kernel::spline::ParameterSide;

/// The most pieces of a surface that are looked at for where one edge is on it, about a second's work. On files of CAD programs a place takes some tens, if
/// it is not found without; on those with one wrong number in them all places of an edge may be about as far from any number of pieces.
const SEARCHED: usize = 100_000;

/// How long places of an edge on a surface may still be searched for.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Searches(usize);

impl Default for Searches {
    fn default() -> Self {
        Self(SEARCHED)
    }
}

impl Searches {
    /// Whether places are no longer searched for all over the surface.
    pub(crate) fn are_over(self) -> bool {
        self.0 == 0
    }

    /// How many pieces may be looked at: one at least, so that there is a place.
    pub(super) fn left(self) -> usize {
        self.0.max(1)
    }

    pub(super) fn spend(&mut self, pieces: usize) {
        self.0 = self.0.saturating_sub(pieces);
    }
}

/// A direction of a surface's parameters.
#[derive(Debug)]
pub(crate) struct Side {
    pub(crate) low: f64,
    pub(crate) high: f64,
    /// Whether the surface closes in it.
    pub(crate) closed: bool,
    /// Where in it triangles must not reach across: creases, and both ends where it closes; ascending.
    pub(crate) lines: Vec<f64>,
    /// What the first derivative jumps by at the other knots, where it does at all; ascending.
    pub(super) jumps: Vec<(f64, f64)>,
}

impl Side {
    pub(crate) fn length(&self) -> f64 {
        self.high - self.low
    }

    /// The same place within the domain, where the direction is closed.
    pub(crate) fn wrapped(&self, x: f64) -> f64 {
        let &Self { low, high, closed, .. } = self;
        if closed { ParameterSide { low, high, closed, poles: [false; 2] }.wrapped(x) } else { x }
    }

    /// The same place, as near to another as it can be.
    pub(crate) fn unwrapped(&self, x: f64, near: f64) -> f64 {
        if self.closed { x + self.length() * ((near - x) / self.length()).round() } else { x }
    }
}
