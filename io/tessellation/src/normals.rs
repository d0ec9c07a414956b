//! Unit normals, also where the two first derivatives do not span a plane.

use loftsman_kernel::spline::Surface;
use loftsman_kernel::{Result, Vector};

use crate::evaluate::Jet;

/// Derivatives smaller than this fraction of the surface's size (over the whole domain), or an angle between
/// them smaller than this, give no normal that rounding would not have made.
const SINGULAR: f64 = 1e-9;

/// `S_u × S_v`, normalised; `None` where the surface is singular.
pub(crate) fn unit_normal(jet: &Jet) -> Option<Vector> {
    let (lu, lv) = (jet.u.norm(), jet.v.norm());
    if !(lu > SINGULAR && lv > SINGULAR) {
        return None;
    }
    let normal = (jet.u / lu).cross(&(jet.v / lv));
    let length = normal.norm();
    (length > SINGULAR).then(|| normal / length)
}

/// The limit of the normal at a singular point of an edge, seen from inside; zero where a second-order limit does
/// not exist either.
///
/// There `S_u × S_v` vanishes and its derivative into the surface takes its place: along `v` it is
/// `S_uv × S_v + S_u × S_vv`, along `u` `S_uu × S_v + S_u × S_uv`. At a pole where all of an edge is one point
/// that is the tangent plane's normal. `across_u` says that the way in is along `u`; `inward` is 1 at the start
/// of the domain and -1 at its end.
pub(crate) fn limit(surface: &Surface, u: f64, v: f64, across_u: bool, inward: f64) -> Result<Vector> {
    let (lu, lv) = (surface.u().length(), surface.v().length());
    let d = |a: usize, b: usize| -> Result<Vector> {
        Ok(surface.derivative(u, v, a, b)? * (lu.powi(a as i32) * lv.powi(b as i32)))
    };
    let (su, sv, suv) = (d(1, 0)?, d(0, 1)?, d(1, 1)?);
    let size = suv.amax().max(su.amax()).max(sv.amax());
    if !(size > 0.0 && size.is_finite()) {
        return Ok(Vector::zeros());
    }
    let normal = if across_u {
        (d(2, 0)? / size).cross(&(sv / size)) + (su / size).cross(&(suv / size))
    } else {
        (suv / size).cross(&(sv / size)) + (su / size).cross(&(d(0, 2)? / size))
    };
    let length = normal.norm();
    Ok(if length > SINGULAR { normal * (inward / length) } else { Vector::zeros() })
}
