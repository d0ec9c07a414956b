//! The factored metric of one block of vertices, and its half-solves, which end where a banded inverse has died away.

use std::ops::Range;

use super::super::envelope::EnvelopeCholesky;

/// Entries of a half-solved row below this share of its largest are nothing beside rounding.
const NEGLIGIBLE: f64 = 1e-18;

/// The factored metric of some control vertices that come one after another.
#[derive(Debug, Clone)]
pub enum Weight {
    /// The same for x, y and z: a matrix with a row for each vertex.
    Vertices(EnvelopeCholesky),
    /// The same, of a grid: the Kronecker product of a matrix along its rows' numbers and one along its columns'.
    Grid(EnvelopeCholesky, EnvelopeCholesky),
    /// A matrix with a row for each coordinate, `3 · vertex + axis`.
    Coordinates(EnvelopeCholesky),
    /// So many vertices that stay where they are.
    Still(usize),
}

impl Weight {
    /// How many vertices it weighs.
    pub fn vertices(&self) -> usize {
        match self {
            Self::Vertices(factor) => factor.size(),
            Self::Grid(u, v) => u.size() * v.size(),
            Self::Coordinates(factor) => factor.size() / 3,
            Self::Still(count) => *count,
        }
    }

    /// `x ← L⁻¹ x`, three numbers a vertex; nothing where they stay.
    pub(super) fn forward(&self, x: &mut [f64]) {
        match self {
            Self::Vertices(factor) => factor.forward(x, 3),
            Self::Coordinates(factor) => factor.forward(x, 1),
            Self::Grid(u, v) => {
                let width = 3 * v.size();
                x.chunks_exact_mut(width).for_each(|row| v.forward(row, 3));
                lower(u, x, width, std::slice::from_ref(&(0..width)));
            }
            Self::Still(_) => x.fill(0.0),
        }
    }

    /// `x ← L⁻ᵀ x`.
    pub(super) fn backward(&self, x: &mut [f64]) {
        match self {
            Self::Vertices(factor) => factor.backward(x, 3),
            Self::Coordinates(factor) => factor.backward(x, 1),
            Self::Grid(u, v) => {
                let width = 3 * v.size();
                upper(u, x, width);
                x.chunks_exact_mut(width).for_each(|row| v.backward(row, 3));
            }
            Self::Still(_) => x.fill(0.0),
        }
    }

    /// Where rows start that reach back further than those before them, of each factor.
    pub(super) fn tails(&self) -> [usize; 2] {
        match self {
            Self::Vertices(factor) => [tail(factor), 0],
            Self::Coordinates(factor) => [tail(factor) / 3 * 3, 0],
            Self::Grid(u, v) => [tail(u), tail(v)],
            Self::Still(_) => [0, 0],
        }
    }

    /// `x ← L⁻¹ x` of a row that is zero but between the vertices `from` and `last`, `S` numbers a vertex. Where it is not
    /// negligible is told piece by piece, as ranges of vertices.
    pub(super) fn forward_row<const S: usize>(
        &self,
        x: &mut [f64],
        touched: &[usize],
        tails: [usize; 2],
        mut piece: impl FnMut(Range<usize>),
    ) {
        let (Some(from), Some(last)) = (touched.iter().copied().min(), touched.iter().copied().max()) else {
            return;
        };
        match self {
            Self::Still(_) => {}
            Self::Vertices(factor) => {
                let end = window::<S>(factor, x, from, last, tails[0]);
                piece(from..end);
                piece(tails[0].max(from)..factor.size());
            }
            Self::Coordinates(factor) => {
                // Three numbers a vertex, each an unknown of its own.
                let end =
                    window::<1>(factor, x, 3 * from, 3 * last + 2, tails[0]).div_ceil(3).min(tails[0] / 3);
                piece(from..end.max(from.min(tails[0] / 3)));
                piece((tails[0] / 3).max(from)..factor.size() / 3);
            }
            Self::Grid(u, v) => {
                let columns = v.size();
                let (first, final_row) = (from / columns, last / columns);
                let left = touched.iter().map(|t| t % columns).min().unwrap_or_default();
                let right = touched.iter().map(|t| t % columns).max().unwrap_or_default();
                let mut end = left;
                for row in x.chunks_exact_mut(columns * S).skip(first).take(final_row + 1 - first) {
                    end = end.max(window::<S>(v, row, left, right, tails[1]));
                }
                let spans = [left * S..end * S, tails[1].max(left) * S..columns * S];
                let bottom = rows_window(u, x, columns * S, &spans, first..final_row, tails[0]);
                for row in (first..bottom).chain(tails[0].max(first)..u.size()) {
                    for span in &spans {
                        piece(row * columns + span.start / S..row * columns + span.end / S);
                    }
                }
            }
        }
    }
}

/// The first row whose envelope starts before that of the row above: of a closed curve, those that the seam ties to the start.
fn tail(factor: &EnvelopeCholesky) -> usize {
    let starts = |i: usize| factor.row(i).0;
    (1..factor.size()).find(|&i| starts(i) < starts(i - 1)).unwrap_or(factor.size())
}

