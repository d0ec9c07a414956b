//! The span of one parameter after another: usually that of the parameter before, or the next one.

use crate::error::Result;
use crate::spline::Space;

/// A span of a space and the parameters `start <= u < stop` on it.
#[derive(Debug, Clone)]
pub(super) struct Cursor<'a> {
    space: &'a Space,
    /// The span; no parameter is on it before the first [`find`](Self::find).
    pub(super) span: usize,
    start: f64,
    stop: f64,
}

impl<'a> Cursor<'a> {
    pub(super) fn new(space: &'a Space) -> Self {
        Self { space, span: space.degree(), start: f64::INFINITY, stop: f64::NEG_INFINITY }
    }

    /// Goes to the span of a parameter, and gives the parameter as it is within the domain (wrapped, where periodic).
    /// `O(1)` on the span where the cursor is and on the next, `O(log n)` elsewhere.
    ///
    /// # Errors
    /// When the parameter is outside the domain.
    #[inline]
    pub(super) fn find(&mut self, u: f64) -> Result<f64> {
        if self.holds(u) {
            return Ok(u);
        }
        let u = self.space.locate(u)?;
        let flat = self.space.flat();
        let next = self.span + 1;
        let follows = next < self.space.unrolled_len() && flat[next] <= u && u < flat[next + 1];
        let span = if follows { next } else { self.space.span(u) };
        (self.span, self.start, self.stop) = (span, flat[span], flat[span + 1]);
        let (_, end) = self.space.domain();
        if self.stop == end && !self.space.is_periodic() {
            // The last span of an open space owns its end too.
            self.stop = end.next_up();
        }
        Ok(u)
    }

    /// Whether a parameter is on the span.
    #[inline]
    pub(super) fn holds(&self, u: f64) -> bool {
        u >= self.start && u < self.stop
    }

    /// How many of the first parameters are on the span.
    #[inline]
    pub(super) fn run(&self, us: &[f64]) -> usize {
        us.iter().position(|&u| !self.holds(u)).unwrap_or(us.len())
    }
}
