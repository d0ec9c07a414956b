//! Sections of meshes, torn curves, and what the operations say of wrong fields.
#![allow(clippy::unwrap_used, reason = "a test that fails should panic")]

use loftsman_intersection::{
    Intersection, IntersectionError, Options, Plane, curve_plane, curves, mesh_section, mesh_section_area,
    section,
};
use loftsman_kernel::brep::Brep;
use loftsman_kernel::mesh::{Cloud, Mesh, Polyline};
use loftsman_kernel::plugin::{Context, Parameters, Registry, StepReport};
use loftsman_kernel::scene::{Geometry, Object, Scene};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};
use serde_json::{Value, json};

fn cube() -> Mesh {
    let corner = |k: usize| Point::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Mesh::new((0..8).map(corner).collect(), &faces).unwrap()
}

fn plane(point: [f64; 3], normal: [f64; 3]) -> Plane {
    Plane::new(Point::from(point), Vector::from(normal)).unwrap()
}

fn round(points: &[Point]) -> f64 {
    (0..points.len()).map(|k| (points[(k + 1) % points.len()] - points[k]).norm()).sum()
}

#[test]
fn meshes_are_cut_in_loops() {
    let cube = cube();
    let cut = mesh_section(&cube, &plane([0.0, 0.0, 0.3], [0.0, 0.0, 1.0]));
    assert!(cut.len() == 1 && cut[0].closed && cut[0].points.len() == 4, "{cut:?}");
    assert!((round(&cut[0].points) - 4.0).abs() < 1e-15);
    // Across the space diagonal: a regular hexagon with sides √2/2.
    let cut = mesh_section(&cube, &plane([0.5; 3], [1.0; 3]));
    assert!(cut.len() == 1 && cut[0].closed && cut[0].points.len() == 6, "{cut:?}");
    assert!((round(&cut[0].points) - 3.0 * 2.0_f64.sqrt()).abs() < 1e-14);
    // Through corners and along edges: their points to the last bit; beside it nothing.
    let cut = mesh_section(&cube, &plane([0.0; 3], [1.0, -1.0, 0.0]));
    assert!(cut.iter().flat_map(|l| &l.points).all(|p| p.x == p.y) && !cut.is_empty(), "{cut:?}");
    assert!(mesh_section(&cube, &plane([0.0, 0.0, 1.5], [0.0, 0.0, 1.0])).is_empty());
    // A face in the plane is bounded by a loop, on whichever side the rest is.
    for z in [0.0, 1.0] {
        let cut = mesh_section(&cube, &plane([0.0, 0.0, z], [0.0, 0.0, 1.0]));
        assert!(cut.len() == 1 && cut[0].closed && round(&cut[0].points) == 4.0, "{z}: {cut:?}");
        assert!(cut[0].points.iter().all(|p| p.z == z), "{cut:?}");
    }
    // With points of its own for each face, as where normals are kept by point.
    let apart: Vec<Point> = cube.corners().iter().map(|&c| cube.points()[c as usize]).collect();
    let faces: Vec<Vec<usize>> = (0..cube.face_count()).map(|k| (4 * k..4 * k + 4).collect()).collect();
    let cut = mesh_section(&Mesh::new(apart, &faces).unwrap(), &plane([0.5; 3], [1.0; 3]));
    assert!(cut.len() == 1 && cut[0].closed && cut[0].points.len() == 6, "{cut:?}");
    let open = Mesh::new(cube.points().to_vec(), &[[0, 1, 5, 4], [1, 3, 7, 5]]).unwrap();
    let cut = mesh_section(&open, &plane([0.0, 0.0, 0.5], [0.0, 0.0, 1.0]));
    assert!(cut.len() == 1 && !cut[0].closed && cut[0].points.len() == 3, "{cut:?}");
    // A face that is not convex is cut twice.
    let comb =
        [[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [2.0, 2.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
    let comb =
        Mesh::new(comb.map(|[x, z]| Point::new(x, 0.0, z)).to_vec(), &[[0, 1, 2, 3, 4, 5, 6, 7]]).unwrap();
    let cut = mesh_section(&comb, &plane([0.0, 0.0, 1.5], [0.0, 0.0, 1.0]));
    assert_eq!(cut.len(), 2, "{cut:?}");
    assert!(cut.iter().all(|l| (l.points[1] - l.points[0]).norm() == 1.0));
}

/// The area of closed sections, by closed forms; of what is open none.
#[test]
fn closed_sections_of_meshes_have_an_area() {
    let cube = cube();
    let area = |mesh: &Mesh, at: &Plane| mesh_section_area(&mesh_section(mesh, at), at);
    let level = plane([0.0, 0.0, 0.3], [0.0, 0.0, -2.0]);
    assert!((area(&cube, &level).unwrap() - 1.0).abs() < 1e-15);
    // A hexagon with sides √2/2.
    let askew = area(&cube, &plane([0.5; 3], [1.0; 3])).unwrap();
    assert!((askew - 0.75 * 3.0_f64.sqrt()).abs() < 1e-14, "{askew}");
    // A room inside takes its part away, and a block in it adds its own.
    let mut points = Vec::new();
    let mut faces: Vec<Vec<usize>> = Vec::new();
    for (low, high) in [(0.0, 1.0), (0.2, 0.8), (0.4, 0.6)] {
        let first = points.len();
        points.extend(cube.points().iter().map(|p| p.map(|c| if c == 0.0 { low } else { high })));
        faces.extend(cube.faces().map(|face| face.iter().map(|k| first + *k as usize).collect()));
    }
    let nested = Mesh::new(points, &faces).unwrap();
    let found = area(&nested, &plane([0.0, 0.5, 0.0], [0.0, 1.0, 0.0])).unwrap();
    assert!((found - (1.0 - 0.36 + 0.04)).abs() < 1e-14, "{found}");
    let open = Mesh::new(cube.points().to_vec(), &[[0, 1, 5, 4], [1, 3, 7, 5]]).unwrap();
    assert_eq!(area(&open, &level), None);
    assert_eq!(area(&cube, &plane([0.0, 0.0, 2.0], [0.0, 0.0, 1.0])), None);
    let report = run(&mut scene(), "section", json!({ "object": "cube", "axis": "z", "at": 0.5 })).unwrap();
    assert!(report.notes.iter().any(|note| note.ends_with("cuts 1 piece, an area of 1 m²")), "{report:?}");
}

/// An edge in the plane belongs to the section, and of a line along which a surface touches it a point is told, whichever way the plane
/// looks and on whichever side the surface is.
#[test]
fn edges_in_the_plane_and_lines_that_touch_it_are_told_from_either_side() {
    let corner = |x: f64, y: f64| Point::new(x, y, 0.5 * x);
    let line = || Space::clamped_uniform(1, 2).unwrap();
    let net = vec![corner(0.0, 0.0), corner(0.0, 1.0), corner(1.0, 0.0), corner(1.0, 1.0)];
    let ramp = Surface::new(line(), line(), net).unwrap();
    let ring = Curve::circle(Point::origin(), Vector::z(), 1.0).unwrap();
    let pipe = Surface::extrusion(&ring, Vector::z() * 3.0).unwrap();
    for way in [1.0, -1.0] {
        for x in [0.0, 0.3, 1.0] {
            let cut = section(&ramp, &plane([x, 0.0, 0.0], [way, 0.0, 0.0]), &Options::default()).unwrap();
            assert!(cut.curves.len() == 1 && cut.touching.is_empty(), "{x} {way}: {cut:?}");
            let length = cut.curves[0].curve.length(1e-12).unwrap().value;
            assert!((length - 1.0).abs() < 1e-9, "{x} {way}: {length}");
        }
        for (x, lines) in [(-1.0, 0), (-0.5, 2), (0.999, 2), (0.99999, 2), (1.0, 0), (1.1, 0)] {
            let cut = section(&pipe, &plane([x, 0.0, 0.0], [way, 0.0, 0.0]), &Options::default()).unwrap();
            assert_eq!(cut.curves.len(), lines, "{x} {way}");
            assert_eq!(cut.touching.len(), usize::from(f64::abs(x) == 1.0), "{x} {way}");
            assert!(cut.touching.iter().all(|p| (p.x - x).abs() < 1e-6 && p.y.abs() < 1e-4), "{cut:?}");
            for one in &cut.curves {
                assert!((one.curve.length(1e-12).unwrap().value - 3.0).abs() < 1e-6, "{x} {way}");
            }
        }
        // The end of a pipe is a circle, closed.
        for z in [0.0, 3.0] {
            let cut = section(&pipe, &plane([0.0, 0.0, z], [0.0, 0.0, way]), &Options::default()).unwrap();
            assert!(cut.curves.len() == 1 && cut.curves[0].closed, "{z} {way}: {cut:?}");
        }
    }
}

#[test]
fn a_fine_ball_is_cut_in_nearly_a_circle() {
    let (n, m) = (96_u32, 48_u32);
    let at = |i: u32, j: u32| {
        let (a, b) = (
            std::f64::consts::TAU * f64::from(i % n) / f64::from(n),
            std::f64::consts::PI * f64::from(j) / f64::from(m),
        );
        Point::new(b.sin() * a.cos(), b.sin() * a.sin(), b.cos())
    };
    let points = (0..n).flat_map(|i| (0..=m).map(move |j| (i, j))).map(|(i, j)| at(i, j)).collect();
    let id = |i: u32, j: u32| ((i % n) * (m + 1) + j) as usize;
    let faces: Vec<[usize; 4]> = (0..n)
        .flat_map(|i| (1..m - 1).map(move |j| [id(i, j), id(i, j + 1), id(i + 1, j + 1), id(i + 1, j)]))
        .collect();
    let ball = Mesh::new(points, &faces).unwrap();
    let cut = mesh_section(&ball, &plane([0.2, 0.1, 0.3], [1.0, 2.0, 0.0]));
    assert!(cut.len() == 1 && cut[0].closed);
    let unit = Vector::new(1.0, 2.0, 0.0).normalize();
    let height = Vector::new(0.2, 0.1, 0.3).dot(&unit);
    let expected = std::f64::consts::TAU * (1.0 - height * height).sqrt();
    assert!((round(&cut[0].points) - expected).abs() < 2e-3 * expected);
    assert!(cut[0].points.iter().all(|p| (p.coords.dot(&unit) - height).abs() < 1e-15 * 8.0));
}

#[test]
fn torn_curves_are_met_on_both_sides() {
    let points =
        [[0.0, 0.0], [2.0, 2.0], [0.0, 2.0], [2.0, 0.0]].map(|[x, y]| Point::new(x, y, 0.0)).to_vec();
    let torn = Curve::new(Space::open(1, vec![0.0, 0.0, 1.0, 1.0, 2.0, 2.0]).unwrap(), points).unwrap();
    let line = Curve::line(Point::new(0.0, 1.5, 0.0), Point::new(3.0, 1.5, 0.0)).unwrap();
    assert_eq!(curves(&line, &torn, &Options::default()).unwrap().meetings.len(), 2);
    assert_eq!(curves(&torn, &line, &Options::default()).unwrap().meetings.len(), 2);
    // Through the end of the first part, where the parameter is that of the second.
    let end = Curve::line(Point::new(1.0, 2.0, 0.0), Point::new(3.0, 2.0, 0.0)).unwrap();
    let found = curves(&end, &torn, &Options::default()).unwrap();
    assert!(
        found.meetings.len() == 1 && (found.meetings[0].point - Point::new(2.0, 2.0, 0.0)).norm() < 1e-9,
        "{found:?}"
    );
    let across = curve_plane(&torn, &plane([1.5, 0.0, 0.0], [1.0, 0.0, 0.0]), &Options::default()).unwrap();
    assert_eq!(across.meetings.len(), 2, "{across:?}");
}

fn scene() -> Scene {
    let mut scene = Scene::new();
    let ring = Curve::circle(Point::origin(), Vector::z(), 1.0).unwrap();
    let pipe = Surface::extrusion(&ring, Vector::z()).unwrap();
    scene.add(Object::new("ring", ring.clone().into())).unwrap();
    scene.add(Object::new("pipe", pipe.into())).unwrap();
    scene.add(Object::new("cube", cube().into())).unwrap();
    scene.add(Object::new("dots", Cloud { points: vec![Point::origin()] }.into())).unwrap();
    let loops =
        [[0.0, 0.0], [3.0, 3.0], [-2.0, 3.0], [1.0, 0.0]].map(|[x, y]| Point::new(x, y, 0.0)).to_vec();
    scene.add(Object::new("loop", Curve::bezier(loops).unwrap().into())).unwrap();
    let mut moved = Object::new("moved", ring.into());
    moved.parent = Some("group".into());
    scene.add(Object::new("group", Geometry::Group)).unwrap();
    scene.add(moved).unwrap();
    let mut flat = Object::new("flat", Curve::circle(Point::origin(), Vector::z(), 1.0).unwrap().into());
    flat.transform = Some(nalgebra::Matrix4::from_diagonal(&nalgebra::Vector4::new(1.0, 1.0, 0.0, 1.0)));
    scene.add(flat).unwrap();
    scene
}

fn run(scene: &mut Scene, op: &str, fields: Value) -> Result<StepReport, String> {
    let mut registry = Registry::new();
    registry.add(&Intersection);
    let operation = registry.find_operation(op, "op").unwrap().clone();
    let parameters = Parameters::new(fields, "step[0]").unwrap();
    operation.apply(scene, &parameters, &Context::quiet(&registry)).map_err(|e| e.to_string())
}

#[test]
fn wrong_fields_are_told() {
    let cases = [
        (
            "intersect",
            json!({ "object": "ring", "with": "dots" }),
            "a curve or polyline is intersected with another, or with a surface",
        ),
        ("intersect", json!({ "object": "pipe" }), "is "),
        ("intersect", json!({ "object": "ring", "with": "nobody" }), "nobody"),
        (
            "intersect",
            json!({ "object": "flat", "with": "ring" }),
            "\"flat\" is placed by a transform that flattens it, so that \"ring\" is nowhere",
        ),
        (
            "intersect",
            json!({ "object": "ring", "with": "pipe", "tolerance": 0 }),
            "0 where a positive length is needed",
        ),
        ("intersect", json!({ "object": "ring", "with": "pipe", "name": "" }), "name: is empty"),
        ("section", json!({ "object": "pipe" }), "give either plane"),
        ("section", json!({ "object": "pipe", "axis": "x" }), "axis goes with one of at and count"),
        (
            "section",
            json!({ "object": "pipe", "axis": "x", "at": 1, "count": 2 }),
            "axis goes with one of at and count",
        ),
        ("section", json!({ "object": "pipe", "axis": "x", "count": 0 }), "0 where 1 to 10000 is needed"),
        (
            "section",
            json!({ "object": "pipe", "axis": "x", "at": [] }),
            "no place is named: 1 to 10000 are needed",
        ),
        (
            "section",
            json!({ "object": "pipe", "plane": { "normal": [0, 0, 0] } }),
            "the plane has no usable normal",
        ),
        (
            "section",
            json!({ "object": "pipe", "plane": { "normal": [0, 0, 1] }, "axis": "x" }),
            "give either plane",
        ),
        (
            "section",
            json!({ "object": "dots", "axis": "x", "at": 0 }),
            "a section is cut from a brep, a surface, trimmed or not, a mesh, a curve or a polyline",
        ),
        ("section", json!({ "object": "nobody", "axis": "x", "at": 0 }), "object: "),
    ];
    for (op, fields, said) in cases {
        let mut after = scene();
        let error =
            run(&mut after, op, fields.clone()).err().unwrap_or_else(|| panic!("{op} {fields} is taken"));
        assert!(error.contains(said), "{op} {fields}: not \"{said}\" but \"{error}\"");
        assert_eq!(after, scene(), "{op} {fields}");
    }
    let ring = Curve::circle(Point::origin(), Vector::z(), 1.0).unwrap();
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = curves(&ring, &ring, &Options::within(bad)).unwrap_err();
        assert!(matches!(error, IntersectionError::Tolerance(_)), "{error}");
    }
}

#[test]
fn a_curve_meets_itself_in_the_scene() {
    let mut scene = scene();
    let report = run(&mut scene, "intersect", json!({ "object": "loop", "name": "knot" })).unwrap();
    assert!(report.notes[0].starts_with("it crosses itself at (0."), "{report:?}");
    assert_eq!(scene.object("knot").unwrap().geometry().points().len(), 1);
    let report = run(&mut scene, "intersect", json!({ "object": "ring", "with": "ring" })).unwrap();
    assert!(report.notes[0].starts_with("it does not meet itself within"), "{report:?}");
}

/// A curve that only touches a plane is not cut by it, and what the plane does not meet is said so.
#[test]
fn sections_of_a_curve_tell_touching_from_crossing() {
    for (at, said) in [
        (0.0, "it crosses the plane through (0, 0, 0) at 2 points"),
        (1.0, "it touches the plane through (1, 0, 0) at 1 point"),
        (1.5, "the plane through (1.5, 0, 0) does not meet it"),
    ] {
        let mut scene = Scene::new();
        let ring = Curve::circle(Point::origin(), Vector::z(), 1.0).unwrap();
        scene.add(Object::new("ring", ring.into())).unwrap();
        let report = run(&mut scene, "section", json!({ "object": "ring", "axis": "x", "at": at })).unwrap();
        assert_eq!(report.notes, [said]);
    }
}

/// Sections of a Brep are loops beside it, and their areas are told; so is a face that lies in the plane.
#[test]
fn sections_of_breps_and_trimmed_surfaces_are_curves_beside_them() {
    let block = Brep::block(Point::origin(), Point::new(3.0, 2.0, 1.0)).unwrap();
    let mut scene = Scene::new();
    scene.add(Object::new("block", block.into())).unwrap();
    let report = run(&mut scene, "section", json!({ "object": "block", "axis": "z", "count": 3 })).unwrap();
    let areas = report.notes.iter().filter(|note| note.ends_with("cuts 1 piece, an area of 6 m²")).count();
    assert_eq!((areas, scene.objects().len()), (3, 4), "{report:?}");
    let report = run(
        &mut scene,
        "section",
        json!({ "object": "block", "name": "top", "plane": { "point": [0, 0, 1], "normal": [0, 0, 1] } }),
    );
    let notes = report.unwrap().notes;
    assert_eq!(notes, ["face 1 lies in the plane through (0, 0, 1): not cut"]);
    // Through a vertex: what is cut was found beside it, and is no further off than that is told.
    let plane = json!({ "point": [0, 0, 0], "normal": [1, -0.5, -0.7] });
    let report =
        run(&mut scene, "section", json!({ "object": "block", "name": "corner", "plane": plane })).unwrap();
    let moved = report.notes.iter().find(|note| note.contains("passes a vertex")).unwrap();
    let moved: f64 = moved.split("was found ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    let distance = report.numbers["distance"].as_f64().unwrap();
    assert!(moved > 0.0 && moved <= 1.001 * distance && distance < 1e-5, "{moved} {report:?}");
    let sample = loftsman_kernel::conformance::sample_scene();
    let window = sample.object("window").unwrap().geometry().clone();
    scene.add(Object::new("window", window)).unwrap();
    let report = run(&mut scene, "section", json!({ "object": "window", "axis": "x", "count": 2 })).unwrap();
    let (last, others) = report.notes.split_last().unwrap();
    assert!(others.iter().all(|note| note.contains("piece")), "{report:?}");
    assert!(last.starts_with("largest distance from the surface: "), "{report:?}");
    assert!(report.numbers["distance"].is_f64() && report.residual.is_none());
}

/// What ends on another passes through nothing; what runs along a fold is told by both ways of that, and made once; rounding is told as none.
#[test]
fn ends_and_folds_are_told_as_what_they_are() {
    let line = |from: [f64; 3], to: [f64; 3]| Curve::line(Point::from(from), Point::from(to)).unwrap();
    let fold = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [1.0, 0.0, 0.0]].map(Point::from).to_vec();
    let fold = Curve::new(Space::clamped(1, &[0.0, 1.0, 2.0]).unwrap(), fold).unwrap();
    let ring = Curve::circle(Point::new(1.0, 0.0, 0.0), Vector::z(), 1.0).unwrap();
    let mut scene = Scene::new();
    for (name, curve) in [
        ("along", line([0.0, 0.0, 0.0], [5.0, 0.0, 0.0])),
        ("up", line([0.0, 0.0, 0.0], [0.0, 5.0, 0.0])),
        ("beside", line([2.5, 0.0, 0.0], [2.5, 1.0, 0.0])),
        ("through", line([2.5, -1.0, 0.0], [2.5, 1.0, 0.0])),
        ("fold", fold),
        ("ring", ring),
    ] {
        scene.add(Object::new(name, curve.into())).unwrap();
    }
    let said = |object: &str, with: &str, kind: &str, words: &str| {
        let mut after = scene.clone();
        let report =
            run(&mut after, "intersect", json!({ "object": object, "with": with, "name": "found" })).unwrap();
        assert_eq!(report.numbers["meetings"][0]["kind"], kind, "{report:?}");
        assert!(report.notes.iter().any(|n| n.contains(words)), "{report:?}");
        assert!(!report.notes.iter().any(|n| n.contains("largest distance")), "{report:?}");
    };
    said("along", "up", "ends", "they meet end on end at (0, 0, 0), parameters 0 and 0");
    said("beside", "along", "end", "one ends on the other at (2.5, 0, 0), parameters 0 and 0.5");
    said("along", "beside", "end", "one ends on the other at (2.5, 0, 0), parameters 0.5 and 0");
    said("through", "along", "cross", "they cross at (2.5, 0, 0), parameters 0.5 and 0.5");
    // A closed curve has no ends, though its parameters have.
    said("along", "ring", "end", "one ends on the other at (0, 0, 0)");
    let mut after = scene.clone();
    let report =
        run(&mut after, "intersect", json!({ "object": "along", "with": "fold", "name": "found" })).unwrap();
    let overlaps = report.numbers["overlaps"].as_array().unwrap();
    let ends = |o: &Value| [&o["from"], &o["to"], &o["with"][0], &o["with"][1]].map(|x| x.as_f64().unwrap());
    let near = |a: [f64; 4], b: [f64; 4]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
    assert_eq!(overlaps.len(), 2, "{report:?}");
    assert!(near(ends(&overlaps[0]), [0.0, 0.8, 0.0, 1.0]), "{overlaps:?}");
    assert!(near(ends(&overlaps[1]), [0.2, 0.8, 2.0, 1.0]), "{overlaps:?}");
    assert!(report.notes.iter().any(|n| n.contains("of the curve and 2 to 1 of the other")), "{report:?}");
    assert!(after.get("found").is_some() && after.get("found.001").is_none());
    let made = after.curve("found").unwrap();
    assert!((made.length(1e-9).unwrap().value - 4.0).abs() < 1e-6);
}

/// Polylines are curves of degree 1, the closed ones with their last side; what is found is told in numbers, too.
#[test]
fn polylines_are_intersected_as_curves_of_degree_one() {
    let at = |points: &[[f64; 2]]| points.iter().map(|[x, y]| Point::new(*x, *y, 0.0)).collect::<Vec<_>>();
    let square = Polyline { points: at(&[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]), closed: true };
    let cross = Polyline { points: at(&[[-1.0, 0.5], [3.0, 1.5]]), closed: false };
    let bow = Polyline { points: at(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]]), closed: false };
    let one = Polyline { points: at(&[[0.0, 0.0]]), closed: false };
    let mut scene = scene();
    for (name, line) in [("square", square), ("cross", cross), ("bow", bow), ("one", one)] {
        scene.add(Object::new(name, line.into())).unwrap();
    }
    let ring = Curve::circle(Point::new(1.0, 1.0, 0.0), Vector::z(), 1.0).unwrap();
    scene.add(Object::new("inside", ring.into())).unwrap();
    let meetings = |object: &str, with: &str| {
        let report = run(&mut scene.clone(), "intersect", json!({ "object": object, "with": with })).unwrap();
        report.numbers["meetings"].as_array().unwrap().clone()
    };
    let found = meetings("square", "cross");
    let points: Vec<[f64; 3]> =
        found.iter().map(|m| serde_json::from_value(m["point"].clone()).unwrap()).collect();
    assert_eq!(found.len(), 2, "{found:?}");
    assert!((points[0][0] - 2.0).abs() < 1e-14 && (points[0][1] - 1.25).abs() < 1e-14, "{points:?}");
    assert!(points[1][0].abs() < 1e-14 && (points[1][1] - 0.75).abs() < 1e-14, "{points:?}");
    // On the last side, which runs back to the first point, the parameter goes on from 3 to 4.
    assert!((found[1]["at"].as_f64().unwrap() - 3.625).abs() < 1e-12, "{found:?}");
    assert!((found[1]["with"].as_f64().unwrap() - 0.25).abs() < 1e-12 && found[1]["kind"] == "cross");
    let touched = meetings("square", "inside");
    assert_eq!(touched.len(), 4, "{touched:?}");
    assert!(touched.iter().all(|m| m["kind"] == "touch"), "{touched:?}");
    let own = meetings("bow", "bow");
    assert!(own.len() == 1 && own[0]["kind"] == "cross" && own[0]["distance"].as_f64().unwrap() < 1e-14);
    let refused =
        run(&mut scene.clone(), "intersect", json!({ "object": "one", "with": "ring" })).unwrap_err();
    assert!(
        refused.to_string().contains("\"one\": a polyline needs 2 points at least, and has 1"),
        "{refused}"
    );
}

