//! What `simulate` says of itself in words: where places that slide ended, that something comes to rest with what is taken for granted.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests may fail the test")]

use loftsman_kernel::scene::{Geometry, Object, Scene, Unit};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};

use serde_json::{Value, json};

use crate::common::run;

fn rope(n: usize, size: f64) -> Geometry {
    let at = |i: usize| Point::new(0.2 * size * i as f64, 0.0, 0.1 * size * (i % 2) as f64);
    Curve::new(Space::clamped_uniform(3, n).unwrap(), (0..n).map(at).collect()).unwrap().into()
}

/// A point of it.
fn place(of: &Geometry, at: f64) -> Point {
    let Geometry::Curve(curve) = of else { panic!("a curve") };
    curve.point(at).unwrap()
}

/// A line across, through a point in its middle.
fn across(middle: Point, size: f64) -> Geometry {
    let space = Space::clamped_uniform(1, 2).unwrap();
    let reach = Vector::y() * (0.7 * size);
    Curve::new(space, vec![middle - reach, middle + reach]).unwrap().into()
}

/// A level sheet with a point in its middle, at [1.5, 1.5].
fn sheet(middle: Point) -> Geometry {
    let space = || Space::clamped_uniform(3, 6).unwrap();
    let share = |k: usize| space().greville(k) / 3.0 - 0.5;
    let at = |k: usize| middle + Vector::new(share(k / 6), share(k % 6), 0.0);
    Surface::new(space(), space(), (0..36).map(at).collect()).unwrap().into()
}

fn scene(objects: Vec<(&str, Geometry)>) -> Scene {
    let mut scene = Scene::new();
    scene.unit = Unit::Metre;
    objects.into_iter().for_each(|(name, geometry)| scene.add(Object::new(name, geometry)).unwrap());
    scene
}

/// The numbers of a note: `"ring" ends at 4.5 and [1, 2], in [0.1, 0, -3]`.
fn numbers(note: &str) -> Vec<f64> {
    let rest = note.split_once(" ends at ").unwrap().1;
    rest.split(|c: char| !(c.is_ascii_digit() || "-.e".contains(c)))
        .filter_map(|part| part.parse().ok())
        .collect()
}

#[test]
fn where_places_slid_is_told_with_parameters_and_points() {
    for size in [1e-3, 1.0, 1e4] {
        let own = rope(12, size);
        let other = across(place(&own, 7.0), size);
        let mut scene = scene(vec![("rope", own), ("other", other)]);
        let report = run(
            &mut scene,
            json!({ "object": "rope", "seconds": 0.5, "scheme": "implicit", "gravity": [0, 0, -size],
                "constraints": [
                { "kind": "fixed", "at": 0, "name": "nail" },
                { "kind": "sliding", "near": 4, "name": "ring" },
                { "kind": "tied", "near": 7, "other": "other", "other_near": 0.5, "name": "hook" },
            ] }),
        )
        .unwrap();
        let Geometry::Curve(rope) = scene.object("rope").unwrap().geometry() else { panic!("a curve") };
        let told: Vec<&String> = report.notes.iter().filter(|note| note.contains(" ends at ")).collect();
        assert_eq!(told.len(), 2, "what stays is not told: {:?}", report.notes);
        for (note, name, parameters) in [(told[0], "ring", 1), (told[1], "hook", 2)] {
            assert!(note.starts_with(&format!("\"{name}\" ends at ")), "{note}");
            let found = numbers(note);
            let own = report.constraints.iter().find(|c| c.name == name).unwrap().location.clone().unwrap();
            assert_eq!((found.len(), own.len()), (parameters + 3, parameters), "{note}");
            for (told, own) in found.iter().zip(&own) {
                assert!((told - own).abs() < 1e-5 * 9.0, "{note}: {own:?}");
            }
            let place = rope.point(own[0]).unwrap();
            for axis in 0..3 {
                let told = found[parameters + axis];
                assert!((told - place[axis]).abs() < 1e-5 * 2.2 * size, "{note}: {place}");
            }
        }
        assert_eq!(report.steps, Some(12));
        assert!(report.iterations.is_none() && report.warnings.is_empty());
    }
}

