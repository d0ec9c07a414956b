//! The curvature of a curve with its sign, as a number.

use super::on::unit;
use super::position::{AT, OBJECT};
use super::{DeclaredFunctional, Functional, Linearity, On, Rows, ShapeNames, Shapes};
use crate::Vector;
use crate::error::{Error, Result};
use crate::plugin::{Declaration, Field, ParameterError, Parameters};
use crate::shape::{Location, Stencil};

/// `κ = (C' × C'')·n / |C'|³`, the curvature seen against the unit normal `n`: positive where the curve turns left of its
/// way, for someone towards whom `n` points. One nonlinear equation with gradient
/// `[S'_i (C'' × n) + S''_i (n × C')] / |C'|³ - 3 κ S'_i C' / |C'|²`. Bounded at samples it makes a curve convex.
///
/// Nothing else is kept, unlike [`curvature`](super::curvature()), which scales a curvature where the curve stands still.
#[derive(Debug, Clone, PartialEq)]
pub struct SignedCurvature {
    on: On,
    at: f64,
    normal: Vector,
}

/// The signed curvature at `u`, seen against `normal` (of any length).
pub fn signed_curvature(at: f64, normal: impl Into<Vector>) -> SignedCurvature {
    SignedCurvature { on: On::default(), at, normal: normal.into() }
}

/// What the value and the gradient are made of.
struct Local {
    stencils: [Stencil; 2],
    first: Vector,
    second: Vector,
    normal: Vector,
    speed: f64,
    value: f64,
}

impl SignedCurvature {
    /// The same on another shape of the problem.
    #[must_use]
    pub fn on(mut self, shape: impl Into<On>) -> Self {
        self.on = shape.into();
        self
    }

    fn local(&self, shapes: &Shapes<'_>) -> Result<Local> {
        let shape = shapes.get(self.on.shape)?;
        let at = Location::Curve(self.at);
        let stencils = [shape.stencil(at, 1.into())?, shape.stencil(at, 2.into())?];
        let [first, second] = [0, 1].map(|k| stencils[k].apply(shape.control_vertices()));
        let normal = unit(&self.normal).ok_or_else(|| {
            let what = self.describe();
            Error::Invalid(format!("{what}: the normal has no direction; give a finite one that is not zero"))
        })?;
        let speed = first.norm();
        let value = first.cross(&second).dot(&normal) / (speed * speed * speed);
        if !(speed > 0.0 && value.is_finite()) {
            let what = self.describe();
            return Err(Error::Invalid(format!(
                "{what}: C' vanishes there, so there is no curvature; ask elsewhere"
            )));
        }
        Ok(Local { stencils, first, second, normal, speed, value })
    }
}

impl Functional for SignedCurvature {
    fn equations(&self) -> usize {
        1
    }

    fn linearity(&self) -> Linearity {
        Linearity::Nonlinear
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        let Local { stencils: [one, two], first, second, normal, speed, value } = self.local(shapes)?;
        let cube = speed * speed * speed;
        let along = second.cross(&normal) / cube - first * (3.0 * value / (speed * speed));
        let across = normal.cross(&first) / cube;
        rows.equation().along(self.on.shape, &one, along).along(self.on.shape, &two, across);
        Ok(())
    }

    fn value(&self, shapes: &Shapes<'_>, out: &mut [f64]) -> Result<()> {
        let local = self.local(shapes)?;
        if let Some(out) = out.first_mut() {
            *out = local.value;
        }
        Ok(())
    }

    fn describe(&self) -> String {
        format!("signed curvature at {}{}", self.at, self.on)
    }

    fn location(&self) -> Option<(usize, Location)> {
        Some((self.on.shape, Location::Curve(self.at)))
    }
}

impl DeclaredFunctional for SignedCurvature {
    const DECLARATION: Declaration = Declaration {
        name: "signed-curvature",
        help: "the curvature as a number, positive where the curve turns left seen against the normal",
        fields: &[
            AT,
            Field::optional("normal", "[x, y, z]", "[0, 0, 1]", "the normal of the plane it is seen in"),
            OBJECT,
        ],
    };

    fn from_parameters(parameters: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
        let at = parameters.location("at")?.on_curve().map_err(|e| parameters.error("at", e.to_string()))?;
        let normal = if parameters.has("normal") { parameters.vector("normal")? } else { Vector::z() };
        Ok(Self { on: On::from_parameters(parameters, names)?, at, normal })
    }
}
