//! The closest point of a curve or a surface to a given point: the global one, not a neighbouring minimum.
//!
//! Branch and bound. Every span starts with the distance to the box of its control vertices as a bound from below;
//! the span with the least bound is taken first, in Bézier form. With `D = A - W Q` (homogeneous, measured from the
//! given point `Q`) a piece is done when
//! * all Bernstein coefficients of `D·D - r² W²` are at least 0 (`r` is the best distance, less the tolerance): by
//!   the convex hull property nothing on the piece is closer. This settles circles around their centre at once;
//! * (curves) the coefficients of `(D·D)' W - (D·D) W'`, the sign of the distance's slope, change sign at most once:
//!   then so does the slope, and the ends or one bracketed root hold the minimum.
//!
//! Otherwise it is halved. Variation diminishing: Farin, *Curves and Surfaces for CAGD*, 5th ed., ch. 6.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::piece::{bezier, bezier_patch, halves, halves_of_rows};
use super::{Curve, Space, Surface, binomial};
use crate::error::{Error, Result};
use crate::{Point, Vector};

/// Nothing closer than this much of the distance is missed, relative to the distance …
const RELATIVE: f64 = 1e-10;
/// … and to the size of the shape seen from the point.
const ABSOLUTE: f64 = 1e-13;
/// Pieces looked at before the search stops with what it has.
const PIECES: usize = 200_000;
/// As many where only a part of the surface counts, which costs more to ask.
const KEPT_PIECES: usize = 20_000;
/// The part of a surface's sides below which pieces that count in part are no longer halved: within them nothing is nearer than the border that
/// they hold by more than the square of it.
const FINE: f64 = 1.0 / 2048.0;

/// The part of a surface that counts.
pub(crate) trait Kept {
    /// Whether a place does.
    fn has(&self, at: [f64; 2]) -> bool;
    /// Whether all places of a box do, or none; `None` where its border runs through the box.
    fn share(&self, sides: [(f64, f64); 2]) -> Option<bool>;
}

/// The closest point that was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Closest<L> {
    /// Where on the shape: `u`, or `(u, v)`.
    pub at: L,
    /// The point there.
    pub point: Point,
    /// Its distance.
    pub distance: f64,
    /// No point of the shape is closer than `distance - gap`. As a rule `1e-10 distance + 1e-13 size`, with the
    /// extent of the shape as seen from the point as size; more only where a search of 200,000 pieces was not enough.
    pub gap: f64,
}

/// A closest point among those around it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Foot {
    /// Its parameters.
    pub at: (f64, f64),
    /// The point there.
    pub point: Point,
    /// Its distance.
    pub distance: f64,
}

type Homogeneous = [f64; 4];

/// A piece of a shape in Bézier form around the given point, and the parameters it covers.
struct Piece {
    bound: f64,
    order: usize,
    u: (f64, f64),
    v: (f64, f64),
    net: Vec<Homogeneous>,
    /// How far, about, one step of the parameters' last digit goes, where that is more than rounding: its bound is larger by so much than the piece.
    resolution: f64,
    /// The spans of a piece that is not yet in Bézier form.
    spans: (usize, usize),
}

