//! The integrals of [`Flux`](crate::flux::Flux) over parts of a tensor-product spline, what loops leave of it among them: no rows are kept, only Gauss points.

use std::ops::Range;
use std::sync::Arc;

use loftsman_kernel::shape::{Cell, Location, Patch, Share};
use loftsman_kernel::spline::Space;
use loftsman_kernel::spline::gram::gauss_legendre;
use loftsman_kernel::{Point, Vector};

use crate::rule::Basis;

/// A spline that is a face of a shape, or this.
#[derive(Debug, PartialEq)]
pub(crate) struct Spline {
    u: Space,
    v: Space,
    weights: Option<Vec<f64>>,
    first: usize,
}

impl Spline {
    /// `None` of a curve, and where there are not as many weights as vertices.
    pub(crate) fn of(patch: &Patch<'_>) -> Option<Self> {
        let splines = patch.splines;
        let weights = splines.weights.map(<[f64]>::to_vec);
        let one = Self { u: splines.u.clone(), v: splines.v?.clone(), weights, first: patch.first };
        let count = one.vertices().len();
        one.weights.as_ref().is_none_or(|weights| weights.len() == count).then_some(one)
    }

    /// The numbers of its control vertices.
    pub(crate) fn vertices(&self) -> Range<usize> {
        self.first..self.first + self.u.len() * self.v.len()
    }

    /// Whether a cell is one of its own.
    pub(crate) fn has(&self, cell: &Cell) -> bool {
        self.spans(cell).is_some()
    }

    /// The span of each direction in which a cell lies, if it lies in one.
    fn spans(&self, cell: &Cell) -> Option<[usize; 2]> {
        let [along_u, along_v] = &cell.sides[..] else { return None };
        let span = |space: &Space, (a, b): (f64, f64)| {
            let span = space.span(0.5 * a + 0.5 * b);
            (space.flat().get(span)? <= &a && &b <= space.flat().get(span + 1)?).then_some(span)
        };
        Some([span(&self.u, (along_u.start, along_u.end))?, span(&self.v, (along_v.start, along_v.end))?])
    }

    /// Of the functions of two spans, the place of the control vertex of number `(i, j)` among its own.
    fn vertex(&self, [span_u, span_v]: [usize; 2], i: usize, j: usize) -> usize {
        let row = self.u.vertex(span_u - self.u.degree() + i);
        row * self.v.len() + self.v.vertex(span_v - self.v.degree() + j)
    }
}

/// Gauss points on a part of a spline, in lines along `u`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SpanFlux {
    spline: Arc<Spline>,
    pieces: Vec<Piece>,
    lines: Vec<Line>,
    /// Parameters along `u` and weights.
    points: Vec<(f64, f64)>,
}

/// The points in one product of spans.
#[derive(Debug, Clone, PartialEq)]
struct Piece {
    spans: [usize; 2],
    lines: Range<usize>,
}

/// Points of one `v`; lines may have the same ones.
#[derive(Debug, Clone, PartialEq)]
struct Line {
    v: f64,
    weight: f64,
    points: Range<usize>,
}

/// What an integration works with.
#[derive(Debug, Default)]
pub(crate) struct Room {
    u: Basis,
    v: Basis,
    /// Homogeneous points, `q + 1` for each function along `u`.
    net: Vec<[f64; 4]>,
    /// The functions along `u` and their slopes at each point of a line, `p + 1` of each.
    along: Vec<f64>,
    /// For each function along `u` the homogeneous point on a line, and its derivative by `v`.
    across: Vec<[[f64; 4]; 2]>,
    /// For each function along `u` what a line adds to it, for each `h`.
    sums: Vec<[[f64; 3]; 4]>,
}

impl SpanFlux {
    /// So many points, which depend on the degree, on each of `parts` parts in either direction of what counts of each cell, times a sense.
    pub(crate) fn with(
        spline: &Arc<Spline>,
        cells: &[&(Cell, Share)],
        counts: impl Fn(usize) -> usize,
        parts: usize,
        sense: f64,
    ) -> Self {
        let (spline, parts) = (Arc::clone(spline), parts.max(1));
        let mut flux = Self { spline, pieces: Vec::new(), lines: Vec::new(), points: Vec::new() };
        for (cell, share) in cells {
            let (Some(spans), [along_u, along_v]) = (flux.spline.spans(cell), &cell.sides[..]) else {
                continue;
            };
            let per = [counts(along_u.degree), counts(along_v.degree)];
            let start = flux.lines.len();
            match share {
                Share::Nothing => {}
                Share::Whole => {
                    let own = nodes(along_u.start, along_u.end, per[0], parts);
                    let points = flux.points.len()..flux.points.len() + own.len();
                    flux.points.extend(own);
                    for (v, weight) in nodes(along_v.start, along_v.end, per[1], parts) {
                        flux.lines.push(Line { v, weight: weight * sense, points: points.clone() });
                    }
                }
                Share::Part(_) => {
                    for (at, weight) in share.gauss_points(cell, per, parts) {
                        let (Location::Surface(u, v) | Location::Face(_, u, v)) = at else { continue };
                        let end = flux.points.len();
                        flux.points.push((u, weight));
                        match flux.lines[start..].last_mut() {
                            Some(line) if line.v == v => line.points.end = end + 1,
                            _ => flux.lines.push(Line { v, weight: sense, points: end..end + 1 }),
                        }
                    }
                }
            }
            flux.pieces.push(Piece { spans, lines: start..flux.lines.len() });
        }
        flux
    }

