//! Vertices of a mesh in one place made one by `subdivide`, as far as they can be.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests may fail the test")]

use std::collections::BTreeSet;

use loftsman_kernel::Point;
use loftsman_kernel::mesh::{Layer, Mesh};
use loftsman_kernel::scene::{Geometry, Object, Scene};
use loftsman_kernel::shape::{Derivative, Location, Shape};
use loftsman_subdivision::Cage;
use loftsman_subdivision::catmull_clark::limit_points;
use serde_json::json;

use crate::operation::{run, scene};

/// A mesh whose vertices are split by face, as files have them that keep normals by vertex, is one cage when it is welded: that of the mesh itself.
#[test]
fn vertices_in_one_place_are_welded() {
    let whole = scene();
    let Geometry::Mesh(cube) = whole.object("cube").unwrap().geometry() else { panic!("a mesh") };
    let points: Vec<Point> = cube.corners().iter().map(|&v| cube.points()[v as usize]).collect();
    let faces: Vec<Vec<usize>> = cube.starts().windows(2).map(|w| (w[0]..w[1]).collect()).collect();
    let mut split = Mesh::new(points.clone(), &faces).unwrap();
    split.uvs = Layer::per_point((0..points.len()).map(|k| [k as f64, 0.5]).collect());
    let mut all = scene();
    all.replace("cube", Geometry::Mesh(split)).unwrap();
    let mut apart = all.clone();
    let report = run(&mut apart, json!({ "object": "cube" })).unwrap();
    assert!(report.notes[0].contains("weld = true"), "{report:?}");
    let report = run(&mut all, json!({ "object": "cube", "weld": true })).unwrap();
    assert!(
        report.notes[0].contains("16 vertices are made one with another in the same place"),
        "{report:?}"
    );
    let mut plain = scene();
    run(&mut plain, json!({ "object": "cube" })).unwrap();
    let sorted = |scene: &Scene| {
        let Geometry::Mesh(mesh) = scene.object("cube").unwrap().geometry() else { panic!("a mesh") };
        let mut all: Vec<[f64; 3]> = mesh.points().iter().map(|p| [p.x, p.y, p.z]).collect();
        all.sort_by(|a, b| a.partial_cmp(b).unwrap());
        (all, mesh.face_count(), mesh.uvs.values().len())
    };
    let ((own, faces, uvs), (expected, count, _)) = (sorted(&all), sorted(&plain));
    assert_eq!((own.len(), faces), (expected.len(), count));
    let off = own.iter().zip(&expected).flat_map(|(a, b)| (0..3).map(move |k| (a[k] - b[k]).abs()));
    assert!(off.fold(0.0, f64::max) < 1e-15);
    assert!(uvs > 0 && sorted(&apart).0.len() > own.len());
}

const CUBE: [[usize; 4]; 6] =
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

/// The corners of two cubes that touch in one.
fn touching() -> (Vec<Point>, Vec<Vec<usize>>) {
    let corner = |k: usize| Point::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
    let one = (0..8).map(corner);
    let other = one.clone().map(|p| Point::new(1.0 + p.x, 1.0 + p.y, 1.0 + p.z));
    let faces = (0..2).flat_map(|k| CUBE.iter().map(move |face| face.iter().map(|v| v + 8 * k).collect()));
    (one.chain(other).collect(), faces.collect())
}

fn of(mesh: Mesh) -> Scene {
    let mut scene = Scene::new();
    scene.add(Object::new("cage", Geometry::Mesh(mesh))).unwrap();
    scene
}

fn surface(scene: &Scene) -> &dyn Shape {
    scene.object("cage").unwrap().geometry().shape().unwrap()
}

/// Every face with vertices of its own, as files have them that keep normals by vertex.
fn split(points: &[Point], faces: &[Vec<usize>]) -> Mesh {
    let corners: Vec<Point> = faces.iter().flatten().map(|&v| points[v]).collect();
    let mut next = 0..;
    let own: Vec<Vec<usize>> =
        faces.iter().map(|f| f.iter().map(|_| next.next().unwrap()).collect()).collect();
    Mesh::new(corners, &own).unwrap()
}

/// Where two fans of faces end in one place, each keeps a vertex there, and all else is made one: the limit is that of the two cubes.
#[test]
fn fans_keep_vertices_of_their_own() {
    let (points, faces) = touching();
    let limits = limit_points(&Cage::new(points.clone(), &faces).unwrap()).unwrap();
    let joined: Vec<Vec<usize>> =
        faces.iter().map(|f| f.iter().map(|&v| if v == 8 { 7 } else { v }).collect()).collect();
    // As it is, every face by itself, and with one vertex for both cubes.
    let meshes = [
        (Mesh::new(points.clone(), &faces).unwrap(), "; no vertex is made one with another", "7 and 15"),
        (split(&points, &faces), "; 32 vertices are made one with another", "6 and 15"),
        (split(&points, &joined), "; 32 vertices are made one with another", "6 and 15"),
    ];
    for (mesh, merged, numbers) in meshes {
        let mut all = of(mesh);
        let report = run(&mut all, json!({ "object": "cage", "surface": true, "weld": true })).unwrap();
        let note = &report.notes[0];
        assert!(note.contains(merged), "{note}");
        let apart = format!(
            "at 1 place vertices stay apart, for one would join several fans of faces there: {numbers} at [1, 1, 1]"
        );
        assert!(note.contains(&apart) && !note.contains("weld = true"), "{note}");
        let surface = surface(&all);
        assert_eq!(surface.control_vertices().len(), 16);
        // Each is one of the cubes' vertices, and none is twice.
        let mut found = BTreeSet::new();
        for (v, p) in surface.control_vertices().iter().enumerate() {
            let own = surface.value(Location::Vertex(v as u32), Derivative::POSITION).unwrap();
            found.extend((0..16).find(|&k| points[k] == *p && (own - limits[k].coords).norm() < 1e-15));
        }
        assert_eq!(found.len(), 16);
    }
}

