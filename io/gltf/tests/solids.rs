//! Breps and trimmed surfaces: triangles for all, faces' own colours, and the exact trimmed surface for Loftsman.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may stop at what should not be")]

use loftsman_gltf::Gltf;
use loftsman_kernel::Point;
use loftsman_kernel::brep::{Brep, Face, SurfaceForm};
use loftsman_kernel::plugin::{Fate, Format, Memory, Parameters, ReadOptions, WriteOptions, WriteReport};
use loftsman_kernel::scene::{Animation, Definition, Geometry, Object, Scene, Unit, Up};
use loftsman_kernel::spline::{Space, Surface};
use loftsman_tessellation::Adaptive;
use nalgebra::{Matrix4, Vector3};
use serde_json::{Value, json};

fn write(scene: &Scene, own: Value) -> (Memory, Value, WriteReport) {
    let tessellator = Adaptive::default();
    let options = WriteOptions {
        tessellator: Some(&tessellator),
        own: Parameters::new(own, "options").unwrap(),
        ..WriteOptions::default()
    };
    let mut file = Memory::new("s.gltf", "");
    let report = Gltf.write(scene, &mut file, &options).unwrap();
    let json = serde_json::from_slice(&file.bytes).unwrap();
    (file, json, report)
}

fn read(file: &Memory) -> Scene {
    let (scene, report) = Gltf.read(file, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    assert!(report.adds_up());
    scene
}

const RED: [f64; 4] = [1.0, 0.0, 0.0, 1.0];
const GLASS: [f64; 4] = [0.0, 0.0, 1.0, 0.5];

/// A block of 3 by 2 by 1 of which two faces are red and one is of blue glass.
fn painted() -> Brep {
    let mut parts = Brep::block(Point::origin(), Point::new(3.0, 2.0, 1.0)).unwrap().parts();
    for (face, color) in [(0, RED), (3, GLASS), (5, RED)] {
        parts.faces[face].color = Some(color);
    }
    Brep::new(parts).unwrap()
}

fn one(geometry: impl Into<Geometry>) -> Scene {
    let mut scene = Scene::new();
    (scene.unit, scene.up) = (Unit::Metre, Up::Y);
    scene.add(Object::new("part", geometry.into())).unwrap();
    scene
}

/// The volume inside the triangles of the objects of a scene, where its transforms put them.
fn volume(scene: &Scene) -> f64 {
    let world = scene.world_transforms().unwrap();
    let mut sum = 0.0;
    for (object, map) in scene.objects().iter().zip(world) {
        let Geometry::Mesh(mesh) = object.geometry() else { continue };
        let map = map.unwrap_or_else(Matrix4::identity);
        let det = map.fixed_view::<3, 3>(0, 0).determinant();
        for face in mesh.faces() {
            let [a, b, c] = [0, 1, 2].map(|k| map.transform_point(&mesh.points()[face[k] as usize]).coords);
            // A mirrored node turns its triangles round.
            sum += det.signum() * a.dot(&b.cross(&c)) / 6.0;
        }
    }
    sum
}

#[test]
fn faces_of_one_colour_are_a_primitive_and_the_others_look_as_the_object() {
    let mut scene = one(painted());
    for color in [None, Some([0.0, 1.0, 0.0, 1.0])] {
        scene.object_mut("part").unwrap().color = color;
        let (file, json, report) = write(&scene, json!({}));
        let written = &report.objects[0];
        assert_eq!((written.fate, written.form.as_str()), (Fate::Approximated, "12 triangles"));
        assert_eq!(written.reason.as_deref(), Some("the brep became triangles"));
        let primitives = json["meshes"][0]["primitives"].as_array().unwrap();
        let look = |primitive: &Value| {
            // What has no colour has no material.
            let material = primitive.get("material").and_then(Value::as_u64);
            let material = material.map_or(&Value::Null, |index| &json["materials"][index as usize]);
            let count = json["accessors"][primitive["indices"].as_u64().unwrap() as usize]["count"].as_u64();
            (
                material["pbrMetallicRoughness"]["baseColorFactor"].clone(),
                count.unwrap(),
                material["alphaMode"].clone(),
            )
        };
        let looks: Vec<_> = primitives.iter().map(look).collect();
        let own = color.map_or(Value::Null, |color| json!(color));
        let expected =
            [(own, 18, Value::Null), (json!(RED), 12, Value::Null), (json!(GLASS), 6, json!("BLEND"))];
        for wanted in expected {
            assert!(looks.contains(&wanted), "{wanted:?} in {looks:?}");
        }
        let back = read(&file);
        let Geometry::Mesh(mesh) = back.object("part").unwrap().geometry() else { unreachable!() };
        assert!((volume(&back) - 6.0).abs() < 1e-6);
        assert_eq!((mesh.face_count(), mesh.normals.is_empty()), (12, false));
        assert_eq!(back.object("part").unwrap().materials.len(), 3);
    }
}

#[test]
fn normals_point_outwards_wherever_it_stands() {
    let shear = Matrix4::new(1.0, 0.7, 0.0, 5.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -2.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    let mirror = Matrix4::new_nonuniform_scaling(&Vector3::new(-1.0, 2.0, 1.0));
    for (transform, full) in [(shear, 12.0), (mirror, 12.0)] {
        let mut scene = one(painted());
        scene.object_mut("part").unwrap().transform = Some(transform);
        let (file, ..) = write(&scene, json!({}));
        let found = volume(&read(&file));
        assert!((found - full).abs() < 1e-4, "{found}");
    }
}

/// A thousand bolts hold one geometry, cut once.
#[test]
fn instances_of_a_solid_share_its_triangles() {
    let mut bolt = Definition::new("bolt");
    bolt.add(Object::new("body", painted().into())).unwrap();
    let mut scene = Scene::new();
    scene.define(bolt).unwrap();
    for k in 0..1000 {
        let mut place = Object::new(format!("bolt {k}"), Geometry::Instance("bolt".into()));
        place.transform = Some(Matrix4::new_translation(&Vector3::new(f64::from(k), 0.0, 0.0)));
        scene.add(place).unwrap();
    }
    let (file, json, report) = write(&scene, json!({}));
    assert_eq!(json["meshes"].as_array().unwrap().len(), 1);
    assert_eq!(json["nodes"].as_array().unwrap().iter().filter(|node| node["mesh"] == 0).count(), 1000);
    assert!(
        report.losses.iter().any(|loss| loss == "brep becomes segments or triangles (1)"),
        "{:?}",
        report.losses
    );
    assert!((volume(&read(&file)) - 6000.0).abs() < 1e-2);
}

#[test]
fn a_face_that_cannot_be_cut_is_named_and_one_of_none_is_left_out() {
    let mut parts = painted().parts();
    let line = || Space::clamped(1, &[0.0, 1.0]).unwrap();
    let speck = Face {
        name: Some("speck".into()),
        color: Some(GLASS),
        surface: Surface::new(line(), line(), vec![Point::new(1.0, 1.0, 1.0); 4]).unwrap(),
        form: SurfaceForm::Spline,
        reversed: false,
        loops: vec![],
        points: vec![],
    };
    parts.faces.push(speck);
    let (file, _, report) = write(&one(Brep::new(parts).unwrap()), json!({}));
    let reason = report.objects[0].reason.as_ref().unwrap();
    assert!(
        reason.contains("1 of 7 faces could not be cut and are left out (face 6 \"speck\": "),
        "{reason}"
    );
    assert!((volume(&read(&file)) - 6.0).abs() < 1e-6);
    let (_, json, report) = write(&one(Brep::new(Default::default()).unwrap()), json!({}));
    assert_eq!((report.objects[0].fate, &json["meshes"]), (Fate::LeftOut, &Value::Null));
    let mut file = Memory::new("s.gltf", "");
    let report = Gltf.write(&one(painted()), &mut file, &WriteOptions::default()).unwrap();
    assert!(report.objects[0].reason.as_ref().unwrap().contains("none is registered"));
}

#[test]
fn a_trimmed_surface_is_shown_and_comes_back_exactly() {
    let sample = loftsman_kernel::conformance::sample_scene();
    let window = sample.object("window").unwrap().geometry().clone();
    let mut scene = one(window.clone());
    for own in [json!({}), json!({ "meshes-only": true })] {
        let (file, json, report) = write(&scene, own);
        let written = &report.objects[0];
        assert!(written.form.ends_with("triangles") && written.error.unwrap() <= written.tolerance.unwrap());
        assert_eq!(
            written.reason.as_deref(),
            Some("the trimmed surface became triangles; the exact one is in extras")
        );
        assert_eq!(json["meshes"].as_array().unwrap().len(), 1);
        assert_eq!(*read(&file).object("part").unwrap().geometry(), window);
    }
    let frames = vec![window.points().to_vec(), window.points().to_vec()];
    scene.object_mut("part").unwrap().animation = Some(Animation { rate: 24.0, frames });
    let (file, _, report) = write(&scene, json!({}));
    assert!(report.objects[0].reason.as_ref().unwrap().contains("it stands still for other programs"));
    assert_eq!(read(&file).object("part").unwrap().animation, scene.object("part").unwrap().animation);
}
