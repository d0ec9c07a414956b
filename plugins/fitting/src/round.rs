//! One round of a search: least squares and parameter corrections in one space, judged.

use loftsman_kernel::Vector;
use loftsman_kernel::spline::Space;

use crate::constraint::Held;
use crate::error::{FitError, Result};
use crate::foot::correct;
use crate::least_squares::{LocalFit, Request};
use crate::measure::{self, Bounds, Course, PREFERRED};
use crate::search::{Search, WORTHWHILE};
use crate::state::State;

/// How much longer a curve may be for each length that constraints pull it away from the points.
const DETOUR: f64 = 4.0;

impl Search<'_> {
    /// Least squares in one space, and parameter corrections.
    pub(crate) fn round(&mut self, space: &Space, sites: &[f64]) -> Result<State> {
        let first = self.solved(space, sites)?;
        self.corrected(first)
    }

    /// Least squares in one space, not yet judged.
    pub(crate) fn solved(&mut self, space: &Space, sites: &[f64]) -> Result<State> {
        if self.observer.cancelled() {
            return Err(FitError::Cancelled);
        }
        let m = self.points.len();
        let fit = self.solve(space, &sites[..m], &[])?;
        let distances = self.request(space, &sites[..m]).distances(&fit.vertices)?;
        self.state(space, fit, sites.to_vec(), distances)
    }

    /// Parameter corrections, and least squares after each. The sum of squares never grows by these, but the largest
    /// error may: the state that has the least one is kept. A correction after which the curve is longer than before
    /// (and longer than the polygon of the points, which a curve that cuts corners has to catch up with) is taken back.
    pub(crate) fn corrected(&mut self, mut state: State) -> Result<State> {
        let mut last_error = f64::INFINITY;
        let mut best: Option<State> = None;
        for correction in 0.. {
            if correction == self.corrections || self.goal.holds(state.error()) {
                break;
            }
            state.distances = correct(&state.curve()?, self.points, &mut state.sites, self.fit.closed)?;
            let error = state.error();
            if self.goal.holds(error) || error >= (1.0 - WORTHWHILE) * last_error {
                break;
            }
            last_error = error;
            let next = match self.solved(&state.space, &state.sites) {
                Ok(next) if next.length > state.length.max(self.polygon) => break,
                // Parameters that moved together: the curve that moved them is what there is.
                Err(FitError::NoData { .. } | FitError::IllConditioned { .. }) => break,
                other => other?,
            };
            best = Some(self.nearer(best, state));
            state = next;
        }
        let best = self.nearer(best, state);
        self.judged(best)
    }

    /// Of two states the one that comes nearer to the points, among those that are not too long.
    pub(crate) fn nearer(&self, best: Option<State>, state: State) -> State {
        let long = |s: &State| !self.is_short(s);
        match best {
            Some(best) if (long(&best), best.error()) < (long(&state), state.error()) => best,
            _ => state,
        }
    }

    /// Whether a state's curve is not much longer than the polygon of the points.
    fn is_short(&self, state: &State) -> bool {
        state.length <= 1.25 * self.polygon + self.allowance
    }

    /// A solution as a state, with its length, not yet judged.
    pub(crate) fn state(
        &self,
        space: &Space,
        fit: LocalFit,
        sites: Vec<f64>,
        distances: Vec<f64>,
    ) -> Result<State> {
        let mut state = State {
            space: space.clone(),
            vertices: fit.vertices,
            sites,
            distances,
            condition: fit.condition,
            held: fit.held,
            length: 0.0,
            sound: false,
            met: false,
            interpolated: false,
            remarks: Vec::new(),
        };
        // The control polygon is never shorter than the curve: where that is short enough, it will do.
        let vertices = state.vertices.as_chunks::<3>().0;
        let around = if self.fit.closed { vertices.last().zip(vertices.first()) } else { None };
        let legs = vertices.windows(2).map(|w| (&w[0], &w[1])).chain(around);
        state.length = legs.map(|(a, b)| (Vector::from(*b) - Vector::from(*a)).norm()).sum();
        if state.length.is_nan() || state.length > self.polygon {
            state.length = measure::length(&state.curve()?)?;
        }
        Ok(state)
    }

    /// Decides whether a state is sound, and whether it meets the goal.
    pub(crate) fn judged(&self, mut state: State) -> Result<State> {
        state.sound = self.is_short(&state);
        if state.sound && self.goal.holds(state.error()) {
            state.sound = self.follows(&state, &PREFERRED)?;
            state.met = state.sound;
        }
        Ok(state)
    }

    /// Whether a state's curve travels as the points do, within bounds.
    pub(crate) fn follows(&self, state: &State, bounds: &Bounds) -> Result<bool> {
        let sites = &state.sites[..self.points.len()];
        let course = Course { points: self.points, sites, closed: self.fit.closed, corners: &[] };
        let curve = state.curve()?;
        let travel = course.travel(&curve, state.error())?;
        Ok(travel.trouble(bounds, self.allowance, self.is_free()).is_none()
            && course.outside(&curve, self.allowance)?.is_none())
    }

    /// Whether constraints may send the curve off between the points.
    pub(crate) fn is_free(&self) -> bool {
        !self.fit.constraints.is_empty()
    }

    pub(crate) fn request<'s>(&'s self, space: &'s Space, sites: &'s [f64]) -> Request<'s> {
        let (points, weights) = (self.points, self.weights);
        Request { space, sites, points, weights, regularization: self.regularization, smoothing: &[] }
    }

    pub(crate) fn solve(&mut self, space: &Space, sites: &[f64], smoothing: &[f64]) -> Result<LocalFit> {
        self.iterations += 1;
        let request = Request { smoothing, ..self.request(space, sites) };
        request.check()?;
        let mut pull = 0.0;
        let held = if self.constraints.is_empty() {
            Held::default()
        } else {
            let rough = request.rough(self.frame)?;
            let held = Held::new(&self.constraints, &rough, self.frame)?;
            pull = held.pull(&rough, self.frame);
            held
        };
        let solved = request.solve(&held);
        self.allowance = self.allowance.max(DETOUR * pull);
        solved
    }
}
