//! De Boor by the book, in homogeneous coordinates, on a span that the caller chooses: one-sided derivatives at knots.

use loftsman_kernel::Vector;
use loftsman_kernel::spline::{Curve, Space, Surface};

pub(crate) type Four = [f64; 4];

/// De Boor's algorithm on span `s` (of `t`), for the control points `c` of the functions `s - p ..= s`.
fn de_boor(t: &[f64], p: usize, s: usize, u: f64, c: &[Four]) -> Four {
    let mut d = c.to_vec();
    for r in 1..=p {
        for j in (r..=p).rev() {
            let (low, high) = (t[s - p + j], t[s + 1 + j - r]);
            let a = (u - low) / (high - low);
            for k in 0..4 {
                d[j][k] = (1.0 - a) * d[j - 1][k] + a * d[j][k];
            }
        }
    }
    d[p]
}

/// `A`, `A'`, `A''` on a span: each derivative is a spline of one degree less, of differences.
fn homogeneous(t: &[f64], p: usize, s: usize, u: f64, c: &[Four]) -> [Four; 3] {
    let (mut c, mut out) = (c.to_vec(), [[0.0; 4]; 3]);
    for (k, value) in out.iter_mut().enumerate().take(p + 1) {
        let q = p - k;
        *value = de_boor(t, q, s, u, &c);
        if q == 0 {
            break;
        }
        c = (0..q)
            .map(|j| {
                let i = s - q + j;
                let width = t[i + q + 1] - t[i + 1];
                std::array::from_fn(|a| q as f64 * (c[j + 1][a] - c[j][a]) / width)
            })
            .collect();
    }
    out
}

/// `C`, `C'`, `C''` of `A / W`.
fn divide(a: [Four; 3]) -> [Vector; 3] {
    let v = |k: usize| Vector::new(a[k][0], a[k][1], a[k][2]);
    let w = |k: usize| a[k][3];
    let point = v(0) / w(0);
    let first = (v(1) - point * w(1)) / w(0);
    let second = (v(2) - first * (2.0 * w(1)) - point * w(2)) / w(0);
    [point, first, second]
}

fn weighted(p: &loftsman_kernel::Point, w: f64) -> Four {
    [p.x * w, p.y * w, p.z * w, w]
}

/// Which vertex an unrolled function belongs to.
fn vertex(space: &Space, k: usize) -> usize {
    if space.is_periodic() {
        (k + space.len() * (space.degree() + 1) - space.degree()) % space.len()
    } else {
        k
    }
}

/// The spans on both sides of each place where something may be lost: knots inside repeated `least` times or oftener and
/// the seam, if wanted.
pub(crate) fn joints(space: &Space, least: usize, seam: bool) -> Vec<[(usize, f64); 2]> {
    let t = space.flat();
    let p = space.degree();
    let last = t.len() - p - 2;
    let spans: Vec<usize> = (p..=last).filter(|&s| t[s] < t[s + 1]).collect();
    let mut all = Vec::new();
    for pair in spans.windows(2) {
        let repeated = t.iter().filter(|k| **k == t[pair[1]]).count();
        if repeated >= least {
            all.push([(pair[0], t[pair[0] + 1]), (pair[1], t[pair[1]])]);
        }
    }
    if seam {
        let (first, end) = (spans[0], spans[spans.len() - 1]);
        all.push([(end, t[end + 1]), (first, t[first])]);
    }
    all
}

pub(crate) fn on_curve(curve: &Curve, (s, u): (usize, f64)) -> [Vector; 3] {
    let (space, p) = (curve.space(), curve.degree());
    let c: Vec<Four> = (s - p..=s)
        .map(|k| vertex(space, k))
        .map(|i| weighted(&curve.points()[i], curve.weights().map_or(1.0, |w| w[i])))
        .collect();
    divide(homogeneous(space.flat(), p, s, u, &c))
}

/// Position, first and second derivative by `u` on a pair of spans.
pub(crate) fn on_surface(surface: &Surface, (s, u): (usize, f64), (r, v): (usize, f64)) -> [Vector; 3] {
    let (su, sv) = (surface.u(), surface.v());
    let (p, q) = (su.degree(), sv.degree());
    let c: Vec<Four> = (s - p..=s)
        .map(|i| {
            let row: Vec<Four> = (r - q..=r)
                .map(|j| vertex(su, i) * sv.len() + vertex(sv, j))
                .map(|k| weighted(&surface.points()[k], surface.weights().map_or(1.0, |w| w[k])))
                .collect();
            de_boor(sv.flat(), q, r, v, &row)
        })
        .collect();
    divide(homogeneous(su.flat(), p, s, u, &c))
}

/// The surface with its parameters exchanged.
pub(crate) fn turned(surface: &Surface) -> Surface {
    let (u, v, points, weights) = surface.clone().into_parts();
    let order = (0..v.len()).flat_map(|j| (0..u.len()).map(move |i| (i, j)));
    let order: Vec<usize> = order.map(|(i, j)| i * v.len() + j).collect();
    let points = order.iter().map(|&k| points[k]).collect();
    let weights = weights.map(|w| order.iter().map(|&k| w[k]).collect());
    Surface::build(v, u, points, weights).unwrap()
}

pub(crate) fn angle(a: Vector, b: Vector) -> f64 {
    a.cross(&b).norm().atan2(a.dot(&b))
}
