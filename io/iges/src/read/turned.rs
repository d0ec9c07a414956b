//! Which way loops run on surfaces that close.
//!
//! Files have boundaries either way round. On a surface that closes, the corners of a loop alone do not say which way it runs, as the same point has several parameters: its edges
//! are laid out one after another, without a jump but along poles.

use loftsman_kernel::Result;
use loftsman_kernel::brep::{Brep, Use, is_around};
use loftsman_kernel::spline::ParameterSide;
use loftsman_kernel::spline::trimmed::ParameterCurve;

/// So many places of each curve say which way a loop turns, and how far it reaches.
const PLACES: usize = 32;
/// Places that are nearer than this part of the domain are one.
const SAME: f64 = 1e-3;
/// Surfaces close within this part of their size.
const CLOSED: f64 = 1e-6;
/// By how much more, as a part of a turn, a loop reaches around if it runs the wrong way, at least.
const FURTHER: f64 = 1e-6;

/// So many seams that close are exchanged at most.
const RINGS: usize = 3;

/// What a loop is as it runs.
struct Way {
    /// Whether it runs counterclockwise about the normal of the face.
    counterclockwise: bool,
    /// Whether the face is outside of it: a seam within the face is there.
    hole: bool,
    /// By how much it reaches further around than the surface, as a part of a turn.
    beyond: f64,
}

impl Way {
    /// Whether the face is to the left, of the outer loop or of another.
    fn is_right(&self, outer: bool) -> bool {
        self.counterclockwise == (outer && !self.hole)
    }
}

/// A Brep of one face whose loops run counterclockwise where they are the outer one, else clockwise; as they are where they go around the surface, and where
/// nothing says which way is right.
///
/// A seam that closes, as a torus has it, starts and ends in one point: of its two uses files do not say which one comes first. They are exchanged where the loop bounds more than
/// the surface otherwise.
///
/// # Errors
/// When an evaluation overflows.
pub(super) fn turned(brep: Brep, outer: &[bool]) -> Result<Brep> {
    let twice = |one: &Use| brep.uses(one.edge).len() == 2;
    if brep.loops(0).iter().flatten().all(twice) {
        return Ok(brep);
    }
    let own = ways(&brep)?;
    let fits = |way: &Option<Way>, outer: bool| {
        way.as_ref().is_none_or(|way| way.is_right(outer) && way.beyond <= FURTHER)
    };
    if own.iter().zip(outer).all(|(way, &outer)| fits(way, outer)) {
        return Ok(brep);
    }
    // What each loop is as it runs, the other way round, and with seams exchanged.
    let mut best: Vec<(Option<Way>, Vec<Use>)> = own.into_iter().zip(brep.loops(0).to_vec()).collect();
    let rings: Vec<usize> = (0..brep.edge_count())
        .filter(|&edge| brep.uses(edge).len() == 2 && brep.ends(edge).is_some_and(|[a, b]| a == b))
        .take(RINGS)
        .collect();
    for choice in 1..1_usize << (rings.len() + 1) {
        let mut parts = brep.parts();
        for chain in &mut parts.faces[0].loops {
            for one in chain.iter_mut() {
                let ring = rings.iter().position(|&edge| edge == one.edge);
                one.reversed ^= ring.is_some_and(|k| choice >> (k + 1) & 1 == 1);
            }
            if choice & 1 == 1 {
                chain.reverse();
                chain.iter_mut().for_each(|one| one.reversed = !one.reversed);
            }
        }
        let loops = parts.faces[0].loops.clone();
        let found = ways(&Brep::new(parts)?)?.into_iter().zip(loops);
        for ((best, found), &outer) in best.iter_mut().zip(found).zip(outer) {
            let (Some(known), Some(way)) = (&best.0, &found.0) else { continue };
            let (good, better) = (known.is_right(outer), way.is_right(outer));
            if better && (!good || way.beyond + FURTHER < known.beyond) {
                *best = found;
            }
        }
    }
    let mut parts = brep.parts();
    parts.faces[0].loops = best.into_iter().map(|(_, chain)| chain).collect();
    Brep::new(parts)
}

/// How each loop of the face runs; `None` of one that goes around the surface.
fn ways(brep: &Brep) -> Result<Vec<Option<Way>>> {
    let Some(surface) = brep.surface(0) else { return Ok(Vec::new()) };
    let points = surface.points();
    let size = points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max);
    let sides = surface.parameter_sides(CLOSED * size)?;
    let curves = brep.parameter_curves(0)?;
    let all = brep.loops(0).iter().zip(&curves);
    all.map(|(uses, curves)| {
        let runs = uses.iter().zip(curves).map(|(one, found)| places(&found.curve, one.reversed));
        Ok(way(uses, &runs.collect::<Result<Vec<_>>>()?, &sides, brep.is_reversed(0)))
    })
    .collect()
}

/// Places along a curve.
fn places(curve: &ParameterCurve, reversed: bool) -> Result<Vec<[f64; 2]>> {
    let (from, to) = curve.range();
    (0..=PLACES)
        .map(|k| {
            let k = if reversed { PLACES - k } else { k };
            let t = from + (to - from) * (k as f64 / PLACES as f64);
            let p = curve.curve().point(t.min(to))?;
            Ok([p.x, p.y])
        })
        .collect()
}

fn way(uses: &[Use], runs: &[Vec<[f64; 2]>], sides: &[ParameterSide; 2], reversed: bool) -> Option<Way> {
    let near = |d: usize, a: f64, b: f64| (a - b).abs() <= SAME * sides[d].length();
    for (run, next) in runs.iter().zip(runs.iter().cycle().skip(1)) {
        let (end, start) = (run.last()?, next.first()?);
        let at_pole = |d: usize| {
            let ends = [sides[d].low, sides[d].high].into_iter().zip(sides[d].poles);
            ends.into_iter().any(|(pole, is)| is && near(d, end[d], pole) && near(d, start[d], pole))
        };
        if !(0..2).all(|d| near(d, end[d], start[d])) && !(0..2).any(at_pole) {
            return None;
        }
    }
    // A seam that is run through there and back on one side of it bounds nothing.
    let middle = |k: usize| runs[k][PLACES / 2];
    let is_spur = |&k: &usize| {
        uses.iter().enumerate().any(|(other, one)| {
            other != k && one.edge == uses[k].edge && (0..2).all(|d| near(d, middle(other)[d], middle(k)[d]))
        })
    };
    let spurs: Vec<usize> = (0..uses.len()).filter(is_spur).collect();
    let kept = runs.iter().enumerate().filter(|(k, _)| !spurs.contains(k));
    let all: Vec<[f64; 2]> = kept.flat_map(|(_, run)| run).copied().collect();
    let next = all.iter().skip(1).chain(all.first());
    let twice: f64 = all.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum();
    let beyond = |d: usize| {
        let ends = all.iter().map(|p| p[d]);
        let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        if sides[d].closed { ((high - low) / sides[d].length() - 1.0).max(0.0) } else { 0.0 }
    };
    Some(Way {
        counterclockwise: (twice > 0.0) != reversed,
        hole: spurs.first().is_some_and(|&k| !is_around(&all, middle(k))),
        beyond: beyond(0).max(beyond(1)),
    })
}
