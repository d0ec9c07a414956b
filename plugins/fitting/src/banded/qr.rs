//! QR of stencil rows by Givens rotations.

use super::stencils::Stencils;

/// The triangular factor `R` of `A = QR`, with `Qᵀb` beside it.
///
/// Rows of `A` are rotated into `R` one after the other (George and Heath 1980). Taken by first column, a row of
/// `p + 1` entries meets at most `p + 1` rows of `R` and never widens the band: `O(p²)` a row, memory `O(n p)`.
/// In a closed curve the last `p` columns are a *border*: kept dense for every row, because rows wrap around to
/// them. Rotations are orthogonal, so the factorization is backward stable for every matrix, totally positive or
/// not (end conditions and closed curves are not), without pivoting; and it works on `A`, not on `AᵀA`, whose
/// condition is the square.
#[derive(Debug, Clone)]
pub(crate) struct Qr {
    columns: usize,
    width: usize,
    /// Columns in the border.
    border: usize,
    sides: usize,
    /// One row a band column: `width` band entries, `border` entries, `sides` right-hand sides.
    band: Vec<f64>,
    /// One row a border column: `border` entries, `sides` right-hand sides.
    corner: Vec<f64>,
}

impl Qr {
    /// Factors `diag(weights) A` and carries `diag(weights) b` along: `rhs` has `sides` entries a row.
    pub(crate) fn factor(matrix: &Stencils, weights: Option<&[f64]>, rhs: &[f64], sides: usize) -> Self {
        let (columns, width) = (matrix.columns(), matrix.width());
        // A closed curve with few vertices has no band to speak of.
        let border = match (matrix.is_cyclic(), columns < 2 * width) {
            (false, _) => 0,
            (true, true) => columns,
            (true, false) => width - 1,
        };
        let banded = columns - border;
        let stride = width + border + sides;
        let mut qr = Self {
            columns,
            width,
            border,
            sides,
            band: vec![0.0; banded * stride],
            corner: vec![0.0; border * (border + sides)],
        };
        let mut incoming = vec![0.0; stride];
        let order = matrix.order();
        for k in 0..matrix.len() {
            let r = order.as_ref().map_or(k, |o| o[k]);
            let first = qr.load(matrix, r, &mut incoming);
            incoming[width + border..].copy_from_slice(&rhs[r * sides..(r + 1) * sides]);
            if let Some(weights) = weights {
                for value in &mut incoming {
                    *value *= weights[r];
                }
            }
            qr.insert(first, &mut incoming);
        }
        qr
    }

    /// Spreads row `r` over band and border; returns the column of the first band entry.
    fn load(&self, matrix: &Stencils, r: usize, incoming: &mut [f64]) -> usize {
        let (start, values) = matrix.row(r);
        if self.border == 0 {
            incoming[..self.width].copy_from_slice(values);
            return start;
        }
        incoming.fill(0.0);
        let banded = self.columns - self.border;
        let first = if start + self.width > self.columns { 0 } else { start };
        for (j, &value) in values.iter().enumerate() {
            let column = (start + j) % self.columns;
            if column >= banded {
                incoming[self.width + column - banded] += value;
            } else {
                incoming[column - first] += value;
            }
        }
        first
    }

    /// Rotates a row into `R`.
    fn insert(&mut self, first: usize, incoming: &mut [f64]) {
        let (width, stride) = (self.width, self.width + self.border + self.sides);
        let (lead, tail) = incoming.split_at_mut(width);
        for (j, row) in self.band.chunks_exact_mut(stride).skip(first).take(width).enumerate() {
            if lead[j] == 0.0 {
                continue;
            }
            let (row_lead, row_tail) = row.split_at_mut(width);
            if row_lead[0] == 0.0 {
                row_lead[..width - j].copy_from_slice(&lead[j..]);
                row_tail.copy_from_slice(tail);
                return;
            }
            let (c, s, length) = rotation(row_lead[0], lead[j]);
            row_lead[0] = length;
            rotate(c, s, &mut row_lead[1..width - j], &mut lead[j + 1..]);
            rotate(c, s, row_tail, tail);
        }
        let stride = self.border + self.sides;
        for (k, row) in self.corner.chunks_exact_mut(stride.max(1)).enumerate() {
            if tail[k] == 0.0 {
                continue;
            }
            if row[k] == 0.0 {
                row[k..].copy_from_slice(&tail[k..]);
                return;
            }
            let (c, s, length) = rotation(row[k], tail[k]);
            row[k] = length;
            rotate(c, s, &mut row[k + 1..], &mut tail[k + 1..]);
        }
    }

