//! Fairing being said, and done.

use std::fmt;
use std::sync::Arc;

use loftsman_kernel::edit::{Constraint, Edit, EditError};
use loftsman_kernel::error::Error;
use loftsman_kernel::functional::Shapes;
use loftsman_kernel::plugin::ConstraintReport;
use loftsman_kernel::shape::{Shape, vertex_index};
use loftsman_kernel::solve::{Automatic, SolveError, Solver};
use loftsman_kernel::{Point, Vector};

use crate::bounds::{Bound, Candidate, bounded, split};
use crate::energy::Energy;
use crate::idle::{idle_motions, notes};
use crate::minimise::{Projection, Search, finite, minimise};
use crate::precondition::Preconditioner;
use crate::squares::Squares;
use crate::within::Leash;

/// Says what should be fair, and under which constraints.
///
/// ```
/// use loftsman_fairing::{Fair, bend};
/// use loftsman_kernel::Point;
/// use loftsman_kernel::edit::Ask;
/// use loftsman_kernel::functional::position;
/// use loftsman_kernel::spline::{Curve, Space};
///
/// let points = (0..12).map(|i| Point::new(f64::from(i), f64::from(i % 2), 0.0)).collect();
/// let curve = Curve::new(Space::clamped_uniform(3, 12)?, points)?;
/// let fair = Fair::new(&curve)
///     .energy(bend())
///     .ask(position(0.0).keep())
///     .ask(position(4.5).to([5.0, 2.0, 0.0]))
///     .ask(position(9.0).keep())
///     .solve()?;
/// assert!((fair.shape().point(4.5)?.y - 2.0).abs() < 1e-14);
/// assert!(fair.report().energy_after < 0.1 * fair.report().energy_before);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Fair<S> {
    shape: S,
    others: Vec<Box<dyn Shape>>,
    energy: Energy,
    constraints: Vec<Constraint>,
    locks: Vec<i64>,
    within: Option<f64>,
}

impl<S: Shape + Clone> Fair<S> {
    /// Fairing of a copy of a shape.
    pub fn new(shape: &S) -> Self {
        Self {
            shape: shape.clone(),
            others: Vec::new(),
            energy: Energy::default(),
            constraints: Vec::new(),
            locks: Vec::new(),
            within: None,
        }
    }

    /// Adds a shape that constraints look at: the next number (1, 2, …) for functionals' `on`. It stays as it is.
    #[must_use]
    pub fn beside(mut self, shape: Box<dyn Shape>) -> Self {
        self.others.push(shape);
        self
    }

    /// What is to be small.
    #[must_use]
    pub fn energy(mut self, energy: Energy) -> Self {
        self.energy = energy;
        self
    }

    /// Asks something. Everything linear can be asked, also for bounds (`at_least`, `at_most`).
    #[must_use]
    pub fn ask(mut self, constraint: Constraint) -> Self {
        self.constraints.push(constraint);
        self
    }

    /// Locks control vertices: they stay where they are. Negative numbers count from the end.
    #[must_use]
    pub fn lock(mut self, vertices: impl IntoIterator<Item = i64>) -> Self {
        self.locks.extend(vertices);
        self
    }

    /// Lets no point move further than a distance: no control vertex does, which is a little more than that. The energy is
    /// then within a thousandth of the least possible ([`FairReport::gap`] says how near); it takes some dozens of searches.
    #[must_use]
    pub fn within(mut self, distance: f64) -> Self {
        self.within = Some(distance);
        self
    }

    /// The shape of least energy, with the default solver for the constraints.
    ///
    /// # Errors
    /// As for [`solve_with`](Self::solve_with).
    pub fn solve(self) -> Result<Fairer<S>, EditError> {
        self.solve_with(Automatic)
    }

