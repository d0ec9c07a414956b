//! The operation `fine-tune` in recipes.

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail the test")]

use loftsman_area_volume::{AreaVolume, area_of};
use loftsman_fine_tuning::{FineTuning, surface_alpha_spaces};
use loftsman_kernel::mesh::{Cloud, Mesh, Polyline};
use loftsman_kernel::plugin::{Context, OperationError, Parameters, Registry, StepReport};
use loftsman_kernel::scene::{Geometry, Object, Scene};
use loftsman_kernel::spline::algebra::Function;
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};
use serde_json::{Value, json};

fn scene() -> Scene {
    let wave = (0..14).map(f64::from).map(|x| Point::new(x, (0.7 * x).sin(), 0.0)).collect();
    let ring = (0..12).map(|i| f64::from(i) / 12.0 * std::f64::consts::TAU);
    let ring = ring.map(|a| Point::new(3.0 * a.cos(), 2.0 * a.sin() + 0.4 * (2.0 * a).cos(), 0.0)).collect();
    let mut scene = Scene::new();
    let wave = Curve::new(Space::clamped_uniform(3, 14).unwrap(), wave).unwrap();
    let ring = Curve::new(Space::periodic_uniform(3, 12).unwrap(), ring).unwrap();
    scene.add(Object::new("wave", wave.into())).unwrap();
    scene.add(Object::new("ring", ring.into())).unwrap();
    scene.add(Object::new("scan", Geometry::Cloud(Cloud { points: vec![Point::origin()] }))).unwrap();
    scene
}

fn run(scene: &mut Scene, fields: Value) -> Result<StepReport, OperationError> {
    let mut registry = Registry::new();
    registry.add(&FineTuning);
    registry.add(&AreaVolume);
    loftsman_kernel::plugin::register_functionals(&mut registry);
    registry.solver(loftsman_kernel::solve::Automatic);
    let operation = registry.find_operation("fine-tune", "step[0]").unwrap();
    let parameters = Parameters::new(fields, "step[0]").unwrap();
    parameters.check(operation.declaration().fields).map_err(OperationError::from)?;
    operation.apply(scene, &parameters, &Context::quiet(&registry))
}

fn fails(fields: Value) -> String {
    let mut changed = scene();
    let error = run(&mut changed, fields).unwrap_err().to_string();
    assert_eq!(changed, scene(), "a failed step leaves the scene alone");
    error
}

#[test]
fn values_numbers_and_functions() {
    let mut scene = scene();
    let before = scene.curve("wave").unwrap().clone();
    let values: Vec<f64> = (0..13).map(|i| 1.0 + 0.5 * f64::from(i % 3)).collect();
    let report = run(&mut scene, json!({ "object": "wave", "alpha": values })).unwrap();
    let after = scene.curve("wave").unwrap();
    assert_eq!(after.degree(), 5);
    assert!((after.point(11.0).unwrap() - before.point(11.0).unwrap()).norm() < 1e-12);
    assert!(report.residual.unwrap() < 1e-12 && report.rank == Some(3), "{report:?}");
    assert!(report.active == ["alpha ≥ 0.001"] && report.notes.len() == 3, "{report:?}");
    assert!(report.notes[1].contains("kept at 0.001 near 11"), "{report:?}");
    assert_eq!(report.marks.len(), 2, "both ends: {:?}", report.marks);

    let mut scene = self::scene();
    let fields = json!({ "object": "wave", "alpha": 2.0, "ends": "free" });
    run(&mut scene, fields).unwrap();
    let after = scene.curve("wave").unwrap();
    let expected =
        before.point(0.0).unwrap() + (before.point(7.3).unwrap() - before.point(0.0).unwrap()) * 2.0;
    assert!((after.point(7.3).unwrap() - expected).norm() < 1e-12);

    let mut scene = self::scene();
    let alpha =
        json!({ "degree": 1, "knots": [2, 2, 3, 4, 5, 6, 7, 8, 8], "values": [1, 1, 0.5, 0.5, 1, 1, 1] });
    let fields = json!({ "object": "wave", "alpha": alpha, "range": [2, 8], "continuity": 1 });
    run(&mut scene, fields).unwrap();
    let after = scene.curve("wave").unwrap();
    assert!((after.point(1.5).unwrap() - before.point(1.5).unwrap()).norm() < 1e-13);
    assert!((after.derivative(8.0, 1).unwrap() - before.derivative(8.0, 1).unwrap()).norm() < 1e-11);
    assert!((after.point(5.0).unwrap() - before.point(5.0).unwrap()).norm() > 1e-2);
}

