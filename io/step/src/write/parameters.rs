//! Parameter curves of edges: what they are in the parameters of B-spline surfaces.
//!
//! The schema wants them at the pace of the curve in space, and on the very surface that is written. Planes, cylinders and their like have other
//! parameters in the file than their splines have: there readers compute them, as they do where none is written; but for [faces with a seam](super::drawn).

use loftsman_kernel::Result;
use loftsman_kernel::brep::{Brep, Edge, UsePlace};
use loftsman_kernel::spline::trimmed::ParameterCurve;
use loftsman_kernel::spline::{Curve, Direction, Space, Surface};

use super::brep::Sheet;
use super::drawn::Drawings;
use super::pace::Pace;
use super::print::{Printer, list, real, references};

/// Places in each span of an edge and of its parameter curve at which their pace is compared.
const EACH: usize = 5;
/// How far they may be apart, as a part of the edge's size, where its tolerance says less.
const NEAR: f64 = 1e-7;
/// So much further off than the surface's nearest point a place may be.
const AS_GOOD: f64 = 1.01;
/// How far beyond the domain of a surface a parameter may be by rounding, as a part of it.
const SLACK: f64 = 1e-12;
/// Domains that differ by a smaller part of them are the same.
const SAME: f64 = 1e-12;

impl Printer {
    /// The curve of an edge, with what it is on the faces where that is known; itself where it is not. `left` is set where a parameter curve
    /// stays out.
    pub(super) fn on_surfaces(
        &mut self,
        brep: &Brep,
        edge: usize,
        (sheets, drawings): (&[Sheet], &Drawings),
        (curve, pace): (u64, Pace),
        left: &mut bool,
    ) -> Result<u64> {
        let Some(own) = brep.edge(edge) else { return Ok(curve) };
        let mut found: Vec<(UsePlace, bool, u64)> = Vec::new();
        let uses = brep.uses(edge);
        for one in uses {
            let held = brep.loops(one.face).get(one.chain).and_then(|chain| chain.get(one.number));
            let (Some(held), Some(sheet)) = (held, sheets.get(one.face)) else { continue };
            if let Some(drawn) = drawings.curves.get(one) {
                found.push((*one, held.reversed, self.parameter_curve(drawn, sheet.number)));
                continue;
            }
            let (number, Some(surface)) = (sheet.number, sheet.spline.as_ref()) else { continue };
            let Some(parameters) = &held.parameters else { continue };
            let Some(fitting) = at_pace(parameters, &own, surface, pace)? else {
                *left = true;
                continue;
            };
            found.push((*one, held.reversed, self.parameter_curve(&fitting, number)));
        }
        // No more than two are allowed; of a seam, the one of the use along the edge comes first.
        if found.len() > 2 {
            *left = true;
            found.truncate(2);
        }
        let seam = matches!(&found[..], [a, b] if a.0.face == b.0.face);
        if seam {
            found.sort_by_key(|one| one.1);
        }
        if found.is_empty() {
            return Ok(curve);
        }
        let all: Vec<u64> = found.iter().map(|one| one.2).collect();
        let kind = if seam { "SEAM_CURVE" } else { "SURFACE_CURVE" };
        Ok(self.put(&format!("{kind}('',#{curve},{},.CURVE_3D.)", references(&all))))
    }

    /// A clamped curve in the parameters of a surface.
    pub(super) fn parameter_curve(&mut self, curve: &Curve, surface: u64) -> u64 {
        let planar = self.planar(curve);
        self.in_parameters(planar, surface)
    }

    /// What was written in two coordinates as a curve in the parameters of a surface.
    fn in_parameters(&mut self, planar: u64, surface: u64) -> u64 {
        let context = self.parameter_plane();
        let representation = self.put(&format!("DEFINITIONAL_REPRESENTATION('',(#{planar}),#{context})"));
        self.put(&format!("PCURVE('',#{surface},#{representation})"))
    }

    /// The context of curves in parameter planes, written once.
    fn parameter_plane(&mut self) -> u64 {
        if let Some(known) = self.plane {
            return known;
        }
        let context = self.put(
            "(GEOMETRIC_REPRESENTATION_CONTEXT(2)PARAMETRIC_REPRESENTATION_CONTEXT()REPRESENTATION_CONTEXT('parameters',''))",
        );
        self.plane = Some(context);
        context
    }

    /// A clamped curve of two coordinates.
    fn planar(&mut self, curve: &Curve) -> u64 {
        let points = curve.points().iter();
        let points: Vec<u64> = points
            .map(|p| self.put(&format!("CARTESIAN_POINT('',{})", list([real(p.x), real(p.y)]))))
            .collect();
        self.curve_of(curve, &references(&points))
    }
}

/// A parameter curve as it is written: over `pace`, from the edge's start to its end. `None` where it is not the edge at that pace.
pub(super) fn at_pace(
    parameters: &ParameterCurve,
    edge: &Edge,
    surface: &Surface,
    pace: Pace,
) -> Result<Option<Curve>> {
    let (start, end) = parameters.range();
    let whole = (start, end) == parameters.curve().domain();
    let part =
        if whole { parameters.curve().to_clamped()? } else { parameters.curve().between(start, end)? };
    let into = |t: f64, direction: Direction| {
        let ((a, b), space) = (surface.space(direction).domain(), surface.space(direction));
        let slack = SLACK * space.length();
        (t >= a - slack && t <= b + slack).then(|| t.clamp(a, b))
    };
    let (low, high) = part.bounds();
    for (k, direction) in [Direction::U, Direction::V].into_iter().enumerate() {
        if into(low[k], direction).is_none() || into(high[k], direction).is_none() {
            return Ok(None);
        }
    }
    let part = if pace.along() { part } else { part.reverse()? };
    let (from, to) = (pace.from.min(pace.to), pace.from.max(pace.to));
    let (a, b) = part.domain();
    // Angles are computed: what is the same but for rounding stays.
    let same = (a - from).abs().max((b - to).abs()) <= SAME * (to - from);
    let fitting = if same { part } else { part.reparametrise(from, to)? };
    let own = edge.curve.between(edge.range.0, edge.range.1)?;
    let points = own.points();
    let size = points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max);
    let near = edge.tolerance.max(NEAR * size);
    let share = |space: &Space| -> Vec<f64> {
        let (a, b) = space.domain();
        space.breakpoints().into_iter().map(|t| (t - a) / (b - a)).collect()
    };
    // Shares of the edge, which a curve against it runs through from the end.
    let mut shares = share(fitting.space());
    if !pace.along() {
        shares.iter_mut().for_each(|share| *share = 1.0 - *share);
    }
    if pace.is_even() {
        shares.extend(share(own.space()));
    }
    shares.sort_by(f64::total_cmp);
    let (first, last) = fitting.domain();
    for pair in shares.windows(2) {
        for k in 0..=EACH {
            let share = pair[0] + (pair[1] - pair[0]) * (k as f64 / EACH as f64);
            let along = if pace.along() { share } else { 1.0 - share };
            let at = fitting.point((first + (last - first) * along).clamp(first, last))?;
            let point = pace.point(&own, share)?;
            let (Some(u), Some(v)) = (into(at.x, Direction::U), into(at.y, Direction::V)) else {
                return Ok(None);
            };
            let apart = nalgebra::distance(&surface.point(u, v)?, &point);
            // An edge that is off its surface is nowhere nearer: then the nearest place is as good as can be.
            if apart > near && apart > AS_GOOD * surface.foot(point, (u, v))?.distance {
                return Ok(None);
            }
        }
    }
    Ok(Some(fitting))
}
