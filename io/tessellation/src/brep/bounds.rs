//! What the second derivatives of a surface can be in any box of its parameters.
//!
//! Each Bézier patch is divided into cells, and over each the derivatives are enclosed by boxes of vectors: of a polynomial patch the
//! boxes of its derivatives' Bézier points; of a rational one `S = A / W`, taken about a point of the cell so that `S` is small,
//!
//! ```text
//! S_u = (A_u - S W_u) / W,   S_uu = (A_uu - 2 S_u W_u - S W_uu) / W,   S_uv = (A_uv - S_u W_v - S_v W_u - S W_uv) / W
//! ```
//!
//! by interval arithmetic. Numerators are taken together as far as they are polynomials: with `S_u = c + e`, `c` its value in the middle
//! of the cell, `A_uu - 2 c W_u` is one, and only `e` is an interval. So the boxes shrink with the cells, but for what the derivatives
//! themselves vary.

use std::sync::{Arc, OnceLock};

use loftsman_kernel::Vector;
use smallvec::SmallVec;

use crate::bezier::{less, more, restrict};
use crate::form::Ranges;
use crate::patch::{Homogeneous, Patch, jet_of, project, xyz};

/// How many cells a direction has at least where the surface bends in it.
const CELLS: usize = 24;

/// The part of cells below which a box is better looked at by itself.
const COARSE: f64 = 0.25;
/// How many cells a mean is taken of, in each direction.
const SAMPLES: usize = 8;
/// How many places of a patch, in each direction, a search starts from.
const NEAR: usize = 4;

/// The Bézier points of a patch or of a derivative of one: of low degrees where they are, without an allocation.
type Net = SmallVec<[Homogeneous; 16]>;

/// A box of vectors.
#[derive(Debug, Clone, Copy)]
struct Span {
    low: Vector,
    high: Vector,
}

impl Span {
    const ZERO: Self = Self { low: Vector::new(0.0, 0.0, 0.0), high: Vector::new(0.0, 0.0, 0.0) };

    #[inline]
    fn of(points: impl Iterator<Item = Vector>) -> Self {
        points.map(|p| Self { low: p, high: p }).reduce(Self::join).unwrap_or(Self::ZERO)
    }

    fn minus(self, other: Self) -> Self {
        Self { low: self.low - other.high, high: self.high - other.low }
    }

    /// Times what lies between two numbers.
    fn times(self, [a, b]: [f64; 2]) -> Self {
        let one = Self { low: self.low * a, high: self.high * a };
        let other = Self { low: self.low * b, high: self.high * b };
        let ends =
            |span: Self| Self { low: lower(&span.low, &span.high), high: upper(&span.low, &span.high) };
        ends(one).join(ends(other))
    }

    fn most(&self) -> f64 {
        upper(&self.low.abs(), &self.high.abs()).norm()
    }

    fn join(self, other: Self) -> Self {
        Self { low: lower(&self.low, &other.low), high: upper(&self.high, &other.high) }
    }
}

/// The lesser of each coordinate.
#[inline]
fn lower(a: &Vector, b: &Vector) -> Vector {
    Vector::new(less(a.x, b.x), less(a.y, b.y), less(a.z, b.z))
}

/// The larger of each coordinate.
#[inline]
fn upper(a: &Vector, b: &Vector) -> Vector {
    Vector::new(more(a.x, b.x), more(a.y, b.y), more(a.z, b.z))
}

/// What the derivatives of a surface can be over a cell of parameters.
#[derive(Debug, Clone, Copy)]
struct Cell {
    /// The largest lengths of `S_u` and `S_v`.
    first: [f64; 2],
    /// `S_uu`, `S_uv`, `S_vv`.
    second: [Span; 3],
}

/// The cells of a surface.
#[derive(Debug)]
pub(crate) struct Bounds {
    breaks: [Vec<f64>; 2],
    /// How many cells each patch is divided into, and how many patches there are along `v`.
    parts: [usize; 2],
    across: usize,
    /// Found when they are first asked for: a face may be a small part of its surface.
    cells: Vec<OnceLock<Cell>>,
    patches: Arc<[Patch]>,
}

