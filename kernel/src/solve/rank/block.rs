//! One block of rows that hang together: its reflections, what they leave, and what rows that follow repeat.

use super::{Dependency, LARGE};
use crate::parallel;
use crate::solve::envelope::dot;
use crate::solve::order::narrow;
use crate::solve::system::{SparseRows, System};

/// Reflections of more numbers than this are worth several threads.
const SIDE_BY_SIDE: usize = 1 << 17;

#[derive(Debug, Clone)]
pub(super) struct Block {
    /// Original rows in pivot order: the first `rank` are independent.
    pub(super) rows: Vec<usize>,
    /// Reciprocal length of each, in that order.
    pub(super) scale: Vec<f64>,
    pub(super) columns: Vec<u32>,
    pub(super) rank: usize,
    /// Row `k`: before the diagonal `L`, from the diagonal on the reflection vector `v_k` (for `k < rank`).
    pub(super) work: Vec<f64>,
    pub(super) diagonal: Vec<f64>,
    /// `2 / vᵀv` of each reflection.
    pub(super) beta: Vec<f64>,
    /// Where the entries of each row are: of an independent one, where its reflection vector ends.
    spans: Vec<Span>,
}

/// The places of a row between which its entries beyond the diagonal are, and their squared length.
#[derive(Debug, Clone)]
struct Span {
    low: usize,
    high: usize,
    square: f64,
}

/// A row while reflections are applied to it.
struct Line<'w> {
    row: &'w mut [f64],
    span: Span,
}

impl Line<'_> {
    /// Reflection `k`, of `v`, whose `2 / vᵀv` is `factor`.
    fn reflect(&mut self, k: usize, v: &[f64], factor: f64) {
        let Self { row, span } = self;
        let end = k + v.len();
        if span.low >= end {
            return;
        }
        (span.low, span.high) = (k + 1, span.high.max(end));
        let part = &mut row[k..end];
        let along = dot(part, v) * factor;
        for (a, b) in part.iter_mut().zip(v) {
            *a -= along * b;
        }
        let rest = &row[k + 1..span.high];
        span.square = dot(rest, rest);
    }
}

impl Block {
    pub(super) fn new(rows: &SparseRows, mut members: Vec<usize>, columns: Vec<u32>, tolerance: f64) -> Self {
        let (count, m) = (members.len(), columns.len());
        let place = (count * m > LARGE).then(|| side_by_side(rows, &mut members, &columns));
        let mut work = vec![0.0; count * m];
        let mut scale = Vec::with_capacity(count);
        let mut spans: Vec<Span> = Vec::with_capacity(count);
        for (i, &row) in members.iter().enumerate() {
            let norm = rows.norm(row);
            let reciprocal = if norm > 0.0 { 1.0 / norm } else { 1.0 };
            let (mut low, mut high) = (m, 0);
            let mut next = 0;
            for (column, value) in rows.iter_row(row) {
                let column = column as u32;
                // Most often the one after the last.
                let is_next = columns.get(next) == Some(&column);
                let found = if is_next { next } else { columns.binary_search(&column).unwrap_or(0) };
                next = found + 1;
                let at = place.as_ref().map_or(found, |place| place[found]);
                // Divide rather than multiply: the reciprocal of a subnormal overflows.
                work[i * m + at] += if norm > 0.0 { value / norm } else { 0.0 };
                (low, high) = (low.min(at), high.max(at + 1));
            }
            scale.push(reciprocal);
            let square = work[i * m + low.min(high)..i * m + high].iter().map(|v| v * v).sum();
            spans.push(Span { low, high, square });
        }
        let columns = match place {
            None => columns,
            Some(place) => {
                let mut placed = vec![0; m];
                columns.iter().zip(&place).for_each(|(&column, &at)| placed[at] = column);
                placed
            }
        };
        let mut diagonal = Vec::new();
        let mut beta = Vec::new();
        let mut rank = 0;
        // Of rows that are put elsewhere nothing is moved before the end.
        let mut order: Vec<usize> = (0..count).collect();
        let mut lines: Vec<Line<'_>> =
            work.chunks_exact_mut(m.max(1)).zip(spans).map(|(row, span)| Line { row, span }).collect();
        while rank < count.min(m) {
            let k = rank;
            let largest = lines[k..].iter().fold(0.0_f64, |most, line| most.max(line.span.square));
            if largest.sqrt() <= tolerance || largest.is_nan() {
                break;
            }
            // The first row that is nearly as long as the longest: rows keep their order where they can, so that of two equal
            // constraints the later one is called redundant. Rows that are much shorter would make the others combinations
            // with large factors, and an answer would meet these only as well as these factors let it.
            let pick = k + lines[k..].iter().position(|line| line.span.square >= 0.64 * largest).unwrap_or(0);
            lines[k..=pick].rotate_right(1);
            order[k..=pick].rotate_right(1);
            let (head, tail) = lines.split_at_mut(k + 1);
            let Line { row: pivot, span } = &mut head[k];
            let end = span.high.max(k + 1);
            span.high = end;
            let v = &mut pivot[k..end];
            let length = dot(v, v).sqrt();
            // σ has the sign of v₀, so that v₀ + σ does not cancel (paper 4, §3).
            let sigma = if v[0] < 0.0 { -length } else { length };
            v[0] += sigma;
            let factor = 1.0 / (sigma * v[0]);
            let v = &*v;
            if tail.len() * v.len() > SIDE_BY_SIDE {
                parallel::map_mut(tail, || (), |(), _, line| line.reflect(k, v, factor));
            } else {
                tail.iter_mut().for_each(|line| line.reflect(k, v, factor));
            }
            diagonal.push(-sigma);
            beta.push(factor);
            rank += 1;
        }
        let spans = lines.into_iter().map(|line| line.span).collect();
        let members = order.iter().map(|&row| members[row]).collect();
        let scale = order.iter().map(|&row| scale[row]).collect();
        put_in_order(&mut work, m, order);
        Self { rows: members, scale, columns, rank, work, diagonal, beta, spans }
    }

