//! Which way round a closed curve runs.

use loftsman_kernel::error::Result;
use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Point, Vector};

/// Samples of a span.
const SAMPLES: usize = 32;

/// Twice the area that a closed curve goes round counterclockwise about a normal, by the polygon of many of its points.
pub(crate) fn signed_area(curve: &Curve, middle: &Point, normal: &Vector) -> Result<f64> {
    let mut twice = 0.0;
    for segment in curve.bezier_segments()? {
        let (a, b) = segment.domain();
        let mut before = segment.point(a)? - middle;
        for k in 1..=SAMPLES {
            let u = if k == SAMPLES { b } else { a + (b - a) * k as f64 / SAMPLES as f64 };
            let here = segment.point(u)? - middle;
            twice += before.cross(&here).dot(normal);
            before = here;
        }
    }
    Ok(twice)
}
