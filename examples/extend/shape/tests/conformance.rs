//! It is a kind of shape, and an object like any other: edited, written, read, drawn, used from a recipe.

#![allow(clippy::unwrap_used, reason = "a test may stop at what should not be")]

use std::sync::Arc;

use loftsman::describe::describe;
use loftsman::kernel::conformance::{format_conformance, kind_conformance, sample_scene, shape_conformance};
use loftsman::kernel::edit::{Ask, Edit};
use loftsman::kernel::functional::{Functional, Shapes, derivative, position};
use loftsman::kernel::plugin::{
    Chord, Context, DeclaredShape, Fate, Fineness, Memory, Parameters, ReadOptions, ReadReport, Registry,
    Splines, WriteOptions, WriteReport,
};
use loftsman::kernel::scene::{Animation, Geometry, Object, Scene, Unit, Up};
use loftsman::kernel::shape::{Derivative, Location, Shape};
use loftsman::kernel::spline::{Space, Surface};
use loftsman::kernel::{Point, Vector};
use loftsman::picture::Look;
use loftsman::recipe::{Recipe, Runner};
use loftsman_example_shape::{Coons, CoonsPlugin};
use serde_json::json;

/// A sail: a square whose edges bend up and down.
fn sail() -> Coons {
    let at = |x: f64, y: f64, z: f64| Point::new(x, y, z);
    Coons([
        at(0.0, 0.0, 0.0),
        at(1.0, 0.1, 0.5),
        at(2.0, 0.0, 0.5),
        at(3.0, 0.0, 0.0),
        at(3.0, 1.0, -0.4),
        at(3.2, 2.0, -0.4),
        at(3.0, 3.0, 1.0 / 3.0),
        at(2.0, 3.0, 0.7),
        at(1.0, 3.0, 0.2),
        at(0.0, 3.0, 0.0),
        at(0.0, 2.0, 0.3),
        at(0.0, 1.0, 0.3),
    ])
}

fn registry() -> Registry {
    let mut registry = loftsman::registry().clone();
    registry.add(&CoonsPlugin);
    registry
}

fn scene() -> Scene {
    let mut scene = Scene::new();
    (scene.unit, scene.up) = (Unit::Millimetre, Up::Z);
    let mut object = Object::new("sail", sail().into());
    let moved = |k: f64| sail().control_vertices().iter().map(|p| p + up(k * p.x)).collect();
    object.animation =
        Some(Animation { rate: 24.0, frames: (0..3).map(|k| moved(f64::from(k) * 0.1)).collect() });
    scene.add(object).unwrap();
    scene
}

fn up(z: f64) -> Vector {
    Vector::new(0.0, 0.0, z)
}

/// Through a format, with the kind known or not.
fn through(scene: &Scene, name: &str, known: bool) -> (Scene, ReadReport, WriteReport, Memory) {
    let registry = registry();
    let format = registry.format_of(name).unwrap();
    let mut file = Memory::new(name, "");
    let fineness = Fineness { chord: Chord::Relative(1e-2), ..Fineness::default() };
    let tessellator = registry.tessellator();
    let options = WriteOptions { tessellator, fineness, ..WriteOptions::default() };
    let written = format.write(scene, &mut file, &options).unwrap();
    let kinds = if known { registry.shape_kinds() } else { &[] };
    let (read, report) = format.read(&file, &ReadOptions { kinds, ..ReadOptions::default() }).unwrap();
    assert!(report.adds_up());
    (read, report, written, file)
}

#[test]
fn it_conforms() {
    let registry = registry();
    let mut flat = sail();
    flat.control_vertices_mut().iter_mut().for_each(|p| p.z = -0.0);
    let kind = registry.find_shape("coons", "").unwrap();
    let verdict = kind_conformance(kind, &[sail().boxed(), flat.boxed()]);
    assert!(verdict.passed() && verdict.checks > 300, "{verdict}");
    let verdict = shape_conformance(&sail());
    assert!(verdict.passed() && verdict.checks > 100, "{verdict}");
}

