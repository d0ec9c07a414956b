//! It is an operation.

use loftsman_example_operation::Snap;
use loftsman_kernel::conformance::{operation_conformance, sample_scene};
use loftsman_kernel::plugin::{Context, Operation, Parameters, Registry};
use serde_json::json;

#[test]
fn it_conforms() {
    let mut registry = Registry::new();
    registry.add(&Snap);
    let parameters = Parameters::new(json!({ "object": "clamped curve", "step": 0.5 }), "step[0]").unwrap();
    let verdict = operation_conformance(&Snap, &sample_scene(), &parameters, &registry);
    assert!(verdict.passed(), "{verdict}");
}

#[test]
fn vertices_land_on_the_grid() {
    let (mut scene, registry) = (sample_scene(), Registry::new());
    let parameters = Parameters::new(json!({ "object": "clamped curve", "step": 0.5 }), "step[0]").unwrap();
    Snap.apply(&mut scene, &parameters, &Context::quiet(&registry)).unwrap();
    let curve = scene.curve("clamped curve").unwrap();
    assert!(curve.points().iter().all(|p| p.iter().all(|c| (c * 2.0).fract() == 0.0)));
}
