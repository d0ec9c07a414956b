//! Splines by the book: basis functions by their recursion, rational derivatives by the quotient rule, curvature by the
//! textbook's formula. And the random curves that are asked.

use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

/// Numbers that are the same everywhere (Knuth's MMIX multiplier), the high bits used.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        let mut random = Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x1234_5678_9abc_def1);
        for _ in 0..4 {
            random.unit();
        }
        random
    }

    /// In `[0, 1)`.
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn between(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.unit()
    }

    pub(crate) fn below(&mut self, limit: usize) -> usize {
        (self.unit() * limit as f64) as usize
    }

    pub(crate) fn of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len())]
    }

    pub(crate) fn vector(&mut self) -> Vector {
        Vector::new(self.between(-1.0, 1.0), self.between(-1.0, 1.0), self.between(-1.0, 1.0))
    }
}

/// The raw numbers of a curve.
#[derive(Debug, Clone)]
pub(crate) struct Spline {
    pub(crate) degree: usize,
    pub(crate) periodic: bool,
    pub(crate) knots: Vec<f64>,
    pub(crate) points: Vec<Point>,
    pub(crate) weights: Option<Vec<f64>>,
}

impl Spline {
    pub(crate) fn of(curve: &Curve) -> Self {
        Self {
            degree: curve.degree(),
            periodic: curve.space().is_periodic(),
            knots: curve.space().knots().to_vec(),
            points: curve.points().to_vec(),
            weights: curve.weights().map(<[f64]>::to_vec),
        }
    }

    pub(crate) fn curve(&self) -> Curve {
        let space = if self.periodic {
            Space::periodic(self.degree, self.knots.clone())
        } else {
            Space::open(self.degree, self.knots.clone())
        };
        Curve::build(space.unwrap(), self.points.clone(), self.weights.clone()).unwrap()
    }

    /// Knots and the vertex of each basis function, a closed curve unrolled to both sides.
    fn unrolled(&self) -> (Vec<f64>, Vec<usize>) {
        let n = self.points.len();
        if !self.periodic {
            return (self.knots.clone(), (0..n).collect());
        }
        let period = self.knots[n] - self.knots[0];
        let turns = self.degree as i64 / n as i64 + 2;
        let range = -turns * n as i64..=(turns + 1) * n as i64;
        let knot =
            |i: i64| self.knots[i.rem_euclid(n as i64) as usize] + period * i.div_euclid(n as i64) as f64;
        let knots: Vec<f64> = range.clone().map(knot).collect();
        let count = knots.len() - self.degree - 1;
        (knots, range.take(count).map(|i| i.rem_euclid(n as i64) as usize).collect())
    }

    pub(crate) fn domain(&self) -> (f64, f64) {
        let n = self.points.len();
        if self.periodic { (self.knots[0], self.knots[n]) } else { (self.knots[self.degree], self.knots[n]) }
    }

    /// Position and two derivatives, from the right (at the end of an open curve from the left).
    pub(crate) fn jet(&self, u: f64) -> [Vector; 3] {
        self.sums(u).0
    }

    /// What rounding of the control vertices alone makes of the curvature.
    pub(crate) fn noise(&self, u: f64) -> f64 {
        let ([_, first, second], sizes) = self.sums(u);
        let (s, [one, two]) = (first.norm(), sizes.map(|size| f64::EPSILON * size));
        (two + one * second.norm() / s) / (s * s)
    }

    /// The same, and `Σ |c_i| |P_i|` of both derivatives.
    fn sums(&self, u: f64) -> ([Vector; 3], [f64; 2]) {
        let (knots, vertices) = self.unrolled();
        let (p, end) = (self.degree, self.domain().1);
        let at_end = !self.periodic && u >= end;
        let inside = |i: usize| {
            if at_end { knots[i] < u && u <= knots[i + 1] } else { knots[i] <= u && u < knots[i + 1] }
        };
        // N_{i,q} for all i, degree after degree; 0/0 is 0.
        let mut table =
            vec![(0..knots.len() - 1).map(|i| f64::from(u8::from(inside(i)))).collect::<Vec<f64>>()];
        let over = |a: f64, b: f64| if b == 0.0 { 0.0 } else { a / b };
        for q in 1..=p {
            let low = &table[q - 1];
            let next = (0..low.len() - 1)
                .map(|i| {
                    over(u - knots[i], knots[i + q] - knots[i]) * low[i]
                        + over(knots[i + q + 1] - u, knots[i + q + 1] - knots[i + 1]) * low[i + 1]
                })
                .collect();
            table.push(next);
        }
        // d-th derivative of N_{i,q}.
        fn derivative(table: &[Vec<f64>], knots: &[f64], i: usize, q: usize, d: usize) -> f64 {
            if d == 0 {
                return table[q][i];
            }
            if q == 0 {
                return 0.0;
            }
            let share = |j: usize| {
                let width = knots[j + q] - knots[j];
                if width == 0.0 { 0.0 } else { q as f64 / width * derivative(table, knots, j, q - 1, d - 1) }
            };
            share(i) - share(i + 1)
        }
        let (mut sums, mut sizes) = ([(Vector::zeros(), 0.0); 3], [0.0; 3]);
        for (i, &vertex) in vertices.iter().enumerate() {
            let weight = self.weights.as_ref().map_or(1.0, |w| w[vertex]);
            for (d, sum) in sums.iter_mut().enumerate() {
                let basis = derivative(&table, &knots, i, p, d) * weight;
                sizes[d] += (self.points[vertex].coords * basis).norm();
                *sum = (sum.0 + self.points[vertex].coords * basis, sum.1 + basis);
            }
        }
        let [(a0, w0), (a1, w1), (a2, w2)] = sums;
        let c0 = a0 / w0;
        let c1 = (a1 - c0 * w1) / w0;
        ([c0, c1, (a2 - c1 * (2.0 * w1) - c0 * w2) / w0], [sizes[1] / w0, sizes[2] / w0])
    }