/// Faired, joined to a B-spline surface along a whole edge, and with an area that is kept: each in a recipe.
#[test]
fn it_is_faired_joined_and_measured_like_any_surface() {
    let registry = registry();
    let apply = |scene: &mut Scene, op: &str, fields: serde_json::Value| {
        let fields = Parameters::new(fields, "step[0]").unwrap();
        registry.find_operation(op, "op").unwrap().apply(scene, &fields, &Context::quiet(&registry)).unwrap()
    };
    // The same surface as a spline tells what is right.
    let Some(Splines::Surfaces(splines)) = sail().splines() else { panic!("it is one surface") };
    let measured = |geometry: Geometry, kind: &str| {
        let mut scene = Scene::new();
        scene.add(Object::new("one", geometry)).unwrap();
        let constraints = json!([{ "kind": kind, "scale": 1.1 }]);
        apply(&mut scene, "edit", json!({ "object": "one", "constraints": constraints, "smooth": 0 }));
        let area = loftsman::area_volume::surface_area();
        let mut value = [0.0];
        let shape = scene.object("one").unwrap().geometry().shape().unwrap().boxed();
        area.value(&Shapes::one(shape.as_ref()), &mut value).unwrap();
        value[0]
    };
    let (own, theirs) =
        (measured(sail().into(), "surface-area"), measured(splines[0].clone().into(), "surface-area"));
    assert!((own - theirs).abs() < 1e-9 * theirs && own > 9.0, "{own} {theirs}");

    let mut scene = Scene::new();
    scene.add(Object::new("sail", sail().into())).unwrap();
    let lines = |s: f64| (0..4).map(move |k| Point::new(3.2 + s, f64::from(k), 0.2 * s));
    let space = |p: usize, n: usize| Space::clamped_uniform(p, n).unwrap();
    let net = (0..3).flat_map(|i| lines(f64::from(i))).collect();
    scene.add(Object::new("sheet", Surface::new(space(2, 3), space(3, 4), net).unwrap().into())).unwrap();
    let join =
        json!([{ "kind": "join", "at": "u1", "with": { "object": "sheet", "at": "u0" }, "continuity": 1 }]);
    apply(&mut scene, "edit", json!({ "object": "sail", "constraints": join }));
    let shape = |name: &str| scene.object(name).unwrap().geometry().shape().unwrap().boxed();
    let (sail, sheet) = (shape("sail"), shape("sheet"));
    for k in 0..=100 {
        let v = f64::from(k) / 100.0;
        let at = |shape: &dyn Shape, u: f64, order: usize| {
            shape.value((u, v).into(), Derivative { u: order, v: 0 }).unwrap()
        };
        let (a, b) = (at(sail.as_ref(), 1.0, 0), at(sheet.as_ref(), 0.0, 0));
        assert!((a - b).norm() < 1e-13, "{v}: {a} {b}");
        let (a, b) = (at(sail.as_ref(), 1.0, 1), at(sheet.as_ref(), 0.0, 1));
        assert!((a - b).norm() < 1e-12, "{v}: {a} {b}");
    }

    let fixed: Vec<_> = [[0, 0], [0, 1], [1, 0], [1, 1]]
        .map(|at| json!({ "kind": "position", "at": at, "keep": true }))
        .into_iter()
        .chain([json!({ "kind": "position", "at": [0.5, 0.5], "by": [0.0, 0.0, 0.3] })])
        .collect();
    let report =
        apply(&mut scene, "fair", json!({ "object": "sail", "energy": "bend", "constraints": fixed }));
    let [before, after] = report.energy.unwrap();
    assert!(after < before && report.residual.unwrap() < 1e-12, "{before} {after}");
}

/// Formats hold what they say of a scene with it.
#[test]
fn formats_conform_with_it() {
    let mut scene = sample_scene();
    scene.add(Object::new("sail", sail().into())).unwrap();
    let registry = registry();
    for format in registry.formats().iter().filter(|f| f.declaration().writes) {
        let verdict = format_conformance(format.as_ref(), &scene);
        assert!(verdict.passed(), "{}: {verdict}", format.declaration().name);
    }
}

#[test]
fn it_is_edited_like_any_shape() {
    let before = sail();
    let top = before.value(Location::Surface(0.4, 0.6), Derivative::POSITION).unwrap();
    let edited = Edit::new(&before)
        .ask(position((0.4, 0.6)).by([0.0, 0.0, 0.5]))
        .ask(position((0.0, 0.0)).keep())
        .ask(derivative((1.0, 1.0), [1, 1]).keep())
        .solve()
        .unwrap();
    assert!(edited.report().residual < 1e-12, "{}", edited.report());
    let after = edited.shape().value(Location::Surface(0.4, 0.6), Derivative::POSITION).unwrap();
    assert!((after - top - up(0.5)).norm() < 1e-12);
}

