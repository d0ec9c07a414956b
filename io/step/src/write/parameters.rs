//! Parameter curves of edges: what they are in the parameters of B-spline surfaces.
//!
//! The schema wants them at the pace of the curve in space, and on the very surface that is written. Planes, cylinders and their like have other
//! parameters in the file than their splines have: there readers compute them, as they do where none is written; but for [faces with a seam](loftsman_kernel::brep::drawn).

use loftsman_kernel::Result;
use loftsman_kernel::brep::drawn::{Drawings, Pace, at_pace};
use loftsman_kernel::brep::{Brep, UsePlace};
use loftsman_kernel::spline::Curve;

use super::brep::Sheet;
use super::print::{Printer, list, real, references};

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
