//! The operations as recipes run them.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic, reason = "tests")]

use loftsman_editing::Editing;
use loftsman_kernel::plugin::{Context, OperationError, Parameters, Registry, StepReport};
use loftsman_kernel::scene::{Animation, Geometry, Object, Scene};
use loftsman_kernel::spline::trimmed::{ParameterCurve, Region};
use loftsman_kernel::spline::{Curve, Space, Surface, Trimmed};
use loftsman_kernel::{Point, Vector};
use serde_json::{Value, json};

fn registry() -> Registry {
    let mut registry = Registry::new();
    registry.add(&Editing);
    registry
}

fn curve() -> Curve {
    let points = (0..12).map(|i| Point::new(f64::from(i), (f64::from(i) * 0.9).sin(), 0.0)).collect();
    Curve::new(Space::clamped_uniform(3, 12).unwrap(), points).unwrap()
}

fn scene() -> Scene {
    let mut scene = Scene::new();
    scene.add(Object::new("section", curve().into())).unwrap();
    scene
}

fn run(scene: &mut Scene, op: &str, parameters: Value) -> Result<StepReport, OperationError> {
    let registry = registry();
    let operation = registry.find_operation(op, "step[0].op")?.clone();
    let parameters = Parameters::new(parameters, "step[0]")?;
    parameters.check(operation.declaration().fields)?;
    operation.apply(scene, &parameters, &Context::quiet(&registry))
}

fn fails(op: &str, parameters: Value) -> String {
    let mut scene = scene();
    let before = scene.clone();
    let message = run(&mut scene, op, parameters).unwrap_err().to_string();
    assert_eq!(scene, before, "a failed step must leave the scene alone");
    message
}

/// A surface of which a round window is left.
fn window() -> Trimmed {
    let space = || Space::clamped(2, &[0.0, 0.5, 1.0]).unwrap();
    let net = (0..16).map(|k| Point::new(f64::from(k / 4), f64::from(k % 4), 0.0)).collect();
    let surface = Surface::new(space(), space(), net).unwrap();
    let ring = Curve::circle(Point::new(0.5, 0.5, 0.0), Vector::z(), 0.3).unwrap();
    let region = Region { outer: vec![ParameterCurve::whole(ring).unwrap()], holes: vec![] };
    Trimmed::new(surface, vec![region], vec![], vec![[0.5, 0.5]]).unwrap()
}

/// What is asked at a place that the loops cut away holds on the surface that carries them, where nobody sees it: it is said how far off. On their border it is
/// seen.
#[test]
fn places_that_loops_cut_away_are_warned_of() {
    for (at, away) in [([0.5, 0.5], false), ([0.2, 0.5], false), ([0.0, 0.0], true), ([0.5, 0.19], true)] {
        for op in ["edit", "drag"] {
            let mut scene = Scene::new();
            scene.add(Object::new("window", window().into())).unwrap();
            let asked = json!([{ "kind": "position", "at": at, "keep": true }]);
            let moved = json!({ "kind": "position", "at": [0.4, 0.6], "by": [0.0, 0.0, 1.0] });
            let report = match op {
                "edit" => run(&mut scene, op, json!({ "constraints": [asked[0], moved] })),
                _ => run(
                    &mut scene,
                    op,
                    json!({ "constraints": asked, "handle": { "kind": "position", "at": [0.4, 0.6] }, "path": [[1.0, 2.0, 1.0]] }),
                ),
            };
            let warnings = report.unwrap().warnings;
            assert_eq!(warnings.iter().any(|w| w.contains("cut away")), away, "{op} {at:?}: {warnings:?}");
            assert_eq!(warnings.len(), usize::from(away), "{warnings:?}");
        }
    }
}

/// What cannot be done to a shape is said before its fields: a place of a surface, as { closest } gives it, is no number for `split`, which is not the point.
#[test]
fn what_a_trimmed_surface_needs_is_said_first() {
    let window = window();
    for (op, fields) in [
        ("split", json!({ "object": "window", "at": [0.3, 0.7] })),
        ("refine", json!({ "object": "window", "knots": [[0.3, 0.7]] })),
        ("elevate", json!({ "object": "window" })),
        ("reverse", json!({ "object": "window" })),
        ("simplify", json!({ "object": "window" })),
    ] {
        let mut scene = scene();
        scene.add(Object::new("window", window.clone().into())).unwrap();
        let told = run(&mut scene, op, fields).unwrap_err().to_string();
        assert!(told.contains("untrim"), "{op}: {told}");
    }
}

