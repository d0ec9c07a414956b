//! The normal of a surface.

use super::position::{AT_ON_SURFACE, OBJECT};
use super::{DeclaredFunctional, Functional, Linearity, On, Rows, ShapeNames, Shapes};
use crate::Vector;
use crate::declare::{Declaration, Field, ParameterError, Parameters};
use crate::error::{Error, Result};
use crate::shape::{Derivative, Location};

/// `S_u·n = S_v·n = 0`: two linear equations that couple the axes; zero where they hold.
#[derive(Debug, Clone, PartialEq)]
pub struct Normal {
    on: On,
    at: Location,
    to: Vector,
}

/// The surface normal at `(u, v)`, or at a place of a face, parallel to a direction.
pub fn normal(at: impl Into<Location>, to: impl Into<Vector>) -> Normal {
    Normal { on: On::default(), at: at.into(), to: to.into() }
}

impl Normal {
    /// The same on another shape of the problem.
    #[must_use]
    pub fn on(mut self, shape: impl Into<On>) -> Self {
        self.on = shape.into();
        self
    }
}

impl Functional for Normal {
    fn equations(&self) -> usize {
        2
    }

    fn linearity(&self) -> Linearity {
        Linearity::Linear
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        let direction = crate::direction(&self.to).ok_or_else(|| {
            Error::Invalid(format!("{}: the direction is the zero vector; give one", self.describe()))
        })?;
        for order in [Derivative { u: 1, v: 0 }, Derivative { u: 0, v: 1 }] {
            let stencil = shapes.stencil(self.on.shape, self.at, order)?;
            rows.equation().along(self.on.shape, &stencil, direction);
        }
        Ok(())
    }

    fn describe(&self) -> String {
        format!("normal at {}{}", self.at, self.on)
    }

    fn location(&self) -> Option<(usize, Location)> {
        Some((self.on.shape, self.at))
    }

    fn is_condition(&self) -> bool {
        true
    }
}

impl DeclaredFunctional for Normal {
    const DECLARATION: Declaration = Declaration {
        name: "normal",
        help: "the surface normal parallel to a direction",
        fields: &[AT_ON_SURFACE, Field::required("to", "[x, y, z]", "the direction"), OBJECT],
    };

    fn from_parameters(parameters: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
        let at = parameters.location("at")?;
        if at.parameters() == 1 {
            return Err(parameters.error(
                "at",
                "a surface's normal is asked at [u, v]; on a curve, ask for the tangent, or that it be orthogonal",
            ));
        }
        Ok(Self { on: On::from_parameters(parameters, names)?, at, to: parameters.vector("to")? })
    }
}
