//! Whether weights are alike enough for parameters to tell apart where one control vertex gives way to another.
//!
//! Between the vertices of a rational Bézier piece of degree `p` the largest of the terms `C(p, i) w_i t^i (1 - t)^(p - i)`
//! decides. In the logarithm of `x = t / (1 - t)` they are lines `ln(C(p, i) w_i) + i ln x`, and the largest changes from
//! vertex `i` to `j` where `ln x` is minus the slope of the upper hull of the points `(i, ln(C(p, i) w_i))` between them
//! (Newton's polygon). So the steepest slope says how near to an end of the piece the curve turns from one vertex to the
//! next: vertices below the hull never count, whatever their weights are.

use loftsman_kernel::text::short;
use loftsman_kernel::{Error, Result};

use crate::patch::Homogeneous;

/// The steepest slope at which a parameter can still be told from the end of its piece: `52 ln 2`.
const STEEPEST: f64 = 36.04;

/// That of a patch, whose cells are not cut as far (to a 2⁴⁰th), so that a turn still has some: `38 ln 2`.
const STEEPEST_OF_PATCH: f64 = 26.33;

/// Weights no more unlike than this are as good as alike, whatever their order: no slope is steeper than the logarithm of
/// this and of the largest binomial coefficient of the largest degree.
const ALIKE: f64 = 1e3;

/// Whether a curve's piece turns between parameters that can be told apart.
///
/// # Errors
/// When it does not.
pub(crate) fn resolved(net: &[Homogeneous]) -> Result<()> {
    check(&net.iter().map(|h| h[3]).collect::<Vec<_>>(), STEEPEST)
}

/// As [`resolved`], of a patch in both directions, by the heaviest of each row and of each column.
///
/// # Errors
/// When it does not.
pub(crate) fn resolved_net(net: &[Homogeneous], columns: usize) -> Result<()> {
    if check_range(net.iter().map(|h| h[3]))? <= ALIKE {
        return Ok(());
    }
    let heaviest = |of: &mut dyn Iterator<Item = f64>| of.fold(0.0, f64::max);
    let rows: Vec<f64> = net.chunks(columns).map(|row| heaviest(&mut row.iter().map(|h| h[3]))).collect();
    let across = (0..columns).map(|j| heaviest(&mut net.iter().skip(j).step_by(columns).map(|h| h[3])));
    let across: Vec<f64> = across.collect();
    check(&rows, STEEPEST_OF_PATCH)?;
    check(&across, STEEPEST_OF_PATCH)
}

fn check(weights: &[f64], most: f64) -> Result<()> {
    let range = check_range(weights.iter().copied())?;
    if steepest(weights) <= most { Ok(()) } else { Err(too_unlike(range)) }
}

/// The quotient of the largest and the smallest weight, whose products with coordinates are numbers.
fn check_range(weights: impl Iterator<Item = f64>) -> Result<f64> {
    let (least, most) = weights.fold((f64::INFINITY, 0.0_f64), |(l, h), w| (l.min(w), h.max(w)));
    let range = most / least;
    // Relative to the heaviest the lightest is still a normal number, and so are its products.
    let known = least > 0.0 && most.is_finite() && range < 1e300;
    if known { Ok(range) } else { Err(too_unlike(range)) }
}

fn too_unlike(range: f64) -> Error {
    let by = if range.is_finite() {
        format!("by a factor of {range}", range = short(range))
    } else {
        "by more than 1e308".to_owned()
    };
    Error::Invalid(format!(
        "its weights differ {by} within one piece, so that it turns between parameters that no number tells apart: give it weights that are more alike"
    ))
}

/// The steepest slope of the upper hull of the points `(i, ln(C(p, i) w_i))`.
fn steepest(weights: &[f64]) -> f64 {
    let mut hull: Vec<(f64, f64)> = Vec::with_capacity(weights.len());
    let (p, mut binomial) = (weights.len() as f64 - 1.0, 1.0_f64);
    let slope = |a: (f64, f64), b: (f64, f64)| (b.1 - a.1) / (b.0 - a.0);
    for (i, weight) in weights.iter().enumerate() {
        let at = (i as f64, binomial.ln() + weight.ln());
        while let [.., a, b] = hull[..]
            && slope(a, b) <= slope(b, at)
        {
            hull.pop();
        }
        hull.push(at);
        binomial *= (p - i as f64) / (i as f64 + 1.0);
    }
    hull.windows(2).map(|pair| slope(pair[0], pair[1]).abs()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_vertices_that_count_make_a_slope() {
        let ln = |x: f64| x.ln();
        for (weights, expected) in [
            (vec![1.0, 1.0], 0.0),
            (vec![1.0, 1e9], ln(1e9)),
            (vec![1.0, 1e-200, 1.0], 0.0),
            (vec![1.0, 1e9, 1.0], ln(2e9)),
            (vec![1.0, 1.0, 1e8], ln(1e8) / 2.0),
            (vec![1e10, 1.0, 1.0, 1e-5], ln(3e5)),
        ] {
            let found = steepest(&weights);
            assert!((found - expected).abs() < 1e-9, "{weights:?}: {found} {expected}");
        }
    }

    #[test]
    fn what_turns_at_one_number_is_refused_with_its_weights() {
        let net = |weights: &[f64]| weights.iter().map(|w| [0.0, 0.0, 0.0, *w]).collect::<Vec<_>>();
        assert!(resolved(&net(&[1.0, 1e15, 1.0])).is_ok());
        assert!(resolved(&net(&[1.0, 1e-290, 1.0])).is_ok());
        for weights in [[1.0, 1e16, 1.0], [1e308, 1.0, 1e-308], [1.0, 0.0, 1.0], [1.0, 1e-310, 1.0]] {
            let problem = resolved(&net(&weights)).unwrap_err().to_string();
            assert!(problem.contains("weights differ by"), "{problem}");
        }
        assert!(resolved_net(&net(&[1.0, 1e-200, 1.0, 1.0]), 2).is_ok());
        assert!(resolved_net(&net(&[1.0, 1.0, 1e-12, 1e-12]), 2).is_err());
    }
}
