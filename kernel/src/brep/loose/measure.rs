//! How far faces are apart along their edges.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::super::{Brep, UsePlace};
use super::pair::together;
use super::sheet::{Sheet, Still};
use super::strand::Strand;
use super::{Loose, Motion};
use crate::error::Result;
use crate::spline::Surface;
use crate::spline::trimmed::ParameterCurve;
use crate::text::figure;

/// Places in each part of an edge along which both faces are smooth.
const EACH: usize = 17;
/// Faces that meet at no larger angle, in radians (1°), meet smoothly as far as files tell: CAD programs draw no edge between them.
pub(super) const MEETS: f64 = 0.0175;
/// Angles that differ by less, in radians, are the same but for rounding: normals are known to about 1e-8 of a turn at best where a
/// surface was refined.
const SAME: f64 = 1e-7;
/// So many edges are told one by one.
const TOLD: usize = 3;

/// What is between the faces of an edge, measured along it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Opening {
    /// The edge.
    pub edge: usize,
    /// How far its faces are apart at most; 0 where it has one.
    pub gap: f64,
    /// How far the edge's curve is off a face at most.
    pub off: f64,
    /// The largest angle between the tangent planes of its two faces, in radians: 0 where they meet smoothly all along it, π where one is
    /// folded back on the other. `None` where it has not two, or these have no tangent planes along it.
    pub angle: Option<f64>,
}

type Curves = BTreeMap<usize, (Surface, Vec<Vec<ParameterCurve>>)>;

impl Brep {
    /// How far the faces of each edge are apart along it, its curve from them, and the angle between them: of the surfaces along their
    /// parameter curves, at 17 places of each part along which both are smooth.
    ///
    /// # Errors
    /// When an evaluation overflows.
    pub fn openings(&self) -> Result<Vec<Opening>> {
        let edges: Vec<usize> = (0..self.edge_count()).collect();
        self.openings_of(&edges)
    }

    pub(super) fn openings_of(&self, edges: &[usize]) -> Result<Vec<Opening>> {
        let mut known = Curves::new();
        let mut all = Vec::with_capacity(edges.len());
        for &edge in edges {
            for one in self.uses(edge) {
                if let (false, Some(surface)) = (known.contains_key(&one.face), self.surface(one.face)) {
                    let own = self.loops(one.face).iter().map(|chain| {
                        chain.iter().map(|one| one.parameters.clone()).collect::<Option<Vec<_>>>()
                    });
                    let curves = match own.collect::<Option<Vec<_>>>() {
                        Some(curves) => curves,
                        None => {
                            let projected = self.parameter_curves(one.face)?;
                            projected
                                .into_iter()
                                .map(|c| c.into_iter().map(|one| one.curve).collect())
                                .collect()
                        }
                    };
                    known.insert(one.face, (surface, curves));
                }
            }
            all.push(self.opening(edge, &known)?);
        }
        Ok(all)
    }

    fn opening(&self, edge: usize, known: &Curves) -> Result<Opening> {
        let mut opening = Opening { edge, gap: 0.0, off: 0.0, angle: None };
        let Some(own) = self.edge(edge) else { return Ok(opening) };
        let part = own.curve.between(own.range.0, own.range.1)?;
        let (from, to) = part.domain();
        let mut strands = Vec::new();
        for one in self.uses(edge) {
            let Some((surface, curves)) = known.get(&one.face) else { continue };
            if let Some(curve) = curves.get(one.chain).and_then(|chain| chain.get(one.number)) {
                strands.push(Strand::new(surface, curve)?);
            }
        }
        let Some((first, others)) = strands.split_first() else { return Ok(opening) };
        let turned = match self.uses(edge) {
            // Loops run around normals: two that run through an edge in one sense have normals on opposite sides.
            [one, other] if strands.len() == 2 => Some(self.turns(one) == self.turns(other)),
            _ => None,
        };
        let beside = others.first().unwrap_or(first);
        for pair in together(first, beside)?.windows(2) {
            for k in 0..EACH {
                let share = pair[0] + (pair[1] - pair[0]) * (k as f64 / (EACH - 1) as f64);
                let here = first.at_share(share);
                let point = first.point(here)?;
                for other in others {
                    let t = other.nearest(point, share)?;
                    opening.gap = opening.gap.max((other.point(t)? - point).norm());
                    let Some(turned) = turned else { continue };
                    if let (Some(a), Some(b)) = (first.normal(here)?, other.normal(t)?) {
                        let cosine = if turned { -a.dot(&b) } else { a.dot(&b) };
                        let angle = a.cross(&b).norm().atan2(cosine);
                        opening.angle = Some(opening.angle.map_or(angle, |largest| largest.max(angle)));
                    }
                }
                let at = part.point(if share >= 1.0 { to } else { from + (to - from) * share })?;
                for strand in &strands {
                    let there = strand.point(strand.nearest(at, share)?)?;
                    opening.off = opening.off.max((there - at).norm());
                }
            }
        }
        Ok(opening)
    }

    /// Whether a loop runs through an edge backwards, as seen against `S_u × S_v` of its face.
    fn turns(&self, place: &UsePlace) -> bool {
        let one = self.loops(place.face).get(place.chain).and_then(|chain| chain.get(place.number));
        one.is_some_and(|one| one.reversed) != self.is_reversed(place.face)
    }

