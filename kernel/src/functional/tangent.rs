//! The direction of a curve.

use std::sync::Arc;

use super::on::{perpendiculars, unit};
use super::position::{AT, OBJECT};
use super::{DeclaredFunctional, Functional, Linearity, On, Rows, ShapeNames, Shapes};
use crate::Vector;
use crate::error::{Error, Result};
use crate::plugin::{Declaration, Field, ParameterError, Parameters};
use crate::shape::{Derivative, Location};

/// `C'` parallel to a direction, its length (and sense) free: `C'·e₁ = C'·e₂ = 0` for two unit vectors
/// perpendicular to the direction. Two linear equations that couple the axes; zero where it holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Tangent {
    on: On,
    at: f64,
    direction: Option<Vector>,
}

/// The tangent direction at `u`: the present one, to be kept, unless [`along`](Tangent::along) gives another.
pub fn tangent(at: f64) -> Tangent {
    Tangent { on: On::default(), at, direction: None }
}

impl Tangent {
    /// The direction that the tangent should have. Its length does not matter.
    #[must_use]
    pub fn along(mut self, direction: impl Into<Vector>) -> Self {
        self.direction = Some(direction.into());
        self
    }

    /// `C'·direction`: negative where the tangent points against the direction it should be parallel to.
    pub(crate) fn sense(&self, shapes: &Shapes<'_>) -> Option<f64> {
        let present = shapes.get(self.on.shape).ok()?.value(Location::Curve(self.at), 1.into()).ok()?;
        Some(present.dot(&self.direction?))
    }

    /// The same on another shape of the problem.
    #[must_use]
    pub fn on(mut self, shape: impl Into<On>) -> Self {
        self.on = shape.into();
        self
    }
}

impl Functional for Tangent {
    fn equations(&self) -> usize {
        2
    }

    fn linearity(&self) -> Linearity {
        Linearity::Linear
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        let shape = shapes.get(self.on.shape)?;
        let stencil = shape.stencil(Location::Curve(self.at), 1.into())?;
        let direction = match self.direction {
            Some(direction) => direction,
            None => shape.value(Location::Curve(self.at), 1.into())?,
        };
        let normals = perpendiculars(&direction, &Vector::zeros()).ok_or_else(|| {
            let what = self.describe();
            Error::Invalid(format!("{what}: the direction is the zero vector; give one, or ask elsewhere"))
        })?;
        for normal in normals {
            rows.equation().along(self.on.shape, &stencil, normal);
        }
        Ok(())
    }

    fn describe(&self) -> String {
        format!("tangent at {}{}", self.at, self.on)
    }

    fn bind(&self, shapes: &Shapes<'_>) -> Result<Option<Arc<dyn Functional>>> {
        if self.direction.is_some() {
            return Ok(None);
        }
        let present =
            shapes.get(self.on.shape)?.value(Location::Curve(self.at), Derivative { u: 1, v: 0 })?;
        // Unit length, so that values do not depend on how far apart the vertices are.
        let direction = unit(&present).unwrap_or(present);
        Ok(Some(Arc::new(Self { direction: Some(direction), ..self.clone() })))
    }

    fn location(&self) -> Option<(usize, Location)> {
        Some((self.on.shape, Location::Curve(self.at)))
    }

    fn is_condition(&self) -> bool {
        true
    }
}

impl DeclaredFunctional for Tangent {
    const DECLARATION: Declaration = Declaration {
        name: "tangent",
        help: "C' parallel to a direction, its length free",
        fields: &[
            AT,
            Field::optional(
                "direction",
                "[x, y, z]",
                "the present one",
                "the direction; its length does not matter",
            ),
            OBJECT,
        ],
    };

    fn from_parameters(parameters: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
        let at = parameters.location("at")?;
        let at = at.on_curve().map_err(|e| parameters.error("at", e.to_string()))?;
        let direction =
            if parameters.has("direction") { Some(parameters.vector("direction")?) } else { None };
        Ok(Self { on: On::from_parameters(parameters, names)?, at, direction })
    }
}
