//! A fairing problem: its energy, its equations, and the least energy under them.

use loftsman_kernel::text::figure;
use std::cell::OnceCell;
use std::sync::Arc;

use loftsman_kernel::edit::{Constraint, EditError, SmoothKnot};
use loftsman_kernel::error::Error;
use loftsman_kernel::functional::Shapes;
use loftsman_kernel::plugin::ConstraintReport;
use loftsman_kernel::problem::{self, Solution};
use loftsman_kernel::shape::{Shape, grid_or_row, vertex_index};
use loftsman_kernel::solve::{SolveError, Solver, System};
use loftsman_kernel::{Point, Vector};

use crate::active::Row;
use crate::bounds::{Bound, not_linear, reach};
use crate::damped::{Damped, NOTHING};
use crate::fair::{Fair, FairReport, Faired};
use crate::form::nothing;
use crate::minimise::{Projection, Search, finite, minimise};
use crate::null_space::{Motions, NullSpace, motions, notes};
use crate::precondition::Preconditioner;
use crate::squares::Squares;
use crate::within::DistanceLimit;

/// Corrections of what the search's rounding left of the equations.
const CORRECTIONS: usize = 4;
/// So much of a vertex's own stiffness holds it back where parts move for themselves.
const DAMPING: f64 = 1e-12;
/// Proximal steps, and a gain below which one is the last.
const STEPS: usize = 40;
const GAIN: f64 = 1e-10;

/// What stays the same while a problem is solved. Points are relative to the first control vertex.
pub(crate) struct Problem<'a, S> {
    pub(crate) fair: &'a Fair<S>,
    pub(crate) solver: Arc<dyn Solver>,
    pub(crate) squares: Squares,
    pub(crate) free: Vec<bool>,
    /// The vertices as they were.
    pub(crate) rest: Vec<Vector>,
    /// The largest coordinate of all.
    reach: f64,
    origin: Point,
    damped: OnceCell<Option<Damped>>,
    motions: OnceCell<Motions>,
}

/// Equations, and the nearest shape that meets them.
pub(crate) struct Stage {
    asked: problem::Problem,
    nearest: Solution,
    pub(crate) x: Vec<Vector>,
    /// What the shape as it was misses of each.
    missing: Vec<f64>,
}

impl Stage {
    /// The equations' rows.
    pub(crate) fn system(&self) -> &System {
        self.nearest.assembly().system()
    }

    /// Each constraint with its part of the numbers that there are for all equations.
    pub(crate) fn account(&self, misfit: &[f64], numbers: &[f64]) -> Vec<ConstraintReport> {
        self.asked.account(self.nearest.assembly(), misfit, numbers)
    }

    /// The same for what is kept smooth.
    pub(crate) fn account_smooth(&self, numbers: &[f64]) -> Vec<ConstraintReport> {
        self.asked.account_smooth(self.nearest.assembly(), &[], numbers)
    }

    /// The multipliers of each constraint, of those of all equations.
    pub(crate) fn multipliers(&self, all: &[f64]) -> Vec<Vec<f64>> {
        self.account(&[], all).into_iter().map(|report| report.multipliers).collect()
    }

    fn misfit(&self, shapes: &Shapes<'_>) -> Result<Vec<f64>, Error> {
        self.asked.misfit(self.nearest.assembly(), shapes)
    }

    fn verify(&self, shapes: &Shapes<'_>, solver: &str) -> Result<(), EditError> {
        self.asked.verify(self.nearest.assembly(), shapes, solver)
    }
}

/// A shape of least energy.
pub(crate) struct Least {
    pub(crate) x: Vec<Vector>,
    pub(crate) search: Search,
    /// Motions that neither energy nor constraints saw.
    pub(crate) ways: usize,
    /// Of each constraint: how much the least energy would change with its value.
    pub(crate) multipliers: Vec<Vec<f64>>,
}

impl<'a, S: Shape + Clone> Problem<'a, S> {
    pub(crate) fn new(fair: &'a Fair<S>, solver: Arc<dyn Solver>) -> Result<Self, EditError> {
        let vertices = fair.shape.control_vertices();
        let origin = vertices.first().copied().unwrap_or_else(Point::origin);
        let energy = fair.energy.as_ref().ok_or_else(nothing)?;
        let squares = energy.squares(fair.shape.as_shape(), origin)?.ok_or_else(|| {
            Error::Invalid(format!(
                "\"{}\" is known by its matrix alone, and fairing works with squares: let an edit make it least (minimise)",
                energy.describe()
            ))
        })?;
        squares.check(vertices.len())?;
        let squares = Squares::from(squares);
        let mut free = vec![true; vertices.len()];
        for &lock in &fair.locks {
            let at = vertex_index(lock, free.len())?;
            free[at] = false;
        }
        let rest = vertices.iter().map(|p| p - origin).collect();
        let (damped, motions) = (OnceCell::new(), OnceCell::new());
        let mut problem = Self { fair, solver, squares, free, rest, reach: 0.0, origin, damped, motions };
        problem.reach = reach(&problem.among(&fair.shape));
        Ok(problem)
    }

