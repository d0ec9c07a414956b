//! The length of a curve's first derivative.

use super::on::curve_location;
use super::position::{AT_ON_CURVE, OBJECT};
use super::{DeclaredFunctional, Functional, Linearity, On, Rows, ShapeNames, Shapes, derivative, equals};
use crate::declare::{Declaration, ParameterError, Parameters};
use crate::error::{Error, Result};
use crate::shape::Location;
use crate::text::figure;

/// `|C'(u)|`, the speed of the parametrisation: one nonlinear equation with gradient `S'_i C'/|C'|`. Keeping it and
/// the position while the direction turns is figure 2 (a) of paper 1; scaling it, figure 2 (b).
#[derive(Debug, Clone, PartialEq)]
pub struct Magnitude {
    on: On,
    at: f64,
}

/// The magnitude of the tangent vector at `u`.
pub fn magnitude(at: f64) -> Magnitude {
    Magnitude { on: On::default(), at }
}

impl Magnitude {
    /// The same on another shape of the problem.
    #[must_use]
    pub fn on(mut self, shape: impl Into<On>) -> Self {
        self.on = shape.into();
        self
    }
}

impl Functional for Magnitude {
    fn equations(&self) -> usize {
        1
    }

    fn linearity(&self) -> Linearity {
        Linearity::Nonlinear
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        let stencil = shapes.stencil(self.on.shape, Location::Curve(self.at), 1.into())?;
        let tangent = stencil.apply(shapes.get(self.on.shape)?.control_vertices());
        let direction = crate::direction(&tangent).ok_or_else(|| {
            let what = self.describe();
            Error::Invalid(format!(
                "{what}: C' vanishes there and has no direction to grow in; ask elsewhere"
            ))
        })?;
        rows.equation().along(self.on.shape, &stencil, direction);
        Ok(())
    }

    fn value(&self, shapes: &Shapes<'_>, out: &mut [f64]) -> Result<()> {
        let tangent = shapes.get(self.on.shape)?.value(Location::Curve(self.at), 1.into())?;
        if let Some(out) = out.first_mut() {
            *out = tangent.norm();
        }
        Ok(())
    }

    fn check_target(&self, _: &[f64], wanted: &[f64]) -> Result<()> {
        let Some(&wanted) = wanted.first().filter(|w| **w <= 0.0) else { return Ok(()) };
        let what = self.describe();
        Err(Error::Invalid(format!(
            "{what}: a length of {} cannot be; ask for one above 0 (to turn the tangent round, ask for the derivative)",
            figure(wanted)
        )))
    }

    fn supersedes(&self, companion: &dyn Functional) -> bool {
        derivative(self.at, 1).on(self.on.clone()).same_as(companion)
    }

    fn same_as(&self, other: &dyn Functional) -> bool {
        equals(self, other)
    }

    fn describe(&self) -> String {
        format!("tangent magnitude at {}{}", self.at, self.on)
    }

    fn location(&self) -> Option<(usize, Location)> {
        Some((self.on.shape, Location::Curve(self.at)))
    }
}

impl DeclaredFunctional for Magnitude {
    const DECLARATION: Declaration = Declaration {
        name: "magnitude",
        help: "the length of the tangent vector C'",
        fields: &[AT_ON_CURVE, OBJECT],
    };

    fn from_parameters(parameters: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
        let at = curve_location(parameters)?;
        Ok(Self { on: On::from_parameters(parameters, names)?, at })
    }
}
