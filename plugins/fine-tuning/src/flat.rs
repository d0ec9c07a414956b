//! Curves in a plane or on a line, but for the rounding of their vertices, which is no direction that they turn to.

use std::borrow::Cow;

use loftsman_kernel::spline::Curve;
use loftsman_kernel::spline::algebra::Function;
use loftsman_kernel::{Point, Vector};

use crate::error::Result;

/// The part of the largest coordinate up to which vertices are off a plane by rounding: that of some knots inserted.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// How far the vertices of a curve may be off for rounding.
fn rounding(curve: &Curve) -> f64 {
    ROUNDING * curve.points().iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()))
}

/// The distance of the vertex that is farthest from the first.
pub(crate) fn extent(curve: &Curve) -> f64 {
    curve.points().iter().map(|p| (p - curve.points()[0]).norm()).fold(0.0, f64::max)
}

/// Which coordinates of a curve are the same everywhere, but for rounding.
fn constant(curve: &Curve) -> [bool; 3] {
    let least = rounding(curve);
    let range = |axis: usize| {
        let each = curve.points().iter().map(|p| p[axis]);
        let (low, high) = each.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        high - low
    };
    [0, 1, 2].map(|axis| range(axis) <= least)
}

/// The curve with those coordinates the same to the last bit.
pub(crate) fn level(curve: Cow<'_, Curve>) -> Result<Cow<'_, Curve>> {
    let constant = constant(&curve);
    let first = curve.points()[0];
    let differs = |p: &Point| (0..3).any(|axis| constant[axis] && p[axis] != first[axis]);
    if !curve.points().iter().any(differs) {
        return Ok(curve);
    }
    let mut points = curve.points().to_vec();
    for point in &mut points {
        (0..3).filter(|axis| constant[*axis]).for_each(|axis| point[axis] = first[axis]);
    }
    Ok(Cow::Owned(Curve::new(curve.space().clone(), points)?))
}

/// The derivative of a curve that is plane or straight but for rounding, within its plane or along its line.
pub(crate) fn within(derivative: Function<Vector>, curve: &Curve) -> Result<Function<Vector>> {
    let mut axes = axes(curve, rounding(curve));
    if axes.is_empty() || axes.len() == 3 {
        return Ok(derivative);
    }
    let constant = constant(curve);
    let varying = constant.map(|is_constant| if is_constant { 0.0 } else { 1.0 });
    if varying.iter().sum::<f64>() as usize == axes.len() {
        return Ok(derivative.mapped(|d| d.component_mul(&Vector::from(varying)))?);
    }
    for axis in &mut axes {
        axis.component_mul_assign(&Vector::from(varying));
    }
    Ok(derivative.mapped(|d| axes.iter().fold(Vector::zeros(), |sum, axis| sum + axis * axis.dot(&d)))?)
}

/// Perpendicular directions that a curve's control vertices lie along, from the first of them, farther than `least`: each that of the vertex
/// farthest from those before.
pub(crate) fn axes(curve: &Curve, least: f64) -> Vec<Vector> {
    let first = curve.points().first().copied().unwrap_or_default();
    let mut ways: Vec<Vector> = curve.points().iter().map(|p| p - first).collect();
    let farthest = |ways: &[Vector]| {
        ways.iter().fold(Vector::zeros(), |m: Vector, w| if w.norm() > m.norm() { *w } else { m })
    };
    let mut axes = Vec::new();
    while axes.len() < 3 {
        let far = farthest(&ways);
        if far.norm() <= least {
            break;
        }
        let axis = far / far.norm();
        ways.iter_mut().for_each(|way| *way -= axis * axis.dot(way));
        axes.push(axis);
    }
    axes
}
