//! Edges that are curved in the parameter plane: interpolated piece by piece.

use super::Projected;
use super::feet::{Feet, Sample};
use crate::error::Result;
use crate::spline::Curve;
use crate::spline::pieces::{DEGREE, Interpolation, Net, at};
use crate::spline::space::Space;
use crate::spline::trimmed::ParameterCurve;
use crate::{Point, Vector};

/// How often a part between knots is halved at most.
const DEPTH: u32 = 12;
/// Pieces at most.
const PIECES: usize = 2000;
/// Steps to where an edge crosses a knot line.
const STEPS: usize = 60;
/// The part of an edge's domain that a stretch along a pole takes.
const ALONG_POLE: f64 = 1.0 / 64.0;

/// A piece of the curve: where it ends, and its Bézier points.
struct Piece {
    length: f64,
    net: Net,
}

struct Fit<'f, 's> {
    feet: &'f Feet<'s>,
    curve: &'f Curve,
    bound: f64,
    interpolation: Interpolation,
    error: f64,
    pieces: Vec<Piece>,
}

/// The curve through feet of an edge, as near to it as `bound` wants beyond what the edge is off.
pub(super) fn fitted(feet: &Feet<'_>, curve: &Curve, samples: &[Sample], bound: f64) -> Result<Projected> {
    let interpolation = Interpolation::new();
    let mut fit = Fit { feet, curve, bound, interpolation, error: 0.0, pieces: Vec::new() };
    let breaks = fit.breaks(samples)?;
    for pair in breaks.windows(2) {
        fit.stretch(&pair[0], &pair[1])?;
    }
    fit.finished()
}

impl Fit<'_, '_> {
    /// The ends of the parts that are smooth: knots of the edge, places where it crosses knot lines of the surface, poles.
    fn breaks(&self, samples: &[Sample]) -> Result<Vec<Sample>> {
        let own = self.curve.space().breakpoints();
        let knots = [self.feet.surface.u().breakpoints(), self.feet.surface.v().breakpoints()];
        let mut all: Vec<Sample> = Vec::new();
        for (k, sample) in samples.iter().enumerate() {
            if k > 0 && sample.t > samples[k - 1].t {
                let before = samples[k - 1];
                let mut crossed = Vec::new();
                for d in 0..2 {
                    let (low, high) = (before.at[d].min(sample.at[d]), before.at[d].max(sample.at[d]));
                    let side = &self.feet.sides[d];
                    let turns = if side.closed {
                        let turn = |x: f64| ((x - side.low) / side.length()).floor();
                        (turn(low) as i64, turn(high) as i64)
                    } else {
                        (0, 0)
                    };
                    // A search that jumps over many turns is no edge.
                    for turn in turns.0..=turns.1.min(turns.0 + 4) {
                        let lines = knots[d].iter().map(|knot| knot + turn as f64 * side.length());
                        crossed.extend(lines.filter(|x| *x > low && *x < high).map(|x| (d, x)));
                    }
                }
                let mut found = Vec::new();
                for (d, line) in crossed {
                    found.push(self.crossing(&before, sample, d, line)?);
                }
                found.sort_unstable_by(|a, b| a.t.total_cmp(&b.t));
                all.extend(found);
            }
            let ends = k == 0 || k + 1 == samples.len();
            if ends || sample.pole.is_some() || own.contains(&sample.t) {
                all.push(*sample);
            }
        }
        // Breaks that rounding set apart are one.
        let (start, end) = self.curve.domain();
        let least = 1e-9 * (end - start);
        let mut kept: Vec<Sample> = Vec::with_capacity(all.len());
        for sample in all {
            match kept.last() {
                // The two sides of a pole.
                Some(last) if last.pole.is_some() && sample.pole.is_some() => kept.push(sample),
                Some(last) if sample.t - last.t <= least => {
                    if sample.t == end && kept.len() > 1 {
                        kept.pop();
                        kept.push(sample);
                    }
                }
                _ => kept.push(sample),
            }
        }
        Ok(kept)
    }

