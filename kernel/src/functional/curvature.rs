//! The curvature of a curve at a fixed position and first derivative.

use std::sync::Arc;

use super::on::perpendiculars;
use super::position::{AT, OBJECT};
use super::{DeclaredFunctional, Functional, Linearity, On, Rows, ShapeNames, Shapes, derivative, position};
use crate::Vector;
use crate::error::{Error, Result};
use crate::plugin::{Declaration, ParameterError, Parameters};
use crate::shape::Location;

/// The part of `C''` perpendicular to `C'`, which at a fixed first derivative is the curvature vector times `|C'|²`
/// (paper 1, figure 4). Two linear equations, `C''·e₁` and `C''·e₂`, `e₁` along the present perpendicular part;
/// scaling them by `s` scales the curvature by `s`, keeping them keeps it, whatever happens along `C'`.
///
/// Position and first derivative at the location are its [companions](Functional::companions): they stand still
/// unless the edit asks for them itself.
#[derive(Debug, Clone, PartialEq)]
pub struct Curvature {
    on: On,
    at: f64,
    frame: Option<[Vector; 2]>,
}

/// The curvature at `u`, to be kept or scaled.
pub fn curvature(at: f64) -> Curvature {
    Curvature { on: On::default(), at, frame: None }
}

impl Curvature {
    /// The same on another shape of the problem.
    #[must_use]
    pub fn on(mut self, shape: impl Into<On>) -> Self {
        self.on = shape.into();
        self
    }

    fn frame(&self, shapes: &Shapes<'_>) -> Result<[Vector; 2]> {
        if let Some(frame) = self.frame {
            return Ok(frame);
        }
        let shape = shapes.get(self.on.shape)?;
        let first = shape.value(Location::Curve(self.at), 1.into())?;
        let second = shape.value(Location::Curve(self.at), 2.into())?;
        perpendiculars(&first, &second).ok_or_else(|| {
            let what = self.describe();
            Error::Invalid(format!("{what}: C' vanishes there, so there is no curvature; ask elsewhere"))
        })
    }
}

impl Functional for Curvature {
    fn equations(&self) -> usize {
        2
    }

    fn linearity(&self) -> Linearity {
        Linearity::Linear
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        let stencil = shapes.get(self.on.shape)?.stencil(Location::Curve(self.at), 2.into())?;
        for normal in self.frame(shapes)? {
            rows.equation().along(self.on.shape, &stencil, normal);
        }
        Ok(())
    }

    fn describe(&self) -> String {
        format!("curvature at {}{}", self.at, self.on)
    }

    fn companions(&self) -> Vec<Arc<dyn Functional>> {
        let on = || self.on.clone();
        vec![Arc::new(position(self.at).on(on())), Arc::new(derivative(self.at, 1).on(on()))]
    }

    fn bind(&self, shapes: &Shapes<'_>) -> Result<Option<Arc<dyn Functional>>> {
        let frame = Some(self.frame(shapes)?);
        Ok(Some(Arc::new(Self { frame, ..self.clone() })))
    }

    fn location(&self) -> Option<(usize, Location)> {
        Some((self.on.shape, Location::Curve(self.at)))
    }
}

impl DeclaredFunctional for Curvature {
    const DECLARATION: Declaration = Declaration {
        name: "curvature",
        help: "the curvature at fixed position and first derivative; scale or keep",
        fields: &[AT, OBJECT],
    };

    fn from_parameters(parameters: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
        let at = parameters.location("at")?.on_curve().map_err(|e| parameters.error("at", e.to_string()))?;
        Ok(Self { on: On::from_parameters(parameters, names)?, at, frame: None })
    }
}