#[test]
fn an_edit_reports_and_marks() {
    let mut scene = scene();
    let report = run(
        &mut scene,
        "edit",
        json!({ "object": "section", "lock": [0, -1], "constraints": [
            { "kind": "position", "at": 4.5, "by": [0.0, 0.2, 0.0] },
            { "kind": "tangent", "at": 4.5, "keep": true },
            { "kind": "curvature", "at": 7.0, "scale": 2.0 } ] }),
    )
    .unwrap();
    assert_eq!((report.equations, report.rank), (Some(13), Some(13)));
    assert!(report.residual.unwrap() < 1e-13 && report.marks.len() == 5);
    let moved = scene.curve("section").unwrap();
    assert!((moved.point(4.5).unwrap() - curve().point(4.5).unwrap() - Vector::y() * 0.2).norm() < 1e-13);
}

#[test]
fn a_trimmed_surface_is_edited_and_keeps_its_loops() {
    let trimmed = window();
    let mut scene = Scene::new();
    scene.add(Object::new("window", trimmed.clone().into())).unwrap();
    let asked = json!([{ "kind": "position", "at": [0.5, 0.5], "by": [0.0, 0.0, 1.0] }]);
    run(&mut scene, "edit", json!({ "constraints": asked })).unwrap();
    let Geometry::Trimmed(now) = scene.object("window").unwrap().geometry() else { panic!("it was trimmed") };
    assert_eq!((now.regions(), now.points()), (trimmed.regions(), trimmed.points()));
    let lift = now.surface().point(0.5, 0.5).unwrap() - trimmed.surface().point(0.5, 0.5).unwrap();
    assert!((lift - Vector::z()).norm() < 1e-14);
    // Its loops are its boundary: the edges of what carries it are not joined.
    let joined = json!([{ "kind": "join", "at": "u0", "with": { "object": "window", "at": "u1" } }]);
    let refused = run(&mut scene, "edit", json!({ "constraints": joined })).unwrap_err().to_string();
    assert!(refused.contains("loops"), "{refused}");
}

#[test]
fn what_was_smooth_stays_smooth_unless_it_is_let_go() {
    let circle = Curve::circle(Point::origin(), Vector::z(), 2.0).unwrap();
    let knot = circle.space().breakpoints()[1];
    let edit = |smooth: Value| {
        let mut scene = Scene::new();
        scene.add(Object::new("other", curve().into())).unwrap();
        scene.add(Object::new("ring", circle.clone().into())).unwrap();
        let asked = json!([{ "kind": "position", "at": knot, "by": [0.0, 0.0, 0.7] },
            { "kind": "vertex", "object": "other", "index": 0, "keep": true }]);
        let mut step = json!({ "object": "ring", "constraints": asked });
        if !smooth.is_null() {
            step["smooth"] = smooth;
        }
        run(&mut scene, "edit", step)
    };
    let kept = edit(Value::Null).unwrap();
    assert_eq!(kept.smooth.as_ref().map(|s| (s.knots, s.equations)), Some((4, 15)), "{kept:?}");
    assert_eq!((kept.constraints.len(), kept.notes.len()), (2, 0));
    let torn = edit(json!(0)).unwrap();
    assert_eq!(torn.smooth.as_ref().map(|s| (s.knots, s.corners.len())), Some((0, 1)), "{torn:?}");
    assert!(
        torn.notes[0].starts_with("a corner of ") && torn.notes[0].ends_with(" (was 0°)"),
        "{:?}",
        torn.notes
    );
    assert!(edit(json!(3)).unwrap_err().to_string().contains("3 is not 0, 1 or 2"));
    // A conflict calls the object by its name, where it is not the step's own.
    let mut scene = Scene::new();
    scene.add(Object::new("other", curve().into())).unwrap();
    scene.add(Object::new("ring", circle.clone().into())).unwrap();
    let on = |index: i64, by: f64| json!({ "kind": "vertex", "object": "ring", "index": index, "by": [by, 0.0, 0.0] });
    let step = json!({ "object": "other", "constraints": [on(1, 0.0), on(2, 0.5), on(3, 0.0)] });
    let text = run(&mut scene, "edit", step).unwrap_err().to_string();
    assert!(
        text.contains(&format!("smooth knot at {knot} of \"ring\"")) && text.contains("smooth = 0"),
        "{text}"
    );
}