impl PartialEq for Piece {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Piece {}
impl PartialOrd for Piece {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Piece {
    /// The least bound is the greatest piece; of equal ones the first made, so that the answer is always the same.
    fn cmp(&self, other: &Self) -> Ordering {
        other.bound.total_cmp(&self.bound).then(other.order.cmp(&self.order))
    }
}

impl Curve {
    /// The point of the curve closest to `point`, over the whole curve. Where several are equally close, the same
    /// one is given every time. `O(n)` for the boxes of the spans, then the few spans that come near.
    ///
    /// Coordinates whose squares overflow or vanish are scaled by a power of two first, and the distance is scaled back.
    ///
    /// # Errors
    /// When `point` is not finite, or the distance is no number.
    pub fn closest(&self, point: Point) -> Result<Closest<f64>> {
        check(point)?;
        if let Some(factor) = factor_for_squares(self.points(), point) {
            let weights = self.weights().map(<[f64]>::to_vec);
            let scaled = Self::build(self.space().clone(), times(self.points(), factor), weights)?;
            return scaled.closest(point * factor)?.scaled_back(factor, |u| self.point(u));
        }
        let (space, p) = (self.space(), self.degree());
        let vertex = |k: usize| homogeneous(self.points(), self.weights(), space.vertex(k), point);
        let mut size = 0.0_f64;
        let mut pieces = Vec::with_capacity(space.len());
        for span in space.spans() {
            let (bound, far) =
                box_distance((span - p..=span).map(|k| self.points()[space.vertex(k)] - point));
            size = size.max(far);
            let u = (space.flat()[span], end_of(space, span));
            pieces.push(Piece {
                bound,
                order: span,
                u,
                v: u,
                net: Vec::new(),
                resolution: 0.0,
                spans: (span, 0),
            });
        }
        let mut best = Best::new(space.domain().0, size);
        let evaluate = |u: f64| self.point(u).map(|c| (c, (c - point).norm()));
        let mut heap = BinaryHeap::from(pieces);
        let mut count = 0;
        while let Some(mut piece) = heap.pop() {
            if piece.bound >= best.enough() || count >= PIECES {
                best.open = piece.bound;
                break;
            }
            count += 1;
            if piece.net.is_empty() {
                let span = piece.spans.0;
                piece.net = bezier(space, span, &(0..=p).map(|j| vertex(span - p + j)).collect::<Vec<_>>());
                for u in [piece.u.0, piece.u.1] {
                    best.offer(u, evaluate(u)?);
                }
            }
            let (squares, weights) = (squared(&piece.net), squared_weights(&piece.net));
            if nothing_closer(&squares, &weights, best.enough()) {
                continue;
            }
            let slope = slope(&squares, &piece.net);
            let changes = sign_changes(&slope);
            let (a, b) = piece.u;
            if changes == 0 {
                continue;
            }
            if changes == 1 {
                // From closer to farther is a maximum: the ends were offered. Otherwise one minimum, bracketed.
                if slope.iter().find(|s| **s != 0.0).is_some_and(|s| *s < 0.0) {
                    let u = self.descend(point, a, b)?;
                    best.offer(u, evaluate(u)?);
                }
                continue;
            }
            let middle = 0.5 * a + 0.5 * b;
            if !(a < middle && middle < b) {
                continue;
            }
            best.offer(middle, evaluate(middle)?);
            for (u, net) in [(a, middle), (middle, b)].into_iter().zip(halves(&piece.net, p + 1, 1)) {
                let bound = net_bound(&net).max(piece.bound);
                heap.push(Piece {
                    bound,
                    order: space.flat().len() + 2 * count,
                    u,
                    v: u,
                    net,
                    resolution: 0.0,
                    spans: (0, 0),
                });
            }
        }
        Ok(best.answer())
    }

    /// The root of `(C - Q)·C'` in `[a, b]`, which it passes from negative to positive: Newton's method in a bracket.
    fn descend(&self, point: Point, a: f64, b: f64) -> Result<f64> {
        let (mut low, mut high) = (a, b);
        let mut u = 0.5 * a + 0.5 * b;
        let mut d = [Vector::zeros(); 3];
        for _ in 0..100 {
            self.derivatives_into(u, &mut d)?;
            let away = d[0] - point.coords;
            let value = away.dot(&d[1]);
            if value == 0.0 {
                return Ok(u);
            }
            if value < 0.0 {
                low = u;
            } else {
                high = u;
            }
            let newton = u - value / (d[1].dot(&d[1]) + away.dot(&d[2]));
            let next = if newton > low && newton < high { newton } else { 0.5 * low + 0.5 * high };
            let small = 2.0 * f64::EPSILON * u.abs().max(b - a);
            if (next - u).abs() <= small {
                return Ok(next);
            }
            u = next;
        }
        Ok(u)
    }
}

impl Surface {
    /// The point of the surface closest to `point`, over the whole surface, as [`Curve::closest`].
    ///
    /// # Errors
    /// When `point` is not finite, or the distance is no number.
    pub fn closest(&self, point: Point) -> Result<Closest<(f64, f64)>> {
        self.nearly_closest(point, 0.0, 0.0)
    }

    /// A point of the surface that no other one is nearer than by more than `absolute` and the part `relative` of its distance: what is enough
    /// where it matters how far off a point is, but not which of many places that are about as near is the nearest. On a surface that is a
    /// circle around the point, but for a little, [`closest`](Self::closest) tells some hundred thousand pieces apart; this takes one of them.
    ///
    /// # Errors
    /// As for [`closest`](Self::closest).
    pub fn nearly_closest(&self, point: Point, absolute: f64, relative: f64) -> Result<Closest<(f64, f64)>> {
        Ok(self.search(point, (absolute, relative), None)?.0)
    }

    /// The closest point of the part of the surface that counts, to be better than a `start` (the nearest of the part's border): pieces that count
    /// in part are halved until they are a 2000th of the surface wide, where what is inside is no nearer, but for rounding, than the border.
    ///
    /// # Errors
    /// As for [`closest`](Self::closest).
    pub(crate) fn closest_kept(
        &self,
        point: Point,
        kept: &dyn Kept,
        start: (f64, f64),
    ) -> Result<Closest<(f64, f64)>> {
        Ok(self.search(point, (0.0, 0.0), Some((kept, start)))?.0)
    }

