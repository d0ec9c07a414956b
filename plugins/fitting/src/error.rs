//! What can keep points from becoming a curve: one variant a reason, with the numbers that show it.

use loftsman_kernel::error::Figure;
use loftsman_kernel::plugin::OperationError;
use loftsman_kernel::text::{counted, figure, short};

/// The result of a fit.
pub type Result<T, E = FitError> = std::result::Result<T, E>;

/// Why points could not be fitted. Every message says what was found and what to do.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FitError {
    /// A coordinate is NaN or infinite.
    #[error("point {index} is ({}, {}, {}): every coordinate must be a finite number", Figure(*.x), Figure(*.y), Figure(*.z))]
    PointNotFinite {
        /// Its index.
        index: usize,
        /// Its x.
        x: f64,
        /// Its y.
        y: f64,
        /// Its z.
        z: f64,
    },
    /// Fewer points than the degree needs.
    #[error("{found} distinct points are too few{}", too_few(*.needed, *.degree, *.possible))]
    TooFewPoints {
        /// Points found.
        found: usize,
        /// Points needed.
        needed: usize,
        /// The degree asked for.
        degree: usize,
        /// The highest degree that would do; 0 where none does.
        possible: usize,
    },
    /// All points are one point.
    #[error("all {count} points are the same point: a curve needs at least two places to go through")]
    AllEqual {
        /// How many there are.
        count: usize,
    },
    /// Neighbouring points that no parametrization can tell apart.
    #[error(
        "{count} points coincide with the point before them (first: {}): remove them, or ask for them to be merged",
        list(.indices)
    )]
    Coincident {
        /// The indices of the later point of each pair, at most eight.
        indices: Vec<usize>,
        /// How many there are.
        count: usize,
    },
    /// Another number of parameters than of points.
    #[error("{parameters} parameters do not fit {points} points: give one parameter a point")]
    ParameterCount {
        /// Parameters found.
        parameters: usize,
        /// Points found.
        points: usize,
    },
    /// A parameter that is not finite, leaves the domain, or decreases (or stands still where it must not).
    #[error(
        "parameter {index} is {}: parameters must be finite, increase, and stay within [{}, {}]",
        Figure(*.value), Figure(*.start), Figure(*.end)
    )]
    Parameter {
        /// Its index.
        index: usize,
        /// Its value.
        value: f64,
        /// Where the domain starts.
        start: f64,
        /// Where the domain ends.
        end: f64,
    },
    /// Too few weights, or too many.
    #[error("{} for {}: give one positive, finite weight a point", counted(*.found, "weight[|s]"), counted(*.points, "point[|s]"))]
    Weights {
        /// How many there are.
        found: usize,
        /// How many there should be.
        points: usize,
    },
    /// A weight that is not positive.
    #[error("weight {index} is {}: give one positive, finite weight a point", Figure(*.value))]
    Weight {
        /// Its index.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// The data do not reach one of the basis functions (the Schoenberg–Whitney conditions fail).
    #[error(
        "no data determine control vertex {vertex}, which acts between {} and {}: remove the knot {}, give more points there, or ask for regularization",
        Figure(*.start), Figure(*.end), Figure(*.knot)
    )]
    NoData {
        /// The vertex.
        vertex: usize,
        /// Where its influence starts.
        start: f64,
        /// Where it ends.
        end: f64,
        /// A knot whose removal helps.
        knot: f64,
    },
    /// The equations are so nearly dependent that their solution would be noise.
    #[error(
        "the equations are singular to working precision (condition {condition}, near parameter {near}): {advice}",
        condition = short(*condition)
    )]
    IllConditioned {
        /// Estimate of the condition number; infinite where exactly singular.
        condition: f64,
        /// The parameter where the weakest pivot is.
        near: f64,
        /// What to do.
        advice: &'static str,
    },
    /// The tolerance could not be met; the largest error of the best curve is a tolerance that can.
    #[error(
        "the tolerance {tolerance} is not met: {vertices} control vertices come as near as {error} (at point {worst}); {advice}",
        tolerance = figure(*tolerance),
        error = figure(*error)
    )]
    NotMet {
        /// What was asked for, in document units.
        tolerance: f64,
        /// The largest distance of a point from the curve.
        error: f64,
        /// The point that has it.
        worst: usize,
        /// Control vertices used.
        vertices: usize,
        /// What to do.
        advice: &'static str,
    },
    /// The curve, though it is near the points, does not go where they go.
    #[error("the curve {astray}: it goes astray between the points; {advice}")]
    Astray {
        /// How.
        astray: Astray,
        /// What to do.
        advice: &'static str,
    },
    /// A request that cannot be; the text says why and what to do.
    #[error("{0}")]
    Request(String),
    /// A constraint that contradicts others.
    #[error("the constraint \"{name}\" contradicts {}: release one of them", quote(.with))]
    Conflict {
        /// Its name.
        name: String,
        /// The names of those it contradicts.
        with: Vec<String>,
    },
    /// A constraint that the curve, measured, does not meet.
    #[error(
        "the fitted curve misses the constraint \"{name}\" by {error} where rounding allows {allowed}: hold fewer constraints that are near one another, or allow more control vertices",
        error = figure(*error),
        allowed = short(*allowed)
    )]
    Missed {
        /// Its name.
        name: String,
        /// By how much its value is missed.
        error: f64,
        /// What its accuracy allows.
        allowed: f64,
    },
    /// A constraint that a fit cannot hold.
    #[error("the constraint \"{name}\" cannot be held by a fit: {reason}")]
    Constraint {
        /// Its name.
        name: String,
        /// Why not, and what to do.
        reason: String,
    },
    /// Control vertices that neither points nor energies nor constraints determine.
    #[error(
        "points, energies and constraints determine {rank} of {vertices} control vertices, and vertex {first} is the first that is left \
         open: give points where it acts, add an energy, or lock it"
    )]
    Undetermined {
        /// The rank of the equations, of each coordinate.
        rank: usize,
        /// The control vertices that may move.
        vertices: usize,
        /// The first that is not determined by those before it.
        first: usize,
    },
    /// Constraints that cannot be met.
    #[error(transparent)]
    Equations(loftsman_kernel::edit::EditError),
    /// Something of the geometry.
    #[error(transparent)]
    Geometry(#[from] loftsman_kernel::Error),
    /// The observer stopped it.
    #[error("cancelled")]
    Cancelled,
}

