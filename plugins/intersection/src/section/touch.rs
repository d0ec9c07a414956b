//! Where a surface only touches a plane: where its distance from it has an extreme that is 0.
//!
//! Moved by a little, the plane cuts a tiny loop off a peak or a pit. The extreme inside it is found by Newton's method on the distance's
//! derivatives, which is exact to rounding however small the loop and however rough its line are; and it is the place that is told.

use loftsman_kernel::Point;
use loftsman_kernel::spline::{ParameterSide, Surface};

use crate::error::Result;
use crate::intersections::Plane;

/// The most steps to an extreme.
const STEPS: usize = 100;
/// Slopes of the distance that are none: the sine of the angle between the tangent plane and the plane.
const LEVEL: f64 = 1e-6;
/// A direction of which nothing is left but this part of the surface's size stands still.
const STILL: f64 = 1e-9;

/// A surface, and its signed distance from a plane.
pub(super) struct Height<'a> {
    surface: &'a Surface,
    plane: &'a Plane,
    size: f64,
    sides: [ParameterSide; 2],
}

impl<'a> Height<'a> {
    /// For a surface of this size.
    pub(super) fn new(surface: &'a Surface, plane: &'a Plane, size: f64) -> Result<Self> {
        Ok(Self { surface, plane, size, sides: surface.parameter_sides(1e-9 * size)? })
    }

    fn inside(&self, at: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|d: usize| self.sides[d].wrapped(at[d]))
    }

    /// The extreme near to a place, where it is no further from a point than `within` and the distance no larger than `most`.
    pub(super) fn level(
        &self,
        start: [f64; 2],
        from: Point,
        [within, most]: [f64; 2],
    ) -> Result<Option<Point>> {
        for sign in [1.0, -1.0] {
            let Some((point, off)) = self.extreme(start, sign)? else { continue };
            if (point - from).norm() <= within && off.abs() <= most {
                return Ok(Some(point));
            }
        }
        Ok(None)
    }

    /// The extreme of the distance near to a place: where it is, and the distance. The way there leads downwards for `sign` 1 and upwards for
    /// -1. `None` where it ends at an edge of the surface with the distance still changing.
    fn extreme(&self, start: [f64; 2], sign: f64) -> Result<Option<(Point, f64)>> {
        let normal = self.plane.normal() * sign;
        let mut at = self.inside(start);
        let mut height = sign * self.plane.distance(&self.surface.point(at[0], at[1])?);
        let mut damping = 0.0;
        let lengths = [0, 1].map(|d: usize| self.sides[d].length());
        let mut slopes = [f64::INFINITY; 2];
        for _ in 0..STEPS {
            // By parameters that run from 0 to 1.
            let by = |a: usize, b: usize| -> Result<loftsman_kernel::Vector> {
                let scale = lengths[0].powi(a as i32) * lengths[1].powi(b as i32);
                Ok(self.surface.derivative(at[0], at[1], a, b)? * scale)
            };
            let first = [by(1, 0)?, by(0, 1)?];
            let mut gradient = first.map(|d| normal.dot(&d));
            let stands = [0, 1].map(|d: usize| first[d].norm() <= STILL * self.size);
            slopes = [0, 1].map(|d: usize| if stands[d] { 0.0 } else { gradient[d].abs() / first[d].norm() });
            let mut hessian = [normal.dot(&by(2, 0)?), normal.dot(&by(1, 1)?), normal.dot(&by(0, 2)?)];
            // What stands still, as at a pole, or would leave at an end is left alone.
            for d in 0..2 {
                let side = &self.sides[d];
                let leaves = !side.closed
                    && (at[d] <= side.low && gradient[d] > 0.0 || at[d] >= side.high && gradient[d] < 0.0);
                if leaves || stands[d] {
                    (gradient[d], hessian[1], hessian[2 * d]) = (0.0, 0.0, 1.0);
                }
            }
            let scale = hessian[0].abs().max(hessian[2].abs()).max(f64::MIN_POSITIVE);
            // Downhill: a Hessian that is not positive is made so.
            let middle = 0.5 * (hessian[0] + hessian[2]);
            let spread = (0.25 * (hessian[0] - hessian[2]).powi(2) + hessian[1] * hessian[1]).sqrt();
            let least = middle - spread;
            let lift = damping * scale + if least <= 1e-12 * scale { 1e-12 * scale - least } else { 0.0 };
            let (p, q, r) = (hessian[0] + lift, hessian[1], hessian[2] + lift);
            let determinant = p * r - q * q;
            let step = [
                (q * gradient[1] - r * gradient[0]) / determinant,
                (q * gradient[0] - p * gradient[1]) / determinant,
            ];
            if !step.iter().all(|x| x.is_finite()) {
                break;
            }
            let next = self.inside([0, 1].map(|d: usize| at[d] + step[d].clamp(-0.1, 0.1) * lengths[d]));
            let change = (0..2).map(|d| step[d].abs()).fold(0.0, f64::max);
            let lower = sign * self.plane.distance(&self.surface.point(next[0], next[1])?);
            // Where heights are rounding, the step by itself is right.
            let room = 4.0 * f64::EPSILON * (height.abs() + self.surface.point(at[0], at[1])?.coords.norm());
            if lower <= height + room || change <= 1e-7 {
                (at, height) = (next, lower);
                damping *= 0.1;
                if change <= 1e-15 {
                    break;
                }
            } else {
                damping = if damping == 0.0 { 1e-3 } else { damping * 10.0 };
                if damping > 1e12 {
                    break;
                }
            }
        }
        let level = slopes.iter().all(|slope| *slope <= LEVEL);
        Ok(level.then_some((self.surface.point(at[0], at[1])?, sign * height)))
    }
}