    /// The closest point, and how many pieces were looked at.
    ///
    /// Where a span is so short that its parameters' last digit is a way that matters (1e-9 at 1000), no parameter may stand for the nearest point: nothing nearer
    /// by less than such a step is looked for there, and the gap says so.
    fn search(
        &self,
        point: Point,
        slack: (f64, f64),
        kept: Option<(&dyn Kept, (f64, f64))>,
    ) -> Result<(Closest<(f64, f64)>, usize)> {
        check(point)?;
        if let Some(factor) = factor_for_squares(self.points(), point) {
            let weights = self.weights().map(<[f64]>::to_vec);
            let points = times(self.points(), factor);
            let scaled = Self::build(self.u().clone(), self.v().clone(), points, weights)?;
            let (found, count) = scaled.search(point * factor, (slack.0 * factor, slack.1), kept)?;
            return Ok((found.scaled_back(factor, |(u, v)| self.point(u, v))?, count));
        }
        let (su, sv) = (self.u(), self.v());
        let (p, q) = (su.degree(), sv.degree());
        let index = |i: usize, j: usize| su.vertex(i) * sv.len() + sv.vertex(j);
        let mut size = 0.0_f64;
        let mut pieces = Vec::new();
        for i in su.spans() {
            for j in sv.spans() {
                let block = (i - p..=i).flat_map(|r| (j - q..=j).map(move |c| (r, c)));
                let (bound, far) = box_distance(block.map(|(r, c)| self.points()[index(r, c)] - point));
                size = size.max(far);
                let (u, v) = ((su.flat()[i], end_of(su, i)), (sv.flat()[j], end_of(sv, j)));
                pieces.push(Piece {
                    bound,
                    order: pieces.len(),
                    u,
                    v,
                    net: Vec::new(),
                    resolution: 0.0,
                    spans: (i, j),
                });
            }
        }
        let first = pieces.len();
        let mut best = Best::new((su.domain().0, sv.domain().0), size);
        best.slack = slack;
        let evaluate = |at: (f64, f64)| self.point(at.0, at.1).map(|c| (c, (c - point).norm()));
        if let Some((_, start)) = kept {
            best.offer(start, evaluate(start)?);
        }
        let kept = kept.map(|(kept, _)| kept);
        let counts = |at: (f64, f64)| kept.is_none_or(|kept| kept.has([at.0, at.1]));
        let most = if kept.is_some() { KEPT_PIECES } else { PIECES };
        let fine = [su, sv].map(|space| FINE * (space.domain().1 - space.domain().0));
        let mut heap = BinaryHeap::from(pieces);
        let mut count = 0;
        while let Some(mut piece) = heap.pop() {
            if piece.bound >= best.enough() || count >= most {
                let left = heap.iter().map(|other| other.bound - other.resolution);
                best.open = left.fold(best.open.min(piece.bound - piece.resolution), f64::min);
                break;
            }
            count += 1;
            let share = kept.map_or(Some(true), |kept| kept.share([piece.u, piece.v]));
            if share == Some(false) {
                continue;
            }
            let inside = |at: (f64, f64)| share == Some(true) || counts(at);
            if piece.net.is_empty() {
                let (i, j) = piece.spans;
                let net: Vec<_> = (i - p..=i)
                    .flat_map(|r| (j - q..=j).map(move |c| (r, c)))
                    .map(|(r, c)| homogeneous(self.points(), self.weights(), index(r, c), point))
                    .collect();
                piece.net = bezier_patch(su, sv, (i, j), net);
                let steps = [
                    step_of(piece.u, p) * extent(&piece.net, q + 1, 1),
                    step_of(piece.v, q) * extent(&piece.net, 1, q + 1),
                ];
                let step = steps[0] + steps[1];
                if step > ABSOLUTE * size {
                    piece.resolution = step;
                    piece.bound += step;
                }
            }
            let (columns, rows) = (q + 1, p + 1);
            let resolution = piece.resolution;
            let worth = |best: &Best<_>| (best.enough() - resolution).max(0.0);
            let squares = product(&piece.net, rows, columns, |a, b| a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
            let weights = product(&piece.net, rows, columns, |a, b| a[3] * b[3]);
            if nothing_closer(&squares, &weights, worth(&best)) {
                if resolution > 0.0 {
                    best.open = best.open.min(worth(&best));
                }
                continue;
            }
            // Corners too: towards a closest point on the surface's edge, middles would come closer only slowly, and
            // ever more pieces along the edge would seem worth a look.
            let last = squares.len() - 1;
            for (at, corner) in [
                ((piece.u.0, piece.v.0), 0),
                ((piece.u.0, piece.v.1), 2 * q),
                ((piece.u.1, piece.v.0), last - 2 * q),
                ((piece.u.1, piece.v.1), last),
            ] {
                if (squares[corner] / weights[corner]).sqrt() < best.distance && inside(at) {
                    best.offer(at, evaluate(at)?);
                }
            }
            let middle = (0.5 * piece.u.0 + 0.5 * piece.u.1, 0.5 * piece.v.0 + 0.5 * piece.v.1);
            let there = evaluate(middle)?;
            if best.distance >= there.1 {
                if inside(middle) {
                    best.offer(middle, there);
                }
                let at = self.approach(point, middle)?;
                if counts(at) {
                    best.offer(at, evaluate(at)?);
                }
            }
            let [wide, high] = [piece.u, piece.v].map(|side| side.1 - side.0);
            if share.is_none() && wide <= fine[0] && high <= fine[1] {
                continue;
            }
            if nothing_closer(&squares, &weights, worth(&best)) {
                if resolution > 0.0 {
                    best.open = best.open.min(worth(&best));
                }
                continue;
            }
            let splits_u = piece.u.0 < middle.0 && middle.0 < piece.u.1;
            let splits_v = piece.v.0 < middle.1 && middle.1 < piece.v.1;
            if !splits_u && !splits_v {
                best.open = best.open.min(piece.bound - resolution);
                continue;
            }
            // The longer way across the net is halved: pieces stay about as long as wide.
            let along_u =
                splits_u && (!splits_v || extent(&piece.net, columns, 1) >= extent(&piece.net, 1, columns));
            let nets =
                if along_u { halves(&piece.net, rows, columns) } else { halves_of_rows(&piece.net, columns) };
            for (half, net) in nets.into_iter().enumerate() {
                let pick = |r: (f64, f64), m: f64| if half == 0 { (r.0, m) } else { (m, r.1) };
                let (u, v) = if along_u {
                    (pick(piece.u, middle.0), piece.v)
                } else {
                    (piece.u, pick(piece.v, middle.1))
                };
                let bound = (net_bound(&net) + resolution).max(piece.bound);
                let order = first + 2 * count + half;
                heap.push(Piece { bound, order, u, v, net, resolution, spans: (0, 0) });
            }
        }
        Ok((best.answer(), count))
    }

    /// Newton's method on the squared distance from a start, damped so that it only ever comes closer, within the
    /// domain. It makes the best distance good early; what it misses, the subdivision finds.
    fn approach(&self, point: Point, start: (f64, f64)) -> Result<(f64, f64)> {
        let (du, dv) = (self.u().domain(), self.v().domain());
        let (mut at, mut away) = (start, self.point(start.0, start.1)? - point);
        let mut jet = [Vector::zeros(); 9];
        for _ in 0..30 {
            self.derivatives_into(at.0, at.1, [2, 2], &mut jet)?;
            let [_, sv, svv, su, suv, _, suu, ..] = jet;
            let (gu, gv) = (away.dot(&su), away.dot(&sv));
            let (mut a, mut b, mut c) =
                (su.dot(&su) + away.dot(&suu), su.dot(&sv) + away.dot(&suv), sv.dot(&sv) + away.dot(&svv));
            if a * c - b * b <= 0.0 || a <= 0.0 {
                // Not convex here: the Gauss–Newton matrix always points downhill.
                (a, b, c) = (su.dot(&su), su.dot(&sv), sv.dot(&sv));
            }
            let determinant = a * c - b * b;
            let step = ((b * gv - c * gu) / determinant, (b * gu - a * gv) / determinant);
            if !(step.0.is_finite() && step.1.is_finite()) {
                break;
            }
            let mut factor = 1.0;
            let mut moved = false;
            while factor > 1e-3 {
                let next =
                    ((at.0 + factor * step.0).clamp(du.0, du.1), (at.1 + factor * step.1).clamp(dv.0, dv.1));
                let now = self.point(next.0, next.1)? - point;
                if now.norm_squared() < away.norm_squared() {
                    (at, away, moved) = (next, now, true);
                    break;
                }
                factor *= 0.25;
            }
            if !moved {
                break;
            }
        }
        Ok(at)
    }
}

/// The last digit of a span's parameters, as a part of the span, and as many times as a piece of a degree may be quicker than on average.
fn step_of((a, b): (f64, f64), degree: usize) -> f64 {
    degree as f64 * f64::EPSILON * a.abs().max(b.abs()) / (b - a)
}

/// Where a span ends. Where the shape is torn there, its value at the knot is that of what follows: the number before the knot
/// stands for the end of this span.
fn end_of(space: &Space, span: usize) -> f64 {
    let end = space.flat()[span + 1];
    let inside = space.is_periodic() || end < space.domain().1;
    if inside && space.multiplicity(end) > space.degree() { end.next_down() } else { end }
}

/// The best point so far.
struct Best<L> {
    at: L,
    point: Point,
    distance: f64,
    size: f64,
    /// What was left open: nothing below this bound was missed.
    open: f64,
    /// By how much less, and by what part, would not be worth finding, if that is more than rounding.
    slack: (f64, f64),
}

impl<L: Copy> Best<L> {
    fn new(at: L, size: f64) -> Self {
        Self {
            at,
            point: Point::origin(),
            distance: f64::INFINITY,
            size,
            open: f64::INFINITY,
            slack: (0.0, 0.0),
        }
    }

