//! Which shape of a problem a functional looks at.

use std::fmt;
use std::sync::Arc;

use super::ShapeNames;
use super::at::At;
use crate::declare::{ParameterError, Parameters};
use crate::direction;
use crate::error::Error;
use crate::shape::Location;

/// A shape of a problem: its number, and its name where it has one. The default is the first shape. Two are equal that have the
/// same number: names are for messages.
#[derive(Debug, Clone, Eq, Default)]
pub struct On {
    /// The number of the shape.
    pub shape: usize,
    /// The name that messages give it.
    pub name: Option<Arc<str>>,
}

impl On {
    /// The shape that the field `object` names, or the first one where the field is left out.
    ///
    /// # Errors
    /// When there is no such object or it cannot be edited.
    pub fn from_parameters(
        parameters: &Parameters,
        names: &mut dyn ShapeNames,
    ) -> Result<Self, ParameterError> {
        if !parameters.has("object") {
            return Ok(Self::default());
        }
        let name = parameters.text("object")?;
        let shape = names.shape(name).map_err(|e| parameters.error("object", e.to_string()))?;
        Ok(Self { shape, name: Some(name.into()) })
    }
}

impl PartialEq for On {
    fn eq(&self, other: &Self) -> bool {
        self.shape == other.shape
    }
}

impl From<usize> for On {
    fn from(shape: usize) -> Self {
        Self { shape, name: None }
    }
}

impl fmt::Display for On {
    /// Nothing for the first shape, else ` of "name"` or ` of shape 1`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (&self.name, self.shape) {
            (Some(name), _) => write!(f, " of \"{name}\""),
            (None, 0) => Ok(()),
            (None, shape) => write!(f, " of shape {shape}"),
        }
    }
}

/// The field `at` of a kind that is asked of curves only.
///
/// # Errors
/// When it is missing or wrong; when it is a location on a surface, saying so.
pub(super) fn curve_location(parameters: &Parameters) -> Result<f64, ParameterError> {
    match parameters.location("at")? {
        Location::Curve(u) => Ok(u),
        at => Err(parameters.error("at", of_curves(at))),
    }
}

/// The fields `at` or `near` of a kind that is asked of curves only.
///
/// # Errors
/// As for [`curve_location`].
pub(super) fn curve_at(parameters: &Parameters) -> Result<At, ParameterError> {
    let at = At::from_parameters(parameters)?;
    match at.location {
        Location::Curve(_) => Ok(at),
        location => Err(parameters.error(if at.floats { "near" } else { "at" }, of_curves(location))),
    }
}

/// Refuses a location that is not on a curve.
///
/// # Errors
/// When it is not.
pub(super) fn of_a_curve(location: Location, name: impl FnOnce() -> String) -> Result<(), Error> {
    match location {
        Location::Curve(_) => Ok(()),
        at => Err(Error::Invalid(format!("{}: {}", name(), of_curves(at)))),
    }
}

fn of_curves(at: Location) -> String {
    let isocurve = if matches!(at, Location::Surface(..)) { ", or of an isocurve" } else { "" };
    format!(
        "this is asked of a curve, at one parameter, and {at} is a location on a surface; there, ask for a position, a derivative or the \
         normal{isocurve}"
    )
}

/// Two unit vectors that are perpendicular to `axis` and to each other, right-handed with it; `None` where `axis`
/// has no direction. The first is as near as can be to `prefer`, where that is not parallel.
pub(super) fn perpendiculars(axis: &crate::Vector, prefer: &crate::Vector) -> Option<[crate::Vector; 2]> {
    let axis = direction(axis)?;
    let rest = |v: &crate::Vector| {
        let v = direction(v)?;
        // Twice, so that what is left is perpendicular to rounding even where v is nearly parallel.
        let once = v - axis * axis.dot(&v);
        let twice = once - axis * axis.dot(&once);
        (once.norm() > 1e-6).then(|| direction(&twice)).flatten()
    };
    // The coordinate axis that is least parallel: never fails.
    let least = crate::Vector::ith(axis.iamin(), 1.0);
    let first = rest(prefer).or_else(|| rest(&least))?;
    Some([first, axis.cross(&first)])
}
