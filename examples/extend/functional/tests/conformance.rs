//! It is a functional, in edits and in recipes.

use loftsman_editing::Editing;
use loftsman_example_functional::MeanHeight;
use loftsman_kernel::Point;
use loftsman_kernel::conformance::{functional_conformance, sample_shapes};
use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::functional::position;
use loftsman_kernel::plugin::{Context, Parameters, Registry};
use loftsman_kernel::scene::{Object, Scene};
use loftsman_kernel::spline::{Curve, Space};
use serde_json::json;

#[test]
fn it_conforms() {
    for shape in sample_shapes(false) {
        let verdict = functional_conformance(&MeanHeight, &[shape]);
        assert!(verdict.passed(), "{verdict}");
    }
}

#[test]
fn it_works_in_an_edit_and_by_name_in_a_recipe() {
    let points = (0..8).map(|i| Point::new(f64::from(i), 0.0, 1.0)).collect();
    let curve = Curve::new(Space::clamped_uniform(3, 8).unwrap(), points).unwrap();
    let raised = Edit::new(&curve).ask(MeanHeight.to(2.0)).ask(position(0.0).keep()).solve().unwrap();
    assert!(raised.report().residual < 1e-13 && raised.shape().point(2.5).unwrap().z > 1.5);

    let mut registry = Registry::new();
    registry.add(&Editing).add(&MeanHeight);
    let mut scene = Scene::new();
    scene.add(Object::new("batten", curve.into())).unwrap();
    let step = json!({ "constraints": [{ "kind": "mean-height", "scale": 3.0 }] });
    let edit = registry.find_operation("edit", "op").unwrap().clone();
    let report = edit
        .apply(&mut scene, &Parameters::new(step, "step[0]").unwrap(), &Context::quiet(&registry))
        .unwrap();
    assert!(report.residual.unwrap() < 1e-13);
    let raised = scene.curve("batten").unwrap();
    let mean: f64 = (0..500).map(|i| raised.point((f64::from(i) + 0.5) / 100.0).unwrap().z / 500.0).sum();
    assert!((mean - 3.0).abs() < 1e-3, "{mean}");
}