/// What is said where nothing was asked for is true: welding mends what it says it does.
#[test]
fn advice_is_true() {
    let (points, faces) = touching();
    let fields = |weld: bool| json!({ "object": "cage", "surface": true, "weld": weld });
    // Two vertices that cannot be one.
    let report = run(&mut of(Mesh::new(points.clone(), &faces).unwrap()), fields(false)).unwrap();
    let told = "vertices 7 and 8 are in one place: they stay apart, for one vertex would join several fans of faces there";
    assert!(report.notes[0].contains(told) && !report.notes[0].contains("weld = true"), "{report:?}");
    // Many that can, and these two.
    let report = run(&mut of(split(&points, &faces)), fields(false)).unwrap();
    let told = "weld = true makes those one that join no several fans of faces";
    assert!(report.notes[0].contains(told), "{report:?}");
    // One vertex of two fans.
    let joined: Vec<Vec<usize>> =
        faces.iter().map(|f| f.iter().map(|&v| if v == 8 { 7 } else { v }).collect()).collect();
    let mut used = points.clone();
    used.remove(8);
    let joined: Vec<Vec<usize>> =
        joined.iter().map(|f| f.iter().map(|&v| if v > 8 { v - 1 } else { v }).collect()).collect();
    let bow = Mesh::new(used, &joined).unwrap();
    let error = run(&mut of(bow.clone()), fields(false)).unwrap_err().to_string();
    assert!(error.contains("vertex 7 joins several fans") && error.contains("weld = true does"), "{error}");
    let report = run(&mut of(bow), fields(true)).unwrap();
    assert!(report.notes[0].contains("7 and 15 at [1, 1, 1]"), "{report:?}");
    // Faces that look to different sides no welding mends.
    let corner = |k: usize| Point::new((k % 3) as f64, (k / 3) as f64, 0.0);
    let odd = Mesh::new((0..6).map(corner).collect(), &[[0, 1, 4, 3], [5, 4, 1, 2]]).unwrap();
    run(&mut of(odd.clone()), fields(false)).unwrap();
    let turned = Mesh::new((0..6).map(corner).collect(), &[[0, 1, 4, 3], [1, 4, 5, 2]]).unwrap();
    for weld in [false, true] {
        let error = run(&mut of(turned.clone()), fields(weld)).unwrap_err().to_string();
        assert!(error.contains("the edge between vertices 1 and 4") && !error.contains("weld"), "{error}");
    }
}

/// Three leaves of a book and one: an edge of three faces cannot be, and leaves that hang together by vertices of their own stay so.
#[test]
fn edges_of_three_faces_come_apart() {
    let mut points = vec![[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    let mut faces = Vec::new();
    for leaf in 0..3 {
        let (sin, cos) = (2.0 * f64::from(leaf)).sin_cos();
        points.extend([[cos, sin, 0.0], [cos, sin, 1.0]]);
        let first = 2 + 2 * leaf as usize;
        faces.push(vec![0, first, first + 1, 1]);
    }
    // The second leaf runs the edge the other way.
    faces[1].reverse();
    let points: Vec<Point> = points.into_iter().map(Point::from).collect();
    let fields = |weld: bool| json!({ "object": "cage", "surface": true, "weld": weld });
    let book = Mesh::new(points.clone(), &faces).unwrap();
    let error = run(&mut of(book.clone()), fields(false)).unwrap_err().to_string();
    assert!(error.contains("has 3 faces") && error.contains("weld = true does"), "{error}");
    let mut all = of(book);
    let report = run(&mut all, fields(true)).unwrap();
    let told = "at 2 places vertices stay apart, for one would join several fans of faces there: 0, 9 and 10, the first of them, at [0, 0, 0]";
    assert!(report.notes[0].contains(told), "{report:?}");
    assert_eq!(surface(&all).control_vertices().len(), 12);
    // Two leaves with vertices of their own are one sheet, and the third beside it.
    let (mut own, mut sheet) = (points.clone(), faces.clone());
    own.extend([points[0], points[1]]);
    sheet[2] = vec![8, 6, 7, 9];
    let mut all = of(Mesh::new(own, &sheet).unwrap());
    let report = run(&mut all, fields(true)).unwrap();
    assert!(report.notes[0].contains("0 and 8, the first of them, at [0, 0, 0]"), "{report:?}");
    assert_eq!(surface(&all).control_vertices().len(), 10);
}
