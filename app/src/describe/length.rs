//! The length of a curve, for people: `∫ ‖C'(u)‖ du` by Gauss–Legendre quadrature, halved until it stands still.

use loftsman_kernel::error::Result;
use loftsman_kernel::spline::Curve;

/// Nodes and weights of the five-point Gauss–Legendre rule on [-1, 1] (exact to degree 9).
const RULE: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_08),
];

/// Halvings of a knot span; beyond them the speed has a cusp, where each halving still halves the error.
const DEPTH: u32 = 16;

/// The length of a curve to about 1e-10 of itself. Linear in the number of knot spans.
pub(super) fn length(curve: &Curve) -> Result<f64> {
    // The control polygon bounds the length from above, and is of its order.
    let polygon: f64 = curve.points().windows(2).map(|p| (p[1] - p[0]).norm()).sum();
    // What rounding of the coordinates alone makes of it; a curve that is one point would halve forever otherwise.
    let largest = curve.points().iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
    let aim = (1e-10 * polygon).max(64.0 * f64::EPSILON * largest);
    let (start, end) = curve.domain();
    let mut total = 0.0;
    for pair in curve.space().breakpoints().windows(2) {
        let tolerance = aim * (pair[1] - pair[0]) / (end - start);
        total += refine(curve, pair[0], pair[1], quadrature(curve, pair[0], pair[1])?, tolerance, DEPTH)?;
    }
    Ok(total)
}

fn quadrature(curve: &Curve, a: f64, b: f64) -> Result<f64> {
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    let mut sum = 0.0;
    for (node, weight) in RULE {
        sum += weight * curve.derivative(middle + half * node, 1)?.norm();
    }
    Ok(sum * half)
}

fn refine(curve: &Curve, a: f64, b: f64, whole: f64, tolerance: f64, depth: u32) -> Result<f64> {
    let middle = 0.5 * (a + b);
    let (left, right) = (quadrature(curve, a, middle)?, quadrature(curve, middle, b)?);
    // The rule's error falls by 2^10 where the speed is smooth, so the difference is the coarser one's.
    if depth == 0 || (left + right - whole).abs() <= 100.0 * tolerance {
        return Ok(left + right);
    }
    Ok(refine(curve, a, middle, left, 0.5 * tolerance, depth - 1)?
        + refine(curve, middle, b, right, 0.5 * tolerance, depth - 1)?)
}

#[cfg(test)]
mod tests {
    use loftsman_kernel::Point;
    use loftsman_kernel::spline::Space;

    use super::*;

    #[test]
    fn a_parabola_has_the_length_of_the_textbook() {
        // y = x² over [0, 1]: √5/2 + asinh(2)/4.
        let points = [[0.0, 0.0], [0.5, 0.0], [1.0, 1.0]].map(|[x, y]| Point::new(x, y, 0.0));
        let exact = 5_f64.sqrt() / 2.0 + 2_f64.asinh() / 4.0;
        for scale in [1e-9, 1.0, 1e9] {
            let curve = Curve::bezier(points.iter().map(|p| p * scale).collect()).unwrap();
            assert!((length(&curve).unwrap() / (exact * scale) - 1.0).abs() < 1e-11);
        }
    }

    #[test]
    fn a_periodic_line_back_and_forth_and_a_single_point() {
        let points = vec![Point::origin(), Point::new(1.0, 0.0, 0.0)];
        let there_and_back = Curve::new(Space::periodic_uniform(1, 2).unwrap(), points).unwrap();
        assert!((length(&there_and_back).unwrap() - 2.0).abs() < 1e-12);
        let point =
            Curve::new(Space::clamped_uniform(3, 6).unwrap(), vec![Point::new(1.0, 2.0, 3.0); 6]).unwrap();
        assert!(length(&point).unwrap() < 1e-14);
    }
}
