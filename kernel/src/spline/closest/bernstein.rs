//! Pieces in Bernstein form around the given point: boxes, squares of the distance, the sign of its slope.

use super::Homogeneous;
use crate::spline::binomial;
use crate::{Point, Vector};

pub(super) fn homogeneous(points: &[Point], weights: Option<&[f64]>, i: usize, from: Point) -> Homogeneous {
    let (d, w) = (points[i] - from, weights.map_or(1.0, |w| w[i]));
    [d.x * w, d.y * w, d.z * w, w]
}

/// Distance from the origin to the box of these vectors, and the largest coordinate among them.
pub(super) fn box_distance(vectors: impl Iterator<Item = Vector>) -> (f64, f64) {
    let (mut low, mut high) = (Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY));
    for v in vectors {
        (low, high) = (low.inf(&v), high.sup(&v));
    }
    let outside = low.sup(&-high).sup(&Vector::zeros());
    (outside.norm(), low.amax().max(high.amax()))
}

pub(super) fn net_bound(net: &[Homogeneous]) -> f64 {
    box_distance(net.iter().map(|h| Vector::new(h[0], h[1], h[2]) / h[3])).0
}

/// How far a net goes: the sum of steps of `stride` between vertices, at most those of a line of `other`.
pub(super) fn extent(net: &[Homogeneous], stride: usize, other: usize) -> f64 {
    let position = |h: &Homogeneous| Vector::new(h[0], h[1], h[2]) / h[3];
    let step = |i: usize| (position(&net[i + stride]) - position(&net[i])).norm();
    // Steps along rows must not go from the end of one to the start of the next.
    (0..net.len() - stride).filter(|i| stride > 1 || (i + 1) % other != 0).map(step).sum::<f64>()
        / (net.len() / other.max(stride)) as f64
}

/// Bernstein coefficients of the product of a net with itself under a bilinear form.
pub(super) fn product(
    net: &[Homogeneous],
    rows: usize,
    columns: usize,
    form: impl Fn(&Homogeneous, &Homogeneous) -> f64,
) -> Vec<f64> {
    let (p, q) = (rows - 1, columns - 1);
    let wide = 2 * q + 1;
    let choose = |n: usize| (0..=n).map(|k| binomial(n, k)).collect::<Vec<_>>();
    let (cp, cq, cp2, cq2) = (choose(p), choose(q), choose(2 * p), choose(2 * q));
    let mut out = vec![0.0; (2 * p + 1) * wide];
    for (a, first) in net.iter().enumerate() {
        let (i, j) = (a / columns, a % columns);
        for (b, second) in net.iter().enumerate() {
            let (k, l) = (b / columns, b % columns);
            out[(i + k) * wide + j + l] += cp[i] * cp[k] * cq[j] * cq[l] * form(first, second);
        }
    }
    for (at, value) in out.iter_mut().enumerate() {
        *value /= cp2[at / wide] * cq2[at % wide];
    }
    out
}

pub(super) fn squared(net: &[Homogeneous]) -> Vec<f64> {
    product(net, net.len(), 1, |a, b| a[0] * b[0] + a[1] * b[1] + a[2] * b[2])
}

pub(super) fn squared_weights(net: &[Homogeneous]) -> Vec<f64> {
    product(net, net.len(), 1, |a, b| a[3] * b[3])
}

pub(super) fn nothing_closer(squares: &[f64], weights: &[f64], distance: f64) -> bool {
    squares.iter().zip(weights).all(|(s, w)| *s >= distance * distance * w)
}

/// Bernstein coefficients of `(D·D)' W - (D·D) 2W'`, which has the sign of the slope of `D·D / W²`.
pub(super) fn slope(squares: &[f64], net: &[Homogeneous]) -> Vec<f64> {
    let (m, p) = (squares.len() - 1, net.len() - 1);
    let mut out = vec![0.0; m + p];
    let mut noise = 0.0_f64;
    // Looked up: taken anew in the loops they cost most of a search at high degrees.
    let choose = |n: usize| (0..=n).map(|k| binomial(n, k)).collect::<Vec<_>>();
    let (of_m, of_p, all) = (choose(m), choose(p), choose((m + p).saturating_sub(1)));
    let (less_m, less_p) = (choose(m.saturating_sub(1)), choose(p.saturating_sub(1)));
    for i in 0..=m {
        for j in 0..=p {
            // f' has coefficients m Δf, W' p ΔW; both products have degree m + p - 1.
            if i < m {
                let term = m as f64 * (squares[i + 1] - squares[i]) * net[j][3];
                out[i + j] += less_m[i] * of_p[j] * term;
            }
            if j < p {
                let term = 2.0 * p as f64 * squares[i] * (net[j + 1][3] - net[j][3]);
                out[i + j] -= of_m[i] * less_p[j] * term;
            }
            noise = noise.max(squares[i].abs() * net[j][3]);
        }
    }
    // What is only rounding has no sign.
    let noise = 8.0 * f64::EPSILON * (m + p) as f64 * noise;
    for (k, value) in out.iter_mut().enumerate() {
        *value /= all[k];
        if value.abs() <= noise {
            *value = 0.0;
        }
    }
    out
}

pub(super) fn sign_changes(coefficients: &[f64]) -> usize {
    let mut last = 0.0;
    let mut changes = 0;
    for &c in coefficients.iter().filter(|c| **c != 0.0) {
        if c * last < 0.0 {
            changes += 1;
        }
        last = c.signum();
    }
    changes
}
