//! What several of the tests start from.

#![allow(clippy::unwrap_used, reason = "what is missing fails the test")]

use loftsman_kernel::Point;
use loftsman_kernel::spline::{Curve, Space};

/// A straight curve between two points, of constant speed, over uniform knots.
pub(crate) fn line(degree: usize, n: usize, from: [f64; 3], to: [f64; 3]) -> Curve {
    let space = Space::clamped_uniform(degree, n).unwrap();
    let (a, b) = (Point::from(from), Point::from(to));
    let end = space.domain().1;
    let points = (0..n).map(|i| a + (b - a) * (space.greville(i) / end)).collect();
    Curve::new(space, points).unwrap()
}
