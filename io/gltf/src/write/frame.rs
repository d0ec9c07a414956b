//! From points of the scene to numbers of the file.

use loftsman_kernel::placement::Change;
use loftsman_kernel::{Error, Point, Result, Vector};

/// How far from the origin, in multiples of its own size, a shape may be before it is moved there. A coordinate
/// then is rounded by less than 5e-7 of the size.
const FAR: f64 = 8.0;

/// How far the square of a normal's length may be from 1. Within it, it is written as it is: quantised normals are no
/// longer, and the validator allows more.
const UNIT: f64 = 0.01;

/// How long normals of what moves are where the faces round them are flat. Blender takes a face for one that is to look flat, and leaves it so
/// while it bends, where the products of its corners' normals with its own are all above 0.9999999.
const SHORT: f64 = 1.0 - 1.0 / 1_048_576.0;

/// From points of a shape to what is written: the change of unit and axes, and a move towards the origin.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    change: Change,
    pub(super) centre: Vector,
    low: [f32; 3],
    high: [f32; 3],
    rounding: f64,
}

impl Frame {
    /// The frame of a shape's points.
    pub(super) fn of(points: &[Point], change: Change) -> Result<Self> {
        let mut frame =
            Self { change, centre: Vector::zeros(), low: [0.0; 3], high: [0.0; 3], rounding: 0.0 };
        let Some(first) = points.first() else { return Ok(frame) };
        let (mut low, mut high) = (frame.moved(first), frame.moved(first));
        for (index, p) in points.iter().enumerate() {
            let q = frame.moved(p);
            (low, high) = (low.inf(&q), high.sup(&q));
            // Comparisons pass over NaN.
            if !(q.x + q.y + q.z).is_finite() {
                return Err(Error::VertexNotFinite { index, x: p.x, y: p.y, z: p.z });
            }
        }
        let largest = low.amax().max(high.amax());
        let size = (high - low).norm();
        if size > 0.0 && (size as f32) < f32::MIN_POSITIVE {
            return Err(Error::Invalid(format!(
                "a shape of size {size:e} is below single precision, which glTF has: choose another unit"
            )));
        }
        if size > 0.0 && size.is_finite() && largest > FAR * size {
            frame.centre = low + (high - low) * 0.5;
        }
        // Rounding keeps the order: the bounds of the rounded numbers are the rounded bounds.
        (frame.low, frame.high) = (single(low - frame.centre), single(high - frame.centre));
        if !frame.low.iter().chain(&frame.high).all(|x| x.is_finite()) {
            let far = |p: &&Point| !single(frame.moved(p)).iter().all(|x| x.is_finite());
            let index = points.iter().position(|p| far(&p)).unwrap_or(0);
            let p = points[index];
            return Err(Error::Invalid(format!(
                "point {index} is ({}, {}, {}), beyond single precision, which glTF has: choose another unit",
                p.x, p.y, p.z
            )));
        }
        frame.rounding = points.iter().fold(0.0, |most, p| {
            let q = frame.moved(p) - frame.centre;
            let [x, y, z] = single(q).map(f64::from);
            (q - Vector::new(x, y, z)).amax().max(most)
        });
        Ok(frame)
    }

    pub(super) fn moved(&self, p: &Point) -> Vector {
        if self.change.is_none() { p.coords } else { self.change.turn * p.coords * self.change.scale }
    }

    /// A point as it is written.
    pub(super) fn position(&self, p: &Point) -> [f32; 3] {
        single(self.moved(p) - self.centre)
    }

    /// A normal as it is written; one without length (of a point that no face has) is any.
    pub(super) fn normal(&self, n: &Vector) -> [f32; 3] {
        let n = if self.change.is_none() { *n } else { self.change.turn * n };
        let is_unit = (n.norm_squared() - 1.0).abs() <= UNIT;
        single(if is_unit { n } else { direction(&n).unwrap_or_else(Vector::z) })
    }

    /// The same a millionth shorter: see [`SHORT`].
    pub(super) fn short_normal(&self, n: &Vector) -> [f32; 3] {
        let n = if self.change.is_none() { *n } else { self.change.turn * n };
        single(direction(&n).unwrap_or_else(Vector::z) * SHORT)
    }

    /// A tangent as it is written: of length 1, its sign 1 or -1.
    pub(super) fn tangent(&self, t: &[f64; 4]) -> [f32; 4] {
        let along = self.change.turn * Vector::new(t[0], t[1], t[2]);
        let [x, y, z] = single(direction(&along).unwrap_or_else(Vector::x));
        [x, y, z, if t[3] < 0.0 { -1.0 } else { 1.0 }]
    }

    pub(super) fn bounds(&self) -> [Vec<f32>; 2] {
        [self.low.to_vec(), self.high.to_vec()]
    }

    /// By how much coordinates are rounded at most; 0 where single precision holds them all.
    pub(super) fn rounding(&self) -> f64 {
        self.rounding
    }
}

/// A vector of length 1, of any length that is not zero: scaled first, so that no square overflows or vanishes.
fn direction(v: &Vector) -> Option<Vector> {
    let largest = v.amax();
    (largest > 0.0 && largest.is_finite()).then(|| (v / largest).normalize())
}

/// Single precision.
pub(super) fn single(v: Vector) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}
