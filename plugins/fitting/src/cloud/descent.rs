//! The steps of a fit.

use loftsman_kernel::edit::EditError;
use loftsman_kernel::energy::{Energy, Squares};
use loftsman_kernel::functional::Shapes;
use loftsman_kernel::plugin::Observer;
use loftsman_kernel::problem::{Problem, Solution};
use loftsman_kernel::shape::{Shape, vertex_index};
use loftsman_kernel::solve::Solver;
use loftsman_kernel::{Point, Vector};

use super::foot::{Foot, feet};
use super::merged::merged;
use super::model::{Model, value};
use super::patches::Patches;
use super::sliding::Sliding;
use super::step::{COARSE, Held, Metric, SMALL};
use super::weight::{EACH, ROUGH, weighed};
use super::{CloudFit, CloudFitted, CloudReport};
use crate::error::{FitError, Result};
use crate::least_squares::check_weights;

/// How much feet are held back: at first, at least, and how fast that changes.
const FIRST: f64 = 0.1;
const LEAST: f64 = 1e-6;
const FACTOR: f64 = 10.0;
/// Parts of what a model promised below which feet are held back more, and above which less.
const POOR: f64 = 0.25;
const GOOD: f64 = 0.5;
/// A step that promises this part of what is there, and no more, is the last.
pub(super) const GAIN: f64 = 1e-10;
/// How much a shape is held where a step would take it too far, beside points of weight 1: at first, how much more each time, and at most.
const STILL: (f64, f64, f64) = (1e-10, 10.0, 1.0);
/// A step of which no more than this part stays within reach is none.
const WITHIN: f64 = 1e-3;
/// How often the noise that a shape is held by is measured anew, and the part by which it may be off.
const STEADYINGS: usize = 8;
const ALIKE: f64 = 0.05;
/// What rounding takes from distances, of the size of all numbers.
pub(super) const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// A shape on the way, its feet and what is to be small.
pub(super) struct State<S> {
    pub(super) shape: S,
    pub(super) feet: Vec<Foot>,
    order: Vec<u32>,
}

/// Where steps came to.
pub(super) struct Descended<S> {
    pub(super) state: State<S>,
    pub(super) report: CloudReport,
    /// Whether steps ended because they no longer promised enough.
    pub(super) settled: bool,
    /// How much feet were held back in the end.
    tau: f64,
    pub(super) multipliers: Vec<f64>,
}

pub(super) fn fit<S: Shape + Clone>(
    asked: &CloudFit<S>,
    points: &[Point],
    solver: &dyn Solver,
    observer: &dyn Observer,
) -> Result<CloudFitted<S>> {
    let shares = checked(asked, points)?;
    let mut run = Run::new(asked, points, shares, solver, observer)?;
    let Some(fair) = asked.fair else { return run.steadied(asked.iterations) };
    let shape = asked.shape.as_shape();
    let Some(squares) = fair.squares(shape, run.origin)? else { return run.steadied(asked.iterations) };
    squares.check(shape.control_vertices().len())?;
    weighed(&mut run, merged(squares, shape.control_vertices().len()))
}

pub(super) struct Run<'a, S> {
    pub(super) asked: &'a CloudFit<S>,
    pub(super) points: Vec<Point>,
    pub(super) shares: Vec<f64>,
    pub(super) solver: &'a dyn Solver,
    pub(super) observer: &'a dyn Observer,
    pub(super) energies: Vec<(f64, Squares)>,
    origin: Point,
    /// How far the shape slides along itself, and how much it is held from it.
    sliding: Option<Sliding>,
    along: f64,
    pub(super) patches: Patches,
    pub(super) problem: Problem,
    pub(super) nearest: Solution,
    pub(super) held: Held,
}

