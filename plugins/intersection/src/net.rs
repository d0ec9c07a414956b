//! Polynomial pieces of curves and surfaces as Bézier nets in homogeneous coordinates `(wx, wy, wz, w)`.
//!
//! A curve is a net with one column. Everything is convex combination or difference, so that all bounds are those of
//! the convex hull (Farin, *Curves and Surfaces for CAGD*, 5th ed., ch. 5 and 13).

use loftsman_kernel::error::MAX_DEGREE;
use loftsman_kernel::{Point, Vector};

/// A homogeneous point.
pub(crate) type Four = [f64; 4];

/// Where and how large shapes are: pieces are kept around `center`, with `size` as unit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame {
    pub(crate) center: Point,
    pub(crate) size: f64,
}

impl Frame {
    pub(crate) fn around(boxes: &[(Point, Point)]) -> Option<Self> {
        let (mut low, mut high) = *boxes.first()?;
        for (l, h) in boxes {
            (low, high) = (low.inf(l), high.sup(h));
        }
        let center = Point::from(low.coords * 0.5 + high.coords * 0.5);
        let extent = (high - low).amax();
        let size = if extent > 0.0 { extent } else { center.coords.amax().max(f64::MIN_POSITIVE) };
        (size.is_finite() && size >= 1e-280 && center.coords.amax() < 1e280).then_some(Self { center, size })
    }

    pub(crate) fn homogeneous(&self, point: &Point, weight: f64) -> Four {
        let d = (point - self.center) / self.size;
        [d.x * weight, d.y * weight, d.z * weight, weight]
    }
}

/// A range of numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Range {
    pub(crate) low: f64,
    pub(crate) high: f64,
}

impl Range {
    pub(crate) const EMPTY: Self = Self { low: f64::INFINITY, high: f64::NEG_INFINITY };

    pub(crate) fn add(&mut self, x: f64) {
        self.low = self.low.min(x);
        self.high = self.high.max(x);
    }

    pub(crate) fn times(self, other: Self) -> Self {
        let mut range = Self::EMPTY;
        for x in [self.low * other.low, self.low * other.high, self.high * other.low, self.high * other.high]
        {
            range.add(x);
        }
        range
    }

    pub(crate) fn minus(self, other: Self) -> Self {
        Self { low: self.low - other.high, high: self.high - other.low }
    }

    pub(crate) fn plus(self, other: Self) -> Self {
        Self { low: self.low + other.low, high: self.high + other.high }
    }

    pub(crate) fn scaled(self, by: f64) -> Self {
        self.times(Self { low: by, high: by })
    }

    pub(crate) fn magnitude(self) -> f64 {
        self.low.abs().max(self.high.abs())
    }
}

/// One polynomial piece: the parameters that it covers, its orders and its net, row after row.
#[derive(Debug, Clone)]
pub(crate) struct Piece {
    pub(crate) low: [f64; 2],
    pub(crate) high: [f64; 2],
    pub(crate) orders: [usize; 2],
    pub(crate) net: Vec<Four>,
}

/// A point and its first derivatives by the local parameters, each from 0 to 1.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Jet {
    pub(crate) point: Vector,
    pub(crate) along: [Vector; 2],
}

impl Piece {
    /// The number of its parameters.
    pub(crate) fn parameters(&self) -> usize {
        if self.orders[1] == 1 { 1 } else { 2 }
    }

    /// The box of its control vertices.
    pub(crate) fn bounds(&self) -> [Range; 3] {
        let mut bounds = [Range::EMPTY; 3];
        for c in &self.net {
            for k in 0..3 {
                bounds[k].add(c[k] / c[3]);
            }
        }
        bounds
    }

    /// Its extent in a direction of space: the control vertices' range along it.
    pub(crate) fn along(&self, direction: &Vector) -> Range {
        let mut range = Range::EMPTY;
        for c in &self.net {
            range.add((c[0] * direction.x + c[1] * direction.y + c[2] * direction.z) / c[3]);
        }
        range
    }

    /// The largest extent of its box.
    pub(crate) fn extent(&self) -> f64 {
        self.bounds().iter().map(|r| r.high - r.low).fold(0.0, f64::max)
    }

    /// How far its net runs in one direction: the longest leg, summed up.
    pub(crate) fn run(&self, direction: usize) -> f64 {
        let [rows, columns] = self.orders;
        let (steps, step, lines, line) =
            if direction == 0 { (rows, columns, columns, 1) } else { (columns, 1, rows, columns) };
        let point = |k: usize| {
            let c = &self.net[k];
            Vector::new(c[0] / c[3], c[1] / c[3], c[2] / c[3])
        };
        (0..lines)
            .map(|l| {
                (1..steps)
                    .map(|s| (point(l * line + s * step) - point(l * line + (s - 1) * step)).norm())
                    .sum()
            })
            .fold(0.0, f64::max)
    }

