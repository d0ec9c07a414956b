//! The kernel in a browser: numbers in, an edit, a number out. `check.mjs` calls it from Node; README.md says how.

use loftsman_kernel::Point;
use loftsman_kernel::edit::{Ask, Edit, EditError};
use loftsman_kernel::functional::position;
use loftsman_kernel::spline::Curve;

/// How far control vertex `vertex` rises when the point at `at` of a straight cubic Bézier curve is raised by `by`, with the least
/// change of all vertices; NaN where that is refused.
#[unsafe(no_mangle)]
#[allow(unsafe_code, reason = "a module exports functions by their plain names; nobody else has this one")]
pub extern "C" fn rise(vertex: usize, at: f64, by: f64) -> f64 {
    raised(at, by).ok().and_then(|curve| curve.points().get(vertex).map(|p| p.y)).unwrap_or(f64::NAN)
}

fn raised(at: f64, by: f64) -> Result<Curve, EditError> {
    let line = Curve::bezier((0..4).map(|i| Point::new(f64::from(i), 0.0, 0.0)).collect())?;
    let edit = Edit::new(&line).ask(position(at).by([0.0, by, 0.0])).solve()?;
    Ok(edit.shape().clone())
}
