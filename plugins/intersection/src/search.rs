//! All meetings of a curve with a curve or a surface: pairs of Bézier pieces, cut until each is settled.

use loftsman_kernel::Vector;

use crate::certificate::{Known, known};
use crate::meeting::{Pair, Spot};
use crate::net::Piece;
use crate::pieces::{Pieces, apart};
use crate::together::{Run, exact, long_enough, together};

/// Pairs looked at for two spans before the rest is called undecided.
const PAIRS: usize = 20_000;
/// Pairs looked at in all, and for each pair of spans that come near, before the rest is called undecided: a second or two.
const ALL_PAIRS: usize = 200_000;
const EACH_PAIR: usize = 100;
/// After so many pairs of parts, and at every third level, parts no smaller than this part of their spans are looked at whether they run together.
const FEW: usize = 16;
const LEVELS: usize = 3;
const PART: f64 = 1e-2;
/// Runs no further apart than this part of the domain can be one.
const FOLLOWS: f64 = 1e-6;
/// Pairs of parts this much smaller than their spans are not cut to tell a touching from crossings.
const TERMINAL: f64 = 1e-5;

/// A meeting: parameters `(t; u, v)` of the shapes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Found {
    pub(crate) at: [f64; 3],
    /// The distance, in the frame.
    pub(crate) distance: f64,
    /// The directions of both differ there, so that it is the only one around.
    pub(crate) simple: bool,
    /// Within its parts, to rounding: no other pair of parts has the same.
    pub(crate) own: bool,
    /// The point of the first shape, in the frame.
    pub(crate) point: Vector,
}

/// What was found, in the order of the pairs of spans.
#[derive(Debug, Default)]
pub(crate) struct Search {
    pub(crate) found: Vec<Found>,
    pub(crate) runs: Vec<Run>,
    /// Ranges of the first shape's parameter, and a point there.
    pub(crate) undecided: Vec<(f64, f64, Vector)>,
    /// Pairs looked at.
    looked: usize,
}

impl Search {
    /// Looks at all spans that come within the tolerance, which is one of the frame.
    pub(crate) fn new(a: &Pieces, b: &Pieces, tolerance: f64) -> Self {
        Self::pairs(a, b, &a.near(b, tolerance), tolerance)
    }

    /// Looks at all pairs of pieces of one curve, but for those that are said to pass into one another.
    pub(crate) fn itself(pieces: &Pieces, passes: &impl Fn(usize, usize) -> bool, tolerance: f64) -> Self {
        let mut near = pieces.near(pieces, tolerance);
        near.retain(|&(i, j)| i < j && !passes(i, j));
        Self::pairs(pieces, pieces, &near, tolerance)
    }

    fn pairs(a: &Pieces, b: &Pieces, near: &[(usize, usize)], tolerance: f64) -> Self {
        let pair = |&(i, j): &(usize, usize)| Pair { a: &a.pieces[i], b: &b.pieces[j] };
        let mut runs: Vec<Vec<Run>> = near.iter().map(|near| together(&pair(near), tolerance)).collect();
        // What runs together over little of a span goes on in its neighbours, or only touches.
        let (low, high) = a
            .pieces
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p.low[0]), h.max(p.high[0])));
        long_enough(&mut runs, FOLLOWS * (high - low), tolerance);
        let mut search = Self::default();
        let most = ALL_PAIRS + EACH_PAIR * near.len();
        for (near, runs) in near.iter().zip(runs) {
            let pair = pair(near);
            if search.looked > most {
                search.undecided.push((pair.a.low[0], pair.a.high[0], pair.a.jet([0.5, 0.0]).point));
                continue;
            }
            let runs = search.spans(&pair, runs, tolerance);
            search.runs.extend(runs);
        }
        search
    }

    /// Looks at two spans, of which some runs are known, and gives all runs back.
    fn spans(&mut self, spans: &Pair<'_>, mut runs: Vec<Run>, tolerance: f64) -> Vec<Run> {
        let extent = spans.a.extent().min(spans.b.extent());
        let small = (TERMINAL * extent).max(0.1 * tolerance);
        let mut open: Vec<_> =
            cut_at_runs(spans.a, &runs).into_iter().map(|a| (a, spans.b.clone(), 0)).collect();
        let mut count = 0;
        while let Some((a, b, depth)) = open.pop() {
            let pair = Pair { a: &a, b: &b };
            if separate(&pair, tolerance) {
                continue;
            }
            count += 1;
            self.looked += 1;
            if count > PAIRS {
                let left = open.iter().map(|(a, ..)| a).chain([&a]);
                let (low, high) =
                    left.fold((a.low[0], a.high[0]), |(l, h), p| (l.min(p.low[0]), h.max(p.high[0])));
                self.undecided.push((low, high, a.jet([0.5, 0.0]).point));
                return runs;
            }
            if runs.iter().any(|run| along(&pair, run, tolerance)) {
                continue;
            }
            let settled = known(&pair, tolerance);
            if settled == Known::Apart {
                continue;
            }
            let end = a.extent().max(b.extent()) <= small;
            if settled == Known::Once || end {
                let spot = pair.nearest([0.5; 3], 0);
                if spot.distance <= tolerance {
                    self.found.push(found(&pair, &spot, settled == Known::Once));
                    continue;
                }
            }
            // What runs together over a small part of a span does so over much of a part; to rounding, or it only touches.
            if count > FEW && depth % LEVELS == 0 && a.extent().min(b.extent()) >= PART * extent {
                let most = exact(tolerance);
                let found =
                    together(&pair, tolerance).into_iter().filter(|run| run.distance <= most && run.long());
                let known = runs.len();
                runs.extend(found);
                if runs[known..].iter().any(|run| along(&pair, run, tolerance)) {
                    continue;
                }
            }
            let lengths = [a.run(0), b.run(0), if b.parameters() == 2 { b.run(1) } else { 0.0 }];
            let splits = [a.splits(0), b.splits(0), b.parameters() == 2 && b.splits(1)];
            let widest = (0..3).filter(|&k| splits[k]).max_by(|&x, &y| lengths[x].total_cmp(&lengths[y]));
            match widest {
                // What is as small as the tolerance and still no meeting is none.
                Some(k) if lengths[k] > 0.1 * tolerance => {
                    if k == 0 {
                        open.extend(a.halves(0).into_iter().map(|half| (half, b.clone(), depth + 1)));
                    } else {
                        open.extend(b.halves(k - 1).into_iter().map(|half| (a.clone(), half, depth + 1)));
                    }
                }
                _ => {}
            }
        }
        runs
    }
}