/// The only object that fits need not be named; planes that differ by little are told apart.
#[test]
fn the_only_object_is_meant_and_planes_are_told_apart() {
    let mut scene = Scene::new();
    let line = Curve::line(Point::origin(), Point::new(10.0, 0.0, 0.0)).unwrap();
    scene.add(Object::new("line", line.into())).unwrap();
    let report = run(&mut scene, "section", json!({ "axis": "x", "at": [5, 5.00000001] })).unwrap();
    let places: Vec<&str> = report.notes.iter().filter_map(|note| note.split('(').nth(1)).collect();
    assert!(places.len() == 2 && places[0] != places[1], "{:?}", report.notes);
    // What is wrong with another field is said, and not that the object is missing.
    let problem = run(&mut scene, "intersect", json!({ "with": "lien" })).unwrap_err();
    assert!(problem.contains("lien") && problem.contains("line"), "{problem}");
    let other = Curve::line(Point::origin(), Point::new(0.0, 1.0, 0.0)).unwrap();
    scene.add(Object::new("other", other.into())).unwrap();
    let problem = run(&mut scene, "intersect", json!({})).unwrap_err();
    assert!(problem.contains("\"line\", \"other\""), "{problem}");
}

/// The closed section of one surface has an area, by the closed forms of a sphere and of a torus, whose inner loop takes its part away; what is open has
/// none. No number is -0.
#[test]
fn closed_sections_of_one_surface_have_an_area() {
    let half =
        Curve::arc(Point::new(0.0, 0.0, -5.0), Point::origin(), Vector::y(), std::f64::consts::PI).unwrap();
    let ball = Surface::revolution(&half, Point::origin(), Vector::z(), std::f64::consts::TAU).unwrap();
    let tube = Curve::circle(Point::new(3.0, 0.0, 0.0), Vector::y(), 1.0).unwrap();
    let ring = Surface::revolution(&tube, Point::origin(), Vector::z(), std::f64::consts::TAU).unwrap();
    let options = Options::within(1e-7);
    for z in [-0.5, 0.0, 3.0, 4.9] {
        let area = section(&ball, &plane([0.0, 0.0, z], [0.0, 0.0, -2.0]), &options).unwrap().area.unwrap();
        let expected = std::f64::consts::PI * (25.0 - z * z);
        assert!((area - expected).abs() < 1e-5, "{z}: {area} {expected}");
    }
    let area = |at: &Plane| section(&ring, at, &options).unwrap().area;
    let round = area(&plane([0.0, 0.0, 0.6], [0.0, 0.0, 1.0])).unwrap();
    assert!((round - std::f64::consts::PI * (3.8 * 3.8 - 2.2 * 2.2)).abs() < 1e-5, "{round}");
    let two = area(&plane([0.0; 3], [1.0, 0.0, 0.0])).unwrap();
    assert!((two - 2.0 * std::f64::consts::PI).abs() < 1e-5, "{two}");
    let bowl =
        Surface::revolution(&half.between(0.0, 2.0).unwrap(), Point::origin(), Vector::z(), 3.0).unwrap();
    assert_eq!(section(&bowl, &plane([0.0, 0.0, -4.0], [0.0, 0.0, 1.0]), &options).unwrap().area, None);
    let mut scene = Scene::default();
    scene.add(Object::new("ball", ball.into())).unwrap();
    let report = run(&mut scene, "section", json!({ "axis": "z", "at": [-0.0, 5] })).unwrap();
    let planes = &report.numbers["planes"];
    assert!((planes[0]["area"].as_f64().unwrap() - 25.0 * std::f64::consts::PI).abs() < 1e-3, "{planes}");
    assert!(planes[1]["area"].is_null(), "{planes}");
    assert!(!planes.to_string().contains("-0.0") && !report.notes.join(" ").contains("-0,"), "{report:?}");
}

