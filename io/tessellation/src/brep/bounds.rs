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

use crate::bezier::restrict;
use crate::form::Ranges;
use crate::patch::{Homogeneous, Patch, project};

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

    fn of(points: impl Iterator<Item = Vector>) -> Self {
        points
            .map(|p| Self { low: p, high: p })
            .reduce(|a, b| Self { low: a.low.inf(&b.low), high: a.high.sup(&b.high) })
            .unwrap_or(Self::ZERO)
    }

    fn minus(self, other: Self) -> Self {
        Self { low: self.low - other.high, high: self.high - other.low }
    }

    /// Times what lies between two numbers.
    fn times(self, [a, b]: [f64; 2]) -> Self {
        let all = [self.low * a, self.low * b, self.high * a, self.high * b];
        Self::of(all.into_iter())
    }

    fn most(&self) -> f64 {
        self.low.abs().sup(&self.high.abs()).norm()
    }

    fn join(self, other: Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }
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
        self.some(low, high).fold([0.0; 2], |most, cell| [0, 1].map(|d: usize| most[d].max(cell.first[d])))
    }

    /// Some cells of a box, spread over it.
    fn some(&self, low: [f64; 2], high: [f64; 2]) -> impl Iterator<Item = &Cell> {
        let (rows, columns) = (self.range(0, low[0], high[0]), self.range(1, low[1], high[1]));
        let [down, across] = [rows.len(), columns.len()].map(|count| count.div_ceil(SAMPLES));
        let columns = columns.skip(across / 2).step_by(across);
        rows.skip(down / 2).step_by(down).flat_map(move |i| columns.clone().map(move |j| self.cell(i, j)))
    }

    /// The means over some cells of a box of how large `S_uu`, `S_uv` and `S_vv` can be.
    pub(crate) fn mean(&self, low: [f64; 2], high: [f64; 2]) -> [f64; 3] {
        let (mut sum, mut count) = ([0.0; 3], 0.0);
        for cell in self.some(low, high) {
            (0..3).for_each(|k| sum[k] += cell.second[k].most());
            count += 1.0;
        }
        sum.map(|s| s / count)
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
    let span = Span::of(net.iter().map(|h| Vector::new(h[0], h[1], h[2])));
    let weight = net.iter().fold(None, |range: Option<[f64; 2]>, h| {
        let [low, high] = range.unwrap_or([h[3]; 2]);
        Some([low.min(h[3]), high.max(h[3])])
    });
    (span, weight.unwrap_or([0.0; 2]))
}

/// What the second derivatives can be over boxes of patches, from their own Bézier points: `(patch, low, high, sides)` each, as
/// [`cell`] takes them.
pub(crate) fn exactly<'p>(boxes: impl Iterator<Item = (&'p Patch, [f64; 2], [f64; 2], [f64; 2])>) -> Spread {
    let join = |a: [Span; 3], b: [Span; 3]| [a[0].join(b[0]), a[1].join(b[1]), a[2].join(b[2])];
    let second = boxes.map(|(patch, low, high, sides)| cell(patch, low, high, sides).second).reduce(join);
    Spread { second: second.unwrap_or([Span::ZERO; 3]) }
}

