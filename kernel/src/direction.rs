//! Directions of vectors of any length.

use crate::Vector;

/// A vector over its length, whatever that is: scaled first, so that no square overflows or vanishes. `None` where it has no direction: zero, NaN, infinite,
/// or so small that it cannot be scaled.
///
/// ```
/// use loftsman_kernel::{Vector, direction};
///
/// assert_eq!(direction(&Vector::new(0.0, -3e-200, 0.0)), Some(-Vector::y()));
/// assert_eq!(direction(&Vector::new(1e300, 0.0, 0.0)), Some(Vector::x()));
/// assert_eq!(direction(&Vector::zeros()), None);
/// ```
pub fn direction(v: &Vector) -> Option<Vector> {
    let largest = v.amax();
    if !(largest > 0.0 && largest.is_finite()) {
        return None;
    }
    let scaled = v / largest;
    // Dividing by a subnormal overflows: no direction can be told there.
    scaled.iter().all(|c| c.is_finite()).then(|| scaled / scaled.norm())
}