/// A cap that is thinner than the tolerance, but whose rim is larger than that, is cut off in its circle, and one of nothing touches at its pole.
#[test]
fn thin_caps_are_cut_off_or_touched_at_their_poles() {
    let half =
        Curve::arc(Point::new(0.0, 0.0, -5.0), Point::origin(), Vector::y(), std::f64::consts::PI).unwrap();
    let ball = Surface::revolution(&half, Point::origin(), Vector::z(), std::f64::consts::TAU).unwrap();
    for thick in [1e-3_f64, 1e-5, 1e-6, 1e-7, 3e-8] {
        let cut =
            section(&ball, &plane([0.0, 0.0, 5.0 - thick], [0.0, 0.0, 1.0]), &Options::default()).unwrap();
        assert!(cut.touching.is_empty() && cut.curves.len() == 1, "{thick}: {cut:?}");
        let rim = (thick * (10.0 - thick)).sqrt();
        let curve = &cut.curves[0].curve;
        for t in curve.space().breakpoints() {
            let p = curve.point(t).unwrap();
            // The plane is moved by 1e-8, the circle by that over its slope.
            let apart = (p.x.hypot(p.y) - rim).abs();
            assert!(apart <= 1e-5 + 2e-7 / rim, "{thick}: {p} {apart}");
        }
    }
    for thick in [1e-9, 0.0, -1e-9] {
        let cut =
            section(&ball, &plane([0.0, 0.0, 5.0 - thick], [0.0, 0.0, 1.0]), &Options::default()).unwrap();
        assert!(cut.curves.is_empty() && cut.touching.len() == 1, "{thick}: {cut:?}");
        assert!((cut.touching[0] - Point::new(0.0, 0.0, 5.0)).norm() < 1e-12, "{thick}: {cut:?}");
    }
}

