//! Two faces that move, along an edge that they share.

use std::collections::BTreeMap;

use super::super::{Brep, UsePlace};
use super::sheet::Sheet;
use super::strand::{Strand, own_places};
use super::trace::{Line, Trace};
use crate::error::Result;
use crate::shape::Stencil;

/// Two boundaries that are as near to one another at the same shares of both, as a part of their size, run at one pace.
const PACE: f64 = 1e-7;
/// Places at which that is looked at.
const LOOKS: usize = 33;
/// A boundary that has to go along with what is no spline in its space has so many spans at least, and at most.
const SPANS: [usize; 2] = [32, 96];
/// Polynomials along an edge of no higher degree are made the same by that many places and one; and a boundary is given a degree up to this,
/// so that it can be any of them.
const EXACT: usize = 12;
const ELEVATED: usize = 7;

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

    /// Gives a face a degree, or knots, along an edge where it has to go along with what its space does not hold.
    pub(super) fn refine_along(
        &self,
        edge: usize,
        tied: Tie,
        sheets: &mut BTreeMap<usize, Sheet>,
    ) -> Result<()> {
        let Some((first, others)) = self.uses(edge).split_first() else { return Ok(()) };
        for other in others {
            // The one whose boundary is a spline of its own follows the other one.
            let (one, beside, along) = match (line(sheets, first), line(sheets, other)) {
                (_, Some(b)) => (other, first, b),
                (Some(a), None) => (first, other, a),
                (None, None) => continue,
            };
            let Some(strand) = strand(sheets, beside)? else { continue };
            let (degree, breaks) = (strand.degree(), strand.breaks()?.len());
            let Some(sheet) = sheets.get_mut(&one.face) else { continue };
            match (tied, degree) {
                (Tie::Polynomials, Some(degree)) => sheet.elevated(&along, degree.min(ELEVATED))?,
                (Tie::Follows, _) => sheet.spanned(&along, (4 * (breaks - 1)).clamp(SPANS[0], SPANS[1]))?,
                _ => {}
            }
        }
        Ok(())
    }
}

/// The rows that keep the faces of an edge together, over the control vertices of the ready Brep.
pub(super) fn rows(brep: &Brep, edge: usize, sheets: &BTreeMap<usize, Sheet>, tied: Tie) -> Result<Rows> {
    let mut all = Rows { rows: Vec::new(), places: false };
    let Some((first, others)) = brep.uses(edge).split_first() else { return Ok(all) };
    for other in others {
        let (Some(f), Some(g)) = (sheets.get(&first.face), sheets.get(&other.face)) else { continue };
        let lines = (line(sheets, first), line(sheets, other));
        let products = (brep.product(first.face), brep.product(other.face));
        if let (Tie::Lines, (Some(a), Some(b)), (Some(p), Some(q))) = (tied, &lines, products)
            && let Some(rows) = Trace::of(&p, a)?.difference(&Trace::of(&q, b)?)?
        {
            all.rows.extend(rows);
            continue;
        }
        all.places |= tied != Tie::Polynomials;
        let (Some(one), Some(two)) = (strand(sheets, first)?, strand(sheets, other)?) else { continue };
        let ((one, own), (two, beside), along) = match lines {
            (_, Some(b)) if tied == Tie::Follows => ((two, (other, g)), (one, (first, f)), Some(b)),
            (Some(a), None) if tied == Tie::Follows => ((one, (first, f)), (two, (other, g)), Some(a)),
            _ => ((one, (first, f)), (two, (other, g)), None),
        };
        let places = match &along {
            Some(line) => {
                let trace = Trace::of(&own.1.product(0), line)?;
                let (a, b) = trace.space.domain();
                own_places(&trace.space)
                    .into_iter()
                    .map(|t| (t - a) / (b - a))
                    .map(|share| (share, line.point(share)))
                    .collect()
            }
            None => places(&one, &two)?,
        };
        for (share, at) in places {
            let point = own.1.surface.point(at[0], at[1])?;
            let there = two.parameters(two.nearest(point, share)?)?;
            let row = brep.row_at(&own.1.surface, own.0.face, at)?;
            let minus = brep.row_at(&beside.1.surface, beside.0.face, there)?.scaled(-1.0);
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
