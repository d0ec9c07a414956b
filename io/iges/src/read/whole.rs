//! Whole ellipses of solids that a program wrote turned.
//!
//! OpenCASCADE writes a whole ellipse that does not start on its longer axis as a polynomial spline, turned about its centre by the angle that it starts at, and from there on: its knots have that
//! angle, and the vertex of its edge is where it should start. Both are told apart from all that is meant, as the vertex is not on the curve, and is at the right place of it once it is turned back.

use std::f64::consts::TAU;

use loftsman_kernel::brep::{CurveForm, Frame};
use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Point, Result, Vector};

/// Places all around by which the ellipse is found; it is measured at as many between them.
const PLACES: usize = 32;
/// Angles that are nearer than this are one, as knots of ten digits tell them.
const ANGLE: f64 = 1e-7;

/// The ellipse that is meant by one that was turned, from a vertex all around; `None` where a curve is none of these.
///
/// # Errors
/// When an evaluation overflows.
pub(super) fn turned_back(curve: &Curve, vertex: Point, near: f64) -> Result<Option<(Curve, CurveForm)>> {
    let (start, end) = curve.domain();
    let whole = (end - start - TAU).abs() <= ANGLE;
    if !whole || curve.weights().is_some() || nalgebra::distance(&curve.point(start)?, &vertex) <= near {
        return Ok(None);
    }
    let at = |k: f64| curve.point((start + TAU * k / PLACES as f64).min(end));
    let points: Vec<Point> = (0..PLACES).map(|k| at(k as f64)).collect::<Result<_>>()?;
    // What goes around once, of constant and of first order: x where it starts and y a quarter of a turn on.
    let mean = |of: &dyn Fn(f64) -> f64| -> Vector {
        let all = points.iter().enumerate();
        all.map(|(k, p)| p.coords * of(TAU * k as f64 / PLACES as f64)).sum::<Vector>() / PLACES as f64
    };
    let center = Point::from(mean(&|_| 1.0));
    let (x, y) = (mean(&|angle| 2.0 * angle.cos()), mean(&|angle| 2.0 * angle.sin()));
    for k in 0..PLACES {
        let angle = TAU * (k as f64 + 0.5) / PLACES as f64;
        let there = center + x * angle.cos() + y * angle.sin();
        if nalgebra::distance(&there, &at(k as f64 + 0.5)?) > near {
            return Ok(None);
        }
    }
    // It starts on an axis.
    let Some(normal) = x.cross(&y).try_normalize(0.0) else { return Ok(None) };
    if x.dot(&y).abs() > near * x.norm().max(y.norm()) {
        return Ok(None);
    }
    let back = |v: Vector| v * start.cos() - normal.cross(&v) * start.sin();
    let (x, y) = (back(x), back(y));
    let Some(frame) = Frame::new(center, normal, x) else { return Ok(None) };
    let meant = Curve::elliptic_arc(center, x, y, start.rem_euclid(TAU), TAU)?;
    if nalgebra::distance(&meant.point(meant.domain().0)?, &vertex) > near {
        return Ok(None);
    }
    Ok(Some((meant, CurveForm::Ellipse { frame, radii: [x.norm(), y.norm()] })))
}
