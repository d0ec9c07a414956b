//! The search behind a fit: rounds of least squares, corrections and new knots, and what is left to smoothness.

use loftsman_kernel::plugin::Observer;
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

use crate::constraint::{Constraint, Held, Holding};
use crate::error::{FitError, Result};
use crate::fit::Fit;
use crate::foot::correct;
use crate::frame::Frame;
use crate::goal::Goal;
use crate::grading::Grading;
use crate::knots::shared;
use crate::least_squares::{LocalFit, Request};
use crate::measure::{self, Bounds, Course, LIMIT, PREFERRED};
use crate::refine::{Spans, refine};
use crate::smoothing::{Factors, energy};

/// A correction that takes less than this share off the largest error is the last one with these knots.
const WORTHWHILE: f64 = 0.1;

/// More rounds than doubling ever needs: where single knots are added again and again to no avail, it ends here.
const ROUNDS: usize = 64;
/// Tries to do with fewer knots, each halving what is left between too few and enough.
const REGRADINGS: usize = 6;
/// Tries to find how much smoothing the tolerance allows: everywhere alike, and row by row.
const UNIFORM: usize = 8;
const LOCAL: usize = 10;
/// How strongly a given number of vertices is straightened where it must be, as little as will do.
const STRAIGHTENED: [f64; 5] = [1e-8, 1e-6, 1e-4, 1e-2, 1.0];
/// How much longer a curve may be for each length that constraints pull it away from the points.
const DETOUR: f64 = 4.0;
/// A fit that needs less than this share of its tolerance is smooth enough.
const SPENT: f64 = 0.05;

/// A state on the way: a curve's vertices (local), its space, the points' parameters and distances.
#[derive(Debug, Clone)]
pub(crate) struct State {
    pub(crate) space: Space,
    pub(crate) vertices: Vec<f64>,
    pub(crate) sites: Vec<f64>,
    pub(crate) distances: Vec<f64>,
    pub(crate) condition: f64,
    pub(crate) held: Holding,
    /// Its length, or (where that is no longer than the polygon of the points) a bound of it from above.
    pub(crate) length: f64,
    /// Whether it goes where the points go.
    pub(crate) sound: bool,
    /// Whether it is sound and the tolerance holds.
    pub(crate) met: bool,
    pub(crate) interpolated: bool,
    /// What was done that nobody asked for.
    pub(crate) remarks: Vec<String>,
}

impl State {
    pub(crate) fn error(&self) -> f64 {
        self.distances.iter().fold(0.0, |m, d| m.max(*d))
    }

    /// The curve, in local coordinates.
    pub(crate) fn curve(&self) -> Result<Curve> {
        let vertices = self.vertices.chunks_exact(3).map(|v| Point::new(v[0], v[1], v[2])).collect();
        Ok(Curve::new(self.space.clone(), vertices)?)
    }
}

fn better(best: Option<State>, state: State) -> State {
    let rank = |s: &State| (s.met, s.sound);
    match best {
        Some(best) if rank(&best) > rank(&state) => best,
        Some(best) if rank(&best) == rank(&state) && !state.met && best.error() < state.error() => best,
        _ => state,
    }
}

/// A fit under way: of all points, or of those between two corners.
pub(crate) struct Search<'a> {
    pub(crate) fit: &'a Fit,
    pub(crate) frame: &'a Frame,
    pub(crate) points: &'a [Vector],
    /// The parameters to start from; around a closed curve one more.
    pub(crate) start: &'a [f64],
    pub(crate) weights: Option<&'a [f64]>,
    pub(crate) constraints: Vec<Constraint>,
    pub(crate) goal: Goal,
    /// Whether it is a piece between corners, which may have fewer points than the degree needs.
    pub(crate) piece: bool,
    pub(crate) iterations: usize,
    pub(crate) observer: &'a dyn Observer,
    pub(crate) regularization: f64,
    /// The length of the polygon of the points, and how much longer the curve may be because of constraints.
    polygon: f64,
    pub(crate) allowance: f64,
}

impl<'a> Search<'a> {
    #[allow(clippy::too_many_arguments, reason = "what a search works on, each of another kind")]
    pub(crate) fn new(
        fit: &'a Fit,
        frame: &'a Frame,
        points: &'a [Vector],
        start: &'a [f64],
        weights: Option<&'a [f64]>,
        constraints: Vec<Constraint>,
        goal: Goal,
        observer: &'a dyn Observer,
    ) -> Self {
        let course = Course { points, sites: start, closed: fit.closed, corners: &[] };
        let polygon = course.polygon();
        let (piece, iterations, allowance, regularization) = (false, 0, 0.0, fit.regularization);
        Self {
            fit,
            frame,
            points,
            start,
            weights,
            constraints,
            goal,
            piece,
            iterations,
            observer,
            regularization,
            polygon,
            allowance,
        }
    }

