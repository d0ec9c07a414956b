//! The search over a surface, or over the part of it that counts.

use std::collections::BinaryHeap;

use super::bernstein::{box_distance, extent, homogeneous, net_bound, nothing_closer, product};
use super::{ABSOLUTE, Best, Closest, PIECES, Piece, check, end_of, factor_for_squares, times};
use crate::error::Result;
use crate::spline::Surface;
use crate::spline::piece::{bezier_patch, halves, halves_of_rows};
use crate::{Point, Vector};

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

impl Surface {
    /// The point of the surface closest to `point`, over the whole surface, as [`Curve::closest`](crate::spline::Curve::closest).
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
        Ok(self.search(point, (absolute, relative), None, PIECES)?.0)
    }

    /// The same, but of so many pieces at most: what it has then, and how many it has looked at. The gap says what may have been missed.
    ///
    /// # Errors
    /// As for [`closest`](Self::closest).
    pub fn nearly_closest_of(
        &self,
        point: Point,
        absolute: f64,
        relative: f64,
        most: usize,
    ) -> Result<(Closest<(f64, f64)>, usize)> {
        self.search(point, (absolute, relative), None, most)
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
        Ok(self.search(point, (0.0, 0.0), Some((kept, start)), KEPT_PIECES)?.0)
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
        most: usize,
    ) -> Result<(Closest<(f64, f64)>, usize)> {
        check(point)?;
        if let Some(factor) = factor_for_squares(self.points(), point) {
            let weights = self.weights().map(<[f64]>::to_vec);
            let points = times(self.points(), factor);
            let scaled = Self::build(self.u().clone(), self.v().clone(), points, weights)?;
            let (found, count) = scaled.search(point * factor, (slack.0 * factor, slack.1), kept, most)?;
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
