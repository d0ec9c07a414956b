//! The search behind a fit: rounds of least squares, corrections and new knots, and what is left to smoothness.

use loftsman_kernel::plugin::Observer;
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

use crate::constraint::{Constraint, Held, Kept};
use crate::error::{FitError, Result};
use crate::fit::{Fit, FittedCurve, Target};
use crate::foot::correct;
use crate::frame::Frame;
use crate::grading::Grading;
use crate::interpolation::{Duplicates, Interpolation};
use crate::knots::shared;
use crate::least_squares::{LocalFit, Request};
use crate::parameters::Parametrization;
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
/// A fit that needs less than this share of its tolerance is smooth enough.
const SPENT: f64 = 0.05;

/// The target in local coordinates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Goal {
    tolerance: Option<f64>,
    vertices: usize,
    exact: bool,
}

impl Goal {
    pub(crate) fn new(fit: &Fit, frame: &Frame, points: &[Vector]) -> Result<Self> {
        let positive = |tolerance: f64| {
            if tolerance > 0.0 && tolerance.is_finite() {
                return Ok(tolerance);
            }
            Err(FitError::Request(format!(
                "a tolerance of {tolerance} cannot be met: give a positive length"
            )))
        };
        let m = points.len();
        let least = if fit.closed { 3 } else { fit.degree + 1 };
        if m < least {
            return Err(FitError::TooFewPoints {
                found: m,
                needed: least,
                degree: fit.degree,
                possible: m.saturating_sub(1),
            });
        }
        let counted = |vertices: usize| {
            if vertices >= least && vertices <= m {
                return Ok(vertices);
            }
            Err(FitError::Request(format!(
                "{vertices} control vertices cannot be fitted: choose from {least} (the degree is {}) to {m} (the points)",
                fit.degree
            )))
        };
        let (tolerance, vertices, exact) = match fit.target {
            Target::Tolerance(t) => (Some(frame.enter_length(positive(t)?)), m, false),
            Target::Relative(t) => {
                let (low, high) =
                    points.iter().fold((points[0], points[0]), |(low, high), p| (low.inf(p), high.sup(p)));
                (Some(positive(t)? * (high - low).norm()), m, false)
            }
            Target::Vertices(n) => (None, counted(n)?, true),
            Target::AtMost { tolerance, vertices } => {
                (Some(frame.enter_length(positive(tolerance)?)), counted(vertices)?, false)
            }
        };
        Ok(Self { tolerance, vertices, exact })
    }

    fn holds(&self, error: f64) -> bool {
        self.tolerance.is_some_and(|t| error <= t)
    }
}

/// A state on the way: a curve's vertices (local), its space, the points' parameters and distances.
#[derive(Debug)]
pub(crate) struct State {
    space: Space,
    vertices: Vec<f64>,
    sites: Vec<f64>,
    distances: Vec<f64>,
    condition: f64,
    kept: Kept,
    pub(crate) met: bool,
    interpolated: bool,
}

impl State {
    fn error(&self) -> f64 {
        self.distances.iter().fold(0.0, |m, d| m.max(*d))
    }
}

fn better(best: Option<State>, state: State) -> State {
    match best {
        Some(best) if !state.met && best.error() < state.error() => best,
        _ => state,
    }
}

/// A fit under way.
pub(crate) struct Search<'a> {
    pub(crate) fit: &'a Fit,
    pub(crate) frame: &'a Frame,
    pub(crate) points: &'a [Vector],
    pub(crate) weights: Option<&'a [f64]>,
    pub(crate) constraints: Vec<Constraint>,
    pub(crate) goal: Goal,
    pub(crate) iterations: usize,
    pub(crate) observer: &'a dyn Observer,
}

