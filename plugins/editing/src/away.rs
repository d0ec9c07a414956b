//! What is asked of a trimmed surface at places that its loops cut away.

use std::any::Any;
use std::collections::HashMap;

use loftsman_kernel::edit::Constraint;
use loftsman_kernel::plugin::ConstraintReport;
use loftsman_kernel::scene::Scene;
use loftsman_kernel::shape::{Location, Shape};
use loftsman_kernel::spline::Trimmed;
use loftsman_kernel::spline::part::Part;
use loftsman_kernel::text::without_rounding;

use crate::problem::Problem;

/// A place that is no further than this part of the surface's size from what the loops leave is on their border, to the accuracy of loops.
const ON_BORDER: f64 = 1e-6;

impl Problem {
    /// Constraints that hold at a place of a trimmed surface where its loops leave nothing: there the surface itself meets them, which nobody sees.
    /// `after` are the shapes in their objects' own coordinates. One search for the nearest place each.
    pub(crate) fn cut_away(
        &self,
        scene: &Scene,
        after: &[&dyn Shape],
        reports: &[ConstraintReport],
    ) -> Vec<String> {
        // What loops leave is looked at once for each shape.
        let mut parts: HashMap<usize, Option<Part>> = HashMap::new();
        let away = |(k, constraint): (usize, &Constraint)| {
            let rested = reports.get(k).and_then(|report| report.rested(constraint.functional()));
            let (shape, at) = rested.as_ref().unwrap_or(constraint.functional()).location()?;
            let Location::Surface(u, v) = at else { return None };
            let any: &dyn Any = *after.get(shape)?;
            let trimmed: &Trimmed = any.downcast_ref()?;
            let off = beyond(parts.entry(shape).or_insert_with(|| trimmed.part().ok()).as_ref()?, [u, v])?;
            let (name, label) = (self.names.get(shape)?, constraint.label());
            let scale = scene.standing(name).map_or(1.0, |standing| standing.most());
            let advice = if rested.is_some() {
                "say where with \"at\", or add a constraint that keeps it off there"
            } else {
                "give a place within the loops, or { closest = [x, y, z] }"
            };
            Some(format!(
                "{label}: [{u}, {v}] is a place that the loops of \"{name}\" cut away, {} off what they leave: {advice}",
                scene.unit.quantity(scale * off, 1)
            ))
        };
        self.constraints.iter().enumerate().filter_map(away).collect()
    }
}

/// How far a place of a surface is from what loops leave of it, where they cut it away.
fn beyond(part: &Part, at: [f64; 2]) -> Option<f64> {
    if part.has(at) {
        return None;
    }
    let point = part.surface().point(at[0], at[1]).ok()?;
    let off = part.closest(point).ok()?.distance;
    let points = part.surface().points();
    let size = points.iter().map(|p| (p - points[0]).amax()).fold(0.0, f64::max);
    Some(without_rounding(off, size)).filter(|off| *off > ON_BORDER * size)
}
