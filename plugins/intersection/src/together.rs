//! Where a curve runs together with a curve or a surface: within the tolerance, over an eighth of a span at least, or to rounding.
//!
//! Two polynomial pieces that share more points than the product of their degrees are parts of one curve (Bézout), so that
//! what runs together does so from an end of a piece to an end of a piece, or to an edge. Those places are found first ([`limits`]),
//! however short what is between them; samples tell between which of them the pieces are together, and bisection where that ends
//! elsewhere, as it does where they are together by the tolerance only.

use loftsman_kernel::Vector;

use crate::limits::limits;
use crate::meeting::{Pair, coarse};

/// Samples between limits: what is on the other at three neighbours runs along it.
const SAMPLES: usize = 16;
/// What runs together within the tolerance does so over this part of a span, or goes on where others end; else it only touches.
const SHARE: f64 = 0.125;
/// How near parts are that run together however short they are, in tolerances; and what is rounding.
const EXACT: f64 = 1e-3;
const ROUNDING: f64 = 1e-13;
/// Shapes that touch and whose curvatures differ by `κ` are within `d` of one another over a length `L` with `L² = 8 d / κ`: what is longer than `L² = 1000 d` does
/// not touch, unless they differ by less than a hundredth (in the frame, whose size is 1).
const TOUCHING: f64 = 1e3;
/// What is shorter than so many tolerances is a place.
const SHORT: f64 = 8.0;

/// A run: parameters `(t; u, v)` of both shapes where it starts and ends.
#[derive(Debug, Clone)]
pub(crate) struct Run {
    pub(crate) from: [f64; 3],
    pub(crate) to: [f64; 3],
    /// Places of it, in order.
    pub(crate) places: Vec<[f64; 3]>,
    /// The largest distance that was measured along it, in the frame.
    pub(crate) distance: f64,
    /// The first shape's points where it starts and ends, in the frame.
    pub(crate) points: [Vector; 2],
    /// How much of a span it is; what is together to rounding counts as all of one.
    share: f64,
}

/// The distance at which parts are together to rounding.
pub(crate) fn exact(tolerance: f64) -> f64 {
    (EXACT * tolerance).max(ROUNDING)
}

/// Leaves the runs that are long enough, alone or with those that they go on into; `reach` is how far apart parameters of the first shape are of what does.
pub(crate) fn long_enough(runs: &mut [Vec<Run>], reach: f64, tolerance: f64) {
    let all: Vec<&Run> = runs.iter().flatten().collect();
    if all.iter().all(|run| run.share >= SHARE) {
        return;
    }
    let mut ends: Vec<(f64, usize, usize)> =
        all.iter().enumerate().flat_map(|(k, run)| [(run.from[0], k, 0), (run.to[0], k, 1)]).collect();
    ends.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)).then(x.2.cmp(&y.2)));
    // Who goes on into whom, as a forest; a root has the sum of all that hang on it.
    let mut above: Vec<usize> = (0..all.len()).collect();
    let mut shares: Vec<f64> = all.iter().map(|run| run.share).collect();
    let root = |above: &mut [usize], mut k: usize| {
        while above[k] != k {
            above[k] = above[above[k]];
            k = above[k];
        }
        k
    };
    for (i, x) in ends.iter().enumerate() {
        // Each with the next few: more than that end at one place only where a curve comes back to it many times.
        for y in ends[i + 1..].iter().take(FEW).take_while(|y| y.0 - x.0 <= reach) {
            if (all[x.1].points[x.2] - all[y.1].points[y.2]).norm() > 4.0 * tolerance {
                continue;
            }
            let (p, q) = (root(&mut above, x.1), root(&mut above, y.1));
            if p != q {
                above[q] = p;
                shares[p] += shares[q];
            }
        }
    }
    let keeps: Vec<bool> = (0..all.len()).map(|k| shares[root(&mut above, k)] >= SHARE).collect();
    let mut keeps = keeps.into_iter();
    for some in runs {
        some.retain(|_| keeps.next().unwrap_or(false));
    }
}

/// So many ends at one place are looked at.
const FEW: usize = 16;

/// The runs of a pair, those that are shorter than an eighth of the first span included: [`Run::long`] and [`long_enough`] tell which are none.
pub(crate) fn together(pair: &Pair<'_>, tolerance: f64) -> Vec<Run> {
    let limits = limits(pair, tolerance);
    let mut runs = Vec::new();
    for ends in limits.windows(2) {
        between(pair, [ends[0], ends[1]], tolerance, &mut runs);
    }
    runs
}

impl Run {
    /// Whether it is long enough by itself.
    pub(crate) fn long(&self) -> bool {
        self.share >= SHARE
    }
}

/// Appends the runs between two parameters of the first piece.
fn between(pair: &Pair<'_>, ends: [f64; 2], tolerance: f64, runs: &mut Vec<Run>) {
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
    let at = |k: usize| match k {
        SAMPLES => ends[1],
        _ => ends[0] + (ends[1] - ends[0]) * k as f64 / SAMPLES as f64,
    };
    // Any three neighbours have an odd one among them.
    let mut spots = [None; SAMPLES + 1];
    for k in (1..SAMPLES).step_by(2) {
        spots[k] = on(at(k), None);
    }
    if spots.iter().all(Option::is_none) {
        return;
    }
    for k in (0..=SAMPLES).step_by(2) {
        spots[k] = on(at(k), None);
    }
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
                let points = [from, to].map(|spot| pair.a.jet([spot[0], 0.0]).point);
                let length =
                    chords(points[0], spots[k..=end].iter().flatten().map(|s| s.0[0]), points[1], pair);
                let part = to[0] - from[0];
                let (from, to) = (global(pair, from), global(pair, to));
                let inner = spots[k..=end].iter().flatten().map(|s| global(pair, s.0));
                let places = std::iter::once(from).chain(inner).chain([to]).collect();
                let most = exact(tolerance);
                let share = if distance <= most && length * length >= TOUCHING * most { 1.0 } else { part };
                if length > SHORT * tolerance {
                    runs.push(Run { from, to, places, distance, points, share });
                }
            }
        }
        k = end + 1;
    }
}

/// The length of the polygon through places of the first piece.
fn chords(from: Vector, inner: impl Iterator<Item = f64>, to: Vector, pair: &Pair<'_>) -> f64 {
    let (mut length, mut last) = (0.0, from);
    for point in inner.map(|t| pair.a.jet([t, 0.0]).point).chain([to]) {
        length += (point - last).norm();
        last = point;
    }
    length
}

fn global(pair: &Pair<'_>, at: [f64; 3]) -> [f64; 3] {
    let v = if pair.unknowns() == 3 { pair.b.parameter(1, at[2]) } else { 0.0 };
    [pair.a.parameter(0, at[0]), pair.b.parameter(0, at[1]), v]
}
