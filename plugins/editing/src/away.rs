//! What is asked of a trimmed surface at places that its loops cut away.

use std::any::Any;

use loftsman_kernel::plugin::ConstraintReport;
use loftsman_kernel::scene::Unit;
use loftsman_kernel::shape::{Location, Shape};
use loftsman_kernel::spline::Trimmed;
use loftsman_kernel::text::without_rounding;

use crate::problem::Problem;

/// A place that is no further than this part of the surface's size from what the loops leave is on their border, to the accuracy of loops.
const ON_BORDER: f64 = 1e-6;

impl Problem {
    /// Constraints that hold at a place of a trimmed surface where its loops leave nothing: there the surface itself meets them, which nobody sees.
    /// `after` are the shapes in their objects' own coordinates, `scales` what a length of each is in the scene. One search for the nearest place each.
    pub(crate) fn cut_away(
        &self,
        after: &[&dyn Shape],
        reports: &[ConstraintReport],
        scale: impl Fn(usize) -> f64,
        unit: Unit,
    ) -> Vec<String> {
        let away = |(k, constraint): (usize, &loftsman_kernel::edit::Constraint)| {
            let rested = reports.get(k).and_then(|report| report.rested(constraint.functional()));
            let (shape, at) = rested.as_ref().unwrap_or(constraint.functional()).location()?;
            let Location::Surface(u, v) = at else { return None };
            let any: &dyn Any = *after.get(shape)?;
            let off = beyond(any.downcast_ref()?, [u, v])?;
            let (name, label) = (self.names.get(shape)?, constraint.label());
            let advice = if rested.is_some() {
                "say where with \"at\", or add a constraint that keeps it off there"
            } else {
                "give a place within the loops, or { closest = [x, y, z] }"
            };
            Some(format!(
                "{label}: [{u}, {v}] is a place that the loops of \"{name}\" cut away, {} off what they leave: {advice}",
                unit.quantity(scale(shape) * off, 1)
            ))
        };
        self.constraints.iter().enumerate().filter_map(away).collect()
    }
}

/// How far a place of a surface is from what loops leave of it, where they cut it away.
fn beyond(trimmed: &Trimmed, at: [f64; 2]) -> Option<f64> {
    let part = trimmed.part().ok()?;
    if part.has(at) {
        return None;
    }
    let point = trimmed.surface().point(at[0], at[1]).ok()?;
    let off = part.closest(point).ok()?.distance;
    let points = trimmed.surface().points();
    let size = points.iter().map(|p| (p - points[0]).amax()).fold(0.0, f64::max);
    Some(without_rounding(off, size)).filter(|off| *off > ON_BORDER * size)
}