/// Objects that are placed otherwise meet where their points do when those are moved by hand; what comes of it is placed as the first one is.
#[test]
fn objects_meet_where_they_are_placed() {
    use nalgebra::{Matrix4, Vector3};
    let turned = Matrix4::new_translation(&Vector3::new(3.0, -1.0, 0.5))
        * Matrix4::from_euler_angles(0.3, -0.7, 1.1)
        * Matrix4::new_nonuniform_scaling(&Vector3::new(2.0, 0.5, 1.5));
    let above =
        Matrix4::new_translation(&Vector3::new(-4.0, 2.0, 1.0)) * Matrix4::from_euler_angles(-0.4, 0.2, 0.9);
    let ring = Geometry::from(Curve::circle(Point::origin(), Vector::z(), 1.0).unwrap());
    let wave = (0..9).map(|k| Point::new(0.4 * f64::from(k) - 1.6, f64::from(k % 2) - 0.5, 0.0)).collect();
    let wave = Geometry::from(Curve::new(Space::clamped_uniform(3, 9).unwrap(), wave).unwrap());
    let pipe = Surface::extrusion(
        &Curve::circle(Point::new(0.0, 0.0, -1.0), Vector::z(), 1.0).unwrap(),
        Vector::z() * 2.0,
    );
    let pipe = Geometry::from(pipe.unwrap());
    // In the world all is where it is in the coordinates of the ring: brought back by the map of the other.
    for (own, parent) in [(turned, None), (turned, Some(above)), (Matrix4::identity(), Some(above))] {
        for (with, count) in [(&ring, 0), (&pipe, 0), (&ring, 1)] {
            let whole = parent.unwrap_or_else(Matrix4::identity) * own;
            let back = whole.try_inverse().unwrap();
            let plain = |second: Geometry| {
                let mut scene = Scene::new();
                scene.add(Object::new("wave", wave.clone())).unwrap();
                scene.add(Object::new("other", second)).unwrap();
                scene
            };
            let fields = json!({ "object": "wave", "with": "other", "name": "hit" });
            let mut scene = plain(with.clone());
            let expected = run(&mut scene, "intersect", fields.clone()).unwrap();
            assert!(expected.numbers["meetings"].as_array().unwrap().len() >= 2, "{expected:?}");
            // Which of the two is placed by a transform.
            let placed = ["other", "wave"][count];
            let mut scene = plain(with.clone());
            if let Some(above) = parent {
                let mut group = Object::new("group", Geometry::Group);
                group.transform = Some(above);
                scene.add(group).unwrap();
            }
            let geometry = scene.object(placed).unwrap().geometry().transformed(&back).unwrap();
            scene.replace(placed, geometry).unwrap();
            let object = scene.object_mut(placed).unwrap();
            object.transform = Some(own);
            object.parent = parent.map(|_| "group".to_owned());
            let report = run(&mut scene, "intersect", fields).unwrap();
            assert!(report.notes.iter().any(|n| n.contains("placed otherwise")), "{report:?}");
            let list = |report: &StepReport| report.numbers["meetings"].as_array().unwrap().clone();
            let (found, expected) = (list(&report), list(&expected));
            assert_eq!(found.len(), expected.len(), "{report:?}");
            for (m, e) in found.iter().zip(&expected) {
                assert_eq!(m["kind"], e["kind"]);
                let apart = m["at"].as_f64().unwrap() - e["at"].as_f64().unwrap();
                assert!(apart.abs() < 1e-11, "{m} {e}");
            }
            // In the world they are where they are without transforms.
            let at = scene.position("hit").unwrap();
            let map = scene.world_transforms().unwrap()[at].unwrap_or_else(Matrix4::identity);
            let points = scene.object("hit").unwrap().geometry().transformed(&map).unwrap();
            for (p, e) in points.points().iter().zip(&expected) {
                let e: [f64; 3] = serde_json::from_value(e["point"].clone()).unwrap();
                assert!((p - Point::from(e)).norm() < 1e-12 * 20.0, "{p} {e:?}");
            }
        }
    }
}

