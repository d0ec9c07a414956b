//! Where points along an edge are on a surface, one after another.

use std::cell::Cell;

use crate::error::Result;
use crate::spline::trimmed::ParameterCurve;
use crate::spline::{Curve, ParameterSide, Surface};
use crate::{Point, Vector};

/// Steps of a span of an edge, at least.
const STEPS: usize = 8;
/// Places at which a file's curve is compared with its edge, for each span of either.
const MEASURED: usize = 12;
/// Pieces of the surface that all searches over the whole of it may look at, for one edge: some hundreds are the rule, and where a hundred
/// thousand do not tell which place is the nearest many are about as near.
const PIECES: usize = 100_000;
/// How much nearer another place may be for all that, as a part of the distance, and of what an edge may be off.
const SLACK: f64 = 1e-7;
/// Shares of the way from a pole at which parameters are looked at that have no value in the pole itself.
const NEAR_POLE: f64 = 1e-3;

/// A point of an edge and its foot.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    pub(super) t: f64,
    /// Unwrapped along the edge. At a pole the parameter along the side that the pole is has its limit along the edge.
    pub(super) at: [f64; 2],
    /// The distance of the point from its foot.
    pub(super) off: f64,
    /// The side of the domain that is a pole where the point is: direction and end.
    pub(super) pole: Option<(usize, usize)>,
}

/// A surface on which feet are looked for.
pub(super) struct Feet<'s> {
    pub(super) surface: &'s Surface,
    pub(super) sides: [ParameterSide; 2],
    poles: Vec<((usize, usize), Point)>,
    /// How near to a pole a point is in it.
    pole_reach: f64,
    /// How far from its point a foot is believed to be the nearest of all: what the edge was found to be off, or its tolerance.
    enough: Cell<f64>,
    /// Pieces that may still be looked at.
    left: Cell<usize>,
}

impl<'s> Feet<'s> {
    pub(super) fn new(surface: &'s Surface, sides: [ParameterSide; 2], enough: f64) -> Self {
        let mut poles = Vec::new();
        for (d, side) in sides.iter().enumerate() {
            for (end, x) in [side.low, side.high].into_iter().enumerate() {
                let mut at = sides.map(|side| side.low);
                at[d] = x;
                if side.poles[end]
                    && let Ok(point) = surface.point(at[0], at[1])
                {
                    poles.push(((d, end), point));
                }
            }
        }
        Self {
            surface,
            sides,
            poles,
            pole_reach: 2.0 * enough,
            enough: Cell::new(2.0 * enough),
            left: Cell::new(PIECES),
        }
    }

    /// The pole that a point is in.
    fn pole(&self, point: &Point) -> Option<(usize, usize)> {
        self.poles.iter().find(|(_, pole)| (pole - point).norm() <= self.pole_reach).map(|(which, _)| *which)
    }