impl Bounds {
    /// Those of the patches of a surface, row after row, between these parameters.
    pub(crate) fn new(patches: Arc<[Patch]>, breaks: &[Vec<f64>; 2]) -> Self {
        let counts = [0, 1].map(|d| breaks[d].len().saturating_sub(1).max(1));
        let bends = |d: usize| patches.iter().any(|p| [p.rows, p.columns][d] > 2);
        let parts = [0, 1].map(|d| if bends(d) { CELLS.div_ceil(counts[d]) } else { 1 });
        let fine = [0, 1].map(|d| {
            let mut all: Vec<f64> = Vec::with_capacity(counts[d] * parts[d] + 1);
            for pair in breaks[d].windows(2) {
                let step = (pair[1] - pair[0]) / parts[d] as f64;
                all.extend((0..parts[d]).map(|k| pair[0] + step * k as f64));
            }
            all.extend(breaks[d].last());
            all
        });
        let count = counts[0] * parts[0] * counts[1] * parts[1];
        let cells = (0..count).map(|_| OnceLock::new()).collect();
        Self { breaks: fine, parts, across: counts[1], cells, patches }
    }

    /// The patch of a cell and where in it that is.
    fn place(&self, row: usize, column: usize) -> (&Patch, [f64; 2], [f64; 2]) {
        let [parts_u, parts_v] = self.parts;
        let (i, j) = (row / parts_u, column / parts_v);
        let (a, b) = (row % parts_u, column % parts_v);
        let share = |k: usize, parts: usize| k as f64 / parts as f64;
        let low = [share(a, parts_u), share(b, parts_v)];
        let high = [share(a + 1, parts_u), share(b + 1, parts_v)];
        (&self.patches[i * self.across + j], low, high)
    }

    fn cell(&self, row: usize, column: usize) -> &Cell {
        self.cells[row * self.columns() + column].get_or_init(|| {
            let (patch, low, high) = self.place(row, column);
            let length = |d: usize, k: usize| self.breaks[d][k + 1] - self.breaks[d][k];
            cell(patch, low, high, [length(0, row), length(1, column)])
        })
    }

    fn columns(&self) -> usize {
        self.breaks[1].len() - 1
    }

    /// The cells that an interval of parameters meets, by direction.
    fn range(&self, direction: usize, low: f64, high: f64) -> std::ops::Range<usize> {
        let breaks = &self.breaks[direction];
        let last = breaks.len() - 2;
        let first = breaks.partition_point(|b| *b <= low).saturating_sub(1).min(last);
        let end = breaks.partition_point(|b| *b < high).clamp(first + 1, last + 1);
        first..end
    }

    fn over(&self, low: [f64; 2], high: [f64; 2]) -> impl Iterator<Item = &Cell> {
        let (rows, columns) = (self.range(0, low[0], high[0]), self.range(1, low[1], high[1]));
        rows.flat_map(move |i| columns.clone().map(move |j| self.cell(i, j)))
    }

    /// Whether a box is in one direction a small part of the cells that it meets.
    pub(crate) fn are_coarse(&self, low: [f64; 2], high: [f64; 2]) -> bool {
        (0..2).any(|d| {
            let cells = self.range(d, low[d], high[d]);
            high[d] - low[d] < COARSE * (self.breaks[d][cells.end] - self.breaks[d][cells.start])
        })
    }

    /// What the second derivatives can be in a box.
    pub(crate) fn spread(&self, low: [f64; 2], high: [f64; 2]) -> Spread {
        let join = |a: [Span; 3], b: [Span; 3]| [a[0].join(b[0]), a[1].join(b[1]), a[2].join(b[2])];
        let second = self.over(low, high).map(|cell| cell.second).reduce(join);
        Spread { second: second.unwrap_or([Span::ZERO; 3]) }
    }

    /// The largest lengths of `S_u` and `S_v` in a box.
    pub(crate) fn speeds(&self, low: [f64; 2], high: [f64; 2]) -> [f64; 2] {
        self.over(low, high).fold([0.0; 2], |most, cell| [0, 1].map(|d: usize| most[d].max(cell.first[d])))
    }