    /// The shape of least energy that meets the constraints; of several the nearest (`Σ‖dᵢ‖²` least) to the shape that the
    /// least adjustment gives. Work is linear in the control vertices of a curve.
    ///
    /// # Errors
    /// When something cannot be asked of the shapes, is not linear, or the constraints cannot all hold; when the energy needs
    /// derivatives that the degree does not have; when the constraints alone move a control vertex beyond [`within`](Self::within).
    pub fn solve_with(mut self, solver: impl Solver + 'static) -> Result<Fairer<S>, EditError> {
        let solver: Arc<dyn Solver> = Arc::new(solver);
        let constraints = std::mem::take(&mut self.constraints);
        let all = std::iter::once(&self.shape as &dyn Shape).chain(self.others.iter().map(AsRef::as_ref));
        let asked = constraints.clone();
        let (equations, bounds) = split(constraints, &Shapes::new(all))?;
        if bounds.is_empty() {
            let how = self.within.map_or(Moving::Anywhere, Moving::Within);
            return Ok(self.equal(&solver, equations, how)?.fairer);
        }
        let solve = |constraints| self.equal(&solver, constraints, Moving::Anywhere);
        let (found, account, active) = match bounded(&equations, &bounds, &mut Vec::new(), &solve) {
            // The kernel knows the bounds as such, and names those that contradict each other with their sides.
            Err(EditError::Solve(SolveError::Conflict(conflict))) => {
                let told = self.edit(asked).solve_with(Arc::clone(&solver));
                return Err(told.err().unwrap_or(SolveError::Conflict(conflict).into()));
            }
            done => done?,
        };
        if let Some(radius) = self.within.filter(|r| r.is_nan() || found.fairer.report.farthest > *r) {
            return self.between(&solver, asked, &equations, &bounds, radius);
        }
        let Fairer { shape, mut report } = found.fairer;
        report.constraints.truncate(equations.len());
        report.residual = account.iter().chain(&report.constraints).fold(0.0, |m, c| m.max(c.residual));
        report.constraints.extend(account);
        report.active = active;
        Ok(Fairer { shape, report })
    }

