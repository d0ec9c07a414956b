//! Derivatives of surfaces with twice the digits, by another way: differences of control points, de Boor's algorithm and the
//! quotient rule, where the kernel combines basis functions. What tests of derivatives compare with.

use std::ops::{Add, Div, Mul, Sub};

use crate::Vector;
use crate::spline::{Space, Surface};

/// An unevaluated sum of two numbers, the second below half a unit in the last place of the first (Dekker 1971).
#[derive(Debug, Clone, Copy, PartialEq)]
struct Double(f64, f64);

impl Double {
    const ZERO: Self = Self(0.0, 0.0);

    fn of(high: f64, low: f64) -> Self {
        let sum = high + low;
        Self(sum, low - (sum - high))
    }

    fn value(self) -> f64 {
        self.0 + self.1
    }
}

impl From<f64> for Double {
    fn from(value: f64) -> Self {
        Self(value, 0.0)
    }
}

impl Add for Double {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let sum = self.0 + other.0;
        let part = sum - self.0;
        let error = (self.0 - (sum - part)) + (other.0 - part);
        Self::of(sum, error + self.1 + other.1)
    }
}

impl Sub for Double {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + Self(-other.0, -other.1)
    }
}

impl Mul for Double {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let product = self.0 * other.0;
        let error = self.0.mul_add(other.0, -product);
        Self::of(product, error + (self.0 * other.1 + self.1 * other.0))
    }
}

impl Div for Double {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let first = Self::from(self.0 / other.0);
        let rest = self - first * other;
        let second = Self::from(rest.0 / other.0);
        let rest = rest - second * other;
        first + second + Self::from(rest.0 / other.0)
    }
}

/// A derivative on a span: differences of the coefficients of its functions, then de Boor's algorithm.
fn along(space: &Space, span: usize, u: f64, order: usize, mut c: Vec<Double>) -> Double {
    let p = space.degree();
    if order > p {
        return Double::ZERO;
    }
    let t = |k: usize| Double::from(space.flat()[k]);
    // `c[i]` belongs to function `span - p + r + i` of the space of degree `p - r`.
    for r in 1..=order {
        let degree = Double::from((p + 1 - r) as f64);
        c = (0..=p - r)
            .map(|i| degree * (c[i + 1] - c[i]) / (t(span + 1 + i) - t(span + r + i - p)))
            .collect();
    }
    for r in order + 1..=p {
        c = (0..=p - r)
            .map(|i| {
                let (left, right) = (t(span + r + i - p), t(span + 1 + i));
                let share = (Double::from(u) - left) / (right - left);
                c[i] + share * (c[i + 1] - c[i])
            })
            .collect();
    }
    c[0]
}

fn binomial(n: usize, k: usize) -> f64 {
    (0..k).fold(1.0, |b, i| b * (n - i) as f64 / (i + 1) as f64)
}

/// The derivatives of orders `0..=m` by `0..=n`, and the size of each: what rounding errors of one unit at every coordinate of
/// every homogeneous control point add up to there, in units.
pub(super) fn derivatives(surface: &Surface, [u, v]: [f64; 2], [m, n]: [usize; 2]) -> Vec<(Vector, f64)> {
    let (su, sv) = (surface.u(), surface.v());
    let (p, q) = (su.degree(), sv.degree());
    let (i0, j0) = (su.span(u), sv.span(v));
    let weight = |at: usize| surface.weights().map_or(1.0, |w| w[at]);
    let vertex = |i: usize, j: usize| su.vertex(i0 - p + i) * sv.len() + sv.vertex(j0 - q + j);
    let homogeneous = |k: usize, l: usize, axis: usize| {
        let column = |j: usize| {
            let own = (0..=p).map(|i| {
                let at = vertex(i, j);
                let w = Double::from(weight(at));
                if axis == 3 { w } else { w * Double::from(surface.points()[at][axis]) }
            });
            along(su, i0, u, k, own.collect())
        };
        along(sv, j0, v, l, (0..=q).map(column).collect())
    };
    let basis = |space: &Space, span: usize, t: f64, order: usize| {
        let mut values = vec![0.0; space.degree() + 1];
        if order <= space.degree() {
            space.basis_into(span, t, order, &mut values);
        }
        values
    };
    // The size of a homogeneous derivative's terms, with and without coordinates.
    let terms = |k: usize, l: usize| {
        let (a, b) = (basis(su, i0, u, k), basis(sv, j0, v, l));
        let mut sums = [0.0; 2];
        for (i, a) in a.iter().enumerate() {
            for (j, b) in b.iter().enumerate() {
                let at = vertex(i, j);
                let own = (a * b).abs() * weight(at);
                sums[0] += own * surface.points()[at].coords.amax();
                sums[1] += own;
            }
        }
        sums
    };
    let rational = surface.weights().is_some();
    let mut found: Vec<([Double; 3], f64)> = Vec::with_capacity((m + 1) * (n + 1));
    let w = homogeneous(0, 0, 3);
    for k in 0..=m {
        for l in 0..=n {
            let mut own = [0, 1, 2].map(|axis| homogeneous(k, l, axis));
            let mut size = terms(k, l)[0];
            for (i, j) in (0..=k).flat_map(|i| (0..=l).map(move |j| (i, j))).filter(|&ij| ij != (0, 0)) {
                if !rational {
                    break;
                }
                let times = binomial(k, i) * binomial(l, j);
                let by = homogeneous(i, j, 3) * Double::from(times);
                let (lower, lower_size) = &found[(k - i) * (n + 1) + (l - j)];
                (0..3).for_each(|axis| own[axis] = own[axis] - by * lower[axis]);
                size += times * terms(i, j)[1] * lower_size;
            }
            found.push((own.map(|c| c / w), size / w.value()));
        }
    }
    found.into_iter().map(|(own, size)| (Vector::from(own.map(Double::value)), size)).collect()
}

#[test]
fn it_has_twice_the_digits() {
    let third = Double::from(1.0) / Double::from(3.0);
    let nothing = third * Double::from(3.0) - Double::from(1.0);
    assert!(nothing.value().abs() < 1e-31 && third.1 != 0.0);
    // 1e16 + 1 - 1e16, which one number loses.
    assert_eq!((Double::from(1e16) + Double::from(1.0) - Double::from(1e16)).value(), 1.0);
}

/// A quarter of a cylinder: an exact circle along u.
#[test]
fn a_circle_has_its_derivatives() {
    let s = 0.5_f64.sqrt();
    let points = [[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let net = points.iter().flat_map(|p| [0.0, 2.0].map(|z| crate::Point::new(p[0], p[1], z))).collect();
    let (u, v) = (Space::clamped_uniform(2, 3).unwrap(), Space::clamped_uniform(1, 2).unwrap());
    let surface = Surface::rational(u, v, net, vec![1.0, 1.0, s, s, 1.0, 1.0]).unwrap();
    let all = derivatives(&surface, [0.3, 0.4], [2, 1]);
    let [point, along, bend] = [all[0].0, all[2].0, all[4].0];
    // x² + y² = 1 and its derivatives.
    let plane = |a: &Vector, b: &Vector| a.x * b.x + a.y * b.y;
    assert!((plane(&point, &point) - 1.0).abs() < 1e-15 && plane(&point, &along).abs() < 1e-15);
    assert!((plane(&point, &bend) + plane(&along, &along)).abs() < 1e-14);
    assert!((point.z - 0.8).abs() < 1e-15 && (all[1].0 - Vector::new(0.0, 0.0, 2.0)).norm() < 1e-15);
}
