//! Solvers: the least adjustment that meets linear equations.
//!
//! `F d = b` with `dᵀ W d` least has the answer `d = W⁻¹Fᵀ (F W⁻¹ Fᵀ)⁻¹ b` (paper 1, equation (5); with `W` the
//! metric). A [`System`] holds the sparse rows of `F` and the metric; a [`Solver`] factors it once, at mouse
//! down; the [`Factored`] answer is then good for any number of right-hand sides.
//!
//! | solver | for | condition |
//! |---|---|---|
//! | [`Adjoint`] | one to six equations; closed forms for 1, 2, 3 | squared |
//! | [`Sparse`] | many equations; work proportional to what they touch | squared |
//! | [`HouseholderQr`] | ill-conditioned systems; shows rank | as it is |
//! | [`SaddlePoint`] | many equations in a banded metric; uses the metric as it is | squared |
//! | [`DenseLu`] | small systems with any metric; an independent check of the others | hardly above it |
//! | [`Automatic`] | picks the first that is fast and safe | |
//!
//! *Rank* is decided by reflections wherever a solver's own factors cannot tell, coarsely at first ([`System::tolerance`]).
//! Whether a row that was left out agrees with the others is judged by the answer ([`Dependency::agrees`]); where it does
//! not, and before that is called a conflict, the system is to be factored [finely](System::finely).
//!
//! *Metrics* are taken out before a solver sees the system, in one place ([`Solver::factor`]), unless it can use them as they are.
//!
//! *Answers* of every solver are corrected by their own residuals until these are rounding of the terms they are made of. A
//! solver that cannot reach that refuses the system and names a better one.
//!
//! Inequalities make a quadratic program ([`Program`]): which of them are active is found first
//! ([`Solver::program`]), and the least adjustment is then that of the equations and the active ones. Many are guessed
//! and put right together ([`Program::pivot`]), few or obstinate ones found one by one.

mod active_set;
mod adjoint;
mod automatic;
mod elimination;
mod envelope;
mod free;
mod householder_qr;
mod in_metric;
mod lu;
mod map;
mod metric;
mod order;
mod pivoting;
mod range_space;
mod rank;
mod refine;
mod saddle;
mod saddle_point;
mod sparse;
mod symmetric;
mod system;
mod unit;

use crate::text::{figure, short};
pub use active_set::{Outcome, Program, Sense};
pub use adjoint::Adjoint;
pub use automatic::Automatic;
pub use envelope::EnvelopeCholesky;
pub use householder_qr::HouseholderQr;
pub use lu::DenseLu;
pub use map::{Map, Operator, Through};
pub use metric::SystemMetric;
pub(crate) use metric::{InverseMetric, Whitened};
pub use range_space::{RangeSpace, Weight};
pub use rank::{Dependency, Diagnosis};
pub use saddle_point::SaddlePoint;
pub use sparse::Sparse;
pub use symmetric::Symmetric;
pub use system::{SparseRows, System};

/// Turns a system into something that can be solved again and again.
pub trait Solver: Send + Sync {
    /// Its name in recipes.
    fn name(&self) -> &str;

    /// One line on what it is for, for lists.
    fn help(&self) -> &str {
        ""
    }

    /// Does all the work that does not depend on the right-hand side, for a system whose metric is the identity (or one that this
    /// solver [takes](Self::takes)): its answers have the least length. Dependent rows are found and left out; the answer's
    /// [`diagnosis`](Factored::diagnosis) names them.
    ///
    /// # Errors
    /// When the system is too large or too ill-conditioned for this solver; the error names a better one.
    fn factor_minimum_norm(&self, system: &System) -> Result<Box<dyn Factored>, SolveError>;

    /// Whether [`factor_minimum_norm`](Self::factor_minimum_norm) can use this metric as it is. By default none but the identity.
    fn takes(&self, metric: &SystemMetric) -> bool {
        matches!(metric, SystemMetric::Least)
    }