    pub(super) fn m(&self) -> usize {
        self.columns.len()
    }

    /// `y = L⁻¹ S b`, into the first `rank` entries of `y`.
    pub(super) fn lower(&self, b: &[f64], sides: usize, side: usize, y: &mut [f64]) {
        for k in 0..self.rank {
            let row = &self.work[k * self.m()..k * self.m() + k];
            let sum: f64 = row.iter().zip(&*y).map(|(l, y)| l * y).sum();
            y[k] = (b[self.rows[k] * sides + side] * self.scale[k] - sum) / self.diagonal[k];
        }
    }

    /// `y ← L⁻ᵀ y` on the leading `k` entries.
    pub(super) fn upper(&self, k: usize, y: &mut [f64]) {
        for i in (0..k).rev() {
            y[i] /= self.diagonal[i];
            let value = y[i];
            for (j, l) in self.work[i * self.m()..i * self.m() + i].iter().enumerate() {
                y[j] -= l * value;
            }
        }
    }

    /// Undoes the reflections, the last first.
    pub(super) fn reflect_back(&self, x: &mut [f64]) {
        for k in (0..self.rank).rev() {
            let end = self.spans[k].high;
            let v = &self.work[k * self.m() + k..k * self.m() + end];
            let x = &mut x[k..end];
            let dot: f64 = x.iter().zip(v).map(|(a, b)| a * b).sum::<f64>() * self.beta[k];
            for (a, b) in x.iter_mut().zip(v) {
                *a -= dot * b;
            }
        }
    }

    /// How pivot row `i` (beyond the rank) is made of the independent ones: `Lᵀ c = l_i`, in unscaled rows. A row that could
    /// be left out without moving the combination by more than rounding is none of them, however large its factor; any other
    /// is, however small.
    pub(super) fn dependency(&self, i: usize) -> Dependency {
        let mut c = self.work[i * self.m()..i * self.m() + self.rank].to_vec();
        self.upper(self.rank, &mut c);
        let largest = c.iter().fold(1.0_f64, |a, b| a.max(b.abs()));
        let mut combination: Vec<(usize, f64)> = c
            .iter()
            .enumerate()
            .filter(|(j, c)| (*c * self.diagonal[*j]).abs() > System::FINE * largest)
            .map(|(j, c)| (self.rows[j], c * self.scale[j] / self.scale[i]))
            .collect();
        combination.sort_by_key(|&(row, _)| row);
        Dependency { row: self.rows[i], combination }
    }