    /// The diagonal entry of a column: zero where the column depends on those before it.
    pub(crate) fn pivot(&self, column: usize) -> f64 {
        let banded = self.columns - self.border;
        if column < banded {
            self.band[column * self.band_stride()]
        } else {
            let k = column - banded;
            self.corner[k * (self.border + self.sides) + k]
        }
    }

    /// The column with the weakest pivot.
    pub(crate) fn weakest(&self) -> usize {
        (0..self.columns).fold(0, |w, c| if self.pivot(c).abs() < self.pivot(w).abs() { c } else { w })
    }

    /// `x` with `R x = Qᵀb`, `sides` entries a column. Pivots must not be zero. `O(n p)`.
    pub(crate) fn solve(&self) -> Vec<f64> {
        let (sides, banded) = (self.sides, self.columns - self.border);
        let mut x = vec![0.0; self.columns * sides];
        for k in (0..self.border).rev() {
            let row = &self.corner[k * (self.border + sides)..][..self.border + sides];
            let (done, here) = split(&mut x, (banded + k + 1) * sides);
            let out = &mut done[(banded + k) * sides..];
            out.copy_from_slice(&row[self.border..]);
            eliminate(&row[k + 1..self.border], here, out);
            scale(out, 1.0 / row[k]);
        }
        for (c, row) in self.band.chunks_exact(self.band_stride()).enumerate().rev() {
            let (lead, tail) = row.split_at(self.width);
            let (done, here) = split(&mut x, (c + 1) * sides);
            let out = &mut done[c * sides..];
            out.copy_from_slice(&tail[self.border..]);
            eliminate(&lead[1..self.width.min(banded - c)], here, out);
            eliminate(&tail[..self.border], &here[(banded - c - 1) * sides..], out);
            scale(out, 1.0 / lead[0]);
        }
        x
    }

    /// Replaces `b` by `R⁻¹ b`: one side. `O(n p)`.
    pub(crate) fn solve_upper(&self, b: &mut [f64]) {
        let banded = self.columns - self.border;
        for k in (0..self.border).rev() {
            let row = &self.corner[k * (self.border + self.sides)..];
            let sum: f64 = (k + 1..self.border).map(|j| row[j] * b[banded + j]).sum();
            b[banded + k] = (b[banded + k] - sum) / row[k];
        }
        for (c, row) in self.band.chunks_exact(self.band_stride()).enumerate().rev() {
            let near = self.width.min(banded - c);
            let mut sum = b[c];
            for (r, x) in row[1..near].iter().zip(&b[c + 1..]) {
                sum -= r * x;
            }
            for (r, x) in row[self.width..self.width + self.border].iter().zip(&b[banded..]) {
                sum -= r * x;
            }
            b[c] = sum / row[0];
        }
    }

    /// Replaces `b` by `R⁻ᵀ b`: one side. `O(n p)`.
    pub(crate) fn solve_transposed(&self, b: &mut [f64]) {
        let banded = self.columns - self.border;
        for (c, row) in self.band.chunks_exact(self.band_stride()).enumerate() {
            let value = b[c] / row[0];
            b[c] = value;
            if value == 0.0 {
                continue;
            }
            let near = self.width.min(banded - c);
            for (r, x) in row[1..near].iter().zip(&mut b[c + 1..]) {
                *x -= r * value;
            }
            for (r, x) in row[self.width..self.width + self.border].iter().zip(&mut b[banded..]) {
                *x -= r * value;
            }
        }
        for k in 0..self.border {
            let row = &self.corner[k * (self.border + self.sides)..];
            let value = b[banded + k] / row[k];
            b[banded + k] = value;
            for j in k + 1..self.border {
                b[banded + j] -= row[j] * value;
            }
        }
    }

