//! What a recipe step runs.

use super::change::{AskedQuantity, ObjectChange};
use super::mark::Mark;
use super::registry::Registry;
use super::step::{editable, object_name};
use crate::declare::{Declaration, ParameterError, Parameters, Table};
use crate::edit::EditError;
use crate::error::Error;
use crate::problem::{ConstraintReport, Convergence, Smoothness};
use crate::scene::Scene;

/// Watches long work; every method does nothing by default.
pub trait Observer {
    /// `done` of `total` units of the current work are finished.
    fn progress(&self, work: &str, done: u64, total: u64) {
        let _ = (work, done, total);
    }

    /// Whether to stop as soon as possible.
    fn cancelled(&self) -> bool {
        false
    }

    /// Says how far the work is, and asks whether to go on.
    ///
    /// # Errors
    /// Where it is to stop.
    fn proceed(&self, work: &str, done: u64, total: u64) -> Result<(), Cancelled> {
        self.progress(work, done, total);
        if self.cancelled() { Err(Cancelled) } else { Ok(()) }
    }
}

/// The observer wants no more.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// An observer that watches nothing.
#[derive(Debug, Clone, Copy, Default)]
pub struct Quiet;

impl Observer for Quiet {}

impl Default for &dyn Observer {
    fn default() -> Self {
        &Quiet
    }
}

/// Tells the time, in seconds from any start. The kernel itself never reads a clock.
pub trait Clock {
    /// Seconds since some fixed moment.
    fn seconds(&self) -> f64;
}

/// A clock that stands still, for results that must not depend on time.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoClock;

impl Clock for NoClock {
    fn seconds(&self) -> f64 {
        0.0
    }
}

/// What travels along with an operation.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// Everything that is registered: functionals and solvers by name, the tessellator.
    pub registry: &'a Registry,
    /// Who watches.
    pub observer: &'a dyn Observer,
    /// The clock for the times in reports.
    pub clock: &'a dyn Clock,
}

impl<'a> Context<'a> {
    /// A context that nobody watches and where time stands still.
    pub fn quiet(registry: &'a Registry) -> Self {
        Self { registry, observer: &Quiet, clock: &NoClock }
    }
}

/// Why an operation could not be done.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum OperationError {
    /// A field is missing, unknown or wrong.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// The geometry does not allow it.
    #[error(transparent)]
    Geometry(#[from] Error),
    /// The constraints cannot be met.
    #[error(transparent)]
    Solve(#[from] crate::solve::SolveError),
    /// The observer stopped it.
    #[error("{Cancelled}")]
    Cancelled,
}

impl From<Cancelled> for OperationError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl From<EditError> for OperationError {
    fn from(error: EditError) -> Self {
        match error {
            EditError::Geometry(error) => error.into(),
            EditError::Solve(error) => error.into(),
        }
    }
}

/// What a step did. Fields that do not apply are left out when it is serialised.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
#[serde(default)]
pub struct StepReport {
    /// The operation.
    pub op: String,
    /// The object it worked on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub object: Option<String>,
    /// What the step changed, object by object; filled in by who runs the step, not by the operation.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub objects: Vec<ObjectChange>,
    /// Lengths, areas and volumes that it was asked to change, also those that are no object's own (an area across a direction, or of several together).
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub asked: Vec<AskedQuantity>,
    /// How many objects it left as they were; filled in by who runs the step.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unchanged: Option<usize>,
    /// The solver that was used.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solver: Option<String>,
    /// Scalar equations in the system.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub equations: Option<usize>,
    /// Independent ones among them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rank: Option<usize>,
    /// Whether what is asked contradicts itself and is met as nearly as can be, because only that was asked for.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub best_effort: bool,
    /// Constraints that were dropped because the others imply them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub redundant: Vec<String>,
    /// Largest constraint error after the step, in document units.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub residual: Option<f64>,
    /// Estimate of the condition number of the system.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub condition: Option<f64>,
    /// `(Σ‖dᵢ‖²)^½` over all control vertices.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub adjustment: Option<f64>,
    /// What was to be small, before and after.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy: Option<[f64; 2]>,
    /// Steps in time that were taken, where something moves.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steps: Option<usize>,
    /// Solves that were needed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub iterations: Option<usize>,
    /// How a nonlinear problem converged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub convergence: Option<Convergence>,
    /// The inequalities that hold with equality.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub active: Vec<String>,
    /// Time to prepare, in seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub prepare_seconds: Option<f64>,
    /// Median time of one event in seconds; where something moves, mean time of one step.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub event_seconds: Option<f64>,
    /// Each constraint: its name, its error after the step and its multiplier.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub constraints: Vec<ConstraintReport>,
    /// What was kept smooth without being asked, and the corners that appeared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub smooth: Option<Smoothness>,
    /// The area of what was made, in document units squared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub area: Option<f64>,
    /// The volume that it bounds, in document units cubed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub volume: Option<f64>,
    /// Numbers that only this operation has, by name: those that its notes tell in words, unrounded.
    #[serde(skip_serializing_if = "serde_json::Map::is_empty")]
    pub numbers: serde_json::Map<String, serde_json::Value>,
    /// Anything else worth saying.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// So many of the first notes are what the step was run for, in the user's quantities (how near, how many): they are told before
    /// how it was solved.
    #[serde(skip)]
    pub leading: usize,
    /// What nobody should overlook: the program says it on the standard error.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// What a picture of the step should mark.
    #[serde(skip)]
    pub marks: Vec<Mark>,
}

/// A step of a recipe: takes a scene and parameters, changes the scene and says what it did.
pub trait Operation: Send + Sync {
    /// Its name, help and fields. `op` is not among the fields; `object` is where it takes one.
    fn declaration(&self) -> Declaration;

    /// What the tables take that its fields list, where that is more than what every constraint takes: for help, and for checks.
    fn tables(&self) -> &'static [Table] {
        &[]
    }

    /// The object that it works on: the one that is named, or the only one that it can be. Places that a step points at are looked for on it. By default a curve, a
    /// surface or a shape of a plug-in.
    ///
    /// # Errors
    /// When there is none, or several.
    fn object(&self, scene: &Scene, parameters: &Parameters) -> Result<String, ParameterError> {
        object_name(scene, parameters, editable(scene), "curve or surface")
    }

    /// Does it. The scene is left as it was where this fails.
    ///
    /// # Errors
    /// When a parameter is wrong, the geometry does not allow it or the constraints cannot be met.
    fn apply(
        &self,
        scene: &mut Scene,
        parameters: &Parameters,
        context: &Context<'_>,
    ) -> Result<StepReport, OperationError>;
}