    /// What an edit did to the edges between faces that moved: tolerances raised to what is measured, and notes.
    pub(super) fn tell(&mut self, loose: &Loose, moved: &[usize], edges: &[usize]) -> Result<Vec<String>> {
        let mut notes = Vec::new();
        let plural = |count: usize, one: &str| format!("{count} {one}{}", if count == 1 { "" } else { "s" });
        if moved.is_empty() {
            return Ok(notes);
        }
        let names: Vec<String> = moved.iter().take(8).map(usize::to_string).collect();
        let more = if moved.len() > 8 { ", …" } else { "" };
        notes.push(format!(
            "{} moved ({}{more}), {} followed; the rest of the brep stands still",
            plural(moved.len(), "face"),
            names.join(", "),
            plural(edges.len(), "edge")
        ));
        let after = self.openings_of(edges)?;
        let size = self.net.iter().map(|p| (p - self.net[0]).amax()).fold(0.0, f64::max);
        let rounding = 64.0 * f64::EPSILON * self.net.iter().map(|p| p.coords.amax()).fold(size, f64::max);
        let mut opened = Vec::new();
        for opening in &after {
            let before = loose.before.iter().find(|one| one.edge == opening.edge).copied();
            let far = opening.gap.max(opening.off);
            let edge = &mut self.edges[opening.edge];
            if far > edge.tolerance && far > rounding {
                edge.tolerance = far;
            }
            if opening.gap > before.map_or(0.0, |one| one.gap) + rounding {
                opened.push((*opening, before.map_or(0.0, |one| one.gap)));
            }
        }
        self.raise_vertices(edges)?;
        opened.sort_by(|a, b| b.0.gap.total_cmp(&a.0.gap));
        for (opening, before) in opened.iter().take(TOLD) {
            notes.push(format!(
                "edge {} opens by up to {} (before: {}), which its tolerance says now",
                opening.edge,
                figure(opening.gap),
                figure(*before)
            ));
        }
        if opened.len() > TOLD {
            notes.push(format!("{} more open by less", plural(opened.len() - TOLD, "edge")));
        }
        if opened.is_empty() && !edges.is_empty() {
            let widest = after.iter().map(|one| one.gap).fold(0.0, f64::max);
            notes.push(format!("no edge opened: faces are at most {} apart along them", figure(widest)));
        }
        notes.extend(self.folds(loose, moved)?);
        let beside: Vec<usize> = loose.beside.iter().map(|one| one.edge).collect();
        let mut smooth = after;
        smooth.extend(self.openings_of(&beside)?);
        notes.extend(creases(loose, &smooth));
        let between = edges.iter().filter(|edge| loose.between.contains(edge)).count();
        if between > 0 {
            notes.push(format!(
                "{} followed at places: no knot line of both its faces",
                plural(between, "edge"),
            ));
        }
        if loose.stays > 0 {
            notes.push(format!(
                "{} between faces that move {} where {}: no knot line and no polynomial of its faces",
                plural(loose.stays, "edge"),
                if loose.stays == 1 { "stays" } else { "stay" },
                if loose.stays == 1 { "it is" } else { "they are" },
            ));
        }
        Ok(notes)
    }

    /// Notes at which edges that stand still faces meet smoothly, one of which may move.
    pub(super) fn look_beside(&mut self, sheets: &BTreeMap<usize, Sheet>) -> Result<()> {
        let still = sheets.values().flat_map(|sheet| &sheet.still).filter_map(|still| match still {
            Still::Edge { edge, .. } => Some(*edge),
            Still::Vertex { .. } => None,
        });
        let edges: BTreeSet<usize> = still.filter(|&edge| self.uses(edge).len() == 2).collect();
        let edges: Vec<usize> = edges.into_iter().collect();
        let mut beside = self.openings_of(&edges)?;
        beside.retain(|one| one.angle.is_some_and(|angle| angle <= MEETS));
        if let Motion::Ready(loose) = &mut self.motion
            && let Some(loose) = Arc::get_mut(loose)
        {
            loose.beside = beside;
        }
        Ok(())
    }

    /// Vertices' tolerances hold the ends of edges that followed.
    fn raise_vertices(&mut self, edges: &[usize]) -> Result<()> {
        for &edge in edges {
            let (Some(own), Some(ends)) = (self.edge(edge), self.ends(edge)) else { continue };
            for (t, vertex) in [own.range.0, own.range.1].into_iter().zip(ends) {
                let distance = (own.curve.point(t)? - self.vertices()[vertex]).norm();
                if distance > self.tolerances[vertex].max(self.edges[edge].tolerance) {
                    self.tolerances[vertex] = distance;
                }
            }
        }
        Ok(())
    }
}

/// What became of edges at which faces met smoothly before an edit.
fn creases(loose: &Loose, after: &[Opening]) -> Option<String> {
    let mut smooth = Vec::new();
    for now in after {
        let mut known = loose.before.iter().chain(&loose.beside);
        let before = known.find(|one| one.edge == now.edge).and_then(|one| one.angle);
        if let (Some(before), Some(angle)) = (before.filter(|angle| *angle <= MEETS), now.angle) {
            smooth.push((now.edge, before, angle));
        }
    }
    let (edge, before, now) = *smooth.iter().max_by(|a, b| (a.2 - a.1).total_cmp(&(b.2 - b.1)))?;
    let (count, degrees) = (smooth.len(), |angle: f64| figure(angle.to_degrees()));
    let which = if count == 1 {
        "1 edge was smooth before".to_owned()
    } else {
        format!("{count} edges were smooth before")
    };
    let worst = smooth.iter().map(|one| one.2).fold(0.0, f64::max);
    let kept = smooth.iter().filter(|(edge, ..)| loose.smooth.contains(edge)).count();
    let kept = match kept {
        0 => String::new(),
        k if k == count => ", kept so".to_owned(),
        k => format!(", {k} of them kept so"),
    };
    Some(if now <= before + SAME {
        format!("{which}{kept}: faces meet there at {}° at most", degrees(worst))
    } else {
        format!("{which}{kept}: edge {edge} changed most, from {}° to {}°", degrees(before), degrees(now))
    })
}