#[test]
fn the_native_document_keeps_it_to_the_last_bit() {
    let scene = scene();
    let (read, report, written, file) = through(&scene, "a.loft.json", true);
    assert_eq!(read, scene);
    assert!(report.notes.is_empty() && written.objects[0].fate == Fate::Kept, "{report:?}");
    assert_eq!(through(&read, "a.loft.json", true).3.bytes, file.bytes);
    assert_eq!(written.objects[0].form, "coons of 12 vertices");
}

#[test]
fn a_document_keeps_it_word_for_word_where_its_plug_in_is_not_here() {
    let file = through(&scene(), "a.loft.json", true).3;
    let (unknown, report, ..) = through(&scene(), "a.loft.json", false);
    assert!(
        report.notes.iter().any(|n| n.contains("\"coons\"") && n.contains("word for word")),
        "{report:?}"
    );
    // Written again it is the same document, and says so; with the plug-in it is the same scene.
    let (again, _, written, same) = through(&unknown, "a.loft.json", true);
    assert_eq!((again, same.bytes), (scene(), file.bytes));
    assert!(written.notes.iter().any(|n| n.contains("word for word")), "{written:?}");
    let facts = describe(&unknown);
    assert!(
        facts.objects[0].unknown && facts.objects[0].kind == "coons" && facts.objects[0].vertices.is_none()
    );
    // In other units it stays where it is.
    let metres = unknown.converted(Unit::Metre, Up::Y).unwrap().into_owned();
    let place = metres.object("sail").unwrap().transform.unwrap();
    assert_eq!((place[(0, 0)], place[(1, 2)], place[(2, 1)]), (1e-3, 1e-3, -1e-3));
    // Nothing that needs its shape is done, and nothing is lost in silence.
    let registry = registry();
    for (op, fields) in [
        (
            "edit",
            json!({ "object": "sail", "constraints": [{ "kind": "position", "at": [0.5, 0.5], "keep": true }] }),
        ),
        ("fair", json!({ "object": "sail" })),
        ("transform", json!({ "object": "sail", "translate": [1, 0, 0] })),
        ("tessellate", json!({ "object": "sail" })),
        ("elevate", json!({ "object": "sail" })),
    ] {
        let mut copy = unknown.clone();
        let operation = Arc::clone(registry.find_operation(op, "op").unwrap());
        let fields = Parameters::new(fields, "step[0]").unwrap();
        let error = operation.apply(&mut copy, &fields, &Context::quiet(&registry)).unwrap_err().to_string();
        assert!(error.contains("coons") && copy == unknown, "{op}: {error}");
        assert!(op == "elevate" || error.contains("plug-in is not here"), "{op}: {error}");
    }
    for name in ["a.obj", "a.glb"] {
        let mut file = Memory::new(name, "");
        let written =
            registry.format_of(name).unwrap().write(&unknown, &mut file, &WriteOptions::default()).unwrap();
        let object = &written.objects[0];
        assert_eq!(object.fate, Fate::LeftOut);
        assert!(object.reason.as_ref().is_some_and(|r| r.contains("plug-in is not here")), "{object:?}");
    }
    let svg = Look::default().picture(&unknown, None, &[]).to_svg().unwrap();
    assert!(svg.contains("not drawn"));
}