    fn offer(&mut self, at: L, (point, distance): (Point, f64)) {
        if distance < self.distance {
            (self.at, self.point, self.distance) = (at, point, distance);
        }
    }

    /// The distance below which a point would be worth finding.
    fn enough(&self) -> f64 {
        let (absolute, relative) = self.slack;
        let relative = relative.max(RELATIVE);
        (self.distance * (1.0 - relative) - absolute.max(ABSOLUTE * self.size)).max(0.0)
    }

    fn answer(self) -> Closest<L> {
        let gap = self.distance - self.enough().min(self.open);
        Closest { at: self.at, point: self.point, distance: self.distance, gap }
    }
}

impl<L: Copy> Closest<L> {
    /// What was found of a shape that was scaled, said of the shape.
    fn scaled_back(self, factor: f64, point: impl Fn(L) -> Result<Point>) -> Result<Self> {
        let (distance, gap) = (self.distance / factor, self.gap / factor);
        if !distance.is_finite() {
            return Err(Error::Invalid(
                "the distance to the point is larger than any number: scale both down".into(),
            ));
        }
        Ok(Self { at: self.at, point: point(self.at)?, distance, gap })
    }
}

/// Sizes between which fourth powers (determinants of squares), and products of squares with weights, neither overflow nor vanish.
const SQUARES: std::ops::RangeInclusive<f64> = 1e-60..=1e60;

/// The power of two that brings points, seen from a place, to a size near 1; none where their squares are numbers as they are.
fn factor_for_squares(points: &[Point], from: Point) -> Option<f64> {
    // Halves, so that no difference overflows.
    let far = |p: &Point| (p.coords * 0.5 - from.coords * 0.5).amax();
    let reach = points.iter().map(far).fold(0.0, f64::max);
    // What is much larger than the shape would still overflow when it is squared.
    let size = points.iter().chain([&from]).map(|p| p.coords.amax()).fold(reach, f64::max);
    let power = |size: f64| 2.0_f64.powi((-size.log2().ceil()).clamp(-1022.0, 1022.0) as i32);
    if size > *SQUARES.end() {
        return Some(power(size));
    }
    // What is small and lies far out stays where it is: nothing of it is to overflow.
    let small = reach > 0.0 && reach < *SQUARES.start();
    Some(power(reach)).filter(|factor| small && size * factor <= *SQUARES.end())
}

fn times(points: &[Point], factor: f64) -> Vec<Point> {
    points.iter().map(|p| p * factor).collect()
}

fn check(point: Point) -> Result<()> {
    if point.iter().all(|c| c.is_finite()) {
        return Ok(());
    }
    let Point { coords } = point;
    Err(Error::Invalid(format!("the point ({}, {}, {}) must be finite", coords.x, coords.y, coords.z)))
}

fn homogeneous(points: &[Point], weights: Option<&[f64]>, i: usize, from: Point) -> Homogeneous {
    let (d, w) = (points[i] - from, weights.map_or(1.0, |w| w[i]));
    [d.x * w, d.y * w, d.z * w, w]
}

/// Distance from the origin to the box of these vectors, and the largest coordinate among them.
fn box_distance(vectors: impl Iterator<Item = Vector>) -> (f64, f64) {
    let (mut low, mut high) = (Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY));
    for v in vectors {
        (low, high) = (low.inf(&v), high.sup(&v));
    }
    let outside = low.sup(&-high).sup(&Vector::zeros());
    (outside.norm(), low.amax().max(high.amax()))
}

fn net_bound(net: &[Homogeneous]) -> f64 {
    box_distance(net.iter().map(|h| Vector::new(h[0], h[1], h[2]) / h[3])).0
}

/// How far a net goes: the sum of steps of `stride` between vertices, at most those of a line of `other`.
fn extent(net: &[Homogeneous], stride: usize, other: usize) -> f64 {
    let position = |h: &Homogeneous| Vector::new(h[0], h[1], h[2]) / h[3];
    let step = |i: usize| (position(&net[i + stride]) - position(&net[i])).norm();
    // Steps along rows must not go from the end of one to the start of the next.
    (0..net.len() - stride).filter(|i| stride > 1 || (i + 1) % other != 0).map(step).sum::<f64>()
        / (net.len() / other.max(stride)) as f64
}

/// Bernstein coefficients of the product of a net with itself under a bilinear form.
fn product(
    net: &[Homogeneous],
    rows: usize,
    columns: usize,
    form: impl Fn(&Homogeneous, &Homogeneous) -> f64,
) -> Vec<f64> {
    let (p, q) = (rows - 1, columns - 1);
    let wide = 2 * q + 1;
    let choose = |n: usize| (0..=n).map(|k| binomial(n, k)).collect::<Vec<_>>();
    let (cp, cq, cp2, cq2) = (choose(p), choose(q), choose(2 * p), choose(2 * q));
    let mut out = vec![0.0; (2 * p + 1) * wide];
    for (a, first) in net.iter().enumerate() {
        let (i, j) = (a / columns, a % columns);
        for (b, second) in net.iter().enumerate() {
            let (k, l) = (b / columns, b % columns);
            out[(i + k) * wide + j + l] += cp[i] * cp[k] * cq[j] * cq[l] * form(first, second);
        }
    }
    for (at, value) in out.iter_mut().enumerate() {
        *value /= cp2[at / wide] * cq2[at % wide];
    }
    out
}

fn squared(net: &[Homogeneous]) -> Vec<f64> {
    product(net, net.len(), 1, |a, b| a[0] * b[0] + a[1] * b[1] + a[2] * b[2])
}

fn squared_weights(net: &[Homogeneous]) -> Vec<f64> {
    product(net, net.len(), 1, |a, b| a[3] * b[3])
}

fn nothing_closer(squares: &[f64], weights: &[f64], distance: f64) -> bool {
    squares.iter().zip(weights).all(|(s, w)| *s >= distance * distance * w)
}

/// Bernstein coefficients of `(D·D)' W - (D·D) 2W'`, which has the sign of the slope of `D·D / W²`.
fn slope(squares: &[f64], net: &[Homogeneous]) -> Vec<f64> {
    let (m, p) = (squares.len() - 1, net.len() - 1);
    let mut out = vec![0.0; m + p];
    let mut noise = 0.0_f64;
    // Looked up: taken anew in the loops they cost most of a search at high degrees.
    let choose = |n: usize| (0..=n).map(|k| binomial(n, k)).collect::<Vec<_>>();
    let (of_m, of_p, all) = (choose(m), choose(p), choose((m + p).saturating_sub(1)));
    let (less_m, less_p) = (choose(m.saturating_sub(1)), choose(p.saturating_sub(1)));
    for i in 0..=m {
        for j in 0..=p {
            // f' has coefficients m Δf, W' p ΔW; both products have degree m + p - 1.
            if i < m {
                let term = m as f64 * (squares[i + 1] - squares[i]) * net[j][3];
                out[i + j] += less_m[i] * of_p[j] * term;
            }
            if j < p {
                let term = 2.0 * p as f64 * squares[i] * (net[j + 1][3] - net[j][3]);
                out[i + j] -= of_m[i] * less_p[j] * term;
            }
            noise = noise.max(squares[i].abs() * net[j][3]);
        }
    }
    // What is only rounding has no sign.
    let noise = 8.0 * f64::EPSILON * (m + p) as f64 * noise;
    for (k, value) in out.iter_mut().enumerate() {
        *value /= all[k];
        if value.abs() <= noise {
            *value = 0.0;
        }
    }
    out
}

fn sign_changes(coefficients: &[f64]) -> usize {
    let mut last = 0.0;
    let mut changes = 0;
    for &c in coefficients.iter().filter(|c| **c != 0.0) {
        if c * last < 0.0 {
            changes += 1;
        }
        last = c.signum();
    }
    changes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(state: &mut u32) -> f64 {
        *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(*state) / 4_294_967_296.0
    }

    #[test]
    fn no_sample_of_a_random_curve_is_closer() {
        let mut state = 7;
        for case in 0..30 {
            let n = 6 + case;
            let points: Vec<Point> =
                (0..n).map(|_| Point::from(Vector::from_fn(|_, _| noise(&mut state) * 4.0))).collect();
            let weights = (0..n).map(|_| 0.3 + 3.0 * noise(&mut state)).collect();
            let space = if case % 2 == 0 {
                Space::clamped_uniform(3, n).unwrap()
            } else {
                Space::periodic_uniform(2, n).unwrap()
            };
            let curve = Curve::build(space, points, (case % 3 == 0).then_some(weights)).unwrap();
            let query = Point::from(Vector::from_fn(|_, _| noise(&mut state) * 4.0));
            let found = curve.closest(query).unwrap();
            let (a, b) = curve.domain();
            assert!(found.gap <= 1e-9, "case {case}: gap {}", found.gap);
            assert!((curve.point(found.at).unwrap() - found.point).norm() < 1e-14);
            for i in 0..=2000 {
                let sample = curve.point(a + (b - a) * f64::from(i) / 2000.0).unwrap();
                assert!((sample - query).norm() >= found.distance - 1e-9, "case {case}");
            }
        }
    }

    #[test]
    fn no_sample_of_a_random_surface_is_closer() {
        let mut state = 11;
        for case in 0..6 {
            let (n, m) = (5, 6);
            let points: Vec<Point> = (0..n * m)
                .map(|k| Point::new((k / m) as f64, (k % m) as f64, 3.0 * noise(&mut state)))
                .collect();
            let weights = (0..n * m).map(|_| 0.3 + 3.0 * noise(&mut state)).collect();
            let space = |n| Space::clamped_uniform(3, n).unwrap();
            let surface =
                Surface::build(space(n), space(m), points, (case % 2 == 0).then_some(weights)).unwrap();
            let query = Point::from(Vector::from_fn(|_, _| noise(&mut state) * 4.0));
            let found = surface.closest(query).unwrap();
            assert!(found.gap <= 1e-8, "case {case}: gap {}", found.gap);
            for i in 0..=60 {
                for j in 0..=60 {
                    let (u, v) = (2.0 * f64::from(i) / 60.0, 3.0 * f64::from(j) / 60.0);
                    assert!((surface.point(u, v).unwrap() - query).norm() >= found.distance - 1e-9);
                }
            }
        }
    }

    /// The place does not depend on the size, up to the ends of numbers.
    #[test]
    fn sizes_whose_squares_are_no_numbers_are_found_as_others() {
        let points = [[0.0, 0.0], [1.0, 2.0], [2.0, -1.0], [3.0, 2.0], [4.0, 0.0]];
        let query = [2.6, 1.7];
        let of = |size: f64| {
            let at = |[x, y]: [f64; 2]| Point::new(x * size, y * size, 0.1 * size);
            let points: Vec<Point> = points.map(at).to_vec();
            let curve = Curve::new(Space::clamped_uniform(3, 5).unwrap(), points.clone()).unwrap();
            let net = points.iter().flat_map(|p| [*p, p + Vector::z() * size]).collect();
            let line = Space::clamped_uniform(1, 2).unwrap();
            let sheet = Surface::new(Space::clamped_uniform(3, 5).unwrap(), line, net).unwrap();
            (curve.closest(at(query)).unwrap(), sheet.closest(at(query)).unwrap())
        };
        let (curve, sheet) = of(1.0);
        for size in [1e-300, 1e-160, 1e-90, 1e-59, 1e59, 1e90, 1e154, 1e160, 1e300, 2e307] {
            let (c, s) = of(size);
            assert!((c.at - curve.at).abs() < 1e-7, "{size:e}: {c:?}");
            assert!((c.distance / size - curve.distance).abs() < 1e-9, "{size:e}: {c:?}");
            assert!((s.at.0 - sheet.at.0).abs() < 1e-7, "{size:e}: {s:?}");
            assert!((s.distance / size - sheet.distance).abs() < 1e-9, "{size:e}: {s:?}");
            assert!(c.gap <= 1e-8 * size && s.gap <= 1e-8 * size, "{size:e}: {c:?} {s:?}");
        }
        // Small differences far out are left as they are.
        let near = Curve::bezier(vec![Point::new(1.0, 0.0, 0.0), Point::new(1.0, 1e-200, 0.0)]).unwrap();
        assert_eq!(near.closest(Point::new(1.0, 1e-200, 0.0)).unwrap().distance, 0.0);
        let line = Curve::bezier(vec![Point::new(1.7e308, 0.0, 0.0), Point::new(1.7e308, 1.0, 0.0)]).unwrap();
        let error = line.closest(Point::new(-1.7e308, 0.0, 0.0)).unwrap_err().to_string();
        assert!(error.contains("larger than any number"), "{error}");
    }

    #[test]
    fn a_slope_of_exactly_zero_is_the_root() {
        // x = 2t - 1 from (0, 1): Newton's method lands on the slope 0 at t = 1/2 at once.
        let line = Curve::bezier(vec![Point::new(-1.0, 0.0, 0.0), Point::new(1.0, 0.0, 0.0)]).unwrap();
        let found = line.closest(Point::new(0.0, 1.0, 0.0)).unwrap();
        assert_eq!((found.at, found.distance), (0.5, 1.0));
        let found = line.closest(Point::new(0.25, 1.0, 0.0)).unwrap();
        assert_eq!((found.at, found.distance), (0.625, 1.0));
    }

    #[test]
    fn the_centre_of_an_arc_and_points_on_curves_are_quick() {
        let space = Space::clamped(2, &[0.0, 1.0]).unwrap();
        let points = vec![Point::new(1.0, 0.0, 0.0), Point::new(1.0, 1.0, 0.0), Point::new(0.0, 1.0, 0.0)];
        let arc = Curve::rational(space, points, vec![1.0, 0.5_f64.sqrt(), 1.0]).unwrap();
        let found = arc.closest(Point::origin()).unwrap();
        assert!((found.distance - 1.0).abs() < 1e-14 && found.at == 0.0);
        for u in [0.0, 0.2, 1.0] {
            let found = arc.closest(arc.point(u).unwrap()).unwrap();
            assert!((found.at - u).abs() < 1e-7 && found.distance < 1e-12, "{found:?}");
        }
        assert!(arc.closest(Point::new(f64::NAN, 0.0, 0.0)).is_err());
    }

    /// The ends of pieces on both sides of a tear are there to be found.
    #[test]
    fn the_ends_before_a_tear_are_points_of_the_shape() {
        let space = Space::open(1, vec![0.0, 0.0, 1.0, 1.0, 2.0, 2.0]).unwrap();
        let points = [[0.0, 0.0], [1.0, 0.0], [5.0, 5.0], [6.0, 5.0]].map(|[x, y]| Point::new(x, y, 0.0));
        let torn = Curve::new(space.clone(), points.to_vec()).unwrap();
        for (query, end, distance) in [([1.25, 0.0], [1.0, 0.0], 0.25), ([4.0, 5.0], [5.0, 5.0], 1.0)] {
            let found = torn.closest(Point::new(query[0], query[1], 0.0)).unwrap();
            assert!((found.distance - distance).abs() < 1e-15, "{found:?}");
            assert!((found.point - Point::new(end[0], end[1], 0.0)).norm() < 1e-15, "{found:?}");
            assert!((torn.point(found.at).unwrap() - found.point).norm() < 1e-15, "its place is that point");
        }
        let net = points.iter().flat_map(|p| [*p, p + Vector::z()]).collect();
        let sheet = Surface::new(space, Space::clamped_uniform(1, 2).unwrap(), net).unwrap();
        let found = sheet.closest(Point::new(1.25, 0.0, 0.5)).unwrap();
        assert!((found.distance - 0.25).abs() < 1e-15, "{found:?}");
    }

    #[test]
    fn a_hundred_thousand_vertices_leave_few_pieces_to_look_at() {
        let n = 100_000;
        let points = (0..n).map(|i| f64::from(i) * 0.01).map(|s| Point::new(s.cos() * s, s.sin() * s, 0.0));
        let curve = Curve::new(Space::clamped_uniform(3, n as usize).unwrap(), points.collect()).unwrap();
        for size in [0.5, 300.0, 2000.0] {
            let found = curve.closest(Point::new(size, 0.3 * size, 0.1)).unwrap();
            assert!(found.gap <= 1e-9 * size, "{found:?}");
        }
    }

    /// A span 1e-9 long at 1000 has some ten thousand parameters only: places between them are nobody's, and no search looks for them.
    #[test]
    fn a_span_of_few_parameters_is_not_searched_beyond_them() {
        let (a, b) = (1000.0, 1000.01);
        let (low, high) = (1000.004_999_999, 1000.005);
        let v = [[a; 4].as_slice(), &[low, high, high, high], &[b; 4]].concat();
        let (u, v) = (Space::clamped_uniform(3, 4).unwrap(), Space::open(3, v).unwrap());
        let columns = v.len();
        let at = |k: usize| {
            let (i, j) = ((k / columns) as f64 / 3.0, (k % columns) as f64 / (columns - 1) as f64);
            Point::new(i, j, 0.3 * (5.0 * i).sin() * (4.0 * j).cos())
        };
        let sheet = Surface::new(u, v, (0..4 * columns).map(at).collect()).unwrap();
        let mut most = 0;
        for (x, y) in [(0.1, 0.25), (0.3, 0.3), (0.5, 0.4), (0.6, 0.5), (0.9, 0.45), (0.5, 0.6)] {
            for z in [-0.4, -0.05, 0.0, 0.07, 0.3] {
                let point = Point::new(x, y, z);
                let (found, count) = sheet.search(point, (0.0, 0.0), None).unwrap();
                most = most.max(count);
                assert!(found.gap <= 2e-4 * (1.0 + found.distance), "{point}: {found:?}");
                let pieces = [(a, low), (low, high), (high, b)];
                for (k, (from, to)) in (0..=60).flat_map(|k| pieces.map(|piece| (k, piece))) {
                    for l in 0..=60 {
                        let at = from + (to - from) * f64::from(l) / 60.0;
                        let sample = sheet.point(f64::from(k) / 60.0, at.min(to)).unwrap();
                        assert!((sample - point).norm() >= found.distance - found.gap, "{point}: {found:?}");
                    }
                }
            }
        }
        assert!(most < 2000, "{most}");
    }
}