    /// The best curve that can be found: by rounds, made smooth, or by interpolation where these do not do.
    pub(crate) fn run(&mut self) -> Result<State> {
        let m = self.points.len();
        let alone = self.fit.constraints.is_empty();
        let few = self.piece && self.places() <= self.fit.degree;
        if few || (alone && self.goal.exact && self.goal.vertices == m) {
            // As many unknowns as points: there is nothing to minimize.
            if let Some(through) = self.through()? {
                return Ok(through);
            }
        }
        let best = match self.rounds() {
            // A polynomial of high degree on few places: interpolation by centripetal parameters, or of lower degree.
            Err(error @ (FitError::NoData { .. } | FitError::IllConditioned { .. }))
                if alone && !self.goal.limited =>
            {
                return self.through()?.ok_or(error);
            }
            other => other?,
        };
        let best = if best.met { self.regraded(best)? } else { best };
        if best.met && self.fit.smooth {
            return self.smoothed(best);
        }
        if best.met || self.goal.limited {
            return Ok(best);
        }
        let other = if alone { self.through()? } else { self.relaxed()? };
        Ok(other.unwrap_or(best))
    }

    /// How many different neighbours there are among the points.
    pub(crate) fn places(&self) -> usize {
        1 + self.points.windows(2).filter(|w| w[0] != w[1]).count()
    }

    /// Rounds of fitting, correcting and adding knots, until the goal is met, no span can be divided any more, or the
    /// points do not bear more knots. Returns the best of them.
    fn rounds(&mut self) -> Result<State> {
        let mut state = self.first_round()?;
        let mut best: Option<State> = None;
        for round in 0.. {
            self.observer.progress("fitting", state.space.len() as u64, self.points.len() as u64);
            // More knots than where a curve starts to swing between the points only make it swing more.
            let done = state.met
                || state.space.len() >= self.goal.vertices
                || !(state.sound || self.goal.exact || best.is_none());
            let next = if done { None } else { self.finer(&state, round)? };
            let outcome = match next {
                Some(space) => self.sound_round(&space, state.sites.clone()),
                None if self.goal.exact && !done => {
                    return Err(FitError::Request(format!(
                        "only {} control vertices can be placed where the points tell them apart: ask for at most that",
                        state.space.len()
                    )));
                }
                None if self.goal.exact => return self.settled(state),
                None => break,
            };
            best = if self.goal.exact { None } else { Some(better(best, state)) };
            state = match (outcome, best.take()) {
                (Ok(state), before) => {
                    best = before;
                    state
                }
                // More knots than the points can bear: the fit before is what there is.
                (Err(FitError::NoData { .. } | FitError::IllConditioned { .. }), Some(before)) => {
                    return Ok(before);
                }
                (Err(error), _) => return Err(error),
            };
        }
        Ok(better(best, state))
    }

    /// The fit with as many vertices as were asked for. Where it goes astray between the points: the one that has its
    /// knots shared out evenly, with the parameters from the start; then the same, straightened as little as will do,
    /// which is reported.
    fn settled(&mut self, state: State) -> Result<State> {
        let met = |state: State| State { met: true, ..state };
        if self.follows(&state, &LIMIT)? {
            return Ok(met(state));
        }
        let even = self.even_space(self.start)?;
        if even.len() != state.space.len() {
            return Ok(met(state));
        }
        let asked = self.regularization;
        for factor in std::iter::once(0.0).chain(STRAIGHTENED) {
            self.regularization = asked.max(factor);
            let tried = self.round(&even, self.start.to_vec());
            self.regularization = asked;
            match tried {
                Ok(mut other) if self.follows(&other, &LIMIT)? => {
                    if factor > asked {
                        other.remarks.push(format!(
                            "straightened (regularization {factor:e}): without, so many control vertices swing between the points"
                        ));
                    }
                    return Ok(met(other));
                }
                Ok(_) | Err(FitError::NoData { .. } | FitError::IllConditioned { .. }) => {}
                Err(error) => return Err(error),
            }
        }
        Ok(met(state))
    }

    /// A round; where it swings between the points, one that starts from the first parameters again, which corrections
    /// have not moved together.
    fn sound_round(&mut self, space: &Space, sites: Vec<f64>) -> Result<State> {
        let moved = sites != self.start;
        let first = self.round(space, sites);
        let again = match &first {
            Ok(state) => !state.sound,
            Err(error) => matches!(error, FitError::NoData { .. } | FitError::IllConditioned { .. }),
        };
        if !(moved && again) {
            return first;
        }
        match self.round(space, self.start.to_vec()) {
            Ok(second) if second.sound || first.is_err() => Ok(second),
            Err(FitError::Cancelled) => Err(FitError::Cancelled),
            _ => first,
        }
    }

