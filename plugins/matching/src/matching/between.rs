//! A match looked at between the places where it was imposed.

use loftsman_kernel::error::Result;
use loftsman_kernel::functional::{Accuracy, Functional, Linearity, Rows, Shapes};
use loftsman_kernel::shape::Derivative;

use super::bound::Bound;
use super::{Matching, put};
use crate::contact::Contact;
use crate::edge_on::unbound;

/// The match looked at between the places where it was imposed: every number divided by its limit and multiplied by the
/// allowed distance, so that one accuracy judges all.
#[derive(Debug)]
pub(super) struct Between {
    pub(super) of: Matching,
}

impl Between {
    fn bound(&self) -> Result<&Bound> {
        self.of.bound.as_deref().ok_or_else(|| unbound(&self.of.describe()))
    }

    /// The factors of slope and bend at a place that make them lengths to be judged by the allowed distance.
    fn factors(&self, shapes: &Shapes<'_>, bound: &Bound, contact: &Contact) -> Result<[f64; 2]> {
        let across = contact.across(shapes.get(self.of.on.shape)?)? * contact.step;
        let limits = &self.of.limits;
        let slope = bound.distance / (limits.angle.sin() * across);
        let bend = bound.distance / (limits.curvature * bound.curvature * across * across);
        Ok([slope, bend].map(|factor| if factor.is_finite() { factor } else { 1.0 }))
    }
}

impl Functional for Between {
    fn equations(&self) -> usize {
        let count = self.of.bound.as_ref().map_or(0, |bound| bound.between.len());
        (3 + self.of.continuity) * count
    }

    fn linearity(&self) -> Linearity {
        Linearity::Nonlinear
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        let (bound, on) = (self.bound()?, self.of.on.shape);
        for place in &bound.between {
            rows.alike(on, &shapes.stencil(on, place.contact.at, Derivative::POSITION)?);
            rows.constant(-place.point.coords);
            if self.of.continuity > 0 {
                let by = self.factors(shapes, bound, &place.contact)?;
                put(rows, shapes, on, &place.contact, self.of.continuity, by)?;
            }
        }
        Ok(())
    }

    fn value(&self, shapes: &Shapes<'_>, out: &mut [f64]) -> Result<()> {
        let bound = self.bound()?;
        let near = self.of.near(shapes, bound)?;
        for (place, out) in bound.between.iter().zip(out.chunks_exact_mut(3 + self.of.continuity)) {
            let (found, limits) = (near.measure(shapes, place)?, &self.of.limits);
            let (apart, found) = (found.apart, found.measured);
            // The planes may differ along the edge as well, where positions do: what counts is the whole angle, and each
            // surface's own curvature.
            let angle = found.angle / limits.angle * bound.distance;
            let curvature = found.curvature / (limits.curvature * bound.curvature) * bound.distance;
            let all = [apart.x, apart.y, apart.z, angle.copysign(found.slope), curvature];
            out.iter_mut().zip(all).for_each(|(out, value)| *out = value);
        }
        Ok(())
    }

    fn describe(&self) -> String {
        format!("{}, all along", self.of.describe())
    }

    fn is_condition(&self) -> bool {
        true
    }

    fn accuracy(&self) -> Accuracy {
        self.of.bound.as_ref().map_or(Accuracy::Rounding, |bound| Accuracy::Within(bound.distance))
    }
}
