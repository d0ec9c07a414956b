//! Faces that meet smoothly along an edge while both of them move.
//!
//! Let the edge be a line of parameters of one face, `G_c` its derivative across that, and `F_u`, `F_v` the derivatives of the other face where the
//! edge is on it. Tangent planes agree where there are factors with
//!
//! `G_c = λ F_u + μ F_v`.
//!
//! The factors are those of the faces as they are, by least squares, and stay: then `G_c - λ F_u - μ F_v` is linear in the control vertices, and
//! an edit that keeps it keeps the tangent planes agreeing as they did. It is kept at as many places as the boundary has control vertices
//! (in a space of both faces, where it is a line of both): all along it where the factors are constant (faces cut from one surface, or joined at
//! one pace), else at these places, the boundary being refined; what is left between them is told in degrees.

use std::collections::{BTreeMap, BTreeSet};

use super::super::{Brep, UsePlace};
use super::measure::MEETS;
use super::pair::{Tie, line, strand};
use super::sheet::Sheet;
use super::strand::{Strand, location, own_places};
use super::trace::{Line, Trace};
use crate::Vector;
use crate::error::Result;
use crate::shape::{Derivative, Shape, Stencil};
use crate::spline::Surface;

/// Of its functions across an edge that stays smooth, two rows go along with the other face, and two may be held on the far side.
const ACROSS: usize = 4;
/// Spans along an edge at which factors change from place to place.
const ALONG: usize = 32;
/// Factors that change the derivative by a smaller part of it are the same.
const CONSTANT: f64 = 1e-6;
/// Below this sine of the angle between the two directions that span it, a face has no tangent plane.
const FLAT: f64 = 1e-6;

/// The two faces of an edge that stays smooth: one for which it is a line, and the other one.
struct Pair<'p> {
    own: &'p UsePlace,
    line: Line,
    beside: &'p UsePlace,
    /// The line of the other face, where both run through theirs at one pace.
    other: Option<Line>,
}

impl Pair<'_> {
    /// The other face's parameters at a share of the line.
    fn there(&self, own: &Sheet, strand: &Strand<'_>, share: f64) -> Result<[f64; 2]> {
        if let Some(line) = &self.other {
            return Ok(line.point(share));
        }
        let at = self.line.point(share);
        strand.parameters(strand.nearest(own.surface.point(at[0], at[1])?, share)?)
    }
}

/// The derivatives of a surface along `u` and `v`, at parameters that rounding may have left beside its domain.
fn slopes(surface: &Surface, at: [f64; 2]) -> Result<[Vector; 2]> {
    let mut d = [Vector::zeros(); 4];
    let into = |k: usize| {
        let space = if k == 0 { surface.u() } else { surface.v() };
        let (a, b) = space.domain();
        if space.is_periodic() { at[k] } else { at[k].clamp(a, b) }
    };
    surface.derivatives_into(into(0), into(1), [1, 1], &mut d)?;
    Ok([d[2], d[1]])
}

/// The derivative across a line.
fn across(surface: &Surface, line: &Line, share: f64) -> Result<Vector> {
    let [by_u, by_v] = slopes(surface, line.point(share))?;
    Ok(if line.along_u { by_v } else { by_u })
}

/// `λ` and `μ` of `target = λ first + μ second`, by least squares; `None` where the two span no plane.
fn factors([first, second]: [Vector; 2], target: Vector) -> Option<[f64; 2]> {
    let (a, b) = (first.norm(), second.norm());
    let (p, q) = (first.try_normalize(0.0)?, second.try_normalize(0.0)?);
    // Against the part of one that is across the other: no squares of condition numbers.
    let (first_only, second_only) = (p - q * p.dot(&q), q - p * q.dot(&p));
    let sine = first_only.norm_squared();
    (sine.sqrt() > FLAT)
        .then(|| [target.dot(&first_only) / (sine * a), target.dot(&second_only) / (sine * b)])
}

