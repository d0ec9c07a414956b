//! Lines, conics and elementary surfaces by themselves: OpenCASCADE finds them as what they are in STEP and IGES, whichever of these they came through.

use std::collections::BTreeMap;
use std::path::PathBuf;

use loftsman::kernel::Point;
use loftsman::kernel::brep::SurfaceForm;
use loftsman::kernel::conformance::{same_forms, sample_forms};
use loftsman::kernel::scene::{Geometry, Scene};
use loftsman::kernel::spline::Curve;
use loftsman_tests::oracle::{Oracle, at, list, number, position};
use serde_json::Value;

use crate::LOFTSMAN;

/// What OpenCASCADE calls the kind of an edge.
fn kind(curve: &Curve) -> &'static str {
    match curve.form().map_or("spline", |piece| piece.form.name()) {
        "spline" => "bsplinecurve",
        other => other,
    }
}

/// All curves that a scene shows, in its world.
fn shown(scene: &Scene) -> Vec<(String, Curve)> {
    let placed = scene.placed(1000).unwrap().filter_map(|placed| {
        let Geometry::Curve(curve) = placed.object.geometry() else { return None };
        let curve = placed.to_world.map_or_else(|| curve.clone(), |map| curve.transformed(&map).unwrap());
        Some((placed.object.name().to_owned(), curve))
    });
    placed.collect()
}

/// That OpenCASCADE has the edges of a scene, each with its kind, length, sizes and places; in any order.
fn agree(file: &str, scene: &Scene, found: &Value) {
    let mut edges: Vec<&Value> = list(found, "curves").iter().collect();
    let expected = shown(scene);
    assert_eq!(edges.len(), expected.len(), "{file}");
    for (name, curve) in expected {
        let name = format!("{file}: {name}, {}", kind(&curve));
        let length = curve.length(1e-12).unwrap().value;
        let size = curve.points().iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
        let ends = [curve.points()[0], *curve.points().last().unwrap()];
        let near = |value: &Value, p: &Point| crate::apart(position(value), [p.x, p.y, p.z]) <= 1e-11 * size;
        let is = |edge: &&Value| {
            let places = list(edge, "places");
            (number(edge, "length") - length).abs() <= 1e-9 * length.max(1e-3 * size)
                && near(&places[0], &ends[0])
                && near(&places[2], &ends[1])
        };
        let Some(number) = edges.iter().position(is) else { panic!("{name} is none of {edges:#?}") };
        let edge = edges.remove(number);
        assert_eq!(at(edge, "kind"), kind(&curve), "{name}");
        // The place in the middle is on it; OpenCASCADE has its own sizes.
        let middle = Point::from(position(&list(edge, "places")[1]));
        assert!(curve.closest(middle).unwrap().distance <= 1e-11 * size, "{name}");
    }
}

/// That OpenCASCADE has the surfaces of a scene as faces, each as large, and of its kind; in IGES what is turned or moved along has no other.
fn agree_on_surfaces(file: &str, scene: &Scene, found: &Value) {
    let mut faces: Vec<&Value> = list(found, "surfaces").iter().collect();
    for object in scene.objects() {
        let Geometry::Surface(surface) = object.geometry() else { continue };
        let piece = surface.form().unwrap();
        let name = format!("{file}: {}, {}", object.name(), piece.noun());
        let area = loftsman::area_volume::surface_area_of(surface).unwrap();
        let is = |face: &&Value| (number(face, "area") - area).abs() <= 1e-7 * area;
        let Some(place) = faces.iter().position(is) else { panic!("{name} of {area} is none of {faces:#?}") };
        let face = faces.remove(place);
        let kind = face["kind"].as_str().unwrap();
        let turned = ["surfaceofrevolution", "surfaceofextrusion"].contains(&kind);
        assert!(kind == piece.noun() || (file.ends_with(".igs") && turned), "{name}: {kind}");
        let sizes = match piece.form {
            SurfaceForm::Cylinder { radius, .. } | SurfaceForm::Sphere { radius, .. } => vec![radius],
            SurfaceForm::Cone { angle, .. } => vec![angle],
            SurfaceForm::Torus { major, minor, .. } => vec![major, minor],
            _ => vec![],
        };
        for (own, other) in sizes.iter().zip(list(face, "sizes")) {
            assert!((own - other.as_f64().unwrap()).abs() <= 1e-12 * own, "{name}: {own} {other}");
        }
    }
    assert!(faces.is_empty(), "{file}: {faces:#?}");
}

#[test]
fn opencascade_finds_what_has_a_form_by_either_way() {
    let folder = tempfile::tempdir().unwrap();
    let scene = sample_forms().unwrap();
    let native = folder.path().join("forms.loft.json");
    loftsman::write(&scene, &native).unwrap();
    let mut files: BTreeMap<&str, PathBuf> = BTreeMap::new();
    files.insert("native", native);
    for (from, to) in [
        ("native", "a.step"),
        ("native", "a.igs"),
        ("a.step", "step.step"),
        ("a.step", "step.igs"),
        ("a.igs", "iges.igs"),
        ("a.igs", "iges.step"),
        ("step.igs", "step.igs.step"),
        ("iges.step", "back.loft.json"),
    ] {
        let path = folder.path().join(to);
        LOFTSMAN.done(folder.path(), &["convert", &files[from].to_string_lossy(), &path.to_string_lossy()]);
        let verdict = same_forms(&scene, &loftsman::read(&path).unwrap().0);
        assert!(verdict.passed(), "{to}: {verdict}");
        files.insert(to, path);
    }
    let told = LOFTSMAN.json(folder.path(), &["info", &files["step.igs.step"].to_string_lossy()]);
    let forms: Vec<&str> = list(&told, "objects").iter().filter_map(|o| o["form"].as_str()).collect();
    assert!(forms.contains(&"arc of a circle") && forms.contains(&"piece of a hyperbola"), "{told}");
    let asked: Vec<PathBuf> = files
        .iter()
        .filter(|(to, _)| !to.contains("json") && **to != "native")
        .map(|(_, path)| path.clone())
        .collect();
    let Some(found) = Oracle::OpenCascade.ask(&asked, &["--curves"]) else { return };
    for (path, found) in asked.iter().zip(&found) {
        agree(&path.to_string_lossy(), &scene, found);
        agree_on_surfaces(&path.to_string_lossy(), &scene, found);
    }
}
