//! Fits in pieces between corners, and the curve that is handed out, measured.

use std::ops::Range;

use loftsman_kernel::edit::{Ask, Constraint};
use loftsman_kernel::functional::position;
use loftsman_kernel::measure;
use loftsman_kernel::plugin::Observer;
use loftsman_kernel::shape::Location;
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

use crate::constraint::Holding;
use crate::error::{FitError, Result};
use crate::fit::{Fit, FittedCurve};
use crate::frame::Frame;
use crate::goal::Goal;
use crate::measure::{Course, LIMIT};
use crate::search::Search;
use crate::state::State;

const ADVICE: &str = "fit with corners, to another tolerance, with fewer control vertices, a lower degree, or centripetal parameters";

const NOT_MET: &str =
    "allow a larger tolerance or more vertices, hold fewer constraints, or ask for a best effort";

/// All that a fit is about, in local coordinates.
pub(crate) struct Whole<'a> {
    pub(crate) fit: &'a Fit,
    pub(crate) frame: &'a Frame,
    pub(crate) points: &'a [Vector],
    /// A parameter for each point; around a closed curve one more.
    pub(crate) sites: &'a [f64],
    pub(crate) weights: Option<&'a [f64]>,
    pub(crate) goal: Goal,
    pub(crate) observer: &'a dyn Observer,
}

/// What a search found.
pub(crate) struct Found {
    pub(crate) state: State,
    pub(crate) allowance: f64,
    pub(crate) iterations: usize,
}

