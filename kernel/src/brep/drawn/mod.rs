//! Faces that meet themselves along a seam: all their edges in the parameters of the surface, loop by loop without a jump.
//!
//! Edges in space say where they are in the parameters of a surface that no face meets itself on. Where one does, along an edge, that is not enough: both uses are
//! the same curve in space, and on which of the two sides of the seam the edges beside it start cannot be told from there (a torus around a hole may as well be the hole, and a sphere
//! whose seam lies a rounding error to one side of the surface's own may have no area). So all edges of such a face are said, or none: what is computed of one edge alone lies a turn
//! away from what is said of its neighbour. A face between lines of constant parameters and a seam, as most cylinders are, leaves no such choice, and nothing is said of it.

mod chart;
mod fitting;
mod pace;
mod track;

use std::collections::{BTreeMap, BTreeSet, HashMap};

use crate::error::Result;
pub use fitting::at_pace;
pub use pace::{Pace, can_turn, is_length, turned};
pub use track::noise;

use super::{Brep, CurveForm, Edge, Face, Parts, Projected, UsePlace, Vertex};
use crate::spline::trimmed::ParameterCurve;
use crate::spline::{Curve, Surface};

use chart::Chart;
use track::{Track, is_iso};

/// What splines may be apart where they close, as a part of their size.
const CLOSED: f64 = 1e-7;

/// The surface of a face, as its edges are to be drawn on it.
#[derive(Debug, Clone, Copy)]
pub struct Sheet<'s> {
    /// Whether its normal is that of the spline.
    pub same: bool,
    /// Whether it is taken as a plane, cylinder, cone, sphere or torus, with the parameters of these.
    pub elementary: bool,
    /// What it is taken as, where that is a spline.
    pub spline: Option<&'s Surface>,
}

/// How the edges of faces that meet themselves are drawn.
#[derive(Debug, Clone, Copy)]
pub struct Manner {
    /// Whether conics keep their own parameters; else lines and circles do, the way the edge runs, and all others are splines.
    pub conics: bool,
    /// Whether seams are [turned round](Drawings::back) where their later use runs against them: a parameter curve that belongs to a use, not to the edge, needs it not.
    pub backs: bool,
}

/// Edges in the parameters of faces.
#[derive(Debug, Default)]
pub struct Drawings {
    /// Over the parameters of the curve that stands for the edge in space, by where they are used.
    pub curves: BTreeMap<UsePlace, Curve>,
    /// Edges whose curves are to run the other way.
    pub back: BTreeSet<usize>,
    /// Whether a face has edges that should be said and are not, as they could not be.
    pub unsaid: bool,
    /// By how much curves are off their edges, where the tolerances of these say less.
    pub off: f64,
}

impl Drawings {
    /// Adds the edges of a face that meets itself along one of them; nothing of another face. One that cannot be said has none, as others have, and
    /// that is known afterwards.
    pub fn add(&mut self, brep: &Brep, face: usize, sheet: &Sheet<'_>, manner: Manner) {
        match drawn(brep, face, sheet, manner) {
            Ok(Some(mut found)) => {
                self.curves.append(&mut found.curves);
                self.back.append(&mut found.back);
                self.off = self.off.max(found.off);
            }
            Ok(None) | Err(_) => self.unsaid = true,
        }
    }
}

/// An edge laid out: where it starts and ends, and its curve where it is the surface's own.
struct Laid {
    ends: [[f64; 2]; 2],
    own: Option<ParameterCurve>,
}

