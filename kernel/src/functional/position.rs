//! Where a shape passes.

use super::at::{AT_OR_NEAR, At, at_a_place};
use super::{DeclaredFunctional, Functional, Linearity, On, Rows, ShapeNames, Shapes, equals};
use crate::declare::{Declaration, Field, ParameterError, Parameters};
use crate::error::Result;
use crate::shape::Derivative;

/// The point of a shape at a location, `Σ S_i P_i`: three linear equations that share the stencil (paper 4,
/// equation (e 7)).
#[derive(Debug, Clone, PartialEq)]
pub struct Position {
    on: On,
    at: At,
}

/// The position at a location: `u` on a curve, `[u, v]` on a surface; or [near](super::near()) one, which floats.
pub fn position(at: impl Into<At>) -> Position {
    Position { on: On::default(), at: at.into() }
}

impl Position {
    /// The same on another shape of the problem.
    #[must_use]
    pub fn on(mut self, shape: impl Into<On>) -> Self {
        self.on = shape.into();
        self
    }
}

impl Functional for Position {
    fn equations(&self) -> usize {
        3
    }

    fn linearity(&self) -> Linearity {
        if self.at.floats { Linearity::Nonlinear } else { Linearity::Linear }
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        rows.alike(self.on.shape, &shapes.stencil(self.on.shape, self.at.location, Derivative::POSITION)?);
        Ok(())
    }

    fn value(&self, shapes: &Shapes<'_>, out: &mut [f64]) -> Result<()> {
        let value = shapes.value(self.on.shape, self.at.location, Derivative::POSITION)?;
        out.copy_from_slice(value.as_slice());
        Ok(())
    }

    fn linearize(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>, value: &mut [f64]) -> Result<()> {
        rows.linearize_alike(
            self.on.shape,
            &shapes.stencil(self.on.shape, self.at.location, Derivative::POSITION)?,
            value,
        )
    }

    fn describe(&self) -> String {
        format!("position {}{}", self.at, self.on)
    }

    fn dimension(&self) -> Option<u8> {
        Some(1)
    }

    fn same_as(&self, other: &dyn Functional) -> bool {
        equals(self, other)
    }

    fn is_vector(&self) -> bool {
        true
    }

    at_a_place!();

    fn along(&self, shapes: &Shapes<'_>, order: Derivative, out: &mut [f64]) -> Result<()> {
        let value = shapes.value(self.on.shape, self.at.location, order)?;
        out.copy_from_slice(value.as_slice());
        Ok(())
    }

    fn along_rows(&self, shapes: &Shapes<'_>, order: Derivative, rows: &mut Rows<'_>) -> Result<()> {
        rows.alike(self.on.shape, &shapes.stencil(self.on.shape, self.at.location, order)?);
        Ok(())
    }

    fn notes(&self) -> Vec<String> {
        self.at.note(|| self.describe())
    }
}

/// The field of a kind that is asked of curves.
pub(super) const AT_ON_CURVE: Field =
    Field::required("at", "number, or { closest = [x, y, z] }", "the location: the curve's parameter");

/// The field that every kind has.
pub(super) const OBJECT: Field =
    Field::optional("object", "text", "the step's object", "another object of the scene to ask this of");

impl DeclaredFunctional for Position {
    const DECLARATION: Declaration = Declaration {
        name: "position",
        help: "where the shape passes",
        fields: &[AT_OR_NEAR[0], AT_OR_NEAR[1], OBJECT],
    };

    fn from_parameters(parameters: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
        Ok(Self { on: On::from_parameters(parameters, names)?, at: At::from_parameters(parameters)? })
    }
}