    /// The same for any system: what callers call, and no solver needs to write. Unknowns [without weight](System::free), maps and
    /// metrics that the solver does not [take](Self::takes) are taken out first and put back into the answers, which are then
    /// corrected by their residuals in the rows as they were given.
    ///
    /// # Errors
    /// As for [`factor_minimum_norm`](Self::factor_minimum_norm); when the metric is not positive definite.
    fn factor(&self, system: &System) -> Result<Box<dyn Factored>, SolveError> {
        if system.free() > 0 {
            free::factor(self.name(), &|weighed| self.factor(weighed), system)
        } else if self.takes(system.metric()) {
            self.factor_minimum_norm(system)
        } else {
            in_metric::factor(self.name(), &|plain| self.factor_minimum_norm(plain), system)
        }
    }

    /// Finds out which inequalities of a quadratic program hold with equality; the least adjustment is then that of the
    /// equations and these, which [`factor`](Self::factor) solves. The default is [`Program::pivot`] for more than some
    /// dozens of rows; where that does not arrive, and for fewer, the dual active-set method of Goldfarb and Idnani (1983) on
    /// an orthonormal basis of the active rows. A solver with another method of its own overrides it.
    ///
    /// # Errors
    /// When the metric is not positive definite, or there are too many rows to decide.
    fn program(&self, program: &Program<'_>) -> Result<Outcome, SolveError> {
        active_set::active_set(program)
    }
}

impl Solver for std::sync::Arc<dyn Solver> {
    fn name(&self) -> &str {
        self.as_ref().name()
    }

    fn help(&self) -> &str {
        self.as_ref().help()
    }

    fn factor_minimum_norm(&self, system: &System) -> Result<Box<dyn Factored>, SolveError> {
        self.as_ref().factor_minimum_norm(system)
    }

    fn takes(&self, metric: &SystemMetric) -> bool {
        self.as_ref().takes(metric)
    }

    fn factor(&self, system: &System) -> Result<Box<dyn Factored>, SolveError> {
        self.as_ref().factor(system)
    }

    fn program(&self, program: &Program<'_>) -> Result<Outcome, SolveError> {
        self.as_ref().program(program)
    }
}

/// A factored system.
///
/// Vectors with several sides are kept row after row: entry `row * sides + side`.
pub trait Factored: Send {
    /// The name of the solver that did the work.
    fn solver(&self) -> &str;

    /// The number of independent rows. Known without work.
    fn rank(&self) -> usize;

    /// Rank, condition and the rows that the others imply. Cheap, but not free: not for every event.
    fn diagnosis(&self) -> Diagnosis;

    /// The least adjustment for a right-hand side: `rhs` has `rows × sides` entries, `d` gets
    /// `touched × sides`. Entries of `rhs` at dependent rows are not looked at (whether they agree is for the
    /// caller to see, with [`Diagnosis::dependencies`]). Allocates nothing.
    fn solve_into(&mut self, rhs: &[f64], d: &mut [f64]);

    /// The Lagrange multipliers `λ` of a right-hand side (`d = W⁻¹Fᵀλ`): `rows × sides`, zero at dependent rows.
    fn multipliers_into(&mut self, rhs: &[f64], multipliers: &mut [f64]);
}