impl Whole<'_> {
    /// The best curve; `corners` ascend and are inside an open chain.
    pub(crate) fn search(&self, corners: &[usize]) -> Result<Found> {
        if !corners.is_empty() {
            return self.in_pieces(corners);
        }
        let Self { fit, frame, points, sites, weights, goal, observer } = *self;
        let kept = [!fit.closed && fit.keep_ends; 2];
        let constraints = self.with_ends(&fit.constraints, kept, 0..points.len(), sites);
        let mut search = Search::new(fit, frame, points, sites, weights, constraints, goal, observer);
        let state = search.run()?;
        Ok(Found { state, allowance: search.allowance, iterations: search.iterations })
    }

    /// A fit for each piece, made into one.
    fn in_pieces(&self, corners: &[usize]) -> Result<Found> {
        let cuts = self.cuts(corners);
        let counts = self.shared_out(&cuts)?;
        let mut constraints = self.assigned(&cuts)?;
        let (mut states, mut allowance, mut iterations) = (Vec::new(), 0.0, 0);
        for (i, cut) in cuts.iter().enumerate() {
            let points: Vec<Vector> = cut.range.clone().map(|k| self.points[self.index(k)]).collect();
            let weights: Option<Vec<f64>> =
                self.weights.map(|w| cut.range.clone().map(|k| w[self.index(k)]).collect());
            let own = std::mem::take(&mut constraints[i]);
            let fit = Fit { closed: false, constraints: own.clone(), ..self.fit.clone() };
            let goal = match counts.as_ref() {
                Some(counts) => Goal { vertices: counts[i], exact: true, limited: true, ..self.goal },
                None => Goal { vertices: points.len(), exact: false, limited: false, ..self.goal },
            };
            let last = cuts.len() - 1;
            let kept = [(0, 0), (1, last)].map(|(_, end)| self.fit.closed || i != end || self.fit.keep_ends);
            let held = self.with_ends(&own, kept, cut.range.clone(), &cut.sites);
            let mut search = Search::new(
                &fit,
                self.frame,
                &points,
                &cut.sites,
                weights.as_deref(),
                held,
                goal,
                self.observer,
            );
            search.piece = true;
            let mut state = search.run()?;
            // Pieces meet in the corners to the last bit; an end of the whole that a constraint puts elsewhere stays there.
            let end = state.vertices.len() - 3;
            let elsewhere = [cut.sites[0], cut.sites[points.len() - 1]].map(|u| is_asked(&own, u));
            if kept[0] && !elsewhere[0] {
                state.vertices[..3].copy_from_slice(points[0].as_slice());
            }
            if kept[1] && !elsewhere[1] {
                state.vertices[end..].copy_from_slice(points[points.len() - 1].as_slice());
            }
            allowance += search.allowance;
            iterations += search.iterations;
            states.push(state);
        }
        let state = self.joined(&cuts, states)?;
        if self.goal.limited && !self.goal.exact && state.space.len() > self.goal.vertices {
            return Err(FitError::Request(format!(
                "the tolerance needs {} control vertices between {} corners: allow as many, or a larger tolerance",
                state.space.len(),
                corners.len()
            )));
        }
        Ok(Found { state, allowance, iterations })
    }

    /// A point's index, where those behind the last one of a closed chain are the first again.
    fn index(&self, k: usize) -> usize {
        k % self.points.len()
    }

    /// The ranges of points between corners with their parameters. The last piece of a closed chain goes on behind
    /// its end; the first starts with the first corner.
    fn cuts(&self, corners: &[usize]) -> Vec<Cut> {
        let m = self.points.len();
        let mut ends = corners.to_vec();
        if self.fit.closed {
            ends.push(corners[0] + m);
        } else {
            ends.insert(0, 0);
            ends.push(m - 1);
        }
        let period = self.sites[self.sites.len() - 1] - self.sites[0];
        let site = |k: usize| if k < m { self.sites[k] } else { self.sites[k - m] + period };
        ends.windows(2)
            .map(|w| Cut { range: w[0]..w[1] + 1, sites: (w[0]..=w[1]).map(site).collect() })
            .collect()
    }

    /// The constraints, and the ends that are to be kept and not asked for anyway.
    fn with_ends(
        &self,
        own: &[Constraint],
        kept: [bool; 2],
        range: Range<usize>,
        sites: &[f64],
    ) -> Vec<Constraint> {
        let mut all = own.to_vec();
        let ends = [(sites[0], range.start), (sites[range.len() - 1], range.end - 1)];
        for ((u, k), kept) in ends.into_iter().zip(kept) {
            if kept && !is_asked(&all, u) {
                let point = self.frame.leave(self.points[self.index(k)]);
                all.push(position(u).to(point));
            }
        }
        all
    }

    /// Each constraint with the piece that it looks at.
    fn assigned(&self, cuts: &[Cut]) -> Result<Vec<Vec<Constraint>>> {
        let mut all = vec![Vec::new(); cuts.len()];
        for constraint in &self.fit.constraints {
            let refuse =
                |reason: &str| FitError::Constraint { name: constraint.describe(), reason: reason.into() };
            let Some(u) = place(constraint) else {
                return Err(refuse(
                    "it looks at the whole curve, which has corners: leave it or the corners out",
                ));
            };
            let inside = |cut: &Cut| u >= cut.sites[0] && u <= cut.sites[cut.sites.len() - 1];
            let mut homes = (0..cuts.len()).filter(|&i| inside(&cuts[i]));
            match (homes.next(), homes.next()) {
                (Some(i), None) => all[i].push(constraint.clone()),
                (Some(_), Some(_)) => {
                    return Err(refuse("it looks at a corner, which stays where its point is"));
                }
                (None, _) => {
                    return Err(refuse(&format!(
                        "with corners, the curve has the parameters {} to {}: give a place there",
                        cuts[0].sites[0],
                        cuts.last().and_then(|c| c.sites.last()).copied().unwrap_or(1.0)
                    )));
                }
            }
        }
        Ok(all)
    }

    /// How many vertices each piece gets, where their number is given: what it needs, and of the others a share by
    /// its number of points.
    fn shared_out(&self, cuts: &[Cut]) -> Result<Option<Vec<usize>>> {
        if !self.goal.exact {
            return Ok(None);
        }
        let p = self.fit.degree;
        let room: Vec<usize> = cuts.iter().map(|c| c.range.len().saturating_sub(p + 1)).collect();
        let most: usize = room.iter().sum();
        let least = p * cuts.len() + usize::from(!self.fit.closed);
        if self.goal.vertices < least || self.goal.vertices > least + most {
            return Err(FitError::Request(format!(
                "{} control vertices cannot be shared out between the corners: choose from {least} to {}",
                self.goal.vertices,
                least + most
            )));
        }
        let extra = self.goal.vertices - least;
        // Shares of the running sum, rounded down: they add up, and none exceeds its room.
        let (mut before, mut given) = (0, 0);
        let counts = room.iter().map(|r| {
            before += r;
            let upto = (extra * before).checked_div(most).unwrap_or(0);
            let own = upto - given;
            given = upto;
            p + 1 + own
        });
        Ok(Some(counts.collect()))
    }

    /// The pieces as one curve, its knots `p` times at the corners.
    fn joined(&self, cuts: &[Cut], states: Vec<State>) -> Result<State> {
        let p = self.fit.degree;
        let (mut knots, mut vertices, mut held) = (Vec::new(), Vec::new(), Holding::default());
        let m = self.points.len();
        let (mut sites, mut distances) = (vec![0.0; m], vec![0.0_f64; m]);
        let mut remarks: Vec<String> = Vec::new();
        let (mut condition, mut met, mut sound, mut interpolated) = (1.0_f64, true, true, false);
        let period = self.sites[self.sites.len() - 1] - self.sites[0];
        let count = states.len();
        for (cut, state) in cuts.iter().zip(states) {
            let flat = state.space.knots();
            let inner = &flat[p + 1..flat.len() - p - 1];
            // The start p times; an open curve's very start and end once more.
            knots.extend(std::iter::repeat_n(flat[p], p));
            knots.extend_from_slice(inner);
            let skip = if vertices.is_empty() && !self.fit.closed { 0 } else { 3 };
            vertices.extend_from_slice(&state.vertices[skip..]);
            for (j, k) in cut.range.clone().enumerate() {
                let turned = if k >= m { period } else { 0.0 };
                // A corner is the end of one piece and the start of the next.
                let k = self.index(k);
                let again = self.fit.closed && turned > 0.0 && k == self.index(cuts[0].range.start);
                if !again {
                    sites[k] = state.sites[j] - turned;
                }
                distances[k] = distances[k].max(state.distances[j]);
            }
            held.extend(state.held);
            for remark in state.remarks {
                if !remarks.contains(&remark) {
                    remarks.push(remark);
                }
            }
            condition = condition.max(state.condition);
            (met, sound) = (met && state.met, sound && state.sound);
            interpolated |= state.interpolated && cut.range.len() > p + 1;
        }
        let (start, end) = (cuts[0].sites[0], cuts[count - 1].sites[cuts[count - 1].sites.len() - 1]);
        let space = if self.fit.closed {
            knots.push(end);
            Space::periodic(p, knots)?
        } else {
            knots.insert(0, start);
            knots.extend(std::iter::repeat_n(end, p + 1));
            Space::open(p, knots)?
        };
        let length = 0.0;
        Ok(State {
            space,
            vertices,
            sites,
            distances,
            condition,
            held,
            length,
            sound,
            met,
            interpolated,
            remarks,
        })
    }

    /// Back to document coordinates, with everything measured on the curve that is handed out.
    ///
    /// # Errors
    /// [`FitError::NotMet`] where the tolerance does not hold and no best effort was asked for; [`FitError::Astray`]
    /// where it does not travel as the points do.
    pub(crate) fn finish(
        &self,
        found: Found,
        points: &[Point],
        corners: Vec<usize>,
        closing_point_dropped: bool,
    ) -> Result<FittedCurve> {
        let Found { state, allowance, iterations } = found;
        let m = self.points.len();
        let mut vertices = self.frame.raise(&state.vertices)?;
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
        parameters.truncate(m);
        let handed = self.frame.lower(&curve)?;
        // A closed curve with corners starts in the first of them: so does its course.
        let first = if self.fit.closed { corners.first().copied().unwrap_or(0) } else { 0 };
        let period = if self.fit.closed { curve.space().length() } else { 0.0 };
        let turned: Vec<Vector> = (first..first + m).map(|k| self.points[k % m]).collect();
        let sites: Vec<f64> =
            (first..first + m).map(|k| parameters[k % m] + if k >= m { period } else { 0.0 }).collect();
        let at: Vec<usize> = corners.iter().map(|c| c - first).collect();
        let course = Course { points: &turned, sites: &sites, closed: self.fit.closed, corners: &at };
        let distances = course.distances(&handed)?;
        let worst = (0..m).fold(0, |w, k| if distances[k] > distances[w] { k } else { w });
        let travel = course.travelled(&handed, distances[worst])?;
        let within =
            |t: f64| measure::Error { error: distances[worst], allowed: t * (1.0 + measure::ITERATED) };
        let met = self.goal.tolerance.is_none_or(|t| within(t).holds());
        if !met && !self.fit.best_effort {
            return Err(FitError::NotMet {
                tolerance: self.frame.leave_length(self.goal.tolerance.unwrap_or(0.0)),
                error: self.frame.leave_length(distances[worst]),
                worst: (worst + first) % m,
                vertices: curve.points().len(),
                advice: NOT_MET,
            });
        }
        let astray = travel.trouble(&LIMIT, allowance, !self.fit.constraints.is_empty());
        if let Some(astray) = astray.map_or_else(|| course.outside(&handed, allowance), |a| Ok(Some(a)))? {
            return Err(FitError::Astray { astray: astray.renumbered(|k| (k + first) % m), advice: ADVICE });
        }
        let mean = distances.iter().map(|d| d * d).sum::<f64>() / m as f64;
        let leave = |length: f64| self.frame.leave_length(length);
        let (distance, farthest) = course.farthest(&handed, &distances)?;
        Ok(FittedCurve {
            met,
            max_error: leave(distances[worst]),
            distance: leave(distance),
            farthest: (farthest + first) % m,
            worst: (worst + first) % m,
            rms_error: leave(mean.sqrt()),
            length: leave(travel.length),
            polygon_length: leave(travel.polygon),
            corners,
            scatter: None,
            remarks: state.remarks,
            parameters,
            tolerance: self.goal.tolerance.map(leave),
            iterations,
            condition: state.condition,
            interpolated: state.interpolated,
            closing_point_dropped,
            kept: state.held.measured(&curve, points)?,
            curve,
        })
    }
}

/// Whether constraints ask for the position at a parameter.
fn is_asked(constraints: &[Constraint], u: f64) -> bool {
    constraints.iter().any(|c| c.narrowed().is_none() && c.functional().same_as(&position(u)))
}

/// The parameter at which a constraint looks, where it is one.
pub(crate) fn place(constraint: &Constraint) -> Option<f64> {
    match constraint.functional().location()? {
        (0, Location::Curve(u)) => Some(u),
        _ => None,
    }
}

/// The points of a piece (those from the number of points on are the first again) and their parameters.
struct Cut {
    range: Range<usize>,
    sites: Vec<f64>,
}
