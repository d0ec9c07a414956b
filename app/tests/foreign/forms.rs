//! Lines, conics, elementary surfaces and swept curves by themselves: OpenCASCADE finds them as what they are in STEP and IGES, whichever of these they came through.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::PathBuf;

use loftsman::kernel::brep::{CurveForm, Frame, SurfaceForm};
use loftsman::kernel::conformance::{same_forms, sample_forms};
use loftsman::kernel::scene::{Geometry, Object, Scene, Unit};
use loftsman::kernel::spline::{Curve, CurvePiece, Space, Surface, SurfacePiece};
use loftsman::kernel::{Point, Vector};
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

/// A spline and conics, along a vector and about an axis.
fn sweeps() -> Scene {
    let frame = Frame::new(Point::new(9.0, 1.0, 2.0), Vector::new(0.1, 1.0, 0.2), Vector::x()).unwrap();
    let points = [[8.0, 0.0], [9.0, 1.0], [12.0, 2.0], [17.0, 3.0]].map(|[x, y]| Point::new(x, y, 1.5));
    let arc = |[a, b]: [f64; 2], [from, to]: [f64; 2]| {
        let form = if a == b {
            CurveForm::Circle { frame, radius: a }
        } else {
            CurveForm::Ellipse { frame, radii: [a, b] }
        };
        let curve = Curve::elliptic_arc(frame.origin, frame.x * a, frame.y() * b, from, to - from).unwrap();
        curve.with_form(CurvePiece { form, range: [from, to] }).unwrap()
    };
    let knots = Space::clamped(2, &[-1.0, 1.5]).unwrap();
    let at = |a: f64, b: f64| frame.origin + frame.x * (0.5 * a * b) + frame.y() * (0.5 * (a + b));
    let parabola = Curve::new(knots, vec![at(-1.0, -1.0), at(-1.0, 1.5), at(1.5, 1.5)]).unwrap();
    let form = CurveForm::Parabola { frame, focal: 0.5 };
    let line = Curve::line(Point::new(8.0, 0.0, 0.0), Point::new(9.0, 4.0, 1.0)).unwrap();
    let (origin, direction) = (Point::new(1.0, -2.0, 0.5), Vector::new(0.3, -0.5, 0.8));
    let mut scene = Scene::new();
    for (name, profile) in [
        ("spline", Curve::bezier(points.to_vec()).unwrap()),
        ("ring", arc([2.0; 2], [0.0, TAU])),
        ("arc", arc([2.0; 2], [-0.5, 2.0])),
        ("tall ellipse", arc([1.0, 2.5], [0.25, 3.0])),
        ("parabola", parabola.with_form(CurvePiece { form, range: [-1.0, 1.5] }).unwrap()),
        ("line", line.with_form(CurvePiece::LINE).unwrap()),
    ] {
        let of = profile.form().copied();
        for (place, sweep) in [("turned", TAU), ("in part", 1.25), ("back", -2.0)] {
            let surface = Surface::revolution(&profile, origin, direction, sweep).unwrap();
            let piece = SurfacePiece::turned(&surface, (origin, direction), sweep, of).unwrap();
            scene
                .add(Object::new(format!("{name} {place}"), surface.with_form(piece).unwrap().into()))
                .unwrap();
        }
        if name != "line" {
            let surface = Surface::extrusion(&profile, Vector::new(1.0, 5.0, -3.0)).unwrap();
            let piece = SurfacePiece::extruded(&surface, of);
            scene
                .add(Object::new(format!("{name} along"), surface.with_form(piece).unwrap().into()))
                .unwrap();
        }
    }
    scene
}

/// OpenCASCADE finds each as large as it is, and as what it is; but for parabolas in STEP, and there in metres what is along vectors and lines about axes.
#[test]
fn opencascade_finds_swept_curves_by_either_way() {
    let folder = tempfile::tempdir().unwrap();
    let scene = sweeps();
    let mut files = Vec::new();
    for unit in [Unit::Millimetre, Unit::Metre] {
        let native = folder.path().join(format!("{}.loft.json", unit.name()));
        loftsman::write(&scene.converted(unit, scene.up).unwrap(), &native).unwrap();
        for ends in ["step", "igs"] {
            let path = folder.path().join(format!("{}.{ends}", unit.name()));
            let other = folder.path().join(format!(
                "{}.{ends}.{}",
                unit.name(),
                if ends == "step" { "igs" } else { "step" }
            ));
            LOFTSMAN.done(folder.path(), &["convert", &native.to_string_lossy(), &path.to_string_lossy()]);
            LOFTSMAN.done(folder.path(), &["convert", &path.to_string_lossy(), &other.to_string_lossy()]);
            files.extend([path, other]);
        }
    }
    let Some(found) = Oracle::OpenCascade.ask(&files, &["--curves"]) else { return };
    // OpenCASCADE's lengths are millimetres.
    let by = scene.unit.metres().unwrap() / 1e-3;
    for (path, found) in files.iter().zip(&found) {
        assert_eq!(found["valid"], true, "{}", path.display());
        let mut faces: Vec<&Value> = list(found, "surfaces").iter().collect();
        for object in scene.objects() {
            let Geometry::Surface(surface) = object.geometry() else { continue };
            let name = format!("{}: {}", path.display(), object.name());
            let area = by * by * loftsman::area_volume::surface_area_of(surface).unwrap();
            // OpenCASCADE integrates what is extruded by few nodes, of the ring 2.4e-3 off its integral (65.119424).
            let near = if object.name().ends_with("along") { 5e-3 } else { 1e-6 };
            let is = |face: &&Value| (number(face, "area") - area).abs() <= near * area;
            let Some(place) = faces.iter().position(is) else {
                panic!("{name} of {area} is none of {faces:#?}")
            };
            let kind = at(faces.remove(place), "kind").to_owned();
            // In other units than millimetres OpenCASCADE takes the lengths of some for these.
            let metres = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("m."));
            let by_length = metres && (object.name().ends_with("along") || object.name().starts_with("line"));
            let spline = (object.name().starts_with("parabola") || by_length)
                && path.to_string_lossy().contains("step");
            let piece = surface.form().unwrap();
            let expected = match piece.noun() {
                _ if spline => "bsplinesurface".to_owned(),
                noun => format!("surfaceof{noun}"),
            };
            assert_eq!(kind, expected, "{name}");
        }
        assert!(faces.is_empty(), "{}: {faces:#?}", path.display());
    }
}
