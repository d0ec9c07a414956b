//! Distances from segments and triangles.

use crate::Point;

/// The distance of a point from what lies between `a` and `b`, which may be one point.
///
/// # Examples
///
/// ```
/// use loftsman_kernel::Point;
/// use loftsman_kernel::mesh::distance::from_segment;
///
/// let [a, b] = [Point::origin(), Point::new(2.0, 0.0, 0.0)];
/// assert_eq!(from_segment(&Point::new(1.0, 3.0, 0.0), &a, &b), 3.0);
/// assert_eq!(from_segment(&Point::new(5.0, 4.0, 0.0), &a, &b), 5.0);
/// ```
#[must_use]
pub fn from_segment(p: &Point, a: &Point, b: &Point) -> f64 {
    let (along, to) = (b - a, p - a);
    let length = along.norm_squared();
    let t = if length > 0.0 { (to.dot(&along) / length).clamp(0.0, 1.0) } else { 0.0 };
    (to - along * t).norm()
}

/// The distance of a point from a triangle: from its plane where its foot lies inside, else from its sides. The triangle may be a segment, or a point.
#[must_use]
pub fn from_triangle(p: &Point, [a, b, c]: &[Point; 3]) -> f64 {
    let sides = [(a, b), (b, c), (c, a)];
    if let Some(normal) = (b - a).cross(&(c - a)).try_normalize(0.0)
        && sides.iter().all(|(a, b)| (*b - *a).cross(&(p - *a)).dot(&normal) >= 0.0)
    {
        return (p - a).dot(&normal).abs();
    }
    sides.into_iter().map(|(a, b)| from_segment(p, a, b)).fold(f64::INFINITY, f64::min)
}