impl<'a, S: Shape + Clone> Run<'a, S> {
    fn new(
        asked: &'a CloudFit<S>,
        points: &[Point],
        shares: Vec<f64>,
        solver: &'a dyn Solver,
        observer: &'a dyn Observer,
    ) -> Result<Self> {
        let shape = asked.shape.as_shape();
        let vertices = shape.control_vertices();
        let origin = vertices.first().copied().unwrap_or_else(Point::origin);
        let mut energies = Vec::new();
        for (weight, energy) in &asked.energies {
            if !(*weight > 0.0 && weight.is_finite()) {
                let what = energy.describe();
                return Err(FitError::Request(format!(
                    "the weight of the energy \"{what}\" is {weight}: give a positive, finite number, or leave it out"
                )));
            }
            let squares = energy.squares(shape, origin)?.ok_or_else(|| {
                let what = energy.describe();
                FitError::Request(format!(
                    "\"{what}\" is known by its matrix alone, and a fit works with squares"
                ))
            })?;
            squares.check(vertices.len())?;
            energies.push((*weight, merged(squares, vertices.len())));
        }
        let patches = Patches::new(shape)?;
        let sliding = Sliding::new(&patches, vertices, origin);
        let problem = asked.edit().problem()?;
        if let Some(functional) = problem.nonlinear() {
            return Err(FitError::Constraint {
                name: functional.describe(),
                reason: "it is not linear in the control vertices: edit the fitted shape under it afterwards"
                    .into(),
            });
        }
        // What conflicts is named here; the nearest shape that meets all is where the search starts.
        let nearest = problem.solve(solver)?;
        let mut free = vec![true; vertices.len()];
        for &lock in &asked.locks {
            free[vertex_index(lock, vertices.len())?] = false;
        }
        let free = (0..free.len()).filter(|&v| free[v]).collect();
        let held = Held::new(nearest.assembly().system(), free, vertices.len());
        Ok(Self {
            asked,
            points: points.to_vec(),
            shares,
            solver,
            observer,
            energies,
            origin,
            sliding,
            along: 0.0,
            patches,
            problem,
            nearest,
            held,
        })
    }

    pub(super) fn size(&self) -> f64 {
        diagonal(&self.points).max(diagonal(self.asked.shape.control_vertices()))
    }

    /// The diagonal of the box of the points and of the shape as it was given.
    fn room(&self) -> f64 {
        diagonal(self.points.iter().chain(self.asked.shape.control_vertices()))
    }

    /// From the shape as it is, in so many steps at most, held from sliding along itself as much as the noise calls for where that is asked.
    fn steadied(&mut self, most: usize) -> Result<CloudFitted<S>> {
        let (mut last, mut steps, mut before) = (None, 0, 0.0);
        if self.asked.steady && self.sliding.is_some() {
            let mut noise = self.noise_within(&self.state(self.asked.shape.clone(), None)?);
            for round in 0..STEADYINGS {
                self.hold_along(noise);
                let found = self.descended(last.as_ref(), EACH.min(most - steps), ROUGH)?;
                before = if round == 0 { found.report.before } else { before };
                steps += found.report.iterations;
                let now = self.noise_within(&found.state);
                let known = (now - noise).abs() <= ALIKE * noise;
                noise = now;
                last = Some(found);
                if known || steps >= most {
                    break;
                }
            }
            self.hold_along(noise);
        }
        let mut found = self.descended(last.as_ref(), most - steps, GAIN)?;
        found.report.iterations += steps;
        found.report.before = if last.is_some() { before } else { found.report.before };
        self.hand_out(found)
    }

    /// The same, or from where steps came to before, not yet measured; a step that promises no more than the part `enough` of what is there is the last.
    pub(super) fn descended(
        &self,
        from: Option<&Descended<S>>,
        most: usize,
        enough: f64,
    ) -> Result<Descended<S>> {
        let (size, room) = (self.size(), self.room());
        let mut report = CloudReport::default();
        let mut state = match from {
            Some(before) => self.state(before.state.shape.clone(), Some(&before.state))?,
            None => {
                let before = self.state(self.asked.shape.clone(), None)?;
                report.before = self.value(&before).0.sqrt();
                let start = self.begin();
                let moved = start.control_vertices() != before.shape.control_vertices();
                if moved { self.state(start, None)? } else { before }
            }
        };
        let small = if enough > GAIN { COARSE } else { SMALL };
        let mut tau = from.map_or(FIRST, |before| before.tau);
        let begin = self.patches.points(self.begin().control_vertices());
        let (mut multipliers, mut settled) = (Vec::new(), self.held.free.is_empty());
        while report.iterations < most && !settled {
            self.observer
                .proceed("fit", report.iterations as u64, most as u64)
                .map_err(|_| FitError::Cancelled)?;
            let mut model = self.model(&state)?;
            let x = self.relative(&state.shape);
            let (squares, energy) = self.value(&state);
            let mut gradient = vec![Vector::zeros(); x.len()];
            model.gradient(&x, &mut gradient);
            let mut metric = Metric::new(&model, &self.held, self.solver)?;
            multipliers = metric.multipliers(&gradient);
            // Nothing is held but where steps before had to be.
            let mut still = None::<f64>;
            let (next, change, gain) = loop {
                let (mut way, share) = loop {
                    let way = metric.least(&model, tau, &gradient, small);
                    let share = self.patches.within(&begin, state.shape.control_vertices(), &way, room);
                    let more = still.map_or(STILL.0, |by| by * STILL.1);
                    if share >= 1.0 || more > STILL.2 {
                        break (way, share);
                    }
                    still = Some(more);
                    model.hold(more, self.patches.still(x.len()));
                    metric = Metric::new(&model, &self.held, self.solver)?;
                };
                way.iter_mut().for_each(|d| *d *= share);
                let change =
                    (0..model.rows.len()).map(|k| model.rows.sum(k, &way).norm()).fold(0.0, f64::max);
                // What the model promises, without what holds the shape: dᵀHd = -gᵀd where it is least, and of a part s of that way 2s - s² times as much.
                let gain = -gradient.iter().zip(&way).map(|(g, d)| g.dot(d)).sum::<f64>() * (2.0 - share)
                    + model.held(&way);
                report.at_reach = still.is_some();
                if share < WITHIN {
                    break (None, change, gain);
                }
                let next = self.state(self.moved(&state.shape, &way, &mut metric)?, Some(&state))?;
                let (then, after) = self.value(&next);
                // Of sums, as below: what one rounds to a gain and the other to none would be tried again for ever.
                let (kept, held) = ((squares + energy - (then + after)) / gain, tau);
                if !(gain > 0.0 && kept >= POOR) {
                    tau = f64::min(1.0, FACTOR * tau);
                } else if kept > GOOD {
                    tau = f64::max(LEAST, tau / FACTOR);
                }
                // Feet that are looked for again may come nearer by rounding alone.
                if gain > 0.0 && then + after < squares + energy {
                    break (Some(next), change, gain);
                }
                if held >= 1.0 || gain > 0.0 && change <= ROUNDING * size {
                    break (None, change, gain);
                }
            };
            report.iterations += 1;
            report.change = change;
            // Where not even held feet bring it nearer, what is left is rounding.
            let promises = |part: f64| gain > part * (squares + energy);
            report.converged = next.is_none() || !promises(GAIN) || change <= self.asked.tolerance * size;
            settled = report.converged || !promises(enough);
            report.converged &= !report.at_reach;
            state = next.unwrap_or(state);
        }
        report.converged |= self.held.free.is_empty();
        Ok(Descended { state, report, settled, tau, multipliers })
    }

