//! Bicubic pieces with points: as Bézier patches, and how far they are from triangles.

use std::ops::{Add, Div, Mul};

use loftsman_kernel::mesh::distance::from_triangle;
use loftsman_kernel::{Point, Vector};

use super::local::Local;
use super::template::Piece;

/// The 16 vertices of a uniform bicubic B-spline over a square, or of a Bézier patch, `u` after `u`.
pub(crate) type Net = [Vector; 16];

/// The largest of some sizes; infinite where one is no number, as sums of numbers that are too large may be.
pub(crate) fn largest(all: impl Iterator<Item = f64>) -> f64 {
    all.fold(0.0, |most, x| if x.is_nan() { f64::INFINITY } else { most.max(x) })
}

/// The vertices of a piece's net.
pub(super) fn net_of(piece: &Piece, point: impl Fn(usize) -> Vector) -> Net {
    sum(piece, &piece.columns, point)
}

/// The Bézier points of a piece.
pub(super) fn bezier_of(piece: &Piece, point: impl Fn(usize) -> Vector) -> Net {
    sum(piece, &piece.bezier, point)
}

fn sum(piece: &Piece, columns: &[[f64; 16]], point: impl Fn(usize) -> Vector) -> Net {
    // Coordinate by coordinate, so that all sums of one go on side by side.
    let mut sums = [[0.0; 16]; 3];
    for (&place, column) in piece.places.iter().zip(columns) {
        let p = point(place as usize);
        // By numbers: iterators are calls where little is optimised.
        let [xs, ys, zs] = &mut sums;
        let mut k = 0;
        while k < 16 {
            xs[k] += p.x * column[k];
            ys[k] += p.y * column[k];
            zs[k] += p.z * column[k];
            k += 1;
        }
    }
    std::array::from_fn(|k| Vector::new(sums[0][k], sums[1][k], sums[2][k]))
}

/// The vertices round a quadrant: it lies in their convex hull, for what refinement makes are means of them.
pub(super) fn hull_of(local: &Local, point: impl Fn(usize) -> Vector) -> Vec<Vector> {
    let count = local.cage().points().len();
    let at = |v: usize| {
        local
            .row(v)
            .iter()
            .enumerate()
            .fold(Vector::zeros(), |sum, (k, c)| if *c == 0.0 { sum } else { sum + point(k) * *c })
    };
    (0..count).map(at).collect()
}

/// The Bézier points of a uniform B-spline piece, or one coefficient of each.
pub(super) fn bezier<T>(net: &[T; 16]) -> [T; 16]
where
    T: Copy + Add<Output = T> + Mul<f64, Output = T> + Div<f64, Output = T>,
{
    let line = |c: [T; 4]| {
        let [a, b, c, d] = c;
        [(a + b * 4.0 + c) / 6.0, (b * 2.0 + c) / 3.0, (b + c * 2.0) / 3.0, (b + c * 4.0 + d) / 6.0]
    };
    both(net, line, line)
}

/// The Bézier points of the part `[u0, u1] × [v0, v1]` of a Bézier patch.
pub(crate) fn cut(net: &Net, u: [f64; 2], v: [f64; 2]) -> Net {
    both(net, |c| cut_line(c, u), |c| cut_line(c, v))
}

/// By blossoming: `f(a, a, a)`, `f(a, a, b)`, `f(a, b, b)`, `f(b, b, b)`.
fn cut_line(c: [Vector; 4], [a, b]: [f64; 2]) -> [Vector; 4] {
    let blossom = |x: f64, y: f64, z: f64| {
        let mix = |p: Vector, q: Vector, t: f64| p * (1.0 - t) + q * t;
        let [d, e, f] = [0, 1, 2].map(|k| mix(c[k], c[k + 1], x));
        mix(mix(d, e, y), mix(e, f, y), z)
    };
    [blossom(a, a, a), blossom(a, a, b), blossom(a, b, b), blossom(b, b, b)]
}

