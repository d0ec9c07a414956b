//! What can be wrong with geometry: one variant a defect, with the indices and values that show it.

use crate::text::clip;

/// The result of a geometric computation.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// The largest polynomial degree that a spline may have.
pub const MAX_DEGREE: usize = 25;

/// A number in a message: with all its digits, but not with hundreds of zeros.
#[derive(Debug, Clone, Copy)]
pub struct Figure(pub f64);

impl std::fmt::Display for Figure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self(number) = self;
        if *number == 0.0 || !number.is_finite() || (1e-7..1e16).contains(&number.abs()) {
            write!(f, "{number}")
        } else {
            write!(f, "{number:e}")
        }
    }
}

/// A parameter outside a domain, in six figures, or in all of them where six would not show that it is.
fn outside(value: f64, start: f64, end: f64) -> String {
    let all = [value, start, end];
    let short = all.map(crate::text::measured);
    let [at, low, high] = short.each_ref().map(|text| text.parse().unwrap_or(f64::NAN));
    let [value, start, end] =
        if at < low || at > high { short } else { all.map(|number| Figure(number).to_string()) };
    format!("{value} is outside the domain [{start}, {end}]: choose a location within it")
}

/// What is wrong with a shape, a location or a request. Every message says what was found and what to do.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// A degree outside `1 ..= 25` (or `0 ..= 25` where a space of piecewise constants makes sense).
    #[error("degree {degree} is not supported: choose a degree from 1 to {MAX_DEGREE}")]
    Degree {
        /// The degree that was asked for.
        degree: usize,
    },
    /// The number of knots does not fit the number of control vertices and the degree.
    #[error(
        "{knots} knots do not fit {vertices} control vertices of degree {degree}: {kind} shape needs {expected}"
    )]
    KnotCount {
        /// Knots found.
        knots: usize,
        /// Control vertices found.
        vertices: usize,
        /// The degree.
        degree: usize,
        /// `"an open"` or `"a periodic"`.
        kind: &'static str,
        /// Knots needed.
        expected: usize,
    },
    /// Too few control vertices (or knots) for the degree.
    #[error("{vertices} control vertices are too few for degree {degree}: at least {needed} are needed")]
    TooFewVertices {
        /// Control vertices found.
        vertices: usize,
        /// The degree.
        degree: usize,
        /// Control vertices needed.
        needed: usize,
    },
    /// A knot is NaN or infinite.
    #[error("knot {index} is {value}: every knot must be a finite number")]
    KnotNotFinite {
        /// Its index.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// The knots decrease somewhere.
    #[error("knot {index} is {}, less than the knot before it ({}): knots must not decrease", Figure(*.value), Figure(*.before))]
    KnotOrder {
        /// The index of the smaller knot.
        index: usize,
        /// The knot before it.
        before: f64,
        /// Its value.
        value: f64,
    },
    /// A knot is repeated more often than continuity allows.
    #[error(
        "knot {} is repeated {multiplicity} times: degree {degree} allows {allowed} there, more would tear the shape",
        Figure(*.value)
    )]
    Multiplicity {
        /// The knot's value.
        value: f64,
        /// How often it occurs.
        multiplicity: usize,
        /// The degree.
        degree: usize,
        /// The largest multiplicity allowed.
        allowed: usize,
    },
    /// The domain has no length, or one that overflows.
    #[error("the domain from {} to {} has no usable length: spread the knots", Figure(*.start), Figure(*.end))]
    EmptyDomain {
        /// Where the domain starts.
        start: f64,
        /// Where it ends.
        end: f64,
    },
    /// A control vertex has a coordinate that is NaN or infinite.
    #[error("control vertex {index} is ({}, {}, {}): every coordinate must be a finite number", Figure(*.x), Figure(*.y), Figure(*.z))]
    VertexNotFinite {
        /// Its index.
        index: usize,
        /// Its x coordinate.
        x: f64,
        /// Its y coordinate.
        y: f64,
        /// Its z coordinate.
        z: f64,
    },
    /// A weight is not a positive finite number.
    #[error("weight {index} is {}: every weight must be positive and finite", Figure(*.value))]
    Weight {
        /// Its index.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// The number of weights differs from the number of control vertices.
    #[error("{weights} weights do not fit {vertices} control vertices: give one weight a vertex, or none")]
    WeightCount {
        /// Weights found.
        weights: usize,
        /// Control vertices found.
        vertices: usize,
    },
    /// The control net is not a full grid.
    #[error(
        "row {row} of the control net has {found} vertices, not {expected}: every row must be equally long"
    )]
    Grid {
        /// The row.
        row: usize,
        /// Its length.
        found: usize,
        /// The length it should have.
        expected: usize,
    },
    /// A parameter outside the domain of an open shape.
    #[error("{}", outside(*.value, *.start, *.end))]
    Outside {
        /// The parameter.
        value: f64,
        /// Where the domain starts.
        start: f64,
        /// Where the domain ends.
        end: f64,
    },
    /// A location with one parameter for a surface, or with two for a curve.
    #[error("{}", location_kind(*.found, *.expected))]
    LocationKind {
        /// Parameters given.
        found: usize,
        /// Parameters that the shape has.
        expected: usize,
    },
    /// A derivative order that the shape cannot be asked for.
    #[error("a derivative of order {order} is beyond what can be asked ({MAX_DEGREE})")]
    DerivativeOrder {
        /// The order asked for.
        order: usize,
    },
    /// A control vertex that does not exist.
    #[error("there is no control vertex {index}: the shape has {count}, numbered 0 to {last} (or -1 to -{count} from the end)", last = count.saturating_sub(1))]
    NoVertex {
        /// The index asked for.
        index: i64,
        /// Vertices that there are.
        count: usize,
    },
    /// A mesh face that cannot be.
    #[error("face {face} {problem}")]
    Face {
        /// Its index.
        face: usize,
        /// What is wrong and what to do.
        problem: String,
    },
    /// A shape of a kind that no registered plug-in brings: what a document says of it is kept, and nothing else is
    /// known.
    #[error(
        "its shape is of the kind \"{}\", whose plug-in is not here: register the plug-in to use it",
        clip(.kind)
    )]
    UnknownKind {
        /// The kind's name in documents.
        kind: String,
    },
    /// A location on a face or at a vertex where the shape is one patch or a curve.
    #[error(
        "a face or a vertex is a location on a surface of many faces, such as a subdivision surface, and this shape is none: give \
         {wanted}"
    )]
    FaceLocation {
        /// What is a location here.
        wanted: &'static str,
    },
    /// A shape of which nothing can be seen, since all of it is one point, or a surface that is a line.
    #[error("{0}")]
    NoExtent(String),
    /// Something that is well formed and still cannot be done; the text says why and what to do.
    #[error("{0}")]
    Invalid(String),
}

