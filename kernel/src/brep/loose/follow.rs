//! A face whose boundary follows another face along an edge: knots enough for that, and the places at which it does.
//!
//! There is one place for each control vertex of the boundary that is free to follow, so that it can be anywhere that the other face goes. What
//! holds already, because something else is kept that comes to the same, must not be asked again: places and that other thing agree but
//! for what interpolation leaves, and two equations that nearly agree throw control vertices about. So the places are those of a
//! boundary that has no corners where it goes on being smooth, and the one beside an end is left out where what meets it there says it.

use std::collections::{BTreeMap, BTreeSet};

use super::super::{Brep, UsePlace};
use super::pair::{Tie, line, strand};
use super::room::Place;
use super::sheet::Sheet;
use super::strand::{Strand, inside, location, own_places};
use super::trace::{Line, Trace};
use crate::error::Result;
use crate::shape::{Derivative, Location, Shape, Side, Stencil};
use crate::spline::{Curve, Space};
use crate::{Point, Vector};

/// A boundary that has to go along with what is no spline in its space has so many spans at least.
const SPANS: usize = 32;
/// The most between two knots of the other one.
const EACH: usize = 16;
/// What is left between places, as a part of the way, is about the part by which the pace changes from one knot of the other face to the next,
/// times this, over the fourth power of the number of spans there...
const WORST: f64 = 25.0;
/// ... and should be no more than this beside the place that is moved. From there a movement falls off by this factor from knot to knot.
const LEFT: f64 = 1e-5;
const FALL: f64 = 3.0;
/// A boundary is given a degree up to this, so that it can be any polynomial that the other one is.
const ELEVATED: usize = 7;
/// Directions whose sine is no larger are one: edges that run on across a smooth one.
const ONWARD: f64 = 1e-3;
/// Coefficients below this part of the largest are rounding.
const ROUNDING: f64 = 1e-9;

/// What edges are, for the places at which one of them follows.
pub(super) struct Edges<'a> {
    pub(super) sheets: &'a BTreeMap<usize, Sheet>,
    pub(super) ties: &'a BTreeMap<usize, Tie>,
    pub(super) smooth: &'a BTreeSet<usize>,
    /// Which control vertices may move.
    pub(super) free: &'a [bool],
}

/// One end of a use: its curve's start or end.
type End = (UsePlace, bool);