/// What is done to a line of four in each direction.
pub(crate) fn both<T: Copy>(
    net: &[T; 16],
    along_u: impl Fn([T; 4]) -> [T; 4],
    along_v: impl Fn([T; 4]) -> [T; 4],
) -> [T; 16] {
    let mut all = *net;
    for i in 0..4 {
        let line = along_v([0, 1, 2, 3].map(|j| all[4 * i + j]));
        line.into_iter().enumerate().for_each(|(j, p)| all[4 * i + j] = p);
    }
    for j in 0..4 {
        let line = along_u([0, 1, 2, 3].map(|i| all[4 * i + j]));
        line.into_iter().enumerate().for_each(|(i, p)| all[4 * i + j] = p);
    }
    all
}

/// The net seen from corner `turn`, which becomes `(0, 0)`.
pub(crate) fn turned<T: Copy>(net: &[T; 16], turn: usize) -> [T; 16] {
    std::array::from_fn(|k| net[place(k, 4, turn)])
}

/// Where in a square net, so many vertices a side, that is which seen from corner `turn` is at a place.
pub(super) fn place(k: usize, side: usize, turn: usize) -> usize {
    let (i, j, last) = (k / side, k % side, side - 1);
    let (i, j) = match turn % 4 {
        0 => (i, j),
        1 => (last - j, i),
        2 => (last - i, last - j),
        _ => (j, last - i),
    };
    side * i + j
}

/// Bounds of the lengths of the first derivatives by `u` and `v` over the square: by the differences of the vertices.
pub(super) fn slopes(net: &Net) -> [f64; 2] {
    let longest = |at: fn(usize, usize) -> usize| {
        let pairs = (0..3).flat_map(|i| (0..4).map(move |j| (i, j)));
        largest(pairs.map(|(i, j)| (net[at(i + 1, j)] - net[at(i, j)]).norm()))
    };
    [longest(|i, j| 4 * i + j), longest(|i, j| 4 * j + i)]
}

/// A vector, and how far others are from it at most: a ball.
#[derive(Clone, Copy)]
struct Ball(Vector, f64);

impl Ball {
    /// One around some vectors: about the middle of their box.
    fn of(all: impl Iterator<Item = Vector> + Clone) -> Self {
        let start = (Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY));
        let (low, high) = all.clone().fold(start, |(low, high), x| (low.inf(&x), high.sup(&x)));
        let middle = low * 0.5 + high * 0.5;
        Self(middle, largest(all.map(|x| (x - middle).norm())))
    }
}

/// The second derivatives of a Bézier patch, each in a ball: second differences are their coefficients.
struct Bend {
    uu: Ball,
    uv: Ball,
    vv: Ball,
    corners: [Vector; 4],
    rounding: f64,
}

impl Bend {
    fn new(patch: &Net) -> Self {
        let at = |i: usize, j: usize| patch[4 * i + j];
        let pairs = |m: usize, n: usize| (0..m).flat_map(move |i| (0..n).map(move |j| (i, j)));
        let uu = pairs(2, 4).map(|(i, j)| (at(i, j) - at(i + 1, j) * 2.0 + at(i + 2, j)) * 6.0);
        let vv = pairs(4, 2).map(|(i, j)| (at(i, j) - at(i, j + 1) * 2.0 + at(i, j + 2)) * 6.0);
        let uv = pairs(3, 3).map(|(i, j)| (at(i + 1, j + 1) - at(i + 1, j) - at(i, j + 1) + at(i, j)) * 9.0);
        let size = largest(patch.iter().map(Vector::amax));
        Self {
            uu: Ball::of(uu),
            uv: Ball::of(uv),
            vv: Ball::of(vv),
            corners: [0, 12, 15, 3].map(|k| patch[k]),
            rounding: 64.0 * f64::EPSILON * size,
        }
    }

