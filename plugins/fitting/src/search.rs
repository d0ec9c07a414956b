//! The search behind a fit: rounds of least squares and new knots, without parameter corrections and with them.

use loftsman_kernel::edit::Constraint;
use loftsman_kernel::plugin::Observer;
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

use crate::error::{FitError, Result};
use crate::fit::Fit;
use crate::frame::Frame;
use crate::goal::Goal;
use crate::measure::{Course, LIMIT};
use crate::state::{State, better};

/// A correction that takes less than this share off the largest error is the last one with these knots.
pub(crate) const WORTHWHILE: f64 = 0.1;

/// How strongly a given number of vertices is straightened where it must be, as little as will do.
const STRAIGHTENED: [f64; 5] = [1e-8, 1e-6, 1e-4, 1e-2, 1.0];
/// Times that knots are spread anew with corrected parameters.
const POLISHED: usize = 3;

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
    /// The most parameter corrections in a round, for now.
    pub(crate) corrections: usize,
    /// Whether it is a piece between corners, which may have fewer points than the degree needs.
    pub(crate) piece: bool,
    pub(crate) iterations: usize,
    pub(crate) observer: &'a dyn Observer,
    pub(crate) regularization: f64,
    /// The length of the polygon of the points, and how much longer the curve may be because of constraints.
    pub(crate) polygon: f64,
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
            corrections: 0,
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
        let best = match self.searched() {
            // A polynomial of high degree on few places: interpolation by centripetal parameters, or of lower degree.
            Err(error @ (FitError::NoData { .. } | FitError::IllConditioned { .. }))
                if alone && !self.goal.limited =>
            {
                return self.through()?.ok_or(error);
            }
            other => other?,
        };
        let best = self.counted(best)?;
        if best.met && self.fit.smooth {
            let smooth = self.smoothed(best.clone())?;
            return Ok(if self.constraints_hold(&smooth)? { smooth } else { best });
        }
        if best.met || self.goal.limited {
            return Ok(best);
        }
        let other = if alone { self.through()? } else { self.relaxed()? };
        Ok(other.unwrap_or(best))
    }

    /// The best of three searches: one that keeps the parameters, one that corrects them on the knots which that has
    /// found, and one that corrects them from the first round on. Corrections on few knots leave parameters that are far
    /// from those of a good curve on many, which takes more knots then; but where the first parameters are poor
    /// (uneven points of a sharp nose), those are the better ones.
    fn searched(&mut self) -> Result<State> {
        let least = if self.fit.closed { 3 } else { self.fit.degree + 1 };
        let exact = self.goal.exact;
        let done = |s: &Result<State>| s.as_ref().is_ok_and(|s| s.met && !exact && s.space.len() <= least);
        self.corrections = 0;
        let plain = self.placed();
        if self.fit.corrections == 0 || done(&plain) {
            return plain;
        }
        self.corrections = self.fit.corrections;
        let best = match plain {
            Err(FitError::Cancelled) => return Err(FitError::Cancelled),
            Ok(plain) if plain.met => match self.polished(plain.clone()) {
                Err(FitError::Cancelled) => return Err(FitError::Cancelled),
                polished => Ok(polished.unwrap_or(plain)),
            },
            other => other,
        };
        if done(&best) {
            return best;
        }
        let asked = self.goal.vertices;
        if let (Ok(State { met: true, space, .. }), false) = (&best, exact) {
            // As many are of no use any more.
            self.goal.vertices = space.len() - 1;
        }
        let corrected = self.placed();
        self.goal.vertices = asked;
        match (best, corrected) {
            (_, Err(FitError::Cancelled)) => Err(FitError::Cancelled),
            (Ok(best), Err(_)) => Ok(best),
            (Err(_), corrected) => corrected,
            (Ok(best), Ok(corrected)) if exact && best.met == corrected.met => {
                self.preferred(best, corrected)
            }
            (Ok(best), Ok(corrected)) => Ok(better(Some(best), corrected)),
        }
    }

    /// One search: rounds that place knots where they are needed, then other places for them.
    fn placed(&mut self) -> Result<State> {
        let mut best = self.rounds()?;
        if self.corrections == 0 {
            best = self.evened(best)?;
        }
        if best.met {
            best = self.regraded(best)?;
        }
        self.held(best)
    }

    /// A state that meets the goal, its parameters corrected and its knots spread anew for as long as that helps.
    fn polished(&mut self, plain: State) -> Result<State> {
        let mut best = plain;
        if self.goal.exact {
            let corrected = self.corrected(best.clone())?;
            best = self.preferred(best, State { met: true, ..corrected })?;
        }
        for _ in 0..POLISHED {
            let before = best.clone();
            best = self.regraded(best)?;
            let nearer = self.goal.exact && best.error() < (1.0 - WORTHWHILE) * before.error();
            if best.space.len() >= before.space.len() && !nearer {
                break;
            }
        }
        self.held(best)
    }

    /// A state whose constraints do not hold in document coordinates, where they will be measured, is not sound.
    fn held(&self, state: State) -> Result<State> {
        let holds = self.constraints_hold(&state)?;
        Ok(State { met: state.met && holds, sound: state.sound && holds, ..state })
    }

    fn constraints_hold(&self, state: &State) -> Result<bool> {
        if self.fit.constraints.is_empty() {
            return Ok(true);
        }
        let points: Vec<Point> = self.points.iter().map(|&p| self.frame.leave(p)).collect();
        let curve = Curve::new(state.space.clone(), self.frame.raise(&state.vertices)?)?;
        match state.held.clone().measured(&curve, &points) {
            Err(FitError::Missed { .. }) => Ok(false),
            other => other.map(|_| true),
        }
    }

    /// Where a tolerance is not met with at most so many vertices: the nearest curve with as many, which may meet it.
    fn counted(&mut self, best: State) -> Result<State> {
        let asked = self.goal;
        if best.met || asked.tolerance.is_none() || !asked.limited || asked.exact {
            return Ok(best);
        }
        self.goal = Goal { tolerance: None, exact: true, ..asked };
        let found = self.searched();
        self.goal = asked;
        match found {
            Err(FitError::Cancelled) => Err(FitError::Cancelled),
            Err(_) => Ok(best),
            Ok(found) => {
                let sound = self.follows(&found, &LIMIT)?;
                let met = sound && self.goal.holds(found.error());
                Ok(better(Some(best), State { sound, met, ..found }))
            }
        }
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
                Some(space) => self.sound_round(&space, &state.sites),
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
            let tried = self.round(&even, self.start);
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
    fn sound_round(&mut self, space: &Space, sites: &[f64]) -> Result<State> {
        let first = self.round(space, sites);
        let again = match &first {
            Ok(state) => !state.sound,
            Err(error) => matches!(error, FitError::NoData { .. } | FitError::IllConditioned { .. }),
        };
        if !again || sites == self.start {
            return first;
        }
        match self.round(space, self.start) {
            Ok(second) if second.sound || first.is_err() => Ok(second),
            Err(FitError::Cancelled) => Err(FitError::Cancelled),
            _ => first,
        }
    }
}