impl Brep {
    /// The uses of an edge of which the first follows the second, along a line of its parameters, one pair for each face beside the first.
    pub(super) fn following<'a>(
        &'a self,
        edge: usize,
        sheets: &BTreeMap<usize, Sheet>,
    ) -> Vec<(&'a UsePlace, &'a UsePlace, Line)> {
        let Some((first, others)) = self.uses(edge).split_first() else { return Vec::new() };
        // The one whose boundary is a spline of its own follows the other one.
        let pair = |other: &'a UsePlace| match (line(sheets, first), line(sheets, other)) {
            (_, Some(along)) => Some((other, first, along)),
            (Some(along), None) => Some((first, other, along)),
            (None, None) => None,
        };
        others.iter().filter_map(pair).collect()
    }

    /// Gives a face a degree along an edge at which it can be any polynomial that the other one is.
    pub(super) fn elevate_along(
        &self,
        edge: usize,
        tied: Tie,
        sheets: &mut BTreeMap<usize, Sheet>,
    ) -> Result<()> {
        if tied != Tie::Polynomials {
            return Ok(());
        }
        for (one, beside, along) in self.following(edge, sheets) {
            let degree = strand(sheets, beside)?.and_then(|strand| strand.degree());
            if let (Some(degree), Some(sheet)) = (degree, sheets.get_mut(&one.face)) {
                sheet.elevated(&along, degree.min(ELEVATED))?;
            }
        }
        Ok(())
    }

    /// Gives a face knots along an edge: where the other one has some, as often as it needs them there; and between them, where
    /// it has to go along with what its space does not hold, the more the nearer to one of these `places`.
    pub(super) fn refine_along(
        &self,
        edge: usize,
        tied: Tie,
        places: &[Place],
        sheets: &mut BTreeMap<usize, Sheet>,
    ) -> Result<()> {
        if tied == Tie::Lines {
            return Ok(());
        }
        for (one, beside, along) in self.following(edge, sheets) {
            let (Some(own), Some(leader)) = (strand(sheets, one)?, strand(sheets, beside)?) else { continue };
            let degree = along.space(own.surface).degree();
            let exact = tied == Tie::Polynomials && leader.degree().is_some_and(|d| d <= degree);
            let mut shares = Vec::new();
            for t in leader.breaks()? {
                shares.push(own.share(own.nearest(leader.point(t)?, leader.share(t))?));
            }
            shares.sort_by(f64::total_cmp);
            let times = if exact { degree.saturating_sub(leader.smoothness()).max(1) } else { 1 };
            let at = |share: f64| along.from + (along.to - along.from) * share;
            let mut knots: Vec<(f64, usize)> = shares.iter().map(|share| (at(*share), times)).collect();
            let mut near = Vec::new();
            for (face, [u, v]) in places.iter().filter(|(face, _)| [one.face, beside.face].contains(face)) {
                let surface = if *face == one.face { own.surface } else { leader.surface };
                let (u, v) = inside(surface, *u, *v);
                let share = own.share(own.closest(surface.point(u, v)?)?.0);
                near.push(shares.partition_point(|s| *s < share));
            }
            for (number, pair) in shares.windows(2).enumerate().filter(|_| !exact) {
                let away = near.iter().map(|n| n.abs_diff(number + 1)).min().unwrap_or(0);
                let left = WORST * bend(&own, &leader, [pair[0], pair[1]])? / FALL.powf(away as f64);
                let needed = (left / LEFT).powf(0.25).ceil().clamp(1.0, EACH as f64);
                let each = needed.max(((pair[1] - pair[0]) * SPANS as f64).ceil()) as usize;
                let inner = (1..each).map(|k| pair[0] + (pair[1] - pair[0]) * (k as f64 / each as f64));
                knots.extend(inner.map(|share| (at(share), 1)));
            }
            if let Some(sheet) = sheets.get_mut(&one.face) {
                sheet.knotted(&along, &knots)?;
            }
        }
        Ok(())
    }

    /// The shares of a line at which a face follows another one.
    pub(super) fn follow_at(
        &self,
        one: &UsePlace,
        along: &Line,
        (leader, beside): (&Strand<'_>, &UsePlace),
        edges: &Edges<'_>,
    ) -> Result<Vec<f64>> {
        let Some(product) = self.product(one.face) else { return Ok(Vec::new()) };
        let trace = Trace::of(&product, along)?;
        let places = own_places(&without_corners(&trace, self.points())?);
        let (a, b) = trace.space.domain();
        let mut shares: Vec<f64> = places.into_iter().map(|t| ((t - a) / (b - a)).clamp(0.0, 1.0)).collect();
        for end in [true, false] {
            let beside_end = if end { trace.space.len() - 2 } else { 1 };
            let held = !self.is_free(&trace.row(beside_end), edges)
                && !self.is_free(&self.leaving(leader, beside, end)?, edges);
            if shares.len() > 2 && (held || self.is_spare((*one, end), edges)?) {
                shares.remove(if end { shares.len() - 2 } else { 1 });
            }
        }
        Ok(shares)
    }

    fn is_free(&self, row: &Stencil, edges: &Edges<'_>) -> bool {
        let largest = row.coefficients().iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        row.iter().any(|(v, c)| edges.free[v] && c.abs() > ROUNDING * largest)
    }

    /// The derivative of a face along a curve on it, at an end of that.
    fn leaving(&self, strand: &Strand<'_>, place: &UsePlace, end: bool) -> Result<Stencil> {
        let (from, to) = strand.curve.range();
        let t = if end { to } else { from };
        let by = strand.curve.curve().derivative(t, 1)?;
        let at = location(strand.surface, place.face, strand.parameters(t)?);
        let by_u = self.stencil(at, Derivative::from([1, 0]))?.scaled(by.x);
        let by_v = self.stencil(at, Derivative::from([0, 1]))?.scaled(by.y);
        Ok(by_u.iter().chain(by_v.iter()).collect())
    }

    /// Whether the derivative of a face along an edge at its end is what others say already: a face goes on there smoothly, across another
    /// edge, and its own edge in the same direction.
    fn is_spare(&self, end: End, edges: &Edges<'_>) -> Result<bool> {
        let Some((corner, other)) = self.onward(end) else { return Ok(false) };
        let across = self.loops(corner.0.face)[corner.0.chain][corner.0.number].edge;
        if !edges.smooth.contains(&across) {
            return Ok(false);
        }
        let chain = &self.loops(other.0.face)[other.0.chain];
        let edge = chain[other.0.number].edge;
        let Some(tie) = edges.ties.get(&edge) else { return Ok(false) };
        let follows =
            *tie != Tie::Lines && self.following(edge, edges.sheets).iter().any(|(one, ..)| **one == other.0);
        // Of two that follow, one leaves it out: that with the shorter span there, as places in a sliver say little of a direction.
        if follows {
            let spans = self.span(end, edges)?.total_cmp(&self.span(other, edges)?);
            if spans.then(end.cmp(&other)).is_gt() {
                return Ok(false);
            }
        }
        let (Some(a), Some(b)) = (self.direction(end, edges)?, self.direction(other, edges)?) else {
            return Ok(false);
        };
        Ok(a.cross(&b).norm() <= ONWARD)
    }

    /// About how long the last span of a boundary is at an end of a use.
    fn span(&self, (place, end): End, edges: &Edges<'_>) -> Result<f64> {
        let (Some(strand), Some(along)) = (strand(edges.sheets, &place)?, line(edges.sheets, &place)) else {
            return Ok(0.0);
        };
        let Some(sheet) = edges.sheets.get(&place.face) else { return Ok(0.0) };
        let at = if end { along.to } else { along.from };
        let whole = (along.to - along.from).abs();
        let least = sheet.breaks_along(&along).into_iter().map(|t| (t - at).abs()).fold(whole, f64::min);
        Ok(least / whole * strand.size())
    }

    /// The end of the use that a loop has beside an end of one, and that of the use that lies beyond: in the face on the other side of that edge.
    fn onward(&self, (place, end): End) -> Option<(End, End)> {
        let step = |place: UsePlace, end: bool| {
            let chain = self.loops(place.face).get(place.chain)?;
            let forth = end != chain.get(place.number)?.reversed;
            let count = chain.len();
            let number = (place.number + if forth { 1 } else { count - 1 }) % count;
            let next = chain.get(number)?;
            // A loop that goes forth comes in at the next one's start.
            (count > 1).then_some((UsePlace { number, ..place }, forth == next.reversed))
        };
        let (across, at) = step(place, end)?;
        let edge = self.loops(across.face)[across.chain][across.number].edge;
        let [one, other] = self.uses(edge) else { return None };
        let beyond = if *one == across { *other } else { *one };
        step(beyond, at).map(|end| ((across, at), end))
    }

    /// The direction of a face's edge at its end.
    fn direction(&self, (place, end): End, edges: &Edges<'_>) -> Result<Option<Vector>> {
        let Some(strand) = strand(edges.sheets, &place)? else { return Ok(None) };
        let (from, to) = strand.curve.range();
        Ok(strand.slope(if end { to } else { from })?.try_normalize(0.0))
    }
}

