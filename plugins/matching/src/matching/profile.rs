//! How far two surfaces are from one another all along an edge.

use loftsman_kernel::error::Result;
use loftsman_kernel::functional::{Functional, Shapes};

use super::Matching;
use super::bound::{Bound, SHARP};
use crate::beside::{Beside, edge_of};
use crate::contact::{Contact, Frame, Partials};
use crate::deviation::Deviation;
use crate::near::{Near, Place};

impl Matching {
    /// How far the surfaces are from one another, now: position, angle and curvature at places all along the edge, between those
    /// where they are imposed.
    ///
    /// # Errors
    /// When the match cannot be asked of these shapes.
    pub fn deviation(&self, shapes: &Shapes<'_>) -> Result<Deviation> {
        Ok(Deviation::worst(&self.profile(shapes)?))
    }

    /// The deviation at many places all along the edge, its ends among them, and where between these each of its measures is largest; by the edge's
    /// parameter.
    pub(crate) fn profile(&self, shapes: &Shapes<'_>) -> Result<Vec<(f64, Deviation)>> {
        let bound = self.fixed(shapes)?;
        let other = shapes.get(self.other.shape)?;
        let there = edge_of(shapes, &self.other, self.other_edge, &self.describe())?;
        let edge = edge_of(shapes, &self.on, self.edge, &self.describe())?;
        let beside = Beside::along(edge, &there.curve, bound.track)?;
        let near = self.near(shapes, &bound)?;
        let step = self.step(shapes)?;
        let at = |t: f64| -> Result<Option<Deviation>> {
            let u = beside.there(t);
            let frame = match Frame::new(other, &there.edge, u) {
                Ok(frame) => frame,
                // Of position alone, a pole somewhere matters not.
                Err(_) if self.continuity == 0 => return Ok(None),
                Err(error) => return Err(error),
            };
            let (at, by) = (beside.at(t), Partials::new(&beside.edge.edge));
            let contact = Contact { at, by, at_end: beside.edge.edge.at_end, step, frame };
            let place = Place { t, point: there.curve.point(u)?, u, contact };
            Ok(Some(self.deviation_at(shapes, &bound, &near, &place)?))
        };
        let mut profile = Vec::new();
        for t in beside.told() {
            profile.extend(at(t)?.map(|found| (t, found)));
        }
        let peaks = crate::deviation::peaks(&profile, &at)?;
        profile.extend(peaks);
        profile.sort_by(|x, y| x.0.total_cmp(&y.0));
        Ok(profile)
    }

    /// The largest angle between the tangent planes of the other surface on both sides of a place of its edge, in radians, and its parameter there; only what is sharp.
    pub(crate) fn corner_there(&self, shapes: &Shapes<'_>) -> Result<Option<(f64, f64)>> {
        let bound = self.fixed(shapes)?;
        let other = shapes.get(self.other.shape)?;
        let there = edge_of(shapes, &self.other, self.other_edge, &self.describe())?;
        let edge = edge_of(shapes, &self.on, self.edge, &self.describe())?;
        let beside = Beside::along(edge, &there.curve, bound.track)?;
        let mut sharpest = None::<(f64, f64)>;
        for sides in beside.sides() {
            let frames = sides.map(|t| Frame::new(other, &there.edge, beside.there(t)));
            let [Ok(before), Ok(behind)] = frames else { continue };
            let angle = before.normal.angle(&behind.normal);
            if angle > sharpest.map_or(SHARP, |(most, _)| most) {
                sharpest = Some((angle, beside.there(0.5 * sides[0] + 0.5 * sides[1])));
            }
        }
        Ok(sharpest)
    }

    pub(super) fn deviations(&self, shapes: &Shapes<'_>, bound: &Bound) -> Result<Vec<(f64, Deviation)>> {
        let near = self.near(shapes, bound)?;
        let each = bound.between.iter();
        each.map(|place| Ok((place.t, self.deviation_at(shapes, bound, &near, place)?))).collect()
    }

    pub(super) fn deviation_at(
        &self,
        shapes: &Shapes<'_>,
        bound: &Bound,
        near: &Near<'_>,
        place: &Place,
    ) -> Result<Deviation> {
        let found = near.measure(shapes, place)?;
        let curvature = found.measured.curvature.abs();
        Ok(Deviation {
            distance: found.apart.norm(),
            angle: found.measured.angle,
            curvature,
            part: curvature / bound.curvature,
            square: if curvature > 0.0 { curvature / bound.square } else { 0.0 },
            flat: bound.flat,
        })
    }

    /// What finds the places of the edges that are nearest to one another.
    pub(super) fn near<'a>(&self, shapes: &Shapes<'a>, bound: &Bound) -> Result<Near<'a>> {
        let there = edge_of(shapes, &self.other, self.other_edge, &self.describe())?;
        let own = edge_of(shapes, &self.on, self.edge, &self.describe())?;
        Near::new(shapes.get(self.other.shape)?, there, self.on.shape, own, bound.apart)
    }
}
