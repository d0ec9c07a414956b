//! The curvature of a curve: how strongly it turns, and in which plane.

use std::sync::Arc;

use super::jet::Jet;
use super::on::{curve_location, perpendiculars};
use super::position::{AT, OBJECT};
use super::{
    DeclaredFunctional, Functional, Linearity, On, Rows, ShapeNames, Shapes, derivative, magnitude, position,
    tangent,
};
use crate::Vector;
use crate::error::{Error, Result};
use crate::plugin::{Declaration, ParameterError, Parameters};
use crate::shape::Location;

/// The curvature vector `k = κN = (C'' - T (T·C'')) / |C'|²` at `u`, as two numbers: its component in the plane in which the
/// curve turns when the edit starts (there that is `κ` itself), and the one across that plane (there 0). One number is
/// enough to ask for: `to(κ)` and `by(δ)` speak of the first and leave the plane as it is; `scale` and `keep` too. Negative
/// values turn the curve to the other side. In units of `1/length`, whatever the parametrisation.
///
/// *What stands still*: position and first derivative at the location are its [companions](Functional::companions), unless
/// the edit asks for them itself. While the first derivative stands still, these are two **linear** equations in `C''`
/// (paper 1, figure 4).
///
/// *Where the first derivative changes as well* (the edit asks for it, for the tangent's direction or magnitude), they are
/// two **nonlinear** equations for the same two numbers, so that curvature means `κ` whatever else is asked. Of direction and
/// magnitude of the first derivative, what is not asked for stands still, so that the curve is as determined there as it is
/// with the linear equations. Where the tangent turns within the plane, the
/// plane stays. Where it leaves the plane, the plane turns with it, by the least rotation that takes the old tangent `T₀` to
/// the new one; `N₀` and `B₀` turn along. A tangent turned right round (by more than 154°) is a curve that is traced
/// backwards: the rotation is that to `-T`, so that the curvature vector of a curve that only changes its sense stays as it is.
/// With `m = R N₀`, `α = (T·N₀)/(1 + T·T₀)`, `f = k·m` and `s = |C'|`:
///
/// `∂f/∂C'' = m/s²`, `∂f/∂C' = -2f T/s - (T·C'') m/s³ - α k/s - (k·T₀) m/((1 + T·T₀) s)`, and the same for `R B₀`.
///
/// Where the curve is straight (`κ = 0` to rounding) there is no plane: `keep` and `scale` keep it straight, other values are
/// refused; [`signed_curvature`](super::signed_curvature()) is told its plane.
#[derive(Debug, Clone, PartialEq)]
pub struct Curvature {
    on: On,
    at: f64,
    /// Whether the first derivative may change.
    alone: bool,
    frame: Option<Frame>,
}

/// How the curve ran when the edit started.
#[derive(Debug, Clone, PartialEq)]
struct Frame {
    tangent: Vector,
    /// In the plane of the curve, and across it.
    normals: [Vector; 2],
    speed: f64,
    /// Where the curve was straight, so that its plane is not known: the curvature up to which that does not matter.
    straight: Option<f64>,
}

/// The plane is known where the curvature is so many times what rounding makes of it.
const PLANAR: f64 = 1e4;

/// A tangent nearly opposite to the old one is the same curve traced backwards.
const TURNED: f64 = -0.9;

/// The curvature at `u`.
pub fn curvature(at: f64) -> Curvature {
    Curvature { on: On::default(), at, alone: false, frame: None }
}

impl Curvature {
    /// The same on another shape of the problem.
    #[must_use]
    pub fn on(mut self, shape: impl Into<On>) -> Self {
        self.on = shape.into();
        self
    }

    /// The same where the first derivative may change: nonlinear, with position and the tangent's direction and magnitude for
    /// companions.
    /// An edit does this by itself where it asks for a first derivative.
    #[must_use]
    pub fn alone(mut self) -> Self {
        self.alone = true;
        self
    }

    fn jet(&self, shapes: &Shapes<'_>) -> Result<Jet> {
        Jet::new(shapes, self.on.shape, self.at, &|| self.describe())
    }

    fn frame(&self, jet: &Jet) -> Result<Frame> {
        if let Some(frame) = &self.frame {
            return Ok(frame.clone());
        }
        let tangent = jet.first / jet.speed;
        let normals = perpendiculars(&jet.first, &jet.second).ok_or_else(|| self.vanishes())?;
        let straight = jet.curvature <= PLANAR * jet.noise;
        let straight = straight.then(|| 1e3 * jet.noise.max(jet.curvature));
        Ok(Frame { tangent, normals, speed: jet.speed, straight })
    }

    fn vanishes(&self) -> Error {
        Error::Invalid(format!(
            "{}: C' vanishes there, so there is no curvature; ask elsewhere",
            self.describe()
        ))
    }

