//! Branches laid into the plane that was asked for.

use loftsman_kernel::spline::Curve;

use crate::error::Result;
use crate::intersections::Plane;

/// Moves a curve along the plane's normal into the plane, and says how far at most.
///
/// Branches are drawn where the plane was moved to by less than the tolerance, and end on edges that may be known to less than rounding: a
/// curve so far from its plane would be no planar one to whatever asks.
pub(super) fn lay(curve: &mut Curve, plane: &Plane) -> Result<f64> {
    let height = |curve: &Curve| curve.points().iter().map(|p| plane.distance(p).abs()).fold(0.0, f64::max);
    let moved = height(curve);
    if moved == 0.0 {
        return Ok(0.0);
    }
    let (space, mut points, weights) = curve.clone().into_parts();
    for point in &mut points {
        *point -= plane.normal() * plane.distance(point);
    }
    *curve = Curve::build(space, points, weights)?;
    Ok(moved)
}