    /// About how long `S_u` and `S_v` are in a box at most: the largest that some of its cells can have.
    pub(crate) fn speeds_of_some(&self, low: [f64; 2], high: [f64; 2]) -> [f64; 2] {
        let faster =
            |most: [f64; 2], (cell, _): (&Cell, f64)| [0, 1].map(|d: usize| most[d].max(cell.first[d]));
        self.some(low, high).fold([0.0; 2], faster)
    }

    /// Some cells of a box, spread over it, and how large they are in the plane of parameters.
    fn some(&self, low: [f64; 2], high: [f64; 2]) -> impl Iterator<Item = (&Cell, f64)> {
        let (rows, columns) = (self.range(0, low[0], high[0]), self.range(1, low[1], high[1]));
        let [down, across] = [rows.len(), columns.len()].map(|count| count.div_ceil(SAMPLES));
        let columns = columns.skip(across / 2).step_by(across);
        let length = |d: usize, k: usize| self.breaks[d][k + 1] - self.breaks[d][k];
        let one = move |i: usize, j: usize| (self.cell(i, j), length(0, i) * length(1, j));
        rows.skip(down / 2).step_by(down).flat_map(move |i| columns.clone().map(move |j| one(i, j)))
    }

    /// How large `S_uu`, `S_uv` and `S_vv` are on average over some cells of a box: constant ones of which as many steps would be needed, and of these there are
    /// in each cell its length times the root. However much a surface bends within a short span, that is few.
    pub(crate) fn mean(&self, low: [f64; 2], high: [f64; 2]) -> [f64; 3] {
        let (mut sum, mut all) = ([0.0; 3], 0.0);
        for (cell, size) in self.some(low, high) {
            (0..3).for_each(|k| sum[k] += size * cell.second[k].most().sqrt());
            all += size;
        }
        sum.map(|s| (s / all) * (s / all))
    }

    /// Parameters of points of the surface near to a point, the nearest first.
    pub(crate) fn near(&self, point: &Vector) -> Vec<[f64; 2]> {
        // A few places of each patch will do.
        let columns = self.columns();
        let step = [0, 1].map(|d: usize| self.parts[d].div_ceil(NEAR));
        let rows = (0..self.cells.len() / columns).skip(step[0] / 2).step_by(step[0]);
        let places = rows.flat_map(|i| (0..columns).skip(step[1] / 2).step_by(step[1]).map(move |j| (i, j)));
        let mut best: Vec<(f64, usize)> = places
            .map(|(i, j)| {
                let (patch, low, high) = self.place(i, j);
                let at = [0, 1].map(|d: usize| 0.5 * (low[d] + high[d]));
                ((patch.point(at) - point).norm_squared(), i * columns + j)
            })
            .collect();
        let order = |a: &(f64, usize), b: &(f64, usize)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
        let most = 4.min(best.len());
        if most < best.len() {
            best.select_nth_unstable_by(most, order);
        }
        best.truncate(most);
        best.sort_by(order);
        let middle = |d: usize, k: usize| 0.5 * (self.breaks[d][k] + self.breaks[d][k + 1]);
        best.into_iter().map(|(_, k)| [middle(0, k / columns), middle(1, k % columns)]).collect()
    }
}

/// What the second derivatives of a surface can be over some box.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Spread {
    second: [Span; 3],
}

impl Spread {
    /// The largest lengths of `S_uu`, `S_uv`, `S_vv`.
    pub(crate) fn most(&self) -> [f64; 3] {
        [0, 1, 2].map(|k: usize| self.second[k].most())
    }

    /// How far a surface can be at most from its linear interpolation over any triangle (or segment) of parameters whose box has
    /// these sides, at equal parameters: `(|S_uu| h² + 2 |S_uv| h k + |S_vv| k²) / 8`, since the variance of what lies within
    /// `h` is at most `h²/4`.
    pub(crate) fn whole(&self, [h, k]: [f64; 2]) -> f64 {
        let [uu, uv, vv] = self.most();
        0.125 * (uu * h * h + 2.0 * uv * h * k + vv * k * k)
    }