#[test]
fn bounds_hold_and_contradictions_are_named() {
    let bound = |at: f64, word: &str, y: f64| json!({ "kind": "position", "at": at, word: y, "axis": "y" });
    let mut constraints: Vec<Value> =
        (0..=18).map(|k| bound(0.5 * f64::from(k), "at_least", -0.25)).collect();
    constraints.push(json!({ "kind": "position", "at": 4.5, "by": [0.0, 1.0, 0.0] }));
    constraints.push(json!({ "kind": "signed-curvature", "at": 2.0, "at_most": 0.5 }));
    let mut scene = scene();
    let report = run(&mut scene, "edit", json!({ "object": "section", "constraints": constraints })).unwrap();
    let moved = scene.curve("section").unwrap();
    for k in 0..=18 {
        assert!(moved.point(0.5 * f64::from(k)).unwrap().y >= -0.25 - 1e-12);
    }
    assert!(!report.active.is_empty() && report.active.iter().all(|name| name.contains('≥')), "{report:?}");
    assert!(report.convergence.is_some_and(|c| c.change < 1e-7) && report.residual.unwrap() < 1e-11);
    let path = json!([[4.0, 0.0, 0.0], [4.0, 2.0, 0.0]]);
    let handle = json!({ "kind": "position", "at": 4.5 });
    let drag = json!({ "handle": handle, "path": path, "constraints": [bound(5.5, "at_most", 0.5)] });
    assert_eq!(run(&mut scene, "drag", drag).unwrap().active.len(), 1);
    assert!(scene.curve("section").unwrap().point(5.5).unwrap().y <= 0.5 + 1e-12);
    let both = json!([bound(3.0, "at_least", 1.0), bound(3.0, "at_most", 0.0), bound(7.0, "at_most", 3.0)]);
    let message = fails("edit", json!({ "constraints": both }));
    assert!(
        message.contains("y of position at 3 ≥ 1\", \"y of position at 3 ≤ 0\" cannot all hold"),
        "{message}"
    );
}