#[test]
fn what_is_wrong_in_a_document_has_its_place() {
    let registry = registry();
    let format = registry.format_of("a.loft.json").unwrap();
    let points = |last: &str| format!("[{}{last}]", "[0, 1, 2], ".repeat(11));
    let good = points("[1, 2, 3]");
    for (shape, place, words) in [
        (
            format!(r#"{{ "kind": "coons", "points": {} }}"#, points("[1, 2]")),
            "shape.points[11]",
            "[x, y, z]",
        ),
        (r#"{ "kind": "coons", "points": [] }"#.to_owned(), "shape.points", "0 points where 12"),
        (r#"{ "kind": "coons" }"#.to_owned(), "shape", "\"points\" is missing"),
        (format!(r#"{{ "kind": "coons", "pionts": {good} }}"#), "shape", "did you mean \"points\""),
        (format!(r#"{{ "kind": "coons", "points": {good}, "points": {good} }}"#), "shape", "twice"),
        (format!(r#"{{ "points": {good} }}"#), "shape", "needs the field \"kind\""),
        (r#"{ "kind": 3 }"#.to_owned(), "shape.kind", "name of a kind"),
        (r#"{ "kind": "coons", "points": [[1e999, 0, 0]] }"#.to_owned(), "shape.points", "too large"),
        ("[]".to_owned(), "shape", "a table of its \"kind\""),
    ] {
        let text = format!(r#"{{ "loftsman": 1, "objects": [{{ "name": "a", "shape": {shape} }}] }}"#);
        let options = ReadOptions { kinds: registry.shape_kinds(), ..ReadOptions::default() };
        let error = format.read(&Memory::new("a.loft.json", text), &options).unwrap_err();
        let told = error.to_string();
        assert!(told.contains(&format!("objects[0].{place}")) && told.contains(words), "{told}");
        assert_eq!(error.object.as_deref(), Some("a"));
    }
}

#[test]
fn gltf_shows_triangles_and_brings_it_back() {
    let scene = scene();
    let (read, report, written, _) = through(&scene, "a.glb", true);
    assert_eq!(read.object("sail").unwrap(), scene.object("sail").unwrap(), "{report:?}");
    let object = &written.objects[0];
    assert_eq!(object.fate, Fate::Approximated);
    let reason = object.reason.as_deref().unwrap();
    assert!(reason.contains("coons became triangles") && reason.contains("not certified"), "{object:?}");
    assert!(object.error.is_none() && object.tolerance.is_some());
    // Without the plug-in it is the mesh, in as many frames, and the report says so.
    let (mesh, report, ..) = through(&scene, "a.glb", false);
    let object = mesh.object("sail").unwrap();
    assert!(matches!(object.geometry(), Geometry::Mesh(_)));
    assert_eq!(object.animation.as_ref().map(|a| a.frames.len()), Some(3));
    assert!(
        report.left_out.keys().any(|r| r.contains("\"coons\"") && r.contains("mesh is taken")),
        "{report:?}"
    );
}

#[test]
fn obj_has_the_surface_that_it_is_beside_triangles() {
    let (read, _, written, _) = through(&scene(), "a.obj", true);
    let kinds: Vec<&str> = read.objects().iter().map(|o| o.geometry().kind()).collect();
    assert!(kinds.contains(&"mesh") && kinds.contains(&"surface"), "{kinds:?}");
    let object = &written.objects[0];
    assert!(object.form.contains("1 NURBS surface (surf) beside") && object.fate == Fate::Approximated);
    let surface = read.objects().iter().find_map(|o| o.geometry().shape().ok()).unwrap();
    for at in [(0.0, 0.0), (0.3, 0.8), (1.0, 0.5)] {
        let value = |shape: &dyn Shape| shape.value(at.into(), Derivative::POSITION).unwrap();
        let (found, own) = (value(surface), value(&sail()));
        // y is up in OBJ.
        assert!((found - Vector::new(own.x, own.z, -own.y)).norm() < 1e-12);
    }
}

#[test]
fn a_recipe_edits_drags_and_draws_it() {
    let folder = tempfile::tempdir().unwrap();
    let registry = registry();
    let mut start = scene();
    start.object_mut("sail").unwrap().animation = None;
    let path = |name: &str| folder.path().join(name);
    loftsman::file::write_with(&start, path("sail.loft.json"), &WriteOptions::default(), &registry).unwrap();
    std::fs::copy(concat!(env!("CARGO_MANIFEST_DIR"), "/sail.toml"), path("sail.toml")).unwrap();
    let recipe = Recipe::read(path("sail.toml")).unwrap();
    let report = Runner::new(&registry).run(&recipe).unwrap();
    assert!(report.steps.iter().all(|step| step.residual.is_none_or(|r| r < 1e-10)), "{report:?}");
    let (edited, _) =
        loftsman::file::read_with(path("raised.loft.json"), &ReadOptions::default(), &registry).unwrap();
    let object = edited.object("sail").unwrap();
    assert_eq!(object.geometry().kind(), "coons");
    assert!(object.animation.as_ref().is_some_and(|a| a.frames.len() > 2 && a.frames[0].len() == 12));
    let value = object.geometry().shape().unwrap().value((0.5, 0.5).into(), Derivative::POSITION).unwrap();
    assert!((value.z - 2.0).abs() < 1e-9, "{value}");
    let svg = std::fs::read_to_string(path("raised.svg")).unwrap();
    assert!(svg.contains("control vertices") && svg.contains("class=\"shading\""));
    assert!(path("raised.glb").exists() && path("raised.obj").exists());
}
