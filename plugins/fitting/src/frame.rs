//! The coordinates that fits are computed in: of size one, near the origin.

use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Point, Vector};

use crate::error::{FitError, Result};

/// A change of coordinates, `local = (p · s - origin) · t`.
///
/// Squares of coordinates neither overflow nor underflow in it, whatever the size of the points, and points far
/// from the origin keep their digits. `s` and `t` are powers of two, so that scaling is exact; the origin is
/// moved only where the points are far from it, so that simple coordinates stay simple.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame {
    outer: f64,
    origin: Vector,
    inner: f64,
}

impl Frame {
    /// The frame of these points.
    ///
    /// # Errors
    /// When a coordinate is not finite, there are no points, or they are all the same.
    pub(crate) fn of(points: &[Point]) -> Result<Self> {
        if let Some((index, p)) = points.iter().enumerate().find(|(_, p)| !p.iter().all(|c| c.is_finite())) {
            return Err(FitError::PointNotFinite { index, x: p.x, y: p.y, z: p.z });
        }
        let Some(first) = points.first() else {
            return Err(FitError::TooFewPoints { found: 0, needed: 2, degree: 1, possible: 0 });
        };
        if points.iter().all(|p| p == first) {
            return Err(FitError::AllEqual { count: points.len() });
        }
        let outer = power(points.iter().map(|p| p.coords.amax()).fold(0.0, f64::max));
        let (low, high) = points
            .iter()
            .map(|p| p.coords * outer)
            .fold((first.coords * outer, first.coords * outer), |(low, high), p| (low.inf(&p), high.sup(&p)));
        let (centre, extent) = ((low + high) * 0.5, (high - low).amax());
        let origin = if centre.amax() > 4.0 * extent { centre } else { Vector::zeros() };
        Ok(Self { outer, origin, inner: power(extent) })
    }

    /// Whether it only scales, by a power of two: then what is computed in document coordinates has the very digits of what
    /// is computed in local ones.
    pub(crate) fn only_scales(&self) -> bool {
        self.origin == Vector::zeros()
    }

    /// A point in local coordinates.
    pub(crate) fn enter(&self, p: Point) -> Vector {
        (p.coords * self.outer - self.origin) * self.inner
    }

    /// Back from local coordinates.
    pub(crate) fn leave(&self, local: Vector) -> Point {
        Point::from((local / self.inner + self.origin) / self.outer)
    }

    /// A displacement or derivative in local coordinates.
    pub(crate) fn enter_vector(&self, v: Vector) -> Vector {
        v * self.outer * self.inner
    }

    /// A length in local coordinates.
    pub(crate) fn enter_length(&self, length: f64) -> f64 {
        length * self.outer * self.inner
    }

    /// A local length in document units.
    pub(crate) fn leave_length(&self, length: f64) -> f64 {
        length / self.inner / self.outer
    }

    /// A curve in local coordinates.
    pub(crate) fn lower(&self, curve: &Curve) -> Result<Curve> {
        let vertices = curve.points().iter().map(|&p| Point::from(self.enter(p))).collect();
        Ok(Curve::new(curve.space().clone(), vertices)?)
    }

    /// Back from three local numbers each.
    ///
    /// # Errors
    /// When that overflows.
    pub(crate) fn raise(&self, flat: &[f64]) -> Result<Vec<Point>> {
        let points: Vec<Point> =
            flat.chunks_exact(3).map(|c| self.leave(Vector::new(c[0], c[1], c[2]))).collect();
        if points.iter().all(|p| p.iter().all(|c| c.is_finite())) {
            return Ok(points);
        }
        Err(FitError::Request(
            "the points are so large that control vertices, which go beyond them, overflow: scale the points down"
                .into(),
        ))
    }
}

/// The power of two that brings `size` to between 1/2 and 2 (as far as powers of two reach).
fn power(size: f64) -> f64 {
    2.0_f64.powi(-(size.log2().floor().clamp(-1000.0, 1000.0) as i32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_magnitude_becomes_one_and_comes_back() {
        for exponent in [-300, -9, 0, 9, 300] {
            let size = 10.0_f64.powi(exponent);
            let points = [Point::new(size, 0.0, -size), Point::new(0.3 * size, 2.0 * size, size)];
            let frame = Frame::of(&points).unwrap();
            for p in points {
                assert!(frame.enter(p).amax() <= 2.0);
                assert_eq!(frame.leave(frame.enter(p)), p);
            }
        }
    }
}
