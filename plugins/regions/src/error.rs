//! What can be wrong with a region.

use loftsman_kernel::Error;
use loftsman_kernel::error::Figure;
use loftsman_kernel::plugin::OperationError;
use loftsman_kernel::text::a;
use loftsman_kernel::text::{figure, short};

/// The result of working with regions.
pub type Result<T, E = RegionError> = std::result::Result<T, E>;

/// Why a region cannot be filled or made a solid. Each message names the object and says what to do.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RegionError {
    /// An object that bounds nothing.
    #[error("\"{object}\" is {}: a region is bounded by closed curves or polylines", a(.kind))]
    Kind {
        /// The object.
        object: String,
        /// What it is.
        kind: String,
    },
    /// A curve that does not come back to its start, and no other that leads there.
    #[error(
        "\"{object}\" is open: its ends are {gap} apart, and no other of the curves given starts where it ends; name the curve that does, or say bridge = true for a straight line",
        gap = figure(*gap)
    )]
    Open {
        /// The object (the last of a chain).
        object: String,
        /// The distance.
        gap: f64,
    },
    /// Points off the plane.
    #[error(
        "\"{object}\" is not planar: it leaves the plane of the region by {distance}; bring its control vertices into one plane first",
        distance = figure(*distance)
    )]
    NotPlanar {
        /// The object.
        object: String,
        /// The largest distance.
        distance: f64,
    },
    /// An outline that bounds no area.
    #[error("\"{object}\" bounds no area: all of it lies on a line")]
    NoArea {
        /// The object.
        object: String,
    },
    /// An outline that meets itself.
    #[error("\"{object}\" crosses or touches itself at ({x}, {y}, {z}): cut it apart there, or move it")]
    SelfCrossing {
        /// The object.
        object: String,
        /// Where.
        x: f64,
        /// Where.
        y: f64,
        /// Where.
        z: f64,
    },
    /// An outline that is closed by a straight line, which meets it or another.
    #[error(
        "the straight line that closes \"{object}\" crosses or touches \"{other}\" at ({x}, {y}, {z}): name a curve that closes it instead, or move its ends"
    )]
    BridgeCrossing {
        /// The object that is closed.
        object: String,
        /// What the line meets: the same or another.
        other: String,
        /// Where.
        x: f64,
        /// Where.
        y: f64,
        /// Where.
        z: f64,
    },
    /// Two outlines that meet.
    #[error(
        "\"{first}\" and \"{second}\" cross or touch at ({x}, {y}, {z}): a hole must lie inside, and two outlines apart"
    )]
    Crossing {
        /// One object.
        first: String,
        /// The other.
        second: String,
        /// Where.
        x: f64,
        /// Where.
        y: f64,
        /// Where.
        z: f64,
    },
    /// A refinement that would need too many triangles.
    #[error(
        "triangles of size {size} would be {count}: at most {most} are made; ask for a larger size",
        size = figure(*size),
        count = short(*count),
        most = short(*most)
    )]
    TooFine {
        /// The size asked for.
        size: f64,
        /// How many triangles that takes.
        count: f64,
        /// The most there may be.
        most: f64,
    },
    /// A number that makes no sense.
    #[error("{what} is {}: {wanted}", Figure(*.value))]
    Number {
        /// What it is.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        wanted: &'static str,
    },
    /// A mesh whose open edges are not simple loops.
    #[error("the walls of \"{object}\" have an edge with more than two faces: they cannot be capped")]
    Walls {
        /// The object.
        object: String,
    },
    /// Sections that cannot be lofted.
    #[error("{0}")]
    Sections(String),
    /// The geometry does not allow it.
    #[error(transparent)]
    Geometry(#[from] Error),
}

impl From<RegionError> for OperationError {
    fn from(error: RegionError) -> Self {
        match error {
            RegionError::Geometry(error) => Self::Geometry(error),
            other => Self::Geometry(Error::Invalid(other.to_string())),
        }
    }
}