#[test]
fn every_mistake_has_its_message() {
    let edit = |constraint: Value| fails("edit", json!({ "constraints": [constraint] }));
    let at = "step[0].constraints[0]";
    for (constraint, parts) in [
        (json!({ "kind": "positon", "at": 1.0, "keep": true }), vec![at, "did you mean \"position\"?"]),
        (json!({ "kind": "position", "at": 1.0, "kep": true }), vec![at, "did you mean \"keep\"?"]),
        (json!({ "kind": "position", "at": 1.0 }), vec![at, "says nothing"]),
        (
            json!({ "kind": "position", "at": 1.0, "to": [0, 0, 0], "by": [0, 0, 0] }),
            vec!["\"to\" and \"by\""],
        ),
        (json!({ "kind": "position", "at": 10.0, "keep": true }), vec!["10 is outside the domain [0, 9]"]),
        (
            json!({ "kind": "position", "at": [1.0, 2.0], "keep": true }),
            vec!["[u, v] is a location on a surface"],
        ),
        (json!({ "kind": "position", "at": 1.0, "to": [0, 0] }), vec!["2 numbers", "3 are needed"]),
        (json!({ "kind": "position", "at": 1.0, "to": [0, "a", 0] }), vec!["to[1]", "\"a\""]),
        (json!({ "kind": "position", "at": 1.0, "at_least": [0, 0] }), vec!["2 numbers"]),
        (json!({ "kind": "position", "at": 1.0, "to": 2.0, "axis": "w" }), vec!["axis", "x, y, z"]),
        (json!({ "kind": "tangent", "at": 1.0, "keep": true, "axis": "x" }), vec!["no axes"]),
        (json!({ "kind": "tangent", "at": 1.0, "to": 0.5 }), vec!["holds or does not hold", "`direction`"]),
        (
            json!({ "kind": "tangent", "at": [1.0, 2.0], "keep": true }),
            vec!["asked of a curve", "location on a surface"],
        ),
        (
            json!({ "kind": "join", "at": "u0", "with": { "object": "section", "at": "u1" } }),
            vec!["no edges"],
        ),
        (
            json!({ "kind": "derivative", "at": 1.0, "order": 1_000_000_000, "keep": true }),
            vec!["1000000000"],
        ),
        (json!({ "kind": "vertex", "index": 12, "keep": true }), vec!["no control vertex 12"]),
        (
            json!({ "kind": "position", "at": 1.0, "object": "setcion", "keep": true }),
            vec!["did you mean \"section\"?"],
        ),
        (json!({ "kind": "tangent", "at": 1.0, "direction": [0, 0, 0] }), vec!["zero vector"]),
    ] {
        let message = edit(constraint.clone());
        for part in parts {
            assert!(message.contains(part), "{constraint}: {message}");
        }
    }
    assert!(fails("edit", json!({ "solver": "adjont" })).contains("did you mean \"adjoint\"?"));
    assert!(fails("edit", json!({ "object": "hull" })).contains("no object \"hull\""));
    assert!(fails("edit", json!({ "metric": "bent" })).contains("did you mean \"bend\"?"));
    assert!(fails("edt", json!({})).contains("did you mean \"edit\"?"));
    for nothing in [json!({}), json!({ "constraints": [] })] {
        assert!(fails("edit", nothing).contains("constraints: nothing is asked"));
    }
    assert!(fails("refine", json!({ "knots": [f64::MAX] })).contains("outside the domain"));
    assert!(fails("elevate", json!({ "by": 1_000_000_000 })).contains("degree"));
}

#[test]
fn a_hundred_thousand_constraints_on_twelve_vertices_are_refused_or_dropped() {
    let many: Vec<Value> = (0..100_000)
        .map(|i| json!({ "kind": "position", "at": 9.0 * f64::from(i) / 100_000.0, "keep": true }))
        .collect();
    let report = run(&mut scene(), "edit", json!({ "constraints": many })).unwrap();
    assert_eq!((report.equations, report.rank), (Some(300_000), Some(36)));
}

#[test]
fn a_drag_keeps_frames() {
    let mut scene = scene();
    let start = curve().point(4.0).unwrap();
    let path: Vec<_> = (1..=10).map(|i| json!([start.x, start.y + 0.1 * f64::from(i), 0.0])).collect();
    let report = run(
        &mut scene,
        "drag",
        json!({ "handle": { "kind": "position", "at": 4.0 }, "path": path, "frames": true,
                "constraints": [{ "kind": "position", "at": 0.0, "keep": true }] }),
    )
    .unwrap();
    assert!(report.residual.unwrap() < 1e-13);
    let animation = scene.object("section").unwrap().animation.clone().unwrap();
    assert_eq!(animation.frames.len(), 11);
    assert_eq!(animation.frames[0], curve().points());
    assert_eq!(animation.frames[10], scene.curve("section").unwrap().points());
    assert!(
        fails("drag", json!({ "handle": { "kind": "position", "at": 4.0 }, "path": [] })).contains("empty")
    );
    // The end-point convention: a pick near the start picks the start.
    let near =
        json!({ "handle": { "kind": "position", "at": 0.01, "pick": 0.2 }, "path": [[-1.0, 0.0, 0.0]] });
    run(&mut scene, "drag", near).unwrap();
    assert!(
        (scene.curve("section").unwrap().point(0.0).unwrap() - Point::new(-1.0, 0.0, 0.0)).norm() < 1e-13
    );
}

