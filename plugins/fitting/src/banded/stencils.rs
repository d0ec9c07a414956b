//! Matrices whose rows are stencils: a few neighbouring columns each, wrapping around where closed.

use loftsman_kernel::Result;
use loftsman_kernel::spline::Space;
use loftsman_kernel::spline::space::MAX_ORDER;

/// A matrix of rows with `width` neighbouring entries: row `r` has its entries at columns
/// `start(r), start(r) + 1, …`, modulo the number of columns.
#[derive(Debug, Clone)]
pub(crate) struct Stencils {
    columns: usize,
    width: usize,
    cyclic: bool,
    starts: Vec<usize>,
    values: Vec<f64>,
}

impl Stencils {
    /// No rows yet; one column a control vertex, `p + 1` entries a row.
    pub(crate) fn new(space: &Space, capacity: usize) -> Self {
        let width = space.degree() + 1;
        Self {
            columns: space.len(),
            width,
            cyclic: space.is_periodic(),
            starts: Vec::with_capacity(capacity),
            values: Vec::with_capacity(capacity * width),
        }
    }

    /// The collocation matrix: row `k` holds the basis functions at `sites[k]`. `O(p²)` a row, plus a search of
    /// the span only where a site is not in the span of the one before or the next one.
    ///
    /// # Errors
    /// When a site is outside the domain.
    pub(crate) fn collocation(space: &Space, sites: &[f64]) -> Result<Self> {
        let mut rows = Self::new(space, sites.len());
        rows.collocate(space, sites, 0)?;
        Ok(rows)
    }

    /// Appends a row a site with the `order`-th derivatives of the basis functions.
    ///
    /// # Errors
    /// As for [`collocation`](Self::collocation).
    pub(crate) fn collocate(&mut self, space: &Space, sites: &[f64], order: usize) -> Result<()> {
        let (p, flat) = (space.degree(), space.flat());
        let mut row = [0.0; MAX_ORDER];
        let mut span = p;
        for &site in sites {
            let u = space.locate(site)?;
            // Sites mostly ascend: look here and one further before searching.
            if !(flat[span] <= u && u < flat[span + 1]) {
                let next = span + 1;
                let ahead = next < space.unrolled_len() && flat[next] <= u && u < flat[next + 1];
                span = if ahead { next } else { space.span(u) };
            }
            space.basis_into(span, u, order, &mut row);
            self.push(space.vertex(span - p), &row[..=p]);
        }
        Ok(())
    }

    /// Appends a row. Entries beyond the width must not be given.
    pub(crate) fn push(&mut self, start: usize, values: &[f64]) {
        debug_assert!(values.len() <= self.width && start < self.columns);
        self.starts.push(start);
        self.values.extend_from_slice(values);
        self.values.resize(self.starts.len() * self.width, 0.0);
    }

    /// The number of rows.
    pub(crate) fn len(&self) -> usize {
        self.starts.len()
    }

    /// The number of columns.
    pub(crate) fn columns(&self) -> usize {
        self.columns
    }

    /// Entries a row.
    pub(crate) fn width(&self) -> usize {
        self.width
    }

    /// Whether rows wrap around.
    pub(crate) fn is_cyclic(&self) -> bool {
        self.cyclic
    }

    /// The first column and the entries of a row.
    pub(crate) fn row(&self, row: usize) -> (usize, &[f64]) {
        (self.starts[row], &self.values[row * self.width..(row + 1) * self.width])
    }

    /// Scales a row to length 1 and returns the factor (1 where the row is zero).
    pub(crate) fn normalize(&mut self, row: usize) -> f64 {
        let values = &mut self.values[row * self.width..(row + 1) * self.width];
        let largest = values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        if !(largest > 0.0 && largest.is_finite()) {
            return 1.0;
        }
        let factor = 1.0 / (largest * values.iter().map(|v| (v / largest).powi(2)).sum::<f64>().sqrt());
        for value in values {
            *value *= factor;
        }
        factor
    }

    /// Row `r` times `x`, which has three entries a column.
    pub(crate) fn point(&self, row: usize, x: &[f64]) -> [f64; 3] {
        let (start, values) = self.row(row);
        let x = x.as_chunks::<3>().0;
        let mut sum = [0.0; 3];
        let mut add = |values: &[f64], x: &[[f64; 3]]| {
            for (value, x) in values.iter().zip(x) {
                for axis in 0..3 {
                    sum[axis] += value * x[axis];
                }
            }
        };
        // Trailing zeros of an open row may lie beyond the last column: they meet nothing.
        add(values, &x[start..]);
        let mut done = self.columns - start;
        while self.cyclic && done < self.width {
            add(&values[done..], x);
            done += self.columns;
        }
        sum
    }

    /// The order in which a row-by-row factorization fills in least: rows that wrap around first (their band
    /// part starts at column 0), then by first column. `None` where that is the order already.
    pub(crate) fn order(&self) -> Option<Vec<usize>> {
        let wraps = |start: usize| self.cyclic && start + self.width > self.columns;
        let key = |&r: &usize| if wraps(self.starts[r]) { 0 } else { self.starts[r] + 1 };
        let sorted = (1..self.len()).all(|r| key(&(r - 1)) <= key(&r));
        if sorted {
            return None;
        }
        let mut order: Vec<usize> = (0..self.len()).collect();
        order.sort_by_key(key);
        Some(order)
    }
}