    /// The energy with every vertex's own stiffness.
    pub(crate) fn damped(&self) -> Option<&Damped> {
        let new = || Damped::new(&self.squares, &self.free, &grid_or_row(self.fair.shape.as_shape()));
        self.damped.get_or_init(new).as_ref()
    }

    /// All motions that cost no energy (but for those that are too many).
    pub(crate) fn motions(&self) -> &[Vec<f64>] {
        &self.loose().all
    }

    fn loose(&self) -> &Motions {
        self.motions
            .get_or_init(|| motions(self.fair.shape.as_shape(), &self.squares, &self.free, || self.damped()))
    }

    /// The shape with other control vertices; locked ones to the last bit as they were, in spite of the origin.
    pub(crate) fn shape(&self, x: &[Vector]) -> S {
        let mut shape = self.fair.shape.clone();
        for ((vertex, x), free) in shape.control_vertices_mut().iter_mut().zip(x).zip(&self.free) {
            if *free {
                *vertex = self.origin + x;
            }
        }
        shape
    }

    /// A shape among the others of the problem.
    pub(crate) fn among<'b>(&'b self, shape: &'b S) -> Shapes<'b> {
        let others = self.fair.others.iter().map(AsRef::as_ref);
        Shapes::new(std::iter::once(shape.as_shape()).chain(others))
    }

    /// Binds equations. What conflicts is named here; the nearest shape that meets them is where the search starts.
    pub(crate) fn stage(&self, constraints: Vec<Constraint>) -> Result<Stage, EditError> {
        let asked = self.fair.edit(constraints).problem()?;
        if let Some(functional) = asked.nonlinear() {
            return Err(not_linear(&functional.describe()).into());
        }
        let nearest = asked.solve(&self.solver)?;
        let missing = asked.misfit(nearest.assembly(), &asked.shapes())?;
        let mut x = self.rest.clone();
        for (vertex, way) in nearest.adjustments() {
            if let Some(x) = x.get_mut(vertex) {
                *x += way;
            }
        }
        Ok(Stage { asked, nearest, x, missing })
    }

    /// The equations one by one, over coordinates.
    pub(crate) fn rows(&self, stage: &Stage) -> Vec<Row> {
        let system = stage.system();
        let (rows, sides) = (system.rows(), system.sides());
        let mut all = Vec::with_capacity(rows.len() * sides);
        for row in 0..rows.len() {
            for side in 0..sides {
                let at = |column: usize| {
                    let global = system.touched()[column];
                    if sides == 3 { 3 * global + side } else { global }
                };
                let terms: Vec<(usize, f64)> = rows.iter_row(row).map(|(c, v)| (at(c), v)).collect();
                let present: f64 = terms.iter().map(|&(at, c)| c * self.rest[at / 3][at % 3]).sum();
                let value = present + stage.missing[row * sides + side];
                let size = terms.iter().map(|(_, c)| c.abs()).sum::<f64>() * self.reach + value.abs();
                all.push(Row { terms, value, equation: true, size });
            }
        }
        all
    }

    /// The motions that neither the energy nor a system of equations sees.
    pub(crate) fn null_space(&self, system: &System) -> NullSpace {
        NullSpace::new(self.motions(), system)
    }

