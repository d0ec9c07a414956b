//! Why a simulation cannot be, or cannot go on: one variant a reason.

use loftsman_kernel::error::{Error, Figure};
use loftsman_kernel::plugin::OperationError;

/// The result of what a simulation does.
pub(crate) type Result<T, E = DynamicsError> = std::result::Result<T, E>;

/// Why a simulation could not be made, or stopped. Every message says what was found and what to do.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DynamicsError {
    /// A number that cannot be.
    #[error("{what} is {}: {needed}", Figure(*.value))]
    Number {
        /// What it is.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What is needed.
        needed: &'static str,
    },
    /// The shape has no extent somewhere, so that nothing can be stretched there.
    #[error(
        "the shape stands still at {at}: a rope or sheet needs a length everywhere before it can be stretched; remove repeated \
         control vertices (operation simplify), or fit a curve to its points"
    )]
    Collapsed {
        /// Where, by its parameters.
        at: String,
    },
    /// The mass matrix is not positive definite.
    #[error(
        "the mass matrix of the shape is singular to rounding at control vertex {vertex}: its basis functions hardly differ there (very high \
         degrees), or some have no part of the shape; fit a curve of lower degree, or simplify the shape"
    )]
    Massless {
        /// The control vertex.
        vertex: usize,
    },
    /// Constraints ask different things of the same.
    #[error("{}", contradiction(.names, *.apart))]
    Conflict {
        /// What they are called.
        names: Vec<String>,
        /// How far apart what they ask for is.
        apart: f64,
    },
    /// A location that is not on its shape.
    #[error("{constraint}: {} is not on the shape, whose parameters run from {} to {}", Figure(*.at), Figure(*.start), Figure(*.end))]
    Outside {
        /// The constraint, force or pull.
        constraint: String,
        /// The parameter.
        at: f64,
        /// Where the domain starts.
        start: f64,
        /// Where it ends.
        end: f64,
    },
    /// Something that is not linear in the control vertices.
    #[error(
        "{what} is not linear in the control vertices: a simulation can hold what is (positions, derivatives, sums of them)"
    )]
    NotLinear {
        /// What was asked.
        what: String,
    },
    /// There is no such thing in this simulation.
    #[error("there is no {what} {index} in this simulation: it has {count}")]
    Missing {
        /// What was looked for.
        what: &'static str,
        /// Its number.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// The numbers left all bounds.
    #[error(
        "the simulation blows up after {} s: steps of {} s are too long for it ({}); give a smaller step, or scheme \"implicit\"",
        Figure(*.time), Figure(*.step), what_is_stable(*.stable)
    )]
    BlowsUp {
        /// When.
        time: f64,
        /// The step that was taken.
        step: f64,
        /// What is known to be stable; infinite where nothing bounds it.
        stable: f64,
    },
    /// A step so short that the run would not end.
    #[error(
        "{} sub-steps would be needed for each step of {} s (stable ones are {} s long): the shape is very stiff for its mass; give scheme \
         \"implicit\", a lower stiffness, or more mass",
        Figure(*.needed), Figure(*.step), Figure(*.stable)
    )]
    TooStiff {
        /// Sub-steps.
        needed: f64,
        /// The step asked for.
        step: f64,
        /// The stable step.
        stable: f64,
    },
    /// What the kernel says.
    #[error(transparent)]
    Geometry(#[from] Error),
}

fn what_is_stable(step: f64) -> String {
    if step.is_finite() {
        format!("up to {} s are stable", Figure(step))
    } else {
        "forces or pulls are too large".into()
    }
}

fn contradiction(names: &[String], apart: f64) -> String {
    let all: Vec<String> = names
        .iter()
        .map(|name| if name.contains('"') { name.clone() } else { format!("\"{name}\"") })
        .collect();
    match &all[..] {
        [one] => format!(
            "{one} cannot hold: it misses by {} wherever the shape goes; correct what it asks",
            Figure(apart)
        ),
        _ => format!(
            "{} cannot all hold: what they ask for is {} apart; release one of them, or give them different locations or times",
            all.join(" and "),
            Figure(apart)
        ),
    }
}

impl From<DynamicsError> for OperationError {
    fn from(error: DynamicsError) -> Self {
        match error {
            DynamicsError::Geometry(error) => error.into(),
            other => Error::Invalid(other.to_string()).into(),
        }
    }
}

/// A number that must be finite and positive, or not negative.
pub(crate) fn check(what: &'static str, value: f64, zero: bool) -> Result<f64> {
    let fine = value.is_finite() && (value > 0.0 || zero && value == 0.0);
    let needed = if zero { "give a finite number, 0 or more" } else { "give a finite number above 0" };
    if fine { Ok(value) } else { Err(DynamicsError::Number { what, value, needed }) }
}
