//! Straight curves that turn back. All their passes lie on one line, so that the offset is known in closed form: on each side of it what the passes
//! in one direction cover, and half a circle round each end of the whole where the curve turns.

use std::f64::consts::PI;

use loftsman_kernel::error::Result;
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

use super::chain::{Chain, assembled};
use super::element::{Element, Kind};
use super::keep::Interval;
use super::{Corners, Job, Offset, measure};

/// Ways back of no more than this part of the size are rounding.
const TURNS: f64 = 1e-11;
/// A part of a piece of no more than this of the size goes one way.
const POINT: f64 = 1e-13;
/// Halvings of a piece.
const HALVINGS: usize = 60;

/// What the passes in one direction cover without a gap, and the first of these passes.
#[derive(Clone, Copy)]
struct Cover {
    low: f64,
    high: f64,
    first: usize,
}

/// The offset of a straight curve that turns back, its deviation measured but not judged; `None` of any other.
pub(super) fn folded(job: &Job<'_>) -> Result<Option<Offset>> {
    let Some(along) = job.plane.along else { return Ok(None) };
    // A torn curve leaps.
    if job.curve.space().most_repeated() > job.curve.degree() {
        return Ok(None);
    }
    let origin = job.curve.points()[0];
    let turns = turns(job, &origin, &along)?;
    let rounding = TURNS * job.size;
    let [_, inner @ .., _] = &turns[..] else { return Ok(None) };
    if inner.is_empty() {
        return Ok(None);
    }
    let high = turns.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let low = turns.iter().copied().fold(f64::INFINITY, f64::min);
    let at = |x: f64| move |y: &f64| (y - x).abs() <= rounding;
    // Where the curve only ends it is not gone round.
    let round = [low, high]
        .map(|x| job.options.corners != Corners::Open && (job.plane.closed || inner.iter().any(at(x))));
    let cut = inner.iter().filter(|x| !at(low)(x) && !at(high)(x)).count();

    let run: f64 = turns.windows(2).map(|w| (w[1] - w[0]).abs()).sum();
    let line = Line { job, origin, along, pace: job.curve.space().length() / run };
    let covers = [1.0, -1.0].map(|way| covers(&turns, way, rounding));
    let mut elements = Vec::new();
    let mut chains = Vec::new();
    for (parts, closed) in in_order(&covers, round, turns[0], rounding) {
        let first = elements.len();
        elements.extend(parts.iter().map(|part| line.element(part, low, high)).collect::<Result<Vec<_>>>()?);
        let whole = |k: usize| {
            let (from, to) = elements[k].domain();
            Interval { element: k, from, to }
        };
        let intervals: Vec<Interval> = (first..elements.len()).map(whole).collect();
        chains.extend(assembled(job, &elements, &intervals, closed, 0)?);
    }
    if chains.is_empty() {
        return Ok(None);
    }
    let deviation = measure::deviation(job, &elements, &chains)?;
    Ok(Some(Offset {
        curves: chains.into_iter().map(|chain: Chain| chain.curve).collect(),
        deviation,
        tolerance: job.tolerance,
        cut: if job.options.corners == Corners::Open { 0 } else { cut },
        blunted: if job.options.corners == Corners::Sharp { round.iter().filter(|r| **r).count() } else { 0 },
        strips: false,
    }))
}

/// How far along the line the curve starts, turns back, and ends. A piece goes one way where its control vertices do.
fn turns(job: &Job<'_>, origin: &Point, along: &Vector) -> Result<Vec<f64>> {
    let place = |p: &Point| (p - origin).dot(along);
    let mut path: Vec<f64> = vec![place(&job.curve.point(job.curve.domain().0)?)];
    let mut go = |x: f64| {
        let last = path[path.len() - 1];
        let ahead = path.len() > 1 && (x - last) * (last - path[path.len() - 2]) >= 0.0;
        if ahead {
            path.pop();
            path.push(x);
        } else if (x - last).abs() > TURNS * job.size {
            path.push(x);
        }
    };
    for segment in job.curve.bezier_segments()? {
        // Halved in its own share from 0 to 1: the curve's parameters may be known to few digits.
        let weight = |k: usize| segment.weights().map_or(1.0, |weights| weights[k]);
        let whole: Vec<[f64; 2]> =
            segment.points().iter().enumerate().map(|(k, p)| [place(p) * weight(k), weight(k)]).collect();
        let mut open = vec![(whole, 0)];
        while let Some((piece, depth)) = open.pop() {
            let places: Vec<f64> = piece.iter().map(|[x, w]| x / w).collect();
            let ordered = places.windows(2).all(|w| w[1] >= w[0]) || places.windows(2).all(|w| w[1] <= w[0]);
            let low = places.iter().copied().fold(f64::INFINITY, f64::min);
            let high = places.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            if ordered || high - low <= POINT * job.size || depth >= HALVINGS {
                go(places[places.len() - 1]);
                continue;
            }
            let [first, second] = halves(piece);
            open.extend([second, first].map(|half| (half, depth + 1)));
        }
    }
    Ok(path)
}

