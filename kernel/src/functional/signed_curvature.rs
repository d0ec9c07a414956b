//! The curvature of a curve with its sign, as a number.

use super::jet::Jet;
use super::on::curve_location;
use super::position::{AT_ON_CURVE, OBJECT};
use super::{DeclaredFunctional, Functional, Linearity, On, Rows, ShapeNames, Shapes};
use crate::Vector;
use crate::declare::{Declaration, Field, ParameterError, Parameters};
use crate::error::{Error, Result};
use crate::shape::{Location, Side};

/// `κ = (C' × C'')·n / |C'|³`, the curvature seen against the unit normal `n`: positive where the curve turns left of its
/// way, for someone towards whom `n` points. One nonlinear equation with gradient
/// `[S'_i (C'' × n) + S''_i (n × C')] / |C'|³ - 3 κ S'_i C' / |C'|²`. Bounded at samples it makes a curve convex. Where the
/// curve (almost) stands still, so that rounding of its control vertices would decide the value, it is refused. At a knot where the
/// curvature may jump it is that of the side behind the knot.
///
/// Nothing else is kept, unlike with [`curvature`](super::curvature()), beside which position and first derivative stand still.
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
    jet: Jet,
    normal: Vector,
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
        let normal = crate::direction(&self.normal).ok_or_else(|| {
            let what = self.describe();
            Error::Invalid(format!("{what}: the normal has no direction; give a finite one that is not zero"))
        })?;
        let jet = Jet::new(shapes, self.on.shape, (self.at, Side::Right), &|| self.describe())?;
        let value = jet.first.cross(&jet.second).dot(&normal) / jet.speed / jet.speed / jet.speed;
        Ok(Local { jet, normal, value })
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
        let Local { jet: Jet { stencils: [one, two], first, second, speed, .. }, normal, value } =
            self.local(shapes)?;
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
            AT_ON_CURVE,
            Field::optional("normal", "[x, y, z]", "[0, 0, 1]", "the normal of the plane it is seen in"),
            OBJECT,
        ],
    };

    fn from_parameters(parameters: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
        let at = curve_location(parameters)?;
        let normal = if parameters.has("normal") { parameters.vector("normal")? } else { Vector::z() };
        Ok(Self { on: On::from_parameters(parameters, names)?, at, normal })
    }
}