#[test]
fn two_curves_are_joined() {
    let mut scene = scene();
    let other = Curve::bezier(vec![
        Point::new(11.5, 0.5, 0.0),
        Point::new(12.0, 1.0, 0.0),
        Point::new(13.0, 1.0, 1.0),
        Point::new(14.0, 0.0, 1.0),
    ]);
    scene.add(Object::new("tail", other.unwrap().into())).unwrap();
    for continuity in 0..=2 {
        let join = json!({ "kind": "join", "at": 9.0, "with": { "object": "tail", "at": 0.0 }, "continuity": continuity });
        run(&mut scene, "edit", json!({ "object": "section", "constraints": [join] })).unwrap();
        for order in 0..=continuity {
            let a = scene.curve("section").unwrap().derivative(9.0, order).unwrap();
            let b = scene.curve("tail").unwrap().derivative(0.0, order).unwrap();
            assert!((a - b).norm() < 1e-11, "order {order}: {a} {b}");
        }
    }
}

#[test]
fn surface_edges_are_joined() {
    let patch = |x: f64, reversed: bool| {
        let space = Space::clamped_uniform(3, 6).unwrap();
        let points = (0..36)
            .map(|k| {
                let j = if reversed { 5 - k % 6 } else { k % 6 };
                Point::new(x + f64::from(k / 6), f64::from(j), (f64::from(k) * 0.7).sin() * 0.3)
            })
            .collect();
        Surface::new(space.clone(), space, points).unwrap()
    };
    for reversed in [false, true] {
        let mut scene = Scene::new();
        scene.add(Object::new("a", patch(0.0, false).into())).unwrap();
        scene.add(Object::new("b", patch(5.2, reversed).into())).unwrap();
        let join =
            json!({ "kind": "join", "at": "u1", "with": { "object": "b", "at": "u0" }, "continuity": 1 });
        run(&mut scene, "edit", json!({ "object": "a", "constraints": [join] })).unwrap();
        let (a, b) = (scene.surface("a").unwrap(), scene.surface("b").unwrap());
        for i in 0..=30 {
            let v = 3.0 * f64::from(i) / 30.0;
            let w = if reversed { 3.0 - v } else { v };
            for order in 0..=1 {
                let gap = a.derivative(3.0, v, order, 0).unwrap() - b.derivative(0.0, w, order, 0).unwrap();
                assert!(gap.norm() < 1e-11, "order {order} at {v}: {gap}");
            }
        }
    }
}

#[test]
fn edges_with_unlike_weights_are_refused_unless_there_is_a_tolerance() {
    let patch = |x: f64, weight: fn(i32) -> f64| {
        let space = Space::clamped_uniform(3, 6).unwrap();
        let points = (0..36)
            .map(|k| Point::new(x + f64::from(k / 6), f64::from(k % 6), (f64::from(k) * 0.7).sin() * 0.3))
            .collect();
        Surface::rational(space.clone(), space, points, (0..36).map(weight).collect()).unwrap()
    };
    let scene = || {
        let mut scene = Scene::new();
        scene.add(Object::new("a", patch(0.0, |k| 1.0 + 0.1 * f64::from(k % 5)).into())).unwrap();
        scene.add(Object::new("b", patch(5.2, |k| 1.0 + 0.1 * f64::from(k % 7)).into())).unwrap();
        scene
    };
    let fields = |tolerance: Option<f64>| {
        let mut join = json!({ "kind": "join", "at": "u1", "with": { "object": "b", "at": "u0" } });
        if let Some(tolerance) = tolerance {
            join["tolerance"] = json!(tolerance);
        }
        json!({ "object": "a", "constraints": [join] })
    };
    let why = |tolerance| run(&mut scene(), "edit", fields(tolerance)).unwrap_err().to_string();
    assert!(
        why(None).contains("C0 join at u1 with u0 of \"b\": the weights of the edges are unlike"),
        "{}",
        why(None)
    );
    assert!(why(Some(-1.0)).contains("tolerance: -1 is not a length"), "{}", why(Some(-1.0)));
    let mut near = scene();
    run(&mut near, "edit", fields(Some(0.1))).unwrap();
    let (a, b) = (near.surface("a").unwrap(), near.surface("b").unwrap());
    for i in 0..=30 {
        let v = 3.0 * f64::from(i) / 30.0;
        assert!((a.point(3.0, v).unwrap() - b.point(0.0, v).unwrap()).norm() < 0.1);
    }
}

