//! An edge in the parameters of a surface, at the pace of the curve that stands for it in space.

use crate::Point;
use crate::brep::Edge;
use crate::error::Result;
use crate::spline::pieces::{self, Interpolation, Limits, Net};
use crate::spline::{Curve, Space};

use super::chart::Chart;
use super::pace::Pace;

/// How often a part between knots is halved at most, and pieces at most.
const LIMITS: Limits = Limits { depth: 10, pieces: 400 };
/// Places in each knot span of an edge, as a multiple of its degree, from each of which the parameters of the next are found.
const STEPS: usize = 4;
/// Halvings until a place is on a knot line of the surface, and the shortest part of an edge between two of them.
const STEPS_TO_LINE: usize = 45;
const LEAST: f64 = 1e-9;
/// Places in each piece, and in each span of the edge, at which the result is measured.
const EACH: usize = 7;
/// How far a curve may be off, as a part of the edge's size and of its tolerance.
const OF_SIZE: f64 = 1e-9;
const OF_TOLERANCE: f64 = 0.1;
/// Where a place lies by a pole it is the noise of its coordinates that says at which angle; an edge of a constant angle may be off by so much of its size there, of how far
/// away it is, and no more than this part of its size.
const NOISE: f64 = 1e-6;
const NOISE_FAR_AWAY: f64 = 1e-9;
const MOST_NOISE: f64 = 1e-4;
/// How far places may be from the edge, as a part of its size, where its tolerance says less, and so much further off than the surface's nearest point.
const NEAR: f64 = 1e-7;
const AS_GOOD: f64 = 1.01;
/// Parameters that change by less than this part of a turn stand still, and those that are as near to where the angles start are there.
const MEANT: f64 = 1e-8;

/// An edge on a surface: what is known of it at places all along.
pub(super) struct Track<'c> {
    chart: &'c Chart<'c>,
    own: Curve,
    pace: Pace,
    /// Shares of the edge with the parameters there, which run on.
    known: Vec<(f64, [f64; 2])>,
    /// Where pieces end at least.
    breaks: Vec<f64>,
    /// How far the curve may be off in space, and the edge from it.
    bound: f64,
    near: f64,
    /// The same by a pole.
    noise: f64,
}

