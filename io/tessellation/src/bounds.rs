//! Bounds on second derivatives from Bézier control points, polynomial and rational.
//!
//! All are by local parameters in `[0, 1]` and hold everywhere on the piece. A chord over a step `h` then is
//! within `h²/8 · max|C''|` of its curve, a triangle over a cell `h × k` within
//! `(h² max|S_uu| + 2 h k max|S_uv| + k² max|S_vv|) / 8` of its patch (Filip, Magedson and Markot 1986, theorem 1).

use loftsman_kernel::Vector;
use nalgebra::Vector4;

/// `p (p - 1) max |Δ²b|`: a bound on the second derivative of a polynomial Bézier curve.
pub(crate) fn second(net: &[Vector4<f64>]) -> f64 {
    let p = net.len().saturating_sub(1) as f64;
    let largest = net.windows(3).map(|b| (b[2] - b[1] * 2.0 + b[0]).xyz().norm()).fold(0.0, f64::max);
    p * (p - 1.0) * largest
}

/// A bound on the second derivative of a rational Bézier curve given by homogeneous points `(w x, w)`.
///
/// With the origin moved to the middle of the control points (so that `|C| ≤ r`, their largest distance from
/// it), the quotient rule `C'' = (A'' - 2 W' C' - W'' C) / W`, `C' = (A' - W' C) / W` is bounded term by term.
pub(crate) fn rational_second(net: &[Vector4<f64>]) -> f64 {
    let p = net.len().saturating_sub(1) as f64;
    let (local, radius, least) = about_middle(net);
    let (mut a1, mut w1, mut a2, mut w2) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
    for b in local.windows(2) {
        let d = b[1] - b[0];
        (a1, w1) = (a1.max(p * d.xyz().norm()), w1.max(p * d.w.abs()));
    }
    for b in local.windows(3) {
        let d = (b[2] - b[1] * 2.0 + b[0]) * (p * (p - 1.0));
        (a2, w2) = (a2.max(d.xyz().norm()), w2.max(d.w.abs()));
    }
    let c1 = (a1 + w1 * radius) / least;
    (a2 + 2.0 * w1 * c1 + w2 * radius) / least
}

/// Bounds on `|S_uu|`, `|S_uv|`, `|S_vv|` of a patch.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Bend {
    pub(crate) uu: f64,
    pub(crate) uv: f64,
    pub(crate) vv: f64,
}

/// The bounds of a Bézier patch of `rows × columns` homogeneous control points, row after row along `u`.
pub(crate) fn bend(net: &[Vector4<f64>], rows: usize, columns: usize, rational: bool) -> Bend {
    if !rational {
        let d = differences(net, rows, columns);
        return Bend { uu: d.uu.0, uv: d.uv.0, vv: d.vv.0 };
    }
    let (local, radius, least) = about_middle(net);
    let d = differences(&local, rows, columns);
    // As for curves: every derivative is (A^(ij) - Σ lower W^(..) S^(..)) / W.
    let su = (d.u.0 + d.u.1 * radius) / least;
    let sv = (d.v.0 + d.v.1 * radius) / least;
    Bend {
        uu: (d.uu.0 + 2.0 * d.u.1 * su + d.uu.1 * radius) / least,
        uv: (d.uv.0 + d.u.1 * sv + d.v.1 * su + d.uv.1 * radius) / least,
        vv: (d.vv.0 + 2.0 * d.v.1 * sv + d.vv.1 * radius) / least,
    }
}

/// Bounds `(|A^(ij)|, |W^(ij)|)` on the derivatives of the homogeneous patch.
#[derive(Default)]
struct Differences {
    u: (f64, f64),
    v: (f64, f64),
    uu: (f64, f64),
    uv: (f64, f64),
    vv: (f64, f64),
}

fn differences(net: &[Vector4<f64>], rows: usize, columns: usize) -> Differences {
    let (p, q) = ((rows - 1) as f64, (columns - 1) as f64);
    let at = |i: usize, j: usize| net[i * columns + j];
    let grow = |bound: &mut (f64, f64), d: Vector4<f64>, factor: f64| {
        bound.0 = bound.0.max(factor * d.xyz().norm());
        bound.1 = bound.1.max(factor * d.w.abs());
    };
    let mut out = Differences::default();
    for i in 0..rows {
        for j in 0..columns {
            if i + 1 < rows {
                grow(&mut out.u, at(i + 1, j) - at(i, j), p);
                if j + 1 < columns {
                    grow(&mut out.uv, at(i + 1, j + 1) - at(i + 1, j) - at(i, j + 1) + at(i, j), p * q);
                }
            }
            if j + 1 < columns {
                grow(&mut out.v, at(i, j + 1) - at(i, j), q);
            }
            if i + 2 < rows {
                grow(&mut out.uu, at(i + 2, j) - at(i + 1, j) * 2.0 + at(i, j), p * (p - 1.0));
            }
            if j + 2 < columns {
                grow(&mut out.vv, at(i, j + 2) - at(i, j + 1) * 2.0 + at(i, j), q * (q - 1.0));
            }
        }
    }
    out
}

/// Homogeneous points about the middle of the control points' box, the largest distance from it, and the least
/// weight.
fn about_middle(net: &[Vector4<f64>]) -> (Vec<Vector4<f64>>, f64, f64) {
    let points = net.iter().map(|h| h.xyz() / h.w);
    let (low, high) = points
        .clone()
        .fold((Vector::repeat(f64::MAX), Vector::repeat(f64::MIN)), |(l, h), p| (l.inf(&p), h.sup(&p)));
    let middle = (low + high) * 0.5;
    let radius = points.map(|p| (p - middle).norm()).fold(0.0, f64::max);
    let least = net.iter().map(|h| h.w).fold(f64::MAX, f64::min);
    let local = net.iter().map(|h| (h.xyz() - middle * h.w).push(h.w)).collect();
    (local, radius, least)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_hold_for_a_rational_quarter_circle() {
        // (1 - t², 2t, 1 + t²): C'' at t = 0 is (-4, 0), the largest on [0, 1].
        let net = [
            Vector4::new(1.0, 0.0, 0.0, 1.0),
            Vector4::new(1.0, 1.0, 0.0, 1.0),
            Vector4::new(0.0, 2.0, 0.0, 2.0),
        ];
        let bound = rational_second(&net);
        assert!((4.0..40.0).contains(&bound), "{bound}");
        let flat: Vec<_> = net.iter().map(|h| (h.xyz() / h.w).push(1.0)).collect();
        assert!((rational_second(&flat) - second(&flat)).abs() < 1e-15);
    }

    #[test]
    fn a_bilinear_patch_bends_only_by_its_twist() {
        let net: Vec<_> = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 3.0]]
            .map(|[x, y, z]| Vector4::new(x, y, z, 1.0))
            .to_vec();
        assert_eq!(bend(&net, 2, 2, false), Bend { uu: 0.0, uv: 3.0, vv: 0.0 });
        let bound = bend(&net, 2, 2, true);
        assert!((bound.uv - 3.0).abs() < 1e-15 && bound.uu == 0.0);
    }
}