impl From<FitError> for OperationError {
    fn from(error: FitError) -> Self {
        match error {
            FitError::Geometry(error) => Self::Geometry(error),
            FitError::Cancelled => Self::Cancelled,
            FitError::Equations(error) => error.into(),
            other => Self::Geometry(loftsman_kernel::Error::Invalid(other.to_string())),
        }
    }
}

fn too_few(needed: usize, degree: usize, possible: usize) -> String {
    if possible == 0 {
        return format!(": give {needed} or more");
    }
    format!(" for degree {degree} ({needed} are needed): give more points, or a degree of at most {possible}")
}

fn list(indices: &[usize]) -> String {
    indices.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

fn quote(names: &[String]) -> String {
    names.iter().map(|n| format!("\"{n}\"")).collect::<Vec<_>>().join(", ")
}

/// How a curve goes astray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Astray {
    /// It is so many times as long as the polygon of the points.
    Long(f64),
    /// From this point to the next it is so many times as long as the polygon about there.
    Detour(usize, f64),
    /// It passes this point against the direction of the points.
    Back(usize),
    /// It leaves the box of the points by so many times the longest side of that.
    Outside(f64),
}

impl Astray {
    /// The same, said of points that are counted from elsewhere.
    pub(crate) fn renumbered(self, number: impl Fn(usize) -> usize) -> Self {
        match self {
            Self::Long(ratio) => Self::Long(ratio),
            Self::Detour(k, ratio) => Self::Detour(number(k), ratio),
            Self::Back(k) => Self::Back(number(k)),
            Self::Outside(share) => Self::Outside(share),
        }
    }
}

impl std::fmt::Display for Astray {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Long(ratio) => write!(f, "is {ratio:.3} times as long as the polygon of the points"),
            Self::Detour(k, ratio) => {
                write!(f, "is {ratio:.3} times as long as the polygon just behind point {k}")
            }
            Self::Back(k) => write!(f, "turns back at point {k}"),
            Self::Outside(share) => {
                write!(f, "leaves the box of the points by {share:.3} times the longest side of that")
            }
        }
    }
}
