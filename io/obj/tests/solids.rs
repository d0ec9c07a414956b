//! Breps and trimmed surfaces: as meshes, whose faces can be told apart, and exactly where OBJ has them.

#![allow(clippy::unwrap_used, reason = "a test may stop at what should not be")]

use std::collections::BTreeMap;

use loftsman_kernel::Point;
use loftsman_kernel::brep::{Brep, Face, SurfaceForm};
use loftsman_kernel::mesh::{FaceGroup, Mesh};
use loftsman_kernel::plugin::{
    Chord, Fate, Fineness, Format, Memory, Parameters, ReadOptions, UpChoice, WriteOptions, WriteReport,
};
use loftsman_kernel::scene::{Geometry, Object, Scene};
use loftsman_kernel::spline::{Space, Surface};
use loftsman_obj::Obj;
use loftsman_tessellation::Adaptive;
use nalgebra::Matrix4;

fn write(scene: &Scene, surfaces: &str) -> (Memory, WriteReport) {
    let mut file = Memory::new("part.obj", "");
    let options = WriteOptions {
        up: UpChoice::Keep,
        tessellator: Some(&Adaptive { budget: 100_000 }),
        fineness: Fineness { chord: Chord::Absolute(0.01), angle: 0.3 },
        own: Parameters::new(serde_json::json!({ "surfaces": surfaces }), "options").unwrap(),
        ..WriteOptions::default()
    };
    let report = Obj.write(scene, &mut file, &options).unwrap();
    (file, report)
}

fn read(file: &Memory) -> Scene {
    let (scene, report) = Obj.read(file, &ReadOptions::default()).unwrap();
    assert!(report.adds_up() && report.left_out.is_empty(), "{report:?}");
    scene
}

fn mesh(scene: &Scene, name: &str) -> Mesh {
    let Geometry::Mesh(mesh) = scene.object(name).unwrap().geometry() else { unreachable!("{name}") };
    mesh.clone()
}

/// A block of 3 by 2 by 1 of which two faces are red and one blue, one of them with a name.
fn painted() -> Brep {
    let mut parts = Brep::block(Point::origin(), Point::new(3.0, 2.0, 1.0)).unwrap().parts();
    for (face, color) in [(0, [1.0, 0.0, 0.0, 1.0]), (3, [0.0, 0.0, 1.0, 0.5]), (5, [1.0, 0.0, 0.0, 1.0])] {
        parts.faces[face].color = Some(color);
    }
    parts.faces[3].name = Some("long side".into());
    Brep::new(parts).unwrap()
}

fn one(name: &str, geometry: Geometry) -> Scene {
    let mut scene = Scene::new();
    scene.add(Object::new(name, geometry)).unwrap();
    scene
}

/// Six times the volume inside, and how often each edge is run through one way and not the other.
fn volume(mesh: &Mesh) -> f64 {
    let mut open: BTreeMap<[u32; 2], i32> = BTreeMap::new();
    let mut sum = 0.0;
    for face in mesh.faces() {
        let [a, b, c] = [0, 1, 2].map(|k| mesh.points()[face[k] as usize].coords);
        sum += a.dot(&b.cross(&c)) / 6.0;
        for k in 0..3 {
            let (a, b) = (face[k], face[(k + 1) % 3]);
            *open.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
        }
    }
    assert!(open.values().all(|&turns| turns == 0), "not watertight");
    sum
}

