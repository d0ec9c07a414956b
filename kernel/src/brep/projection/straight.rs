//! Edges that are straight in the parameter plane, or that lie on a surface that is a plane there: exactly.

use super::feet::{Feet, Sample};
use super::{Projected, size_of};
use crate::error::Result;
use crate::spline::space::Space;
use crate::spline::trimmed::ParameterCurve;
use crate::spline::{Curve, Surface};
use crate::{Point, Vector};

/// What is this near to the end of a domain, as a share of it, is on it.
const ON: f64 = 1e-9;
/// A net is affine where its vertices are, to this share of its size.
const AFFINE: f64 = 1e-14;

/// Origin and axes of a surface that is `O + u A + v B`.
fn axes(surface: &Surface) -> Option<(Point, [Vector; 2])> {
    let (u, v) = (surface.u(), surface.v());
    if u.is_periodic() || v.is_periodic() {
        return None;
    }
    if let Some(weights) = surface.weights()
        && weights.iter().any(|w| *w != weights[0])
    {
        return None;
    }
    let (rows, columns) = (u.len(), v.len());
    let points = surface.points();
    let (gu, gv) = (|i: usize| u.greville(i), |j: usize| v.greville(j));
    let (du, dv) = (gu(rows - 1) - gu(0), gv(columns - 1) - gv(0));
    let a = (points[(rows - 1) * columns] - points[0]) / du;
    let b = (points[columns - 1] - points[0]) / dv;
    let origin = points[0] - a * gu(0) - b * gv(0);
    let size = size_of(points);
    let on = |i: usize, j: usize| {
        let expected = points[0] + a * (gu(i) - gu(0)) + b * (gv(j) - gv(0));
        (points[i * columns + j] - expected).norm() <= AFFINE * size
    };
    let upright = a.cross(&b).norm() > 1e-9 * a.norm() * b.norm();
    let all = upright && (0..rows).all(|i| (0..columns).all(|j| on(i, j)));
    all.then_some((origin, [a, b]))
}

/// On a plane an edge is an affine image of its curve, vertex by vertex.
pub(super) fn affine(feet: &Feet<'_>, curve: &Curve) -> Result<Option<Projected>> {
    let Some((origin, [a, b])) = axes(feet.surface) else { return Ok(None) };
    // Least squares of two unknowns, scaled to unit axes: what is off the plane has no part in it.
    let (la, lb) = (a.norm(), b.norm());
    let (a, b) = (a / la, b / lb);
    let r = a.dot(&b);
    let det = 1.0 - r * r;
    let mut error = 0.0_f64;
    let points = curve
        .points()
        .iter()
        .map(|p| {
            let d = p - origin;
            let (x, y) = (d.dot(&a), d.dot(&b));
            let (u, v) = ((x - r * y) / det, (y - r * x) / det);
            error = error.max((d - a * u - b * v).norm());
            Point::new(u / la, v / lb, 0.0)
        })
        .collect();
    let plane = Curve::build(curve.space().clone(), points, curve.weights().map(<[f64]>::to_vec))?;
    Ok(Some(Projected { curve: ParameterCurve::whole(plane)?, error }))
}

/// The straight line that an edge is in the parameter plane, where it is one to within a distance beyond what it is off the surface: a line
/// along `u` or `v`, at any speed, or any line, at the edge's.
pub(super) fn line(
    feet: &Feet<'_>,
    curve: &Curve,
    samples: &[Sample],
    bound: f64,
) -> Result<Option<Projected>> {
    let (Some(first), Some(last)) = (samples.first(), samples.last()) else { return Ok(None) };
    let snapped = |d: usize, x: f64| {
        let side = &feet.sides[d];
        let low = side.low
            + if side.closed { side.length() * ((x - side.low) / side.length()).round() } else { 0.0 };
        [low, side.high].into_iter().find(|end| (end - x).abs() <= ON * side.length()).unwrap_or(x)
    };
    for d in 0..2 {
        let fixed = samples.iter().map(|s| s.at[d]);
        let (low, high) = fixed.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        let (from, to) = (snapped(1 - d, first.at[1 - d]), snapped(1 - d, last.at[1 - d]));
        let ascends = to > from;
        let runs = samples.windows(2).all(|pair| {
            let step = pair[1].at[1 - d] - pair[0].at[1 - d];
            (step > 0.0) == ascends && step != 0.0
        });
        // More than a small part of the domain is no line with rounding.
        if !runs || high - low > 1e-3 * feet.sides[d].length() {
            continue;
        }
        let middle = 0.5 * (low + high);
        let knots = [feet.surface.u(), feet.surface.v()][d].breakpoints();
        let near = knots.iter().map(|knot| feet.sides[d].unwrapped(*knot, middle));
        let near = near.filter(|knot| *knot >= low - ON && *knot <= high + ON);
        let near = near.min_by(|a, b| (a - middle).abs().total_cmp(&(b - middle).abs()));
        for at in near.into_iter().chain([snapped(d, middle)]) {
            let place = |x: f64| if d == 0 { [at, x] } else { [x, at] };
            let mut error = 0.0_f64;
            let mut beyond = 0.0_f64;
            for sample in samples {
                let away = (feet.point(place(sample.at[1 - d]))? - curve.point(sample.t)?).norm();
                error = error.max(away);
                beyond = beyond.max(away - sample.off);
            }
            if beyond <= bound {
                return Ok(Some(Projected { curve: segment(curve, place(from), place(to))?, error }));
            }
        }
    }
    // Any other line: in step with the edge.
    let (a, b) = (first.at, last.at);
    let (start, end) = curve.domain();
    let mut error = 0.0_f64;
    for sample in samples {
        let share = (sample.t - start) / (end - start);
        let at = [0, 1].map(|d: usize| a[d] + (b[d] - a[d]) * share);
        let away = (feet.point(at)? - curve.point(sample.t)?).norm();
        if away - sample.off > bound {
            return Ok(None);
        }
        error = error.max(away);
    }
    Ok(Some(Projected { curve: segment(curve, a, b)?, error }))
}

/// The segment between two places, over the domain of an edge.
pub(super) fn segment(curve: &Curve, a: [f64; 2], b: [f64; 2]) -> Result<ParameterCurve> {
    let (start, end) = curve.domain();
    let points = [a, b].map(|p| Point::new(p[0], p[1], 0.0));
    ParameterCurve::whole(Curve::new(Space::clamped(1, &[start, end])?, points.to_vec())?)
}
