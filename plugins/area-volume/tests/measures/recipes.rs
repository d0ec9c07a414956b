//! The functionals as recipes ask for them, in `edit` and `drag`.

use loftsman_area_volume::{AreaVolume, area, area_of, volume_of};
use loftsman_editing::Editing;
use loftsman_kernel::functional::{Functional, Shapes};
use loftsman_kernel::plugin::{Context, OperationError, Parameters, Registry, StepReport};
use loftsman_kernel::scene::{Object, Scene};
use serde_json::{Value, json};

use crate::samples::{ball, circle, oval, pebble};

fn registry() -> Registry {
    let mut registry = Registry::new();
    registry.add(&Editing).add(&AreaVolume);
    registry
}

fn scene() -> Scene {
    let mut scene = Scene::new();
    scene.add(Object::new("section", oval().into())).unwrap();
    scene.add(Object::new("duct", circle(0.3).into())).unwrap();
    scene.add(Object::new("hull", ball(8, 6).into())).unwrap();
    scene
}

fn run(scene: &mut Scene, op: &str, step: Value) -> Result<StepReport, OperationError> {
    let registry = registry();
    let operation = registry.find_operation(op, "op").unwrap().clone();
    let parameters = Parameters::new(step, "step[0]").unwrap();
    parameters.check(operation.declaration().fields).unwrap();
    operation.apply(scene, &parameters, &Context::quiet(&registry))
}

#[test]
fn an_edit_keeps_what_lies_between_section_and_duct() {
    let between = |scene: &Scene| {
        let mut out = [0.0];
        let (outer, inner) = (scene.curve("section").unwrap(), scene.curve("duct").unwrap());
        let shapes: [&dyn loftsman_kernel::shape::Shape; 2] = [outer, inner];
        area().holes([1]).value(&Shapes::new(shapes), &mut out).unwrap();
        out[0]
    };
    let mut scene = scene();
    let before = between(&scene);
    let report = run(
        &mut scene,
        "edit",
        json!({ "object": "section", "constraints": [
            { "kind": "area", "objects": ["section"], "holes": ["duct"], "keep": true },
            { "kind": "area", "object": "duct", "normal": [0, 0, 1], "scale": 1.5 },
            { "kind": "centroid", "object": "duct", "keep": true },
            { "kind": "length", "by": 0.1 },
            { "kind": "symmetry", "normal": [1, 0, 0] },
        ] }),
    )
    .unwrap();
    assert!((between(&scene) / before - 1.0).abs() < 1e-12);
    assert!(report.residual.unwrap() < 1e-12 && report.constraints.len() >= 5, "{report:?}");
    assert!(
        (area_of(scene.curve("duct").unwrap()).unwrap() / (0.09 * std::f64::consts::PI) - 1.5).abs() < 1e-11
    );
}

#[test]
fn drags_keep_area_and_volume_with_axes_together_or_alternating() {
    for axes in ["together", "alternating"] {
        let mut scene = scene();
        let kept = (
            area_of(scene.curve("section").unwrap()).unwrap(),
            volume_of(scene.surface("hull").unwrap()).unwrap(),
        );
        let path: Vec<[f64; 3]> = (1..=5).map(|i| [2.0 + 0.1 * f64::from(i), 0.1, 0.0]).collect();
        let step = json!({ "object": "section", "handle": { "kind": "position", "at": 2 }, "path": path, "axes": axes,
                           "constraints": [{ "kind": "area", "keep": true }], "frames": true });
        run(&mut scene, "drag", step).unwrap();
        assert!((area_of(scene.curve("section").unwrap()).unwrap() / kept.0 - 1.0).abs() < 1e-12);
        assert_eq!(scene.object("section").unwrap().animation.as_ref().unwrap().frames.len(), 6);
        let step = json!({ "object": "hull", "handle": { "kind": "position", "at": [2, 1.5] }, "path": path, "axes": axes,
                           "constraints": [{ "kind": "volume", "keep": true }] });
        run(&mut scene, "drag", step).unwrap();
        assert!((volume_of(scene.surface("hull").unwrap()).unwrap() / kept.1 - 1.0).abs() < 1e-12);
    }
}

#[test]
fn what_cannot_be_names_the_place_and_the_object() {
    let refused = |object: &str, constraint: Value, words: &[&str]| {
        let mut scene = scene();
        let mut open = pebble().into_parts().1;
        open[0].x += 0.5;
        let torn = loftsman_kernel::spline::Curve::new(pebble().space().clone(), open).unwrap();
        scene.add(Object::new("torn", torn.into())).unwrap();
        let error =
            run(&mut scene, "edit", json!({ "object": object, "constraints": [constraint] })).unwrap_err();
        let error = error.to_string();
        for word in words {
            assert!(error.contains(word), "\"{word}\" is not in: {error}");
        }
    };
    let place = "step[0].constraints[0]";
    refused("torn", json!({ "kind": "area", "keep": true }), &[place, "\"torn\"", "open", "0.5 away"]);
    refused("hull", json!({ "kind": "area", "keep": true }), &[place, "\"hull\"", "surface-area"]);
    refused("section", json!({ "kind": "volume", "keep": true }), &[place, "\"section\"", "curve"]);
    refused("section", json!({ "kind": "area", "to": -2 }), &["\"section\"", "same sign"]);
    refused(
        "section",
        json!({ "kind": "area", "objects": ["section", "section"], "keep": true }),
        &["twice"],
    );
    refused("section", json!({ "kind": "area", "holes": ["section"], "keep": true }), &["hole in itself"]);
    refused("section", json!({ "kind": "area", "objects": [], "keep": true }), &["at least one"]);
    refused("section", json!({ "kind": "area", "objects": [1], "keep": true }), &["objects[0]", "name"]);
    refused("section", json!({ "kind": "area", "objects": ["keel"], "keep": true }), &["objects[0]", "keel"]);
    refused("section", json!({ "kind": "length", "to": 0 }), &["\"section\"", "more than 0"]);
}