    /// The shape of least energy under equations.
    fn equal(
        &self,
        solver: &Arc<dyn Solver>,
        constraints: Vec<Constraint>,
        moving: Moving<'_>,
    ) -> Result<Found<S>, EditError> {
        let origin = self.shape.control_vertices().first().copied().unwrap_or_else(Point::origin);
        let squares = Squares::new(&self.shape, &self.energy, origin)?;
        let mut free = vec![true; self.shape.control_vertices().len()];
        for &lock in &self.locks {
            let at = vertex_index(lock, free.len())?;
            free[at] = false;
        }
        let before = relative(&self.shape, origin);
        let mut session = self.edit(constraints).prepare(Arc::clone(solver))?;
        if let Some(functional) = session.nonlinear() {
            let name = functional.describe();
            return Err(SolveError::Unsupported(format!(
                "\"{name}\" is not linear in the control vertices, and a fair shape is sought under linear constraints only: \
                 leave it out, or use \"edit\" with the metric \"bend\""
            ))
            .into());
        }
        // What conflicts is named here; then the nearest shape that meets the constraints is where the search starts.
        session.apply()?;
        let mut x = relative(session.shape(), origin);
        let system = session.system();
        let factored = solver.factor(system)?;
        let told = session.report();
        let leash = match moving {
            Moving::Within(radius) => Some(Leash::new(&before, radius, &free, &x)?),
            _ => None,
        };
        // What is minimised: the energy, and the tethers where there are any.
        let mut tied = squares.clone();
        if let Moving::Tethered(tethers) = moving {
            tied.tether(tethers, &before);
        }
        let idle = idle_motions(&self.shape, &squares, &free, system);
        let notes = notes(&self.shape, &squares, idle.len());
        let mut projection = Projection::new(system, factored, idle);
        if matches!(moving, Moving::Tethered(_)) {
            projection.tether();
        }
        let mut search = Search::default();
        if free.contains(&true) {
            let grid = self.shape.grid();
            let precondition = |squares: &Squares| Preconditioner::new(squares, &free, &grid, system);
            let mut preconditioner = precondition(&tied).ok_or_else(|| {
                let vertices = free.len();
                Error::Invalid(format!(
                    "the energy of {vertices} control vertices cannot be factored: it vanishes, or is beyond all memory; \
                     take another energy, or fair a part of the shape"
                ))
            })?;
            let start = x.clone();
            search = minimise(&tied, &free, &mut projection, &mut preconditioner, &mut x)?;
            if let Some(leash) = leash.as_ref().filter(|leash| leash.farthest(&x).0 > leash.radius) {
                x = start;
                projection.tether();
                let mut solve = |tethers: &[f64], x: &mut [Vector]| {
                    tied.tether(tethers, &before);
                    let Some(mut preconditioner) = precondition(&tied) else { return Ok(None) };
                    Ok(Some(minimise(&tied, &free, &mut projection, &mut preconditioner, x)?.steps))
                };
                search = leash.minimise(&squares, &mut solve, &mut x)?;
            }
        }
        // What the projections' rounding left.
        let mut fair = self.shape.clone();
        let mut misfit = Vec::new();
        for last in [false, true] {
            finite(&x)?;
            for (vertex, x) in fair.control_vertices_mut().iter_mut().zip(&x) {
                *vertex = origin + x;
            }
            let all = std::iter::once(&fair as &dyn Shape).chain(self.others.iter().map(AsRef::as_ref));
            misfit = session.misfit(&Shapes::new(all))?;
            if !last {
                projection.correct(&misfit, &mut x);
            }
        }
        // Locked vertices to the last bit, in spite of the origin.
        for (at, (vertex, old)) in
            fair.control_vertices_mut().iter_mut().zip(self.shape.control_vertices()).enumerate()
        {
            if !free[at] {
                *vertex = *old;
            }
        }
        let mut gradient = vec![Vector::zeros(); x.len()];
        tied.gradient(&x, true, &mut gradient);
        gradient.iter_mut().zip(&free).filter(|(_, free)| !**free).for_each(|(g, _)| *g = Vector::zeros());
        let multipliers: Vec<f64> = projection.multipliers(&gradient).iter().map(|m| 2.0 * m).collect();
        let adjustment = x.iter().zip(&before).map(|(a, b)| (a - b).norm()).fold(0.0, f64::hypot);
        let report = FairReport {
            energy: self.energy.to_string(),
            energy_before: squares.energy(&before).0,
            energy_after: squares.energy(&x).0,
            solver: told.solver,
            equations: told.equations,
            rank: told.rank,
            redundant: told.redundant,
            residual: misfit.iter().fold(0.0, |m, e| m.max(e.abs())),
            condition: told.condition,
            adjustment,
            farthest: x.iter().zip(&before).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max),
            iterations: search.steps,
            gap: search.gap,
            active: Vec::new(),
            constraints: session.account(&misfit, &multipliers),
            notes,
        };
        if let Some(leash) = leash.filter(|leash| leash.farthest(&x).0 > leash.radius) {
            let (far, vertex) = leash.farthest(&x);
            let text =
                format!("control vertex {vertex} would move by {far}, beyond {}: allow more", leash.radius);
            return Err(Error::Invalid(text).into());
        }
        let others = self.others.iter().map(|other| other.boxed()).collect();
        Ok(Found { fairer: Fairer { shape: fair, report }, others })
    }

    /// The shape of least energy under equations and bounds, and within a distance. With tethers in place of the distance it is a
    /// problem with bounds alone, and its shape is drawn back towards the least adjustment, as far as it must be.
    fn between(
        &self,
        solver: &Arc<dyn Solver>,
        asked: Vec<Constraint>,
        equations: &[Constraint],
        bounds: &[Bound],
        radius: f64,
    ) -> Result<Fairer<S>, EditError> {
        let origin = self.shape.control_vertices().first().copied().unwrap_or_else(Point::origin);
        let squares = Squares::new(&self.shape, &self.energy, origin)?;
        let mut free = vec![true; self.shape.control_vertices().len()];
        for &lock in &self.locks {
            let at = vertex_index(lock, free.len())?;
            free[at] = false;
        }
        let edited = self.edit(asked).solve_with(Arc::clone(solver))?;
        let (rest, mut x) = (relative(&self.shape, origin), relative(edited.shape(), origin));
        let leash = Leash::new(&rest, radius, &free, &x)?;
        let (mut active, mut last) = (Vec::new(), None);
        let mut solve = |tethers: &[f64], x: &mut [Vector]| {
            let equal = |constraints| self.equal(solver, constraints, Moving::Tethered(tethers));
            let done = bounded(equations, bounds, &mut active, &equal)?;
            let found = &done.0.fairer;
            for (x, point) in x.iter_mut().zip(found.shape.control_vertices()) {
                *x = point - origin;
            }
            let steps = found.report.iterations;
            last = Some(done);
            Ok(Some(steps))
        };
        let search = leash.minimise(&squares, &mut solve, &mut x)?;
        let mut shape = self.shape.clone();
        for (at, (vertex, x)) in shape.control_vertices_mut().iter_mut().zip(&x).enumerate() {
            if free[at] {
                *vertex = origin + x;
            }
        }
        let Some((found, mut account, names)) = last else {
            // The least adjustment has no energy that could be less.
            let report = FairReport { energy: self.energy.to_string(), ..FairReport::default() };
            return Ok(Fairer { shape, report });
        };
        let all = std::iter::once(&shape as &dyn Shape).chain(self.others.iter().map(AsRef::as_ref));
        let shapes = Shapes::new(all);
        for (told, bound) in account.iter_mut().zip(bounds) {
            told.residual = bound.violation(&shapes)?;
        }
        let mut report = found.fairer.report;
        report.constraints.truncate(equations.len());
        report.constraints.extend(account);
        let residual = report.constraints.iter().fold(0.0, |m: f64, c| m.max(c.residual));
        report.residual = residual.max(edited.report().residual);
        report.energy_after = squares.energy(&x).0;
        report.adjustment = x.iter().zip(&rest).map(|(a, b)| (a - b).norm()).fold(0.0, f64::hypot);
        (report.farthest, report.iterations, report.gap) = (leash.farthest(&x).0, search.steps, search.gap);
        report.active = names;
        Ok(Fairer { shape, report })
    }

    /// An edit of the shape beside the others, which stay.
    fn edit(&self, constraints: Vec<Constraint>) -> Edit<S> {
        // An energy decides how smooth the shape becomes, not how smooth it was.
        let mut edit = Edit::new(&self.shape).smooth(0).lock(self.locks.iter().copied());
        for (index, other) in self.others.iter().enumerate() {
            let count = other.control_vertices().len() as i64;
            edit = edit.with(other.boxed()).lock_on(index + 1, 0..count);
        }
        constraints.into_iter().fold(edit, Edit::ask)
    }
}

