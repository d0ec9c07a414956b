//! Cholesky factorisation within the envelope: each row is kept from its first non-zero to the diagonal.

/// `A = L Lᵀ` of a symmetric positive definite matrix, `L` kept row after row from the first column that the
/// row's envelope has. Fill never leaves the envelope, so a band stays a band.
#[derive(Debug, Clone, Default)]
pub struct EnvelopeCholesky {
    /// Where row `i` starts in `values`; its columns are `first[i] ..= i`, the diagonal's reciprocal last.
    starts: Vec<usize>,
    first: Vec<u32>,
    values: Vec<f64>,
    smallest_pivot: f64,
}

/// `a · b`, in eight sums where it is long: one alone would wait for each product in turn.
#[inline]
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    if a.len() < 16 {
        return a.iter().zip(b).map(|(a, b)| a * b).sum();
    }
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    let mut sums = [0.0; 8];
    for (a, b) in a.iter().zip(b) {
        for k in 0..8 {
            sums[k] += a[k] * b[k];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    let half: [f64; 4] = std::array::from_fn(|k| sums[k] + sums[k + 4]);
    (half[0] + half[2]) + (half[1] + half[3]) + rest
}

impl EnvelopeCholesky {
    /// Factors the matrix whose row `i` has its first non-zero at column `first[i] ≤ i` and whose entries are
    /// `entry(i, j)` for `first[i] ≤ j ≤ i`. Work: the sum over rows of the square of their envelope.
    ///
    /// # Errors
    /// The row whose pivot is not above `threshold` times its diagonal entry.
    pub fn factor(
        first: Vec<u32>,
        threshold: f64,
        mut entry: impl FnMut(usize, usize) -> f64,
    ) -> Result<Self, usize> {
        let mut done = Self::envelope(first);
        for i in 0..done.size() {
            let from = done.first[i] as usize;
            for j in from..=i {
                let at = done.starts[i] + j - from;
                done.values[at] = entry(i, j);
            }
        }
        done.factor_in_place(threshold)?;
        Ok(done)
    }

    /// An envelope with nothing in it yet: row `i` from column `first[i] ≤ i` on. Its matrix is put into [`entries_mut`](Self::entries_mut)
    /// and factored [in place](Self::factor_in_place), as often as it changes.
    pub fn envelope(first: Vec<u32>) -> Self {
        let mut starts = Vec::with_capacity(first.len() + 1);
        starts.push(0);
        let mut total = 0;
        for (i, &f) in first.iter().enumerate() {
            total += (i + 1).saturating_sub(f as usize);
            starts.push(total);
        }
        Self { starts, first, values: vec![0.0; total], smallest_pivot: 0.0 }
    }

    /// The entries of the lower triangle within the envelope, row after row, before they are factored.
    pub fn entries_mut(&mut self) -> &mut [f64] {
        &mut self.values
    }

    /// Where the entry `(i, j)`, `j ≤ i`, stands among the [entries](Self::entries_mut): in the envelope of row `i`.
    pub fn place(&self, i: usize, j: usize) -> usize {
        self.starts[i] + j - self.first[i] as usize
    }

    /// Factors the matrix that the entries are. Allocates nothing.
    ///
    /// # Errors
    /// The row whose pivot is not above `threshold` times its diagonal entry; there is no factor then.
    pub fn factor_in_place(&mut self, threshold: f64) -> Result<(), usize> {
        let Self { starts, first, values, smallest_pivot } = self;
        *smallest_pivot = f64::INFINITY;
        for i in 0..first.len() {
            let fi = first[i] as usize;
            let (done, rest) = values.split_at_mut(starts[i]);
            let row = &mut rest[..i + 1 - fi];
            let mut diagonal = row[i - fi];
            let whole = diagonal;
            for j in fi..i {
                let fj = first[j] as usize;
                let other = &done[starts[j]..starts[j + 1]];
                let low = fi.max(fj);
                let products = dot(&row[low - fi..j - fi], &other[low - fj..j - fj]);
                let value = (row[j - fi] - products) * other[j - fj];
                row[j - fi] = value;
                diagonal -= value * value;
            }
            if !(diagonal > threshold * whole && diagonal.is_finite()) {
                return Err(i);
            }
            *smallest_pivot = smallest_pivot.min(diagonal / whole);
            row[i - fi] = 1.0 / diagonal.sqrt();
        }
        Ok(())
    }

    /// From the rows of a factor that is known: the first column of each, its entries, the diagonal's reciprocal last.
    pub(super) fn from_rows<R: Iterator<Item = f64>>(rows: impl Iterator<Item = (u32, R)>) -> Self {
        let mut factor = Self { starts: vec![0], smallest_pivot: f64::INFINITY, ..Self::default() };
        for (first, row) in rows {
            let start = factor.values.len();
            factor.first.push(first);
            factor.values.extend(row);
            factor.starts.push(factor.values.len());
            // Of the diagonal of L Lᵀ: that of L is kept as its reciprocal.
            if let Some((reciprocal, before)) = factor.values[start..].split_last() {
                let pivot = 1.0 / (reciprocal * reciprocal);
                let whole = pivot + before.iter().map(|l| l * l).sum::<f64>();
                factor.smallest_pivot = factor.smallest_pivot.min(pivot / whole);
            }
        }
        factor
    }

    /// The size `n`.
    pub fn size(&self) -> usize {
        self.first.len()
    }

    /// The smallest pivot, each relative to its diagonal entry: 1 for a diagonal matrix, small where rows are
    /// nearly dependent.
    pub fn smallest_pivot(&self) -> f64 {
        self.smallest_pivot
    }

    /// Row `i` of `L`: its first column, its entries before the diagonal, and the reciprocal of the diagonal.
    pub(super) fn row(&self, i: usize) -> (usize, &[f64], f64) {
        let row = &self.values[self.starts[i]..self.starts[i + 1]];
        (self.first[i] as usize, &row[..row.len() - 1], row[row.len() - 1])
    }

    /// `x ← L⁻¹ x`, `sides` entries a row.
    pub fn forward(&self, x: &mut [f64], sides: usize) {
        match sides {
            3 => self.forward_fixed::<3>(x),
            1 => self.forward_fixed::<1>(x),
            _ => {
                for i in 0..self.size() {
                    let (first, row, reciprocal) = self.row(i);
                    for side in 0..sides {
                        let sum: f64 =
                            row.iter().enumerate().map(|(k, l)| l * x[(first + k) * sides + side]).sum();
                        x[i * sides + side] = (x[i * sides + side] - sum) * reciprocal;
                    }
                }
            }
        }
    }

    fn forward_fixed<const S: usize>(&self, x: &mut [f64]) {
        let (x, _) = x.as_chunks_mut::<S>();
        for i in 0..self.size() {
            let (first, row, reciprocal) = self.row(i);
            let mut sum = x[i];
            for (l, x) in row.iter().zip(&x[first..i]) {
                for s in 0..S {
                    sum[s] -= l * x[s];
                }
            }
            x[i] = sum.map(|s| s * reciprocal);
        }
    }

    /// `x ← L⁻ᵀ x`, `sides` entries a row.
    pub fn backward(&self, x: &mut [f64], sides: usize) {
        match sides {
            3 => self.backward_fixed::<3>(x),
            1 => self.backward_fixed::<1>(x),
            _ => {
                for i in (0..self.size()).rev() {
                    let (first, row, reciprocal) = self.row(i);
                    for side in 0..sides {
                        let value = x[i * sides + side] * reciprocal;
                        x[i * sides + side] = value;
                        for (k, l) in row.iter().enumerate() {
                            x[(first + k) * sides + side] -= l * value;
                        }
                    }
                }
            }
        }
    }

    fn backward_fixed<const S: usize>(&self, x: &mut [f64]) {
        let (x, _) = x.as_chunks_mut::<S>();
        for i in (0..self.size()).rev() {
            let (first, row, reciprocal) = self.row(i);
            let value = x[i].map(|v| v * reciprocal);
            x[i] = value;
            for (l, x) in row.iter().zip(&mut x[first..i]) {
                for s in 0..S {
                    x[s] -= l * value[s];
                }
            }
        }
    }

    /// `x ← A⁻¹ x`, `sides` entries a row.
    pub fn solve(&self, x: &mut [f64], sides: usize) {
        self.forward(x, sides);
        self.backward(x, sides);
    }

    /// `x ← L x`.
    pub fn multiply_lower(&self, x: &mut [f64], sides: usize) {
        for i in (0..self.size()).rev() {
            let (first, row, reciprocal) = self.row(i);
            for side in 0..sides {
                let sum: f64 = row.iter().enumerate().map(|(k, l)| l * x[(first + k) * sides + side]).sum();
                x[i * sides + side] = x[i * sides + side] / reciprocal + sum;
            }
        }
    }

    /// `x ← Lᵀ x`.
    pub fn multiply_upper(&self, x: &mut [f64], sides: usize) {
        for i in 0..self.size() {
            let (first, row, reciprocal) = self.row(i);
            for side in 0..sides {
                let value = x[i * sides + side];
                x[i * sides + side] = value / reciprocal;
                for (k, l) in row.iter().enumerate() {
                    x[(first + k) * sides + side] += l * value;
                }
            }
        }
    }

    /// Estimate of the condition number of `A` by a few steps of power iteration on `A` and `A⁻¹`; never above
    /// the true one, rarely below a third of it.
    pub fn condition(&self) -> f64 {
        let n = self.size();
        if n < 2 {
            return 1.0;
        }
        // A start with all frequencies in it, the same on every machine.
        let start: Vec<f64> =
            (0..n).map(|i| 1.0 + ((i * 7 + 3) % 11) as f64 / 11.0 - 2.0 * (i % 2) as f64).collect();
        let norm = |x: &[f64]| x.iter().map(|v| v * v).sum::<f64>().sqrt();
        let grow = |inverse: bool| {
            let mut x = start.clone();
            let mut growth = 1.0;
            for _ in 0..12 {
                let before = norm(&x);
                if !(before > 0.0 && before.is_finite()) {
                    return f64::INFINITY;
                }
                x.iter_mut().for_each(|v| *v /= before);
                if inverse {
                    self.solve(&mut x, 1);
                } else {
                    self.multiply_upper(&mut x, 1);
                    self.multiply_lower(&mut x, 1);
                }
                growth = norm(&x);
            }
            growth
        };
        (grow(false) * grow(true)).max(1.0)
    }
}