    /// What the second derivatives of the distance along a unit normal can be.
    pub(crate) fn across(&self, normal: &Vector) -> Ranges {
        let [uu, uv, vv] = self.second.map(|span| {
            let (middle, half) = ((span.high + span.low) * 0.5, (span.high - span.low) * 0.5);
            [normal.dot(&middle), normal.abs().dot(&half)]
        });
        Ranges::new(uu, uv, vv)
    }
}

/// The box of a net's points, and the least and the largest of its weights.
fn hull(net: &[Homogeneous]) -> (Span, [f64; 2]) {
    let Some(&first) = net.first() else { return (Span::ZERO, [0.0; 2]) };
    let (mut low, mut high) = (first, first);
    for h in net {
        for l in 0..4 {
            (low[l], high[l]) = (less(low[l], h[l]), more(high[l], h[l]));
        }
    }
    (Span { low: xyz(&low), high: xyz(&high) }, [low[3], high[3]])
}

/// What the second derivatives can be over boxes of patches, from their own Bézier points: `(patch, low, high, sides)` each, as
/// [`cell`] takes them.
pub(crate) fn exactly<'p>(boxes: impl Iterator<Item = (&'p Patch, [f64; 2], [f64; 2], [f64; 2])>) -> Spread {
    let join = |a: [Span; 3], b: [Span; 3]| [a[0].join(b[0]), a[1].join(b[1]), a[2].join(b[2])];
    let second = boxes.map(|(patch, low, high, sides)| cell(patch, low, high, sides).second).reduce(join);
    Spread { second: second.unwrap_or([Span::ZERO; 3]) }
}

/// The derivatives over a box of a patch whose sides have these lengths as parameters of the surface.
///
/// All derivatives are nets of the patch's own degrees, so that they can be added point by point; their boxes are no larger for that.
fn cell(patch: &Patch, low: [f64; 2], high: [f64; 2], lengths: [f64; 2]) -> Cell {
    let size = [patch.rows, patch.columns];
    let mut net = Net::from_slice(&patch.net);
    restrict(&mut net, size[0], size[1], low, high);
    let middle = jet_of(&net, size, patch.rational, [0.5, 0.5]);
    for h in &mut net {
        (0..3).for_each(|l| h[l] -= middle.point[l] * h[3]);
    }
    let (along_u, along_v) = (derivative(&net, size, 0), derivative(&net, size, 1));
    let (uu, uv) = (derivative(&along_u, size, 0), derivative(&along_u, size, 1));
    let vv = derivative(&along_v, size, 1);
    let [(u, wu), (v, wv), (fuu, wuu), (fuv, wuv), (fvv, wvv)] =
        [&along_u, &along_v, &uu, &uv, &vv].map(|net| hull(net));
    let (mut first, mut second) = ([u, v], [fuu, fuv, fvv]);
    if patch.rational {
        let place = Span::of(net.iter().map(project));
        let (_, [light, heavy]) = hull(&net);
        let share = [1.0 / heavy, 1.0 / light];
        first = [u.minus(place.times(wu)).times(share), v.minus(place.times(wv)).times(share)];
        let (cu, cv) = (middle.u, middle.v);
        let off = |along: &Net, c: Vector| Span::of(along.iter().zip(&net).map(|(h, w)| xyz(h) - c * w[3]));
        let eu = off(&along_u, cu).minus(place.times(wu)).times(share);
        let ev = off(&along_v, cv).minus(place.times(wv)).times(share);
        let twice = |w: [f64; 2]| w.map(|w| 2.0 * w);
        let bend = |bend: &Net, along: &Net, c: Vector| {
            Span::of(bend.iter().zip(along).map(|(h, w)| xyz(h) - c * (2.0 * w[3])))
        };
        let twist = uv.iter().zip(&along_u).zip(&along_v);
        let twist = Span::of(twist.map(|((h, u), v)| xyz(h) - cv * u[3] - cu * v[3]));
        second = [
            bend(&uu, &along_u, cu).minus(eu.times(twice(wu))).minus(place.times(wuu)),
            twist.minus(eu.times(wv)).minus(ev.times(wu)).minus(place.times(wuv)),
            bend(&vv, &along_v, cv).minus(ev.times(twice(wv))).minus(place.times(wvv)),
        ]
        .map(|span| span.times(share));
    }
    let [u, v] = first;
    let [fuu, fuv, fvv] = second;
    let [h, k] = lengths.map(|length| 1.0 / length);
    let scaled = |span: Span, by: f64| Span { low: span.low * by, high: span.high * by };
    Cell {
        first: [u.most() * h, v.most() * k],
        second: [scaled(fuu, h * h), scaled(fuv, h * k), scaled(fvv, k * k)],
    }
}

