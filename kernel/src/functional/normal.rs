//! The normal of a surface.

use std::any::Any;
use std::sync::Arc;

use super::at::{At, ON_SURFACE, at_a_place, direction};
use super::position::OBJECT;
use super::{DeclaredFunctional, Functional, Linearity, On, Rows, ShapeNames, Shapes};
use crate::Vector;
use crate::declare::{Declaration, Field, ParameterError, Parameters};
use crate::error::{Error, Result};
use crate::shape::Derivative;

/// `S_u·n = S_v·n = 0`: two linear equations that couple the axes; zero where they hold.
#[derive(Debug, Clone, PartialEq)]
pub struct Normal {
    on: On,
    at: At,
    direction: Option<Vector>,
}

/// The surface normal at `(u, v)`, or at a place of a face, or [near](super::near()) one, which floats, parallel to a direction.
pub fn normal(at: impl Into<At>, direction: impl Into<Vector>) -> Normal {
    Normal { on: On::default(), at: at.into(), direction: Some(direction.into()) }
}

/// The surface normal as it is at `(u, v)`, or at a place of a face, or [near](super::near()) one, which floats: to be kept.
pub fn present_normal(at: impl Into<At>) -> Normal {
    Normal { on: On::default(), at: at.into(), direction: None }
}

impl Normal {
    /// The same on another shape of the problem.
    #[must_use]
    pub fn on(mut self, shape: impl Into<On>) -> Self {
        self.on = shape.into();
        self
    }

    /// The unit vector that it should be parallel to.
    fn unit(&self, shapes: &Shapes<'_>) -> Result<Vector> {
        match self.direction {
            Some(given) => crate::direction(&given).ok_or_else(|| {
                Error::Invalid(format!("{}: the direction is the zero vector; give one", self.describe()))
            }),
            None => {
                let shape = shapes.get(self.on.shape)?;
                let [u, v] = beyond(Derivative::POSITION).map(|order| shape.value(self.at.location, order));
                crate::direction(&u?.cross(&v?)).ok_or_else(|| {
                    Error::Invalid(format!(
                        "{}: the surface has no normal there that could stay; give a direction, or ask elsewhere",
                        self.describe()
                    ))
                })
            }
        }
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

    fn bind(&self, shapes: &Shapes<'_>) -> Result<Option<Arc<dyn Functional>>> {
        if self.direction.is_some() {
            return Ok(None);
        }
        Ok(Some(Arc::new(Self { direction: Some(self.unit(shapes)?), ..self.clone() })))
    }

    /// Whatever direction each of them means.
    fn same_as(&self, other: &dyn Functional) -> bool {
        let any: &dyn Any = other;
        any.downcast_ref::<Self>().is_some_and(|other| (other.at, &other.on) == (self.at, &self.on))
    }

    at_a_place!();

    fn along(&self, shapes: &Shapes<'_>, order: Derivative, out: &mut [f64]) -> Result<()> {
        let direction = self.unit(shapes)?;
        for (out, order) in out.iter_mut().zip(beyond(order)) {
            *out = shapes.value(self.on.shape, self.at.location, order)?.dot(&direction);
        }
        Ok(())
    }

    fn along_rows(&self, shapes: &Shapes<'_>, order: Derivative, rows: &mut Rows<'_>) -> Result<()> {
        let direction = self.unit(shapes)?;
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
        help: "the surface normal parallel to a direction: holds where it is asked (with or without keep = true)",
        fields: &[
            ON_SURFACE[0],
            ON_SURFACE[1],
            Field::optional(
                "direction",
                "[x, y, z]",
                "the present one",
                "the direction; its length does not matter",
            ),
            Field::optional("to", "[x, y, z]", "direction", "the same as direction"),
            OBJECT,
        ],
    };

    fn from_parameters(parameters: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
        let at = At::from_parameters(parameters)?;
        if at.location.parameters() == 1 {
            return Err(parameters.error(
                if at.floats { "near" } else { "at" },
                "a surface's normal is asked at [u, v]; on a curve, ask for the tangent, or that it be orthogonal",
            ));
        }
        let given = parameters.has("direction") || parameters.has("to");
        let direction = if given { Some(direction(parameters)?) } else { None };
        Ok(Self { on: On::from_parameters(parameters, names)?, at, direction })
    }
}