#[test]
fn a_solid_is_a_watertight_mesh_whose_faces_are_groups_and_have_their_colours() {
    let mut scene = one("part", painted().into());
    let moves = Matrix4::new_nonuniform_scaling(&nalgebra::Vector3::new(-1.0, 2.0, 1.0));
    for (color, transform, full) in
        [(None, None, 6.0), (Some([0.0, 1.0, 0.0, 1.0]), None, 6.0), (None, Some(moves), 12.0)]
    {
        let object = scene.object_mut("part").unwrap();
        (object.color, object.transform) = (color, transform);
        for surfaces in ["both", "mesh"] {
            let (file, report) = write(&scene, surfaces);
            let written = &report.objects[0];
            assert_eq!((written.fate, written.form.as_str()), (Fate::Approximated, "12 triangles"));
            assert_eq!(written.reason.as_deref(), Some("the brep was tessellated"));
            assert!(written.error.unwrap() <= written.tolerance.unwrap());
            let back = read(&file);
            let mesh = mesh(&back, "part");
            // Mirrored, it is still seen from outside.
            assert!((volume(&mesh) - full).abs() < 1e-12);
            let groups: Vec<(&str, usize)> =
                mesh.groups.iter().map(|g| (g.name.as_str(), g.faces.len())).collect();
            let names = ["face_0", "face_1", "face_2", "face_3_long_side", "face_4", "face_5"];
            assert_eq!(groups, names.map(|name| (name, 2)));
            assert!(report.notes.is_empty(), "{:?}", report.notes);
            let looks: Vec<[f64; 4]> = back
                .object("part")
                .unwrap()
                .materials
                .iter()
                .map(|name| back.materials.get(name).unwrap().base_color)
                .collect();
            let of = |face: usize| mesh.materials[2 * face] as usize;
            assert_eq!(looks[of(0)], [1.0, 0.0, 0.0, 1.0]);
            assert_eq!((looks[of(3)], of(5)), ([0.0, 0.0, 1.0, 0.5], of(0)));
            assert!(of(1) == of(2) && of(1) != of(0) && of(1) == of(4));
            if let Some(color) = color {
                assert_eq!(looks[of(1)], color);
            }
        }
    }
}

/// What comes behind the faces of a solid is in none of their groups: its own names come back, with nothing left out.
#[test]
fn what_follows_a_solid_is_in_none_of_its_groups() {
    let sample = loftsman_kernel::conformance::sample_scene();
    let kinds = ["curve", "surface", "trimmed", "mesh", "polyline", "cloud"];
    let mut seen = std::collections::BTreeSet::new();
    for surfaces in ["both", "exact", "mesh"] {
        for object in sample.objects().iter().filter(|o| kinds.contains(&o.geometry().kind())) {
            let mut scene = one("part", painted().into());
            let mut grouped = triangle();
            grouped.groups = vec![FaceGroup { name: "side".into(), faces: vec![0] }];
            scene.add(Object::new("patch", grouped.into())).unwrap();
            scene.add(Object::new("rib", object.geometry().clone())).unwrap();
            let (file, _) = write(&scene, surfaces);
            let (back, report) = Obj.read(&file, &ReadOptions::default()).unwrap();
            let rib =
                back.object("rib").unwrap_or_else(|_| panic!("{surfaces} {}", object.geometry().kind()));
            let (told, kept) = (report.left_out.keys(), rib.geometry().kind());
            assert!(report.left_out.keys().all(|why| !why.contains("group")), "{surfaces} {kept}: {told:?}");
            if let Geometry::Mesh(mesh) = rib.geometry() {
                let own = if let Geometry::Mesh(mesh) = object.geometry() { mesh.groups.len() } else { 0 };
                assert_eq!(mesh.groups.len(), own, "{surfaces}");
            }
            let second = write(&back, surfaces).0;
            let third = write(&read(&second), surfaces).0;
            assert_eq!(String::from_utf8_lossy(&second.bytes), String::from_utf8_lossy(&third.bytes));
            seen.insert(object.geometry().kind());
        }
    }
    assert_eq!(seen.len(), kinds.len(), "{seen:?}");
}

/// Lines of a mesh are in no group of its faces.
#[test]
fn lines_behind_faces_are_in_none_of_their_groups() {
    let mut mesh = triangle();
    mesh.groups = vec![FaceGroup { name: "side".into(), faces: vec![0] }];
    mesh.set_lines(vec![0, 1, 2], vec![0, 3]).unwrap();
    let (file, _) = write(&one("part", mesh.clone().into()), "both");
    let (back, report) = Obj.read(&file, &ReadOptions::default()).unwrap();
    assert!(report.left_out.is_empty(), "{:?}", report.left_out);
    let Geometry::Mesh(found) = back.objects()[0].geometry() else { panic!("no mesh") };
    assert_eq!((&found.groups, found.lines().count()), (&mesh.groups, 1));
}