impl<'c> Track<'c> {
    /// An edge whose parameters at its start and its end are known, to a quarter of a turn; at a pole they are those. `None` where they do not run from the one
    /// to the other.
    pub(super) fn new(
        chart: &'c Chart<'c>,
        edge: &Edge,
        pace: Pace,
        ends: [[f64; 2]; 2],
    ) -> Result<Option<Self>> {
        let own = edge.curve.between(edge.range.0, edge.range.1)?;
        let (low, high) = own.domain();
        // A circle is smooth in its angle wherever its spline has knots.
        let breaks: Vec<f64> = if pace.is_even() {
            own.space().breakpoints().into_iter().map(|t| (t - low) / (high - low)).collect()
        } else {
            vec![0.0, 1.0]
        };
        let count = STEPS * own.degree().max(4);
        let mut shares = vec![0.0];
        for pair in breaks.windows(2) {
            shares.extend((1..=count).map(|k| pair[0] + (pair[1] - pair[0]) * (k as f64 / count as f64)));
        }
        let turns = chart.turns();
        let apart = |a: [f64; 2], b: [f64; 2], most: f64| {
            (0..2).any(|d| turns[d].is_some_and(|turn| (a[d] - b[d]).abs() > most * turn))
        };
        let points = shares.iter().map(|&share| pace.point(&own, share)).collect::<Result<Vec<Point>>>()?;
        let size = points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max);
        let (bound, near) = (
            (OF_SIZE * size).max(OF_TOLERANCE * edge.tolerance.min(1e-4 * size)),
            edge.tolerance.max(NEAR * size),
        );
        // A place by a pole is at all angles, but for noise: also at that of the place before it.
        let noise = noise(&points, edge.tolerance);
        let same = |a: [f64; 2], b: [f64; 2]| -> Result<bool> {
            let turned = [0, 1].map(|d: usize| if turns[d].is_some() { b[d] } else { a[d] });
            Ok(slip(chart, a, turned)?.is_some_and(|slip| slip <= noise))
        };
        let mut known: Vec<(f64, [f64; 2])> = Vec::with_capacity(shares.len());
        for (k, (&share, &point)) in shares.iter().zip(&points).enumerate() {
            let last = k + 1 == shares.len();
            let before = known.last().map_or(ends[0], |one| one.1);
            let mut at = chart.at(point, if last { ends[1] } else { before })?;
            if !(at[0].is_finite() && at[1].is_finite()) {
                return Ok(None);
            }
            if last && apart(at, ends[1], 0.25) && !same(at, ends[1])? {
                return Ok(None);
            }
            if apart(at, before, 0.25) {
                if !same(at, before)? {
                    return Ok(None);
                }
                (0..2).filter(|&d| turns[d].is_some()).for_each(|d| at[d] = before[d]);
            }
            known.push((share, at));
        }
        Ok(Some(Self { chart, own, pace, known, breaks, bound, near, noise }))
    }

    /// The least and the largest of each parameter, at the places that are known.
    pub(super) fn bounds(&self) -> [[f64; 2]; 2] {
        let all = |d: usize| self.known.iter().map(move |one| one.1[d]);
        [0, 1].map(|d| [all(d).fold(f64::INFINITY, f64::min), all(d).fold(f64::NEG_INFINITY, f64::max)])
    }

    /// The same on the surface, whole turns away.
    pub(super) fn shift(&mut self, by: [f64; 2]) {
        self.known.iter_mut().for_each(|one| (0..2).for_each(|d| one.1[d] += by[d]));
    }

    /// The edge in the parameters of the surface, and by how much it is off where that is more than the edge's tolerance says; `None` where it is nothing
    /// that is as near to it as it should be.
    ///
    /// A clamped curve of two coordinates over the parameters of the one in space: also a line, as one without ends begins nowhere.
    pub(super) fn drawn(&self) -> Result<Option<(Curve, f64)>> {
        // What stands still around the surface does so to the bit, for it is asked on which side of a seam it is: where the angles start, if it is there.
        let mut tries = vec![self.still(true), self.still(false), [None; 2]];
        tries.dedup();
        for still in tries {
            if let Some(line) = self.line(still, self.bound)?
                && self.holds(&line, self.near)?.is_some()
            {
                return Ok(Some((line, 0.0)));
            }
            if let Some(curve) = self.fitted(still)?
                && self.holds(&curve, self.near)?.is_some()
            {
                return Ok(Some((curve, 0.0)));
            }
        }
        // The nearer to a pole the more does noise turn a place: what stands still but for that does.
        let Some(line) = self.line(self.still_but_for_noise()?, self.noise)? else { return Ok(None) };
        Ok(self.holds(&line, self.noise)?.map(|off| (line, off)))
    }

    /// The same of what does not change by more than noise in space: as it is where a turn is longest.
    fn still_but_for_noise(&self) -> Result<[Option<f64>; 2]> {
        let mut all = [None; 2];
        for (d, turn) in self.chart.turns().into_iter().enumerate() {
            let Some(turn) = turn else { continue };
            let mut widest = (0.0, None);
            for (_, at) in &self.known {
                let mut across = *at;
                across[d] -= 0.25 * turn;
                let wide = self.slip(*at, across)?.unwrap_or(0.0);
                if wide > widest.0 {
                    widest = (wide, Some(at[d]));
                }
            }
            let Some(value) = widest.1 else { continue };
            let mut still = true;
            for (_, at) in &self.known {
                let mut there = *at;
                there[d] = value;
                still &= self.slip(*at, there)?.is_some_and(|slip| slip <= self.noise);
            }
            let nearest = self.whole(d, turn, value);
            all[d] = still.then(|| if (value - nearest).abs() <= MEANT * turn { nearest } else { value });
        }
        Ok(all)
    }

    /// The whole turn that is nearest to a value.
    fn whole(&self, d: usize, turn: f64, value: f64) -> f64 {
        let start = self.chart.starts()[d];
        start + ((value - start) / turn).round() * turn
    }

    /// Parameters around the surface that do not change along the edge but for rounding, and their values: whole turns where they are that `whole`, but for rounding.
    fn still(&self, whole: bool) -> [Option<f64>; 2] {
        let (turns, bounds) = (self.chart.turns(), self.bounds());
        [0, 1].map(|d: usize| {
            let (turn, [low, high]) = (turns[d]?, bounds[d]);
            let (value, near) = (0.5 * (low + high), MEANT * turn);
            let nearest = self.whole(d, turn, value);
            let value = if whole && (value - nearest).abs() <= near { nearest } else { value };
            (high - low <= near).then_some(value)
        })
    }

    /// How far apart two places are in space.
    fn slip(&self, a: [f64; 2], b: [f64; 2]) -> Result<Option<f64>> {
        slip(self.chart, a, b)
    }

    /// A line at an even pace, where the edge is one, within a bound.
    fn line(&self, still: [Option<f64>; 2], bound: f64) -> Result<Option<Curve>> {
        let (Some(first), Some(last)) = (self.known.first(), self.known.last()) else { return Ok(None) };
        let (from, to) = (self.pace.from, self.pace.to);
        let ends = [first.1, last.1].map(|at| self.on_plane(at, still));
        if ends[0] == ends[1] {
            return Ok(None);
        }
        let [start, end] = if self.pace.along() { ends } else { [ends[1], ends[0]] };
        let line = Curve::new(Space::clamped(1, &[from.min(to), from.max(to)])?, vec![start, end])?;
        for &(share, at) in &self.known {
            let slip = self.slip(at_parameter(&line, self.pace.at(share))?, at)?;
            if slip.is_none_or(|slip| slip > bound) {
                return Ok(None);
            }
        }
        Ok(Some(line))
    }

    /// Parameters as a point of the plane of them.
    fn on_plane(&self, at: [f64; 2], still: [Option<f64>; 2]) -> Point {
        let [u, v] = self.chart.inside([0, 1].map(|d: usize| still[d].unwrap_or(at[d])));
        Point::new(u, v, 0.0)
    }

    /// The parameters at a share of the edge.
    fn at(&self, share: f64) -> Result<[f64; 2]> {
        let k = self.known.partition_point(|one| one.0 <= share).clamp(1, self.known.len() - 1);
        let ((a, p), (b, q)) = (self.known[k - 1], self.known[k]);
        let part = (share - a) / (b - a);
        let near = [0, 1].map(|d: usize| p[d] + (q[d] - p[d]) * part);
        self.chart.at(self.pace.point(&self.own, share)?, near)
    }

    /// The ends of parts within which edge and surface are smooth.
    fn smooth_parts(&self) -> Result<Vec<f64>> {
        let mut all = self.breaks.clone();
        for pair in self.known.windows(2) {
            let [(a, p), (b, q)] = [pair[0], pair[1]];
            for d in 0..2 {
                for line in self.chart.rough(d, [p[d].min(q[d]), p[d].max(q[d])]) {
                    let (mut low, mut high) = (a, b);
                    for _ in 0..STEPS_TO_LINE {
                        let middle = 0.5 * (low + high);
                        let below = (self.at(middle)?[d] < line) == (p[d] < line);
                        (low, high) = if below { (middle, high) } else { (low, middle) };
                    }
                    all.push(0.5 * (low + high));
                }
            }
        }
        Ok(pieces::apart(all, LEAST))
    }

    /// Pieces through places of the edge, halved until each is near enough.
    fn fitted(&self, still: [Option<f64>; 2]) -> Result<Option<Curve>> {
        let parts = self.smooth_parts()?;
        let piece = |by: &Interpolation, a, b| self.piece(by, (a, b), still).map(Some);
        let Some(curve) = Interpolation::new().curve(&parts, LIMITS, piece)? else { return Ok(None) };
        let curve = if self.pace.along() { curve } else { curve.reverse()? };
        let (from, to) = (self.pace.from, self.pace.to);
        curve.reparametrise(from.min(to), from.max(to)).map(Some)
    }

    /// The Bézier points between two shares, and whether they are near enough.
    fn piece(&self, by: &Interpolation, (a, b): (f64, f64), still: [Option<f64>; 2]) -> Result<(Net, bool)> {
        let mut places = Net::default();
        for (place, x) in places.iter_mut().zip(by.nodes()) {
            *place = self.at(a + (b - a) * x)?;
        }
        let net = by.through(&places)?;
        let mut good = true;
        // Between the nodes, where it is worst.
        for x in by.between() {
            let slip = self.slip(pieces::at(&net, x), self.at(a + (b - a) * x)?)?;
            good &= slip.is_some_and(|slip| slip <= self.bound);
        }
        let on_plane = net.map(|at| self.on_plane(at, still)).map(|p| [p.x, p.y]);
        Ok((on_plane, good))
    }

    /// By how much a curve is off the edge, between the places through which it was made, too: `None` where that is more than `near` and more than the surface is.
    fn holds(&self, curve: &Curve, near: f64) -> Result<Option<f64>> {
        let mut shares = self.breaks.clone();
        let (from, to) = (self.pace.from, self.pace.to);
        shares.extend(curve.space().breakpoints().into_iter().map(|t| (t - from) / (to - from)));
        shares.sort_by(f64::total_cmp);
        let mut most = 0.0_f64;
        for pair in shares.windows(2) {
            for k in 0..=EACH {
                let share = (pair[0] + (pair[1] - pair[0]) * (k as f64 / EACH as f64)).clamp(0.0, 1.0);
                let Some(on) = self.chart.point(at_parameter(curve, self.pace.at(share))?)? else {
                    return Ok(None);
                };
                let point = self.pace.point(&self.own, share)?;
                let away = nalgebra::distance(&on, &point);
                most = most.max(away);
                if away <= near {
                    continue;
                }
                // An edge that is off its surface is nowhere nearer: then the nearest place is as good as can be.
                let foot = self.chart.point(self.at(share)?)?;
                if foot.is_none_or(|foot| away > AS_GOOD * nalgebra::distance(&foot, &point)) {
                    return Ok(None);
                }
            }
        }
        Ok(Some(most))
    }
}