    /// Each number with its derivatives by `C'` and `C''`.
    fn numbers(&self, jet: &Jet, frame: &Frame) -> [(f64, Vector, Vector); 2] {
        let (first, second, s) = (jet.first, jet.second, jet.speed);
        if !self.alone {
            let size = frame.speed * frame.speed;
            return frame.normals.map(|n| (n.dot(&second) / size, Vector::zeros(), n / size));
        }
        let t = first / s;
        let along = t.dot(&second);
        let k = (second - t * along) / s / s;
        let old = if t.dot(&frame.tangent) < TURNED { -frame.tangent } else { frame.tangent };
        let ahead = 1.0 + t.dot(&old);
        // Traced backwards, the rotation takes -T₀ to T: the same one that takes T₀ to -T.
        frame.normals.map(|n| {
            let alpha = t.dot(&n) / ahead;
            let turned = n - (old + t) * alpha;
            let value = k.dot(&turned);
            let by_first = t * (-2.0 * value / s)
                - turned * (along / s / s / s)
                - k * (alpha / s)
                - turned * (k.dot(&old) / (ahead * s));
            (value, by_first, turned / s / s)
        })
    }
}

impl Functional for Curvature {
    fn equations(&self) -> usize {
        2
    }

    fn linearity(&self) -> Linearity {
        if self.alone { Linearity::Nonlinear } else { Linearity::Linear }
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        self.linearize(shapes, rows, &mut [])
    }

    fn value(&self, shapes: &Shapes<'_>, out: &mut [f64]) -> Result<()> {
        let jet = self.jet(shapes)?;
        let frame = self.frame(&jet)?;
        out.iter_mut().zip(self.numbers(&jet, &frame)).for_each(|(out, (value, ..))| *out = value);
        Ok(())
    }

    fn linearize(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>, value: &mut [f64]) -> Result<()> {
        let jet = self.jet(shapes)?;
        let frame = self.frame(&jet)?;
        let numbers = self.numbers(&jet, &frame);
        for (_, by_first, by_second) in numbers {
            rows.equation();
            if self.alone {
                rows.along(self.on.shape, &jet.stencils[0], by_first);
            }
            rows.along(self.on.shape, &jet.stencils[1], by_second);
        }
        value.iter_mut().zip(numbers).for_each(|(out, (value, ..))| *out = value);
        Ok(())
    }

    fn describe(&self) -> String {
        format!("curvature at {}{}", self.at, self.on)
    }

    fn companions(&self) -> Vec<Arc<dyn Functional>> {
        let on = || self.on.clone();
        let position = Arc::new(position(self.at).on(on()));
        if self.alone {
            vec![position, Arc::new(tangent(self.at).on(on())), Arc::new(magnitude(self.at).on(on()))]
        } else {
            vec![position, Arc::new(derivative(self.at, 1).on(on()))]
        }
    }

    fn beside(&self, stands_still: &dyn Fn(&dyn Functional) -> bool) -> Option<Arc<dyn Functional>> {
        let moves = !self.alone && !stands_still(&derivative(self.at, 1).on(self.on.clone()));
        moves.then(|| -> Arc<dyn Functional> { Arc::new(self.clone().alone()) })
    }

    fn complete(&self, given: &[f64]) -> Option<Vec<f64>> {
        match given {
            [kappa] => Some(vec![*kappa, 0.0]),
            _ => None,
        }
    }

    fn check_target(&self, _: &[f64], wanted: &[f64]) -> Result<()> {
        let most = self.frame.as_ref().and_then(|frame| frame.straight);
        if most.is_none_or(|most| wanted.iter().all(|w| w.abs() <= most)) {
            return Ok(());
        }
        Err(Error::Invalid(format!(
            "{}: the curve is straight there, so there is no plane to bend it in; ask for a signed-curvature with the normal \
             of the plane, or for the second derivative",
            self.describe()
        )))
    }

    fn bind(&self, shapes: &Shapes<'_>) -> Result<Option<Arc<dyn Functional>>> {
        let frame = Some(self.frame(&self.jet(shapes)?)?);
        Ok(Some(Arc::new(Self { frame, ..self.clone() })))
    }

    fn location(&self) -> Option<(usize, Location)> {
        Some((self.on.shape, Location::Curve(self.at)))
    }
}

impl DeclaredFunctional for Curvature {
    const DECLARATION: Declaration = Declaration {
        name: "curvature",
        help: "the curvature, in the plane in which the curve turns; position and first derivative stand still unless asked",
        fields: &[AT, OBJECT],
    };

    fn from_parameters(parameters: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
        let at = curve_location(parameters)?;
        Ok(Self { on: On::from_parameters(parameters, names)?, at, alone: false, frame: None })
    }
}