/// The piece, cut where runs start and end.
fn cut_at_runs(piece: &Piece, runs: &[Run]) -> Vec<Piece> {
    let mut ends: Vec<f64> = runs.iter().flat_map(|run| [run.from[0], run.to[0]]).collect();
    ends.sort_by(f64::total_cmp);
    let mut parts = Vec::new();
    let mut rest = piece.clone();
    for end in ends {
        let (low, high) = (rest.low[0], rest.high[0]);
        let local = (end - low) / (high - low);
        if end > low && end < high && local > 0.0 && local < 1.0 {
            let [mut before, mut after] = rest.cut(0, local);
            (before.high[0], after.low[0]) = (end, end);
            parts.push(before);
            rest = after;
        }
    }
    parts.push(rest);
    parts
}

fn found(pair: &Pair<'_>, spot: &Spot, simple: bool) -> Found {
    let n = pair.unknowns();
    let own =
        simple && spot.distance <= 1e-12 && spot.at[..n].iter().all(|x| (1e-6..=1.0 - 1e-6).contains(x));
    let at = [
        pair.a.parameter(0, spot.at[0]),
        pair.b.parameter(0, spot.at[1]),
        if n == 3 { pair.b.parameter(1, spot.at[2]) } else { 0.0 },
    ];
    Found { at, distance: spot.distance, simple, own, point: pair.a.jet([spot.at[0], 0.0]).point }
}

/// Whether the parts are further apart than the tolerance, by their boxes or along a direction that suits them.
fn separate(pair: &Pair<'_>, tolerance: f64) -> bool {
    if apart(&pair.a.bounds(), &pair.b.bounds()) > tolerance {
        return true;
    }
    let (difference, columns, _) = pair.difference([0.5; 3]);
    let direction = if pair.unknowns() == 3 {
        columns[1].cross(&columns[2])
    } else {
        let square = columns[0].norm_squared();
        if square > 0.0 {
            difference - columns[0] * (difference.dot(&columns[0]) / square)
        } else {
            difference
        }
    };
    let length = direction.norm();
    if length.is_nan() || length <= 1e-150 {
        return false;
    }
    let direction = direction / length;
    let (a, b) = (pair.a.along(&direction), pair.b.along(&direction));
    (a.low - b.high).max(b.low - a.high) > tolerance
}

/// Whether all that the parts have in common belongs to a run: the run leads through them, within it, and neither turns
/// back.
fn along(pair: &Pair<'_>, run: &Run, tolerance: f64) -> bool {
    let (low, high) = (pair.a.low[0], pair.a.high[0]);
    if low < run.from[0] || high > run.to[0] || !narrow(pair) {
        return false;
    }
    // The place of the run beside the middle, if these parts hold it.
    pair.nearest([0.5; 3], 1).distance <= tolerance
}

/// Whether both run forwards along the first's direction in its middle, a surface with one face to one side.
fn narrow(pair: &Pair<'_>) -> bool {
    let [a, b] = pair.difference([0.5; 3]).2;
    let forward = |piece: &Piece, d: usize, way: &Vector| {
        let columns = piece.orders[1];
        let step = if d == 0 { columns } else { 1 };
        let sign = |k: usize| {
            let (c, n) = (&piece.net[k], &piece.net[k + step]);
            (0..3).map(|x| (n[x] / n[3] - c[x] / c[3]) * way[x]).sum::<f64>()
        };
        let (rows, cols) =
            if d == 0 { (piece.orders[0] - 1, columns) } else { (piece.orders[0], columns - 1) };
        let mut steps = (0..rows).flat_map(|i| (0..cols).map(move |j| i * columns + j)).map(sign);
        steps.all(|s| s > 0.0)
    };
    if !forward(pair.a, 0, &a.along[0]) {
        return false;
    }
    if pair.unknowns() == 2 {
        let way = if a.along[0].dot(&b.along[0]) < 0.0 { -a.along[0] } else { a.along[0] };
        return forward(pair.b, 0, &way);
    }
    forward(pair.b, 0, &b.along[0]) && forward(pair.b, 1, &b.along[1])
}