    /// Adds `F_i` for each `h`, one for each of the spline's control vertices, which are `points`; coordinates are taken from `origin`.
    pub(crate) fn integrate(
        &self,
        points: &[Point],
        origin: &Point,
        room: &mut Room,
        out: &mut [Vec<Vector>],
    ) {
        for piece in &self.pieces {
            self.piece(piece, points, origin, out, room);
        }
    }

    fn piece(
        &self,
        piece: &Piece,
        points: &[Point],
        origin: &Point,
        out: &mut [Vec<Vector>],
        room: &mut Room,
    ) {
        let Spline { u, v, weights, .. } = &*self.spline;
        let (p, q) = (u.degree(), v.degree());
        let kinds = out.len().min(4);
        let weight = |own: usize| weights.as_ref().map_or(1.0, |weights| weights[own]);
        let Room { u: bu, v: bv, net, along, across, sums } = room;
        bu.enter(u, piece.spans[0]);
        bv.enter(v, piece.spans[1]);
        net.clear();
        for (i, j) in (0..=p).flat_map(|i| (0..=q).map(move |j| (i, j))) {
            let own = self.spline.vertex(piece.spans, i, j);
            let (from, w) = (points[own] - origin, weight(own));
            net.push([from.x * w, from.y * w, from.z * w, w]);
        }
        let mut known = 0..0;
        for line in &self.lines[piece.lines.clone()] {
            if line.points != known {
                known = line.points.clone();
                along.clear();
                for (at, _) in &self.points[known.clone()] {
                    bu.at(*at);
                    along.extend_from_slice(&bu.values[..=p]);
                    along.extend_from_slice(&bu.slopes[..=p]);
                }
            }
            bv.at(line.v);
            let (values_v, slopes_v) = (&bv.values[..=q], &bv.slopes[..=q]);
            across.clear();
            for row in net.chunks(q + 1) {
                let mut to = [[0.0; 4]; 2];
                for ((h, value), slope) in row.iter().zip(values_v).zip(slopes_v) {
                    for a in 0..4 {
                        to[0][a] += value * h[a];
                        to[1][a] += slope * h[a];
                    }
                }
                across.push(to);
            }
            sums.clear();
            sums.resize(p + 1, [[0.0; 3]; 4]);
            for ((_, weight), functions) in self.points[known.clone()].iter().zip(along.chunks(2 * p + 2)) {
                let (values, slopes) = functions.split_at(p + 1);
                let (mut s, mut su, mut sv) = ([0.0; 4], [0.0; 4], [0.0; 4]);
                for ((value, slope), across) in values.iter().zip(slopes).zip(across.iter()) {
                    for a in 0..4 {
                        s[a] += value * across[0][a];
                        su[a] += slope * across[0][a];
                        sv[a] += value * across[1][a];
                    }
                }
                let (point, normal) = projected(s, su, sv);
                // R_ij = w_ij N_i M_j / W: the weight of the vertex is put on at the end.
                let normal = normal.map(|n| n * weight * line.weight / s[3]);
                for (sums, value) in sums.iter_mut().zip(values) {
                    for (kind, sum) in sums.iter_mut().enumerate().take(kinds) {
                        let h = if kind == 0 { *value } else { value * point[kind - 1] };
                        (0..3).for_each(|a| sum[a] += h * normal[a]);
                    }
                }
            }
            for (i, sums) in sums.iter().enumerate() {
                for (j, value) in values_v.iter().enumerate() {
                    let own = self.spline.vertex(piece.spans, i, j);
                    let factor = value * weight(own);
                    for (out, sum) in out.iter_mut().zip(sums) {
                        out[own] += Vector::from(*sum) * factor;
                    }
                }
            }
        }
    }
}

/// Gauss–Legendre points with their weights, `per` on each of `parts` parts of an interval.
fn nodes(start: f64, end: f64, per: usize, parts: usize) -> Vec<(f64, f64)> {
    let (at, weights) = gauss_legendre(per.max(1));
    let step = (end - start) / parts as f64;
    let part = |k: usize| {
        let (at, weights) = (&at, &weights);
        let from = start + step * k as f64;
        at.iter().zip(weights).map(move |(x, w)| (from + step * x, w * step)).collect::<Vec<_>>()
    };
    (0..parts).flat_map(part).collect()
}

/// The point and `S_u × S_v`, from a homogeneous point and its derivatives.
fn projected(s: [f64; 4], su: [f64; 4], sv: [f64; 4]) -> ([f64; 3], [f64; 3]) {
    let w = s[3];
    let point = [0, 1, 2].map(|a| s[a] / w);
    let by = |d: [f64; 4]| [0, 1, 2].map(|a| (d[a] - point[a] * d[3]) / w);
    let (a, b) = (by(su), by(sv));
    (point, [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
}