    /// Fewer vertices (or, where their number is given, a smaller error) by knots spread evenly over the error.
    fn regraded(&mut self, mut best: State) -> Result<State> {
        let grading = Grading::of(&best.curve()?)?;
        let m = self.points.len();
        let own = if self.fit.closed { 0 } else { self.fit.degree };
        // As many spans are too few; the best state's are enough.
        let mut few = if self.fit.closed { 2 } else { 0 };
        for _ in 0..REGRADINGS {
            let enough = best.space.len() - own;
            let spans = if self.goal.exact { enough } else { usize::midpoint(few, enough) };
            if spans <= few {
                break;
            }
            let Some(space) = grading.space(&best.space, spans, &best.sites[..m])? else { break };
            let tried = match self.round(&space, best.sites.clone()) {
                Err(
                    FitError::NoData { .. } | FitError::IllConditioned { .. } | FitError::Conflict { .. },
                ) => None,
                other => Some(other?),
            };
            match tried {
                Some(tried) if self.goal.exact => {
                    if tried.space.len() == best.space.len()
                        && tried.error() < best.error()
                        && self.follows(&tried, &LIMIT)?
                    {
                        best = State { met: true, ..tried };
                    }
                    break;
                }
                Some(tried) if tried.met && tried.space.len() < best.space.len() => best = tried,
                _ => few = spans,
            }
        }
        Ok(best)
    }

    /// The next space to try: larger than the last one, so that there is an end.
    fn finer(&self, state: &State, round: usize) -> Result<Option<Space>> {
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
    fn first_round(&mut self) -> Result<State> {
        let sites = self.start;
        let (p, m) = (self.fit.degree, self.points.len());
        let (own, least) = if self.fit.closed { (0, (p + 1).max(3).min(m)) } else { (p, 1) };
        let most = (self.goal.vertices - own).min((m / 2).max(least));
        let mut spans = (least + self.fit.constraints.len()).min(most);
        loop {
            let breaks = shared(sites, spans);
            let space =
                if self.fit.closed { Space::periodic(p, breaks)? } else { Space::clamped(p, &breaks)? };
            match self.round(&space, sites.to_vec()) {
                Err(FitError::Conflict { .. }) if spans < most => spans = (2 * spans).min(most),
                other => return other,
            }
        }
    }

    /// As many vertices as asked for, the points shared out evenly among the spans.
    fn even_space(&self, sites: &[f64]) -> Result<Space> {
        let p = self.fit.degree;
        if self.fit.closed {
            return Ok(Space::periodic(p, shared(sites, self.goal.vertices))?);
        }
        Ok(Space::clamped(p, &shared(sites, self.goal.vertices - p))?)
    }

    /// Least squares and parameter corrections in one space. A correction after which the curve is longer than before
    /// (and longer than the polygon of the points, which a curve that cuts corners has to catch up with) is taken back.
    fn round(&mut self, space: &Space, mut sites: Vec<f64>) -> Result<State> {
        let m = self.points.len();
        let mut last_error = f64::INFINITY;
        let mut before: Option<State> = None;
        let mut correction = 0;
        loop {
            if self.observer.cancelled() {
                return Err(FitError::Cancelled);
            }
            let fit = match (self.solve(space, &sites[..m], &[]), before.take()) {
                (Ok(fit), kept) => {
                    before = kept;
                    fit
                }
                // Parameters that moved together: the curve that moved them is what there is.
                (Err(FitError::NoData { .. } | FitError::IllConditioned { .. }), Some(before)) => {
                    return self.judged(before);
                }
                (Err(error), _) => return Err(error),
            };
            let distances = self.request(space, &sites[..m]).distances(&fit.vertices)?;
            let mut state = self.state(space, fit, sites, distances)?;
            if let Some(before) = before.take_if(|before| state.length > before.length.max(self.polygon)) {
                return self.judged(before);
            }
            if self.goal.holds(state.error()) || correction == self.fit.corrections {
                return self.judged(state);
            }
            state.distances = correct(&state.curve()?, self.points, &mut state.sites, self.fit.closed)?;
            let error = state.error();
            if self.goal.holds(error) || error >= (1.0 - WORTHWHILE) * last_error {
                return self.judged(state);
            }
            last_error = error;
            sites = state.sites.clone();
            before = Some(state);
            correction += 1;
        }
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
        state.sound = state.length <= 1.25 * self.polygon + self.allowance;
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
        let travel = course.travel(&state.curve()?, state.error())?;
        Ok(travel.trouble(bounds, self.allowance, self.is_free()).is_none())
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

    /// A curve in the same space that is as smooth as the tolerance lets it be.
    ///
    /// Each row of `∫ |C'''|²` has a factor of its own beside the sum of squares. It grows where the points of the
    /// row's support are well within the tolerance and shrinks where one is not, so that a corner in the data does
    /// not keep the rest of the curve from being smooth.
    fn smoothed(&mut self, mut best: State) -> Result<State> {
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
