//! The least energy between bounds: found, sharpened, and made the nearest of its kind.
//!
//! Where the least energy under the equations alone keeps to the bounds, that is it. Else proximal steps ([`Convex`]) find which
//! bounds hold with equality; with these as equations the search of equations alone gives the answer to rounding, and
//! what it says of its multipliers (none pulls the wrong way) and of the other bounds (all hold) proves that it is the least: the
//! conditions of Karush, Kuhn and Tucker. What no energy and no bound that carries something decides is decided by nearness
//! to the shape as it was.

use loftsman_kernel::Vector;
use loftsman_kernel::edit::{Constraint, EditError};
use loftsman_kernel::shape::{Shape, grid_or_row};
use loftsman_kernel::solve::SolveError;

use crate::active::{Failure, Row};
use crate::bounds::Bound;
use crate::convex::{Convex, nearest_along};
use crate::damped::Damped;
use crate::fair::Faired;
use crate::minimise::Search;
use crate::problem::{Least, Problem, Stage};
use crate::within::DistanceLimit;

/// Proximal steps before the last one's answer must do.
const STEPS: usize = 40;
/// A step that gains less than this part of the energy is the last.
const GAIN: f64 = 1e-12;
/// The same where tethers still move.
const ROUGHLY: f64 = 1e-7;
/// A multiplier below this part of the largest is none.
const IDLE: f64 = 1e-9;
/// A violation below this, relative to the numbers at hand, is rounding.
const MET: f64 = 32.0 * f64::EPSILON;
/// The most numbers of motions that are looked along for the nearest shape.
const MOTIONS: usize = 20_000_000;

/// A problem with bounds.
pub(crate) struct Between<'a, S> {
    pub(crate) problem: &'a Problem<'a, S>,
    /// The equations alone.
    pub(crate) plain: &'a Stage,
    pub(crate) bounds: &'a [Bound],
    /// Everything, as it was asked.
    pub(crate) asked: &'a [Constraint],
    pub(crate) equations: &'a [Constraint],
}

/// An answer: a shape, and the multiplier of each bound.
struct Answer {
    least: Least,
    pushes: Vec<f64>,
}

