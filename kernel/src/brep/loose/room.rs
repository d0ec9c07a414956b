//! Places that are to move: on their faces, and where one lies on an edge between faces that move, each of these needs control vertices that can.

use std::collections::{BTreeMap, BTreeSet};

use super::super::{Brep, UsePlace};
use super::pair::{Tie, line, strand};
use super::sheet::Sheet;
use super::strand::inside;
use super::trace::Line;
use crate::error::{Error, Result};
use crate::text::{figure, measured};

/// A place this near to an edge, as a part of the edge's size, is on it: files give points with some seven digits.
const ON: f64 = 1e-6;

/// A place on a face, by its parameters.
pub(super) type Place = (usize, [f64; 2]);

impl Brep {
    /// That a place is on its face: inside its loops, or on them as files give points.
    pub(super) fn check_place(&self, face: usize, [u, v]: [f64; 2]) -> Result<()> {
        let Some(surface) = self.surface(face).filter(|_| !self.loops(face).is_empty()) else {
            return Ok(());
        };
        // What is beside the domain is told where it is asked about.
        let (Ok(x), Ok(y)) = (surface.u().locate(u), surface.v().locate(v)) else { return Ok(()) };
        let part = self.part(face)?;
        if part.has([x, y]) {
            return Ok(());
        }
        let point = surface.point(x, y)?;
        let found = part.closest(point)?;
        let size = surface.points().iter().map(|p| (p - surface.points()[0]).amax()).fold(0.0, f64::max);
        let widest = self.loops(face).iter().flatten().map(|one| self.edges[one.edge].tolerance);
        if found.distance <= widest.fold(ON * size, f64::max) {
            return Ok(());
        }
        let (s, t) = found.at;
        Err(Error::Invalid(format!(
            "a place on face {face}: (u, v) = ({}, {}) is outside its loops, {} away from what they leave of the surface: choose a place on it, as ({}, {}), \
             the nearest one",
            measured(u),
            measured(v),
            figure(found.distance),
            measured(s),
            measured(t),
        )))
    }

    /// The places that are asked about, and those of other faces that are the same points of edges that both have.
    fn places_beside(
        &self,
        asked: &[Place],
        ties: &BTreeMap<usize, Tie>,
        sheets: &BTreeMap<usize, Sheet>,
    ) -> Result<Vec<Place>> {
        let mut all: Vec<Place> = Vec::new();
        let mut open: Vec<Place> = asked.to_vec();
        while let Some((face, at)) = open.pop() {
            let Some(sheet) = sheets.get(&face) else { continue };
            let known = |place: &Place| {
                let near = |k: usize, (a, b): (f64, f64)| (place.1[k] - at[k]).abs() <= ON * (b - a);
                place.0 == face && near(0, sheet.surface.u().domain()) && near(1, sheet.surface.v().domain())
            };
            if all.iter().any(known) {
                continue;
            }
            all.push((face, at));
            let (u, v) = inside(&sheet.surface, at[0], at[1]);
            let point = sheet.surface.point(u, v)?;
            let edges: BTreeSet<usize> = self.loops(face).iter().flatten().map(|one| one.edge).collect();
            for edge in edges.into_iter().filter(|edge| ties.contains_key(edge)) {
                let uses = self.uses(edge);
                let mut on = false;
                for one in uses.iter().filter(|one| one.face == face) {
                    let Some(own) = strand(sheets, one)? else { continue };
                    on |= own.closest(point)?.1 <= ON * own.size();
                }
                for one in uses.iter().filter(|_| on) {
                    let Some(there) = strand(sheets, one)? else { continue };
                    open.push((one.face, there.parameters(there.closest(point)?.0)?));
                }
            }
        }
        all.sort_by(|a, b| a.0.cmp(&b.0).then(a.1[0].total_cmp(&b.1[0])).then(a.1[1].total_cmp(&b.1[1])));
        Ok(all)
    }

    /// Gives the faces control vertices that can move at these places, and beside them. The places, and those that are the same on other
    /// faces.
    pub(super) fn free(
        &self,
        asked: &[(u32, [f64; 2])],
        ties: &BTreeMap<usize, Tie>,
        sheets: &mut BTreeMap<usize, Sheet>,
    ) -> Result<Vec<Place>> {
        let asked: Vec<Place> = asked.iter().map(|(face, at)| (*face as usize, *at)).collect();
        let all = self.places_beside(&asked, ties, sheets)?;
        for place in &all {
            let Some(sheet) = sheets.get_mut(&place.0) else { continue };
            let freed = sheet.freed(&[place.1]);
            if asked.contains(place) {
                freed?;
            }
        }
        let more: BTreeSet<usize> = all.iter().map(|place| place.0).collect();
        for (&edge, _) in ties.iter().filter(|(_, tie)| **tie == Tie::Lines) {
            if self.uses(edge).iter().filter(|one| more.contains(&one.face)).count() > 1 {
                self.same_knots(edge, sheets)?;
            }
        }
        Ok(all)
    }

    /// Gives both faces of an edge that is a line of both, at one pace, all knots that one of them has along it: where only one can bend
    /// neither does.
    fn same_knots(&self, edge: usize, sheets: &mut BTreeMap<usize, Sheet>) -> Result<()> {
        let Some((first, others)) = self.uses(edge).split_first() else { return Ok(()) };
        for other in others {
            let (Some(a), Some(b)) = (line(sheets, first), line(sheets, other)) else { continue };
            give(sheets, (first, &a), (other, &b))?;
            give(sheets, (other, &b), (first, &a))?;
        }
        Ok(())
    }
}

/// The knots that one face has along a line, for the other.
fn give(
    sheets: &mut BTreeMap<usize, Sheet>,
    (from, own): (&UsePlace, &Line),
    (to, beside): (&UsePlace, &Line),
) -> Result<()> {
    let Some(sheet) = sheets.get(&from.face) else { return Ok(()) };
    let shares = sheet.breaks_along(own).into_iter().map(|t| (t - own.from) / (own.to - own.from));
    let at = |share: f64| (beside.from + (beside.to - beside.from) * share, 1);
    let knots: Vec<(f64, usize)> = shares.map(at).collect();
    match sheets.get_mut(&to.face) {
        Some(sheet) => sheet.knotted(beside, &knots),
        None => Ok(()),
    }
}
