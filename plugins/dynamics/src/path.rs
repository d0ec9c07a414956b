//! Where a target is at a time.

use loftsman_kernel::{Point, Vector};

use crate::error::{DynamicsError, Result};

/// A place that may move: it rests at its first point until it starts, passes the others at equal times and rests at the last. Between it is
/// the cubic of Catmull and Rom, at rest at both ends, so that nothing is torn along.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    points: Vec<Point>,
    start: f64,
    end: f64,
}

impl From<Point> for Path {
    fn from(point: Point) -> Self {
        Self { points: vec![point], start: 0.0, end: 0.0 }
    }
}

impl From<[f64; 3]> for Path {
    fn from(point: [f64; 3]) -> Self {
        Point::from(point).into()
    }
}

impl Path {
    /// Through these points from one time to another, in seconds.
    ///
    /// # Errors
    /// When there is no point, one is not finite, or the times do not ascend.
    pub fn new(points: Vec<Point>, start: f64, end: f64) -> Result<Self> {
        let wrong = |what, value, needed| Err(DynamicsError::Number { what, value, needed });
        if points.is_empty() {
            return wrong("the number of points of a path", 0.0, "give at least one");
        }
        if let Some(bad) = points.iter().flat_map(|p| p.iter()).find(|v| !v.is_finite()) {
            return wrong("a coordinate of a path", *bad, "give finite numbers");
        }
        if !(start.is_finite() && end.is_finite() && start <= end) {
            return wrong("the end of a path's time", end, "give finite times, the end after the start");
        }
        Ok(Self { points, start, end })
    }

    /// Place, velocity and acceleration at a time. `O(1)`.
    pub fn at(&self, time: f64) -> [Vector; 3] {
        let count = self.points.len();
        let whole = (time - self.start) / (self.end - self.start);
        let rests = |index: usize| [self.points[index].coords, Vector::zeros(), Vector::zeros()];
        // Written so that a path that takes no time is at its end.
        if count == 1 || time <= self.start && self.end > self.start {
            return rests(0);
        }
        if whole.is_nan() || whole >= 1.0 {
            return rests(count - 1);
        }
        let at = whole * (count - 1) as f64;
        let i = (at as usize).min(count - 2);
        let t = at - i as f64;
        let p = |k: usize| self.points[k].coords;
        let slope = |k: usize| {
            if k == 0 || k == count - 1 { Vector::zeros() } else { (p(k + 1) - p(k - 1)) * 0.5 }
        };
        let (a, b, m, n) = (p(i), p(i + 1), slope(i), slope(i + 1));
        // Hermite's cubic: a + m t + (3(b-a) - 2m - n) t² + (2(a-b) + m + n) t³.
        let (c, d) = ((b - a) * 3.0 - m * 2.0 - n, (a - b) * 2.0 + m + n);
        let pace = (count - 1) as f64 / (self.end - self.start);
        [
            a + (m + (c + d * t) * t) * t,
            (m + (c * 2.0 + d * (3.0 * t)) * t) * pace,
            (c * 2.0 + d * (6.0 * t)) * (pace * pace),
        ]
    }

    /// Whether it is somewhere at all times.
    pub(crate) fn is_finite(&self) -> bool {
        self.points.iter().flat_map(|p| p.iter()).all(|v| v.is_finite())
    }

    /// All points that it passes.
    pub fn points(&self) -> &[Point] {
        &self.points
    }
}
