//! Loops in the parameter plane, each curve where the one before it ends.

use super::{Found, Projected};
use crate::Point;
use crate::error::Result;
use crate::spline::space::Space;
use crate::spline::trimmed::ParameterCurve;
use crate::spline::{Curve, ParameterSide};

/// Places that are nearer than this share of a closed direction are one.
const SAME: f64 = 1e-6;

/// A use in the loop's direction.
struct Leg {
    found: Found,
    turned: bool,
    /// Where it starts and ends, none for an edge that is a point.
    ends: Option<[[f64; 2]; 2]>,
}

impl Leg {
    fn shift(&mut self, by: [f64; 2]) {
        if let Some(ends) = &mut self.ends {
            ends.iter_mut().for_each(|end| (0..2).for_each(|d| end[d] += by[d]));
        }
    }
}

/// A step along a pole: before which leg, in which direction, and by how much.
struct Leap {
    leg: usize,
    direction: usize,
    by: f64,
}

/// Shifts curves by whole periods so that the loop runs on. `turned` says which uses run against their edges; `reversed`, whether the face
/// is right of its loops.
pub(super) fn lay_out(
    found: Vec<Found>,
    turned: &[bool],
    sides: &[ParameterSide; 2],
    reversed: bool,
) -> Result<Vec<Projected>> {
    let mut legs = Vec::with_capacity(found.len());
    for (found, &turned) in found.into_iter().zip(turned) {
        let ends = match &found {
            Found::Curve(one) => {
                let [a, b] = one.curve.ends()?;
                Some(if turned { [b, a] } else { [a, b] })
            }
            Found::Point(_) => None,
        };
        legs.push(Leg { found, turned, ends });
    }
    let original: Vec<Option<[[f64; 2]; 2]>> = legs.iter().map(|leg| leg.ends).collect();
    let mut leaps: Vec<Leap> = Vec::new();
    let Some(first) = legs.iter().position(|leg| leg.ends.is_some()) else {
        return legs
            .iter()
            .map(|leg| point(sides.map(|side| side.low), sides.map(|side| side.low), leg))
            .collect();
    };
    let mut at = legs[first].ends.map_or([0.0; 2], |ends| ends[1]);
    for k in first + 1..legs.len() {
        let Some([start, _]) = legs[k].ends else { continue };
        let mut by = [0, 1].map(|d: usize| sides[d].unwrapped(start[d], at[d]) - start[d]);
        if let Some(leap) = leap(at, [start[0] + by[0], start[1] + by[1]], sides, reversed) {
            let (d, step) = leap;
            by[d] = at[d] + step - start[d];
            leaps.push(Leap { leg: k, direction: d, by: step });
        }
        legs[k].shift(by);
        at = legs[k].ends.map_or(at, |ends| ends[1]);
    }
    close(&mut legs, first, at, &mut leaps, sides, reversed);
    settle(&mut legs, sides);
    // Edges that are points lead from where the one before them ends to where the next one starts.
    let count = legs.len();
    let mut all = Vec::with_capacity(count);
    for (k, leg) in legs.iter().enumerate() {
        let Found::Curve(one) = &leg.found else {
            let before = (1..=count).find_map(|back| legs[(k + count - back) % count].ends);
            let after = (1..=count).find_map(|ahead| legs[(k + ahead) % count].ends);
            let (Some([_, a]), Some([b, _])) = (before, after) else { continue };
            // The first of several takes all of the way.
            let again = k > 0 && legs[k - 1].ends.is_none();
            all.push(point(if again { b } else { a }, b, leg)?);
            continue;
        };
        let by = match (leg.ends, original[k]) {
            (Some(now), Some(then)) => [now[0][0] - then[0][0], now[0][1] - then[0][1]],
            _ => [0.0; 2],
        };
        all.push(Projected { curve: shifted(&one.curve, by)?, error: one.error });
    }
    Ok(all)
}