    /// A bound of the distance from a triangle of all points of the half of the square on one side of the diagonal `u = v` (0 has
    /// `v ≤ u`), and how much of it is due to second derivatives that vary.
    ///
    /// Linear interpolation between the half's corners leaves `L - S = Σ λ_i ∫ (1 - s) H(x + s w_i)[w_i, w_i] ds`, `w_i` from the point to
    /// corner `i` (Taylor's formula at the point, summed). With the second derivatives in balls, `H = H₀ + δ`, the constant part is the
    /// quadratic `½ Σ_{i<j} λ_i λ_j H₀[e_ij, e_ij]`, the rest at most `(δ_uu + 2 δ_uv + δ_vv) / 8`. The quadratic's distance is that
    /// at 15 places, for the distance from a triangle is convex, and what it differs by from chords between these.
    fn beyond(&self, half: usize, target: &[Point; 3]) -> (f64, f64) {
        let [uu, uv, vv] = [self.uu.0, self.uv.0, self.vv.0];
        let across = uu + uv * 2.0 + vv;
        let ([a, b, c], [ab, bc, ac]) = match half {
            0 => ([0, 1, 2], [uu, vv, across]),
            _ => ([0, 2, 3], [across, uu, vv]),
        };
        let mut most: f64 = 0.0;
        for i in 0..=4_u8 {
            for j in 0..=4 - i {
                let (x, y) = (f64::from(i) / 4.0, f64::from(j) / 4.0);
                let z = 1.0 - x - y;
                let chord = self.corners[a] * x + self.corners[b] * y + self.corners[c] * z;
                let at = chord - (ab * (x * y) + bc * (y * z) + ac * (x * z)) * 0.5;
                most = most.max(from_triangle(&Point::from(at), target));
            }
        }
        // Between the places it is a quadratic with a sixteenth of the second derivatives; Σ λ_i λ_j is at most a third.
        let between = ab.norm().max(bc.norm()).max(ac.norm()) / 96.0;
        let rest = between + (self.uu.1 + 2.0 * self.uv.1 + self.vv.1) / 8.0 + self.rounding;
        (most + rest, rest)
    }
}

/// How often a patch is divided to know its distance better, at most.
const DIVIDED: u32 = 5;

/// A bound of the distance that either half of a Bézier patch (below and above the diagonal `u = v`) has from a triangle of its own. Where
/// it is more than `enough`, but not by more than a finer look may take away, it is that of the patch's parts.
pub(super) fn beyond(patch: &Net, targets: [&[Point; 3]; 2], enough: f64) -> f64 {
    looked(patch, targets.map(Some), enough, 0)
}

fn looked(patch: &Net, targets: [Option<&[Point; 3]>; 2], enough: f64, divided: u32) -> f64 {
    let bend = Bend::new(patch);
    let mut most: f64 = 0.0;
    for (half, target) in targets.into_iter().enumerate() {
        let Some(target) = target else { continue };
        let (bound, rest) = bend.beyond(half, target);
        if !bound.is_finite() {
            return f64::INFINITY;
        }
        // What is due to rounding no finer look takes away.
        if bound <= enough || bound - 2.0 * (rest - bend.rounding) > enough || divided == DIVIDED {
            most = most.max(bound);
            continue;
        }
        let mut own = [None; 2];
        own[half] = Some(target);
        let beside = [(0.5, 0.0), (0.0, 0.5)][half];
        for ((u, v), targets) in [((0.0, 0.0), own), ((0.5, 0.5), own), (beside, [Some(target); 2])] {
            let part = cut(patch, [u, u + 0.5], [v, v + 0.5]);
            most = most.max(looked(&part, targets, enough, divided + 1));
        }
    }
    most
}

/// How often a patch is divided to find which of several triangles its parts are near, at most.
const DIVIDED_AMONG: u32 = 5;

/// A bound of the distance that a Bézier patch has from the nearest of several triangles, part by part; infinite where that is more than
/// `enough` or cannot be told. Round an extraordinary vertex sides of quads bend within the surface, so that a part of a quad is beside
/// its own triangles and on those of its neighbours.
pub(super) fn beyond_all(patch: &Net, targets: &[[Point; 3]], enough: f64, divided: u32) -> f64 {
    let corners = [0, 12, 15, 3].map(|k| Point::from(patch[k]));
    let far: Vec<[f64; 4]> = targets.iter().map(|t| corners.map(|p| from_triangle(&p, t))).collect();
    if (0..4).any(|k| !far.iter().any(|d| d[k] <= enough)) {
        return f64::INFINITY;
    }
    let bend = Bend::new(patch);
    // A triangle that a corner is far from is none for its half.
    let half = |half: usize| {
        let own = [[0, 1, 2], [0, 2, 3]][half];
        let some = targets.iter().zip(&far).filter(|(_, d)| own.iter().all(|&k: &usize| d[k] <= enough));
        some.map(|(t, _)| bend.beyond(half, t).0).filter(|b| b.is_finite()).fold(f64::INFINITY, f64::min)
    };
    let bound = half(0).max(half(1));
    if bound <= enough {
        return bound;
    }
    // Nor has a part to do with triangles that are further away than it is large.
    let reach = enough + largest(patch.iter().map(|p| (p - patch[0]).norm()));
    let targets: Vec<[Point; 3]> =
        targets.iter().zip(&far).filter(|(_, d)| d[0] <= reach).map(|(t, _)| *t).collect();
    let targets = &targets[..];
    if divided == DIVIDED_AMONG {
        return f64::INFINITY;
    }
    let mut most: f64 = 0.0;
    for (u, v) in [(0.0, 0.0), (0.5, 0.0), (0.0, 0.5), (0.5, 0.5)] {
        let part = cut(patch, [u, u + 0.5], [v, v + 0.5]);
        most = most.max(beyond_all(&part, targets, enough, divided + 1));
        if most > enough {
            break;
        }
    }
    most
}

