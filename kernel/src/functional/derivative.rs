//! The derivative vectors of a shape.

use super::at::{AT_OR_NEAR, At, at_a_place};
use super::position::OBJECT;
use super::{
    DeclaredFunctional, Functional, Linearity, On, Rows, ShapeNames, Shapes, equals, magnitude, tangent,
};
use crate::declare::{Declaration, Field, ParameterError, Parameters};
use crate::error::Result;
use crate::shape::{Derivative, Location};
use crate::space::Space;

/// The derivative vector of any order at a location, `Σ S_i^(k) P_i`: three linear equations.
#[derive(Debug, Clone, PartialEq)]
pub struct DerivativeAt {
    on: On,
    at: At,
    order: Derivative,
}

/// The derivative of an order (`k` on a curve, `[i, j]` on a surface) at a location, or [near](super::near()) one, which floats.
pub fn derivative(at: impl Into<At>, order: impl Into<Derivative>) -> DerivativeAt {
    DerivativeAt { on: On::default(), at: at.into(), order: order.into() }
}

impl DerivativeAt {
    /// The same on another shape of the problem.
    #[must_use]
    pub fn on(mut self, shape: impl Into<On>) -> Self {
        self.on = shape.into();
        self
    }
}

impl Functional for DerivativeAt {
    fn equations(&self) -> usize {
        3
    }

    fn linearity(&self) -> Linearity {
        if self.at.floats { Linearity::Nonlinear } else { Linearity::Linear }
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        rows.alike(self.on.shape, &shapes.stencil(self.on.shape, self.at.location, self.order)?);
        Ok(())
    }

    fn value(&self, shapes: &Shapes<'_>, out: &mut [f64]) -> Result<()> {
        let value = shapes.value(self.on.shape, self.at.location, self.order)?;
        out.copy_from_slice(value.as_slice());
        Ok(())
    }

    fn linearize(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>, value: &mut [f64]) -> Result<()> {
        rows.linearize_alike(
            self.on.shape,
            &shapes.stencil(self.on.shape, self.at.location, self.order)?,
            value,
        )
    }

    fn describe(&self) -> String {
        let Self { on, at, order } = self;
        match at.location {
            Location::Curve(_) => match order.u {
                1 => format!("first derivative {at}{on}"),
                2 => format!("second derivative {at}{on}"),
                3 => format!("third derivative {at}{on}"),
                order => format!("derivative of order {order} {at}{on}"),
            },
            _ => format!("derivative [{}, {}] {at}{on}", order.u, order.v),
        }
    }

    fn supersedes(&self, companion: &dyn Functional) -> bool {
        match self.at.location {
            Location::Curve(u) if self.order == 1.into() => {
                let on = || self.on.clone();
                tangent(u).on(on()).same_as(companion) || magnitude(u).on(on()).same_as(companion)
            }
            _ => false,
        }
    }

    fn same_as(&self, other: &dyn Functional) -> bool {
        equals(self, other)
    }

    fn is_vector(&self) -> bool {
        true
    }

    fn powerless(&self, shapes: &Shapes<'_>) -> Option<String> {
        let splines = shapes.get(self.on.shape).ok()?.cells()?.splines()?;
        let (p, q) = (splines.u.degree(), splines.v.map_or(0, Space::degree));
        let Derivative { u, v } = self.order;
        // A quotient has derivatives of all orders.
        if (u <= p && v <= q) || splines.weights.is_some() {
            return None;
        }
        let (order, degree) = match self.at.location {
            Location::Curve(_) => (u.to_string(), p.to_string()),
            _ => (format!("[{u}, {v}]"), format!("{p}×{q}")),
        };
        Some(format!("derivative {order} of degree {degree} is always 0; elevate first"))
    }

    at_a_place!();

    fn along(&self, shapes: &Shapes<'_>, order: Derivative, out: &mut [f64]) -> Result<()> {
        let order = Derivative { u: self.order.u + order.u, v: self.order.v + order.v };
        let value = shapes.value(self.on.shape, self.at.location, order)?;
        out.copy_from_slice(value.as_slice());
        Ok(())
    }

    fn along_rows(&self, shapes: &Shapes<'_>, order: Derivative, rows: &mut Rows<'_>) -> Result<()> {
        let order = Derivative { u: self.order.u + order.u, v: self.order.v + order.v };
        rows.alike(self.on.shape, &shapes.stencil(self.on.shape, self.at.location, order)?);
        Ok(())
    }

    fn takes_derivatives(&self) -> usize {
        self.order.u.max(self.order.v)
    }

    fn notes(&self) -> Vec<String> {
        self.at.note(|| self.describe())
    }
}

impl DeclaredFunctional for DerivativeAt {
    const DECLARATION: Declaration = Declaration {
        name: "derivative",
        help: "the derivative vector there",
        fields: &[
            AT_OR_NEAR[0],
            AT_OR_NEAR[1],
            Field::optional(
                "order",
                "whole number, or [i, j] on a surface",
                "1, needed on a surface",
                "how often by u (and by v)",
            ),
            OBJECT,
        ],
    };

    fn from_parameters(parameters: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
        let at = At::from_parameters(parameters)?;
        let order = match (parameters.value("order"), at.location) {
            (None, Location::Curve(_)) => Derivative { u: 1, v: 0 },
            (Some(value), Location::Curve(_)) if !value.is_array() => parameters.count("order")?.into(),
            (Some(_), Location::Curve(_)) => {
                return Err(parameters.error("order", "on a curve the order is one whole number"));
            }
            (Some(value), _) if value.is_array() => {
                let pair = parameters.integers("order")?;
                match pair[..] {
                    [i, j] if i >= 0 && j >= 0 => Derivative { u: i as usize, v: j as usize },
                    _ => return Err(parameters.error("order", "two counts [i, j] are needed")),
                }
            }
            _ => {
                return Err(
                    parameters.error("order", "on a surface the order is [i, j]: how often by u and by v, as [1, 0] for the derivative by u")
                );
            }
        };
        Ok(Self { on: On::from_parameters(parameters, names)?, at, order })
    }
}
