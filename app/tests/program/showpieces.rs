//! What examples of fine tuning and of subdivision say of themselves, measured on the files that they write.

use std::path::{Path, PathBuf};

use loftsman::kernel::spline::{Curve, Surface};
use loftsman::kernel::{Point, Vector};
use serde_json::Value;

use super::examples::copy;
use crate::LOFTSMAN;

/// Runs an example in a folder; where its outputs are.
fn run(folder: &Path, example: &str) -> PathBuf {
    let examples = folder.join("examples");
    copy(&loftsman_tests::repository().join("examples"), &examples);
    LOFTSMAN.json(folder, &["run", &examples.join(example).join("recipe.toml").to_string_lossy()]);
    folder.join("out").join(example)
}

fn curvature(first: &Vector, second: &Vector) -> f64 {
    first.cross(second).norm() / first.norm().powi(3)
}

fn turned(a: &Vector, b: &Vector) -> f64 {
    a.cross(b).norm() / (a.norm() * b.norm())
}

/// The nose has twice its curvature, to the digit and all over its span; it and both ends stay, and no tangent turns.
#[test]
fn the_nose_is_twice_as_sharp() {
    let folder = tempfile::tempdir().unwrap();
    let out = run(folder.path(), "sharper-nose");
    let recipe = r#"
        input = "examples/blade-section/IEA-15-240-RWT_AF20_Coords.txt"
        output = "before.loft.json"
        [[step]]
        op = "fit"
        degree = 3
        tolerance = 2e-4
    "#;
    std::fs::write(folder.path().join("before.toml"), recipe).unwrap();
    LOFTSMAN.json(folder.path(), &["run", "before.toml"]);
    let read = |path: PathBuf, name: &str| -> Curve {
        loftsman::read_scene(path).unwrap().curve(name).unwrap().clone()
    };
    let before = read(folder.path().join("before.loft.json"), "IEA-15-240-RWT_AF20_Coords");
    let after = read(out.join("section.loft.json"), "section");
    let bent =
        |curve: &Curve, t| curvature(&curve.derivative(t, 1).unwrap(), &curve.derivative(t, 2).unwrap());
    for k in 0..=20 {
        let t = 0.475 + 0.05 * f64::from(k) / 20.0;
        let ratio = bent(&after, t) / bent(&before, t);
        assert!((ratio - 2.0).abs() < 1e-9, "{t}: {ratio}");
    }
    for t in [0.0, 0.5, 1.0] {
        let off = (after.point(t).unwrap() - before.point(t).unwrap()).norm();
        assert!(off < 1e-13, "{t}: {off:e}");
    }
    for k in 1..400 {
        let t = f64::from(k) / 400.0;
        let turn = turned(&before.derivative(t, 1).unwrap(), &after.derivative(t, 1).unwrap());
        assert!(turn < 1e-10, "{t}: {turn:e}");
    }
}

/// The body bends 1.8 times as sharply at the foot of the windscreen, as `κ/α` everywhere; nose and tail stay and no line along it turns.
#[test]
fn the_body_bends_more_sharply() {
    let folder = tempfile::tempdir().unwrap();
    let out = run(folder.path(), "car-body");
    let scene = loftsman::read_scene(out.join("body.loft.json")).unwrap();
    let (body, tuned) = (scene.surface("body").unwrap(), scene.surface("tuned").unwrap());
    // It stands beside the other.
    let aside = tuned.point(0.0, 0.5).unwrap() - body.point(0.0, 0.5).unwrap();
    assert!(aside.norm() > 1.0);
    let of = |surface: &Surface, u, v, order| surface.derivative(u, v, order, 0).unwrap();
    let mut sharpest = 0.0_f64;
    for j in 0..=8 {
        let v = f64::from(j) / 8.0;
        for u in [0.0, 1.0] {
            let off = (tuned.point(u, v).unwrap() - body.point(u, v).unwrap() - aside).norm();
            assert!(off < 1e-11, "{u} {v}: {off:e}");
        }
        for i in 1..100 {
            let u = f64::from(i) / 100.0 + 1e-4;
            let (was, is) = (of(body, u, v, 1), of(tuned, u, v, 1));
            assert!(turned(&was, &is) < 1e-9, "{u} {v}");
            let alpha = is.norm() / was.norm();
            let (before, after) = (curvature(&was, &of(body, u, v, 2)), curvature(&is, &of(tuned, u, v, 2)));
            if before > 1e-2 {
                assert!((after / before * alpha - 1.0).abs() < 1e-6, "{u} {v}: {after} {before} {alpha}");
                sharpest = sharpest.max(after / before);
            }
        }
    }
    assert!((sharpest - 1.8).abs() < 0.05, "{sharpest}");
}

/// The limit passes the five points, by the closed form of Catmull and Clark's limit on quads: `(n² P + 4 Σ E + Σ F) / (n (n + 5))`.
#[test]
fn the_head_passes_five_points() {
    let folder = tempfile::tempdir().unwrap();
    let out = run(folder.path(), "five-points");
    let text = std::fs::read_to_string(out.join("head.loft.json")).unwrap();
    let document: Value = serde_json::from_str(&text).unwrap();
    let shape = &document["objects"][0]["shape"];
    let numbers = |value: &Value| -> Vec<f64> {
        value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
    };
    let points: Vec<Point> =
        shape["points"].as_array().unwrap().iter().map(|p| Point::from_slice(&numbers(p))).collect();
    let faces: Vec<Vec<usize>> = shape["faces"]
        .as_array()
        .unwrap()
        .iter()
        .map(|face| numbers(face).into_iter().map(|k| k as usize).collect())
        .collect();
    assert!(faces.iter().all(|face| face.len() == 4));
    for (vertex, to) in [
        (56, [0.0, -0.43, 1.74]),
        (70, [-1.69, 0.61, -0.11]),
        (74, [1.69, 0.61, -0.11]),
        (50, [0.0, 1.02, -0.04]),
        (51, [0.0, -1.12, 0.04]),
    ] {
        let (mut n, mut sum) = (0.0, Vector::zeros());
        for face in &faces {
            let Some(k) = face.iter().position(|v| *v == vertex) else { continue };
            // The next vertex of each face is one end of an edge, each once round a closed fan.
            sum += points[face[(k + 1) % 4]].coords * 4.0 + points[face[(k + 2) % 4]].coords;
            n += 1.0;
        }
        let limit = (points[vertex].coords * (n * n) + sum) / (n * (n + 5.0));
        let off = (limit - Vector::from(to)).norm();
        assert!(off < 1e-13, "vertex {vertex} of {n} edges: {off:e}");
    }
}
