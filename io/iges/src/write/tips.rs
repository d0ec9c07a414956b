//! Tips of cones that edges miss by the noise of a file.
//!
//! Near a tip the noise of a file says at which angle a place lies: OpenCASCADE took a seam that missed the tip by 1e-10 for one that ends elsewhere, and its face for another one. What is
//! meant to end at a tip is written as ending there.

use std::collections::HashMap;

use loftsman_kernel::brep::drawn::noise;
use loftsman_kernel::brep::{Brep, CurveForm, Edge, SurfaceForm};
use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Point, Result};

/// Vertices that are moved to tips, and by how much at most.
#[derive(Default)]
pub(super) struct Tips {
    moved: HashMap<usize, Point>,
    pub(super) off: f64,
}

impl Tips {
    pub(super) fn of(brep: &Brep) -> Result<Self> {
        let mut tips = Self::default();
        for face in 0..brep.face_count() {
            let SurfaceForm::Cone { frame, radius, angle } = brep.surface_form(face) else { continue };
            let tip = frame.origin - frame.z * (radius / angle.tan());
            if !tip.iter().all(|c| c.is_finite()) {
                continue;
            }
            for one in brep.loops(face).iter().flatten() {
                let Some(edge) = brep.edge(one.edge).filter(|edge| matches!(edge.form, CurveForm::Line))
                else {
                    continue;
                };
                let ends = [edge.curve.point(edge.range.0)?, edge.curve.point(edge.range.1)?];
                let noise = noise(&ends, edge.tolerance);
                for (vertex, end) in edge.ends.into_iter().zip(ends) {
                    let by = nalgebra::distance(&brep.vertices()[vertex], &tip)
                        .max(nalgebra::distance(&end, &tip));
                    if by > 0.0 && by <= noise {
                        tips.moved.insert(vertex, tip);
                        tips.off = tips.off.max(by);
                    }
                }
            }
        }
        Ok(tips)
    }

    /// Puts vertices where they are meant to be.
    pub(super) fn put(&self, points: &mut [Point]) {
        for (&vertex, tip) in &self.moved {
            if let Some(point) = points.get_mut(vertex) {
                *point = *tip;
            }
        }
    }

    /// An edge that ends where it is meant to.
    pub(super) fn meant(&self, edge: Edge) -> Result<Edge> {
        let known = edge.ends.map(|end| self.moved.get(&end));
        if !matches!(edge.form, CurveForm::Line) || known == [None; 2] {
            return Ok(edge);
        }
        let [start, end] = [edge.curve.point(edge.range.0)?, edge.curve.point(edge.range.1)?];
        let curve = Curve::line(known[0].copied().unwrap_or(start), known[1].copied().unwrap_or(end))?;
        Ok(Edge { range: curve.domain(), curve, ..edge })
    }
}