    /// The same, or nothing where vertices are open.
    pub(super) fn descended_if_determined(
        &self,
        from: Option<&Descended<S>>,
        most: usize,
        enough: f64,
    ) -> Result<Option<Descended<S>>> {
        match self.descended(from, most, enough) {
            Err(FitError::Undetermined { .. }) => Ok(None),
            other => other.map(Some),
        }
    }

    /// What steps can begin from that other points led to.
    pub(super) fn begun(&self, shape: S) -> Result<Descended<S>> {
        let (report, multipliers) = (CloudReport::default(), Vec::new());
        Ok(Descended { state: self.state(shape, None)?, report, settled: false, tau: FIRST, multipliers })
    }

    /// The shape as it was given, moved to where constraints hold.
    pub(super) fn begin(&self) -> S {
        let mut start = self.asked.shape.clone();
        let vertices = start.control_vertices_mut();
        for (vertex, way) in self.nearest.adjustments() {
            if let Some(vertex) = vertices.get_mut(vertex) {
                *vertex += way;
            }
        }
        start
    }

    /// A shape with its feet, looked for from those of a state before where there is one.
    pub(super) fn state(&self, shape: S, before: Option<&State<S>>) -> Result<State<S>> {
        if let Some(vertex) = shape
            .control_vertices()
            .iter()
            .position(|p| p.iter().any(|c| !(c.is_finite() && c.abs() < 1e150)))
        {
            return Err(FitError::Request(format!(
                "control vertex {vertex} is {:?}, which no distance can be measured from: give finite numbers of a usual size",
                shape.control_vertices()[vertex].coords.as_slice()
            )));
        }
        let cancelled = || self.observer.cancelled();
        let known = before.map(|before| (before.feet.as_slice(), before.order.as_slice()));
        let found = feet(shape.as_shape(), &self.patches, &self.points, known, &cancelled)?;
        let (feet, order) = found.ok_or(FitError::Cancelled)?;
        Ok(State { shape, feet, order })
    }

    pub(super) fn model<'b>(&'b self, state: &'b State<S>) -> Result<Model<'b>> {
        let shape = state.shape.as_shape();
        let mut model = Model::new(shape, &state.feet, &state.order, &self.shares, &self.energies)?;
        model.hold_along(self.held_along());
        Ok(model)
    }

    /// The mean square of the distances of points that the shape does not end before: what is beyond its border says where it should end, and is no noise.
    pub(super) fn noise_within(&self, state: &State<S>) -> f64 {
        let free = [true, state.shape.domain().len() > 1];
        let within = || state.feet.iter().zip(&self.shares).filter(|(foot, _)| foot.free == free);
        let sum: f64 = within().map(|(foot, share)| share * foot.distance * foot.distance).sum();
        let part: f64 = within().map(|(_, share)| share).sum();
        if part > 0.0 { sum / part } else { 0.0 }
    }