    /// The least energy under the equations of a stage, and within a distance where there is one; of several shapes of least
    /// energy the nearest to `x`, where the search starts.
    ///
    /// # Errors
    /// When the energy cannot be factored, the search does not arrive, or no shape is within the distance.
    pub(crate) fn least(
        &self,
        stage: &Stage,
        mut x: Vec<Vector>,
        within: Option<f64>,
    ) -> Result<Least, EditError> {
        let limit = within.map(|radius| DistanceLimit::new(&self.rest, radius, &self.free)).transpose()?;
        let system = stage.system();
        let null_space = self.null_space(system);
        let ways = null_space.ways();
        let mut projection = Projection::new(system, self.solver.factor(system)?, null_space);
        let mut squares = self.squares.clone();
        let mut search = Search::default();
        if self.free.contains(&true) {
            let grid = grid_or_row(self.fair.shape.as_shape());
            let precondition = |squares: &Squares| Preconditioner::new(squares, &self.free, &grid, system);
            let mut preconditioner = precondition(&squares).ok_or_else(|| self.beyond())?;
            self.correct(stage, &mut projection, &mut x)?;
            let start = x.clone();
            search = if self.loose().more && within.is_none() {
                self.descend(&mut projection, &mut x)?
            } else {
                minimise(&squares, &self.free, &mut projection, &mut preconditioner, &mut x)?
            };
            if let Some(limit) = limit.as_ref().filter(|limit| limit.farthest(&x).0 > limit.radius) {
                x = start;
                if limit.farthest(&x).0 >= limit.inside() {
                    x = self.inside(limit, stage, &[])?;
                }
                projection.tether();
                let mut solve = |tethers: &[f64], x: &mut [Vector]| {
                    squares.tether(tethers, &self.rest);
                    let Some(mut preconditioner) = precondition(&squares) else { return Ok(None) };
                    Ok(Some(minimise(&squares, &self.free, &mut projection, &mut preconditioner, x)?.steps))
                };
                let safe = x.clone();
                match limit.minimise(&self.squares, &mut solve, &mut x) {
                    Ok(done) => search = done,
                    Err(report) => {
                        x = safe;
                        let rows = self.rows(stage);
                        let (search, multipliers) = self.cut(limit, &rows, &mut x).ok_or(report)?;
                        self.correct(stage, &mut projection, &mut x)?;
                        let multipliers = stage.multipliers(&multipliers);
                        return Ok(Least { x, search, ways, multipliers });
                    }
                }
            }
        }
        self.correct(stage, &mut projection, &mut x)?;
        let mut gradient = vec![Vector::zeros(); x.len()];
        squares.gradient(&x, true, &mut gradient);
        gradient
            .iter_mut()
            .zip(&self.free)
            .filter(|(_, free)| !**free)
            .for_each(|(g, _)| *g = Vector::zeros());
        let multipliers: Vec<f64> = projection.multipliers(&gradient).iter().map(|m| 2.0 * m).collect();
        let multipliers = stage.multipliers(&multipliers);
        Ok(Least { x, search, ways, multipliers })
    }

    /// The least energy by proximal steps, where so many parts move for themselves that it is not known how: each search is held
    /// back by a millionth of a millionth of every vertex's own stiffness, and starts where the last one ended.
    fn descend(&self, projection: &mut Projection<'_>, x: &mut [Vector]) -> Result<Search, EditError> {
        let weights: Vec<f64> = self.squares.stiffness(x.len()).iter().map(|h| DAMPING * h).collect();
        let mut squares = self.squares.clone();
        squares.tether(&weights, x);
        let grid = grid_or_row(self.fair.shape.as_shape());
        let mut preconditioner = Preconditioner::new(&squares, &self.free, &grid, projection.system())
            .ok_or_else(|| self.beyond())?;
        projection.tether();
        let (mut search, mut energy) = (Search::default(), f64::INFINITY);
        for _ in 0..STEPS {
            squares.tether(&weights, x);
            let found = minimise(&squares, &self.free, projection, &mut preconditioner, x)?;
            search = Search { steps: search.steps + found.steps, gap: found.gap };
            let (now, size) = self.squares.energy(x);
            if energy - now <= GAIN * now + NOTHING * size {
                break;
            }
            energy = now;
        }
        Ok(search)
    }

    /// The least energy under rows and within a distance, by planes, from a shape that keeps to both: what the search did, and the
    /// multipliers of the rows.
    pub(crate) fn cut(
        &self,
        limit: &DistanceLimit<'_>,
        rows: &[Row],
        x: &mut [Vector],
    ) -> Option<(Search, Vec<f64>)> {
        let damped = self.damped()?;
        let (search, mut multipliers) = limit.cut(&self.squares, (damped, self.motions()), rows, x).ok()?;
        multipliers.iter_mut().for_each(|u| *u *= 2.0);
        Some((search, multipliers))
    }

    /// Takes away what a shape misses of the equations.
    pub(crate) fn correct(
        &self,
        stage: &Stage,
        projection: &mut Projection<'_>,
        x: &mut [Vector],
    ) -> Result<(), EditError> {
        let system = stage.system();
        let mut before = f64::INFINITY;
        for _ in 0..CORRECTIONS {
            finite(x)?;
            let missing = stage.misfit(&self.among(&self.shape(x)))?;
            let each = missing.chunks_exact(system.sides()).enumerate().map(|(row, missing)| {
                let all: f64 = system.rows().row(row).1.iter().map(|c| c.abs()).sum();
                let most = missing.iter().fold(0.0_f64, |m, e| m.max(e.abs()));
                if all > 0.0 { most / all } else { 0.0 }
            });
            let worst = each.fold(0.0, f64::max) / self.reach.max(f64::MIN_POSITIVE);
            if !(worst > f64::EPSILON && worst < 0.5 * before) {
                break;
            }
            before = worst;
            projection.correct(&missing, x);
        }
        Ok(())
    }

