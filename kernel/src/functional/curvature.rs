//! The curvature of a curve: how strongly it turns, and in which plane.

use crate::text::{figure, short};
use std::sync::Arc;

use smallvec::SmallVec;

use super::jet::Jet;
use super::on::{curve_location, perpendiculars};
use super::position::{AT_ON_CURVE, OBJECT};
use super::{
    DeclaredFunctional, Functional, Linearity, On, Rows, ShapeNames, Shapes, derivative, magnitude, position,
    tangent,
};
use crate::Vector;
use crate::declare::{Declaration, ParameterError, Parameters};
use crate::error::{Error, Result};
use crate::shape::{Location, SMOOTH, Side, Stencil};

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
/// *At a knot where the curvature may jump* (repeated as often as the degree less one, or oftener) it is asked of both sides, if
/// the curve runs smoothly there: four equations, the two of the left side behind those of the right, each in its own plane. Where
/// the knot is repeated as often as the degree, so that nothing but what an edit asks lets the first derivative on the left
/// stand still, those of the left are nonlinear. At a corner only the right side is asked, and a note says so.
///
/// Where the curve is straight (`κ = 0` to rounding) there is no plane: `keep` and `scale` keep it straight, other values are
/// refused; [`signed_curvature`](super::signed_curvature()) is told its plane.
#[derive(Debug, Clone, PartialEq)]
pub struct Curvature {
    on: On,
    at: f64,
    /// Whether the first derivative may change.
    alone: bool,
    /// Of the side behind the location, and of the one before it.
    frames: Option<[Frame; 2]>,
    other: Other,
}

/// The side of the location before it, where that has derivatives of its own.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
enum Other {
    /// It has none.
    #[default]
    Same,
    /// It has another second derivative, or another first one as well.
    Second,
    First,
    /// There is a corner.
    Corner,
}

/// How the curve ran when the edit started.
#[derive(Debug, Clone, PartialEq)]
struct Frame {
    tangent: Vector,
    /// In the plane of the curve, and across it.
    normals: [Vector; 2],
    speed: f64,
    /// How large its control polygon was there.
    size: f64,
    /// Where the curve was straight, so that its plane is not known: the curvature up to which that does not matter.
    straight: Option<f64>,
}

/// The plane is known where the curvature is so many times what rounding makes of it.
const PLANAR: f64 = 1e4;

/// Times the size of the control polygon, a curvature beyond this is lost in rounding: with `C'` as it is, the control vertices
/// that it takes are so far away that they leave nothing of `C'`.
const RESOLVABLE: f64 = 1e-3 / f64::EPSILON;

/// A tangent nearly opposite to the old one is the same curve traced backwards.
const TURNED: f64 = -0.9;

