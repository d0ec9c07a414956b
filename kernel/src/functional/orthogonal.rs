//! A curve's tangent perpendicular to a direction.

use super::at::{ALONG_CURVE, At, DIRECTION, at_a_place, direction};
use super::on::{curve_at, of_a_curve};
use super::position::OBJECT;
use super::{DeclaredFunctional, Functional, Linearity, On, Rows, ShapeNames, Shapes, derivative, tangent};
use crate::Vector;
use crate::declare::{Declaration, ParameterError, Parameters};
use crate::error::{Error, Result};
use crate::shape::Derivative;

/// `C'·v = 0`: one linear equation that couples the axes; zero where it holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Orthogonal {
    on: On,
    at: At,
    direction: Vector,
}

/// The tangent at `u`, or [near](super::near()) one, which floats, orthogonal to a direction.
pub fn orthogonal(at: impl Into<At>, direction: impl Into<Vector>) -> Orthogonal {
    Orthogonal { on: On::default(), at: at.into(), direction: direction.into() }
}

impl Orthogonal {
    /// The same on another shape of the problem.
    #[must_use]
    pub fn on(mut self, shape: impl Into<On>) -> Self {
        self.on = shape.into();
        self
    }

    fn unit(&self) -> Result<Vector> {
        crate::direction(&self.direction).ok_or_else(|| {
            Error::Invalid(format!("{}: the direction is the zero vector; give one", self.describe()))
        })
    }
}

impl Functional for Orthogonal {
    fn equations(&self) -> usize {
        1
    }

    fn linearity(&self) -> Linearity {
        if self.at.floats { Linearity::Nonlinear } else { Linearity::Linear }
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        self.along_rows(shapes, Derivative::POSITION, rows)
    }

    fn describe(&self) -> String {
        let [x, y, z] = [self.direction.x, self.direction.y, self.direction.z];
        format!("orthogonal to [{x}, {y}, {z}] {}{}", self.at, self.on)
    }

    fn supersedes(&self, companion: &dyn Functional) -> bool {
        let on = || self.on.clone();
        let at = self.at.location;
        derivative(at, 1).on(on()).same_as(companion) || tangent(at).on(on()).same_as(companion)
    }

    at_a_place!();

    fn along(&self, shapes: &Shapes<'_>, order: Derivative, out: &mut [f64]) -> Result<()> {
        let order = Derivative { u: 1 + order.u, v: order.v };
        let value = shapes.value(self.on.shape, self.at.location, order)?.dot(&self.unit()?);
        out.fill(value);
        Ok(())
    }

    fn along_rows(&self, shapes: &Shapes<'_>, order: Derivative, rows: &mut Rows<'_>) -> Result<()> {
        of_a_curve(self.at.location, || self.describe())?;
        let order = Derivative { u: 1 + order.u, v: order.v };
        let stencil = shapes.stencil(self.on.shape, self.at.location, order)?;
        rows.equation().along(self.on.shape, &stencil, self.unit()?);
        Ok(())
    }

    fn takes_derivatives(&self) -> usize {
        1
    }

    fn notes(&self) -> Vec<String> {
        self.at.note(|| self.describe())
    }

    fn is_condition(&self) -> bool {
        true
    }
}

impl DeclaredFunctional for Orthogonal {
    const DECLARATION: Declaration = Declaration {
        name: "orthogonal",
        help: "the tangent C' perpendicular to a direction",
        fields: &[ALONG_CURVE[0], ALONG_CURVE[1], DIRECTION[0], DIRECTION[1], OBJECT],
    };

    fn from_parameters(parameters: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
        let at = curve_at(parameters)?;
        Ok(Self { on: On::from_parameters(parameters, names)?, at, direction: direction(parameters)? })
    }
}