/// A loop stays closed, its area what it was, and its curvature at one place is divided by just what was asked, all in one step.
#[test]
fn area_kept_while_alpha_scales() {
    let mut scene = scene();
    let before = scene.curve("ring").unwrap().clone();
    let values: Vec<f64> = (0..12).map(|i| if i % 4 == 0 { 0.6 } else { 1.0 }).collect();
    let fields = json!({
        "object": "ring", "alpha": values, "alpha_at": [{ "at": 4.0, "to": 0.5 }],
        "constraints": [{ "kind": "area", "normal": [0, 0, 1], "keep": true }],
    });
    let report = run(&mut scene, fields).unwrap();
    let after = scene.curve("ring").unwrap();
    assert!(after.is_periodic());
    let (was, is) = (area_of(&before).unwrap(), area_of(after).unwrap());
    assert!((was - is).abs() < 1e-10 * was, "{was} {is} {report:?}");
    let curvature = |curve: &Curve| {
        let (first, second) = (curve.derivative(4.0, 1).unwrap(), curve.derivative(4.0, 2).unwrap());
        first.cross(&second).norm() / first.norm().powi(3)
    };
    assert!((curvature(after) - 2.0 * curvature(&before)).abs() < 1e-9);
    assert!((after.point(6.0).unwrap() - before.point(6.0).unwrap()).norm() > 1e-3);
}

/// The curvature at a place is what is asked of the curve as it was given, and so is the place; its derivative is what α scales.
#[test]
fn curvature_asked_while_alpha_scales() {
    let curvature = |curve: &Curve| {
        let (first, second) = (curve.derivative(4.0, 1).unwrap(), curve.derivative(4.0, 2).unwrap());
        first.cross(&second).norm() / first.norm().powi(3)
    };
    for name in ["ring", "wave"] {
        for (wanted, times) in
            [(json!({ "scale": 2.0 }), 2.0), (json!({ "keep": true }), 1.0), (json!({ "scale": 0.5 }), 0.5)]
        {
            let mut scene = scene();
            let before = scene.curve(name).unwrap().clone();
            let values: Vec<f64> = (0..before.space().len() - usize::from(name == "wave"))
                .map(|i| if i % 4 == 0 { 0.6 } else { 1.0 })
                .collect();
            let mut asked = json!({ "kind": "curvature", "at": 4.0 });
            asked.as_object_mut().unwrap().extend(wanted.as_object().unwrap().clone());
            let fields = json!({ "object": name, "alpha": values, "constraints": [asked] });
            let report = run(&mut scene, fields).unwrap();
            let after = scene.curve(name).unwrap();
            let case = format!("{name} {wanted}");
            assert!(
                (after.point(4.0).unwrap() - before.point(4.0).unwrap()).norm() < 1e-12,
                "{case}: {report:?}"
            );
            assert!(
                (curvature(after) - times * curvature(&before)).abs() < 1e-9,
                "{case}: {} {}",
                curvature(after),
                curvature(&before)
            );
            let slower = after.derivative(4.0, 1).unwrap() * times - before.derivative(4.0, 1).unwrap();
            assert!(slower.norm() < 1e-9, "{case}: the tangent does not turn, and is divided by as much");
            assert!((after.point(6.0).unwrap() - before.point(6.0).unwrap()).norm() > 1e-6, "{case}");
        }
    }
}

/// Where 1 is the α nearest to what is asked, that is said; where nothing is asked, nothing is undone.
#[test]
fn nothing_is_tuned() {
    let error = fails(json!({ "object": "ring", "alpha": 1.0, "range": [3, 3] }));
    assert!(error.contains("range"), "{error}");
    let space = Space::clamped_uniform(3, 9).unwrap();
    let line = (0..9).map(|i| Point::new(space.greville(i), 0.0, 0.0)).collect();
    let mut scene = Scene::new();
    let line = Curve::new(space, line).unwrap();
    scene.add(Object::new("line", line.into())).unwrap();
    let error = run(&mut scene, json!({ "object": "line", "alpha": 0.35 })).unwrap_err().to_string();
    assert!(error.contains("1 is the nearest") && error.contains("range"), "{error}");
    let report = run(&mut scene, json!({ "object": "line", "alpha": 1.0 })).unwrap();
    assert!(!report.notes.iter().any(|note| note.contains("undone")), "{report:?}");
}