/// The edges of a face, none where nothing is to be said; `None` where they cannot be.
fn drawn(brep: &Brep, face: usize, sheet: &Sheet<'_>, manner: Manner) -> Result<Option<Drawings>> {
    let nothing = Ok(Some(Drawings::default()));
    let Some(alone) = seams(brep, face) else { return nothing };
    let form = brep.surface_form(face);
    let size = size_of(brep, face);
    let chart = match sheet.spline {
        Some(surface) => Chart::of_spline(surface, CLOSED * size)?,
        None if sheet.elementary => Chart::of_form(&form, size),
        None => None,
    };
    let Some(chart) = chart else { return nothing };
    if !alone && sheet.elementary && all_iso(brep, face, &chart)? {
        return nothing;
    }
    let laid = if sheet.elementary { on_covering(brep, face, sheet, &chart) } else { on_spline(brep, face) }?;
    if !alone && laid.iter().flatten().all(|one| one.own.as_ref().is_some_and(is_line)) {
        return nothing;
    }
    let (mut all, mut tracks) = (Drawings::default(), Vec::new());
    for (chain, uses) in brep.loops(face).iter().enumerate() {
        let mut found = Vec::new();
        for (number, one) in uses.iter().enumerate() {
            let place = UsePlace { face, chain, number };
            let laid = laid.get(chain).and_then(|chain| chain.get(number));
            let (Some(mut edge), Some(laid)) = (brep.edge(one.edge), laid) else { return Ok(None) };
            if !manner.conics {
                edge.form = upright(&edge)?;
            }
            let back = manner.backs && runs_back(brep, one.edge, &edge)?;
            let pace = Pace::of(&edge, back)?;
            if back {
                all.back.insert(one.edge);
            }
            if let (Some(own), Some(surface)) = (&laid.own, sheet.spline)
                && let Some(curve) = at_pace(own, &edge, surface, pace)?
            {
                all.curves.insert(place, curve);
                continue;
            }
            let Some(track) = Track::new(&chart, &edge, pace, laid.ends)? else {
                return Ok(None);
            };
            found.push((place, track));
        }
        tracks.push(found);
    }
    if sheet.elementary {
        together(&mut tracks, &chart);
    }
    for (place, track) in tracks.iter().flatten() {
        let Some((curve, off)) = track.drawn()? else {
            return Ok(None);
        };
        all.off = all.off.max(off);
        all.curves.insert(*place, curve);
    }
    // A seam whose two uses are on one side of it bounds like any other edge.
    for (place, curve) in &all.curves {
        let held = brep.loops(face).get(place.chain).and_then(|chain| chain.get(place.number));
        let Some(number) = held.map(|one| one.edge) else { return Ok(None) };
        let mut others = brep.uses(number).iter().filter(|other| *other != place);
        let there = |other: &Curve| -> Result<bool> {
            let ((a, b), (c, d)) = (curve.domain(), other.domain());
            let [p, q] = [curve.point(0.5 * (a + b))?, other.point(0.5 * (c + d))?];
            let turns = chart.turns();
            Ok((0..2).all(|d| turns[d].is_none_or(|turn| (p[d] - q[d]).abs() < 0.5 * turn)))
        };
        if let Some(other) = others.next().and_then(|other| all.curves.get(other))
            && there(other)?
        {
            return Ok(None);
        }
    }
    Ok(Some(all))
}

/// What stands for an edge where conics but circles are splines: always along the edge.
fn upright(edge: &Edge) -> Result<CurveForm> {
    Ok(match edge.form {
        CurveForm::Line => CurveForm::Line,
        CurveForm::Circle { frame, radius } => {
            let along = Pace::of(edge, false)?.along();
            CurveForm::Circle { frame: if along { frame } else { turned(&frame) }, radius }
        }
        _ => CurveForm::Spline,
    })
}

/// Whether the curve of a seam is to be turned round, so that the later use of it runs along: of two parameter curves that belong to the edge the first is then that of the first use,
/// whoever counts uses, and whoever goes by which of them runs along.
fn runs_back(brep: &Brep, number: usize, edge: &Edge) -> Result<bool> {
    let [first, last] = brep.uses(number) else { return Ok(false) };
    if first.face != last.face || !can_turn(edge) {
        return Ok(false);
    }
    let held = brep.loops(last.face).get(last.chain).and_then(|chain| chain.get(last.number));
    let along = Pace::of(edge, false)?.along();
    Ok(held.is_some_and(|one| one.reversed == along))
}

/// Whether a face uses an edge twice, and then whether it has no other edges. `None` where it does not, or an edge has more than two uses: an edge has two parameter curves at most.
fn seams(brep: &Brep, face: usize) -> Option<bool> {
    let (mut some, mut alone) = (false, true);
    for one in brep.loops(face).iter().flatten() {
        let uses = brep.uses(one.edge);
        match uses.iter().filter(|place| place.face == face).count() {
            1 if uses.len() <= 2 => alone = false,
            2 if uses.len() == 2 => some = true,
            _ => return None,
        }
    }
    some.then_some(alone)
}