/// A Bézier piece, cut in the middle (P. de Casteljau).
fn halves(mut piece: Vec<[f64; 2]>) -> [Vec<[f64; 2]>; 2] {
    let mut first = Vec::with_capacity(piece.len());
    for end in (0..piece.len()).rev() {
        first.push(piece[0]);
        for k in 0..end {
            let (a, b) = (piece[k], piece[k + 1]);
            piece[k] = [0.5 * a[0] + 0.5 * b[0], 0.5 * a[1] + 0.5 * b[1]];
        }
    }
    [first, piece]
}

/// What the passes cover that go up the line, for `way` 1, or down, for -1; ascending.
fn covers(turns: &[f64], way: f64, rounding: f64) -> Vec<Cover> {
    let passes = turns.windows(2).enumerate().filter(|(_, w)| (w[1] - w[0]) * way > 0.0);
    let mut all: Vec<Cover> =
        passes.map(|(first, w)| Cover { low: w[0].min(w[1]), high: w[0].max(w[1]), first }).collect();
    all.sort_by(|x, y| x.low.total_cmp(&y.low).then(x.first.cmp(&y.first)));
    let mut covers: Vec<Cover> = Vec::new();
    for pass in all {
        match covers.last_mut() {
            Some(last) if pass.low <= last.high + rounding => {
                last.high = last.high.max(pass.high);
                last.first = last.first.min(pass.first);
            }
            _ => covers.push(pass),
        }
    }
    covers
}

/// A part of the offset.
enum Part {
    /// Along the line from one place to another.
    Straight(f64, f64),
    /// Round the upper end of the whole, or the lower one.
    Round { upper: bool },
}

/// The parts of each curve of the offset, in the order in which the curve passes them, and whether it goes round. What goes up goes on round the upper end
/// of the whole into what goes down, and that round the lower one.
fn in_order(
    [up, down]: &[Vec<Cover>; 2],
    [round_low, round_high]: [bool; 2],
    start: f64,
    rounding: f64,
) -> Vec<(Vec<Part>, bool)> {
    let ways: Vec<(&Cover, f64, f64)> =
        up.iter().map(|c| (c, c.low, c.high)).chain(down.iter().map(|c| (c, c.high, c.low))).collect();
    let mut next: Vec<Option<usize>> = vec![None; ways.len()];
    let mut is_start = vec![true; ways.len()];
    let mut link = |from: usize, to: usize| {
        next[from] = Some(to);
        is_start[to] = false;
    };
    if !up.is_empty() && !down.is_empty() {
        if round_high {
            link(up.len() - 1, ways.len() - 1);
        }
        if round_low {
            link(up.len(), 0);
        }
    }
    let mut found = Vec::new();
    // One that goes round starts where the curve does.
    let ring = is_start.iter().all(|starts| !starts);
    let begin = (0..ways.len()).filter(|&k| is_start[k] || ring && ways[k].0.first == 0);
    for k in begin {
        let (mut parts, mut first, mut at) = (Vec::new(), usize::MAX, Some(k));
        while let Some(i) = at {
            let (cover, from, to) = ways[i];
            first = first.min(cover.first);
            parts.push(Part::Straight(from, to));
            at = next[i];
            if at.is_some() {
                parts.push(Part::Round { upper: i < up.len() });
            }
            if at == Some(k) {
                break;
            }
        }
        if ring && let Some(Part::Straight(from, to)) = parts.first_mut() {
            let begins = *from;
            if (start - begins).abs() > rounding && (start - *to).abs() > rounding {
                *from = start;
                parts.push(Part::Straight(begins, start));
            }
        }
        found.push((first, parts));
    }
    found.sort_by_key(|(first, _)| *first);
    found.into_iter().map(|(_, parts)| (parts, ring)).collect()
}

/// The line, and how it is left.
struct Line<'a> {
    job: &'a Job<'a>,
    origin: Point,
    along: Vector,
    /// Parameters of a length.
    pace: f64,
}

impl Line<'_> {
    fn point(&self, x: f64) -> Point {
        self.origin + self.along * x
    }

    fn element(&self, part: &Part, low: f64, high: f64) -> Result<Element> {
        match *part {
            Part::Straight(from, to) => {
                let space = Space::clamped(1, &[0.0, (to - from).abs() * self.pace])?;
                let piece = Curve::new(space, vec![self.point(from), self.point(to)])?;
                Ok(Element::Moved { piece, kind: Kind::Straight, index: 0 })
            }
            Part::Round { upper } => {
                let (end, along) = if upper { (high, self.along) } else { (low, -self.along) };
                Ok(Element::Arc {
                    corner: self.point(end),
                    from: along.cross(&self.job.plane.normal) * self.job.distance,
                    sweep: PI.copysign(self.job.distance),
                    width: PI * self.job.distance.abs() * self.pace,
                    between: [0; 2],
                })
            }
        }
    }
}
