//! Plain scalar references: what the structure of each workload allows on this machine.

use crate::inputs::Rows;

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
