//! The search along a curve.

use std::collections::BinaryHeap;

use super::bernstein::{
    box_distance, homogeneous, net_bound, nothing_closer, sign_changes, slope, squared, squared_weights,
};
use super::{Best, Closest, PIECES, Piece, check, end_of, factor_for_squares, times};
use crate::error::Result;
use crate::spline::Curve;
use crate::spline::piece::{bezier, halves};
use crate::{Point, Vector};

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