    pub(crate) fn turn(&self, u: f64) -> Turn {
        let [_, first, second] = self.jet(u);
        let tangent = first.normalize();
        let cross = first.cross(&second);
        Turn {
            first,
            tangent,
            kappa: cross.norm() / first.norm().powi(3),
            vector: (second - tangent * tangent.dot(&second)) / first.norm_squared(),
        }
    }
}

/// How a curve turns at a place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Turn {
    pub(crate) first: Vector,
    pub(crate) tangent: Vector,
    /// `|C' × C''| / |C'|³`.
    pub(crate) kappa: f64,
    /// `κN`.
    pub(crate) vector: Vector,
}

/// The least rotation that takes unit vector `from` to `to`, by Rodrigues' formula, of a vector.
pub(crate) fn turned(v: Vector, from: Vector, to: Vector) -> Vector {
    let (axis, cos) = (from.cross(&to), from.dot(&to));
    v + axis.cross(&v) + axis.cross(&axis.cross(&v)) / (1.0 + cos)
}

/// A random curve: degree 2 to 7 and 25, clamped, floating or closed, knots repeated up to `p` times, rational with unlike
/// weights, planar or not, of any size.
pub(crate) fn any_spline(random: &mut Random) -> Spline {
    let degree = random.of(&[2, 3, 3, 3, 4, 5, 6, 7, 25]);
    let periodic = random.below(3) == 0;
    let clamped = random.below(2) == 0;
    let mut breaks = vec![0.0];
    for _ in 0..3 + random.below(6) {
        let gap = random.of(&[1.0, 1.0, 0.5, 0.2, 2.0, 1.3]);
        breaks.push(breaks[breaks.len() - 1] + gap);
    }
    let most = if degree > 7 { 3 } else { degree };
    let mut knots = Vec::new();
    if periodic {
        knots.push(breaks[0]);
        for &b in &breaks[1..breaks.len() - 1] {
            knots.extend(std::iter::repeat_n(
                b,
                if random.below(3) == 0 { 1 + random.below(most) } else { 1 },
            ));
        }
        knots.push(breaks[breaks.len() - 1]);
        // As many vertices as a closed curve of the degree needs.
        while knots.len() < degree + 3 {
            let last = knots[knots.len() - 1];
            knots.push(last + 1.0);
        }
    } else {
        let (a, b) = (breaks[0], breaks[breaks.len() - 1]);
        let outside = |i: usize| if clamped { 0.0 } else { 0.4 * i as f64 };
        knots.extend((0..=degree).rev().map(|i| a - outside(i)));
        for &inner in &breaks[1..breaks.len() - 1] {
            knots.extend(std::iter::repeat_n(
                inner,
                if random.below(3) == 0 { 1 + random.below(most) } else { 1 },
            ));
        }
        knots.extend((0..=degree).map(|i| b + outside(i)));
    }
    let n = if periodic { knots.len() - 1 } else { knots.len() - degree - 1 };
    let planar = random.below(3) == 0;
    let size = random.of(&[1.0, 1.0, 1.0, 10.0, 1e-9, 1e9, 1e3]);
    let points = (0..n)
        .map(|i| {
            let t = i as f64 / n as f64 * std::f64::consts::TAU * if periodic { 1.0 } else { 0.8 };
            let base = Vector::new(3.0 * t.cos(), 2.0 * t.sin(), (2.0 * t).sin());
            let mut at = (base + random.vector() * 0.15) * size;
            if planar {
                at.z = 0.0;
            }
            Point::from(at)
        })
        .collect();
    let weights = (random.below(3) == 0).then(|| (0..n).map(|_| random.between(0.3, 3.0)).collect());
    Spline { degree, periodic, knots, points, weights }
}

/// A place: inside, at a knot, at an end.
pub(crate) fn any_place(spline: &Spline, random: &mut Random) -> f64 {
    let (a, b) = spline.domain();
    match random.below(5) {
        0 => a,
        1 if !spline.periodic => b,
        2 => {
            let inner: Vec<f64> = spline.knots.iter().copied().filter(|k| (a..b).contains(k)).collect();
            random.of(&inner)
        }
        _ => random.between(a, b),
    }
}
