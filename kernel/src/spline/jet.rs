//! A surface's point and derivatives at one place: the net is contracted along `v`, then along `u`.

use smallvec::{SmallVec, smallvec};

use super::space::{MAX_ORDER, Space};
use super::{Surface, binomial};
use crate::{Point, Vector};

/// `x, y, z` times the weight, and the weight.
type Homogeneous = [f64; 4];

/// Rows of basis functions: on the stack up to second derivatives.
type Rows = SmallVec<[[f64; MAX_ORDER]; 3]>;

impl Surface {
    /// The point at a place on a patch.
    #[inline]
    pub(super) fn point_on(&self, spans: (usize, usize), (u, v): (f64, f64)) -> Point {
        if (self.u().degree(), self.v().degree()) == (3, 3) {
            let (row, column) = (self.u().values::<4>(spans.0, u), self.v().values::<4>(spans.1, v));
            return self.combine(spans, &row, &column);
        }
        let (mut row, mut column) = ([0.0; MAX_ORDER], [0.0; MAX_ORDER]);
        row_into(self.u(), spans.0, u, &mut row);
        row_into(self.v(), spans.1, v, &mut column);
        self.combine(spans, &row[..=self.u().degree()], &column[..=self.v().degree()])
    }

    /// The point that the basis values of both directions give.
    #[inline(always)]
    fn combine(&self, spans: (usize, usize), row: &[f64], column: &[f64]) -> Point {
        let mut sum = [0.0; 4];
        for (i, value) in row.iter().enumerate() {
            let mut along = [0.0; 4];
            self.along(spans, i, column.len(), |j, h| add(&mut along, column[j], &h));
            add(&mut sum, *value, &along);
        }
        let [x, y, z, w] = sum;
        if self.weights().is_some() { Point::new(x / w, y / w, z / w) } else { Point::new(x, y, z) }
    }

    /// All mixed derivatives up to `orders` at a place on a patch, in the order of
    /// [`derivatives_into`](Self::derivatives_into).
    pub(super) fn derivatives_on(
        &self,
        spans: (usize, usize),
        (u, v): (f64, f64),
        [a, b]: [usize; 2],
        out: &mut [Vector],
    ) {
        let (rows, columns) = (all_rows(self.u(), spans.0, u, a), all_rows(self.v(), spans.1, v, b));
        let mut sums: SmallVec<[Homogeneous; 9]> = smallvec![[0.0; 4]; (a + 1) * (b + 1)];
        let mut along: SmallVec<[Homogeneous; 3]> = smallvec![[0.0; 4]; b + 1];
        for i in 0..=self.u().degree() {
            along.fill([0.0; 4]);
            self.along(spans, i, self.v().degree() + 1, |j, h| {
                for (along, column) in along.iter_mut().zip(&columns) {
                    add(along, column[j], &h);
                }
            });
            for (sums, row) in sums.chunks_exact_mut(b + 1).zip(&rows) {
                for (sum, along) in sums.iter_mut().zip(&along) {
                    add(sum, row[i], along);
                }
            }
        }
        for (out, [x, y, z, _]) in out.iter_mut().zip(&sums) {
            *out = Vector::new(*x, *y, *z);
        }
        if self.weights().is_some() {
            quotient([a, b], &sums, out);
        }
    }

    /// The `count` vertices of row `i` of a patch, homogeneous, one after another.
    #[inline(always)]
    fn along(&self, spans: (usize, usize), i: usize, count: usize, mut each: impl FnMut(usize, Homogeneous)) {
        let (p, columns) = (self.u().degree(), self.v().len());
        let start = self.u().vertex(spans.0 - p + i) * columns;
        let first = spans.1 + 1 - count;
        let mut give = |j: usize, index: usize| {
            let (point, w) = (self.points()[index], self.weights().map_or(1.0, |w| w[index]));
            each(j, [point.x * w, point.y * w, point.z * w, w]);
        };
        if self.v().is_periodic() {
            for j in 0..count {
                give(j, start + self.v().vertex(first + j));
            }
        } else {
            for j in 0..count {
                give(j, start + first + j);
            }
        }
    }
}

#[inline(always)]
fn add(sum: &mut Homogeneous, factor: f64, h: &Homogeneous) {
    for (sum, h) in sum.iter_mut().zip(h) {
        *sum += factor * h;
    }
}

/// The values of the basis functions on a span, unrolled for the usual degrees.
#[inline]
pub(super) fn row_into(space: &Space, span: usize, u: f64, row: &mut [f64; MAX_ORDER]) {
    match space.degree() {
        1 => row[..2].copy_from_slice(&space.values::<2>(span, u)),
        2 => row[..3].copy_from_slice(&space.values::<3>(span, u)),
        3 => row[..4].copy_from_slice(&space.values::<4>(span, u)),
        4 => row[..5].copy_from_slice(&space.values::<5>(span, u)),
        5 => row[..6].copy_from_slice(&space.values::<6>(span, u)),
        _ => space.basis_into(span, u, 0, row),
    }
}

fn all_rows(space: &Space, span: usize, u: f64, order: usize) -> Rows {
    let mut rows: Rows = smallvec![[0.0; MAX_ORDER]; order + 1];
    match (space.degree(), order) {
        (_, 0) => row_into(space, span, u, &mut rows[0]),
        (1, ..=2) => copy(&space.rows::<2, 3>(span, u), &mut rows),
        (2, ..=2) => copy(&space.rows::<3, 3>(span, u), &mut rows),
        (3, ..=2) => copy(&space.rows::<4, 3>(span, u), &mut rows),
        (4, ..=2) => copy(&space.rows::<5, 3>(span, u), &mut rows),
        (5, ..=2) => copy(&space.rows::<6, 3>(span, u), &mut rows),
        _ => space.rows_into(span, u, &mut rows),
    }
    rows
}

fn copy<const N: usize>(from: &[[f64; N]; 3], to: &mut [[f64; MAX_ORDER]]) {
    for (to, from) in to.iter_mut().zip(from) {
        to[..N].copy_from_slice(from);
    }
}

/// Derivatives of `A / W` from those of `A` (in place) and of `W` (the fourth lane of `sums`).
fn quotient([a, b]: [usize; 2], sums: &[Homogeneous], out: &mut [Vector]) {
    let at = |k: usize, l: usize| k * (b + 1) + l;
    for k in 0..=a {
        for l in 0..=b {
            let mut value = out[at(k, l)];
            for i in 0..=k {
                for j in 0..=l {
                    if i + j > 0 {
                        let factor = binomial(k, i) * binomial(l, j) * sums[at(i, j)][3];
                        value -= out[at(k - i, l - j)] * factor;
                    }
                }
            }
            out[at(k, l)] = value / sums[0][3];
        }
    }
}