/// The area of a loop is kept while a part of it is tuned; what is outside of the part stands still.
#[test]
fn area_kept_while_a_part_is_tuned() {
    let mut scene = scene();
    let before = scene.curve("ring").unwrap().clone();
    let alpha = json!({
        "degree": 2, "knots": [2, 2, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9], "values": [1, 1, 0.7, 0.7, 1.2, 1, 1, 1, 1],
    });
    let fields = json!({
        "object": "ring", "alpha": alpha, "range": [2, 9],
        "constraints": [{ "kind": "area", "normal": [0, 0, 1], "keep": true }],
    });
    let report = run(&mut scene, fields.clone()).unwrap();
    let after = scene.curve("ring").unwrap();
    let (was, is) = (area_of(&before).unwrap(), area_of(after).unwrap());
    assert!(after.is_periodic() && (was - is).abs() < 1e-10 * was, "{was} {is} {report:?}");
    assert!((after.point(10.5).unwrap() - before.point(10.5).unwrap()).norm() < 1e-13);
    assert!((after.point(5.0).unwrap() - before.point(5.0).unwrap()).norm() > 1e-3);
    let mut elsewhere = fields;
    elsewhere["constraints"] = json!([{ "kind": "position", "at": 11, "by": [0, 0.5, 0] }]);
    let error = fails(elsewhere);
    assert!(error.contains("position") && error.contains("11"), "{error}");
}

