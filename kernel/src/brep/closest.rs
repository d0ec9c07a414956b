//! The place of a Brep that is nearest to a point.

use std::collections::HashMap;

use super::Brep;
use crate::error::{Error, Result};
use crate::spline::part::{Part, follow};
use crate::spline::trimmed::ParameterCurve;
use crate::{Point, parallel};

/// Where a loop ends this near to its start, as a part of the domain, it closes.
const JOINED: f64 = 1e-3;

/// A place on a Brep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FacePlace {
    /// The face.
    pub face: usize,
    /// The parameters of its surface.
    pub at: [f64; 2],
    /// The place itself.
    pub point: Point,
    /// How far it is from the point that was asked for.
    pub distance: f64,
}

impl Brep {
    /// What its loops leave of a face's surface, prepared for many questions: whether a place is on it, which place of it is nearest to a point.
    ///
    /// # Errors
    /// When there is no such face, or its curves in the parameter plane cannot be computed.
    pub fn part(&self, face: usize) -> Result<Part> {
        let surface = self.surface(face).ok_or_else(|| Error::Invalid(format!("there is no face {face}")))?;
        let curves: Vec<Vec<ParameterCurve>> = self
            .parameter_curves(face)?
            .into_iter()
            .map(|chain| chain.into_iter().map(|one| one.curve).collect())
            .collect();
        let size = surface.points().iter().map(|p| (p - surface.points()[0]).amax()).fold(0.0, f64::max);
        let sides = surface.parameter_sides(1e-6 * size)?;
        // A seam bounds nothing: what is on its one side goes on on the other.
        let mut known: HashMap<usize, Vec<[f64; 2]>> = HashMap::new();
        for (one, curve) in
            self.loops(face).iter().zip(&curves).flat_map(|(uses, chain)| uses.iter().zip(chain))
        {
            let start = curve.curve().point(curve.range().0)?;
            known.entry(one.edge).or_default().push([start.x, start.y]);
        }
        let is_seam = |edge: usize| match known.get(&edge).map(Vec::as_slice) {
            Some([a, b]) => (0..2).any(|d| {
                let away = (a[d] - b[d]).abs() / sides[d].length();
                sides[d].closed && (away - 1.0).abs() <= 1e-6
            }),
            _ => false,
        };
        let mut lines = Vec::with_capacity(curves.len());
        for (uses, chain) in self.loops(face).iter().zip(&curves) {
            let mut line = Vec::new();
            for (one, curve) in uses.iter().zip(chain) {
                if is_seam(one.edge) {
                    lines.push(std::mem::take(&mut line));
                    continue;
                }
                follow(&mut line, curve, one.reversed)?;
            }
            // Ends that tolerances or rounding leave apart are joined, or places beside them would be taken for inside.
            if let (Some(&first), Some(&last)) = (line.first(), line.last()) {
                let start = [0, 1].map(|d| sides[d].unwrapped(first[d], last[d]));
                if start != last && (0..2).all(|d| (start[d] - last[d]).abs() <= JOINED * sides[d].length()) {
                    line.push(start);
                }
            }
            lines.push(line);
        }
        lines.retain(|line| line.len() > 1);
        if self.is_reversed(face) {
            lines.iter_mut().for_each(|line| line.reverse());
        }
        Ok(Part::new(surface, &lines, sides, curves.into_iter().flatten().collect()))
    }

    /// The place of the Brep that is nearest to a point: on each face that may have it, the nearest place of its surface where that is inside the
    /// loops, else the nearest one of what is inside and of the edges. A search or two on each such surface.
    ///
    /// # Errors
    /// When the point is not finite, there are no faces, or an evaluation overflows.
    pub fn closest(&self, point: Point) -> Result<FacePlace> {
        if !point.iter().all(|c| c.is_finite()) {
            return Err(Error::Invalid("the point is not finite".into()));
        }
        let mut faces: Vec<(f64, usize)> =
            (0..self.face_count()).map(|face| (self.at_least(face, point), face)).collect();
        faces.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut best: Option<FacePlace> = None;
        // Some faces at once; those that cannot be nearer than what is found are left out.
        for some in faces.chunks(8) {
            let reach = best.map_or(f64::INFINITY, |best| best.distance);
            let near: Vec<usize> =
                some.iter().filter(|(least, _)| *least <= reach).map(|(_, face)| *face).collect();
            for found in parallel::map(near.len(), |k| self.closest_on(near[k], point)) {
                let found = found?;
                if best.is_none_or(|best| found.distance < best.distance) {
                    best = Some(found);
                }
            }
        }
        best.ok_or_else(|| Error::Invalid("a brep without faces has no place".into()))
    }

    /// No place of a face is nearer than this: the box of its surface's control vertices.
    fn at_least(&self, face: usize, point: Point) -> f64 {
        let net = &self.net[self.range_of(face)];
        let Some(first) = net.first() else { return f64::INFINITY };
        let (low, high) = net.iter().fold((*first, *first), |(low, high), p| (low.inf(p), high.sup(p)));
        let beside = (0..3).map(|k| (low[k] - point[k]).max(point[k] - high[k]).max(0.0));
        beside.map(|d| d * d).sum::<f64>().sqrt()
    }

    fn closest_on(&self, face: usize, point: Point) -> Result<FacePlace> {
        let found = self.part(face)?.closest(point)?;
        Ok(FacePlace { face, at: found.at.into(), point: found.point, distance: found.distance })
    }
}