/// The derivatives over a box of a patch whose sides have these lengths as parameters of the surface.
fn cell(patch: &Patch, low: [f64; 2], high: [f64; 2], lengths: [f64; 2]) -> Cell {
    let (p, q) = (patch.rows, patch.columns);
    let mut net = patch.net.clone();
    restrict(&mut net, p, q, low, high);
    let mut part = Patch::new(net, p, q, patch.rational);
    let point = part.point([0.5, 0.5]);
    for h in &mut part.net {
        (0..3).for_each(|l| h[l] -= point[l] * h[3]);
    }
    let (degree_u, degree_v) = (p as f64 - 1.0, q as f64 - 1.0);
    let step =
        |factor: f64, a: &Homogeneous, b: &Homogeneous| [0, 1, 2, 3].map(|l: usize| factor * (b[l] - a[l]));
    let along_u: Net =
        part.net.iter().zip(part.net.iter().skip(q)).map(|(a, b)| step(degree_u, a, b)).collect();
    let along_v: Net = part
        .net
        .chunks_exact(q)
        .flat_map(|row| row.windows(2).map(|h| step(degree_v, &h[0], &h[1])))
        .collect();
    let (mut uu, mut uv, mut vv) = (Net::new(), Net::new(), Net::new());
    part.uu(&mut uu);
    part.uv(&mut uv);
    part.vv(&mut vv);
    let sizes = [[p - 1, q], [p, q - 1], [p.saturating_sub(2), q], [p - 1, q - 1], [p, q.saturating_sub(2)]];
    let [one, two, three, four, five] = sizes;
    let nets = [(along_u, one), (along_v, two), (uu, three), (uv, four), (vv, five)];
    let [(u, wu), (v, wv), (uu, wuu), (uv, wuv), (vv, wvv)]: [(Span, [f64; 2]); 5] =
        { nets.each_ref().map(|(net, _)| hull(net)) };
    let (mut first, mut second) = ([u, v], [uu, uv, vv]);
    if part.rational {
        let place = Span::of(part.net.iter().map(project));
        let (_, [light, heavy]) = hull(&part.net);
        let share = [1.0 / heavy, 1.0 / light];
        first = [u.minus(place.times(wu)).times(share), v.minus(place.times(wv)).times(share)];
        // All in the degrees of the patch, so that they can be added point by point.
        let full = nets.map(|(net, size)| raised(net, size, [p, q]));
        let jet = part.jet([0.5, 0.5]);
        let [cu, cv] = [jet.u, jet.v];
        let off = |net: usize, c: Vector| {
            let points = full[net].iter().zip(&part.net);
            Span::of(points.map(|(h, w)| Vector::new(h[0], h[1], h[2]) - c * w[3]))
        };
        let eu = off(0, cu).minus(place.times(wu)).times(share);
        let ev = off(1, cv).minus(place.times(wv)).times(share);
        let linear = |of: usize, terms: [(usize, Vector); 2]| {
            Span::of((0..p * q).map(|k| {
                let lift = |net: usize| Vector::new(full[net][k][0], full[net][k][1], full[net][k][2]);
                terms.iter().fold(lift(of), |sum, (net, c)| sum - c * full[*net][k][3])
            }))
        };
        let twice = |w: [f64; 2]| w.map(|w| 2.0 * w);
        let none = Vector::zeros();
        second = [
            linear(2, [(0, cu * 2.0), (0, none)]).minus(eu.times(twice(wu))).minus(place.times(wuu)),
            linear(3, [(0, cv), (1, cu)]).minus(eu.times(wv)).minus(ev.times(wu)).minus(place.times(wuv)),
            linear(4, [(1, cv * 2.0), (1, none)]).minus(ev.times(twice(wv))).minus(place.times(wvv)),
        ]
        .map(|span| span.times(share));
    }
    let [u, v] = first;
    let [uu, uv, vv] = second;
    let [h, k] = lengths.map(|length| 1.0 / length);
    let scaled = |span: Span, by: f64| span.times([by, by]);
    Cell {
        first: [u.most() * h, v.most() * k],
        second: [scaled(uu, h * h), scaled(uv, h * k), scaled(vv, k * k)],
    }
}

/// A net of `rows × columns` in other degrees, which are not lower.
fn raised(mut net: Net, [mut rows, mut columns]: [usize; 2], to: [usize; 2]) -> Net {
    if net.is_empty() {
        return Net::from_elem([0.0; 4], to[0] * to[1]);
    }
    let mix = |a: &Homogeneous, b: &Homogeneous, share: f64| {
        [0, 1, 2, 3].map(|l: usize| a[l] * share + b[l] * (1.0 - share))
    };
    while rows < to[0] {
        let line = |i: usize, j: usize| {
            let share = i as f64 / rows as f64;
            let of = |i: usize| &net[i.min(rows - 1) * columns + j];
            mix(of(i.saturating_sub(1)), of(i), share)
        };
        net = (0..=rows).flat_map(|i| (0..columns).map(move |j| (i, j))).map(|(i, j)| line(i, j)).collect();
        rows += 1;
    }
    while columns < to[1] {
        let line = |i: usize, j: usize| {
            let share = j as f64 / columns as f64;
            let of = |j: usize| &net[i * columns + j.min(columns - 1)];
            mix(of(j.saturating_sub(1)), of(j), share)
        };
        net = (0..rows).flat_map(|i| (0..=columns).map(move |j| (i, j))).map(|(i, j)| line(i, j)).collect();
        columns += 1;
    }
    net
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
