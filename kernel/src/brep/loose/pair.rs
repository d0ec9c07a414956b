//! Two faces that move, along an edge that they share.

use std::collections::BTreeMap;

use super::super::{Brep, UsePlace};
use super::follow::Edges;
use super::sheet::Sheet;
use super::strand::{Strand, inside};
use super::trace::{Line, Trace};
use crate::error::Result;
use crate::shape::Stencil;

/// Two boundaries that are as near to one another at the same shares of both, as a part of their size, run at one pace.
const PACE: f64 = 1e-7;
/// Places at which that is looked at.
const LOOKS: usize = 33;
/// Polynomials along an edge of no higher degree are made the same by that many places and one.
const EXACT: usize = 12;

/// What keeps two faces that move together along their edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Tie {
    /// It is a line of parameters of both, at one pace: their boundary curves are one.
    Lines,
    /// Both are polynomials along it, at one pace: as many places as they have coefficients.
    Polynomials,
    /// It is a line of parameters of one, which follows at places that are its own.
    Follows,
    /// None of this: nothing that is not exact, or near to it, would hold them. The edge stays where it is.
    Held,
}

/// What keeps the faces of an edge together.
pub(super) struct Rows {
    pub(super) rows: Vec<Stencil>,
    /// Whether they hold at places, and something may be left between them.
    pub(super) places: bool,
}

/// A use as its face has it.
pub(super) fn strand<'a>(sheets: &'a BTreeMap<usize, Sheet>, one: &UsePlace) -> Result<Option<Strand<'a>>> {
    let Some(sheet) = sheets.get(&one.face) else { return Ok(None) };
    let curve = sheet.curves.get(one.chain).and_then(|chain| chain.get(one.number));
    curve.map(|curve| Strand::new(&sheet.surface, curve)).transpose()
}

/// The line of parameters that a use is, where it is one.
pub(super) fn line(sheets: &BTreeMap<usize, Sheet>, one: &UsePlace) -> Option<Line> {
    Line::of(sheets.get(&one.face)?.curves.get(one.chain)?.get(one.number)?)
}

/// Whether two faces run through an edge at one pace.
fn in_step(one: &Strand<'_>, two: &Strand<'_>) -> Result<bool> {
    let (mut apart, mut size) = (0.0_f64, 0.0_f64);
    let mut first = None;
    for k in 0..LOOKS {
        let share = k as f64 / (LOOKS - 1) as f64;
        let (p, q) = (one.point(one.at_share(share))?, two.point(two.at_share(share))?);
        apart = apart.max((p - q).norm());
        size = size.max((p - *first.get_or_insert(p)).norm());
    }
    Ok(apart <= PACE * size)
}

/// How a pair of uses can be kept together.
fn tie(sheets: &BTreeMap<usize, Sheet>, first: &UsePlace, other: &UsePlace) -> Result<Tie> {
    let (Some(one), Some(two)) = (strand(sheets, first)?, strand(sheets, other)?) else {
        return Ok(Tie::Held);
    };
    let step = in_step(&one, &two)?;
    let lines = (line(sheets, first), line(sheets, other));
    if let (true, (Some(a), Some(b))) = (step, &lines)
        && Trace::of(&one.surface.product(), a)?
            .difference(&Trace::of(&two.surface.product(), b)?)
            .is_ok_and(|d| d.is_some())
    {
        return Ok(Tie::Lines);
    }
    let degree = one.degree().zip(two.degree()).map(|(a, b)| a.max(b));
    Ok(match (degree, lines) {
        (Some(degree), _) if step && degree <= EXACT => Tie::Polynomials,
        (_, (None, None)) => Tie::Held,
        _ => Tie::Follows,
    })
}

impl Brep {
    /// How the faces of an edge can be kept together while all of them move.
    pub(super) fn tie(&self, edge: usize, sheets: &BTreeMap<usize, Sheet>) -> Result<Tie> {
        let Some((first, others)) = self.uses(edge).split_first() else { return Ok(Tie::Held) };
        let mut all = Tie::Lines;
        for other in others {
            let own = tie(sheets, first, other)?;
            all = if all == Tie::Lines || all == own { own } else { Tie::Held };
        }
        Ok(all)
    }
}