/// How far the control points of a face's surface are from the first of them, at most.
fn size_of(brep: &Brep, face: usize) -> f64 {
    let Some(surface) = brep.surface(face) else { return 0.0 };
    let points = surface.points();
    points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max)
}

/// Whether each edge of an elementary face lies along a line of constant parameters.
fn all_iso(brep: &Brep, face: usize, chart: &Chart<'_>) -> Result<bool> {
    for one in brep.loops(face).iter().flatten() {
        let Some(edge) = brep.edge(one.edge) else { return Ok(false) };
        if !is_iso(chart, &edge)? {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Whether a curve in parameters is a line of constant ones.
fn is_line(curve: &ParameterCurve) -> bool {
    let points = curve.curve().points();
    (0..2).any(|d| points.iter().all(|p| p[d] == points[0][d]))
}

/// The edges in the parameters of the face's own spline.
fn on_spline(brep: &Brep, face: usize) -> Result<Vec<Vec<Laid>>> {
    let laid = |found: Projected| Ok(Laid { ends: found.curve.ends()?, own: Some(found.curve) });
    let loops = brep.parameter_curves(face)?;
    loops.into_iter().map(|chain| chain.into_iter().map(laid).collect()).collect()
}

/// Where edges start and end in the parameters of an elementary surface: the face on the spline whose angles start where the frame's do.
fn on_covering(brep: &Brep, face: usize, sheet: &Sheet<'_>, chart: &Chart<'_>) -> Result<Vec<Vec<Laid>>> {
    let form = brep.surface_form(face);
    let Some(own) = brep.face(face) else { return Ok(Vec::new()) };
    let covering = form.covering(own.surface.points())?;
    let mut parts = Parts::default();
    let (mut edges, mut vertices): (HashMap<usize, usize>, HashMap<usize, usize>) = Default::default();
    let mut loops = own.loops;
    for one in loops.iter_mut().flatten() {
        one.parameters = None;
        let number = one.edge;
        one.edge = *edges.entry(number).or_insert(parts.edges.len());
        let Some(mut edge) = brep.edge(number).filter(|_| one.edge == parts.edges.len()) else { continue };
        for end in &mut edge.ends {
            let place = vertices.entry(*end).or_insert(parts.vertices.len());
            if *place == parts.vertices.len() {
                let (point, tolerance) = (brep.vertices()[*end], brep.tolerances()[*end]);
                parts.vertices.push(Vertex { point, tolerance });
            }
            *end = *place;
        }
        parts.edges.push(edge);
    }
    parts.faces.push(Face {
        surface: covering.clone(),
        // Its normal points outwards, as that of the form does.
        reversed: own.reversed == sheet.same,
        form,
        loops,
        points: Vec::new(),
        name: None,
        color: None,
    });
    let alone = Brep::new(parts)?;
    let mut all = Vec::new();
    for chain in alone.parameter_curves(0)? {
        let mut laid = Vec::new();
        for found in chain {
            let [a, b] = found.curve.ends()?;
            let ends = [chart.of_covering(&covering, a)?, chart.of_covering(&covering, b)?];
            laid.push(Laid { ends, own: None });
        }
        all.push(laid);
    }
    Ok(all)
}

/// Shifts loops by whole turns to where the longest one is.
fn together(loops: &mut [Vec<(UsePlace, Track<'_>)>], chart: &Chart<'_>) {
    for (d, turn) in chart.turns().into_iter().enumerate() {
        let Some(turn) = turn else { continue };
        let ranges: Vec<[f64; 2]> = loops
            .iter()
            .map(|tracks| {
                let all = tracks.iter().map(|(_, track)| track.bounds()[d]);
                all.fold([f64::INFINITY, f64::NEG_INFINITY], |a, b| [a[0].min(b[0]), a[1].max(b[1])])
            })
            .collect();
        let longest = ranges.iter().max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])));
        let Some(&[low, high]) = longest else { continue };
        for (tracks, range) in loops.iter_mut().zip(&ranges) {
            let turns = (0.5 * (low + high - range[0] - range[1]) / turn).round();
            if turns != 0.0 && turns.is_finite() {
                let mut by = [0.0; 2];
                by[d] = turns * turn;
                tracks.iter_mut().for_each(|(_, track)| track.shift(by));
            }
        }
    }
}