    /// Estimates of the largest and the smallest singular value of `L`, by power iteration.
    pub(super) fn singular_values(&self) -> (f64, f64) {
        let n = self.rank;
        if n == 0 {
            return (0.0, f64::INFINITY);
        }
        if n == 1 {
            return (self.diagonal[0].abs(), self.diagonal[0].abs());
        }
        let norm = |x: &[f64]| x.iter().map(|v| v * v).sum::<f64>().sqrt();
        let start: Vec<f64> =
            (0..n).map(|i| 1.0 + ((i * 7 + 3) % 11) as f64 / 11.0 - 2.0 * (i % 2) as f64).collect();
        let l = |i: usize, j: usize| if i == j { self.diagonal[i] } else { self.work[i * self.m() + j] };
        let grow = |inverse: bool| {
            let mut x = start.clone();
            let mut growth = 0.0;
            for _ in 0..12 {
                let before = norm(&x);
                x.iter_mut().for_each(|v| *v /= before);
                if inverse {
                    for i in 0..n {
                        let sum: f64 = (0..i).map(|j| l(i, j) * x[j]).sum();
                        x[i] = (x[i] - sum) / self.diagonal[i];
                    }
                    self.upper(n, &mut x);
                } else {
                    for j in 0..n {
                        x[j] = (j..n).map(|i| l(i, j) * x[i]).sum();
                    }
                    for i in (0..n).rev() {
                        x[i] = (0..=i).map(|j| l(i, j) * x[j]).sum();
                    }
                }
                growth = norm(&x);
            }
            growth
        };
        (grow(false).sqrt(), 1.0 / grow(true).sqrt())
    }
}

/// Puts rows that share columns side by side, so that each reflection meets a few rows only, and what they come to; returns the place of
/// each of the `columns`, which ascend. Columns are as they are where that keeps the entries of each row closest together, or else (of an
/// edge of a surface whose neighbours are far apart by number) by the first row that touches them in an order that keeps the rows narrow.
/// Rows with the same first place stay in their order.
pub(super) fn side_by_side(rows: &SparseRows, members: &mut [usize], columns: &[u32]) -> Vec<usize> {
    let found = |column: usize| columns.binary_search(&(column as u32)).unwrap_or(0);
    let mut place: Vec<usize> = (0..columns.len()).collect();
    let (mut turned, mut next) = (vec![usize::MAX; columns.len()], 0);
    for row in narrow(rows, members.iter().map(|&row| row as u32).collect()).0 {
        for (column, _) in rows.iter_row(row as usize) {
            let at = &mut turned[found(column)];
            if *at == usize::MAX {
                *at = next;
                next += 1;
            }
        }
    }
    let ends = |row: usize, place: &[usize]| {
        let places = rows.iter_row(row).map(|(column, _)| place[found(column)]);
        places.fold((usize::MAX, 0), |(low, high), at| (low.min(at), high.max(at)))
    };
    let width = |place: &[usize]| {
        members.iter().map(|&row| ends(row, place)).map(|(low, high)| high.saturating_sub(low)).sum::<usize>()
    };
    if width(&turned) < width(&place) {
        place = turned;
    }
    members.sort_by_cached_key(|&row| ends(row, &place).0);
    place
}

/// Puts row `order[k]` into place `k`, for all `k`.
fn put_in_order(work: &mut [f64], m: usize, mut order: Vec<usize>) {
    let mut kept = vec![0.0; m];
    for start in 0..order.len() {
        if order[start] == start {
            continue;
        }
        kept.copy_from_slice(&work[start * m..(start + 1) * m]);
        let mut at = start;
        loop {
            let from = std::mem::replace(&mut order[at], at);
            if from == start {
                work[at * m..(at + 1) * m].copy_from_slice(&kept);
                break;
            }
            work.copy_within(from * m..(from + 1) * m, at * m);
            at = from;
        }
    }
}