/// `x ← L⁻¹ x`, zero before `from` and after `last`. The end of what is not negligible before the `tail`, whose rows are all done.
fn window<const S: usize>(
    factor: &EnvelopeCholesky,
    x: &mut [f64],
    from: usize,
    last: usize,
    tail: usize,
) -> usize {
    let (x, _) = x.as_chunks_mut::<S>();
    let (mut end, mut quiet, mut largest) = (from, 0, 0.0_f64);
    for i in from..tail {
        let (first, row, reciprocal) = factor.row(i);
        if i > last && quiet >= i.saturating_sub(first) {
            break;
        }
        let low = first.max(from);
        let mut sum = x[i];
        for (l, x) in row[low - first..].iter().zip(&x[low..i]) {
            for s in 0..S {
                sum[s] -= l * x[s];
            }
        }
        x[i] = sum.map(|s| s * reciprocal);
        let size = x[i].iter().fold(0.0_f64, |size, v| size.max(v.abs()));
        largest = largest.max(size);
        quiet = if size <= NEGLIGIBLE * largest { quiet + 1 } else { 0 };
        end = i + 1;
    }
    x[end - quiet..end].fill([0.0; S]);
    end -= quiet;
    for i in tail.max(from)..factor.size() {
        let (first, row, reciprocal) = factor.row(i);
        let mut sum = x[i];
        for part in [first.max(from)..end.min(i), first.max(tail).max(from)..i] {
            if part.start < part.end {
                for (l, x) in row[part.start - first..].iter().zip(&x[part]) {
                    for s in 0..S {
                        sum[s] -= l * x[s];
                    }
                }
            }
        }
        x[i] = sum.map(|s| s * reciprocal);
    }
    end
}

/// `row ← (row - l · other) ` on some spans of both.
fn subtract(x: &mut [f64], width: usize, spans: &[Range<usize>], i: usize, k: usize, l: f64) {
    let (before, rest) = x.split_at_mut(i * width);
    for span in spans {
        let (own, other) = (&mut rest[span.clone()], &before[k * width..][span.clone()]);
        own.iter_mut().zip(other).for_each(|(own, other)| *own -= l * other);
    }
}

/// `x ← (L⁻¹ ⊗ I) x` for rows of `width` numbers, on some spans of them.
fn lower(factor: &EnvelopeCholesky, x: &mut [f64], width: usize, spans: &[Range<usize>]) {
    for i in 0..factor.size() {
        lower_row(factor, x, width, spans, i, 0);
    }
}

fn lower_row(
    factor: &EnvelopeCholesky,
    x: &mut [f64],
    width: usize,
    spans: &[Range<usize>],
    i: usize,
    from: usize,
) {
    let (first, row, reciprocal) = factor.row(i);
    let low = first.max(from);
    for (k, l) in row.iter().enumerate().skip(low - first) {
        subtract(x, width, spans, i, first + k, *l);
    }
    for span in spans {
        x[i * width..][span.clone()].iter_mut().for_each(|v| *v *= reciprocal);
    }
}

/// `x ← (L⁻ᵀ ⊗ I) x` for rows of `width` numbers.
fn upper(factor: &EnvelopeCholesky, x: &mut [f64], width: usize) {
    for i in (0..factor.size()).rev() {
        let (first, row, reciprocal) = factor.row(i);
        let (before, rest) = x.split_at_mut(i * width);
        let own = &mut rest[..width];
        own.iter_mut().for_each(|v| *v *= reciprocal);
        for (k, l) in row.iter().enumerate() {
            let other = &mut before[(first + k) * width..][..width];
            other.iter_mut().zip(&*own).for_each(|(other, own)| *other -= l * own);
        }
    }
}

/// [`window`] over rows of `width` numbers of which some spans are not zero.
fn rows_window(
    factor: &EnvelopeCholesky,
    x: &mut [f64],
    width: usize,
    spans: &[Range<usize>],
    touched: Range<usize>,
    tail: usize,
) -> usize {
    let (from, last) = (touched.start, touched.end);
    let (mut end, mut quiet, mut largest) = (from, 0, 0.0_f64);
    for i in from..tail {
        if i > last && quiet >= i.saturating_sub(factor.row(i).0) {
            break;
        }
        lower_row(factor, x, width, spans, i, from);
        let row = &x[i * width..][..width];
        let size = spans.iter().flat_map(|s| &row[s.clone()]).fold(0.0_f64, |size, v| size.max(v.abs()));
        largest = largest.max(size);
        quiet = if size <= NEGLIGIBLE * largest { quiet + 1 } else { 0 };
        end = i + 1;
    }
    for i in end - quiet..end {
        spans.iter().for_each(|s| x[i * width..][s.clone()].fill(0.0));
    }
    end -= quiet;
    for i in tail.max(from)..factor.size() {
        let (first, row, reciprocal) = factor.row(i);
        for (k, l) in row.iter().enumerate() {
            let at = first + k;
            if at >= from && (at < end || at >= tail) {
                subtract(x, width, spans, i, at, *l);
            }
        }
        for span in spans {
            x[i * width..][span.clone()].iter_mut().for_each(|v| *v *= reciprocal);
        }
    }
    end
}