/// How far vertices may move.
#[derive(Clone, Copy)]
enum Moving<'a> {
    Anywhere,
    /// No further than this.
    Within(f64),
    /// Tied to where they were, with these weights.
    Tethered(&'a [f64]),
}

/// A fair shape among the others of its problem.
struct Found<S> {
    fairer: Fairer<S>,
    others: Vec<Box<dyn Shape>>,
}

impl<S: Shape> Candidate for Found<S> {
    fn shapes(&self) -> Shapes<'_> {
        Shapes::new(
            std::iter::once(&self.fairer.shape as &dyn Shape).chain(self.others.iter().map(AsRef::as_ref)),
        )
    }

    fn constraints(&self) -> &[ConstraintReport] {
        &self.fairer.report.constraints
    }
}

fn relative(shape: &dyn Shape, origin: Point) -> Vec<Vector> {
    shape.control_vertices().iter().map(|p| p - origin).collect()
}

/// A fair shape, and how it came about.
#[derive(Debug, Clone, PartialEq)]
pub struct Fairer<S> {
    shape: S,
    report: FairReport,
}

impl<S> Fairer<S> {
    /// The fair shape.
    pub fn shape(&self) -> &S {
        &self.shape
    }

    /// The fair shape, given away.
    pub fn into_shape(self) -> S {
        self.shape
    }

    /// What fairing gave.
    pub fn report(&self) -> &FairReport {
        &self.report
    }
}

/// What fairing gave: printed by `Display`, kept by serde.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct FairReport {
    /// What was to be small.
    pub energy: String,
    /// The energy of the shape as it was.
    pub energy_before: f64,
    /// The energy of the fair shape.
    pub energy_after: f64,
    /// The solver of the constraints.
    pub solver: String,
    /// Scalar equations asked.
    pub equations: usize,
    /// Independent ones among them.
    pub rank: usize,
    /// Constraints (or parts of them) that the others imply: they were dropped, and hold.
    pub redundant: Vec<String>,
    /// Largest error of any constraint, in document units.
    pub residual: f64,
    /// Estimate of the condition number of the equations, each scaled to unit length.
    pub condition: f64,
    /// `(Σ‖dᵢ‖²)^½`.
    pub adjustment: f64,
    /// The largest `‖dᵢ‖`: no point of the shape moved further.
    pub farthest: f64,
    /// Steps of the search.
    pub iterations: usize,
    /// Estimate of the energy that more steps would gain, relative to the energy.
    pub gap: f64,
    /// The inequalities that hold with equality.
    pub active: Vec<String>,
    /// Every constraint with its error and its multipliers: how much the least energy would change with its value.
    pub constraints: Vec<ConstraintReport>,
    /// Anything else worth saying.
    pub notes: Vec<String>,
}

impl fmt::Display for FairReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { energy, energy_before, energy_after, rank, equations, residual, adjustment, .. } = self;
        write!(
            f,
            "{energy} {energy_before:.4e} → {energy_after:.4e} · rank {rank} of {equations} · residual {residual:.1e} · \
             ‖d‖ {adjustment:.4} · {} steps",
            self.iterations
        )?;
        if !self.active.is_empty() {
            write!(f, " · active: {}", self.active.join(", "))?;
        }
        for note in &self.notes {
            write!(f, " · {note}")?;
        }
        Ok(())
    }
}
