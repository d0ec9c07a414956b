//! A linear system as solvers see it: sparse rows over the columns that matter, and a metric.

use std::sync::Arc;

use super::metric::SystemMetric;

/// Sparse rows. Columns ascend within a row and do not repeat.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SparseRows {
    starts: Vec<usize>,
    columns: Vec<u32>,
    values: Vec<f64>,
    width: usize,
}

impl SparseRows {
    /// No rows yet, over `width` columns.
    pub fn new(width: usize) -> Self {
        Self { starts: vec![0], columns: Vec::new(), values: Vec::new(), width }
    }

    /// Room for `rows` rows of `entries` entries in all.
    pub fn with_capacity(width: usize, rows: usize, entries: usize) -> Self {
        let mut starts = Vec::with_capacity(rows + 1);
        starts.push(0);
        Self { starts, columns: Vec::with_capacity(entries), values: Vec::with_capacity(entries), width }
    }

    /// Appends a row. Terms at the same column are added; zero coefficients stay. Columns beyond the width are
    /// left out.
    pub fn push(&mut self, terms: impl IntoIterator<Item = (usize, f64)>) {
        let start = self.columns.len();
        let mut ascending = true;
        for (column, value) in terms {
            if column >= self.width {
                continue;
            }
            let column = column as u32;
            ascending &= self.columns.len() == start || self.columns.last().is_some_and(|&c| c < column);
            self.columns.push(column);
            self.values.push(value);
        }
        if !ascending {
            let mut row: Vec<(u32, f64)> =
                self.columns.drain(start..).zip(self.values.drain(start..)).collect();
            row.sort_by_key(|&(column, _)| column);
            for (column, value) in row {
                if self.columns.len() > start && self.columns.last() == Some(&column) {
                    if let Some(last) = self.values.last_mut() {
                        *last += value;
                    }
                } else {
                    self.columns.push(column);
                    self.values.push(value);
                }
            }
        }
        self.starts.push(self.columns.len());
    }

    /// The Kronecker product with the 3 × 3 identity: row `3 i + axis` holds row `i`.
    #[must_use]
    pub fn per_axis(&self) -> Self {
        let mut all = Self::with_capacity(3 * self.width, 3 * self.len(), 3 * self.entries());
        for row in 0..self.len() {
            for axis in 0..3 {
                all.push(self.iter_row(row).map(|(column, value)| (3 * column + axis, value)));
            }
        }
        all
    }

    /// The number of rows.
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The number of columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// The entries in all rows.
    pub fn entries(&self) -> usize {
        self.columns.len()
    }

    /// Columns and values of a row.
    pub fn row(&self, row: usize) -> (&[u32], &[f64]) {
        let range = self.starts[row]..self.starts[row + 1];
        (&self.columns[range.clone()], &self.values[range])
    }

    /// Columns and values of each row.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (&[u32], &[f64])> {
        self.starts.windows(2).map(|ends| (&self.columns[ends[0]..ends[1]], &self.values[ends[0]..ends[1]]))
    }

    /// `(column, value)` pairs of a row.
    pub fn iter_row(&self, row: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let (columns, values) = self.row(row);
        columns.iter().map(|&c| c as usize).zip(values.iter().copied())
    }

    /// The Euclidean norm of a row, safe from overflow.
    #[inline]
    pub fn norm(&self, row: usize) -> f64 {
        norm(self.row(row).1)
    }

    /// The inner product of two rows.
    #[inline]
    pub fn dot(&self, i: usize, j: usize) -> f64 {
        let ((ci, vi), (cj, vj)) = (self.row(i), self.row(j));
        let (Some(&fi), Some(&fj)) = (ci.first(), cj.first()) else { return 0.0 };
        let contiguous = |c: &[u32], first: u32| (c[c.len() - 1] - first) as usize + 1 == c.len();
        if contiguous(ci, fi) && contiguous(cj, fj) {
            // Stencils of curves: two runs of columns that overlap by a shift.
            let low = fi.max(fj);
            let (a, b) = (vi.get((low - fi) as usize..), vj.get((low - fj) as usize..));
            return match (a, b) {
                (Some(a), Some(b)) => a.iter().zip(b).map(|(x, y)| x * y).sum(),
                _ => 0.0,
            };
        }
        let (mut a, mut b, mut sum) = (0, 0, 0.0);
        while a < ci.len() && b < cj.len() {
            match ci[a].cmp(&cj[b]) {
                std::cmp::Ordering::Less => a += 1,
                std::cmp::Ordering::Greater => b += 1,
                std::cmp::Ordering::Equal => {
                    sum += vi[a] * vj[b];
                    a += 1;
                    b += 1;
                }
            }
        }
        sum
    }

    /// `out = F x`, each with `sides` entries a row.
    pub fn multiply(&self, x: &[f64], sides: usize, out: &mut [f64]) {
        for (row, out) in out.chunks_exact_mut(sides).enumerate().take(self.len()) {
            out.fill(0.0);
            for (column, value) in self.iter_row(row) {
                for (o, x) in out.iter_mut().zip(&x[column * sides..(column + 1) * sides]) {
                    *o += value * x;
                }
            }
        }
    }
}

