//! Parameter correction: each point's parameter moves towards the foot of its perpendicular on the curve.

use loftsman_kernel::Vector;
use loftsman_kernel::spline::Curve;

use crate::error::Result;

/// Newton steps a point and correction: two bring most points to rounding, and the next correction follows.
const STEPS: usize = 2;

/// Moves `sites` towards the feet of `points` on `curve`, and returns each point's distance from the curve at its
/// new parameter: an upper bound of its true distance.
///
/// Newton's method on `(C - Q)·C' = 0` (Hoschek 1988; Plass and Stone 1983), Gauss–Newton where the second-order
/// term would make it climb. A step that brings the point no nearer is halved, at last given up: no distance grows.
/// Parameters stay between the middles to their old neighbours, so that their order cannot change. The first one,
/// and the last one of an open curve, stay where they are.
///
/// # Errors
/// When a site is outside the domain.
pub(crate) fn correct(curve: &Curve, points: &[Vector], sites: &mut [f64], closed: bool) -> Result<Vec<f64>> {
    let (_, end) = curve.domain();
    let mut distances = Vec::with_capacity(points.len());
    let last = points.len().saturating_sub(1);
    let mut before = f64::NAN;
    for k in 0..points.len() {
        let old = sites[k];
        let mut jet = [Vector::zeros(); 3];
        curve.derivatives_into(old, &mut jet)?;
        let mut best = (old, (jet[0] - points[k]).norm());
        if k > 0 && (closed || k < last) {
            let low = 0.5 * (before + old);
            let high = 0.5 * (old + sites.get(k + 1).copied().unwrap_or(end));
            for _ in 0..STEPS {
                let Some(next) = step(curve, &points[k], best, &jet, (low, high))? else { break };
                best = next;
                curve.derivatives_into(best.0, &mut jet)?;
            }
        }
        before = old;
        sites[k] = best.0;
        distances.push(best.1);
    }
    Ok(distances)
}

/// One guarded step from a parameter with its distance; `None` where no step brings the point nearer.
fn step(
    curve: &Curve,
    point: &Vector,
    (u, distance): (f64, f64),
    jet: &[Vector; 3],
    (low, high): (f64, f64),
) -> Result<Option<(f64, f64)>> {
    let off = jet[0] - point;
    let slope = off.dot(&jet[1]);
    let speed = jet[1].norm_squared();
    let curvature = speed + off.dot(&jet[2]);
    let full = if curvature > 0.25 * speed { slope / curvature } else { slope / speed };
    if !full.is_finite() {
        return Ok(None);
    }
    let mut share = 1.0;
    for _ in 0..4 {
        let next = (u - share * full).clamp(low.min(u), high.max(u));
        if next == u {
            return Ok(None);
        }
        let found = (curve.derivative(next, 0)? - point).norm();
        if found < distance {
            return Ok(Some((next, found)));
        }
        share *= 0.25;
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::*;
    use loftsman_kernel::Point;

    #[test]
    fn feet_on_a_parabola_are_found_and_stay_in_order() {
        let curve = Curve::bezier(vec![
            Point::new(-1.0, 1.0, 0.0),
            Point::new(0.0, -1.0, 0.0),
            Point::new(1.0, 1.0, 0.0),
        ])
        .unwrap();
        // C(u) = (x, x²) with x = 2u - 1; points off it along the normal, parameters disturbed.
        let true_sites: Vec<f64> = (0..=10).map(|i| f64::from(i) / 10.0).collect();
        let points: Vec<Vector> = true_sites
            .iter()
            .map(|u| {
                let x = 2.0 * u - 1.0;
                Vector::new(x, x * x, 0.0) + Vector::new(-2.0 * x, 1.0, 0.0).normalize() * 0.05
            })
            .collect();
        let mut sites: Vec<f64> = true_sites.iter().map(|u| u + 0.03 * (7.0 * u).sin() * (1.0 - u)).collect();
        for _ in 0..6 {
            correct(&curve, &points, &mut sites, false).unwrap();
            assert!(sites.windows(2).all(|w| w[0] < w[1]));
        }
        for (site, expected) in sites.iter().zip(&true_sites) {
            assert!((site - expected).abs() < 1e-9, "{site} {expected}");
        }
    }
}