    /// Estimate of the condition number `‖R‖₁ ‖R⁻¹‖₁`, rarely below a third of it: Hager's method (1984) as in
    /// Higham, *Accuracy and Stability*, algorithm 15.1. A few solves; infinite where a pivot is zero.
    pub(crate) fn condition(&self) -> f64 {
        if (0..self.columns).any(|c| self.pivot(c) == 0.0) {
            return f64::INFINITY;
        }
        let n = self.columns;
        let mut x = vec![1.0 / n as f64; n];
        let mut estimate = 0.0_f64;
        let mut last = usize::MAX;
        for _ in 0..4 {
            self.solve_upper(&mut x);
            let norm: f64 = x.iter().map(|v| v.abs()).sum();
            if !norm.is_finite() {
                return f64::INFINITY;
            }
            if norm <= estimate {
                break;
            }
            estimate = norm;
            for v in &mut x {
                *v = if *v < 0.0 { -1.0 } else { 1.0 };
            }
            self.solve_transposed(&mut x);
            let largest = x.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            let steepest = x.iter().position(|v| v.abs() == largest).unwrap_or(0);
            if steepest == last {
                break;
            }
            last = steepest;
            x.fill(0.0);
            x[steepest] = 1.0;
        }
        estimate * self.norm()
    }

    /// `‖R‖₁`, the largest column sum.
    fn norm(&self) -> f64 {
        let banded = self.columns - self.border;
        let mut sums = vec![0.0; self.columns + self.width];
        for (c, row) in self.band.chunks_exact(self.band_stride()).enumerate() {
            for (sum, r) in sums[c..].iter_mut().zip(&row[..self.width.min(banded - c)]) {
                *sum += r.abs();
            }
            for (sum, r) in sums[banded..].iter_mut().zip(&row[self.width..self.width + self.border]) {
                *sum += r.abs();
            }
        }
        for row in self.corner.chunks_exact((self.border + self.sides).max(1)) {
            for (sum, r) in sums[banded..].iter_mut().zip(&row[..self.border]) {
                *sum += r.abs();
            }
        }
        sums.into_iter().fold(0.0, f64::max)
    }

    fn band_stride(&self) -> usize {
        // Never zero, so that it can cut slices.
        self.width + self.border + self.sides
    }
}

/// The rotation that turns `(a, b)` into `(length, 0)`.
fn rotation(a: f64, b: f64) -> (f64, f64, f64) {
    let square = a * a + b * b;
    // Entries are of order one; only basis functions of high degree near the end of their support get here with
    // squares that underflow.
    let length = if square > 1e-290 { square.sqrt() } else { a.hypot(b) };
    let inverse = 1.0 / length;
    if inverse.is_finite() { (a * inverse, b * inverse, length) } else { (1.0, 0.0, a) }
}

fn rotate(c: f64, s: f64, upper: &mut [f64], lower: &mut [f64]) {
    for (u, l) in upper.iter_mut().zip(lower) {
        let (a, b) = (*u, *l);
        *u = c * a + s * b;
        *l = c * b - s * a;
    }
}

fn split(x: &mut [f64], at: usize) -> (&mut [f64], &[f64]) {
    let (done, here) = x.split_at_mut(at);
    (done, here)
}

/// `out -= Σ row[j] x[j]`, `out.len()` sides.
fn eliminate(row: &[f64], x: &[f64], out: &mut [f64]) {
    if let Ok(out) = <&mut [f64; 3]>::try_from(&mut *out) {
        // Points: a length that the compiler knows.
        for (r, x) in row.iter().zip(x.as_chunks::<3>().0) {
            for axis in 0..3 {
                out[axis] -= r * x[axis];
            }
        }
        return;
    }
    let sides = out.len();
    for (r, x) in row.iter().zip(x.chunks_exact(sides)) {
        for (o, x) in out.iter_mut().zip(x) {
            *o -= r * x;
        }
    }
}

fn scale(out: &mut [f64], factor: f64) {
    for o in out {
        *o *= factor;
    }
}