    /// The shape, measured afresh: every equation and every bound as it holds there, how far it moved, and the energy beside that
    /// of the shape as it was. `pushes` are the multipliers of the bounds.
    ///
    /// # Errors
    /// When something does not hold to rounding, or the energy is more than it was though the shape met everything.
    pub(crate) fn hand_out(
        &self,
        stage: &Stage,
        least: &Least,
        bounds: &[Bound],
        pushes: &[f64],
    ) -> Result<Faired<S>, EditError> {
        let (x, search) = (&least.x, least.search);
        finite(x)?;
        let shape = self.shape(x);
        let shapes = self.among(&shape);
        let missing = stage.misfit(&shapes)?;
        let solver = self.solver.name();
        stage.verify(&shapes, solver)?;
        let old = self.among(&self.fair.shape);
        let mut feasible = stage.verify(&old, solver).is_ok();
        let mut constraints = stage.account(&missing, &[]);
        for (report, multipliers) in constraints.iter_mut().zip(&least.multipliers) {
            report.multipliers.clone_from(multipliers);
        }
        let mut active = Vec::new();
        for (bound, push) in bounds.iter().zip(pushes) {
            let found = bound.measured(&shapes, self.reach)?;
            if !found.holds() {
                let (error, constraint) = (found.verdict(), format!("\"{}\"", bound.name()));
                let advice = "ask for less at once, or release a bound that nearly contradicts it";
                let (error, allowed, solver) = (error.error, error.allowed, solver.to_owned());
                return Err(SolveError::Missed { constraint, error, allowed, solver, advice }.into());
            }
            feasible &= bound.measured(&old, self.reach)?.holds();
            constraints.push(bound.account(found.error, *push));
            if *push != 0.0 || bound.touched(&shapes, self.reach)? {
                active.push(bound.name());
            }
        }
        let residual = constraints.iter().fold(0.0, |m: f64, c| m.max(c.residual));
        let ((energy_before, size), energy_after) =
            (self.squares.energy(&self.rest), self.squares.energy(x).0);
        let allowed = energy_before * (1.0 + 1e-9) + NOTHING * size;
        if energy_after.is_nan() || feasible && energy_after > allowed {
            return Err(SolveError::Unsupported(format!(
                "the search ended at an energy of {energy_after}, and the shape as it was has {energy_before}: it \
                 cannot be made fairer with numbers of this size", energy_after = figure(energy_after), energy_before = figure(energy_before)))
            .into());
        }
        let smooth = stage.asked.smoothness(&shapes);
        let kept: Vec<SmoothKnot> = stage.asked.smooth_knots().collect();
        let mut notes = notes(self.fair.shape.as_shape(), &self.squares, least.ways, &kept);
        notes.extend(smooth.notes());
        // Within a distance the search ends at a thousandth of the energy, which is more than rounding.
        if self.fair.within.is_some() && search.gap > 1e-6 {
            notes.push(format!(
                "its energy is at most {} % above the least that there is within that distance",
                figure(100.0 * search.gap)
            ));
        }
        let moved = || x.iter().zip(&self.rest).map(|(a, b)| (a - b).norm());
        let nearest = &stage.nearest;
        let report = FairReport {
            energy: self.fair.energy.as_ref().map(|energy| energy.describe()).unwrap_or_default(),
            energy_before,
            energy_after,
            solver: nearest.solver().to_owned(),
            equations: nearest.equations(),
            rank: nearest.rank(),
            redundant: nearest.redundant().to_vec(),
            residual,
            condition: nearest.condition(),
            adjustment: moved().fold(0.0, f64::hypot),
            farthest: moved().fold(0.0, f64::max),
            iterations: search.steps,
            gap: search.gap,
            active,
            constraints,
            notes,
            smooth,
        };
        // Coordinates are rounded, so that what is between them is known to so much and no better.
        let size = x.iter().map(|p| p.amax()).fold(0.0, f64::max);
        let rounding = 4.0 * f64::EPSILON * size;
        if let Some(radius) =
            self.fair.within.filter(|radius| report.farthest.is_nan() || report.farthest > *radius + rounding)
        {
            // As short as they differ.
            let are_alike = figure(report.farthest) == figure(radius);
            let told = |x: f64| if are_alike { x.to_string() } else { figure(x) };
            let (far, radius) = (told(report.farthest), told(radius));
            let text = format!("a control vertex would move by {far}, beyond {radius}: allow more");
            return Err(Error::Invalid(text).into());
        }
        Ok(Faired { shape, report })
    }

    /// That the energy cannot be factored.
    pub(crate) fn beyond(&self) -> EditError {
        let vertices = self.free.len();
        Error::Invalid(format!(
            "the energy of {vertices} control vertices cannot be factored: it vanishes, or is beyond all memory; take \
             another energy, or fair a part of the shape"
        ))
        .into()
    }
}
