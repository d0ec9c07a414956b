//! Where a functional looks: at a location, or near one, where that floats.

use std::fmt;

use crate::Vector;
use crate::declare::{Field, ParameterError, Parameters};
use crate::shape::Location;
use crate::text::measured;

/// A location, or one that floats.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct At {
    pub(super) location: Location,
    /// Where it starts, if it floats or has floated.
    from: Option<Location>,
    pub(super) floats: bool,
}

/// A location that was found, for people: in six figures.
fn told(at: Location) -> String {
    match at {
        Location::Curve(u) => measured(u),
        Location::Surface(u, v) => format!("[{}, {}]", measured(u), measured(v)),
        Location::Face(face, u, v) => format!("[{}, {}] of face {face}", measured(u), measured(v)),
        Location::Vertex(_) => at.to_string(),
    }
}

/// A location that floats: the functional holds wherever near here the least adjustment meets it. Its parameters are unknowns of
/// the problem, without weight: of all places from here on downhill, the adjustment is least at the one that is found.
///
/// ```
/// use loftsman_kernel::Point;
/// use loftsman_kernel::edit::{Ask, Edit};
/// use loftsman_kernel::functional::{near, position};
/// use loftsman_kernel::spline::{Curve, Space};
///
/// let points = (0..12).map(|i| Point::new(f64::from(i), 0.0, 0.0)).collect();
/// let curve = Curve::new(Space::clamped_uniform(3, 12)?, points)?;
/// // Through a point above the middle, wherever along the curve.
/// let moved = Edit::new(&curve).ask(position(near(4.0)).to([5.0, 1.0, 0.0])).solve()?;
/// let at = moved.report().constraints[0].location.clone().unwrap();
/// assert!((moved.shape().point(at[0])? - Point::new(5.0, 1.0, 0.0)).norm() < 1e-12);
/// assert!(moved.report().adjustment < 1.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn near(location: impl Into<Location>) -> At {
    let location = location.into();
    At { location, from: Some(location), floats: true }
}

impl At {
    /// Come to rest at a location.
    pub(super) fn moved(self, to: Location) -> Self {
        Self { location: to, floats: false, ..self }
    }

    /// Where it came to rest, for the report.
    pub(super) fn note(&self, name: impl FnOnce() -> String) -> Vec<String> {
        let rests = self.from.filter(|_| !self.floats);
        rests.map(|_| format!("{}: it holds at {}", name(), told(self.location))).into_iter().collect()
    }

    /// From the fields `at` or `near`.
    pub(super) fn from_parameters(parameters: &Parameters) -> Result<Self, ParameterError> {
        match (parameters.has("at"), parameters.has("near")) {
            (true, true) => Err(parameters
                .error("near", "stands beside \"at\": a location is given, or floats; give one of them")),
            (_, true) => parameters.location("near").map(near),
            (true, _) => parameters.location("at").map(Self::from),
            _ => {
                Err(parameters
                    .error("at", "a location is needed: give \"at\", or \"near\" for one that floats"))
            }
        }
    }
}

/// What functionals with a field `on` and a field `at` have in common: where they look, whether that floats, and how it moves.
macro_rules! at_a_place {
    () => {
        fn location(&self) -> Option<(usize, $crate::shape::Location)> {
            Some((self.on.shape, self.at.location))
        }

        fn floats(&self) -> bool {
            self.at.floats
        }

        fn moved(
            &self,
            to: $crate::shape::Location,
        ) -> Option<std::sync::Arc<dyn $crate::functional::Functional>> {
            Some(std::sync::Arc::new(Self { at: self.at.moved(to), ..self.clone() }))
        }

        fn slide(&mut self, to: $crate::shape::Location) -> bool {
            self.at.location = to;
            true
        }
    };
}
pub(super) use at_a_place;

/// The fields of a kind whose location may float.
pub(super) const AT_OR_NEAR: [Field; 2] = [
    Field::optional(
        "at",
        "number, [u, v] on a surface, { closest = [x, y, z] }, or on faces { face, uv } or { vertex }",
        "this or near is needed",
        "the location, in the shape's own parameters",
    ),
    Field::optional(
        "near",
        "number, [u, v] on a surface, or { closest = [x, y, z] }",
        "this or at is needed",
        "instead of at: the location floats, from here to where the change is least; not on faces",
    ),
];

/// The same of a kind that is asked of curves.
pub(super) const ALONG_CURVE: [Field; 2] = [
    Field::optional(
        "at",
        "number, or { closest = [x, y, z] }",
        "this or near is needed",
        "the location: the curve's parameter",
    ),
    Field::optional(
        "near",
        "number, or { closest = [x, y, z] }",
        "this or at is needed",
        "instead of at: the location floats, from here to where the change is least",
    ),
];

/// The direction of kinds that need one. It is called `direction` wherever there is one, and `to` in recipes as they were written first.
pub(super) const DIRECTION: [Field; 2] = [
    Field::optional(
        "direction",
        "[x, y, z]",
        "this or to is needed",
        "the direction; its length does not matter",
    ),
    Field::optional("to", "[x, y, z]", "this or direction is needed", "the same as direction"),
];

/// That direction, whichever way it is given.
pub(super) fn direction(parameters: &Parameters) -> Result<Vector, ParameterError> {
    match (parameters.has("direction"), parameters.has("to")) {
        (true, true) => Err(parameters.error("to", "direction says it already: leave one of them out")),
        (false, true) => parameters.vector("to"),
        _ => parameters.vector("direction"),
    }
}

/// The same of a kind that is asked of surfaces.
pub(super) const ON_SURFACE: [Field; 2] = [
    Field::optional(
        "at",
        "[u, v], { closest = [x, y, z] }, or on faces { face, uv } or { vertex }",
        "this or near is needed",
        "the location, in the surface's own parameters",
    ),
    Field::optional(
        "near",
        "[u, v], or { closest = [x, y, z] }",
        "this or at is needed",
        "instead of at: the location floats, from here to where the change is least; not on faces",
    ),
];

impl<T: Into<Location>> From<T> for At {
    fn from(location: T) -> Self {
        Self { location: location.into(), from: None, floats: false }
    }
}

impl fmt::Display for At {
    /// `at 0.4`, or `near 0.4` where it starts.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.from {
            None => write!(f, "at {}", self.location),
            Some(from) => write!(f, "near {from}"),
        }
    }
}
