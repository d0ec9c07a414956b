//! Distances from triangles.

use loftsman_kernel::Point;

/// The distance from a triangle: from its plane where the foot is inside, else from its sides.
pub(super) fn from_triangle(p: &Point, [a, b, c]: &[Point; 3]) -> f64 {
    let sides = [(a, b), (b, c), (c, a)];
    if let Some(normal) = (b - a).cross(&(c - a)).try_normalize(0.0)
        && sides.iter().all(|(a, b)| (*b - *a).cross(&(p - *a)).dot(&normal) >= 0.0)
    {
        return (p - a).dot(&normal).abs();
    }
    sides.into_iter().map(|(a, b)| from_segment(p, a, b)).fold(f64::INFINITY, f64::min)
}

pub(super) fn from_segment(p: &Point, a: &Point, b: &Point) -> f64 {
    let along = b - a;
    let size = along.norm_squared();
    let t = if size > 0.0 { ((p - a).dot(&along) / size).clamp(0.0, 1.0) } else { 0.0 };
    (p - (a + along * t)).norm()
}