/// The rows that keep the faces of an edge together, over the control vertices of the ready Brep.
pub(super) fn rows(brep: &Brep, edge: usize, edges: &Edges<'_>, tied: Tie) -> Result<Rows> {
    let sheets = edges.sheets;
    let mut all = Rows { rows: Vec::new(), places: false };
    let Some((first, others)) = brep.uses(edge).split_first() else { return Ok(all) };
    let following = brep.following(edge, sheets);
    for (number, other) in others.iter().enumerate() {
        let lines = (line(sheets, first), line(sheets, other));
        let products = (brep.product(first.face), brep.product(other.face));
        if let (Tie::Lines, (Some(a), Some(b)), (Some(p), Some(q))) = (tied, &lines, products)
            && let Some(rows) = Trace::of(&p, a)?.difference(&Trace::of(&q, b)?)?
        {
            all.rows.extend(rows);
            continue;
        }
        all.places |= tied != Tie::Polynomials;
        let follower = following.get(number).filter(|_| following.len() == others.len());
        let (one, two, along) = match follower {
            Some((one, beside, along)) => (*one, *beside, Some(along)),
            None => (first, other, None),
        };
        let (Some(own), Some(leader)) = (strand(sheets, one)?, strand(sheets, two)?) else { continue };
        let holds = |line: &&Line| {
            tied == Tie::Follows || leader.degree().is_some_and(|d| d <= line.space(own.surface).degree())
        };
        let places = match along.filter(holds) {
            Some(line) => {
                let shares = brep.follow_at(one, line, (&leader, two), edges)?;
                shares.into_iter().map(|share| (share, line.point(share))).collect()
            }
            None => places(&own, &leader)?,
        };
        for (share, at) in places {
            let (u, v) = inside(own.surface, at[0], at[1]);
            let there = leader.parameters(leader.nearest(own.surface.point(u, v)?, share)?)?;
            let row = brep.row_at(own.surface, one.face, at)?;
            let minus = brep.row_at(leader.surface, two.face, there)?.scaled(-1.0);
            all.rows.push(row.iter().chain(minus.iter()).collect());
        }
    }
    Ok(all)
}

/// Places in each part of an edge along which both faces are polynomials, one more than their degree: shares of the first's curve, and its
/// parameters there.
fn places(one: &Strand<'_>, two: &Strand<'_>) -> Result<Vec<(f64, [f64; 2])>> {
    let shares = together(one, two)?;
    let each = one.degree().unwrap_or(EXACT).max(two.degree().unwrap_or(EXACT));
    let mut all = Vec::new();
    for pair in shares.windows(2) {
        for k in 0..each {
            // Closer to the ends of a part, as interpolation wants them.
            let within = 0.5 - 0.5 * (std::f64::consts::PI * k as f64 / each as f64).cos();
            let share = pair[0] + (pair[1] - pair[0]) * within;
            all.push((share, one.parameters(one.at_share(share))?));
        }
    }
    all.push((1.0, one.parameters(one.at_share(1.0))?));
    Ok(all)
}

/// The shares of the first curve between which both are smooth, ascending from 0 to 1.
pub(super) fn together(one: &Strand<'_>, two: &Strand<'_>) -> Result<Vec<f64>> {
    let (from, to) = one.curve.range();
    let (start, end) = two.curve.range();
    let mut shares: Vec<f64> = one.breaks()?.into_iter().map(|t| (t - from) / (to - from)).collect();
    for t in two.breaks()? {
        let share = (t - start) / (end - start);
        let there = one.nearest(two.point(t)?, share)?;
        shares.push((there - from) / (to - from));
    }
    shares.sort_by(f64::total_cmp);
    shares.retain(|share| (0.0..=1.0).contains(share));
    shares.dedup_by(|b, a| *b - *a < 1e-6);
    if let (Some(first), Some(last)) = (shares.first().copied(), shares.last().copied()) {
        if first > 0.0 {
            shares.insert(0, 0.0);
        }
        if last < 1.0 {
            shares.push(1.0);
        }
    }
    Ok(shares)
}