impl<S: Shape + Clone> Between<'_, S> {
    /// The shape of least energy.
    ///
    /// # Errors
    /// When the bounds contradict each other or the equations, naming them; when no shape is within the distance.
    pub(crate) fn solve(&self) -> Result<Faired<S>, EditError> {
        let problem = self.problem;
        let limit =
            problem.fair.within.map(|r| DistanceLimit::new(&problem.rest, r, &problem.free)).transpose()?;
        let rows = self.rows()?;
        let mut answer = self.unbounded(&rows)?;
        if answer.is_none() {
            answer = Some(self.least(&rows)?);
        }
        if let (Some(limit), Some(found)) = (&limit, &answer)
            && limit.farthest(&found.least.x).0 > limit.radius
        {
            answer = Some(self.within(&rows, limit)?);
        }
        match answer {
            Some(Answer { least, pushes }) => problem.hand_out(self.plain, &least, self.bounds, &pushes),
            None => Err(problem.beyond()),
        }
    }

    /// The rows of the equations, then those of the bounds.
    fn rows(&self) -> Result<Vec<Row>, EditError> {
        let problem = self.problem;
        let shapes = problem.among(&problem.fair.shape);
        let mut rows = problem.rows(self.plain);
        for bound in self.bounds {
            rows.push(bound.row(&shapes, &problem.rest, &problem.free)?);
        }
        Ok(rows)
    }

    /// The least energy under the equations alone, where that keeps to the bounds.
    fn unbounded(&self, rows: &[Row]) -> Result<Option<Answer>, EditError> {
        let Ok(least) = self.problem.least(self.plain, self.plain.x.clone(), None) else { return Ok(None) };
        let pushes = vec![0.0; self.bounds.len()];
        Ok(keeps(rows, &least.x).then_some(Answer { least, pushes }))
    }

    /// The least energy with some bounds in the way.
    fn least(&self, rows: &[Row]) -> Result<Answer, EditError> {
        let problem = self.problem;
        let first = rows.len() - self.bounds.len();
        let damped = problem.damped().ok_or_else(|| problem.beyond())?;
        let convex = Convex { squares: &problem.squares, damped, motions: problem.motions(), rows };
        let mut centre = problem.rest.clone();
        let (mut guess, mut energy) = (Vec::new(), f64::INFINITY);
        let mut tried: Vec<Vec<usize>> = Vec::new();
        for steps in 1..=STEPS {
            let found = convex.step(&centre, &guess).map_err(|stuck| self.stuck(&stuck))?;
            let mut active: Vec<usize> = found.active.iter().map(|row| row - first).collect();
            active.sort_unstable();
            if !tried.contains(&active) {
                if let Some(sharp) = self.sharpened(rows, &found.x, &active) {
                    return Ok(self.nearest(rows, sharp));
                }
                tried.push(active);
            }
            let (now, size) = problem.squares.energy(&found.x);
            if energy - now <= GAIN * now + f64::EPSILON * f64::EPSILON * size {
                let multipliers: Vec<f64> = found.multipliers.iter().map(|u| 2.0 * u).collect();
                let search = Search { steps, gap: (energy - now).max(0.0) / now.max(f64::MIN_POSITIVE) };
                let pushes = multipliers[first..].to_vec();
                let multipliers = self.plain.multipliers(&multipliers[..first]);
                let ways = problem.null_space(self.plain.system()).ways();
                let least = Least { x: found.x, search, ways, multipliers };
                return Ok(Answer { least, pushes });
            }
            (energy, centre, guess) = (now, found.x, found.active);
        }
        Err(SolveError::Unsupported(format!(
            "after {STEPS} steps the energy between {} bounds still falls: ask for fewer, or take an energy that is less stiff",
            self.bounds.len()
        ))
        .into())
    }

    /// The least energy with some bounds as equations, from a shape near to it: where it is the least with all bounds.
    fn sharpened(&self, rows: &[Row], x: &[Vector], active: &[usize]) -> Option<Answer> {
        let reached = active.iter().map(|&b| self.bounds[b].reached());
        let stage = self.problem.stage(self.equations.iter().cloned().chain(reached).collect()).ok()?;
        let mut least = self.problem.least(&stage, x.to_vec(), None).ok()?;
        if !keeps(rows, &least.x) {
            return None;
        }
        let count = self.equations.len();
        let mut pushes = vec![0.0; self.bounds.len()];
        for (k, &b) in active.iter().enumerate() {
            let push = least.multipliers.get(count + k).and_then(|m| m.first().copied()).unwrap_or(0.0);
            pushes[b] = self.bounds[b].sign() * push;
        }
        least.multipliers.drain(count..count + active.len());
        let strongest =
            least.multipliers.iter().flatten().chain(&pushes).fold(0.0_f64, |m, p| m.max(p.abs()));
        // Beside the forces that all but cancel at the least, a small one is rounding.
        let strain = self.problem.squares.strain(&least.x);
        for (b, push) in pushes.iter_mut().enumerate() {
            let row = &rows[rows.len() - self.bounds.len() + b];
            let rounding =
                IDLE * strongest + 1e-12 * strain / row.terms.iter().fold(0.0, |m: f64, (_, c)| m.hypot(*c));
            if *push < -rounding {
                return None;
            }
            if *push <= rounding {
                *push = 0.0;
            }
        }
        Some(Answer { least, pushes })
    }

    /// The nearest to the shape as it was of all shapes of an answer's energy. Bounds that carry something hold with equality for
    /// all of them; the others may be reached on the way.
    fn nearest(&self, rows: &[Row], mut answer: Answer) -> Answer {
        let problem = self.problem;
        if problem.motions().is_empty() {
            return answer;
        }
        let first = rows.len() - self.bounds.len();
        let carrying = (0..self.bounds.len()).filter(|&b| answer.pushes[b] != 0.0);
        let reached = carrying.map(|b| self.bounds[b].reached());
        let Ok(stage) = problem.stage(self.equations.iter().cloned().chain(reached).collect()) else {
            return answer;
        };
        let null_space = problem.null_space(stage.system());
        answer.least.ways = null_space.ways();
        if null_space.ways() == 0 || null_space.ways() * 3 * problem.rest.len() > MOTIONS {
            return answer;
        }
        let motions: Vec<Vec<Vector>> = null_space.all().collect();
        let rest: Vec<Row> = (0..self.bounds.len())
            .filter(|&b| answer.pushes[b] == 0.0)
            .map(|b| rows[first + b].clone())
            .collect();
        if let Ok(found) = nearest_along(&motions, &answer.least.x, &problem.rest, &rest)
            && keeps(rows, &found.x)
        {
            answer.least.x = found.x;
        }
        answer
    }

    /// The least energy within a distance, too: with tethers in place of the distance it is a problem with bounds alone, and its
    /// shape is drawn back towards one that is inside, as far as it must be.
    fn within(&self, rows: &[Row], limit: &DistanceLimit<'_>) -> Result<Answer, EditError> {
        let problem = self.problem;
        let first = rows.len() - self.bounds.len();
        let mut x = problem.inside(limit, self.plain, self.bounds)?;
        let grid = grid_or_row(problem.fair.shape.as_shape());
        let mut squares = problem.squares.clone();
        let (mut guess, mut last) = (Vec::new(), Vec::new());
        let mut solve = |tethers: &[f64], x: &mut [Vector]| {
            squares.tether(tethers, &problem.rest);
            let Some(damped) = Damped::new(&squares, &problem.free, &grid) else { return Ok(None) };
            let convex = Convex { squares: &squares, damped: &damped, motions: &[], rows };
            let mut energy = f64::INFINITY;
            for steps in 1..=STEPS {
                let found = convex.step(x, &guess).map_err(|stuck| self.stuck(&stuck))?;
                x.copy_from_slice(&found.x);
                (guess, last) = (found.active, found.multipliers);
                let now = squares.energy(x).0;
                if energy - now <= ROUGHLY * now {
                    return Ok(Some(steps));
                }
                energy = now;
            }
            Ok(Some(STEPS))
        };
        let safe = x.clone();
        let search = match limit.minimise(&problem.squares, &mut solve, &mut x) {
            Ok(search) => search,
            Err(told) => {
                x = safe;
                let (search, multipliers) = problem.cut(limit, rows, &mut x).ok_or(told)?;
                last = multipliers.iter().map(|u| 0.5 * u).collect();
                search
            }
        };
        last.resize(rows.len(), 0.0);
        last.iter_mut().for_each(|u| *u *= 2.0);
        let multipliers = self.plain.multipliers(&last[..first]);
        let pushes = last[first..].to_vec();
        Ok(Answer { least: Least { x, search, ways: 0, multipliers }, pushes })
    }

    /// Why there is no answer: the kernel knows the bounds as such, and names those that contradict each other.
    fn stuck(&self, stuck: &Failure) -> EditError {
        let told = self
            .problem
            .fair
            .edit(self.asked.to_vec())
            .solve_with(std::sync::Arc::clone(&self.problem.solver));
        let count = self.bounds.len();
        told.err().unwrap_or_else(|| {
            let why = match stuck {
                Failure::Contradiction => "they nearly depend on each other",
                Failure::Work => "there are too many",
            };
            SolveError::Unsupported(format!(
                "which of {count} bounds hold with equality at the least energy could not be decided: {why}; ask for fewer, or \
                 less at once"
            ))
            .into()
        })
    }
}

/// Whether a shape keeps to all rows.
fn keeps(rows: &[Row], x: &[Vector]) -> bool {
    rows.iter().filter(|row| !row.equation).all(|row| {
        let (missing, size) = row.missing(x);
        missing <= MET * size
    })
}
