//! Surfaces whose cells say their points: evaluated as Bézier patches, without rows, many at once.

use std::ops::Range;

use loftsman_kernel::shape::{CellNet, Shape};
use loftsman_kernel::spline::space::MAX_ORDER;
use loftsman_kernel::{Error, Point, Result, Vector, parallel};

use crate::members::{Member, middle_of};

/// Cells that one thread looks at in a run: always the same, so that sums are.
const RUN: usize = 512;
/// The most nodes of a line of places.
pub(crate) const MOST_NODES: usize = MAX_ORDER + 6;

/// A surface whose cells say their nets.
#[derive(Clone, Copy)]
pub(crate) struct Nets<'s> {
    shape: &'s dyn Shape,
    /// What nets are taken from.
    pub(crate) origin: Point,
    /// Cells have numbers below this one.
    pub(crate) count: usize,
    /// The degrees of the first one.
    pub(crate) degrees: [usize; 2],
}

impl<'s> Nets<'s> {
    /// `None` where the surface is summed in another way: as a product of splines, as a part of its cells, or by stencils.
    pub(crate) fn of(surface: &Member<'s>) -> Option<Self> {
        let cells = surface.cells;
        if surface.splines.is_some() || cells.is_partial() {
            return None;
        }
        let origin = middle_of(surface.points());
        cells.nets(0..0, &origin, &mut |_| {})?.ok()?;
        let count = cells.count();
        let mut nets = Self { shape: surface.shape, origin, count, degrees: [1; 2] };
        let first = |nets: &Self, k| nets.one(k, |net| net.sides.map(|side| side.degree)).ok().flatten();
        if let Some(degrees) = (0..count).find_map(|number| first(&nets, number)) {
            nets.degrees = degrees;
        }
        Some(nets)
    }

