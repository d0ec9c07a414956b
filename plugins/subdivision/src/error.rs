//! What can be wrong with a cage or a polygon.

/// The result of working with cages.
pub type Result<T, E = SubdivisionError> = std::result::Result<T, E>;

/// Why a cage cannot be made, refined or asked. Each message names the vertex, edge or face and says what to do.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SubdivisionError {
    /// A face that is none.
    #[error("face {face} {problem}")]
    Face {
        /// The face.
        face: usize,
        /// What is wrong with it, and what to do.
        problem: String,
    },
    /// A vertex where the faces do not make one fan, or with a coordinate that is no number.
    #[error("vertex {vertex} {problem}")]
    Vertex {
        /// The vertex.
        vertex: usize,
        /// What is wrong with it, and what to do.
        problem: String,
    },
    /// An edge with more than two faces, or that two faces run the same way.
    #[error("the edge between vertices {from} and {to} {problem}")]
    Edge {
        /// The vertex where it starts.
        from: usize,
        /// The vertex where it ends.
        to: usize,
        /// What is wrong with it, and what to do.
        problem: String,
    },
    /// Something was said of an edge that is not there.
    #[error(
        "there is no edge between vertices {from} and {to}: name two vertices that follow each other in a face"
    )]
    NoEdge {
        /// The vertex where it would start.
        from: usize,
        /// The vertex where it would end.
        to: usize,
    },
    /// A vertex, face, edge or level was asked for that is not there.
    #[error("there is no {what} {index}: there are {count}, counted from 0")]
    Missing {
        /// What was asked for.
        what: &'static str,
        /// Its index.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// A sharpness or interval that is negative or no number.
    #[error("the {what} of {place} is {value}: it must be {needed}")]
    Value {
        /// What it is.
        what: &'static str,
        /// Of which vertex or edge.
        place: String,
        /// The number given.
        value: f64,
        /// What it must be.
        needed: &'static str,
    },
    /// Something that was said twice, and not the same.
    #[error("the {what} of {place} is said twice, as {} and as {}: keep one", values[0], values[1])]
    Twice {
        /// What it is.
        what: &'static str,
        /// Of which vertex or edge.
        place: String,
        /// What was said first, and then.
        values: [f64; 2],
    },
    /// More vertices, edges or corners than 32 bits count.
    #[error("{what} are more than {limit}: refine less often, or in parts")]
    TooLarge {
        /// What would be too many.
        what: String,
        /// How many there may be.
        limit: usize,
    },
    /// A polygon that makes no curve.
    #[error("the polygon {problem}")]
    Polygon {
        /// What is wrong, and what to do.
        problem: String,
    },
    /// What the kernel refused.
    #[error(transparent)]
    Kernel(#[from] loftsman_kernel::Error),
}