/// The derivative of a net of `rows × columns` along `u` or `v`, in the same degrees: of degree `p` it is
/// `k (A_k - A_{k-1}) + (p - k) (A_{k+1} - A_k)`, which is `p (A_{k+1} - A_k)` raised by one.
fn derivative(net: &[Homogeneous], [rows, columns]: [usize; 2], direction: usize) -> Net {
    let (order, step) = if direction == 0 { (rows, columns) } else { (columns, 1) };
    let place = |index: usize| if direction == 0 { index / columns } else { index % columns };
    let slope = |index: usize| {
        let k = place(index);
        let (before, behind) = (k as f64, (order - 1 - k) as f64);
        let own = &net[index];
        let mut sum = [0.0; 4];
        if k > 0 {
            let other = &net[index - step];
            (0..4).for_each(|l| sum[l] = before * (own[l] - other[l]));
        }
        if k + 1 < order {
            let other = &net[index + step];
            (0..4).for_each(|l| sum[l] += behind * (other[l] - own[l]));
        }
        sum
    };
    (0..rows * columns).map(slope).collect()
}

#[cfg(test)]
mod tests {
    use loftsman_kernel::spline::{Curve, Surface};
    use loftsman_kernel::{Point, Vector};

    use super::*;
    use crate::fineness::Frame;
    use crate::patch::Patches;

    /// Derivatives at many places are in the boxes around them; on a cylinder the boxes say that it is straight.
    #[test]
    fn derivatives_are_where_they_are_said_to_be() {
        let arc = Curve::elliptic_arc(Point::origin(), Vector::x(), Vector::y() * 2.0, 0.1, 1.4).unwrap();
        let slanted = Curve::line(Point::new(1.0, 0.0, 0.0), Point::new(2.0, 0.0, 3.0)).unwrap();
        let surfaces = [
            Surface::extrusion(&arc, Vector::z() * 5.0).unwrap(),
            Surface::revolution(&slanted, Point::origin(), Vector::z(), 3.0).unwrap(),
            Surface::revolution(&arc, Point::new(5.0, 0.0, 0.0), Vector::y(), 2.0).unwrap(),
        ];
        for surface in surfaces {
            let of = Patches::new(&surface, &Frame::absolute());
            let [rows, columns] = of.counts();
            let patches: Vec<Patch> = (0..rows * columns).map(|k| of.get(k / columns, k % columns)).collect();
            let breaks = [surface.u().breakpoints(), surface.v().breakpoints()];
            let bounds = Bounds::new(patches.into(), &breaks);
            let ends = [surface.u().domain(), surface.v().domain()];
            for k in 0..20 {
                for l in 0..20 {
                    let at = [(ends[0], k), (ends[1], l)]
                        .map(|((a, b), k)| a + (b - a) * (f64::from(k) + 0.37) / 20.0);
                    let spread = bounds.spread(at, at);
                    for (span, [a, b]) in spread.second.iter().zip([[2, 0], [1, 1], [0, 2]]) {
                        let exact = surface.derivative(at[0], at[1], a, b).unwrap();
                        let slack = Vector::repeat(1e-9 * (1.0 + exact.norm()));
                        assert!(
                            (exact - span.low + slack).min() >= 0.0
                                && (span.high - exact + slack).min() >= 0.0
                        );
                    }
                }
            }
            let whole = bounds.spread([ends[0].0, ends[1].0], [ends[0].1, ends[1].1]).most();
            assert!(whole[2] < 1e-9 || surface.v().degree() > 1, "{whole:?}");
        }
    }
}