#[cfg(test)]
mod tests {
    use super::*;

    fn some() -> Net {
        std::array::from_fn(|k| {
            let (i, j) = ((k / 4) as f64, (k % 4) as f64);
            Vector::new(i + 0.3 * (j * 1.7).sin(), j + 0.2 * (i * 2.3).cos(), (i * 1.3 + j * j).sin())
        })
    }

    fn value(points: &Net, u: f64, v: f64) -> Vector {
        cut(points, [u, u], [v, v])[0]
    }

    #[test]
    fn a_part_is_the_patch_there() {
        let patch = bezier(&some());
        let part = cut(&patch, [0.25, 0.5], [0.0, 0.75]);
        for (u, v) in [(0.0, 0.0), (0.3, 0.8), (1.0, 1.0), (0.5, 0.1)] {
            let off = value(&part, u, v) - value(&patch, 0.25 + 0.25 * u, 0.75 * v);
            assert!(off.norm() < 1e-14, "{off}");
        }
        for turn in 0..4 {
            let other = bezier(&turned(&some(), turn));
            let (u, v) = [(0.3, 0.2), (0.8, 0.3), (0.7, 0.8), (0.2, 0.7)][turn];
            assert!((value(&other, 0.3, 0.2) - value(&patch, u, v)).norm() < 1e-14);
        }
    }

    /// Bounds hold, and are not far from what there is: for a quadratic they are nearly it, and where patches are divided, too.
    #[test]
    fn bounds_of_halves_hold_and_are_tight() {
        let quadratic: Net = std::array::from_fn(|k| {
            let (i, j) = ((k / 4) as f64, (k % 4) as f64);
            Vector::new(i, j, 0.1 * (i * i - i * j + 0.5 * j * j))
        });
        for (net, slack) in [(quadratic, 1.15), (some(), 8.0)] {
            let patch = bezier(&net);
            let corners = [0, 12, 15, 3].map(|k| Point::from(patch[k]));
            let targets = [[0, 1, 2], [0, 2, 3]].map(|half| half.map(|k: usize| corners[k]));
            let mut most: f64 = 0.0;
            for i in 0..=400 {
                for j in 0..=400 {
                    let (u, v) = (f64::from(i) / 400.0, f64::from(j) / 400.0);
                    let own = &targets[usize::from(i < j)];
                    most = most.max(from_triangle(&Point::from(value(&patch, u, v)), own));
                }
            }
            let whole = beyond(&patch, [&targets[0], &targets[1]], f64::INFINITY);
            assert!(most <= whole && whole <= slack * most, "{most} {whole}");
            let finer = beyond(&patch, [&targets[0], &targets[1]], 1.01 * most);
            assert!(most <= finer && finer <= 1.02 * most, "{most} {finer}");
        }
    }

    #[test]
    fn derivatives_are_within_their_bounds() {
        let (patch, [su, sv]) = (bezier(&some()), slopes(&some()));
        for k in 0..100 {
            let (u, v) = (f64::from(k % 10) / 10.0, f64::from(k / 10) / 10.0);
            let rate = |a: Vector, b: Vector| (a - b).norm() / 1e-6;
            assert!(rate(value(&patch, u + 1e-6, v), value(&patch, u, v)) <= su * (1.0 + 1e-5));
            assert!(rate(value(&patch, u, v + 1e-6), value(&patch, u, v)) <= sv * (1.0 + 1e-5));
        }
    }
}
