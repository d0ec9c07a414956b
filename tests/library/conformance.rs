//! Everything that is registered passes the kernel's suites; what is new and has no sample here fails.

use loftsman::kernel::Point;
use loftsman::kernel::conformance::{
    format_conformance, operation_conformance, sample_scene, solver_conformance,
};
use loftsman::kernel::mesh::Polyline;
use loftsman::kernel::plugin::Parameters;
use loftsman::kernel::scene::{Geometry, Object, Scene};
use serde_json::json;

#[test]
fn every_format() {
    let formats = loftsman::registry().formats();
    assert!(formats.len() >= 4);
    for format in formats {
        // A scene of what the format can hold, and one of everything.
        let mut clouds = Scene::new();
        for object in sample_scene().objects() {
            if matches!(object.geometry, Geometry::Cloud(_) | Geometry::Polyline(_)) {
                let mut object = object.clone();
                object.parent = None;
                clouds.add(object).unwrap();
            }
        }
        for scene in [clouds, sample_scene()] {
            let verdict = format_conformance(format.as_ref(), &scene);
            assert!(verdict.passed(), "{}: {verdict}", format.declaration().name);
        }
    }
}

#[test]
fn every_solver() {
    let solvers = loftsman::registry().solvers();
    assert!(solvers.len() >= 6);
    for solver in solvers {
        let verdict = solver_conformance(solver.as_ref());
        assert!(verdict.passed(), "{}: {verdict}", solver.name());
    }
}

#[test]
fn every_operation() {
    let registry = loftsman::registry();
    let curve = "clamped curve";
    for operation in registry.operations() {
        let name = operation.declaration().name;
        let position = json!({ "kind": "position", "at": 1.2, "by": [0.0, 1.0, 0.0] });
        let parameters = match name {
            "edit" => json!({ "object": curve, "constraints": [position], "metric": "bend", "lock": [0] }),
            "drag" => {
                let handle = json!({ "kind": "position", "at": 1.2 });
                json!({ "object": curve, "handle": handle, "path": [[1, 2, 3], [2, 3, 4]], "frames": true })
            }
            "fair" => json!({ "object": curve, "energy": "bend", "constraints": [position], "lock": [0] }),
            "refine" => json!({ "object": curve, "knots": [0.2, 0.7, 0.7] }),
            "elevate" => json!({ "object": "patch", "by": 2 }),
            "reverse" => json!({ "object": "rational" }),
            "split" => json!({ "object": "patch", "at": 1.0, "direction": "v" }),
            "untrim" => json!({ "object": "window" }),
            "transform" => json!({ "object": "mesh", "scale": [1, -2, 1], "translate": [1, 0, 0] }),
            "tessellate" => json!({ "object": "patch", "tolerance": 20.0, "angle": 170 }),
            "copy" => json!({ "object": "rational", "to": ["once", "twice"] }),
            "delete" => json!({ "object": "group" }),
            "rename" => json!({ "object": "group", "to": "all" }),
            "fill" => json!({ "objects": ["square"], "size": 0.5 }),
            "extrude" => json!({ "objects": ["square"], "by": [0, 0, 2], "surfaces": true }),
            "loft" => json!({ "sections": ["square", "lid"], "surface": true }),
            "fit" => json!({ "object": "chain", "degree": 2, "vertices": 4 }),
            other => panic!("the operation \"{other}\" has no sample: add one"),
        };
        let parameters = Parameters::new(parameters, "step[0]").unwrap();
        let verdict = operation_conformance(operation.as_ref(), &with_squares(), &parameters, registry);
        assert!(verdict.passed(), "{name}: {verdict}");
    }
}

/// The sample scene, and two planar outlines above one another.
fn with_squares() -> Scene {
    let mut scene = sample_scene();
    for (name, z) in [("square", 0.0), ("lid", 2.0)] {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let points = corners.iter().map(|c| Point::new(c[0], c[1], z)).collect();
        scene.add(Object::new(name, Polyline { points, closed: true }.into())).unwrap();
    }
    scene
}