#[test]
fn a_relative_drag_starts_where_the_handle_is() {
    let drag = |relative: bool, to: [f64; 3]| {
        let mut scene = scene();
        let handle = json!({ "kind": "derivative", "at": 4.0, "order": 2 });
        let fields = json!({ "handle": handle, "path": [to], "relative": relative });
        run(&mut scene, "drag", fields).unwrap();
        scene.curve("section").unwrap().derivative(4.0, 2).unwrap()
    };
    let start = curve().derivative(4.0, 2).unwrap();
    assert!((drag(false, [1.0, 2.0, 0.0]) - Vector::new(1.0, 2.0, 0.0)).norm() < 1e-12);
    assert!((drag(true, [1.0, 2.0, 0.0]) - start - Vector::new(1.0, 2.0, 0.0)).norm() < 1e-12);
}

#[test]
fn copies_are_the_same_under_other_names() {
    let mut scene = scene();
    run(&mut scene, "copy", json!({ "object": "section", "to": ["once", "twice"] })).unwrap();
    let names: Vec<&str> = scene.objects().iter().map(|o| o.name()).collect();
    assert_eq!(names, ["section", "once", "twice"]);
    assert_eq!(scene.objects()[2], scene.objects()[0].renamed("twice"));
    let before = scene.clone();
    let taken = json!({ "object": "section", "to": ["thrice", "once"] });
    assert!(run(&mut scene, "copy", taken).unwrap_err().to_string().contains("once"));
    assert_eq!(scene, before, "a copy that fails leaves nothing behind");
    assert!(fails("copy", json!({ "object": "section", "to": [3] })).contains("name"));
}

#[test]
fn splits_reversals_and_transforms() {
    let mut scene = scene();
    run(&mut scene, "split", json!({ "at": 4.0 })).unwrap();
    assert_eq!(scene.objects().len(), 2);
    run(&mut scene, "reverse", json!({ "object": "section.001" })).unwrap();
    run(&mut scene, "refine", json!({ "object": "section", "knots": [0.5, 0.5] })).unwrap();
    run(&mut scene, "elevate", json!({ "object": "section" })).unwrap();
    let rotate = json!({ "axis": [0, 0, 1], "degrees": 90 });
    run(&mut scene, "transform", json!({ "object": "section", "rotate": rotate, "translate": [1, 0, 0] }))
        .unwrap();
    let (old, new) = (curve().point(2.0).unwrap(), scene.curve("section").unwrap().point(2.0).unwrap());
    assert!((new - Point::new(1.0 - old.y, old.x, 0.0)).norm() < 1e-13);
    run(&mut scene, "rename", json!({ "object": "section", "to": "left" })).unwrap();
    run(&mut scene, "delete", json!({ "object": "left" })).unwrap();
    assert!(matches!(scene.objects()[0].geometry(), Geometry::Curve(_)));
    assert!(fails("transform", json!({ "matrix": [[1, 0, 0, 0]] })).contains("4 rows"));
}

/// The scene with three frames on its curve: the curve itself, and two others on the same knots.
fn animated() -> Scene {
    let mut scene = scene();
    let frame = |by: f64| curve().points().iter().map(|p| p + Vector::y() * (by * p.x)).collect();
    let animation = Animation { rate: 24.0, frames: vec![frame(0.0), frame(0.1), frame(0.3)] };
    scene.object_mut("section").unwrap().animation = Some(animation);
    scene
}