    /// The ranges of the four homogeneous coordinates around a point.
    pub(crate) fn values(&self, around: &Vector) -> [Range; 4] {
        ranges(self.net.iter().copied(), around)
    }

    /// The ranges of the derivatives of the four by a local parameter.
    pub(crate) fn slopes(&self, direction: usize, around: &Vector) -> [Range; 4] {
        let [rows, columns] = self.orders;
        let (degree, step) = if direction == 0 { (rows - 1, columns) } else { (columns - 1, 1) };
        let inner = if direction == 0 { (rows - 1, columns) } else { (rows, columns - 1) };
        let factor = degree as f64;
        let legs = (0..inner.0).flat_map(move |i| (0..inner.1).map(move |j| i * columns + j)).map(|k| {
            let (a, b) = (&self.net[k], &self.net[k + step]);
            [0, 1, 2, 3].map(|l| factor * (b[l] - a[l]))
        });
        ranges(legs, around)
    }

    /// Both halves in one direction.
    pub(crate) fn halves(&self, direction: usize) -> [Self; 2] {
        self.cut(direction, 0.5)
    }

    /// Both parts in one direction, cut at a local parameter (de Casteljau).
    pub(crate) fn cut(&self, direction: usize, local: f64) -> [Self; 2] {
        let rest = 1.0 - local;
        let middle = rest * self.low[direction] + local * self.high[direction];
        let [rows, columns] = self.orders;
        let (steps, step, lines, line) =
            if direction == 0 { (rows, columns, columns, 1) } else { (columns, 1, rows, columns) };
        let (mut left, mut right) = (self.clone(), self.clone());
        for l in 0..lines {
            let at = |s: usize| l * line + s * step;
            for r in 1..steps {
                for s in 0..steps - r {
                    let (a, b) = (right.net[at(s)], right.net[at(s + 1)]);
                    right.net[at(s)] = [0, 1, 2, 3].map(|k| rest * a[k] + local * b[k]);
                }
                left.net[at(r)] = right.net[at(0)];
            }
        }
        left.high[direction] = middle;
        right.low[direction] = middle;
        [left, right]
    }

    /// Whether a half in this direction would have parameters between its ends.
    pub(crate) fn splits(&self, direction: usize) -> bool {
        let (a, b) = (self.low[direction], self.high[direction]);
        let middle = 0.5 * a + 0.5 * b;
        a < middle && middle < b
    }

    /// The shape's parameter at a local one.
    pub(crate) fn parameter(&self, direction: usize, local: f64) -> f64 {
        let (a, b) = (self.low[direction], self.high[direction]);
        if local >= 1.0 { b } else { (a + (b - a) * local).clamp(a, b) }
    }

    /// The point and its first derivatives at local parameters. `O(pq)`.
    pub(crate) fn jet(&self, at: [f64; 2]) -> Jet {
        let [rows, columns] = self.orders;
        let (bu, su) = bernstein(rows - 1, at[0]);
        let (bv, sv) = bernstein(columns - 1, at[1]);
        let mut sums = [[0.0; 4]; 3];
        for i in 0..rows {
            for j in 0..columns {
                let c = &self.net[i * columns + j];
                let factors = [bu[i] * bv[j], su[i] * bv[j], bu[i] * sv[j]];
                for (sum, factor) in sums.iter_mut().zip(factors) {
                    for k in 0..4 {
                        sum[k] += factor * c[k];
                    }
                }
            }
        }
        let [value, du, dv] = sums;
        let space = |c: &Four| Vector::new(c[0], c[1], c[2]);
        let point = space(&value) / value[3];
        let by = |d: &Four| (space(d) - point * d[3]) / value[3];
        Jet { point, along: [by(&du), by(&dv)] }
    }
}

/// The Bernstein polynomials of a degree, and their derivatives, at `t`.
fn bernstein(degree: usize, t: f64) -> ([f64; MAX_DEGREE + 1], [f64; MAX_DEGREE + 1]) {
    let mut values = [0.0; MAX_DEGREE + 1];
    let mut slopes = [0.0; MAX_DEGREE + 1];
    values[0] = 1.0;
    for p in 1..=degree {
        if p == degree {
            for i in 0..=degree {
                let before = if i > 0 { values[i - 1] } else { 0.0 };
                let here = if i < degree { values[i] } else { 0.0 };
                slopes[i] = degree as f64 * (before - here);
            }
        }
        for i in (0..=p).rev() {
            let before = if i > 0 { values[i - 1] } else { 0.0 };
            values[i] = t * before + (1.0 - t) * if i < p { values[i] } else { 0.0 };
        }
    }
    (values, slopes)
}

fn ranges(values: impl Iterator<Item = Four>, around: &Vector) -> [Range; 4] {
    let mut ranges = [Range::EMPTY; 4];
    for c in values {
        for k in 0..3 {
            ranges[k].add(c[k] - around[k] * c[3]);
        }
        ranges[3].add(c[3]);
    }
    ranges
}
