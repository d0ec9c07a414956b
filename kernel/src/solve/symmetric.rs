//! Sparse symmetric matrices: metrics and energies.

/// A sparse symmetric matrix, both triangles kept, rows by ascending column.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Symmetric {
    starts: Vec<usize>,
    columns: Vec<u32>,
    values: Vec<f64>,
}

impl Symmetric {
    /// From entries `(i, j, value)` of an `n × n` matrix; give each off-diagonal pair once, it is mirrored.
    /// Entries at the same place are added, those outside the matrix left out. `O(n + m log k)` for `m` entries, `k` of them in a row.
    pub fn from_entries(n: usize, entries: impl IntoIterator<Item = (usize, usize, f64)>) -> Self {
        let given: Vec<(u32, u32, f64)> = entries
            .into_iter()
            .filter(|&(i, j, _)| i < n && j < n)
            .map(|(i, j, value)| (i as u32, j as u32, value))
            .collect();
        // By row, in the order given.
        let mut ends = vec![0; n + 1];
        for &(i, j, _) in &given {
            ends[i as usize + 1] += 1;
            ends[j as usize + 1] += usize::from(i != j);
        }
        for i in 0..n {
            ends[i + 1] += ends[i];
        }
        let mut all = vec![(0_u32, 0.0); ends[n]];
        let mut put = |row: u32, column: u32, value: f64| {
            // What was the row's start becomes its end.
            let at = &mut ends[row as usize];
            all[*at] = (column, value);
            *at += 1;
        };
        for (i, j, value) in given {
            put(i, j, value);
            if i != j {
                put(j, i, value);
            }
        }
        let mut matrix = Self { starts: Vec::with_capacity(n + 1), ..Self::default() };
        matrix.starts.push(0);
        let mut start = 0;
        for &end in &ends[..n] {
            let row = &mut all[start..end];
            // Stable, so that equal places are added in the order given, whatever the machine.
            row.sort_by_key(|&(column, _)| column);
            let mut previous = None;
            for &(column, value) in row.iter() {
                match matrix.values.last_mut() {
                    Some(last) if previous == Some(column) => *last += value,
                    _ => {
                        matrix.columns.push(column);
                        matrix.values.push(value);
                    }
                }
                previous = Some(column);
            }
            matrix.starts.push(matrix.values.len());
            start = end;
        }
        matrix
    }

    /// The size `n`.
    pub fn size(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// The first row with a number that is not finite.
    pub fn first_not_finite(&self) -> Option<usize> {
        (0..self.size()).find(|&i| self.row(i).any(|(_, value)| !value.is_finite()))
    }

    /// `(column, value)` pairs of a row, ascending.
    pub fn row(&self, i: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let range = self.starts[i]..self.starts[i + 1];
        self.columns[range.clone()].iter().map(|&c| c as usize).zip(self.values[range].iter().copied())
    }

    /// The entry at `(i, j)`; zero where none is kept.
    pub fn entry(&self, i: usize, j: usize) -> f64 {
        let range = self.starts[i]..self.starts[i + 1];
        let columns = &self.columns[range.clone()];
        columns.binary_search(&(j as u32)).map_or(0.0, |at| self.values[range.start + at])
    }

    /// Rows and columns `kept` (ascending) of the matrix.
    #[must_use]
    pub fn select(&self, kept: &[usize]) -> Self {
        let mut place = vec![u32::MAX; self.size()];
        for (new, &old) in kept.iter().enumerate() {
            place[old] = new as u32;
        }
        let mut matrix = Self { starts: vec![0], ..Self::default() };
        for &old in kept {
            for (j, value) in self.row(old) {
                if place[j] != u32::MAX {
                    matrix.columns.push(place[j]);
                    matrix.values.push(value);
                }
            }
            matrix.starts.push(matrix.columns.len());
        }
        matrix
    }

    /// The Kronecker product with the 3 × 3 identity: row `3 i + axis` holds row `i`.
    #[must_use]
    pub fn per_axis(&self) -> Self {
        let mut matrix = Self { starts: vec![0], ..Self::default() };
        for i in 0..self.size() {
            for axis in 0..3 {
                for (j, value) in self.row(i) {
                    matrix.columns.push((3 * j + axis) as u32);
                    matrix.values.push(value);
                }
                matrix.starts.push(matrix.columns.len());
            }
        }
        matrix
    }

    /// `out = A x`, each with `sides` entries a row.
    pub fn multiply(&self, x: &[f64], sides: usize, out: &mut [f64]) {
        for (i, out) in out.chunks_exact_mut(sides).enumerate().take(self.size()) {
            out.fill(0.0);
            for (j, value) in self.row(i) {
                for (o, x) in out.iter_mut().zip(&x[j * sides..(j + 1) * sides]) {
                    *o += value * x;
                }
            }
        }
    }

    /// An order of the rows that keeps neighbours together (reverse Cuthill–McKee, each component from a vertex
    /// of least degree): position → row.
    pub fn narrow_order(&self) -> Vec<usize> {
        let n = self.size();
        let degree = |i: usize| self.starts[i + 1] - self.starts[i];
        let mut by_degree: Vec<usize> = (0..n).collect();
        by_degree.sort_by_key(|&i| (degree(i), i));
        let mut seen = vec![false; n];
        let mut order = Vec::with_capacity(n);
        for start in by_degree {
            if seen[start] {
                continue;
            }
            seen[start] = true;
            let mut head = order.len();
            order.push(start);
            while head < order.len() {
                let from = order.len();
                let row = order[head];
                for (j, _) in self.row(row) {
                    if !seen[j] {
                        seen[j] = true;
                        order.push(j);
                    }
                }
                order[from..].sort_by_key(|&i| (degree(i), i));
                head += 1;
            }
        }
        order.reverse();
        order
    }
}