/// A number has no degree, a scene with one polyline one object, and a surface's α tables.
#[test]
fn what_needs_no_saying() {
    let mut scene = Scene::new();
    let points = (0..20).map(|i| Point::new(f64::from(i), f64::from(i * i % 5), 0.0)).collect();
    let high = Curve::new(Space::clamped_uniform(16, 20).unwrap(), points).unwrap();
    scene.add(Object::new("high", high.clone().into())).unwrap();
    run(&mut scene, json!({ "alpha": 2.0, "ends": "free" })).unwrap();
    let tuned = scene.curve("high").unwrap().clone();
    assert_eq!((tuned.degree(), tuned.points().len()), (16, 20));
    let off = tuned.point(3.0).unwrap()
        - (high.point(0.0).unwrap() + (high.point(3.0).unwrap() - high.point(0.0).unwrap()) * 2.0);
    assert!(off.norm() < 1e-10, "{off}");
    scene.replace("high", Geometry::from(high)).unwrap();
    let report = run(&mut scene, json!({ "alpha": 2.0 })).unwrap();
    assert!(scene.curve("high").unwrap().degree() <= 25 && report.residual.unwrap() < 1e-12);

    let mut scene = Scene::new();
    let line = Polyline {
        points: vec![Point::origin(), Point::new(1.0, 0.0, 0.0), Point::new(1.0, 2.0, 0.0)],
        closed: false,
    };
    scene.add(Object::new("line", line.into())).unwrap();
    run(&mut scene, json!({ "alpha": [{ "edge": [1, 2], "value": 1.5 }] })).unwrap();
    assert!(
        (scene.object("line").unwrap().geometry().points()[2] - Point::new(1.0, 3.0, 0.0)).norm() < 1e-12
    );
    let twice = json!({ "alpha": [{ "edge": [1, 2], "value": 1.5 }, { "edge": [2, 1], "value": 2 }] });
    let error = run(&mut scene, twice).unwrap_err().to_string();
    assert!(error.contains("step[0].alpha[1].edge") && error.contains("named before"), "{error}");

    let mut scene = Scene::new();
    let at = |k: i32| Point::new(f64::from(k / 5), f64::from(k % 5), f64::from(k * k % 7));
    let space = |n| Space::clamped_uniform(3, n).unwrap();
    let surface = Surface::new(space(7), space(5), (0..35).map(at).collect()).unwrap();
    scene.add(Object::new("sheet", surface.clone().into())).unwrap();
    let rows: Vec<Value> = (0..24).map(|_| json!([1, 1, 1])).collect();
    let knots: Vec<f64> =
        [0.0; 2].into_iter().chain((0..=22).map(|k| f64::from(k) * 4.0 / 22.0)).chain([4.0; 2]).collect();
    let table = json!({ "degree": [2, 2], "knots": [knots, [0, 0, 0, 2, 2, 2]], "values": rows });
    run(
        &mut scene,
        json!({ "alpha": table, "direction": "u", "alpha_at": [{ "at": [1.7, 0.6], "to": 0.5 }] }),
    )
    .unwrap();
    let Geometry::Surface(tuned) = scene.object("sheet").unwrap().geometry() else {
        unreachable!("a surface")
    };
    let wanted = surface.derivative(1.7, 0.6, 1, 0).unwrap() * 0.5;
    assert!((tuned.derivative(1.7, 0.6, 1, 0).unwrap() - wanted).norm() < 1e-11);
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    let error = fails(json!({ "object": "wave" }));
    assert!(error.contains("alpha"), "{error}");
    let error = fails(json!({ "alpha": 1.0 }));
    assert!(error.contains("object"), "{error}");
    let error = fails(json!({ "object": "scan", "alpha": 1.0 }));
    assert!(error.contains("step[0].object") && error.contains("curve"), "{error}");
    let error = fails(json!({ "object": "wave", "alpha": [1.0, 1.0] }));
    assert!(error.contains("step[0].alpha") && error.contains("2 values and needs 13"), "{error}");
    let error = fails(json!({ "object": "wave", "alpha": 0.0 }));
    assert!(error.contains("positive"), "{error}");
    let error =
        fails(json!({ "object": "wave", "alpha": { "degree": 2, "knots": [0, 1], "values": [1, 1] } }));
    assert!(error.contains("an open function has 5 knots"), "{error}");
    let error =
        fails(json!({ "object": "wave", "alpha": { "degree": 1, "knots": [0, 0, 1, 1], "values": [1, 1] } }));
    assert!(error.contains("[0, 1]") && error.contains("[0, 11]"), "{error}");
    let error = fails(json!({ "object": "wave", "alpha": 1.0, "alpha_at": [{ "at": 4.0, "to": -1.0 }] }));
    assert!(error.contains("step[0].alpha_at[0].to") && error.contains("-1 is not positive"), "{error}");
    let one = json!({ "degree": 0, "knots": [0, 11], "values": [1.3] });
    let error = fails(json!({ "object": "wave", "alpha": one }));
    assert!(error.contains("2 equations, and α has 1 value where it needs at least 3"), "{error}");
    let error = fails(json!({ "object": "wave", "alpha": 1.0, "ends": "exactly" }));
    assert!(error.contains("exact"), "{error}");
    let error = fails(json!({ "object": "wave", "alpha": 1.0, "continuity": 3 }));
    assert!(error.contains("0, 1 or 2"), "{error}");
    let error = fails(json!({ "object": "wave", "alpha": 1.0, "through": [{ "at": 1.0 }] }));
    assert!(error.contains("to"), "{error}");
    let error = fails(json!({ "object": "ring", "alpha": 1.1, "ends": "position" }));
    assert!(error.contains("exact"), "{error}");
    let error = fails(json!({ "object": "wave", "alpha": 1.1, "constraints": [
        { "kind": "join", "at": 0.0, "with": { "object": "ring", "at": 0.0 }, "keep": true }] }));
    assert!(error.contains("curve alone"), "{error}");
}

/// α of any size: ends are kept to its rounding, and huge ones are refused, for they would leave nothing else.
#[test]
fn alpha_of_any_size() {
    for alpha in [1e-300, 1e-12, 1e3, 1e9] {
        let mut scene = scene();
        let before = scene.curve("wave").unwrap().clone();
        run(&mut scene, json!({ "object": "wave", "alpha": alpha, "any_sign": true })).unwrap();
        let after = scene.curve("wave").unwrap();
        let off = (after.point(11.0).unwrap() - before.point(11.0).unwrap()).norm();
        assert!(off < 1e-14 * f64::max(alpha, 1.0) * 30.0, "{alpha}: {off:e}");
    }
    let error = fails(json!({ "object": "wave", "alpha": 1e300 }));
    assert!(error.contains("as large as 1e300") && error.contains("\"free\""), "{error}");
}

