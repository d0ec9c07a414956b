//! Plain scalar references: what the structure of each workload allows on this machine.

mod grid;

pub use grid::grid;

use crate::inputs::{Rows, cubic, cubic_slope};

/// W4: Cholesky of `F Fᵀ` in its band, rows in the order they come.
#[derive(Debug, Clone)]
pub struct BandCholesky {
    band: usize,
    lower: Vec<f64>,
    reciprocal: Vec<f64>,
    y: Vec<[f64; 3]>,
}

impl BandCholesky {
    /// Room for these rows.
    pub fn new(rows: &Rows) -> Self {
        let c = rows.count();
        let near = |i: usize, j: usize| rows.first[j] - rows.first[i] < 4;
        let band = (0..c).map(|i| (i..c).take_while(|&j| near(i, j)).count() - 1).max().unwrap_or(0);
        let lower = vec![0.0; c * (band + 1)];
        Self { band, lower, reciprocal: vec![0.0; c], y: vec![[0.0; 3]; c] }
    }

    /// Mouse down.
    pub fn factor(&mut self, rows: &Rows) {
        let (w, band) = (self.band + 1, self.band);
        for i in 0..rows.count() {
            let low = i.saturating_sub(band);
            for j in low..=i {
                let mut sum = dot(rows, i, j);
                for k in low.max(j.saturating_sub(band))..j {
                    sum -= self.lower[i * w + k + band - i] * self.lower[j * w + k + band - j];
                }
                if i == j {
                    let root = sum.sqrt();
                    self.lower[i * w + band] = root;
                    self.reciprocal[i] = 1.0 / root;
                } else {
                    self.lower[i * w + j + band - i] = sum * self.reciprocal[j];
                }
            }
        }
    }

    /// Mouse move: `d = Fᵀ (F Fᵀ)⁻¹ b` into the vertices that the rows touch; the others are not looked at.
    pub fn solve(&mut self, rows: &Rows, b: &[[f64; 3]], d: &mut [[f64; 3]]) {
        let (c, w, band) = (rows.count(), self.band + 1, self.band);
        for i in 0..c {
            let mut sum = b[i];
            for k in i.saturating_sub(band)..i {
                let l = self.lower[i * w + k + band - i];
                for q in 0..3 {
                    sum[q] -= l * self.y[k][q];
                }
            }
            self.y[i] = sum.map(|s| s * self.reciprocal[i]);
        }
        for i in (0..c).rev() {
            let mut sum = self.y[i];
            for k in i + 1..(i + band + 1).min(c) {
                let l = self.lower[k * w + i + band - k];
                for q in 0..3 {
                    sum[q] -= l * self.y[k][q];
                }
            }
            self.y[i] = sum.map(|s| s * self.reciprocal[i]);
        }
        for &first in &rows.first {
            d[first..first + 4].fill([0.0; 3]);
        }
        for ((&first, values), y) in rows.first.iter().zip(&rows.values).zip(&self.y) {
            for (d, value) in d[first..first + 4].iter_mut().zip(values) {
                for q in 0..3 {
                    d[q] += value * y[q];
                }
            }
        }
    }
}

/// The inner product of two rows of four neighbouring entries.
fn dot(rows: &Rows, i: usize, j: usize) -> f64 {
    let (fi, fj) = (rows.first[i], rows.first[j]);
    let (low, high) = (fi.max(fj), fi.min(fj) + 4);
    (low..high).map(|k| rows.values[i][k - fi] * rows.values[j][k - fj]).sum()
}

/// W1: a cubic curve as one polynomial a span, evaluated by Horner at ascending parameters.
#[derive(Debug, Clone)]
pub struct SpanPolynomials {
    knots: Vec<f64>,
    /// Of each span: the coefficients of 1, x, x², x³.
    coefficients: Vec<[[f64; 3]; 4]>,
}

impl SpanPolynomials {
    /// The polynomials of a clamped cubic without repeated interior knots.
    pub fn new(t: &[f64], points: &[[f64; 3]]) -> Self {
        let coefficients = (3..points.len())
            .map(|s| {
                // Differences of differences: the control vertices of the derivatives that matter at t[s].
                let rows = [cubic(t, s, t[s]), cubic_slope(t, s, t[s])];
                let mut c = [[0.0; 3]; 4];
                let slope = |i: usize, q: usize| 3.0 * (points[i][q] - points[i - 1][q]) / (t[i + 3] - t[i]);
                let bend = |i: usize, q: usize| 2.0 * (slope(i, q) - slope(i - 1, q)) / (t[i + 2] - t[i]);
                for q in 0..3 {
                    for k in 0..4 {
                        c[0][q] += rows[0][k] * points[s - 3 + k][q];
                        c[1][q] += rows[1][k] * points[s - 3 + k][q];
                    }
                    c[2][q] = 0.5 * bend(s - 1, q);
                    c[3][q] = (bend(s, q) - bend(s - 1, q)) / (t[s + 1] - t[s]) / 6.0;
                }
                c
            })
            .collect();
        Self { knots: t[3..=points.len()].to_vec(), coefficients }
    }