impl Brep {
    /// The faces of an edge that can stay smooth there.
    fn smooth_pair(&self, edge: usize, tie: Tie, sheets: &BTreeMap<usize, Sheet>) -> Option<Pair<'_>> {
        let [first, other] = self.uses(edge) else { return None };
        // The same choice as for what follows what.
        match (tie, line(sheets, first), line(sheets, other)) {
            (Tie::Held, ..) | (_, None, None) => None,
            (Tie::Lines, a, Some(line)) => Some(Pair { own: other, line, beside: first, other: a }),
            (_, _, Some(line)) => Some(Pair { own: other, line, beside: first, other: None }),
            (_, Some(line), None) => Some(Pair { own: first, line, beside: other, other: None }),
        }
    }

    /// The edges, of those at which faces that move are held together, that stay smooth: lines of parameters of a face, that meet at no more
    /// than 1° all along them.
    pub(super) fn stay_smooth(
        &self,
        ties: &BTreeMap<usize, Tie>,
        sheets: &BTreeMap<usize, Sheet>,
    ) -> Result<BTreeSet<usize>> {
        let can =
            |edge: &usize| ties.get(edge).is_some_and(|tie| self.smooth_pair(*edge, *tie, sheets).is_some());
        let some: Vec<usize> = ties.keys().copied().filter(can).collect();
        let smooth = self.openings_of(&some)?.into_iter();
        Ok(smooth.filter(|one| one.angle.is_some_and(|angle| angle <= MEETS)).map(|one| one.edge).collect())
    }

    /// Gives the faces of an edge that stays smooth control vertices enough for that.
    pub(super) fn refine_across(
        &self,
        edge: usize,
        tie: Tie,
        sheets: &mut BTreeMap<usize, Sheet>,
    ) -> Result<()> {
        let Some(pair) = self.smooth_pair(edge, tie, sheets) else { return Ok(()) };
        let constant = self.is_constant(&pair, sheets)?;
        let both = [(pair.own, Some(pair.line)), (pair.beside, pair.other)];
        for (place, along) in both {
            let (Some(sheet), Some(along)) = (sheets.get_mut(&place.face), along) else { continue };
            let space = if along.along_u { sheet.surface.v() } else { sheet.surface.u() };
            let (from, to) = space.domain();
            sheet.spanned(&Line { along_u: !along.along_u, at: along.from, from, to }, ACROSS)?;
            if !constant {
                sheet.spanned(&along, ALONG)?;
            }
        }
        Ok(())
    }

    /// Whether the factors of a pair are the same all along its edge.
    fn is_constant(&self, pair: &Pair<'_>, sheets: &BTreeMap<usize, Sheet>) -> Result<bool> {
        let (Some(g), Some(f)) = (sheets.get(&pair.own.face), sheets.get(&pair.beside.face)) else {
            return Ok(true);
        };
        let Some(strand) = strand(sheets, pair.beside)? else { return Ok(true) };
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let (mut lengths, mut size) = ([0.0_f64; 2], 0.0_f64);
        for k in 0..=ALONG {
            let share = k as f64 / ALONG as f64;
            let target = across(&g.surface, &pair.line, share)?;
            let base = slopes(&f.surface, pair.there(g, &strand, share)?)?;
            let Some(both) = factors(base, target) else { continue };
            size = size.max(target.norm());
            for k in 0..2 {
                (low[k], high[k]) = (low[k].min(both[k]), high[k].max(both[k]));
                lengths[k] = lengths[k].max(base[k].norm());
            }
        }
        // By what they make of the derivative: factors of other dimensions cannot be compared.
        Ok((0..2).all(|k| (high[k] - low[k]) * lengths[k] <= CONSTANT * size))
    }

    /// The rows that keep the faces of an edge smooth, over the control vertices of this Brep, which is ready.
    pub(super) fn smooth_rows(
        &self,
        edge: usize,
        tie: Tie,
        sheets: &BTreeMap<usize, Sheet>,
    ) -> Result<Vec<Stencil>> {
        let mut rows = Vec::new();
        let Some(pair) = self.smooth_pair(edge, tie, sheets) else { return Ok(rows) };
        let (Some(g), Some(f)) = (sheets.get(&pair.own.face), sheets.get(&pair.beside.face)) else {
            return Ok(rows);
        };
        let Some(strand) = strand(sheets, pair.beside)? else { return Ok(rows) };
        let own = Trace::of(&g.product(0), &pair.line)?;
        let space = match &pair.other {
            Some(line) => {
                let common = own.space.common(&Trace::of(&f.product(0), line)?.space)?;
                own.all_converted(&common.first).space
            }
            None => own.space,
        };
        let (start, end) = space.domain();
        for t in own_places(&space) {
            let share = ((t - start) / (end - start)).clamp(0.0, 1.0);
            let there = pair.there(g, &strand, share)?;
            let target = across(&g.surface, &pair.line, share)?;
            let Some([lambda, mu]) = factors(slopes(&f.surface, there)?, target) else { continue };
            let here = location(&g.surface, pair.own.face, pair.line.point(share));
            let there = location(&f.surface, pair.beside.face, there);
            let by = if pair.line.along_u { [0, 1] } else { [1, 0] };
            let row = self.stencil(here, Derivative::from(by))?;
            let by_u = self.stencil(there, Derivative::from([1, 0]))?.scaled(-lambda);
            let by_v = self.stencil(there, Derivative::from([0, 1]))?.scaled(-mu);
            let row: Stencil = row.iter().chain(by_u.iter()).chain(by_v.iter()).collect();
            // Derivatives count by the lengths of parameters: as distances they weigh what the rows of positions do.
            let largest = row.coefficients().iter().fold(0.0_f64, |m, c| m.max(c.abs()));
            if largest > 0.0 && largest.is_finite() {
                rows.push(row.scaled(1.0 / largest));
            }
        }
        Ok(rows)
    }
}