/// Said of the location, which is what was written; the shape it is meant for may not be known yet.
fn location_kind(found: usize, expected: usize) -> &'static str {
    match (found, expected) {
        (2, 1) => "[u, v] is a location on a surface, and this is asked of a curve: give one parameter u",
        (1, 2) => "one parameter is a location on a curve, and this is asked of a surface: give [u, v]",
        _ => {
            "the location has another number of parameters than the shape: one on a curve, [u, v] on a surface"
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_their_digits_and_no_more() {
        let shown =
            [0.0, -0.25, 1e15, 1.7e308, -1e-300, f64::NAN, f64::NEG_INFINITY].map(|x| Figure(x).to_string());
        assert_eq!(shown, ["0", "-0.25", "1000000000000000", "1.7e308", "-1e-300", "NaN", "-inf"]);
        let error = Error::VertexNotFinite { index: 2, x: 1.5e308, y: f64::INFINITY, z: -1e300 };
        assert!(error.to_string().starts_with("control vertex 2 is (1.5e308, inf, -1e300)"), "{error}");
    }

    #[test]
    fn places_outside_of_a_domain_have_as_many_figures_as_show_it() {
        let turn = std::f64::consts::TAU;
        for (value, end, told) in [
            (9.0, turn, "9 is outside the domain [0, 6.28319]"),
            (1.5, 1.0, "1.5 is outside the domain [0, 1]"),
            (-1e-9, turn, "-1e-9 is outside the domain [0, 6.28319]"),
            // Whoever takes the end from such a message is told why that is none.
            ((turn * 1e5).round() / 1e5, turn, "6.28319 is outside the domain [0, 6.283185307179586]"),
            (1.0 + f64::EPSILON, 1.0, "1.0000000000000002 is outside the domain [0, 1]"),
            (f64::NAN, turn, "NaN is outside the domain [0, 6.283185307179586]"),
            (f64::INFINITY, 1.0, "inf is outside the domain [0, 1]"),
        ] {
            let text = Error::Outside { value, start: 0.0, end }.to_string();
            assert!(text.starts_with(told), "{text}");
        }
    }
}
