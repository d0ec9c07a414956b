//! One Bézier patch: its points, its derivatives, and its second derivatives as nets of their own.

use loftsman_kernel::Vector;
use loftsman_kernel::spline::Surface;
use loftsman_kernel::spline::space::MAX_ORDER;
use smallvec::{SmallVec, smallvec};

use crate::bezier::{extraction, less, more};
use crate::fineness::Frame;

/// A homogeneous control point `(w x, w y, w z, w)`.
pub(crate) type Homogeneous = [f64; 4];

/// A point with its first derivatives by the patch's own parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Jet {
    pub(crate) point: Vector,
    pub(crate) u: Vector,
    pub(crate) v: Vector,
}

/// A patch over `[0, 1]²`, row after row of control points along `u`.
#[derive(Debug, Clone, Default)]
pub(crate) struct Patch {
    pub(crate) rows: usize,
    pub(crate) columns: usize,
    pub(crate) rational: bool,
    pub(crate) net: Vec<Homogeneous>,
    /// The diagonal of the control points' box.
    pub(crate) size: f64,
}

impl Patch {
    /// The patch of these control points, with weights scaled so that the largest is about 1.
    pub(crate) fn new(mut net: Vec<Homogeneous>, rows: usize, columns: usize, rational: bool) -> Self {
        let largest = net.iter().map(|h| h[3]).fold(f64::MIN_POSITIVE, more);
        if rational {
            // A power of two, so that nothing is rounded.
            let scale = (-largest.log2().floor()).exp2();
            net.iter_mut().flatten().for_each(|x| *x *= scale);
        }
        let (mut low, mut high) = ([f64::MAX; 3], [f64::MIN; 3]);
        for point in net.iter().map(project) {
            for k in 0..3 {
                (low[k], high[k]) = (less(low[k], point[k]), more(high[k], point[k]));
            }
        }
        let size = (Vector::from(high) - Vector::from(low)).norm();
        Self { rows, columns, rational, net, size }
    }

    /// The degrees.
    fn degrees(&self) -> [f64; 2] {
        [self.rows, self.columns].map(|order| order as f64 - 1.0)
    }

    /// The control points from a row on.
    fn rows_from(&self, row: usize) -> &[Homogeneous] {
        self.net.get(row * self.columns..).unwrap_or_default()
    }

    /// Adds `A_uu` of degree `(p - 2, q)`, row after row.
    pub(crate) fn uu(&self, out: &mut impl Extend<Homogeneous>) {
        let [p, _] = self.degrees();
        let along = self.net.iter().zip(self.rows_from(1)).zip(self.rows_from(2));
        out.extend(along.map(|((a, b), c)| second(p * (p - 1.0), a, b, c)));
    }

    /// Adds `A_uv` of degree `(p - 1, q - 1)`.
    pub(crate) fn uv(&self, out: &mut impl Extend<Homogeneous>) {
        let ([p, q], columns) = (self.degrees(), self.columns);
        for (row, next) in self.net.chunks_exact(columns).zip(self.rows_from(1).chunks_exact(columns)) {
            let twist = |(a, b): (&[Homogeneous], &[Homogeneous])| {
                lanes(|l| p * q * (b[1][l] - b[0][l] - a[1][l] + a[0][l]))
            };
            out.extend(row.windows(2).zip(next.windows(2)).map(twist));
        }
    }

    /// Adds `A_vv` of degree `(p, q - 2)`.
    pub(crate) fn vv(&self, out: &mut impl Extend<Homogeneous>) {
        let [_, q] = self.degrees();
        for row in self.net.chunks_exact(self.columns) {
            out.extend(row.windows(3).map(|h| second(q * (q - 1.0), &h[0], &h[1], &h[2])));
        }
    }

    /// The point alone.
    pub(crate) fn point(&self, at: [f64; 2]) -> Vector {
        self.jet(at).point
    }

    /// Point and first derivatives. `O(p q)`.
    pub(crate) fn jet(&self, at: [f64; 2]) -> Jet {
        jet_of(&self.net, [self.rows, self.columns], self.rational, at)
    }

    /// `S_uu`, `S_uv`, `S_vv`: by the quotient rule from the second derivatives' nets, after point and first derivatives.
    pub(crate) fn second(&self, at: [f64; 2]) -> (Jet, [Vector; 3]) {
        let first = homogeneous(&self.net, [self.rows, self.columns], at);
        let (jet, [a, au, av]) = (quotient(&first, self.rational), first);
        let (p, q) = (self.rows, self.columns);
        let mut net = SmallVec::<[Homogeneous; 16]>::new();
        self.uu(&mut net);
        let uu = value(&net, p.saturating_sub(2), q, at);
        net.clear();
        self.uv(&mut net);
        let uv = value(&net, p.saturating_sub(1), q.saturating_sub(1), at);
        net.clear();
        self.vv(&mut net);
        let vv = value(&net, p, q.saturating_sub(2), at);
        let quotient = |h: Homogeneous, terms: Vector| (xyz(&h) - jet.point * h[3] - terms) / a[3];
        let second = [
            quotient(uu, jet.u * (2.0 * au[3])),
            quotient(uv, jet.v * au[3] + jet.u * av[3]),
            quotient(vv, jet.v * (2.0 * av[3])),
        ];
        (jet, second)
    }