/// The curvature at `u`.
pub fn curvature(at: f64) -> Curvature {
    Curvature { on: On::default(), at, alone: false, frames: None, other: Other::Same }
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

    fn jet(&self, shapes: &Shapes<'_>, side: Side) -> Result<Jet> {
        Jet::new(shapes, self.on.shape, (self.at, side), &|| self.describe())
    }

    /// What the other side of the location is like, beside the side behind it.
    fn other(&self, shapes: &Shapes<'_>, jet: &Jet) -> Result<Other> {
        let at = Location::Curve(self.at);
        let stencil = |order: usize| shapes.stencil_on(self.on.shape, at, order.into(), Side::Left.into());
        let [first, second] = [stencil(1)?, stencil(2)?];
        if alike(&first, &jet.stencils[0]) {
            let same = alike(&second, &jet.stencils[1]);
            return Ok(if same { Other::Same } else { Other::Second });
        }
        let before = first.apply(shapes.get(self.on.shape)?.control_vertices());
        let (across, along) = (before.cross(&jet.first).norm(), before.dot(&jet.first));
        // Written so that a derivative that vanishes is a corner.
        Ok(if along > 0.0 && across <= SMOOTH * along { Other::First } else { Other::Corner })
    }

    /// The sides that are asked: each with its derivatives, how it ran, and whether its first derivative may change.
    fn sides(&self, shapes: &Shapes<'_>) -> Result<SmallVec<[(Jet, Frame, bool); 2]>> {
        let mut sides = SmallVec::new();
        for (k, side) in [Side::Right, Side::Left].into_iter().enumerate().take(self.equations() / 2) {
            let jet = self.jet(shapes, side)?;
            let frame = match &self.frames {
                Some(frames) => frames[k].clone(),
                None => self.frame(&jet)?,
            };
            sides.push((jet, frame, self.alone || k == 1 && self.other == Other::First));
        }
        Ok(sides)
    }

    fn frame(&self, jet: &Jet) -> Result<Frame> {
        let tangent = jet.first / jet.speed;
        let normals = perpendiculars(&jet.first, &jet.second).ok_or_else(|| self.vanishes())?;
        let straight = jet.curvature <= PLANAR * jet.noise;
        let straight = straight.then(|| 1e3 * jet.noise.max(jet.curvature));
        Ok(Frame { tangent, normals, speed: jet.speed, size: jet.size, straight })
    }

    fn vanishes(&self) -> Error {
        Error::Invalid(format!(
            "{}: C' vanishes there, so there is no curvature; ask elsewhere",
            self.describe()
        ))
    }

    /// Each number with its derivatives by `C'` and `C''`.
    fn numbers(jet: &Jet, frame: &Frame, alone: bool) -> [(f64, Vector, Vector); 2] {
        let (first, second, s) = (jet.first, jet.second, jet.speed);
        if !alone {
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

/// Whether two stencils are one to rounding, whatever vertices they count that have no part in them.
fn alike(one: &Stencil, other: &Stencil) -> bool {
    let largest = |s: &Stencil| s.coefficients().iter().fold(0.0_f64, |m, c| m.max(c.abs()));
    let size = largest(one).max(largest(other));
    let all: Stencil = one.iter().chain(other.iter().map(|(i, c)| (i, -c))).collect();
    largest(&all) <= 1e-11 * size
}

impl Functional for Curvature {
    fn equations(&self) -> usize {
        match self.other {
            Other::Same | Other::Corner => 2,
            Other::Second | Other::First => 4,
        }
    }

    fn linearity(&self) -> Linearity {
        if self.alone || self.other == Other::First { Linearity::Nonlinear } else { Linearity::Linear }
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        self.linearize(shapes, rows, &mut [])
    }

    fn value(&self, shapes: &Shapes<'_>, out: &mut [f64]) -> Result<()> {
        let sides = self.sides(shapes)?;
        let numbers = sides.iter().flat_map(|(jet, frame, alone)| Self::numbers(jet, frame, *alone));
        out.iter_mut().zip(numbers).for_each(|(out, (value, ..))| *out = value);
        Ok(())
    }

    fn linearize(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>, value: &mut [f64]) -> Result<()> {
        let sides = self.sides(shapes)?;
        let mut value = value.iter_mut();
        for (jet, frame, alone) in &sides {
            for (number, by_first, by_second) in Self::numbers(jet, frame, *alone) {
                rows.equation();
                if *alone {
                    rows.along(self.on.shape, &jet.stencils[0], by_first);
                }
                rows.along(self.on.shape, &jet.stencils[1], by_second);
                if let Some(value) = value.next() {
                    *value = number;
                }
            }
        }
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
        let one = match given {
            [kappa] => [*kappa, 0.0],
            [kappa, across] => [*kappa, *across],
            _ => return None,
        };
        Some(one.repeat(self.equations() / 2))
    }

    fn check_target(&self, _: &[f64], wanted: &[f64]) -> Result<()> {
        let size = self.frames.as_ref().map_or(0.0, |[frame, _]| frame.size);
        if let Some(kappa) = wanted.iter().find(|w| w.abs() * size > RESOLVABLE) {
            return Err(Error::Invalid(format!(
                "{}: a curvature of {kappa} is out of all proportion to the curve there, whose control vertices are {size} \
                 apart (it is that of a circle of radius {}); ask for less",
                self.describe(),
                short(1.0 / kappa.abs()),
                kappa = figure(*kappa),
                size = short(size)
            )));
        }
        let straight =
            |frames: &[Frame; 2]| frames.iter().filter_map(|frame| frame.straight).reduce(f64::min);
        let most = self.frames.as_ref().and_then(straight);
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
        let jet = self.jet(shapes, Side::Right)?;
        let bound = Self { other: self.other(shapes, &jet)?, ..self.clone() };
        let sides = bound.sides(shapes)?;
        let mut frames = [0, sides.len() - 1].map(|k| sides[k].1.clone());
        // A side that is straight has the plane of the other.
        for (k, other) in [(0, 1), (1, 0)] {
            if frames[k].straight.is_some() && frames[other].straight.is_none() {
                (frames[k].normals, frames[k].straight) = (frames[other].normals, None);
            }
        }
        Ok(Some(Arc::new(Self { frames: Some(frames), ..bound })))
    }

    fn notes(&self) -> Vec<String> {
        let corner = self.other == Other::Corner;
        let note = || {
            format!("{}: the curve has a corner there; it is asked of the side behind it", self.describe())
        };
        corner.then(note).into_iter().collect()
    }

    fn location(&self) -> Option<(usize, Location)> {
        Some((self.on.shape, Location::Curve(self.at)))
    }
}

impl DeclaredFunctional for Curvature {
    const DECLARATION: Declaration = Declaration {
        name: "curvature",
        help: "the curvature, in the plane in which the curve turns (below 0 it turns the other way); position and first derivative stand still unless asked",
        fields: &[AT_ON_CURVE, OBJECT],
    };

    fn from_parameters(parameters: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
        let at = curve_location(parameters)?;
        Ok(Self {
            on: On::from_parameters(parameters, names)?,
            at,
            alone: false,
            frames: None,
            other: Other::Same,
        })
    }
}
