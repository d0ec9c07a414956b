//! Where a search places its knots.

use loftsman_kernel::spline::Space;

use crate::error::{FitError, Result};
use crate::grading::Grading;
use crate::knots::shared;
use crate::measure::LIMIT;
use crate::refine::{Spans, refine};
use crate::search::Search;
use crate::state::{State, better};

/// More rounds than doubling ever needs: where single knots are added again and again to no avail, it ends here.
const ROUNDS: usize = 64;
/// Tries to do with fewer knots, each halving what is left between too few and enough.
const REGRADINGS: usize = 6;
/// How many even knots are tried where rounds do not meet a tolerance, in eighths of the points.
const EVENED: [usize; 4] = [4, 5, 6, 7];

impl Search<'_> {
    /// The next space to try: larger than the last one, so that there is an end.
    pub(crate) fn finer(&self, state: &State, round: usize) -> Result<Option<Space>> {
        if round < ROUNDS {
            let spans = Spans::of(&state.space, &state.sites[..self.points.len()], &state.distances);
            let room = self.goal.vertices - state.space.len();
            let finer = refine(&state.space, &spans, self.goal.tolerance, room)?;
            if finer.is_some() || !self.goal.exact {
                return Ok(finer);
            }
        }
        if !self.goal.exact {
            return Ok(None);
        }
        // Too few points a span to choose by error: share the points out evenly.
        let even = self.even_space(&state.sites)?;
        Ok((even.len() > state.space.len()).then_some(even))
    }

    /// A round with one span (as many as a closed curve needs), and one more for each constraint: more, where these
    /// cannot hold together on so few vertices.
    pub(crate) fn first_round(&mut self) -> Result<State> {
        let sites = self.start;
        let (p, m) = (self.fit.degree, self.points.len());
        let (own, least) = if self.fit.closed { (0, (p + 1).max(3).min(m)) } else { (p, 1) };
        let most = (self.goal.vertices - own).min((m / 2).max(least));
        let mut spans = (least + self.fit.constraints.len()).min(most);
        loop {
            let breaks = shared(sites, spans);
            let space =
                if self.fit.closed { Space::periodic(p, breaks)? } else { Space::clamped(p, &breaks)? };
            match self.round(&space, sites) {
                Err(FitError::Conflict { .. }) if spans < most => spans = (2 * spans).min(most),
                other => return other,
            }
        }
    }

    /// As many vertices as asked for, the points shared out evenly among the spans.
    pub(crate) fn even_space(&self, sites: &[f64]) -> Result<Space> {
        let p = self.fit.degree;
        if self.fit.closed {
            return Ok(Space::periodic(p, shared(sites, self.goal.vertices))?);
        }
        Ok(Space::clamped(p, &shared(sites, self.goal.vertices - p))?)
    }

    /// Fewer vertices (or, where their number is given, a smaller error) by knots at even steps of the parameters to
    /// start from, or of the points.
    pub(crate) fn evened(&mut self, mut best: State) -> Result<State> {
        let (p, closed, start) = (self.fit.degree, self.fit.closed, self.start);
        let (first, last) = (start[0], start[start.len() - 1]);
        let places = |_: &State, spans: usize| -> Result<Vec<Place>> {
            let step = |i: usize| {
                let share = i as f64 / spans as f64;
                first * (1.0 - share) + last * share
            };
            let mut ways = vec![(0..=spans).map(step).collect(), shared(start, spans)];
            ways.dedup();
            let space = |breaks: Vec<f64>| -> Result<Place> {
                let space = if closed { Space::periodic(p, breaks)? } else { Space::clamped(p, &breaks)? };
                Ok((space, start.to_vec()))
            };
            ways.into_iter().filter(|b| b.len() == spans + 1).map(space).collect()
        };
        if !best.met {
            // Some that rounds have not come to.
            let own = if closed { 0 } else { p };
            for eighths in EVENED {
                let vertices = (self.points.len() * eighths / 8).min(self.goal.vertices);
                if best.met || vertices <= best.space.len() {
                    continue;
                }
                for place in places(&best, vertices - own)? {
                    if let Some(tried) = self.attempted(&place)? {
                        best = better(Some(best), tried);
                    }
                }
            }
        }
        if best.met { self.leaner(best, usize::MAX, &places) } else { Ok(best) }
    }

    /// The same by knots spread evenly over the error.
    pub(crate) fn regraded(&mut self, best: State) -> Result<State> {
        let grading = Grading::of(&best.curve()?)?;
        let m = self.points.len();
        let places = |best: &State, spans: usize| -> Result<Vec<Place>> {
            let space = grading.space(&best.space, spans, &best.sites[..m])?;
            Ok(space.map(|space| (space, best.sites.clone())).into_iter().collect())
        };
        self.leaner(best, REGRADINGS, &places)
    }

    /// The state with the fewest vertices that meets the goal, of those at the places that a number of spans gives, by
    /// bisection; where the number is given, the nearest of them.
    fn leaner(
        &mut self,
        mut best: State,
        tries: usize,
        places: &dyn Fn(&State, usize) -> Result<Vec<Place>>,
    ) -> Result<State> {
        let own = if self.fit.closed { 0 } else { self.fit.degree };
        if self.goal.exact {
            let spans = best.space.len() - own;
            for place in places(&best, spans)? {
                if let Some(tried) = self.attempted(&place)?.filter(|t| t.space.len() == best.space.len()) {
                    best = self.preferred(best, State { met: true, ..tried })?;
                }
            }
            return Ok(best);
        }
        // As many spans are too few; the best state's are enough.
        let mut few = if self.fit.closed { 2 } else { 0 };
        for _ in 0..tries {
            let enough = best.space.len() - own;
            let spans = usize::midpoint(few, enough);
            if spans <= few {
                break;
            }
            let mut found = None;
            for place in places(&best, spans)? {
                found = self.attempted(&place)?.filter(|t| t.met && t.space.len() < best.space.len());
                if found.is_some() {
                    break;
                }
            }
            match found {
                Some(found) => best = found,
                None => few = spans,
            }
        }
        Ok(best)
    }

    /// A round; `None` where the points do not bear those knots, or constraints do not.
    fn attempted(&mut self, (space, sites): &Place) -> Result<Option<State>> {
        match self.round(space, sites) {
            Err(FitError::NoData { .. } | FitError::IllConditioned { .. } | FitError::Conflict { .. }) => {
                Ok(None)
            }
            other => other.map(Some),
        }
    }

    /// Of two states with the number of vertices that was asked for the nearer one that goes where the points go.
    pub(crate) fn preferred(&self, best: State, other: State) -> Result<State> {
        let follows = self.follows(&other, &LIMIT)?;
        if other.error() < best.error() {
            let take = follows || !self.follows(&best, &LIMIT)?;
            return Ok(if take { other } else { best });
        }
        let take = follows && !self.follows(&best, &LIMIT)?;
        Ok(if take { other } else { best })
    }
}

/// Knots, and the parameters to try them with.
type Place = (Space, Vec<f64>);