/// The Euclidean norm, safe from overflow.
#[inline]
pub(super) fn norm(values: &[f64]) -> f64 {
    let squares: f64 = values.iter().map(|v| v * v).sum();
    // Nothing overflowed, and nothing that underflowed can matter.
    if squares > 1e-280 && squares < f64::INFINITY { squares.sqrt() } else { scaled_norm(values) }
}

/// The norm by way of the largest entry: for squares that overflow or underflow.
#[cold]
fn scaled_norm(values: &[f64]) -> f64 {
    let largest = values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    if largest == 0.0 || !largest.is_finite() {
        return largest;
    }
    largest * values.iter().map(|v| (v / largest) * (v / largest)).sum::<f64>().sqrt()
}

/// `F d = b` with `dᵀWd` least: sparse rows over the columns that the constraints touch, and a metric.
///
/// `sides` is the number of right-hand sides that share the rows: 3 where all constraints treat x, y and z alike
/// (a column is a control vertex), 1 where some couple the axes (a column is one coordinate of a vertex,
/// `3 · vertex + axis`). The rows are shared, so that what is factored can keep them without a copy.
#[derive(Debug, Clone)]
pub struct System {
    rows: Arc<SparseRows>,
    touched: Arc<Vec<usize>>,
    sides: usize,
    metric: SystemMetric,
    tolerance: f64,
    /// So many of the last columns have no weight.
    free: usize,
    /// Whether answers are corrected by residuals in other rows than these: those that these were made of.
    corrected_elsewhere: bool,
}

impl System {
    /// The [`tolerance`](Self::tolerance) of a new system.
    pub const COARSE: f64 = 1e-10;
    /// The [`tolerance`](Self::tolerance) below which rounding alone makes rows look independent.
    pub const FINE: f64 = 32.0 * f64::EPSILON;

    /// A system. `touched` are the global columns behind the rows' own, ascending, as many as the rows are wide.
    pub fn new(rows: SparseRows, touched: Vec<usize>, sides: usize, metric: SystemMetric) -> Self {
        debug_assert_eq!(rows.width(), touched.len());
        let (rows, touched) = (Arc::new(rows), Arc::new(touched));
        let tolerance = Self::COARSE;
        Self { rows, touched, sides: sides.max(1), metric, tolerance, free: 0, corrected_elsewhere: false }
    }

    /// The same with the last `free` columns without weight: what they are costs nothing (parameters that float). The metric is
    /// one of the others.
    #[must_use]
    pub fn with_free(self, free: usize) -> Self {
        Self { free: free.min(self.touched.len()), ..self }
    }

    /// How many of the last columns have no weight.
    pub fn free(&self) -> usize {
        self.free
    }

    /// How many columns have one: those before.
    pub(super) fn weighed(&self) -> usize {
        self.touched.len() - self.free
    }

    /// The columns with a weight, under other rows.
    pub(super) fn without_free(&self, rows: SparseRows) -> Self {
        let touched = Arc::new(self.touched[..self.weighed()].to_vec());
        Self { rows: Arc::new(rows), touched, free: 0, ..self.clone() }
    }

    /// A row counts as implied by others where its part outside their span is not longer than this, of its own length.
    ///
    /// Where rows are nearly dependent, two answers compete. With the row left out, rounding of the right-hand side stays what
    /// it is, but the row is met only as far as the others imply it; with the row in, it is met whatever is asked, and rounding
    /// is magnified by one over this. So systems start [`COARSE`](Self::COARSE), and only where a right-hand side denies what
    /// is implied, beyond rounding, are they factored anew, [`finely`](Self::finely).
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// The same system at the tolerance [`FINE`](Self::FINE).
    #[must_use]
    pub fn finely(&self) -> Self {
        Self { tolerance: Self::FINE, ..self.clone() }
    }

    /// The rows of `F`, over [`touched`](Self::touched) columns.
    pub fn rows(&self) -> &Arc<SparseRows> {
        &self.rows
    }

    /// The global columns that matter: those that a row touches, and those that the metric moves along.
    pub fn touched(&self) -> &[usize] {
        &self.touched
    }

    /// Right-hand sides that share the rows: 3 or 1.
    pub fn sides(&self) -> usize {
        self.sides
    }

    /// The metric over the touched columns (over those with a weight, where some have [none](Self::free)).
    pub fn metric(&self) -> &SystemMetric {
        &self.metric
    }

    /// The same columns with rows that were made of these, in whose coordinates the metric is the identity; answers are corrected
    /// in these rows.
    pub(super) fn in_metric(&self, rows: Arc<SparseRows>) -> Self {
        Self { rows, metric: SystemMetric::Least, corrected_elsewhere: true, ..self.clone() }
    }

    /// Whether answers are corrected by residuals in other rows.
    pub(super) fn is_corrected_elsewhere(&self) -> bool {
        self.corrected_elsewhere
    }

    /// The same system with only some of its rows, in the given order.
    #[must_use]
    pub fn select(&self, kept: &[usize]) -> Self {
        let mut rows = SparseRows::with_capacity(self.rows.width(), kept.len(), self.rows.entries());
        for &row in kept {
            rows.push(self.rows.iter_row(row));
        }
        Self {
            rows: Arc::new(rows),
            touched: Arc::clone(&self.touched),
            sides: self.sides,
            metric: self.metric.clone(),
            tolerance: self.tolerance,
            free: self.free,
            corrected_elsewhere: self.corrected_elsewhere,
        }
    }
}
