//! How a curve runs beside an edge: found by where both are.

use loftsman_kernel::error::Result;
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::topology::{EdgeCurve, TOGETHER};
use loftsman_kernel::{Point, Vector};

use super::{Askew, Track};

/// Places at which edge and curve are compared to find the way round.
const COMPARED: usize = 17;
/// The most places of a closed curve that are tried as its start.
const STARTS: usize = 64;
/// Places at which two closed ones are compared, and as many starts that are tried evenly.
const ROUND: usize = 64;
/// Golden sections of the way between two of these starts: the start is known to 1e-8 of a turn.
const SECTIONS: usize = 40;
/// A start at which breakpoints lie beside one another is as good as the best one where its squared distances are no more than this part larger …
const AS_NEAR: f64 = 0.02;
/// … or differ by no more than the squares of this part of the edge's size, and where lines across run askew by no more than this part of a turn.
const TURNED: f64 = 1e-6;
const ASKEW: f64 = 1.0 / 720.0;
/// Where the edge may have to be the curve, corners of both, or what may be one, that lie no further than this part of a turn from one another (6°) meet.
const CORNERS: f64 = 1.0 / 60.0;
/// A start no further than this part of a turn from a knot of the curve is at it.
const AT_KNOT: f64 = 1e-6;

/// Straight on or backwards, whichever is nearer; of equals straight on.
pub(super) fn straight(edge: &Curve, curve: &Curve) -> Result<Track> {
    let ((a, b), (c, d)) = (edge.domain(), curve.domain());
    let tracks = [(c, false), (d, true)].map(|(start, reversed)| Track {
        edge: (a, b),
        curve: (c, d),
        start,
        reversed,
    });
    let mut far = [0.0; 2];
    for i in 0..COMPARED {
        let t = (a + (b - a) * i as f64 / (COMPARED - 1) as f64).min(b);
        let point = edge.point(t)?;
        for (far, track) in far.iter_mut().zip(&tracks) {
            *far += (curve.point(track.there(t))? - point).norm();
        }
    }
    Ok(tracks[usize::from(far[1] < far[0] * (1.0 - TOGETHER))])
}

/// The way and the start at which a closed curve is nearest to a closed edge. A grid of starts, then golden sections. `O(1)` places of both, and the
/// breakpoints of the curve up to some number of them.
pub(super) fn round(edge: &EdgeCurve, curve: &Curve, exact: bool) -> Result<(Track, Option<Askew>)> {
    let size = edge.spread();
    let edge = &edge.curve;
    let ((a, b), (c, d)) = (edge.domain(), curve.domain());
    let breaks = curve.space().breakpoints();
    let track = |start: f64, reversed: bool| {
        // Where it is a knot but for rounding it is that.
        let start = if start < c { start + (d - c) } else { start };
        let start = if start > d { start - (d - c) } else { start };
        let knot = breaks.iter().find(|k| (*k - start).abs() <= TOGETHER * (d - c));
        let start = knot.copied().unwrap_or(start);
        // The start of a curve run backwards is its end.
        let start = if reversed && start <= c {
            d
        } else if !reversed && start >= d {
            c
        } else {
            start
        };
        Track { edge: (a, b), curve: (c, d), start, reversed }
    };
    let share = |k: usize| k as f64 / ROUND as f64;
    let places: Vec<f64> = (0..ROUND).map(|k| a + (b - a) * share(k)).collect();
    let own = places.iter().map(|t| edge.point(*t)).collect::<Result<Vec<_>>>()?;
    let grid = (0..ROUND).map(|k| curve.point(c + (d - c) * share(k))).collect::<Result<Vec<_>>>()?;
    // How far they are apart, but for where their middles are, which no start changes: there would be nothing to see of it beside a wide gap.
    let apart = |there: &dyn Fn(usize) -> Result<Point>| -> Result<f64> {
        let ways = own.iter().enumerate().map(|(k, p)| Ok(there(k)? - p)).collect::<Result<Vec<_>>>()?;
        let middle = ways.iter().sum::<Vector>() / ROUND as f64;
        Ok(ways.iter().map(|way| ((way - middle) / size).norm_squared()).sum())
    };
    let of = |track: &Track| apart(&|k| curve.point(track.there(places[k])));
    let mut least: Option<(f64, usize, bool)> = None;
    for reversed in [false, true] {
        for start in 0..ROUND {
            let there = |k: usize| if reversed { (start + ROUND - k) % ROUND } else { (start + k) % ROUND };
            let far = apart(&|k| Ok(grid[there(k)]))?;
            // Of equals the first: straight on, from the start.
            if least.is_none_or(|(least, ..)| far < least * (1.0 - TOGETHER)) {
                least = Some((far, start, reversed));
            }
        }
    }
    let (_, start, reversed) = least.unwrap_or((0.0, 0, false));
    let turn = |share: f64| track(c + (d - c) * share.rem_euclid(1.0), reversed);
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut low, mut high) = (share(start) - share(1), share(start) + share(1));
    let inner = |low: f64, high: f64| [high - golden * (high - low), low + golden * (high - low)];
    let mut values = [0.0; 2];
    for (value, at) in values.iter_mut().zip(inner(low, high)) {
        *value = of(&turn(at))?;
    }
    for _ in 0..SECTIONS {
        let [x, y] = inner(low, high);
        if values[0] <= values[1] {
            high = y;
            values = [of(&turn(inner(low, high)[0]))?, values[0]];
        } else {
            low = x;
            values = [values[1], of(&turn(inner(low, high)[1]))?];
        }
    }
    let mut best = turn(0.5 * low + 0.5 * high);
    let mut far = of(&best)?;
    let inside = breaks.iter().copied().filter(|&k| k > c && k < d).take(STARTS);
    let starts: Vec<Track> = std::iter::once(c)
        .chain(inside)
        .flat_map(|start| [false, true].map(|way| track(start, way)))
        .collect();
    // Those are better as well where the grid was too coarse.
    let mut alike: Option<(f64, Track)> = None;
    for track in starts {
        let found = of(&track)?;
        if found < far * (1.0 - TOGETHER) {
            (far, best) = (found, track);
        }
        let nearer = alike.is_none_or(|(least, _)| found < least * (1.0 - TOGETHER));
        if nearer && track.agrees(edge.space(), curve.space()) {
            alike = Some((found, track));
        }
    }
    // Golden sections find a knot but for rounding.
    let length = d - c;
    let away = |u: f64, v: f64| {
        let turn = ((u - v) / length).rem_euclid(1.0);
        turn.min(1.0 - turn)
    };
    if let Some(&knot) = breaks.iter().find(|&&knot| away(knot, best.start) <= AT_KNOT) {
        best = track(knot, best.reversed);
    }
    let enough = far * (1.0 + AS_NEAR) + ROUND as f64 * TURNED * TURNED;
    let turned = |track: &Track| {
        if track.reversed == best.reversed { away(track.start, best.start) } else { 1.0 }
    };
    let as_good = |(found, track): &(f64, Track)| *found <= enough && turned(track) <= ASKEW;
    let begun = match alike.filter(|one| exact || as_good(one)) {
        Some((_, track)) => track,
        None => track(best.start + together(edge.space(), curve.space(), &best, exact), best.reversed),
    };
    let turn = turned(&begun);
    let seam = !edge.space().is_periodic();
    // Run the other way it is as far off as can be; nothing is askew of what looks the same from everywhere.
    let askew = (turn > ASKEW && far * (1.0 + AS_NEAR) < of(&begun)?).then_some(Askew {
        turn: turn.min(0.5),
        nearest: best.start,
        seam,
    });
    Ok((begun, askew))
}