/// The edges of a polyline and of a mesh are springs.
#[test]
fn springs_in_recipes() {
    let points = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| Point::new(x, y, 0.0));
    let line = Polyline { points: points.to_vec(), closed: true };
    let square = Mesh::new(points.to_vec(), &[[0, 1, 2, 3]]).unwrap();
    let mut scene = Scene::new();
    scene.add(Object::new("line", line.into())).unwrap();
    scene.add(Object::new("square", square.into())).unwrap();
    for object in ["line", "square"] {
        let fields = json!({ "object": object, "alpha": [{ "edge": [1, 0], "value": 2.0 }], "lock": [-1] });
        let report = run(&mut scene, fields).unwrap();
        assert!(report.notes[0].starts_with("springs: the edges differ by"), "{report:?}");
        let after = scene.object(object).unwrap().geometry().points();
        assert!((after[1] - after[0] - Vector::new(1.75, 0.0, 0.0)).norm() < 1e-14);
        assert_eq!(after[3], points[3]);
    }
    let mut fails = |fields: Value| run(&mut scene, fields).unwrap_err().to_string();
    let error = fails(json!({ "object": "square", "alpha": [{ "edge": [0, 2], "value": 2.0 }] }));
    assert!(error.contains("step[0].alpha[0].edge") && error.contains("no edge"), "{error}");
    let error = fails(json!({ "object": "square", "alpha": 2.0, "ends": "free" }));
    assert!(error.contains("for curves"), "{error}");
    let error = fails(json!({ "object": "square", "alpha": -2.0 }));
    assert!(error.contains("-2"), "{error}");
    let error = fails(json!({ "object": "square", "alpha": 2.0, "lock": [9] }));
    assert!(error.contains('9'), "{error}");
}

/// What is held at places: a place that is none is named by its entry, and of too many values it is said how many α needs; where little is left of what was asked,
/// what that is.
#[test]
fn what_is_held_and_what_is_left_are_said() {
    let points: Vec<Point> = (0..8).map(f64::from).map(|t| Point::new(t, (1.3 * t).sin(), 0.0)).collect();
    let open = Curve::new(Space::clamped_uniform(3, 8).unwrap(), points).unwrap();
    let scene_of = |curve: &Curve| {
        let mut scene = Scene::new();
        scene.add(Object::new("c", curve.clone().into())).unwrap();
        scene
    };
    let tuned = |curve: &Curve, fields: Value| run(&mut scene_of(curve), fields);
    let places = |all: &[(f64, f64)]| -> Vec<Value> {
        all.iter().map(|(at, to)| json!({ "at": at, "to": to })).collect()
    };
    let error =
        tuned(&open, json!({ "alpha": 2, "alpha_at": places(&[(1.0, 2.0), (9.0, 1.0)]) })).unwrap_err();
    assert!(
        error.to_string().starts_with("step[0].alpha_at[1].at: 9 is outside the domain [0, 5]"),
        "{error}"
    );
    let error = tuned(&open, json!({ "alpha": 2, "through": [{ "at": 5.5, "to": [1, 1, 0] }] })).unwrap_err();
    assert!(error.to_string().starts_with("step[0].through[0].at: 5.5 is outside the domain"), "{error}");
    // Two equations for the end and one for each value: seven values of α meet five of them and no sixth.
    let at = |count: usize| -> Vec<(f64, f64)> {
        (0..count).map(|k| (0.5 + 0.75 * k as f64, 1.0 + 0.1 * (k % 3) as f64)).collect()
    };
    let alpha = json!([1, 2, 1, 2, 1, 2, 1]);
    let fields = |count: usize| json!({ "alpha": alpha, "any_sign": true, "alpha_at": places(&at(count)) });
    let report = tuned(&open, fields(5)).unwrap();
    let is_held = |note: &String| {
        note.starts_with("alpha is what was asked where it is held; elsewhere more than half")
    };
    assert!(report.notes.iter().any(is_held), "{report:?}");
    let error = tuned(&open, fields(6)).unwrap_err().to_string();
    assert!(
        error.contains("6 values of α: these are 8 equations, and α has 7 values where it needs at least 8"),
        "{error}"
    );
    // A closed curve of three values has one factor, which closes it.
    let ring = |k: usize| {
        let (sin, cos) = (std::f64::consts::TAU * k as f64 / 3.0).sin_cos();
        Point::new(cos, sin, 0.0)
    };
    let closed = Curve::new(Space::periodic_uniform(2, 3).unwrap(), (0..3).map(ring).collect()).unwrap();
    let report = tuned(&closed, json!({ "alpha": [1, 2, 1.2] })).unwrap();
    let is_factor =
        |note: &String| note.starts_with("of what was asked a factor of 1.4 is left and nothing else");
    assert!(report.notes.iter().any(is_factor), "{report:?}");
}

