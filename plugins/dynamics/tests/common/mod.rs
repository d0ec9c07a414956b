//! What several of the tests start from.

#![allow(clippy::unwrap_used, reason = "what is missing fails the test")]

use loftsman_dynamics::Dynamics;
use loftsman_kernel::Point;
use loftsman_kernel::plugin::{Context, OperationError, Parameters, Registry, StepReport};
use loftsman_kernel::scene::Scene;
use loftsman_kernel::spline::{Curve, Space};
use serde_json::Value;

/// Runs `simulate` with these fields, beside the constraints of the kernel and those of areas and volumes.
pub(crate) fn run(scene: &mut Scene, fields: Value) -> Result<StepReport, OperationError> {
    let mut registry = Registry::new();
    registry.add(&Dynamics);
    registry.add(&loftsman_area_volume::AreaVolume);
    loftsman_kernel::plugin::register_functionals(&mut registry);
    let operation = registry.find_operation("simulate", "step[0]").unwrap();
    operation.apply(scene, &Parameters::new(fields, "step[0]").unwrap(), &Context::quiet(&registry))
}

/// A straight curve between two points, of constant speed, over uniform knots.
pub(crate) fn line(degree: usize, n: usize, from: [f64; 3], to: [f64; 3]) -> Curve {
    let space = Space::clamped_uniform(degree, n).unwrap();
    let (a, b) = (Point::from(from), Point::from(to));
    let end = space.domain().1;
    let points = (0..n).map(|i| a + (b - a) * (space.greville(i) / end)).collect();
    Curve::new(space, points).unwrap()
}