/// Why a system could not be solved.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SolveError {
    /// More equations or unknowns than this solver is for.
    #[error(
        "{equations} equations with {unknowns} unknowns are too many for the solver \"{solver}\": use \"{better}\""
    )]
    TooLarge {
        /// The solver's name.
        solver: String,
        /// Rows of the system.
        equations: usize,
        /// Columns that the rows touch.
        unknowns: usize,
        /// The name of a solver that can.
        better: &'static str,
    },
    /// The system is so ill-conditioned that this solver would lose the answer.
    #[error(
        "the constraints are nearly dependent (condition {condition}), too much so for the solver \"{solver}\": use \"{better}\"",
        condition = short(*condition)
    )]
    IllConditioned {
        /// The solver's name.
        solver: String,
        /// Estimate of the condition number.
        condition: f64,
        /// The name of a solver that can.
        better: &'static str,
    },
    /// The metric is not positive definite.
    #[error(
        "the metric is not positive definite (at vertex {vertex}): every weight must be positive, and an energy must see every motion: \
         add some of the distance from the shape as it was (`near`)"
    )]
    Metric {
        /// The control vertex where it fails.
        vertex: usize,
    },
    /// An answer that misses an equation by more than rounding explains: it is not handed out.
    #[error(
        "{constraint} would be missed by {error}, more than rounding explains ({allowed}), so the answer of the solver \"{solver}\" is not taken: {advice}",
        error = short(*error),
        allowed = short(*allowed)
    )]
    Missed {
        /// What is missed.
        constraint: String,
        /// By how much.
        error: f64,
        /// What its accuracy allows.
        allowed: f64,
        /// The solver's name.
        solver: String,
        /// What to do.
        advice: &'static str,
    },
    /// An answer that is farther from an equation than the tolerance that it was given: it is not handed out.
    #[error(
        "{constraint} would be missed by {error}, more than its tolerance of {tolerance} allows: allow more, refine what it is asked of, or (edges that should meet) leave the tolerance out, for edges that are made one where that can be",
        error = figure(*error),
        tolerance = figure(*tolerance)
    )]
    OutOfTolerance {
        /// What is missed.
        constraint: String,
        /// By how much, at most: between the places where it was imposed, too.
        error: f64,
        /// What was allowed.
        tolerance: f64,
    },
    /// An answer that does not hold between the places where it was imposed: it is not handed out.
    #[error("{constraint} would not hold all along: {found}; {remedy}")]
    Between {
        /// What is missed.
        constraint: String,
        /// What was found there, in its own quantities.
        found: String,
        /// What to do.
        remedy: String,
    },
    /// Constraints that all hold only by an adjustment out of all proportion to what each of them asks.
    #[error(
        "{names} nearly contradict one another (condition {condition}): to meet them all, control vertices would go {length}, {times} times as far as each alone would take; release one of them, ask the same of those whose places are so near, move the places apart, or say force = true to take it",
        names = constraints.join(", "),
        condition = short(*condition),
        length = short(*length),
        times = short(*times)
    )]
    NearConflict {
        /// The constraints that fight each other, as people know them.
        constraints: Vec<String>,
        /// Estimate of the condition number of the equations.
        condition: f64,
        /// The length of the adjustment, in the metric.
        length: f64,
        /// How many times as long that is as what each equation alone would cost, all together.
        times: f64,
    },
    /// Constraints that cannot all hold; the text names them and says what could be done.
    #[error("{text}")]
    Conflict {
        /// The constraints of the contradiction, as people know them, none of which could be spared.
        constraints: Vec<String>,
        /// A knot that would resolve it, where one that was tried does.
        knot: Option<f64>,
        /// All of it in words.
        text: String,
    },
    /// The constraints need something that the solver does not do.
    #[error("{0}")]
    Unsupported(String),
    /// A nonlinear problem whose iterations did not arrive.
    #[error(
        "not solved after {iterations} iterations: the largest constraint error is still {residual} (in {worst}); ask for less at once",
        residual = figure(*residual)
    )]
    NotConverged {
        /// Iterations made.
        iterations: usize,
        /// The largest constraint error that is left.
        residual: f64,
        /// The constraint that has it.
        worst: String,
    },
    /// A nonlinear problem whose constraints are met, but whose adjustment is not yet the least one.
    #[error(
        "not solved after {iterations} iterations: every constraint is met, but beside {beside} the adjustment still changes by {change} of itself, so it is not the least one; ask for less at once",
        change = short(*change)
    )]
    StillMoving {
        /// Iterations made.
        iterations: usize,
        /// The last change of the adjustment, relative to the adjustment.
        change: f64,
        /// The constraints that are not linear.
        beside: String,
    },
    /// Constraints that cannot all hold, whose least squares were not found.
    #[error(
        "the least squares were not found after {iterations} iterations: what {beside} miss{} could still be less, and looking on costs too much; ask for less at once",
        if beside.contains(", ") { "" } else { "es" }
    )]
    NotLeast {
        /// Iterations made.
        iterations: usize,
        /// The slope of the sum of squares that is left, as a share of what the misses could pull together.
        slope: f64,
        /// The constraints that are not linear.
        beside: String,
    },
}