    /// Where an edge crosses a knot line between two of its places.
    fn crossing(&self, a: &Sample, b: &Sample, d: usize, line: f64) -> Result<Sample> {
        let (mut low, mut high) = (*a, *b);
        let mut found = low;
        for step in 0..STEPS {
            let (x, y) = (low.at[d] - line, high.at[d] - line);
            let share = if step % 3 == 2 { 0.5 } else { (x / (x - y)).clamp(0.01, 0.99) };
            let t = low.t + (high.t - low.t) * share;
            if t <= low.t || t >= high.t {
                break;
            }
            found = self.feet.sample(self.curve, t, Some(low.at))?;
            if (found.at[d] - line).abs() <= 1e-14 * self.feet.sides[d].length() {
                break;
            }
            if (found.at[d] < line) == (low.at[d] < line) {
                low = found;
            } else {
                high = found;
            }
        }
        found.at[d] = line;
        Ok(found)
    }

    /// The pieces between two breaks.
    fn stretch(&mut self, from: &Sample, to: &Sample) -> Result<()> {
        if to.t <= from.t {
            return Ok(());
        }
        let mut open = vec![(0_u32, *from, *to)];
        while let Some((depth, a, b)) = open.pop() {
            let middle = 0.5 * (a.t + b.t);
            let (piece, error, good) = self.piece(&a, &b)?;
            if good
                || depth >= DEPTH
                || self.pieces.len() + open.len() >= PIECES
                || middle <= a.t
                || middle >= b.t
            {
                self.error = self.error.max(error);
                self.pieces.push(piece);
                continue;
            }
            let near = [0, 1].map(|d: usize| 0.5 * (a.at[d] + b.at[d]));
            let halfway = self.feet.sample(self.curve, middle, Some(near))?;
            open.extend([(depth + 1, halfway, b), (depth + 1, a, halfway)]);
        }
        Ok(())
    }

    /// The interpolation between two places, how far the surface along it is from the edge, and whether that is near enough.
    fn piece(&self, a: &Sample, b: &Sample) -> Result<(Piece, f64, bool)> {
        let mut places: Net = [a.at; DEGREE + 1];
        let mut error = a.off.max(b.off);
        let mut near = a.at;
        // Leaving a pole, the next place is where the way leads to.
        for (k, x) in self.interpolation.nodes().into_iter().enumerate() {
            let sample = if k == 0 {
                *a
            } else if k == DEGREE {
                *b
            } else {
                self.feet.sample(self.curve, a.t + (b.t - a.t) * x, Some(near))?
            };
            near = sample.at;
            error = error.max(sample.off);
            places[k] = sample.at;
        }
        let net = self.interpolation.through(&places)?;
        let mut good = true;
        // Between the nodes, where the interpolation is worst.
        for x in self.interpolation.between() {
            let at = at(&net, x);
            let t = a.t + (b.t - a.t) * x;
            let (on, point) = (self.feet.point(at)?, self.curve.point(t)?);
            let away = (on - point).norm();
            error = error.max(away);
            if away > self.bound {
                let sample = self.feet.sample(self.curve, t, Some(at))?;
                let slip: Vector = on - self.feet.point(sample.at)?;
                good &= slip.norm() <= self.bound;
            }
        }
        Ok((Piece { length: b.t - a.t, net }, error, good))
    }

    fn finished(self) -> Result<Projected> {
        let (start, end) = self.curve.domain();
        let mut knots = vec![start; DEGREE + 1];
        let mut points: Vec<Point> = Vec::new();
        let mut at = start;
        let lift = |p: &[f64; 2]| Point::new(p[0], p[1], 0.0);
        let mut own_speed = true;
        for piece in &self.pieces {
            let first = piece.net[0];
            if let Some(last) = points.last().copied() {
                let apart = (0..2).any(|d| (last[d] - first[d]).abs() > 1e-9 * self.feet.sides[d].length());
                if apart {
                    // Through a pole: along the side of the domain that it is.
                    at += ALONG_POLE * (end - start);
                    own_speed = false;
                    let line = |k: usize| last + (lift(&first) - last) * (k as f64 / DEGREE as f64);
                    points.extend((1..=DEGREE).map(line));
                    knots.extend([at; DEGREE]);
                }
            } else {
                points.push(lift(&first));
            }
            at += piece.length;
            points.extend(piece.net[1..].iter().map(lift));
            knots.extend([at; DEGREE]);
        }
        if own_speed {
            // To the last bit.
            let len = knots.len();
            knots[len - DEGREE..].fill(end);
        }
        let last = knots.last().copied().unwrap_or(end);
        knots.push(last);
        let curve = Curve::new(Space::open(DEGREE, knots)?, points)?;
        Ok(Projected { curve: ParameterCurve::whole(curve)?, error: self.error })
    }
}
