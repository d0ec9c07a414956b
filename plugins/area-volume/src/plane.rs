//! The plane that an area is measured in.

use loftsman_kernel::error::Error;
use loftsman_kernel::{Point, Result, Vector};

/// An origin and three unit vectors, right-handed: two in the plane, and its normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Plane {
    pub(crate) origin: Point,
    pub(crate) x: Vector,
    pub(crate) y: Vector,
    pub(crate) normal: Vector,
}

impl Plane {
    /// The plane through `origin` across `normal`.
    pub(crate) fn across(normal: &Vector, origin: Point, what: &str) -> Result<Self> {
        let largest = normal.amax();
        let scaled = normal / largest;
        if !(largest > 0.0 && scaled.iter().all(|c| c.is_finite())) {
            return Err(Error::Invalid(format!(
                "{what}: the normal has no direction; give one that is not zero"
            )));
        }
        let normal = scaled.normalize();
        // The coordinate axis that lies most nearly in the plane, so that an area across z has the plane's own x and y.
        let least = Vector::ith(normal.iamin(), 1.0);
        let x = (least - normal * normal.dot(&least)).normalize();
        Ok(Self { origin, x, y: normal.cross(&x), normal })
    }
}