/// How far an edge with these points may miss the pole of a surface by the noise of coordinates of some ten digits.
pub fn noise(points: &[Point], tolerance: f64) -> f64 {
    let Some(first) = points.first() else { return tolerance };
    let size = points.iter().map(|p| (p - first).norm()).fold(0.0, f64::max);
    let away = points.iter().map(|p| p.coords.norm()).fold(0.0, f64::max);
    tolerance.max(NEAR * size).max((NOISE * size).max(NOISE_FAR_AWAY * away).min(MOST_NOISE * size))
}

/// What a curve in parameters is at a parameter of its own.
fn at_parameter(curve: &Curve, t: f64) -> Result<[f64; 2]> {
    let (low, high) = curve.domain();
    let p = curve.point(t.clamp(low, high))?;
    Ok([p.x, p.y])
}

/// How far apart two places of a surface are in space; `None` beyond its domain.
fn slip(chart: &Chart<'_>, a: [f64; 2], b: [f64; 2]) -> Result<Option<f64>> {
    let (Some(a), Some(b)) = (chart.point(a)?, chart.point(b)?) else { return Ok(None) };
    Ok(Some(nalgebra::distance(&a, &b)))
}

/// Whether one of the parameters stands still along an edge of an elementary surface, within its tolerance.
pub(super) fn is_iso(chart: &Chart<'_>, edge: &Edge) -> Result<bool> {
    let own = edge.curve.between(edge.range.0, edge.range.1)?;
    let mut points = Vec::new();
    for pair in own.space().breakpoints().windows(2) {
        let count = 2 * own.degree().max(4);
        for k in 0..=count {
            points.push(own.point(pair[0] + (pair[1] - pair[0]) * (k as f64 / count as f64))?);
        }
    }
    let size = points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max);
    let near = edge.tolerance.max(NEAR * size);
    let Some(middle) = points.get(points.len() / 3) else { return Ok(false) };
    let middle = chart.at(*middle, [0.0; 2])?;
    let still = |d: usize| -> Result<bool> {
        for point in &points {
            let at = chart.at(*point, middle)?;
            let mut to = at;
            to[d] = middle[d];
            if slip(chart, at, to)?.is_none_or(|slip| slip > near) {
                return Ok(false);
            }
        }
        Ok(true)
    };
    Ok(still(0)? || still(1)?)
}