/// How much farther along a closed curve it is begun so that knots of edge and curve that lie all but beside one another do: two knots with next to nothing
/// between them would be a piece that nothing holds. Where both have their corners, or what may be one, first; else as many as can be; and by no more than
/// [`ASKEW`], which turns what runs across by next to nothing, or for corners of what is to be `exact` by no more than [`CORNERS`].
pub(super) fn together(edge: &Space, curve: &Space, track: &Track, exact: bool) -> f64 {
    let length = curve.length();
    let around = |space: &Space| {
        let mut breaks = space.breakpoints();
        // The end of what is closed is its start.
        breaks.pop();
        breaks.truncate(STARTS);
        breaks
    };
    let off = |t: f64, knot: f64| {
        let off = ((knot - track.there(t)) / length).rem_euclid(1.0);
        if off > 0.5 { off - 1.0 } else { off }
    };
    let near = |edges: &[f64], knots: &[f64], within: f64| -> Vec<f64> {
        let each = edges.iter().flat_map(|t| knots.iter().map(move |knot| off(*t, *knot)));
        let mut all: Vec<f64> = each.filter(|off| off.abs() <= within).collect();
        all.sort_by(f64::total_cmp);
        all
    };
    let sharp = |space: &Space| {
        let start = space.domain().0;
        let may_turn = |knot: &f64| {
            !space.is_periodic() && *knot == start || space.multiplicity(*knot) >= space.degree()
        };
        around(space).into_iter().filter(may_turn).collect::<Vec<f64>>()
    };
    let mut all = near(&sharp(edge), &sharp(curve), if exact { CORNERS } else { ASKEW });
    if all.is_empty() {
        all = near(&around(edge), &around(curve), ASKEW);
    }
    // Of those that can be met at once the most, and of equals the nearest.
    let mut best = None::<(usize, f64)>;
    for (k, low) in all.iter().enumerate() {
        let met = all[k..].partition_point(|off| off - low <= AT_KNOT);
        let at = all[k + met / 2];
        if best.is_none_or(|(most, by)| met > most || met == most && at.abs() < by.abs()) {
            best = Some((met, at));
        }
    }
    best.map_or(0.0, |(_, by)| by * length)
}

/// The largest coordinate of a curve's control vertices.
pub(super) fn size_of(curve: &Curve) -> f64 {
    curve.points().iter().fold(0.0, |most: f64, p| most.max(p.coords.amax()))
}