fn triangle() -> Mesh {
    let points = [[0.0, 0.0, 9.0], [1.0, 0.0, 9.0], [0.0, 1.0, 9.0]].map(Point::from);
    Mesh::new(points.to_vec(), &[vec![0, 1, 2]]).unwrap()
}

#[test]
fn exactly_there_is_no_brep() {
    let (file, report) = write(&one("part", painted().into()), "exact");
    let written = &report.objects[0];
    assert_eq!(written.fate, Fate::LeftOut);
    assert_eq!(written.reason.as_deref(), Some("OBJ has no brep, and only exact surfaces were asked for"));
    assert!(!String::from_utf8(file.bytes).unwrap().contains("\nf "));
    assert!(report.losses.iter().any(|loss| loss == "brep is left out (1)"), "{:?}", report.losses);
    let mut file = Memory::new("part.obj", "");
    let report = Obj.write(&one("part", painted().into()), &mut file, &WriteOptions::default()).unwrap();
    assert!(report.objects[0].reason.as_ref().unwrap().contains("none is registered"));
}

/// A face that is a point cannot be cut: the others go out, and the report says which is missing.
#[test]
fn a_face_that_cannot_be_cut_is_named() {
    let mut parts = painted().parts();
    let line = || Space::clamped(1, &[0.0, 1.0]).unwrap();
    parts.faces.push(Face {
        name: Some("speck".into()),
        color: None,
        surface: Surface::new(line(), line(), vec![Point::new(1.0, 1.0, 1.0); 4]).unwrap(),
        form: SurfaceForm::Spline,
        reversed: false,
        loops: vec![],
        points: vec![],
    });
    let (file, report) = write(&one("part", Brep::new(parts).unwrap().into()), "both");
    let written = &report.objects[0];
    assert_eq!((written.fate, written.form.as_str()), (Fate::Approximated, "12 triangles"));
    let reason = written.reason.as_ref().unwrap();
    assert!(
        reason.contains("1 of 7 faces could not be cut and are left out (face 6 \"speck\": "),
        "{reason}"
    );
    assert!((volume(&mesh(&read(&file), "part")) - 6.0).abs() < 1e-12);
}

#[test]
fn trimmed_surfaces_are_one_object_with_the_mesh_that_shows_them() {
    let sample = loftsman_kernel::conformance::sample_scene();
    let window = sample.object("window").unwrap().geometry();
    let scene = one("window", window.clone());
    let (file, report) = write(&scene, "both");
    let written = &report.objects[0];
    assert_eq!(written.fate, Fate::Kept);
    assert!(written.form.starts_with("trimmed surface of 2 loops (surf) beside "), "{}", written.form);
    assert!(written.error.unwrap() <= 0.01);
    let back = read(&file);
    assert_eq!(back.objects().len(), 1);
    assert_eq!(back.object("window").unwrap().geometry(), window);
    // Other programs see the mesh; where one has moved a vertex of it, both are read.
    let text = String::from_utf8(file.bytes).unwrap();
    let moved = text.replacen("\nv ", "\nv 1", 1);
    assert_eq!(read(&Memory::new("moved.obj", moved)).objects().len(), 2);
    // So it is where one has filled the hole of the surface; a special curve bounds nothing.
    let without = |word: &str| -> String {
        let lines: Vec<&str> = text.lines().filter(|line| !line.starts_with(word)).collect();
        assert!(lines.len() < text.lines().count(), "{word}");
        lines.join("\n")
    };
    for (word, expected) in [("hole ", 2), ("scrv ", 1)] {
        let (back, _) = Obj.read(&Memory::new("part.obj", without(word)), &ReadOptions::default()).unwrap();
        assert_eq!(back.objects().len(), expected, "{word}");
    }
    let (file, report) = write(&scene, "mesh");
    assert_eq!(report.objects[0].reason.as_deref(), Some("the surface was tessellated"));
    assert!(mesh(&read(&file), "window").face_count() > 2);
    let (file, report) = write(&scene, "exact");
    assert!(report.objects[0].tolerance.is_none());
    assert_eq!(read(&file).object("window").unwrap().geometry(), window);
}