    /// The control points of a side, in the direction of its parameter.
    pub(crate) fn side(&self, side: usize) -> impl Iterator<Item = &Homogeneous> + Clone {
        let (p, q) = (self.rows, self.columns);
        let (start, step, count) = match side {
            0 => (0, q, p),
            1 => ((p - 1) * q, 1, q),
            2 => (q - 1, q, p),
            _ => (0, 1, q),
        };
        self.net[start..].iter().step_by(step).take(count)
    }
}

/// All patches of a surface, made one by one from its control points in a frame.
pub(crate) struct Patches<'a> {
    surface: &'a Surface,
    net: Vec<Homogeneous>,
    spans: [Vec<usize>; 2],
    rows: [Vec<Vec<[f64; MAX_ORDER]>>; 2],
}

impl<'a> Patches<'a> {
    pub(crate) fn new(surface: &'a Surface, frame: &Frame) -> Self {
        let weight = |i: usize| surface.weights().map_or(1.0, |w| w[i]);
        let local = |(i, p): (usize, &loftsman_kernel::Point)| {
            let (x, w) = ((p - frame.centre) / frame.size, weight(i));
            [x.x * w, x.y * w, x.z * w, w]
        };
        let net = surface.points().iter().enumerate().map(local).collect();
        let spaces = [surface.u(), surface.v()];
        let spans = spaces.map(|space| space.spans().collect::<Vec<_>>());
        let rows = [0, 1].map(|d| {
            let (space, flat) = (spaces[d], spaces[d].flat());
            let matrix = |&span: &usize| {
                let mut rows = Vec::new();
                extraction(space, span, flat[span], flat[span + 1], &mut rows);
                rows
            };
            spans[d].iter().map(matrix).collect()
        });
        Self { surface, net, spans, rows }
    }

    /// How many patches there are along `u` and along `v`.
    pub(crate) fn counts(&self) -> [usize; 2] {
        [self.spans[0].len(), self.spans[1].len()]
    }

    /// The parameters between which patch `k` of a direction lies.
    pub(crate) fn ends(&self, direction: usize, k: usize) -> (f64, f64) {
        let space = if direction == 0 { self.surface.u() } else { self.surface.v() };
        let span = self.spans[direction][k];
        (space.flat()[span], space.flat()[span + 1])
    }

    /// Patch `(i, j)`. `O(p q (p + q))`.
    pub(crate) fn get(&self, i: usize, j: usize) -> Patch {
        let (u, v) = (self.surface.u(), self.surface.v());
        let (p, q) = (u.degree(), v.degree());
        let (first, across) = (self.spans[0][i] - p, self.spans[1][j] - q);
        let columns = q + 1;
        // The patch's control points along `v` in these spans, then along `u` as well.
        let mut strip: SmallVec<[Homogeneous; 16]> = smallvec![[0.0; 4]; (p + 1) * columns];
        for (r, out) in strip.chunks_exact_mut(columns).enumerate() {
            let start = u.vertex(first + r) * v.len();
            for c in 0..columns {
                let h = self.net[start + v.vertex(across + c)];
                for (out, shares) in out.iter_mut().zip(&self.rows[1][j]) {
                    *out = plus(*out, &h, shares[c]);
                }
            }
        }
        let mut net = vec![[0.0; 4]; (p + 1) * columns];
        for (out, shares) in net.chunks_exact_mut(columns).zip(&self.rows[0][i]) {
            for (row, &share) in strip.chunks_exact(columns).zip(shares) {
                for (out, h) in out.iter_mut().zip(row) {
                    *out = plus(*out, h, share);
                }
            }
        }
        Patch::new(net, p + 1, columns, self.surface.weights().is_some())
    }
}

/// A second difference of three control points in line.
fn second(factor: f64, a: &Homogeneous, b: &Homogeneous, c: &Homogeneous) -> Homogeneous {
    lanes(|l| factor * (c[l] - 2.0 * b[l] + a[l]))
}

/// A sum and a part of a control point.
fn plus(sum: Homogeneous, h: &Homogeneous, share: f64) -> Homogeneous {
    lanes(|l| sum[l] + share * h[l])
}

