//! Fairing being said, and what comes of it.

use loftsman_kernel::text::{figure, short};
use std::fmt;
use std::sync::Arc;

use loftsman_kernel::edit::{Constraint, Edit, Smoothness};
use loftsman_kernel::energy::Energy;
use loftsman_kernel::plugin::ConstraintReport;
use loftsman_kernel::shape::Shape;

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
    pub(crate) shape: S,
    pub(crate) others: Vec<Box<dyn Shape>>,
    pub(crate) energy: Option<Arc<dyn Energy>>,
    pub(crate) constraints: Vec<Constraint>,
    pub(crate) locks: Vec<i64>,
    pub(crate) within: Option<f64>,
    smooth: u8,
}

impl<S: Shape + Clone> Fair<S> {
    /// Fairing of a copy of a shape.
    pub fn new(shape: &S) -> Self {
        Self {
            shape: shape.clone(),
            others: Vec::new(),
            energy: None,
            constraints: Vec::new(),
            locks: Vec::new(),
            within: None,
            smooth: 1,
        }
    }

    /// Adds another shape to the problem: the next number (1, 2, …) for functionals' `on`. Constraints look at it, and it stays as it is; in an
    /// [edit](Edit::with) it may move, too.
    #[must_use]
    pub fn with(mut self, shape: Box<dyn Shape>) -> Self {
        self.others.push(shape);
        self
    }

    /// What is to be small: a [sum of those here](crate::EnergySum), or any other energy that is known by its
    /// [squares](Energy::squares).
    #[must_use]
    pub fn energy(mut self, energy: impl Energy + 'static) -> Self {
        self.energy = Some(Arc::new(energy));
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

    /// How smooth what was smooth stays, at knots that are repeated so often that corners can appear there, and at the seams of
    /// closed curves: as in an [edit](Edit::smooth), by the same equations, and by default 1 (tangents). At all knots around
    /// control vertices that may move: an energy looks within spans only, and takes for nothing what happens between them. 2
    /// keeps curvatures as well, 0 lets corners and gaps appear. More counts as 2. [`FairReport::smooth`] says at how many
    /// knots, and what corners there are all the same.
    #[must_use]
    pub fn smooth(mut self, level: u8) -> Self {
        self.smooth = level.min(2);
        self
    }

    /// An edit of the shape beside the others, which stay; what is smooth is kept wherever the shape may move.
    pub(crate) fn edit(&self, constraints: Vec<Constraint>) -> Edit<S> {
        let mut edit = Edit::new(&self.shape).smooth(self.smooth).smooth_everywhere();
        edit = edit.lock(self.locks.iter().copied());
        for (index, other) in self.others.iter().enumerate() {
            let count = other.control_vertices().len() as i64;
            edit = edit.with(other.boxed()).lock_on(index + 1, 0..count);
        }
        constraints.into_iter().fold(edit, Edit::ask)
    }
}

/// A fair shape, and how it came about.
#[derive(Debug, Clone, PartialEq)]
pub struct Faired<S> {
    pub(crate) shape: S,
    pub(crate) report: FairReport,
}

impl<S> Faired<S> {
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
    /// Scalar equations: of what was asked, and of what was [kept smooth](Self::smooth) beside it.
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
    /// What was kept smooth without being asked, and the corners that there are all the same.
    pub smooth: Smoothness,
    /// Anything else worth saying.
    pub notes: Vec<String>,
}

impl fmt::Display for FairReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { energy, energy_before, energy_after, rank, equations, residual, adjustment, .. } = self;
        write!(
            f,
            "{energy} {energy_before} → {energy_after} · rank {rank} of {equations} · residual {residual} · \
             ‖d‖ {adjustment:.4} · {} steps",
            self.iterations,
            energy_before = figure(*energy_before),
            energy_after = figure(*energy_after),
            residual = short(*residual)
        )?;
        if self.smooth.knots > 0 {
            write!(f, " · {}", self.smooth)?;
        }
        if !self.active.is_empty() {
            write!(f, " · active: {}", self.active.join(", "))?;
        }
        for note in &self.notes {
            write!(f, " · {note}")?;
        }
        Ok(())
    }
}
