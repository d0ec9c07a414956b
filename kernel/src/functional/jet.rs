//! First and second derivative of a curve at a place, and how well its curvature is known there.

use super::Shapes;
use crate::error::{Error, Result};
use crate::shape::{Location, Side, Stencil};
use crate::text::{figure, short};
use crate::{Point, Vector};

/// `C'` and `C''` at a place where the curvature can be told.
pub(super) struct Jet {
    /// Of the first and of the second derivative.
    pub(super) stencils: [Stencil; 2],
    pub(super) first: Vector,
    pub(super) second: Vector,
    /// `|C'|`.
    pub(super) speed: f64,
    /// What rounding of the control vertices' coordinates makes of the curvature: about the error that any value of it has.
    pub(super) noise: f64,
    /// `|C' × C''| / |C'|³`.
    pub(super) curvature: f64,
    /// How large the control polygon is there.
    pub(super) size: f64,
}

/// The curvature is told where rounding leaves it this share of itself, or of that of a circle as large as the control
/// polygon there.
const RESOLVED: f64 = 1e-6;

impl Jet {
    /// Both derivatives at `u`, from a side where that is a knot. With `δ₁ = ε Σ|S'_i||P_i|` and `δ₂` the same of `C''`,
    /// rounding changes the curvature by about `(δ₁|C''|/|C'| + δ₂)/|C'|² + 3κδ₁/|C'|`: beside a cusp that is all there is.
    ///
    /// # Errors
    /// Where `C'` vanishes, or is so small that rounding decides; `name` says what cannot be told there.
    pub(super) fn new(
        shapes: &Shapes<'_>,
        shape: usize,
        (u, side): (f64, Side),
        name: &dyn Fn() -> String,
    ) -> Result<Self> {
        let at = Location::Curve(u);
        let points = shapes.get(shape)?.control_vertices();
        let stencil = |order: usize| shapes.stencil_on(shape, at, order.into(), side.into());
        let stencils = [stencil(1)?, stencil(2)?];
        let [first, second] = [0, 1].map(|k| stencils[k].apply(points));
        let speed = first.norm();
        let curvature = first.cross(&second).norm() / speed / speed / speed;
        if !(speed > 0.0 && curvature.is_finite()) {
            let name = name();
            return Err(Error::Invalid(format!(
                "{name}: C' vanishes there, so there is no curvature; ask elsewhere"
            )));
        }
        let [one, two] = [0, 1].map(|k| f64::EPSILON * magnitude(&stencils[k], points));
        let noise = (one * second.norm() / speed + two) / speed / speed + 3.0 * curvature * one / speed;
        let size = extent(&stencils[0], points);
        let known = noise * size <= RESOLVED * (curvature * size).max(1.0);
        if !known {
            let name = name();
            return Err(Error::Invalid(format!(
                "{name}: it cannot be resolved there: beside the control vertices ({size} apart) C' is so small \
                 ({speed}) that rounding of them decides the curvature ({curvature}, give or take {noise}); ask \
                 farther from where the curve stands still, or (where a curvature out of all proportion was asked) for less",
                size = short(size),
                speed = short(speed),
                curvature = figure(curvature),
                noise = short(noise)
            )));
        }
        Ok(Self { stencils, first, second, speed, noise, curvature, size })
    }
}

/// `Σ |S_i| |P_i|`.
fn magnitude(stencil: &Stencil, points: &[Point]) -> f64 {
    stencil.iter().filter_map(|(i, c)| Some(c.abs() * points.get(i)?.coords.norm())).sum()
}

/// How large the control polygon is there.
fn extent(stencil: &Stencil, points: &[Point]) -> f64 {
    let mut own = stencil.vertices().iter().filter_map(|&i| points.get(i));
    let Some(first) = own.next() else { return 0.0 };
    own.fold(0.0, |size, p| size.max((p - first).amax()))
}