/// Surfaces: along one direction or both, parts, and what is missing is said.
#[test]
fn surfaces_in_recipes() {
    let space = Space::clamped_uniform(2, 6).unwrap();
    let at = |k: usize| ((k / 6) as f64, (k % 6) as f64);
    let points = (0..36).map(at).map(|(x, y)| Point::new(x, y, (0.6 * x).sin() + 0.1 * y * y)).collect();
    let sheet = Surface::new(space.clone(), space, points).unwrap();
    let mut scene = Scene::new();
    scene.add(Object::new("sheet", sheet.clone().into())).unwrap();
    let one = scene.clone();
    // An extrusion whose ends stay: little of a long stretch of 3 is left.
    let waves = (0..36).map(at).map(|(x, y)| Point::new(x, y, (0.6 * x).sin())).collect();
    let waves = Surface::new(sheet.u().clone(), sheet.v().clone(), waves).unwrap();
    let mut other = Scene::new();
    other.add(Object::new("waves", waves.into())).unwrap();
    let report = run(&mut other.clone(), json!({ "alpha_u": [1, 3, 3, 3, 1] })).unwrap();
    let is_undone = |note: &String| note.starts_with("along u, more than half of what was asked is undone");
    assert_eq!(report.notes.iter().filter(|note| is_undone(note)).count(), 1, "{report:?}");
    let report = run(&mut other, json!({ "alpha_u": [1, 3, 3, 3, 1], "ends": "free" })).unwrap();
    assert!(!report.notes.iter().any(is_undone), "{report:?}");
    let report = run(&mut scene, json!({ "alpha_u": [1, 2, 1, 1, 1], "ends": "free" })).unwrap();
    assert!(report.notes[0].contains("2 × 2 → 3 × 2"), "{report:?}");
    let after = scene.surface("sheet").unwrap();
    let alpha =
        Function::new(surface_alpha_spaces(&sheet).unwrap()[0].clone(), vec![1.0, 2.0, 1.0, 1.0, 1.0])
            .unwrap();
    for (u, v) in [(0.3, 0.4), (1.7, 3.1), (3.9, 2.2)] {
        let expected = sheet.derivative(u, v, 1, 0).unwrap() * alpha.value(u).unwrap();
        assert!((after.derivative(u, v, 1, 0).unwrap() - expected).norm() < 1e-12);
    }
    let mut scene = one.clone();
    run(&mut scene, json!({ "alpha": 0.5, "direction": "both", "ends": "free" })).unwrap();
    let after = scene.surface("sheet").unwrap();
    let (start, p, q) =
        (sheet.point(0.0, 0.0).unwrap(), sheet.point(2.2, 3.3).unwrap(), after.point(2.2, 3.3).unwrap());
    assert!((start + (p - start) * 0.5 - q).norm() < 1e-10);
    // The ends of each direction for themselves.
    let tuned = |ends: Value| {
        let mut scene = one.clone();
        run(&mut scene, json!({ "alpha_v": 0.5, "ends": ends }))
            .map(|_| scene.surface("sheet").unwrap().clone())
    };
    assert_eq!(tuned(json!(["exact", "free"])).unwrap(), tuned(json!("free")).unwrap());
    assert_ne!(tuned(json!(["free", "exact"])).ok(), tuned(json!("free")).ok(), "along v the ends stay");
    let fails = |fields: Value| {
        let mut scene = one.clone();
        let error = run(&mut scene, fields).unwrap_err().to_string();
        assert_eq!(scene, one);
        error
    };
    for (fields, words) in [
        (json!({}), "alpha_u"),
        (json!({ "alpha": 0.5 }), "direction"),
        (json!({ "alpha": [[1, 2]], "direction": "u" }), "step[0].alpha[0]"),
        (json!({ "alpha_u": [1, 2] }), "2 values where the derivative's own knots have 5"),
        (json!({ "alpha_u": 2, "direction": "u" }), "stands beside"),
        (json!({ "alpha_u": 2, "lock": [0] }), "tune a part (range)"),
        (
            json!({ "alpha_u": 2, "constraints": [{ "kind": "position", "at": [1, 1], "keep": true }] }),
            "alpha_at",
        ),
        (json!({ "alpha_u": 2, "ends": ["free", "loose"] }), "step[0].ends[1]"),
        (json!({ "alpha_u": 2, "range": [1, 2] }), "[[u0, u1], [v0, v1]]"),
    ] {
        let error = fails(fields.clone());
        assert!(error.contains(words), "{fields}: {error}");
    }
}