/// Where two places are in one pole, by how much the loop goes along it: with the face to the left of the way, at most once around.
fn leap(from: [f64; 2], to: [f64; 2], sides: &[ParameterSide; 2], reversed: bool) -> Option<(usize, f64)> {
    for d in 0..2 {
        for (end, pole) in [sides[d].low, sides[d].high].into_iter().enumerate() {
            let on = |at: [f64; 2]| (at[d] - pole).abs() <= SAME * sides[d].length();
            if !(sides[d].poles[end] && on(from) && on(to)) {
                continue;
            }
            let along = &sides[1 - d];
            if !along.closed {
                return None;
            }
            // On the upper side of v the face is to the left of ways to smaller u, on that of u of ways to larger v.
            let ascends = ((end == 1) == (d == 0)) != reversed;
            let period = along.length();
            let step = (to[1 - d] - from[1 - d]).rem_euclid(period);
            let none = step.min(period - step) <= SAME * period;
            return Some((
                1 - d,
                match (none, ascends) {
                    (true, true) => period,
                    (true, false) => -period,
                    (false, true) => step,
                    (false, false) => step - period,
                },
            ));
        }
    }
    None
}

/// Where a loop that goes through a pole does not close, there is no way along that pole: the loop only touches it.
fn close(
    legs: &mut [Leg],
    first: usize,
    end: [f64; 2],
    leaps: &mut Vec<Leap>,
    sides: &[ParameterSide; 2],
    reversed: bool,
) {
    let Some([start, _]) = legs[first].ends else { return };
    let mut open = [0, 1].map(|d: usize| end[d] - start[d]);
    // The way from its end to its start may be along a pole itself: whatever is missing is that.
    let near = [0, 1].map(|d: usize| sides[d].unwrapped(start[d], end[d]));
    if let Some((d, by)) = leap(end, near, sides, reversed) {
        let around = end[d] + by - start[d];
        if around.abs() <= SAME * sides[d].length() {
            return;
        }
        open[d] = around;
    }
    for d in 0..2 {
        let period = sides[d].length();
        let turns = (open[d] / period).round();
        if !sides[d].closed || turns == 0.0 {
            continue;
        }
        // A whole turn along a pole that is none, where that closes the loop.
        let whole = leaps.iter().position(|leap| {
            leap.direction == d
                && (leap.by.abs() - period).abs() <= SAME * period
                && leap.by.signum() == turns.signum()
        });
        if let Some(leap) = whole.filter(|_| turns.abs() == 1.0).map(|k| leaps.remove(k)) {
            let mut by = [0.0; 2];
            by[d] = -leap.by;
            legs[leap.leg..].iter_mut().for_each(|leg| leg.shift(by));
        }
    }
}

/// A loop as a whole into the domain, as far as it can be.
fn settle(legs: &mut [Leg], sides: &[ParameterSide; 2]) {
    for d in 0..2 {
        if !sides[d].closed {
            continue;
        }
        let ends = legs.iter().filter_map(|leg| leg.ends).flatten().map(|end| end[d]);
        let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        let period = sides[d].length();
        let turns = ((0.5 * (low + high) - sides[d].low) / period + SAME).floor();
        let mut by = [0.0; 2];
        by[d] = -turns * period;
        if turns != 0.0 && turns.is_finite() {
            legs.iter_mut().for_each(|leg| leg.shift(by));
        }
    }
}

fn shifted(curve: &ParameterCurve, by: [f64; 2]) -> Result<ParameterCurve> {
    if by == [0.0; 2] {
        return Ok(curve.clone());
    }
    let (from, to) = curve.range();
    let (space, mut points, weights) = curve.curve().clone().into_parts();
    points.iter_mut().for_each(|p| *p = Point::new(p.x + by[0], p.y + by[1], 0.0));
    ParameterCurve::new(Curve::build(space, points, weights)?, from, to)
}

/// An edge that is a point, as the way in the plane from one place to another one, in the loop's direction.
fn point(from: [f64; 2], to: [f64; 2], leg: &Leg) -> Result<Projected> {
    let ends = if leg.turned { [to, from] } else { [from, to] };
    let points = ends.map(|p| Point::new(p[0], p[1], 0.0));
    let curve = ParameterCurve::whole(Curve::new(Space::clamped(1, &[0.0, 1.0])?, points.to_vec())?)?;
    let Found::Point(error) = leg.found else { return Ok(Projected { curve, error: 0.0 }) };
    Ok(Projected { curve, error })
}
