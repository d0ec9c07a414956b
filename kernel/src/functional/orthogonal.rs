//! A curve's tangent perpendicular to a direction.

use super::on::curve_location;
use super::position::{AT_ON_CURVE, OBJECT};
use super::{DeclaredFunctional, Functional, Linearity, On, Rows, ShapeNames, Shapes, derivative, tangent};
use crate::Vector;
use crate::declare::{Declaration, Field, ParameterError, Parameters};
use crate::error::{Error, Result};
use crate::shape::Location;

/// `C'·v = 0`: one linear equation that couples the axes; zero where it holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Orthogonal {
    on: On,
    at: f64,
    to: Vector,
}

/// The tangent at `u` orthogonal to a direction.
pub fn orthogonal(at: f64, to: impl Into<Vector>) -> Orthogonal {
    Orthogonal { on: On::default(), at, to: to.into() }
}

impl Orthogonal {
    /// The same on another shape of the problem.
    #[must_use]
    pub fn on(mut self, shape: impl Into<On>) -> Self {
        self.on = shape.into();
        self
    }
}

impl Functional for Orthogonal {
    fn equations(&self) -> usize {
        1
    }

    fn linearity(&self) -> Linearity {
        Linearity::Linear
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        let stencil = shapes.stencil(self.on.shape, Location::Curve(self.at), 1.into())?;
        let direction = crate::direction(&self.to).ok_or_else(|| {
            Error::Invalid(format!("{}: the direction is the zero vector; give one", self.describe()))
        })?;
        rows.equation().along(self.on.shape, &stencil, direction);
        Ok(())
    }

    fn describe(&self) -> String {
        format!("orthogonal to [{}, {}, {}] at {}{}", self.to.x, self.to.y, self.to.z, self.at, self.on)
    }

    fn supersedes(&self, companion: &dyn Functional) -> bool {
        let on = || self.on.clone();
        derivative(self.at, 1).on(on()).same_as(companion) || tangent(self.at).on(on()).same_as(companion)
    }

    fn location(&self) -> Option<(usize, Location)> {
        Some((self.on.shape, Location::Curve(self.at)))
    }

    fn is_condition(&self) -> bool {
        true
    }
}

impl DeclaredFunctional for Orthogonal {
    const DECLARATION: Declaration = Declaration {
        name: "orthogonal",
        help: "the tangent C' perpendicular to a direction",
        fields: &[AT_ON_CURVE, Field::required("to", "[x, y, z]", "the direction"), OBJECT],
    };

    fn from_parameters(parameters: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
        let at = curve_location(parameters)?;
        Ok(Self { on: On::from_parameters(parameters, names)?, at, to: parameters.vector("to")? })
    }
}