    /// Holds the shape from sliding along itself as much as noise of this variance calls for.
    pub(super) fn hold_along(&mut self, noise: f64) {
        // Less than rounding makes is none.
        let noise = if noise > (ROUNDING * self.size()).powi(2) { noise } else { 0.0 };
        self.along = self.sliding.as_ref().map_or(0.0, |sliding| sliding.weight(noise, self.points.len()));
    }

    fn held_along(&self) -> Option<(f64, &Sliding)> {
        self.sliding.as_ref().filter(|_| self.along > 0.0).map(|sliding| (self.along, sliding))
    }

    /// The mean square of the distances, and what the energies come to.
    pub(super) fn value(&self, state: &State<S>) -> (f64, f64) {
        let x = self.relative(&state.shape);
        let (squares, energy) = value(&state.feet, &self.shares, &self.energies, &x);
        let held = self.held_along().map_or(0.0, |(by, sliding)| by * sliding.value(&x));
        (squares, energy + held)
    }

    /// What is to be small, all of it.
    pub(super) fn sum(&self, found: &Descended<S>) -> f64 {
        let (squares, energy) = self.value(&found.state);
        squares + energy
    }

    /// The area of a surface, or the length of a curve.
    pub(super) fn measure(&self, shape: &S) -> f64 {
        self.patches.measure(shape.control_vertices())
    }

    /// The control vertices as the energies see them.
    pub(super) fn relative(&self, shape: &S) -> Vec<Vector> {
        shape.control_vertices().iter().map(|p| p - self.origin).collect()
    }

    pub(super) fn among<'b>(&'b self, shape: &'b S) -> Shapes<'b> {
        Shapes::new(std::iter::once(shape.as_shape()).chain(self.asked.others.iter().map(AsRef::as_ref)))
    }

    /// The shape moved, and what rounding took from the equations put right.
    fn moved(&self, shape: &S, way: &[Vector], metric: &mut Metric<'_>) -> Result<S> {
        let mut next = shape.clone();
        next.control_vertices_mut().iter_mut().zip(way).for_each(|(p, d)| *p += d);
        let assembly = self.nearest.assembly();
        if !assembly.system().rows().is_empty() {
            for _ in 0..2 {
                let missing = self.problem.misfit(assembly, &self.among(&next))?;
                let mut by = vec![Vector::zeros(); way.len()];
                metric.correct(&missing, &mut by);
                next.control_vertices_mut().iter_mut().zip(&by).for_each(|(p, d)| *p += d);
            }
        }
        Ok(next)
    }
}

/// The shares of the points: their weights, or all alike.
fn checked<S>(asked: &CloudFit<S>, points: &[Point]) -> Result<Vec<f64>> {
    if points.is_empty() {
        return Err(FitError::Request("there are no points to fit to: give some".into()));
    }
    if let Some(index) = points.iter().position(|p| p.iter().any(|c| !c.is_finite())) {
        let [x, y, z] = points[index].coords.into();
        return Err(FitError::PointNotFinite { index, x, y, z });
    }
    if let Some(index) = points.iter().position(|p| p.coords.amax() > 1e150) {
        return Err(FitError::Request(format!(
            "point {index} is farther than 1e150, where squares of distances overflow: scale the points down"
        )));
    }
    if !(asked.tolerance >= 0.0 && asked.tolerance.is_finite()) {
        let tolerance = asked.tolerance;
        return Err(FitError::Request(format!(
            "a tolerance of {tolerance} is none: give 0 or a positive number"
        )));
    }
    let Some(weights) = &asked.weights else {
        return Ok(vec![1.0 / points.len() as f64; points.len()]);
    };
    check_weights(weights, points.len())?;
    let largest = weights.iter().fold(0.0_f64, |m, w| m.max(*w));
    let sum: f64 = weights.iter().map(|w| w / largest).sum();
    Ok(weights.iter().map(|w| w / largest / sum).collect())
}

/// The diagonal of the box of points.
fn diagonal<'a>(points: impl IntoIterator<Item = &'a Point>) -> f64 {
    let start = (Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY));
    let (low, high) = points.into_iter().fold(start, |(a, b), p| (a.inf(&p.coords), b.sup(&p.coords)));
    if low.x <= high.x { (high - low).norm() } else { 0.0 }
}

impl From<EditError> for FitError {
    fn from(error: EditError) -> Self {
        match error {
            EditError::Geometry(error) => Self::Geometry(error),
            other => Self::Equations(other),
        }
    }
}
