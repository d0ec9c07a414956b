//! A surface's point and derivatives at one place: the net is contracted along `v`, then along `u`.

use super::space::{MAX_ORDER, Space};
use super::{Surface, binomial};
use crate::{Point, Vector};

/// `x, y, z` times the weight, and the weight.
type Homogeneous = [f64; 4];

impl Surface {
    /// The point at a place on a patch.
    #[inline]
    pub(super) fn point_on(&self, spans: (usize, usize), at: (f64, f64)) -> Point {
        let [[[x, y, z, w]]] = self.jet::<1>(spans, at);
        if self.weights().is_some() { Point::new(x / w, y / w, z / w) } else { Point::new(x, y, z) }
    }

    /// All mixed derivatives up to `orders` at a place on a patch, in the order of
    /// [`derivatives_into`](Self::derivatives_into).
    pub(super) fn derivatives_on(
        &self,
        spans: (usize, usize),
        at: (f64, f64),
        [a, b]: [usize; 2],
        out: &mut [Vector],
    ) {
        match a.max(b) {
            0 => self.divided(&self.jet::<1>(spans, at), [a, b], out),
            1 => self.divided(&self.jet::<2>(spans, at), [a, b], out),
            2 => self.divided(&self.jet::<3>(spans, at), [a, b], out),
            _ => self.divided(&self.jet_of_any_order(spans, at, [a, b]), [a, b], out),
        }
    }

    /// The homogeneous derivatives, `[k][l]` of order `k` by `u` and `l` by `v`, both below `K`, which is at most 3.
    #[inline]
    pub(super) fn jet<const K: usize>(
        &self,
        (su, sv): (usize, usize),
        (u, v): (f64, f64),
    ) -> [[Homogeneous; K]; K] {
        match (self.u().degree(), self.v().degree()) {
            (3, 3) => {
                let (rows, columns) = (self.u().rows::<4, K>(su, u), self.v().rows::<4, K>(sv, v));
                self.contracted((su, sv), (4, 4), &rows, &columns)
            }
            (..=5, ..=5) => {
                let (rows, columns) = (low_rows(self.u(), su, u), low_rows(self.v(), sv, v));
                self.contracted((su, sv), self.orders(), &rows, &columns)
            }
            _ => {
                let (mut rows, mut columns) = ([[0.0; MAX_ORDER]; K], [[0.0; MAX_ORDER]; K]);
                self.u().rows_into(su, u, &mut rows);
                self.v().rows_into(sv, v, &mut columns);
                self.contracted((su, sv), self.orders(), &rows, &columns)
            }
        }
    }

    fn orders(&self) -> (usize, usize) {
        (self.u().degree() + 1, self.v().degree() + 1)
    }

    /// `Σ_i Σ_j R_ki C_lj H_ij` for every row `R_k` and `C_l` of basis functions.
    #[inline(always)]
    fn contracted<const W: usize, const K: usize>(
        &self,
        spans: (usize, usize),
        (count_u, count_v): (usize, usize),
        rows: &[[f64; W]; K],
        columns: &[[f64; W]; K],
    ) -> [[Homogeneous; K]; K] {
        let mut sums = [[[0.0; 4]; K]; K];
        for i in 0..count_u {
            let mut along = [[0.0; 4]; K];
            self.along(spans, (i, count_u), count_v, |j, h| {
                for l in 0..K {
                    add(&mut along[l], columns[l][j], &h);
                }
            });
            for k in 0..K {
                for l in 0..K {
                    add(&mut sums[k][l], rows[k][i], &along[l]);
                }
            }
        }
        sums
    }

    #[cold]
    fn jet_of_any_order(
        &self,
        (su, sv): (usize, usize),
        (u, v): (f64, f64),
        [a, b]: [usize; 2],
    ) -> Vec<Vec<Homogeneous>> {
        let (mut rows, mut columns) = (vec![[0.0; MAX_ORDER]; a + 1], vec![[0.0; MAX_ORDER]; b + 1]);
        self.u().rows_into(su, u, &mut rows);
        self.v().rows_into(sv, v, &mut columns);
        let (count_u, count_v) = self.orders();
        let mut sums = vec![vec![[0.0; 4]; b + 1]; a + 1];
        let mut along = vec![[0.0; 4]; b + 1];
        for i in 0..count_u {
            along.fill([0.0; 4]);
            self.along((su, sv), (i, count_u), count_v, |j, h| {
                for (along, column) in along.iter_mut().zip(&columns) {
                    add(along, column[j], &h);
                }
            });
            for (sums, row) in sums.iter_mut().zip(&rows) {
                for (sum, along) in sums.iter_mut().zip(&along) {
                    add(sum, row[i], along);
                }
            }
        }
        sums
    }

    /// The `count_v` vertices of row `i` of a patch, homogeneous, one after another.
    #[inline(always)]
    fn along(
        &self,
        (su, sv): (usize, usize),
        (i, count_u): (usize, usize),
        count_v: usize,
        mut each: impl FnMut(usize, Homogeneous),
    ) {
        let start = self.u().vertex(su + 1 - count_u + i) * self.v().len();
        let first = sv + 1 - count_v;
        let homogeneous = |p: &Point, w: f64| [p.x * w, p.y * w, p.z * w, w];
        if self.v().is_periodic() {
            for j in 0..count_v {
                let index = start + self.v().vertex(first + j);
                each(j, homogeneous(&self.points()[index], self.weights().map_or(1.0, |w| w[index])));
            }
            return;
        }
        // The vertices lie side by side.
        let range = start + first..start + first + count_v;
        let points = &self.points()[range.clone()];
        if let Some(weights) = self.weights() {
            for (j, (p, w)) in points.iter().zip(&weights[range]).enumerate() {
                each(j, homogeneous(p, *w));
            }
        } else {
            for (j, p) in points.iter().enumerate() {
                each(j, homogeneous(p, 1.0));
            }
        }
    }

    /// Derivatives of `A / W` from those of `A` and of `W` (the fourth lane).
    #[inline]
    fn divided<R: AsRef<[Homogeneous]>>(&self, jet: &[R], [a, b]: [usize; 2], out: &mut [Vector]) {
        let at = |k: usize, l: usize| k * (b + 1) + l;
        for k in 0..=a {
            for l in 0..=b {
                let [x, y, z, _] = jet[k].as_ref()[l];
                let mut value = Vector::new(x, y, z);
                if self.weights().is_some() {
                    for i in 0..=k {
                        for j in 0..=l {
                            if i + j > 0 {
                                let factor = binomial(k, i) * binomial(l, j) * jet[i].as_ref()[j][3];
                                value -= out[at(k - i, l - j)] * factor;
                            }
                        }
                    }
                    value /= jet[0].as_ref()[0][3];
                }
                out[at(k, l)] = value;
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

/// The rows of basis functions and derivatives of a space of degree 1 to 5.
#[inline]
fn low_rows<const K: usize>(space: &Space, span: usize, u: f64) -> [[f64; 6]; K] {
    match space.degree() {
        1 => padded(space.rows::<2, K>(span, u)),
        2 => padded(space.rows::<3, K>(span, u)),
        3 => padded(space.rows::<4, K>(span, u)),
        4 => padded(space.rows::<5, K>(span, u)),
        _ => space.rows::<6, K>(span, u),
    }
}

#[inline]
fn padded<const N: usize, const K: usize>(rows: [[f64; N]; K]) -> [[f64; 6]; K] {
    rows.map(|row| {
        let mut padded = [0.0; 6];
        padded[..N].copy_from_slice(&row);
        padded
    })
}