/// Lines of a mesh, and polylines, are cut in points; which side of a face in the plane is cut is told.
#[test]
fn lines_are_cut_in_points_and_sides_are_told() {
    let mut scene = Scene::new();
    let points = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [2.0, 1.0], [2.0, 3.0], [1.0, 4.0], [0.0, 4.0]];
    let points: Vec<Point> = points.iter().map(|[x, y]| Point::new(*x, *y, 0.0)).collect();
    let mut mesh = Mesh::new::<[usize; 3]>(points.clone(), &[]).unwrap();
    mesh.set_lines(vec![0, 1, 2, 3, 4, 5, 6], vec![0, 3, 7]).unwrap();
    scene.add(Object::new("wires", mesh.into())).unwrap();
    scene.add(Object::new("way", Polyline { points, closed: true }.into())).unwrap();
    let mut cut = |object: &str, at: f64| {
        let name = format!("{object} {at}");
        let fields = json!({ "object": object, "axis": "x", "at": at, "name": name });
        let report = run(&mut scene, "section", fields).unwrap();
        let found = scene.get(&name).map_or(Vec::new(), |o| o.geometry().points().to_vec());
        (report.notes, found.iter().map(|p| [p.x, p.y]).collect::<Vec<_>>())
    };
    let (notes, found) = cut("wires", 0.5);
    assert_eq!(notes, ["its lines meet the plane through (0.5, 0, 0) at 2 points"]);
    assert_eq!(found, [[0.5, 0.0], [0.5, 4.0]]);
    // From (1, 0) to (1, 1) they lie in it; (1, 4) is passed once.
    let (notes, found) = cut("wires", 1.0);
    assert_eq!(found, [[1.0, 4.0]]);
    assert_eq!(notes[0], "1 part of its lines lies in the plane through (1, 0, 0): not cut");
    assert_eq!(cut("wires", 3.0).0, ["the plane through (3, 0, 0) does not meet it"]);
    let (notes, found) = cut("way", 0.5);
    assert_eq!(notes, ["it crosses the plane through (0.5, 0, 0) at 2 points"]);
    assert_eq!(found, [[0.5, 0.0], [0.5, 4.0]]);
    // A Brep is cut above its faces, a mesh below where it has something there.
    let sides = |object: Geometry, at: f64| {
        let mut scene = Scene::new();
        scene.add(Object::new("block", object)).unwrap();
        run(&mut scene, "section", json!({ "axis": "z", "at": at })).unwrap().notes.join("\n")
    };
    let block = || Geometry::from(Brep::block(Point::origin(), Point::new(3.0, 2.0, 1.0)).unwrap());
    assert!(
        sides(block(), 0.0).contains("not cut; what is cut is what lies just above it"),
        "{}",
        sides(block(), 0.0)
    );
    // Above its top there is nothing.
    assert!(
        sides(block(), 1.0).ends_with("in the plane through (0, 0, 1): not cut"),
        "{}",
        sides(block(), 1.0)
    );
    assert!(sides(cube().into(), 0.0).contains("just above it"), "{}", sides(cube().into(), 0.0));
    assert!(sides(cube().into(), 1.0).contains("just below it"), "{}", sides(cube().into(), 1.0));
    assert!(!sides(cube().into(), 0.5).contains("just"));
}