/// Both parameters of both places, one behind the other.
#[test]
fn locations_on_sheets_have_both_parameters() {
    let own = rope(12, 0.3);
    let below = sheet(place(&own, 4.0));
    let mut scene = scene(vec![("rope", own), ("sheet", below)]);
    let report = run(
        &mut scene,
        json!({ "object": "rope", "seconds": 0.25, "scheme": "implicit", "constraints": [
            { "kind": "tied", "at": 4, "other": "sheet", "other_near": [1.5, 1.5], "name": "bead" },
        ] }),
    )
    .unwrap();
    let own = report.constraints[0].location.clone().unwrap();
    let note = report.notes.iter().find(|note| note.starts_with("\"bead\" ends at ")).unwrap();
    let found = numbers(note);
    assert_eq!((own.len(), found.len()), (3, 6), "{note}");
    assert!(own.iter().zip(&found).all(|(own, told)| (own - told).abs() < 1e-4), "{note}: {own:?}");
    let Geometry::Surface(sheet) = scene.object("sheet").unwrap().geometry() else { panic!("a surface") };
    let place = sheet.point(own[1], own[2]).unwrap();
    assert!((0..3).all(|k| (found[3 + k] - place[k]).abs() < 1e-4), "{note}: {place}");
}

/// With nothing said but what holds it, a rope that falls is not still stretched to and fro after some seconds: its energy of motion is a small
/// share of what it fell by. Without any damping it keeps all of it.
#[test]
fn a_first_try_comes_to_rest() {
    let moving = |damping: Value| -> f64 {
        let mut scene = scene(vec![("rope", rope(12, 1.0))]);
        let mut fields = json!({ "seconds": 8, "constraints": [{ "kind": "fixed", "at": 0 }, { "kind": "fixed", "at": 9 }] });
        if !damping.is_null() {
            fields["damping"] = damping;
        }
        let report = run(&mut scene, fields).unwrap();
        let note = report.notes.iter().find(|note| note.starts_with("energy at the end: motion ")).unwrap();
        note.split([' ', ',']).find_map(|word| word.parse().ok()).unwrap()
    };
    let (taken, none) = (moving(Value::Null), moving(json!(0)));
    assert!(taken < 0.05 * none, "{taken} with what is taken for granted, {none} without damping");
    assert_eq!(taken, moving(json!(0.5)));
}

/// What drifts by more than a millionth of the size is warned of: here where things fall a hundred thousand times as fast as they do, and not over corners alone.
#[test]
fn what_drifts_is_warned_of() {
    let mut warned = 0;
    for (degree, gravity) in [(1, -9.81), (3, -9.81), (1, -1e6)] {
        let space = Space::clamped_uniform(degree, 12).unwrap();
        let (end, at) = (space.domain().1, |i: usize| Point::new(0.2 * i as f64, 0.0, 0.3 * (i % 2) as f64));
        let zigzag = Curve::new(space, (0..12).map(at).collect()).unwrap();
        let mut scene = scene(vec![("rope", zigzag.into())]);
        let fields = json!({ "object": "rope", "seconds": 1, "scheme": "exact", "gravity": [0, 0, gravity], "constraints": [
            { "kind": "fixed", "at": 0 }, { "kind": "sliding", "near": 0.45 * end },
        ] });
        let report = run(&mut scene, fields).unwrap();
        let note = report.notes.iter().find(|note| note.starts_with("constraints drifted by ")).unwrap();
        let drift: f64 = note.split(' ').find_map(|word| word.parse().ok()).unwrap();
        let told = report.warnings.iter().any(|warning| warning.contains("\"rope\" drifted by "));
        assert_eq!(told, drift > 1e-6 * 2.2, "{note} {:?}", report.warnings);
        assert!(!told || gravity < -10.0, "{degree}: {note}");
        warned += usize::from(told);
    }
    assert!(warned > 0);
}

#[test]
fn a_single_point_is_refused_by_name() {
    let point =
        Curve::new(Space::clamped_uniform(3, 5).unwrap(), vec![Point::new(1.0, 2.0, 3.0); 5]).unwrap();
    for (object, bodies) in [("dot", json!([])), ("rope", json!([{ "object": "dot" }]))] {
        let mut scene = scene(vec![("rope", rope(12, 1.0)), ("dot", point.clone().into())]);
        let fields = json!({ "object": object, "seconds": 1, "bodies": bodies });
        let refused = run(&mut scene, fields).unwrap_err().to_string();
        assert!(refused.contains("\"dot\" is a single point"), "{refused}");
    }
}
