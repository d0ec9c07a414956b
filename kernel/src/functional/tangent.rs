//! The direction of a curve.

use std::any::Any;
use std::sync::Arc;

use super::at::{ALONG_CURVE, At, at_a_place};
use super::on::{curve_at, of_a_curve, perpendiculars};
use super::position::OBJECT;
use super::{DeclaredFunctional, Functional, Linearity, On, Rows, ShapeNames, Shapes, derivative};
use crate::Vector;
use crate::declare::{Declaration, Field, ParameterError, Parameters};
use crate::error::{Error, Result};
use crate::shape::Derivative;

/// `C'` parallel to a direction, its length (and sense) free: `C'·e₁ = C'·e₂ = 0` for two unit vectors
/// perpendicular to the direction. Two linear equations that couple the axes; zero where it holds, and nothing else can be
/// asked of them: which two vectors they are is nobody's business.
#[derive(Debug, Clone, PartialEq)]
pub struct Tangent {
    on: On,
    at: At,
    direction: Option<Vector>,
}

/// The tangent direction at `u`, or [near](super::near()) one, which floats: the present one, to be kept, unless
/// [`direction`](Tangent::direction) gives another.
pub fn tangent(at: impl Into<At>) -> Tangent {
    Tangent { on: On::default(), at: at.into(), direction: None }
}

impl Tangent {
    /// The direction that the tangent should have. Its length does not matter.
    #[must_use]
    pub fn direction(mut self, direction: impl Into<Vector>) -> Self {
        self.direction = Some(direction.into());
        self
    }

    /// `C'·direction`: negative where the tangent points against the direction it should be parallel to.
    pub(crate) fn sense(&self, shapes: &Shapes<'_>) -> Option<f64> {
        let present = shapes.get(self.on.shape).ok()?.value(self.at.location, 1.into()).ok()?;
        Some(present.dot(&self.direction?))
    }

    /// Two unit vectors across its direction.
    fn across(&self, shapes: &Shapes<'_>) -> Result<[Vector; 2]> {
        let direction = match self.direction {
            Some(direction) => direction,
            None => shapes.get(self.on.shape)?.value(self.at.location, 1.into())?,
        };
        perpendiculars(&direction, &Vector::zeros()).ok_or_else(|| {
            let what = self.describe();
            Error::Invalid(format!("{what}: the direction is the zero vector; give one, or ask elsewhere"))
        })
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
        if self.at.floats { Linearity::Nonlinear } else { Linearity::Linear }
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        self.along_rows(shapes, Derivative::POSITION, rows)
    }

    fn describe(&self) -> String {
        format!("tangent {}{}", self.at, self.on)
    }

    fn bind(&self, shapes: &Shapes<'_>) -> Result<Option<Arc<dyn Functional>>> {
        if self.direction.is_some() {
            return Ok(None);
        }
        let present = shapes.get(self.on.shape)?.value(self.at.location, Derivative { u: 1, v: 0 })?;
        // Unit length, so that values do not depend on how far apart the vertices are.
        let direction = crate::direction(&present).unwrap_or(present);
        Ok(Some(Arc::new(Self { direction: Some(direction), ..self.clone() })))
    }

    /// Whatever direction each of them means.
    fn same_as(&self, other: &dyn Functional) -> bool {
        let any: &dyn Any = other;
        any.downcast_ref::<Self>().is_some_and(|other| (other.at, &other.on) == (self.at, &self.on))
    }

    fn supersedes(&self, companion: &dyn Functional) -> bool {
        // To stay as it is does not turn it.
        self.direction.is_some() && derivative(self.at.location, 1).on(self.on.clone()).same_as(companion)
    }

    at_a_place!();

    fn along(&self, shapes: &Shapes<'_>, order: Derivative, out: &mut [f64]) -> Result<()> {
        let order = Derivative { u: 1 + order.u, v: order.v };
        let value = shapes.value(self.on.shape, self.at.location, order)?;
        for (out, normal) in out.iter_mut().zip(self.across(shapes)?) {
            *out = value.dot(&normal);
        }
        Ok(())
    }

    fn along_rows(&self, shapes: &Shapes<'_>, order: Derivative, rows: &mut Rows<'_>) -> Result<()> {
        of_a_curve(self.at.location, || self.describe())?;
        let order = Derivative { u: 1 + order.u, v: order.v };
        let stencil = shapes.stencil(self.on.shape, self.at.location, order)?;
        for normal in self.across(shapes)? {
            rows.equation().along(self.on.shape, &stencil, normal);
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

    fn only_holds(&self) -> Option<&'static str> {
        Some("to turn the tangent, give the direction that it should have as `direction`")
    }
}

impl DeclaredFunctional for Tangent {
    const DECLARATION: Declaration = Declaration {
        name: "tangent",
        help: "C' parallel to a direction, its length free: holds where it is asked (with or without keep = true)",
        fields: &[
            ALONG_CURVE[0],
            ALONG_CURVE[1],
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
        let at = curve_at(parameters)?;
        let direction =
            if parameters.has("direction") { Some(parameters.vector("direction")?) } else { None };
        Ok(Self { on: On::from_parameters(parameters, names)?, at, direction })
    }
}