/// Of what does not meet the least distance is told: closed forms of circles, lines and a cylinder, and of waves by many places.
#[test]
fn how_near_what_does_not_meet_comes_is_told() {
    use loftsman_intersection::{gap_of_curve_and_surface, gap_of_curves};
    let ring = |center: [f64; 3], normal: Vector, radius: f64| {
        Curve::circle(Point::from(center), normal, radius).unwrap()
    };
    let line = |p: [f64; 3], q: [f64; 3]| Curve::line(Point::from(p), Point::from(q)).unwrap();
    for size in [1e-6, 1.0, 1e6] {
        let p = |x: f64, y: f64, z: f64| [x * size, y * size, z * size];
        let inner = ring(p(0.2, 0.0, 0.0), Vector::z(), size);
        for (a, b, exact) in [
            // All round as near.
            (ring(p(0.0, 0.0, 0.0), Vector::z(), 3.0 * size), ring(p(0.0, 0.0, 0.0), Vector::z(), size), 2.0),
            (ring(p(0.0, 0.0, 0.0), Vector::z(), 3.0 * size), inner.clone(), 1.8),
            (line(p(-5.0, 2.0, 0.3), p(5.0, 2.0, 0.3)), line(p(0.0, -5.0, 1.0), p(0.0, 5.0, 1.0)), 0.7),
            (line(p(-5.0, 0.0, 1.0), p(5.0, 0.0, 1.0)), line(p(-5.0, 0.0, 0.0), p(5.0, 0.0, 0.0)), 1.0),
            (line(p(3.0, 4.0, 0.0), p(9.0, 4.0, 0.0)), line(p(0.0, 0.0, 0.0), p(-1.0, 0.0, 0.0)), 5.0),
        ] {
            for (a, b) in [(&a, &b), (&b, &a)] {
                let gap = gap_of_curves(a, b).unwrap().unwrap();
                let off = gap.distance / (exact * size) - 1.0;
                assert!((-1e-12..2e-4).contains(&off), "{size} {exact}: {gap:?}");
                assert!(a.closest(gap.point).unwrap().distance < 1e-12 * 10.0 * size, "{gap:?}");
            }
        }
        let pipe = Surface::extrusion(&inner, Vector::z() * size).unwrap();
        let gap =
            gap_of_curve_and_surface(&line(p(-5.0, 3.0, 0.5), p(5.0, 3.0, 0.5)), &pipe).unwrap().unwrap();
        assert!((gap.distance / size - 2.0).abs() < 1e-3 && gap.least, "{gap:?}");
    }
    let wave = |phase: f64, height: f64| {
        let points =
            (0..400).map(|k| Point::new(0.1 * f64::from(k), (0.37 * f64::from(k) + phase).sin(), height));
        Curve::new(Space::clamped_uniform(3, 400).unwrap(), points.collect()).unwrap()
    };
    let (a, b) = (wave(0.0, 0.0), wave(0.0, 0.0).clone());
    let b =
        Curve::new(b.space().clone(), b.points().iter().map(|p| p + Vector::new(0.0, 2.5, 0.4)).collect())
            .unwrap();
    let gap = gap_of_curves(&a, &b).unwrap().unwrap();
    let (from, to) = a.domain();
    let nearest = (0..=4000)
        .map(|k| {
            b.closest(a.point((from + (to - from) * f64::from(k) / 4000.0).min(to)).unwrap())
                .unwrap()
                .distance
        })
        .fold(f64::INFINITY, f64::min);
    assert!(gap.distance <= nearest * (1.0 + 1e-3), "{gap:?} {nearest}");
    let mut scene = scene();
    let far = Curve::line(Point::new(0.0, 3.0, -1.0), Point::new(0.0, 3.0, 1.0)).unwrap();
    scene.add(Object::new("far", far.into())).unwrap();
    let report = run(&mut scene, "intersect", json!({ "object": "far", "with": "ring" })).unwrap();
    assert_eq!(report.notes[1], "the nearest places are 2 m apart, at (0, 3, 0)");
}

