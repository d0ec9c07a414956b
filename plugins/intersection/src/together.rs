//! Where a curve runs together with a curve or a surface: within the tolerance, over an eighth of a span at least.
//!
//! Two polynomial pieces that share more points than the product of their degrees are parts of one curve (Bézout), so that
//! what runs together does so from an end of a piece to an end of a piece, or to an edge: samples find it and bisection its ends.

use crate::meeting::Pair;

/// Samples of a span: what is on the other at three neighbours runs along it.
const SAMPLES: usize = 16;

/// A run: parameters `(t; u, v)` of both shapes where it starts and ends.
#[derive(Debug, Clone)]
pub(crate) struct Run {
    pub(crate) from: [f64; 3],
    pub(crate) to: [f64; 3],
    /// Places of it, in order.
    pub(crate) places: Vec<[f64; 3]>,
    /// The largest distance that was measured along it, in the frame.
    pub(crate) distance: f64,
}

pub(crate) fn together(pair: &Pair<'_>, tolerance: f64) -> Vec<Run> {
    let bounds = pair.b.bounds();
    let mut last: Option<[f64; 3]> = None;
    let mut on = |t: f64, near: Option<[f64; 3]>| -> Option<([f64; 3], f64)> {
        let point = pair.a.jet([t, 0.0]).point;
        if (0..3).any(|k| point[k] < bounds[k].low - tolerance || point[k] > bounds[k].high + tolerance) {
            return None;
        }
        let tried =
            near.or(last).map(|s| pair.nearest([t, s[1], s[2]], 1)).filter(|s| s.distance <= tolerance);
        let spot = match tried {
            Some(spot) => spot,
            None => pair.nearest(coarse(pair, t), 1),
        };
        if spot.distance > tolerance {
            return None;
        }
        last = Some(spot.at);
        Some((spot.at, spot.distance))
    };
    let at = |k: usize| k as f64 / SAMPLES as f64;
    // Any three neighbours have an odd one among them.
    let mut spots = [None; SAMPLES + 1];
    for k in (1..SAMPLES).step_by(2) {
        spots[k] = on(at(k), None);
    }
    if spots.iter().all(Option::is_none) {
        return Vec::new();
    }
    for k in (0..=SAMPLES).step_by(2) {
        spots[k] = on(at(k), None);
    }
    let mut runs = Vec::new();
    let mut k = 0;
    while k <= SAMPLES {
        let Some(first) = spots[k] else {
            k += 1;
            continue;
        };
        let mut end = k;
        while end < SAMPLES && spots[end + 1].is_some() {
            end += 1;
        }
        if let (true, Some(final_spot)) = (end - k >= 2, spots[end]) {
            let mut distance = spots[k..=end].iter().flatten().map(|s| s.1).fold(0.0, f64::max);
            let degrees = pair
                .a
                .orders
                .iter()
                .chain(&pair.b.orders)
                .map(|o| o - 1)
                .filter(|d| *d > 0)
                .product::<usize>();
            // More than Bézout's number of places, between those that are known.
            let places = (degrees + 2).clamp(8, 400);
            let (low, high) = (at(k), at(end));
            let all = (0..places).all(|p| {
                let t = low + (high - low) * (p as f64 + 0.5) / places as f64;
                let spot = on(t, None);
                distance = distance.max(spot.map_or(0.0, |s| s.1));
                spot.is_some()
            });
            if all {
                let mut bisect = |inside: ([f64; 3], f64), outside: f64| {
                    let (mut spot, mut out) = (inside.0, outside);
                    for _ in 0..50 {
                        let middle = 0.5 * (spot[0] + out);
                        match on(middle, Some(spot)) {
                            Some((s, _)) => spot = s,
                            None => out = middle,
                        }
                    }
                    spot
                };
                let from = if k > 0 { bisect(first, at(k - 1)) } else { first.0 };
                let to = if end < SAMPLES { bisect(final_spot, at(end + 1)) } else { final_spot.0 };
                let (from, to) = (global(pair, from), global(pair, to));
                let inner = spots[k..=end].iter().flatten().map(|s| global(pair, s.0));
                let places = std::iter::once(from).chain(inner).chain([to]).collect();
                runs.push(Run { from, to, places, distance });
            }
        }
        k = end + 1;
    }
    runs
}

/// The best of a few places of the other piece.
fn coarse(pair: &Pair<'_>, t: f64) -> [f64; 3] {
    let count = |order: usize| if order == 1 { 1 } else { 2 * order.min(6) };
    let point = pair.a.jet([t, 0.0]).point;
    let (rows, columns) = (count(pair.b.orders[0]), count(pair.b.orders[1]));
    let local = |k: usize, n: usize| if n == 1 { 0.0 } else { k as f64 / (n - 1) as f64 };
    let mut best = (f64::INFINITY, [t, 0.5, 0.5]);
    for i in 0..rows {
        for j in 0..columns {
            let at = [local(i, rows), local(j, columns)];
            let distance = (pair.b.jet(at).point - point).norm();
            if distance < best.0 {
                best = (distance, [t, at[0], at[1]]);
            }
        }
    }
    best.1
}

fn global(pair: &Pair<'_>, at: [f64; 3]) -> [f64; 3] {
    let v = if pair.unknowns() == 3 { pair.b.parameter(1, at[2]) } else { 0.0 };
    [pair.a.parameter(0, at[0]), pair.b.parameter(0, at[1]), v]
}