    /// A place within the domain.
    pub(super) fn inside(&self, at: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|d: usize| {
            let side = &self.sides[d];
            // The high end of what closes is a place of its own: surfaces that are not periodic have it.
            if at[d] >= side.low && at[d] <= side.high { at[d] } else { side.wrapped(at[d]) }
        })
    }

    pub(super) fn point(&self, at: [f64; 2]) -> Result<Point> {
        let [u, v] = self.inside(at);
        self.surface.point(u, v)
    }

    /// The foot of a point, near a place where one is known: unwrapped to be as near to that as it can be.
    pub(super) fn foot(&self, point: Point, near: Option<[f64; 2]>) -> Result<([f64; 2], f64)> {
        let unwrapped = |at: (f64, f64)| {
            let at = [at.0, at.1];
            near.map_or(at, |near| [0, 1].map(|d: usize| self.sides[d].unwrapped(at[d], near[d])))
        };
        let mut best: Option<([f64; 2], f64)> = None;
        if let Some(near) = near {
            let start = self.inside(near);
            let found = self.surface.foot(point, (start[0], start[1]))?;
            best = Some((unwrapped(found.at), found.distance));
            // A surface that closes without being periodic ends for the search where it does not end: from its other side, too.
            for d in 0..2 {
                let side = &self.sides[d];
                // Held at an end it may be near enough, and still not the nearest.
                let at = [found.at.0, found.at.1][d];
                let held = at <= side.low || at >= side.high;
                let enough = best.is_some_and(|(_, distance)| distance <= self.enough.get());
                if enough && !held || !side.closed || self.surface_is_periodic(d) {
                    continue;
                }
                let mut other = start;
                other[d] = if start[d] - side.low < side.high - start[d] { side.high } else { side.low };
                let found = self.surface.foot(point, (other[0], other[1]))?;
                if best.is_none_or(|(_, distance)| found.distance < distance) {
                    best = Some((unwrapped(found.at), found.distance));
                }
            }
        }
        if let Some(best) = best.filter(|(_, distance)| *distance <= self.enough.get()) {
            return Ok(best);
        }
        if let Some(best) = best.filter(|_| self.left.get() == 0) {
            return Ok(best);
        }
        let slack = SLACK * self.enough.get();
        let (closest, looked) =
            self.surface.nearly_closest_of(point, slack, SLACK, self.left.get().max(1))?;
        self.left.set(self.left.get().saturating_sub(looked));
        let whole = (unwrapped(closest.at), closest.distance);
        // The edge is as far off as that: nobody needs to search all of the surface for that again.
        let found =
            best.filter(|(_, distance)| *distance <= closest.distance * (1.0 + 1e-6)).unwrap_or(whole);
        self.enough.set(self.enough.get().max(1.5 * found.1));
        Ok(found)
    }

    fn surface_is_periodic(&self, d: usize) -> bool {
        [self.surface.u(), self.surface.v()][d].is_periodic()
    }

    /// The foot of a point of an edge.
    pub(super) fn sample(&self, curve: &Curve, t: f64, near: Option<[f64; 2]>) -> Result<Sample> {
        let point = curve.point(t)?;
        let Some(pole) = self.pole(&point) else {
            let (at, off) = self.foot(point, near)?;
            return Ok(Sample { t, at, off, pole: None });
        };
        let (start, last) = curve.domain();
        let ahead = t - start < last - t;
        self.beside(curve, t, pole, if ahead { 1.0 } else { -1.0 }, near)
    }

    /// A place in a pole, as the edge leads there from one side: beside the pole the parameter along it has a value.
    fn beside(
        &self,
        curve: &Curve,
        t: f64,
        (d, end): (usize, usize),
        side: f64,
        near: Option<[f64; 2]>,
    ) -> Result<Sample> {
        let (start, last) = curve.domain();
        let step = side * NEAR_POLE * (last - start);
        let mut before = near;
        let mut beside = [0.0; 3];
        for (k, x) in beside.iter_mut().enumerate().rev() {
            let foot = self.foot(curve.point((t + step * (k + 1) as f64).clamp(start, last))?, before)?;
            *x = foot.0[1 - d];
            before = Some(foot.0);
        }
        let mut at = before.unwrap_or_default();
        at[1 - d] = 3.0 * beside[0] - 3.0 * beside[1] + beside[2];
        at[d] = [self.sides[d].low, self.sides[d].high][end];
        let off = (self.point(at)? - curve.point(t)?).norm();
        Ok(Sample { t, at, off, pole: Some((d, end)) })
    }

    /// Feet of an edge's points at both ends and at some places of each of its spans, from its middle on both ways.
    pub(super) fn along(&self, curve: &Curve) -> Result<Vec<Sample>> {
        let breaks = curve.space().breakpoints();
        let steps = (2 * curve.degree() + 2).max(STEPS);
        let mut places = vec![breaks[0]];
        for pair in breaks.windows(2) {
            places.extend((1..=steps).map(|k| pair[0] + (pair[1] - pair[0]) * (k as f64 / steps as f64)));
        }
        if let (Some(last), Some(&end)) = (places.last_mut(), breaks.last()) {
            *last = end;
        }
        // Away from its ends, where seams and poles are.
        let middle = places.len() / 2;
        let mut after = Vec::with_capacity(places.len());
        let mut near = None;
        for &t in &places[middle..] {
            let sample = self.sample(curve, t, near)?;
            near = Some(sample.at);
            after.push(sample);
        }
        let mut all = Vec::with_capacity(places.len());
        near = after.first().map(|sample| sample.at);
        for &t in places[..middle].iter().rev() {
            let sample = self.sample(curve, t, near)?;
            near = Some(sample.at);
            all.push(sample);
        }
        all.reverse();
        all.extend(after);
        self.through_poles(curve, all)
    }

    /// Where an edge goes through a pole, a place for either side.
    fn through_poles(&self, curve: &Curve, samples: Vec<Sample>) -> Result<Vec<Sample>> {
        let (start, end) = curve.domain();
        let least = 1e-6 * (end - start);
        let mut passed: Vec<(f64, (usize, usize))> = Vec::new();
        for (which, pole) in &self.poles {
            let mut away = Vec::with_capacity(samples.len());
            for sample in &samples {
                away.push((curve.point(sample.t)? - pole).norm());
            }
            for k in 0..samples.len() {
                let no_nearer = |other: Option<&f64>| other.is_none_or(|other| *other >= away[k]);
                if no_nearer(k.checked_sub(1).and_then(|k| away.get(k))) && no_nearer(away.get(k + 1)) {
                    let (t, off) = nearest(curve, pole, samples[k].t)?;
                    if off <= self.pole_reach && t > start + least && t < end - least {
                        passed.push((t, *which));
                    }
                }
            }
        }
        passed.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        passed.dedup_by(|a, b| a.0 - b.0 <= least);
        if passed.is_empty() {
            return Ok(samples);
        }
        let mut all = Vec::with_capacity(samples.len() + 2 * passed.len());
        let mut rest = samples.into_iter().peekable();
        for (t, which) in passed {
            while let Some(sample) = rest.next_if(|sample| sample.t < t - least) {
                all.push(sample);
            }
            while rest.next_if(|sample| sample.t <= t + least).is_some() {}
            let before = all.last().map(|sample| sample.at);
            all.push(self.beside(curve, t, which, -1.0, before)?);
            all.push(self.beside(curve, t, which, 1.0, rest.peek().map(|sample| sample.at))?);
        }
        all.extend(rest);
        Ok(all)
    }

    /// How far the surface along a curve of its parameter plane is from an edge, as sets: at places of both.
    pub(super) fn measured(&self, own: &ParameterCurve, edge: &Curve) -> Result<f64> {
        let (from, to) = own.range();
        let part = own.curve().between(from, to)?;
        let (a, b) = part.domain();
        let spans = part.space().breakpoints().len().max(edge.space().breakpoints().len()) - 1;
        let count = MEASURED * spans;
        let (start, end) = edge.domain();
        let mut worst = 0.0_f64;
        let mut t = start;
        for k in 0..=count {
            let share = k as f64 / count as f64;
            let p = part.point((a + (b - a) * share).min(b))?;
            let on = self.point([p.x, p.y])?;
            // Its speed is not the edge's: the nearest of the edge's points from where the last one was, or from the same share.
            let guess = start + (end - start) * share;
            let tries = [t, guess].map(|from| nearest(edge, &on, from));
            let [one, other] = tries;
            let (one, other) = (one?, other?);
            let better = if other.1 < one.1 { other } else { one };
            t = better.0;
            worst = worst.max(better.1);
        }
        // Both ends of the edge are reached.
        for (t, s) in [(start, a), (end, b)] {
            let p = part.point(s)?;
            worst = worst.max((self.point([p.x, p.y])? - edge.point(t)?).norm());
        }
        Ok(worst)
    }
}

/// The point of a curve nearest to a point downhill from a parameter, and its distance: Gauss and Newton's steps, halved until they lead nearer.
fn nearest(curve: &Curve, point: &Point, from: f64) -> Result<(f64, f64)> {
    let (start, end) = curve.domain();
    let mut t = from.clamp(start, end);
    let mut d = [Vector::zeros(); 2];
    curve.derivatives_into(t, &mut d)?;
    let mut away = point.coords - d[0];
    for _ in 0..40 {
        let squared = d[1].norm_squared();
        if squared == 0.0 {
            break;
        }
        let mut step = away.dot(&d[1]) / squared;
        let mut moved = false;
        for _ in 0..30 {
            let next = (t + step).clamp(start, end);
            if next == t {
                break;
            }
            let mut there = [Vector::zeros(); 2];
            curve.derivatives_into(next, &mut there)?;
            let further = point.coords - there[0];
            if further.norm_squared() < away.norm_squared() {
                (t, d, away, moved) = (next, there, further, true);
                break;
            }
            step *= 0.5;
        }
        if !moved {
            break;
        }
    }
    Ok((t, away.norm()))
}