/// The area that a plane cuts of a cylinder below a transform that stretches: that of an ellipse, by the half axes where it stands.
#[test]
fn a_section_is_as_large_as_it_stands() {
    use nalgebra::{Matrix4, Vector3};
    let circle = Curve::circle(Point::origin(), Vector::z(), 1.0).unwrap();
    let pipe = Surface::extrusion(&circle, Vector::new(0.0, 0.0, 4.0)).unwrap();
    let mut scene = Scene::new();
    let mut object = Object::new("pipe", pipe.into());
    object.transform = Some(Matrix4::new_nonuniform_scaling(&Vector3::new(3.0, 0.5, 7.0)));
    scene.add(object).unwrap();
    let report = run(&mut scene, "section", json!({ "object": "pipe", "axis": "z", "at": 1.0 })).unwrap();
    let area = report.numbers["planes"][0]["area"].as_f64().unwrap();
    assert!((area / (1.5 * std::f64::consts::PI) - 1.0).abs() < 1e-6, "{area}");
    let told = |what: &str| report.notes.iter().any(|note| note.contains(what));
    assert!(told("an area of 4.712 m²") && told("axis and at are in its own coordinates"), "{report:?}");
}

/// What a plane cuts of a group or an instance is what it cuts of each of its parts where that stands, and nothing of what is hidden.
#[test]
fn a_group_and_an_instance_are_cut_part_by_part() {
    use loftsman_kernel::scene::{Definition, Layer};
    use nalgebra::{Matrix4, Vector3};
    let circle = Curve::circle(Point::origin(), Vector::z(), 1.0).unwrap();
    let pipe =
        || Object::new("pipe", Surface::extrusion(&circle, Vector::new(0.0, 0.0, 4.0)).unwrap().into());
    let below = |mut object: Object, parent: &str, map: Matrix4<f64>| {
        object.parent = Some(parent.into());
        object.transform = Some(map);
        object
    };
    let turn = Matrix4::from_axis_angle(&Vector::x_axis(), 0.4);
    let wide = Matrix4::new_nonuniform_scaling(&Vector3::new(3.0, 0.5, 1.0));
    let mirrored = Matrix4::new_translation(&Vector3::new(3.0, 1.0, 0.4))
        * Matrix4::new_nonuniform_scaling(&Vector3::new(-2.0, 2.0, 2.0));

    let mut scene = Scene::new();
    scene.layers.add(Layer::new("steel")).unwrap();
    scene.layers.add(Layer::new("construction").hidden()).unwrap();
    let mut part = Definition::new("part");
    part.add(below(pipe(), "rig", wide)).unwrap();
    part.add(Object::new("rig", Geometry::Group)).unwrap();
    part.add(Object::new("cube", cube().into())).unwrap();
    scene.define(part).unwrap();
    let mut whole = Object::new("whole", Geometry::Group);
    whole.transform =
        Some(Matrix4::new_translation(&Vector3::new(0.0, 0.0, 70.0)) * Matrix4::new_scaling(3.0));
    scene.add(whole).unwrap();
    scene.add(below(Object::new("first", Geometry::Instance("part".into())), "whole", turn)).unwrap();
    let mut second = below(Object::new("second", Geometry::Instance("part".into())), "first", mirrored);
    second.layer = Some("steel".into());
    scene.add(second).unwrap();
    let mut unseen = below(pipe().renamed("unseen"), "whole", Matrix4::identity());
    unseen.layer = Some("construction".into());
    scene.add(unseen).unwrap();
    scene.add(pipe().renamed("beside")).unwrap();

    // The same one by one: each part moved to where it is in the group, so that all its numbers are in that one's coordinates.
    let parts = [
        ("first/pipe", turn * wide, false),
        ("first/cube", turn, true),
        ("second/pipe", turn * mirrored * wide, false),
        ("second/cube", turn * mirrored, true),
    ];
    let plane = json!({ "point": [0.1, 0.2, 1.1], "normal": [0.1, -0.2, 1.0] });
    let (mut area, mut lengths) = (0.0, Vec::new());
    for (name, map, is_cube) in &parts {
        let mut alone = Scene::new();
        let geometry = if *is_cube { Geometry::from(cube()) } else { pipe().geometry().clone() };
        alone.add(Object::new(*name, geometry.transformed(map).unwrap())).unwrap();
        let report = run(&mut alone, "section", json!({ "plane": plane, "tolerance": 1e-8 })).unwrap();
        let found = &report.numbers["planes"][0];
        area += found["area"].as_f64().unwrap_or(0.0);
        let pieces = alone.objects()[1..].iter().map(|o| o.geometry().clone());
        lengths.extend(pieces.map(|piece| (format!("whole section {name}"), size_of_piece(&piece))));
    }
    assert!(lengths.len() >= 3 && area > 1.0, "{lengths:?} {area}");

    let known = scene.objects().len();
    let mut all = scene.clone();
    let report =
        run(&mut all, "section", json!({ "object": "whole", "plane": plane, "tolerance": 1e-8 })).unwrap();
    let found = &report.numbers["planes"][0];
    let told = found["area"].as_f64().unwrap();
    // Lengths are three times as long where the group stands.
    assert!((told / (9.0 * area) - 1.0).abs() < 1e-6, "{told} {area}");
    assert_eq!(found["pieces"], lengths.len());
    assert_eq!(found["parts"].as_array().unwrap().len(), lengths.len());
    let added: Vec<(String, f64)> =
        all.objects()[known..].iter().map(|o| (o.name().to_owned(), size_of_piece(o.geometry()))).collect();
    for ((name, size), (expected, other)) in added.iter().zip(&lengths) {
        assert!(name == expected && (size / other - 1.0).abs() < 1e-6, "{added:?} {lengths:?}");
    }
    for object in &all.objects()[known..] {
        assert_eq!(object.transform, all.object("whole").unwrap().transform);
        assert_eq!(object.layer.as_deref(), object.name().contains("second").then_some("steel"));
    }
    let note = format!("cuts {} pieces of {} parts", lengths.len(), lengths.len());
    assert!(report.notes.iter().any(|n| n.contains(&note)), "{:?}", report.notes);

    // An instance shows its own parts alone, called by what is within it.
    let mut one = scene.clone();
    let report = run(&mut one, "section", json!({ "object": "second", "axis": "z", "count": 3 })).unwrap();
    assert_eq!(report.numbers["planes"].as_array().unwrap().len(), 3);
    let names: Vec<&str> = one.objects()[known..].iter().map(Object::name).collect();
    assert!(names.contains(&"second section pipe") && names.contains(&"second section cube"), "{names:?}");

    // Which is meant must be said where there are several, groups and instances among them; a single one need not be named.
    let mut several = scene.clone();
    let error = run(&mut several, "section", json!({ "axis": "z", "at": 1 })).unwrap_err();
    assert!(["whole", "first", "second", "beside"].iter().all(|name| error.contains(name)), "{error}");
    for name in ["whole", "first", "unseen", "beside"] {
        several.remove(name).unwrap();
    }
    let report = run(&mut several, "section", json!({ "axis": "z", "count": 3 })).unwrap();
    assert_eq!(report.numbers["planes"].as_array().unwrap().len(), 3);

    // What shows nothing, or nothing that is seen.
    let mut hidden = scene.clone();
    hidden.object_mut("first").unwrap().layer = Some("construction".into());
    hidden.object_mut("second").unwrap().layer = Some("construction".into());
    let error = run(&mut hidden, "section", json!({ "object": "whole", "axis": "z", "at": 1 })).unwrap_err();
    assert!(error.contains("\"whole\" shows no brep") && error.contains("hidden layers"), "{error}");
    scene.add(Object::new("empty", Geometry::Group)).unwrap();
    let error = run(&mut scene, "section", json!({ "object": "empty", "axis": "z", "at": 1 })).unwrap_err();
    assert!(error.contains("\"empty\" shows no brep") && !error.contains("hidden"), "{error}");
    // Nothing is added where one part cannot be cut.
    let flat = Matrix4::new_nonuniform_scaling(&Vector3::new(1.0, 1.0, 0.0));
    scene.object_mut("second").unwrap().transform = Some(flat);
    let count = scene.objects().len();
    let error = run(&mut scene, "section", json!({ "object": "whole", "axis": "z", "at": 1 })).unwrap_err();
    assert!(error.contains("second/pipe") && error.contains("flattens it"), "{error}");
    assert_eq!(scene.objects().len(), count);
}

