//! Where what a piece has in common with another can start and end: at its own ends, where the other curve ends on it, and where it passes
//! an edge of the other surface.

use crate::meeting::{Pair, coarse};
use crate::net::Piece;
use crate::pieces::apart;

/// Places of a piece from which the nearest ones are looked for: at those that are nearer than their neighbours.
const PLACES: usize = 16;
/// Halvings of both, by which most pairs are shown to be apart.
const HALVINGS: usize = 6;

/// The local parameters of the first piece at which a run can start or end, in order, the first 0 and the last 1. `O(p)` evaluations for a curve,
/// `O(p + q)` for a surface.
pub(crate) fn limits(pair: &Pair<'_>, tolerance: f64) -> Vec<f64> {
    let mut limits = vec![0.0, 1.0];
    let [rows, columns] = pair.b.orders;
    let corners = [0, columns - 1, (rows - 1) * columns, rows * columns - 1];
    let corners = if columns == 1 { &corners[1..3] } else { &corners[..] };
    for &corner in corners {
        // A curve that stands still.
        let net = vec![pair.b.net[corner]; 2];
        nearest(
            pair.a,
            &Piece { low: [0.0; 2], high: [1.0, 0.0], orders: [2, 1], net },
            tolerance,
            &mut limits,
        );
    }
    if columns > 1 {
        for edge in edges(pair.b) {
            nearest(pair.a, &edge, tolerance, &mut limits);
        }
    }
    limits.sort_by(f64::total_cmp);
    limits.dedup();
    limits
}

/// The four edges of a patch.
fn edges(patch: &Piece) -> [Piece; 4] {
    let [rows, columns] = patch.orders;
    let edge = |d: usize, first: usize, step: usize, count: usize| Piece {
        low: [patch.low[d], 0.0],
        high: [patch.high[d], 0.0],
        orders: [count, 1],
        net: (0..count).map(|k| patch.net[first + k * step]).collect(),
    };
    [
        edge(0, 0, columns, rows),
        edge(0, columns - 1, columns, rows),
        edge(1, 0, 1, columns),
        edge(1, (rows - 1) * columns, 1, columns),
    ]
}

/// Whether boxes of parts of both are within the tolerance, after so many halvings.
fn near(curve: &Piece, other: &Piece, tolerance: f64) -> bool {
    if apart(&curve.bounds(), &other.bounds()) > tolerance {
        return false;
    }
    let mut open = vec![(curve.clone(), other.clone(), 0)];
    while let Some((a, b, depth)) = open.pop() {
        if depth == HALVINGS {
            return true;
        }
        let parts = if a.extent() >= b.extent() {
            a.halves(0).map(|half| (half, b.clone(), depth + 1))
        } else {
            b.halves(0).map(|half| (a.clone(), half, depth + 1))
        };
        open.extend(parts.into_iter().filter(|(a, b, _)| apart(&a.bounds(), &b.bounds()) <= tolerance));
    }
    false
}

/// Appends the places of a curve that are as near to another as the tolerance and nearer than all beside them.
fn nearest(curve: &Piece, other: &Piece, tolerance: f64, limits: &mut Vec<f64>) {
    if !near(curve, other, tolerance) {
        return;
    }
    let pair = Pair { a: curve, b: other };
    let starts: Vec<([f64; 3], f64)> = (0..=PLACES)
        .map(|k| {
            let start = coarse(&pair, k as f64 / PLACES as f64);
            (start, pair.difference(start).0.norm())
        })
        .collect();
    for (k, (start, distance)) in starts.iter().enumerate() {
        let beside = |k: Option<usize>| k.and_then(|k| starts.get(k)).is_none_or(|s| s.1 >= *distance);
        if beside(k.checked_sub(1)) && beside(Some(k + 1)) {
            let spot = pair.nearest(*start, 0);
            if spot.distance <= tolerance {
                limits.push(spot.at[0]);
            }
        }
    }
}