#[test]
fn what_keeps_the_shape_takes_its_frames_along() {
    let lifted = |frame: usize, p: Point| p + Vector::y() * ([0.0, 0.1, 0.3][frame] * p.x);
    for (op, fields, object, place) in [
        ("refine", json!({ "knots": [1.5, 1.5, 4.25] }), "section", (|u| u) as fn(f64) -> f64),
        ("elevate", json!({ "by": 2 }), "section", |u| u),
        ("simplify", json!({}), "section", |u| u),
        ("reverse", json!({}), "section", |u| 9.0 - u),
        ("split", json!({ "at": 4.5 }), "section", |u| u),
        ("split", json!({ "at": 4.5 }), "section.001", |u| u),
        ("copy", json!({ "object": "section", "to": "twin" }), "twin", |u| u),
        ("rename", json!({ "object": "section", "to": "other" }), "other", |u| u),
    ] {
        let mut scene = animated();
        if op == "simplify" {
            run(&mut scene, "refine", json!({ "knots": [2.5] })).unwrap();
        }
        run(&mut scene, op, fields).unwrap();
        let found = scene.object(object).unwrap();
        let animation = found.animation.as_ref().unwrap_or_else(|| panic!("{op} of {object}"));
        assert_eq!((animation.frames.len(), animation.rate), (3, 24.0), "{op}");
        assert!(animation.fits(found.geometry()) && animation.frames[0] == found.geometry().points(), "{op}");
        for (number, points) in animation.frames.iter().enumerate() {
            let Geometry::Curve(frame) = found.geometry().with_points(points.clone()).unwrap() else {
                panic!()
            };
            let (a, b) = frame.domain();
            for i in 0..=10 {
                let u = a + (b - a) * f64::from(i) / 10.0;
                let expected = lifted(number, curve().point(place(u)).unwrap());
                let apart = (frame.point(u).unwrap() - expected).norm();
                assert!(apart < 1e-12, "{op}, frame {number} at {u}: {apart}");
            }
        }
    }
}

#[test]
fn what_changes_the_shape_leaves_no_frames_of_the_old_one() {
    let by = json!([{ "kind": "position", "at": 4.5, "by": [0.0, 0.2, 0.0] }]);
    for (op, fields) in [
        ("edit", json!({ "constraints": by })),
        ("edit", json!({ "constraints": by, "within": [2.0, 7.0] })),
        ("drag", json!({ "handle": { "kind": "position", "at": 4.5 }, "path": [[4.5, 2.0, 0.0]] })),
        ("simplify", json!({ "tolerance": 0.5 })),
    ] {
        let mut scene = animated();
        run(&mut scene, op, fields).unwrap();
        assert_eq!(scene.object("section").unwrap().animation, None, "{op}");
    }
    // Nothing asked that is not so: nothing has become of another shape.
    let mut scene = animated();
    let keep = json!([{ "kind": "position", "at": 4.5, "by": [0.0, 0.0, 0.0] }]);
    run(&mut scene, "edit", json!({ "constraints": keep })).unwrap();
    assert!(scene.object("section").unwrap().animation.is_some());
    // A knot that one frame needs stays in none: the frames go.
    let mut scene = animated();
    run(&mut scene, "refine", json!({ "knots": [2.5] })).unwrap();
    let object = scene.object_mut("section").unwrap();
    object.animation.as_mut().unwrap().frames[1][4].y += 1.0;
    run(&mut scene, "simplify", json!({})).unwrap();
    assert_eq!(scene.curve("section").unwrap().points().len(), 12);
    assert_eq!(scene.object("section").unwrap().animation, None);
}

#[test]
fn what_is_known_is_listed_once() {
    let message = fails(
        "edit",
        json!({ "constraints": [{ "kind": "normal", "at": [0.5, 0.5], "to": [0, 0, 1], "zzz": 1 }] }),
    );
    let (_, known) = message.split_once("known here: ").unwrap_or_else(|| panic!("{message}"));
    let mut names: Vec<&str> = known.split(", ").collect();
    let count = names.len();
    names.sort_unstable();
    names.dedup();
    assert!(names.contains(&"to") && names.len() == count && count > 5, "{message}");
}

/// What cannot be asked is an error of its own table, before anything is solved.
#[test]
fn what_cannot_be_asked_is_told_where_it_stands() {
    let fine = json!({ "kind": "position", "at": 4.5, "by": [0.0, 0.2, 0.0] });
    for (bad, words) in [
        (json!({ "kind": "position", "at": 99.0, "keep": true }), "99 is outside the domain [0, 9]"),
        (json!({ "kind": "vertex", "index": 40, "keep": true }), "no control vertex 40"),
        (json!({ "kind": "position", "at": [0.5, 0.5], "keep": true }), "location"),
    ] {
        let message = fails("edit", json!({ "constraints": [fine, bad] }));
        assert!(message.starts_with("step[0].constraints[1]: ") && message.contains(words), "{message}");
    }
}