/// The length of a curve by chords, or of a polyline.
fn size_of_piece(geometry: &Geometry) -> f64 {
    let points: Vec<Point> = match geometry {
        Geometry::Curve(curve) => {
            let (a, b) = curve.domain();
            (0..=4000).map(|k| curve.point((a + (b - a) * f64::from(k) / 4000.0).min(b)).unwrap()).collect()
        }
        other => other.points().to_vec(),
    };
    points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}

/// Where no object is named: a polyline beside the only shape is not cut, which is said; groups count where they show something to cut.
#[test]
fn what_is_cut_where_nothing_is_named_is_told() {
    let run = |objects: &[(&str, &str)]| {
        let mut scene = Scene::new();
        for &(name, parent) in objects {
            let line = || vec![Point::new(-1.0, 0.0, 0.0), Point::new(1.0, 1.0, 0.0)];
            let geometry: Geometry = match &name[..1] {
                "c" if !name.ends_with("section") => Curve::line(line()[0], line()[1]).unwrap().into(),
                "c" | "p" => Polyline { points: line(), closed: false }.into(),
                _ => Geometry::Group,
            };
            let mut object = Object::new(name, geometry);
            object.parent = (!parent.is_empty()).then(|| parent.to_owned());
            scene.add(object).unwrap();
        }
        let mut registry = Registry::new();
        registry.add(&Intersection);
        let operation = registry.find_operation("section", "op").unwrap().clone();
        let parameters = Parameters::new(json!({ "axis": "x", "at": 0.5 }), "step[0]").unwrap();
        let found = operation.apply(&mut scene, &parameters, &Context::quiet(&registry));
        found.map(|report| (report.object.unwrap(), report.notes.join("; "))).map_err(|e| e.to_string())
    };
    let (object, notes) = run(&[("p", ""), ("c", "")]).unwrap();
    assert!(object == "c" && notes.contains("only \"c\" is cut") && notes.contains("\"p\""), "{notes}");
    let (object, notes) = run(&[("g", ""), ("p", "g"), ("c", "g")]).unwrap();
    assert!(object == "c" && notes.contains("\"p\""), "{object}: {notes}");
    let (object, notes) = run(&[("c", ""), ("c section", "")]).unwrap();
    assert!(object == "c" && !notes.contains("only"), "{notes}");
    let (object, notes) = run(&[("p", "")]).unwrap();
    assert!(object == "p" && !notes.contains("only"), "{notes}");
    // An empty group is nothing to choose.
    let error = run(&[("g", ""), ("c", ""), ("c2", "")]).unwrap_err();
    assert!(error.contains("\"c\", \"c2\"") && !error.contains("\"g\""), "{error}");
    let error = run(&[("g", ""), ("g2", "g"), ("c", "g2"), ("c2", "")]).unwrap_err();
    assert!(error.contains("\"g\", \"g2\", \"c\", \"c2\""), "{error}");
}

/// The second loop of a part does not get the name of another part: `cut box.001` would be of "box.001".
#[test]
fn loops_are_not_called_like_other_objects() {
    let mut scene = Scene::new();
    scene.add(Object::new("rig", Geometry::Group)).unwrap();
    for name in ["box", "box.001"] {
        let mut object = Object::new(name, cube().into());
        object.parent = (name == "box").then(|| "rig".to_owned());
        scene.add(object).unwrap();
    }
    let mut registry = Registry::new();
    registry.add(&Intersection);
    let operation = registry.find_operation("section", "op").unwrap().clone();
    let mut run = |fields: Value| {
        let parameters = Parameters::new(fields, "step[0]").unwrap();
        operation.apply(&mut scene, &parameters, &Context::quiet(&registry)).unwrap();
        scene.objects().iter().map(|o| o.name().to_owned()).collect::<Vec<String>>()
    };
    let names = run(json!({ "object": "rig", "axis": "y", "count": 3, "name": "cut" }));
    assert_eq!(names[3..], ["cut box", "cut box (2)", "cut box (3)"]);
    // Where nothing is meant by it, they are numbered as ever.
    let names = run(json!({ "object": "box.001", "axis": "y", "count": 2, "name": "turned" }));
    assert_eq!(names[6..], ["turned", "turned.001"]);
}