    fn each(&self, numbers: Range<usize>, origin: &Point, work: &mut dyn FnMut(CellNet<'_>)) -> Result<()> {
        let mut sound = Ok(());
        let said = self.shape.cells().and_then(|cells| {
            cells.nets(numbers, origin, &mut |net| {
                let wanted: usize = net.sides.iter().map(|side| side.degree + 1).product();
                let fits = net.sides.iter().all(|side| side.degree < MAX_ORDER && side.start < side.end);
                if fits && wanted == net.points.len() {
                    work(net);
                } else if sound.is_ok() {
                    sound = Err(Error::Invalid(format!(
                        "cell {} of a shape ({}) needs sides with a length and {wanted} points, one more in each direction than its degree: it \
                         is {net:?}",
                        net.number,
                        self.shape.type_name()
                    )));
                }
            })
        });
        said.unwrap_or(Ok(())).and(sound)
    }

    /// `work` on the net of every cell, with what `room` makes for a run of them, runs side by side; results are in the order of the cells.
    ///
    /// # Errors
    /// As for [`Cells::nets`](loftsman_kernel::shape::Cells::nets), and when a net has not as many points as its degrees want.
    pub(crate) fn map<S, R: Send>(
        &self,
        origin: &Point,
        room: impl Fn() -> S + Sync + Send,
        work: impl Fn(&mut S, CellNet<'_>) -> R + Sync + Send,
    ) -> Result<Vec<R>> {
        let runs = parallel::map(self.count.div_ceil(RUN), |run| {
            let numbers = run * RUN..((run + 1) * RUN).min(self.count);
            let mut made = Vec::with_capacity(numbers.len());
            let mut room = room();
            self.each(numbers, origin, &mut |net| made.push(work(&mut room, net)))?;
            Ok(made)
        });
        let mut all = Vec::with_capacity(self.count);
        for run in runs {
            all.extend(run?);
        }
        Ok(all)
    }

    /// What `work` makes of the net of one cell.
    ///
    /// # Errors
    /// As for [`map`](Self::map).
    pub(crate) fn one<R>(&self, number: usize, work: impl FnOnce(CellNet<'_>) -> R) -> Result<Option<R>> {
        let (mut work, mut made) = (Some(work), None);
        self.each(number..number + 1, &self.origin, &mut |net| {
            if let Some(work) = work.take() {
                made = Some(work(net));
            }
        })?;
        Ok(made)
    }
}

/// Bernstein functions and their slopes at the nodes of a line in `[0, 1]`: of each function all nodes, one after another, and zeros after them up to a
/// whole number of fours, so that work on them goes on several at a time.
#[derive(Debug, Clone)]
pub(crate) struct Line {
    degree: usize,
    pub(crate) nodes: usize,
    /// The number of nodes with the zeros after them.
    stride: usize,
    values: Vec<f64>,
    slopes: Vec<f64>,
}

impl Line {
    /// At most [`MOST_NODES`] nodes.
    pub(crate) fn new(degree: usize, nodes: impl ExactSizeIterator<Item = f64>) -> Self {
        let count = nodes.len();
        let stride = count.next_multiple_of(4);
        let (mut values, mut slopes) = (vec![0.0; (degree + 1) * stride], vec![0.0; (degree + 1) * stride]);
        for (k, x) in nodes.enumerate() {
            let mut row = [0.0; MAX_ORDER];
            row[0] = 1.0;
            for level in 1..=degree {
                if level == degree {
                    // `p (B_{i-1} - B_i)` of those of one degree less.
                    for i in 0..=degree {
                        let before = if i > 0 { row[i - 1] } else { 0.0 };
                        let own = if i < degree { row[i] } else { 0.0 };
                        slopes[i * stride + k] = degree as f64 * (before - own);
                    }
                }
                let mut carry = 0.0;
                for value in &mut row[..=level] {
                    let own = *value;
                    *value = own * (1.0 - x) + carry;
                    carry = own * x;
                }
            }
            (0..=degree).for_each(|i| values[i * stride + k] = row[i]);
        }
        Self { degree, nodes: count, stride, values, slopes }
    }
}

/// Numbers at the nodes of a line, component by component.
pub(crate) type Across = [[f64; MOST_NODES]; 3];

/// What a patch is along a line of nodes in `v`: at first nothing.
pub(crate) struct Row {
    /// Its points, from the first of its net.
    pub(crate) points: Across,
    /// `S_u × S_v`.
    pub(crate) normals: Across,
}

impl Default for Row {
    fn default() -> Self {
        Self { points: [[0.0; MOST_NODES]; 3], normals: [[0.0; MOST_NODES]; 3] }
    }
}

impl Row {
    /// Of a patch along `v` at node `x` of the line in `u`; its points only where they are wanted. Cost: the number of points of the net, and for each
    /// node those of one row of it.
    pub(crate) fn fill(&mut self, net: &[Vector], [u, v]: [&Line; 2], x: usize, with_points: bool) {
        // Usual degrees and numbers of nodes as constants: then all loops have a length that is known.
        match ([u.degree, v.degree], v.stride) {
            ([2, 2], 4) => self.known::<3, 3, 4>(net, [u, v], x, with_points),
            ([2, 2], 8) => self.known::<3, 3, 8>(net, [u, v], x, with_points),
            ([3, 3], 8) => self.known::<4, 4, 8>(net, [u, v], x, with_points),
            ([3, 3], 12) => self.known::<4, 4, 12>(net, [u, v], x, with_points),
            (degrees, _) => self.any(net, [u, v], degrees, x, with_points),
        }
    }

    /// Of degrees one less than `P` and `Q`, with `N` nodes and zeros.
    fn known<const P: usize, const Q: usize, const N: usize>(
        &mut self,
        net: &[Vector],
        [u, v]: [&Line; 2],
        x: usize,
        with_points: bool,
    ) {
        let Some(&first) = net.first() else { return };
        let (rows, _) = net.as_chunks::<Q>();
        let (functions, derivatives) = (v.values.as_chunks::<N>().0, v.slopes.as_chunks::<N>().0);
        let (mut values, mut slopes) = ([[0.0; Q]; 3], [[0.0; Q]; 3]);
        for (i, row) in rows.iter().enumerate().take(P) {
            let (value, slope) = (u.values[i * u.stride + x], u.slopes[i * u.stride + x]);
            for (j, point) in row.iter().enumerate() {
                let point = point - first;
                for a in 0..3 {
                    values[a][j] += value * point[a];
                    slopes[a][j] += slope * point[a];
                }
            }
        }
        let (mut along_u, mut along_v) = ([[0.0; N]; 3], [[0.0; N]; 3]);
        for a in 0..3 {
            add(&mut along_u[a], functions, &slopes[a]);
            add(&mut along_v[a], derivatives, &values[a]);
            if with_points {
                let mut points = [0.0; N];
                add(&mut points, functions, &values[a]);
                self.points[a][..N].copy_from_slice(&points);
            }
        }
        let ([ux, uy, uz], [vx, vy, vz]) = (&along_u, &along_v);
        let [nx, ny, nz] = &mut self.normals;
        let mut k = 0;
        while k < N {
            nx[k] = uy[k] * vz[k] - uz[k] * vy[k];
            ny[k] = uz[k] * vx[k] - ux[k] * vz[k];
            nz[k] = ux[k] * vy[k] - uy[k] * vx[k];
            k += 1;
        }
    }

    fn any(&mut self, net: &[Vector], [u, v]: [&Line; 2], [p, q]: [usize; 2], x: usize, with_points: bool) {
        let Some(&first) = net.first() else { return };
        let count = v.nodes.min(MOST_NODES);
        // Tiny cells are far from the origin by their own size: what is left of that is taken off at once.
        let (mut values, mut slopes) = ([[0.0; MAX_ORDER]; 3], [[0.0; MAX_ORDER]; 3]);
        for i in 0..=p {
            let (value, slope) = (u.values[i * u.stride + x], u.slopes[i * u.stride + x]);
            for j in 0..=q {
                let point = net[i * (q + 1) + j] - first;
                for a in 0..3 {
                    values[a][j] += value * point[a];
                    slopes[a][j] += slope * point[a];
                }
            }
        }
        let (mut along_u, mut along_v) = ([[0.0; MOST_NODES]; 3], [[0.0; MOST_NODES]; 3]);
        for a in 0..3 {
            let (by_u, by_v) = (&mut along_u[a][..count], &mut along_v[a][..count]);
            for j in 0..=q {
                let functions = &v.values[j * v.stride..j * v.stride + count];
                let derivatives = &v.slopes[j * v.stride..j * v.stride + count];
                let (value, slope) = (values[a][j], slopes[a][j]);
                for k in 0..count {
                    by_u[k] += functions[k] * slope;
                    by_v[k] += derivatives[k] * value;
                }
            }
            if with_points {
                let points = &mut self.points[a][..count];
                points.fill(0.0);
                for j in 0..=q {
                    let functions = &v.values[j * v.stride..j * v.stride + count];
                    points.iter_mut().zip(functions).for_each(|(sum, c)| *sum += c * values[a][j]);
                }
            }
        }
        let ([ux, uy, uz], [vx, vy, vz]) = (&along_u, &along_v);
        let [x, y, z] = &mut self.normals;
        for k in 0..count {
            x[k] = uy[k] * vz[k] - uz[k] * vy[k];
            y[k] = uz[k] * vx[k] - ux[k] * vz[k];
            z[k] = ux[k] * vy[k] - uy[k] * vx[k];
        }
    }

    /// The normal at a node.
    pub(crate) fn normal(&self, node: usize) -> [f64; 3] {
        [0, 1, 2].map(|a| self.normals[a][node])
    }
}

/// `sum += Σ_j by_j functions_j` at all nodes.
#[inline(always)]
fn add<const N: usize, const Q: usize>(sum: &mut [f64; N], functions: &[[f64; N]], by: &[f64; Q]) {
    // By numbers: iterators are calls where little is optimised.
    let mut j = 0;
    while j < Q && j < functions.len() {
        let function = &functions[j];
        let mut k = 0;
        while k < N {
            sum[k] += function[k] * by[j];
            k += 1;
        }
        j += 1;
    }
}

/// A sum whose rounding does not grow with the number of terms (Neumaier 1974).
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Total {
    sum: f64,
    lost: f64,
}

impl Total {
    pub(crate) fn add(&mut self, term: f64) {
        let sum = self.sum + term;
        let lost =
            if self.sum.abs() >= term.abs() { (self.sum - sum) + term } else { (term - sum) + self.sum };
        // Where the sum is no number any more, nothing is lost.
        if lost.is_finite() {
            self.lost += lost;
        }
        self.sum = sum;
    }

    pub(crate) fn value(self) -> f64 {
        self.sum + self.lost
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values, slopes and points of a patch by de Casteljau's algorithm and by differences.
    #[test]
    fn a_row_is_the_patch_there() {
        for [p, q] in [[1, 1], [2, 2], [3, 3], [3, 1], [2, 5], [0, 3]] {
            let wave = |k: usize| ((1 + k * k) as f64 * 1.7).sin();
            let net: Vec<Vector> = (0..(p + 1) * (q + 1))
                .map(|k| Vector::new(wave(k) + 1e3, wave(3 * k + 1), wave(7 * k + 2)))
                .collect();
            let lines = [Line::new(p, [0.2, 0.7].into_iter()), Line::new(q, [0.0, 0.4, 1.0].into_iter())];
            let mut row = Row::default();
            for (x, u) in [0.2, 0.7].into_iter().enumerate() {
                row.fill(&net, [&lines[0], &lines[1]], x, true);
                for (k, v) in [0.0, 0.4, 1.0].into_iter().enumerate() {
                    let at = |u: f64, v: f64| {
                        let line = |mut points: Vec<Vector>, t: f64| {
                            while points.len() > 1 {
                                points = points.windows(2).map(|w| w[0] * (1.0 - t) + w[1] * t).collect();
                            }
                            points[0]
                        };
                        line(net.chunks(q + 1).map(|row| line(row.to_vec(), v)).collect(), u)
                    };
                    let point = net[0] + Vector::from([0, 1, 2].map(|a| row.points[a][k]));
                    assert!((point - at(u, v)).norm() < 1e-12, "{p} {q}");
                    let h = 1e-4;
                    let by_u = (at(u + h, v) - at(u - h, v)) / (2.0 * h);
                    let by_v = (at(u, v + h) - at(u, v - h)) / (2.0 * h);
                    let off = Vector::from(row.normal(k)) - by_u.cross(&by_v);
                    assert!(off.norm() < 1e-4 * (1.0 + by_u.norm() * by_v.norm()), "{p} {q}: {off}");
                }
            }
        }
    }

    #[test]
    fn a_sum_keeps_what_is_small() {
        let mut total = Total::default();
        for term in [1e16, 1.0, 1.0, -1e16, 0.25] {
            total.add(term);
        }
        assert_eq!(total.value(), 2.25);
        total.add(f64::INFINITY);
        assert_eq!(total.value(), f64::INFINITY);
    }
}