/// A number needs no freedom where a loop closes whatever it is: the loop keeps its degree and its knots, at high degrees too, and is scaled from its start.
#[test]
fn a_number_scales_a_loop_as_it_is() {
    for degree in [2, 3, 5, 7, 13, 25] {
        let n = 2 * degree + 5;
        let ring = (0..n).map(|i| i as f64 / n as f64 * std::f64::consts::TAU);
        let points = ring.map(|a| Point::new(3.0 * a.cos(), 2.0 * a.sin(), 0.3 * (2.0 * a).cos())).collect();
        let before = Curve::new(Space::periodic_uniform(degree, n).unwrap(), points).unwrap();
        let mut scene = Scene::new();
        scene.add(Object::new("ring", before.clone().into())).unwrap();
        run(&mut scene, json!({ "object": "ring", "alpha": 0.64 })).unwrap();
        let after = scene.curve("ring").unwrap();
        assert!(after.is_periodic(), "{degree}");
        assert_eq!((after.degree(), after.space().breakpoints()), (degree, before.space().breakpoints()));
        let (start, end) = before.domain();
        let first = before.point(start).unwrap();
        for k in 0..=40 {
            let u = start + (end - start) * f64::from(k) / 40.0;
            let wanted = first + (before.point(u).unwrap() - first) * 0.64;
            assert!((after.point(u).unwrap() - wanted).norm() < 1e-9, "{degree} {u}");
        }
    }
}

/// A number does not jump, though the derivative across its direction does: surfaces with creases, and of degree 1 across.
#[test]
fn a_number_crosses_creases() {
    let creased = Space::open(2, vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 2.0]).unwrap();
    let straight = Space::periodic(1, vec![0.0, 1.0, 2.0, 3.0]).unwrap();
    let smooth = Space::clamped_uniform(3, 6).unwrap();
    for (k, across) in [creased, straight].into_iter().enumerate() {
        for direction in ["u", "v"] {
            let (u, v) = if direction == "u" {
                (smooth.clone(), across.clone())
            } else {
                (across.clone(), smooth.clone())
            };
            let points = (0..u.len() * v.len()).map(|i| {
                let (a, b) = ((i / v.len()) as f64, (i % v.len()) as f64);
                Point::new(a + 0.1 * b.sin(), b + 0.2 * a.cos(), (a * b).sin())
            });
            let before = Surface::new(u.clone(), v.clone(), points.collect()).unwrap();
            for ends in ["free", "exact"] {
                let mut scene = Scene::new();
                scene.add(Object::new("s", before.clone().into())).unwrap();
                let fields = json!({ "object": "s", "alpha": 1.7, "direction": direction, "ends": ends });
                let done = run(&mut scene, fields);
                if ends == "exact" {
                    // That nothing but 1 keeps the ends may be so, and is said.
                    assert!(done.as_ref().err().is_none_or(|e| !e.to_string().contains("jumps")), "{done:?}");
                    continue;
                }
                done.unwrap_or_else(|e| panic!("{k} {direction}: {e}"));
                let after = scene.surface("s").unwrap();
                for (s, t) in [(0.2, 0.3), (0.7, 0.5), (0.4, 0.9)] {
                    let at = |space: &Space, s: f64| space.domain().0 + s * space.length();
                    let (a, b) = (at(&u, s), at(&v, t));
                    let by = if direction == "u" { (1, 0) } else { (0, 1) };
                    let [one, other] = [&before, after].map(|x| x.derivative(a, b, by.0, by.1).unwrap());
                    assert!((other - one * 1.7).norm() < 1e-10, "{k} {direction}: {one} {other}");
                }
            }
        }
    }
}
