//! What a tolerance leaves over, spent on smoothness.

use loftsman_kernel::spline::Space;

use crate::error::{FitError, Result};
use crate::foot::correct;
use crate::search::Search;
use crate::smoothing::{Factors, energy};
use crate::state::State;

/// Tries to find how much smoothing the tolerance allows: everywhere alike, and row by row.
const UNIFORM: usize = 8;
const LOCAL: usize = 10;
/// A fit that needs less than this share of its tolerance is smooth enough.
const SPENT: f64 = 0.05;

impl Search<'_> {
    /// A curve in the same space that is as smooth as the tolerance lets it be.
    ///
    /// Each row of `∫ |C'''|²` has a factor of its own beside the sum of squares. It grows where the points of the
    /// row's support are well within the tolerance and shrinks where one is not, so that a corner in the data does
    /// not keep the rest of the curve from being smooth.
    pub(crate) fn smoothed(&mut self, mut best: State) -> Result<State> {
        let (m, Some(tolerance)) = (self.points.len(), self.goal.tolerance) else { return Ok(best) };
        let mut least = energy(&best.space, &best.vertices);
        if best.error() < SPENT * tolerance || least == 0.0 {
            return Ok(best);
        }
        let space = best.space.clone();
        // First one factor for all rows, in steps of a power from where both sums would weigh the same.
        let mut factor = m as f64 * tolerance * tolerance / least;
        let (mut step, mut before, mut held) = (16.0_f64, None, None);
        for _ in 0..UNIFORM {
            let Some(tried) = self.smoothly(&space, &best.sites, Factors::new(&space, factor).values())?
            else {
                return Ok(best);
            };
            if before.is_some_and(|b| b != tried.met) {
                step = step.sqrt();
            }
            before = Some(tried.met);
            if tried.met {
                held = Some(factor);
                least = energy(&space, &tried.vertices);
                best = tried;
                factor *= step;
            } else {
                factor /= step;
            }
        }
        // Then each row's own.
        let mut factors = Factors::new(&space, held.unwrap_or(factor));
        for _ in 0..LOCAL {
            let Some(tried) = self.smoothly(&space, &best.sites, factors.values())? else { return Ok(best) };
            factors.adapt(&tried.sites[..m], &tried.distances, tolerance);
            let energy = energy(&space, &tried.vertices);
            if tried.met && energy <= 1.02 * least {
                least = energy.min(least);
                best = tried;
            }
        }
        Ok(best)
    }

    /// The fit with these factors of smoothness, its parameters corrected once; `None` where corrections before have
    /// left the parameters too close together for an answer.
    fn smoothly(&mut self, space: &Space, sites: &[f64], factors: &[f64]) -> Result<Option<State>> {
        if self.observer.cancelled() {
            return Err(FitError::Cancelled);
        }
        let m = self.points.len();
        let fit = match self.solve(space, &sites[..m], factors) {
            Err(FitError::NoData { .. } | FitError::IllConditioned { .. }) => return Ok(None),
            other => other?,
        };
        let mut tried = self.state(space, fit, sites.to_vec(), Vec::new())?;
        tried.distances = if self.fit.corrections > 0 {
            correct(&tried.curve()?, self.points, &mut tried.sites, self.fit.closed)?
        } else {
            self.request(space, &tried.sites[..m]).distances(&tried.vertices)?
        };
        self.judged(tried).map(Some)
    }
}