pub(crate) fn xyz(h: &Homogeneous) -> Vector {
    Vector::new(h[0], h[1], h[2])
}

pub(crate) fn project(h: &Homogeneous) -> Vector {
    xyz(h) / h[3]
}

fn lanes(f: impl Fn(usize) -> f64) -> Homogeneous {
    [f(0), f(1), f(2), f(3)]
}

/// The value of a net; zero where it is empty (a second derivative of a straight direction).
fn value(net: &[Homogeneous], rows: usize, columns: usize, [u, v]: [f64; 2]) -> Homogeneous {
    match rows.max(columns) {
        _ if rows.min(columns) == 0 => [0.0; 4],
        ..=4 => {
            zeroth_order(net, &bernstein::<4>(rows, u)[0][..rows], &bernstein::<4>(columns, v)[0][..columns])
        }
        _ => {
            let (u, v) = (bernstein::<MAX_ORDER>(rows, u), bernstein::<MAX_ORDER>(columns, v));
            zeroth_order(net, &u[0][..rows], &v[0][..columns])
        }
    }
}

/// The value of a net, given the Bernstein polynomials.
#[inline(always)]
fn zeroth_order(net: &[Homogeneous], u: &[f64], v: &[f64]) -> Homogeneous {
    let shares = u.iter().flat_map(|u| v.iter().map(move |v| u * v));
    net.iter().zip(shares).fold([0.0; 4], |sum, (h, share)| plus(sum, h, share))
}

/// Point and first derivatives of the patch of a net of `rows × columns`. `O(rows columns)`.
pub(crate) fn jet_of(net: &[Homogeneous], size: [usize; 2], rational: bool, at: [f64; 2]) -> Jet {
    quotient(&homogeneous(net, size, at), rational)
}

/// Point and first derivatives of the quotient.
fn quotient([a, au, av]: &[Homogeneous; 3], rational: bool) -> Jet {
    if !rational {
        return Jet { point: xyz(a), u: xyz(au), v: xyz(av) };
    }
    let (point, share) = (project(a), 1.0 / a[3]);
    Jet { point, u: (xyz(au) - point * au[3]) * share, v: (xyz(av) - point * av[3]) * share }
}

/// `A`, `A_u`, `A_v`. The usual orders have code of their own.
fn homogeneous(net: &[Homogeneous], size: [usize; 2], [u, v]: [f64; 2]) -> [Homogeneous; 3] {
    match size {
        [3, 3] => first_order(net, &bernstein::<3>(3, u), &bernstein::<3>(3, v), 3),
        [4, 4] => first_order(net, &bernstein::<4>(4, u), &bernstein::<4>(4, v), 4),
        [rows @ ..=4, columns @ ..=4] => {
            first_order(net, &bernstein::<4>(rows, u), &bernstein::<4>(columns, v), columns)
        }
        [rows, columns] => {
            let (u, v) = (bernstein::<MAX_ORDER>(rows, u), bernstein::<MAX_ORDER>(columns, v));
            first_order(net, &u, &v, columns)
        }
    }
}

/// Value and first derivatives of a net, given the Bernstein polynomials and their derivatives.
#[inline(always)]
fn first_order<const N: usize>(
    net: &[Homogeneous],
    [bu, du]: &[[f64; N]; 2],
    [bv, dv]: &[[f64; N]; 2],
    columns: usize,
) -> [Homogeneous; 3] {
    let mut sums = [[0.0; 4]; 3];
    for (i, row) in net.chunks_exact(columns).enumerate() {
        let (mut value, mut slope) = ([0.0; 4], [0.0; 4]);
        for (j, h) in row.iter().enumerate() {
            for l in 0..4 {
                value[l] += bv[j] * h[l];
                slope[l] += dv[j] * h[l];
            }
        }
        for l in 0..4 {
            sums[0][l] += bu[i] * value[l];
            sums[1][l] += du[i] * value[l];
            sums[2][l] += bu[i] * slope[l];
        }
    }
    sums
}

/// The Bernstein polynomials of an order, at most `N`, and their derivatives. `O(order²)`.
#[inline(always)]
fn bernstein<const N: usize>(order: usize, t: f64) -> [[f64; N]; 2] {
    let (mut b, mut d) = ([0.0; N], [0.0; N]);
    b[0] = 1.0;
    let s = 1.0 - t;
    for k in 1..order {
        if k + 1 == order {
            let p = k as f64;
            d[0] = -p * b[0];
            (1..k).for_each(|i| d[i] = p * (b[i - 1] - b[i]));
            d[k] = p * b[k - 1];
        }
        b[k] = t * b[k - 1];
        (1..k).rev().for_each(|i| b[i] = s * b[i] + t * b[i - 1]);
        b[0] *= s;
    }
    [b, d]
}