impl Search<'_> {
    /// The best curve that can be found: by rounds, made smooth, or by interpolation where these do not do.
    pub(crate) fn run(&mut self, points: &[Point], sites: &[f64]) -> Result<State> {
        let best = self.rounds(sites)?;
        let best = if best.met { self.regraded(best)? } else { best };
        if best.met && self.fit.smooth {
            return self.smoothed(best);
        }
        if !best.met && self.fit.constraints.is_empty() && self.goal.vertices >= self.points.len() {
            return Ok(self.interpolate(points, sites)?.unwrap_or(best));
        }
        Ok(best)
    }

    /// Rounds of fitting, correcting and adding knots, until the goal is met or no span can be divided any more.
    /// Returns the best of them.
    fn rounds(&mut self, sites: &[f64]) -> Result<State> {
        let mut state = self.first_round(sites)?;
        let mut best: Option<State> = None;
        for round in 0.. {
            self.observer.progress("fitting", state.space.len() as u64, self.points.len() as u64);
            let done = state.met || state.space.len() >= self.goal.vertices;
            let next = if done { None } else { self.finer(&state, round)? };
            let outcome = match next {
                Some(space) => self.round(&space, state.sites.clone()),
                None if self.goal.exact && !done => {
                    return Err(FitError::Request(format!(
                        "only {} control vertices can be placed where the points tell them apart: ask for at most that",
                        state.space.len()
                    )));
                }
                None if self.goal.exact => return Ok(State { met: true, ..state }),
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

    /// Fewer vertices (or, where their number is given, a smaller error) by knots spread evenly over the error.
    fn regraded(&mut self, mut best: State) -> Result<State> {
        let grading = Grading::of(&self.local_curve(&best)?)?;
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
                    if tried.space.len() == best.space.len() && tried.error() < best.error() {
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
    fn first_round(&mut self, sites: &[f64]) -> Result<State> {
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

    /// Least squares and parameter corrections in one space.
    fn round(&mut self, space: &Space, mut sites: Vec<f64>) -> Result<State> {
        let m = self.points.len();
        let mut last_error = f64::INFINITY;
        let mut correction = 0;
        loop {
            if self.observer.cancelled() {
                return Err(FitError::Cancelled);
            }
            let fit = self.solve(space, &sites[..m], &[])?;
            let distances = self.request(space, &sites[..m]).distances(&fit.vertices)?;
            let mut state = State {
                space: space.clone(),
                vertices: fit.vertices,
                sites,
                distances,
                condition: fit.condition,
                kept: fit.kept,
                met: false,
                interpolated: false,
            };
            state.met = self.goal.holds(state.error());
            if state.met || correction == self.fit.corrections {
                return Ok(state);
            }
            let curve = self.local_curve(&state)?;
            state.distances = correct(&curve, self.points, &mut state.sites, self.fit.closed)?;
            let error = state.error();
            state.met = self.goal.holds(error);
            correction += 1;
            if state.met || error >= (1.0 - WORTHWHILE) * last_error {
                return Ok(state);
            }
            last_error = error;
            sites = state.sites;
        }
    }

    fn request<'s>(&'s self, space: &'s Space, sites: &'s [f64]) -> Request<'s> {
        let (points, weights) = (self.points, self.weights);
        Request { space, sites, points, weights, regularization: self.fit.regularization, smoothing: &[] }
    }

    fn solve(&mut self, space: &Space, sites: &[f64], smoothing: &[f64]) -> Result<LocalFit> {
        self.iterations += 1;
        let request = Request { smoothing, ..self.request(space, sites) };
        request.check()?;
        let held = if self.constraints.is_empty() {
            Held::default()
        } else {
            Held::new(&self.constraints, &request.rough(self.frame)?, self.frame)?
        };
        request.solve(&held, self.frame)
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
            let tried = self.smoothly(&space, &best.sites, Factors::new(&space, factor).values())?;
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
            let tried = self.smoothly(&space, &best.sites, factors.values())?;
            factors.adapt(&tried.sites[..m], &tried.distances, tolerance);
            let energy = energy(&space, &tried.vertices);
            if tried.met && energy <= 1.02 * least {
                least = energy.min(least);
                best = tried;
            }
        }
        Ok(best)
    }

    /// The fit with these factors of smoothness, its parameters corrected once.
    fn smoothly(&mut self, space: &Space, sites: &[f64], factors: &[f64]) -> Result<State> {
        if self.observer.cancelled() {
            return Err(FitError::Cancelled);
        }
        let m = self.points.len();
        let fit = self.solve(space, &sites[..m], factors)?;
        let mut tried = State {
            space: space.clone(),
            vertices: fit.vertices,
            sites: sites.to_vec(),
            distances: Vec::new(),
            condition: fit.condition,
            kept: fit.kept,
            met: false,
            interpolated: false,
        };
        tried.distances = if self.fit.corrections > 0 {
            let curve = self.local_curve(&tried)?;
            correct(&curve, self.points, &mut tried.sites, self.fit.closed)?
        } else {
            self.request(space, &tried.sites[..m]).distances(&tried.vertices)?
        };
        tried.met = self.goal.holds(tried.error());
        Ok(tried)
    }

    fn local_curve(&self, state: &State) -> Result<Curve> {
        let vertices = state.vertices.chunks_exact(3).map(|v| Point::new(v[0], v[1], v[2])).collect();
        Ok(Curve::new(state.space.clone(), vertices)?)
    }

    /// The curve through all points: what is left when no fewer vertices are enough.
    fn interpolate(&mut self, points: &[Point], sites: &[f64]) -> Result<Option<State>> {
        self.iterations += 1;
        let through = Interpolation {
            closed: self.fit.closed,
            parameters: Parametrization::Given(sites.to_vec()),
            duplicates: Duplicates::Merge,
            ..Interpolation::new(self.fit.degree)
        }
        .curve(&points[..self.points.len()]);
        // Where it cannot be (too few distinct points, an unlucky even degree) the fit is what there is.
        let Ok(through) = through else { return Ok(None) };
        let vertices: Vec<f64> =
            through.curve.points().iter().flat_map(|&p| <[f64; 3]>::from(self.frame.enter(p))).collect();
        let space = through.curve.space().clone();
        let sites = sites[..self.points.len()].to_vec();
        let distances = self.request(&space, &sites).distances(&vertices)?;
        let mut state = State {
            space,
            vertices,
            sites,
            distances,
            condition: through.condition,
            kept: Kept::default(),
            met: false,
            interpolated: true,
        };
        state.met = self.goal.holds(state.error());
        Ok(state.met.then_some(state))
    }

    /// Back to document coordinates, with distances measured on the curve that is handed out.
    pub(crate) fn finish(
        &self,
        state: State,
        points: &[Point],
        closing_point_dropped: bool,
    ) -> Result<FittedCurve> {
        let mut vertices = self.frame.raise(&state.vertices);
        if !self.fit.closed && self.fit.keep_ends {
            // The ends hold to rounding: make it to the last bit, unless a constraint put them elsewhere.
            let (last, end) = (vertices.len() - 1, points.len() - 1);
            for (vertex, point) in [(0, 0), (last, end)] {
                let off = (self.frame.enter(vertices[vertex]) - self.frame.enter(points[point])).norm();
                if off < 1e-12 {
                    vertices[vertex] = points[point];
                }
            }
        }
        let curve = Curve::new(state.space, vertices)?;
        let mut parameters = state.sites;
        parameters.truncate(self.points.len());
        let (mut max_error, mut worst, mut sum) = (0.0_f64, 0, 0.0);
        for (k, (&u, point)) in parameters.iter().zip(points).enumerate() {
            let distance = (self.frame.enter(curve.point(u)?) - self.frame.enter(*point)).norm();
            if distance > max_error {
                (max_error, worst) = (distance, k);
            }
            sum += distance * distance;
        }
        Ok(FittedCurve {
            met: self.goal.tolerance.is_none_or(|t| max_error <= t * (1.0 + 1e-12)),
            curve,
            max_error: self.frame.leave_length(max_error),
            worst,
            rms_error: self.frame.leave_length((sum / parameters.len() as f64).sqrt()),
            parameters,
            tolerance: self.goal.tolerance.map(|t| self.frame.leave_length(t)),
            iterations: self.iterations,
            condition: state.condition,
            interpolated: state.interpolated,
            closing_point_dropped,
            kept: state.kept,
        })
    }
}
