//! A grid of parameters on a surface.

use std::ops::Range;

use super::cursor::Cursor;
use super::sample::Outcome;
use super::{OrientedPoint, Sample, in_blocks, same_length};
use crate::Point;
use crate::error::Result;
use crate::spline::Surface;
use crate::spline::space::{MAX_ORDER, Space};

impl Surface {
    /// The points on the grid `us × vs`, all of `vs` for the first `u`, then for the next. The sum over the net is
    /// taken in two steps: one row of vertices a `u`, then `q + 1` of them a point. `O(|us| n_v p + |us| |vs| q)`.
    ///
    /// # Errors
    /// When `out` is not `us.len() * vs.len()` long or a parameter is outside the domain.
    pub fn grid_into(&self, us: &[f64], vs: &[f64], out: &mut [Point]) -> Result<()> {
        self.contract(us, vs, out)
    }

    /// Points and unit normals on the grid `us × vs`, as [`grid_into`](Self::grid_into).
    ///
    /// # Errors
    /// As for [`grid_into`](Self::grid_into).
    pub fn grid_oriented_into(&self, us: &[f64], vs: &[f64], out: &mut [OrientedPoint]) -> Result<()> {
        self.contract(us, vs, out)
    }

    /// Points, first derivatives and unit normals on the grid `us × vs`, as [`grid_into`](Self::grid_into).
    ///
    /// # Errors
    /// As for [`grid_into`](Self::grid_into).
    pub fn grid_frames_into(&self, us: &[f64], vs: &[f64], out: &mut [Sample]) -> Result<()> {
        self.contract(us, vs, out)
    }

    fn contract<T: Outcome>(&self, us: &[f64], vs: &[f64], out: &mut [T]) -> Result<()> {
        match (self.weights().is_some(), self.v().degree()) {
            (true, 3) => self.contract_of::<true, 4, T>(us, vs, out),
            (true, _) => self.contract_of::<true, 0, T>(us, vs, out),
            (false, 3) => self.contract_of::<false, 4, T>(us, vs, out),
            (false, _) => self.contract_of::<false, 0, T>(us, vs, out),
        }
    }

    /// `N` is the order `q + 1` along `v` where the compiler is to know it, or 0.
    fn contract_of<const RATIONAL: bool, const N: usize, T: Outcome>(
        &self,
        us: &[f64],
        vs: &[f64],
        out: &mut [T],
    ) -> Result<()> {
        same_length(us.len().saturating_mul(vs.len()), out.len())?;
        let columns = Columns::new(self.v(), vs)?;
        let n = if N == 0 { self.v().degree() + 1 } else { N };
        in_blocks(us, out, vs.len(), |us, out| {
            let mut cursor = Cursor::new(self.u());
            let mut lines = vec![[[0.0; 4]; 2]; columns.used.len()];
            for (&u, out) in us.iter().zip(out.chunks_exact_mut(vs.len().max(1))) {
                let u = cursor.find(u)?;
                self.contract_u(cursor.span, u, T::SLOPES, columns.used.clone(), &mut lines);
                for ((&first, values), out) in
                    columns.first.iter().zip(columns.values.chunks_exact(n)).zip(out)
                {
                    let mut jet = [[0.0; 4]; 3];
                    for ([value, slope], line) in values.iter().zip(&lines[first..first + n]) {
                        for lane in 0..4 {
                            jet[0][lane] += value * line[0][lane];
                            if T::SLOPES {
                                jet[1][lane] += value * line[1][lane];
                                jet[2][lane] += slope * line[0][lane];
                            }
                        }
                    }
                    *out = T::of::<RATIONAL>(&jet);
                }
            }
            Ok(())
        })
    }

    /// The net contracted along `u`: homogeneous vertices of the curve `S(u, ·)`, and of its derivative by `u`. They are
    /// unrolled along `v`, so that no point has to wrap an index.
    fn contract_u(&self, span: usize, u: f64, slopes: bool, used: Range<usize>, lines: &mut [[[f64; 4]; 2]]) {
        let (space, p) = (self.u(), self.u().degree());
        let mut rows = [[0.0; MAX_ORDER]; 2];
        let orders = if slopes { 2 } else { 1 };
        space.rows_into(span, u, &mut rows[..orders]);
        lines.fill([[0.0; 4]; 2]);
        for i in 0..=p {
            let start = space.vertex(span - p + i) * self.v().len();
            for (k, line) in used.clone().zip(&mut *lines) {
                let index = start + self.v().vertex(k);
                let (point, w) = (self.points()[index], self.weights().map_or(1.0, |w| w[index]));
                let homogeneous = [point.x * w, point.y * w, point.z * w, w];
                for (line, row) in line.iter_mut().zip(&rows[..orders]) {
                    for (sum, h) in line.iter_mut().zip(homogeneous) {
                        *sum += row[i] * h;
                    }
                }
            }
        }
    }
}

/// The basis functions along `v`, once for all rows of the grid.
struct Columns {
    /// Unrolled vertices that some parameter needs.
    used: Range<usize>,
    /// Of each parameter: the first of its vertices, counted from the first that is used.
    first: Vec<usize>,
    /// Value and derivative of its `q + 1` basis functions.
    values: Vec<[f64; 2]>,
}

impl Columns {
    fn new(space: &Space, vs: &[f64]) -> Result<Self> {
        let q = space.degree();
        let mut cursor = Cursor::new(space);
        let mut first = Vec::with_capacity(vs.len());
        let mut values = Vec::with_capacity(vs.len() * (q + 1));
        let mut rows = [[0.0; MAX_ORDER]; 2];
        for &v in vs {
            let v = cursor.find(v)?;
            space.rows_into(cursor.span, v, &mut rows);
            first.push(cursor.span - q);
            values.extend((0..=q).map(|j| [rows[0][j], rows[1][j]]));
        }
        let low = first.iter().copied().min().unwrap_or(0);
        let high = first.iter().copied().max().map_or(0, |last| last + q + 1);
        first.iter_mut().for_each(|first| *first -= low);
        Ok(Self { used: low..high, first, values })
    }
}