    /// Points at ascending parameters.
    pub fn points(&self, parameters: &[f64], out: &mut [[f64; 3]]) {
        let mut s = 0;
        for (&u, out) in parameters.iter().zip(out) {
            while s + 1 < self.coefficients.len() && u >= self.knots[s + 1] {
                s += 1;
            }
            let (x, [a, b, c, d]) = (u - self.knots[s], &self.coefficients[s]);
            for q in 0..3 {
                out[q] = a[q] + x * (b[q] + x * (c[q] + x * d[q]));
            }
        }
    }

    /// Points, first and second derivatives at ascending parameters.
    pub fn derivatives(&self, parameters: &[f64], out: &mut [[[f64; 3]; 3]]) {
        let mut s = 0;
        for (&u, out) in parameters.iter().zip(out) {
            while s + 1 < self.coefficients.len() && u >= self.knots[s + 1] {
                s += 1;
            }
            let (x, [a, b, c, d]) = (u - self.knots[s], &self.coefficients[s]);
            for q in 0..3 {
                out[0][q] = a[q] + x * (b[q] + x * (c[q] + x * d[q]));
                out[1][q] = b[q] + x * (2.0 * c[q] + 3.0 * x * d[q]);
                out[2][q] = 2.0 * c[q] + 6.0 * x * d[q];
            }
        }
    }
}

/// Cubic interpolation: chord lengths, knots by averaging, Gaussian elimination in the band. (Collocation matrices of
/// B-splines are totally positive: without pivoting nothing grows.)
pub fn interpolate(points: &[[f64; 3]]) -> Vec<[f64; 3]> {
    const REACH: usize = 3;
    const WIDTH: usize = 2 * REACH + 1;
    let n = points.len();
    let mut at = vec![0.0; n];
    for i in 1..n {
        let step: f64 = (0..3).map(|q| (points[i][q] - points[i - 1][q]).powi(2)).sum();
        at[i] = at[i - 1] + step.sqrt();
    }
    let mut t = vec![at[0]; 4];
    t.extend((1..n - 3).map(|j| (at[j] + at[j + 1] + at[j + 2]) / 3.0));
    t.extend([at[n - 1]; 4]);
    let mut band = vec![[0.0; WIDTH]; n];
    let mut x = points.to_vec();
    let mut s = 3;
    for i in 0..n {
        while s < n - 1 && at[i] >= t[s + 1] {
            s += 1;
        }
        for (k, value) in cubic(&t, s, at[i]).into_iter().enumerate() {
            let column = s - 3 + k;
            if value != 0.0 {
                band[i][column + REACH - i] = value;
            }
        }
    }
    for i in 0..n {
        let pivot = band[i];
        let value = x[i];
        for j in i + 1..(i + REACH + 1).min(n) {
            let factor = band[j][i + REACH - j] / pivot[REACH];
            for k in i..(i + REACH + 1).min(n) {
                band[j][k + REACH - j] -= factor * pivot[k + REACH - i];
            }
            for q in 0..3 {
                x[j][q] -= factor * value[q];
            }
        }
    }
    for i in (0..n).rev() {
        for j in i + 1..(i + REACH + 1).min(n) {
            for q in 0..3 {
                x[i][q] -= band[i][j + REACH - i] * x[j][q];
            }
        }
        x[i] = x[i].map(|v| v / band[i][REACH]);
    }
    x
}

/// W6: the Cholesky factor of a matrix of half bandwidth 3, in place.
#[derive(Debug, Clone)]
pub struct Banded {
    /// A row's three entries to the left of the diagonal, and the reciprocal of that on it.
    lower: Vec<[f64; 4]>,
}

impl Banded {
    /// The mass matrix of `n` uniform cubics, as it is far from the ends (which costs as much): 2416, 1191, 120 and 1 of 5040.
    pub fn mass_of_uniform_cubic(n: usize) -> Self {
        let mass = [2416.0 / 5040.0, 1191.0 / 5040.0, 120.0 / 5040.0, 1.0 / 5040.0];
        let mut lower: Vec<[f64; 4]> = Vec::with_capacity(n);
        for i in 0..n {
            let mut row = [0.0; 4];
            for back in (0..=i.min(3)).rev() {
                let j = i - back;
                // Columns k before j that both rows have.
                let before: f64 = (back + 1..=i.min(3))
                    .map(|further| {
                        row[3 - further]
                            * if back == 0 { row[3 - further] } else { lower[j][3 + back - further] }
                    })
                    .sum();
                let left = mass[back] - before;
                row[3 - back] = if back == 0 { 1.0 / left.sqrt() } else { left * lower[j][3] };
            }
            lower.push(row);
        }
        Self { lower }
    }

    /// `(L Lᵀ)⁻¹ x` into `x`.
    pub fn solve(&mut self, x: &mut [[f64; 3]]) {
        let n = x.len().min(self.lower.len());
        for i in 0..n {
            let row = self.lower[i];
            let mut sum = x[i];
            for back in 1..=i.min(3) {
                for axis in 0..3 {
                    sum[axis] -= row[3 - back] * x[i - back][axis];
                }
            }
            x[i] = sum.map(|s| s * row[3]);
        }
        for i in (0..n).rev() {
            let row = self.lower[i];
            let value = x[i].map(|s| s * row[3]);
            x[i] = value;
            for back in 1..=i.min(3) {
                for axis in 0..3 {
                    x[i - back][axis] -= row[3 - back] * value[axis];
                }
            }
        }
    }
}
