//! The normal of a surface.

use super::at::{At, DIRECTION, ON_SURFACE, at_a_place, direction};
use super::position::OBJECT;
use super::{DeclaredFunctional, Functional, Linearity, On, Rows, ShapeNames, Shapes};
use crate::Vector;
use crate::declare::{Declaration, ParameterError, Parameters};
use crate::error::{Error, Result};
use crate::shape::Derivative;

/// `S_u·n = S_v·n = 0`: two linear equations that couple the axes; zero where they hold.
#[derive(Debug, Clone, PartialEq)]
pub struct Normal {
    on: On,
    at: At,
    direction: Vector,
}

/// The surface normal at `(u, v)`, or at a place of a face, or [near](super::near()) one, which floats, parallel to a direction.
pub fn normal(at: impl Into<At>, direction: impl Into<Vector>) -> Normal {
    Normal { on: On::default(), at: at.into(), direction: direction.into() }
}

impl Normal {
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

impl Functional for Normal {
    fn equations(&self) -> usize {
        2
    }

    fn linearity(&self) -> Linearity {
        if self.at.floats { Linearity::Nonlinear } else { Linearity::Linear }
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        self.along_rows(shapes, Derivative::POSITION, rows)
    }

    fn describe(&self) -> String {
        format!("normal {}{}", self.at, self.on)
    }

    at_a_place!();

    fn along(&self, shapes: &Shapes<'_>, order: Derivative, out: &mut [f64]) -> Result<()> {
        let direction = self.unit()?;
        for (out, order) in out.iter_mut().zip(beyond(order)) {
            *out = shapes.value(self.on.shape, self.at.location, order)?.dot(&direction);
        }
        Ok(())
    }

    fn along_rows(&self, shapes: &Shapes<'_>, order: Derivative, rows: &mut Rows<'_>) -> Result<()> {
        let direction = self.unit()?;
        for order in beyond(order) {
            let stencil = shapes.stencil(self.on.shape, self.at.location, order)?;
            rows.equation().along(self.on.shape, &stencil, direction);
        }
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

/// One more by each parameter.
fn beyond(order: Derivative) -> [Derivative; 2] {
    let Derivative { u, v } = order;
    [Derivative { u: u + 1, v }, Derivative { u, v: v + 1 }]
}

impl DeclaredFunctional for Normal {
    const DECLARATION: Declaration = Declaration {
        name: "normal",
        help: "the surface normal parallel to a direction",
        fields: &[ON_SURFACE[0], ON_SURFACE[1], DIRECTION[0], DIRECTION[1], OBJECT],
    };

    fn from_parameters(parameters: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
        let at = At::from_parameters(parameters)?;
        if at.location.parameters() == 1 {
            return Err(parameters.error(
                if at.floats { "near" } else { "at" },
                "a surface's normal is asked at [u, v]; on a curve, ask for the tangent, or that it be orthogonal",
            ));
        }
        Ok(Self { on: On::from_parameters(parameters, names)?, at, direction: direction(parameters)? })
    }
}