/// By which part of the way between two shares of one curve the middle of the same on the other one is off the middle: nothing where both run
/// straight, and at paces of a constant ratio.
fn bend(own: &Strand<'_>, leader: &Strand<'_>, [from, to]: [f64; 2]) -> Result<f64> {
    let there = |share: f64| -> Result<[f64; 2]> {
        leader.parameters(leader.nearest(own.point(own.at_share(share))?, share)?)
    };
    let (a, b, middle) = (there(from)?, there(to)?, there(0.5 * (from + to))?);
    let way = (b[0] - a[0]).hypot(b[1] - a[1]);
    let off = (middle[0] - 0.5 * (a[0] + b[0])).hypot(middle[1] - 0.5 * (a[1] + b[1]));
    Ok(if way > 0.0 { (off / way).min(1.0) } else { 0.0 })
}

/// The space of a curve along a line, with knots of multiplicity `p - 1` where the curve is smooth though they are repeated oftener: what
/// an edit keeps.
fn without_corners(trace: &Trace, net: &[Point]) -> Result<Space> {
    let space = &trace.space;
    let p = space.degree();
    if space.most_repeated() < p || p < 2 {
        return Ok(space.clone());
    }
    let curve = trace.curve(net)?;
    let mut flat = Vec::with_capacity(space.flat().len());
    let (a, b) = space.domain();
    for same in space.flat().chunk_by(|a, b| a == b) {
        let (knot, times) = (same[0], same.len());
        let inside = knot > a && knot < b;
        let smooth = |side: Side| slope(&curve, knot, side);
        let goes_on = inside
            && times >= p
            && match (smooth(Side::Left)?, smooth(Side::Right)?) {
                (Some(left), Some(right)) => (left - right).norm() <= ONWARD * ONWARD,
                _ => false,
            };
        flat.extend(std::iter::repeat_n(knot, if goes_on { p - 1 } else { times }));
    }
    Space::open(p, flat)
}

/// The direction of a curve on one side of a knot.
fn slope(curve: &Curve, at: f64, side: Side) -> Result<Option<Vector>> {
    let row = curve.stencil_on(Location::Curve(at), Derivative::from(1), side.into())?;
    Ok(row.apply(curve.points()).try_normalize(0.0))
}
