//! Layers, colours by layer, labels and unknown units: there and back.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may stop at what should not be")]

use loftsman_gltf::Gltf;
use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::plugin::{Format, Memory, ReadOptions, ReadReport, WriteOptions, WriteReport};
use loftsman_kernel::scene::{Definition, Geometry, Layer, Object, Scene, Unit, Up};
use loftsman_kernel::{Point, Vector};
use nalgebra::Matrix4;
use serde_json::{Value, json};

const RED: [f64; 4] = [1.0, 0.25, 0.125, 1.0];

fn write(scene: &Scene) -> (Memory, WriteReport) {
    let mut file = Memory::new("s.gltf", "");
    let report = Gltf.write(scene, &mut file, &WriteOptions::default()).unwrap();
    (file, report)
}

fn read(file: &Memory) -> (Scene, ReadReport) {
    let (scene, report) = Gltf.read(file, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    assert!(report.adds_up());
    scene.check().unwrap();
    (scene, report)
}

fn json_of(file: &Memory) -> Value {
    serde_json::from_slice(&file.bytes).unwrap()
}

fn mesh() -> Geometry {
    let points = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(|[x, y]| Point::new(x, y, 0.0)).to_vec();
    Mesh::new(points, &[[0, 1, 2]]).unwrap().into()
}

/// A red layer below a hidden one, with an object by layer and one with a colour of its own.
fn scene(unit: Unit, up: Up) -> Scene {
    let mut scene = Scene::new();
    (scene.unit, scene.up) = (unit, up);
    scene.layers.add(Layer::new("bolts").colored(RED).below("all")).unwrap();
    scene.layers.add(Layer::new("all").hidden()).unwrap();
    for (name, layer) in [("by layer", "bolts"), ("own", "bolts"), ("plain", "not listed")] {
        let mut object = Object::new(name, mesh());
        object.layer = Some(layer.into());
        object.color = (name == "own").then_some([0.0, 0.5, 1.0, 1.0]);
        scene.add(object).unwrap();
    }
    scene
}

#[test]
fn layers_and_what_has_its_colour_from_them_come_back() {
    for (unit, up) in
        [(Unit::Metre, Up::Y), (Unit::Millimetre, Up::Z), (Unit::of_metres(0.3).unwrap(), Up::Y)]
    {
        let scene = scene(unit, up);
        let (file, report) = write(&scene);
        let note = report.losses.iter().find(|note| note.contains("hidden layers"));
        assert!(note.is_some_and(|note| note.starts_with("2 objects")), "{:?}", report.losses);
        // Others see the colour of the layer.
        let json = json_of(&file);
        let shown = &json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"];
        assert_eq!(*shown, json!(RED), "{json}");
        let (back, report) = read(&file);
        assert_eq!((&back.layers, back.unit, back.up), (&scene.layers, unit, up), "{report:?}");
        for (a, b) in scene.objects().iter().zip(back.objects()) {
            assert_eq!((a.name(), &a.layer, a.color), (b.name(), &b.layer, b.color));
        }
        assert_eq!(write(&back).0.bytes, file.bytes);
    }
    // Without layers of their own, files say nothing of them.
    let mut named = scene(Unit::Metre, Up::Y);
    named.layers = Default::default();
    assert!(json_of(&write(&named).0)["asset"]["extras"].is_null());
}

#[test]
fn a_material_that_another_program_changed_is_no_colour_by_layer_any_more() {
    let (file, _) = write(&scene(Unit::Metre, Up::Y));
    let mut json = json_of(&file);
    json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!([0.0, 1.0, 0.0, 1.0]);
    let changed = Memory { bytes: serde_json::to_vec(&json).unwrap(), ..file };
    assert_eq!(read(&changed).0.object("by layer").unwrap().color, Some([0.0, 1.0, 0.0, 1.0]));
}

#[test]
fn layers_that_cannot_be_are_left_out_and_said_to_be() {
    let (file, _) = write(&scene(Unit::Metre, Up::Y));
    for (layers, words) in [
        (json!([{ "name": "a", "parent": "b" }, { "name": "b", "parent": "a" }]), "cyclic"),
        (json!([{ "name": "a", "parent": "b" }]), "does not exist"),
        (json!([{ "name": "a" }, { "name": "a" }]), "two layers"),
        (json!([{ "name": "" }]), "empty"),
        (json!([{ "name": "a", "color": [1, "x"] }]), "invalid type"),
        (json!(7), "invalid type"),
    ] {
        let mut json = json_of(&file);
        json["asset"]["extras"]["loftsman"]["layers"] = layers;
        let broken = Memory { bytes: serde_json::to_vec(&json).unwrap(), ..file.clone() };
        let (scene, report) = read(&broken);
        assert!(scene.layers.is_empty());
        assert!(report.notes.iter().any(|note| note.contains(words)), "{words}: {:?}", report.notes);
        assert!(report.left_out.keys().any(|reason| reason.contains("layers")), "{report:?}");
        // The colour is the object's own then.
        assert_eq!(scene.object("by layer").unwrap().color, Some(RED));
    }
}

#[test]
fn what_a_hidden_instance_shows_is_on_its_layer() {
    let mut scene = scene(Unit::Metre, Up::Y);
    let mut part = Definition::new("part");
    let mut own = Object::new("own", mesh());
    own.layer = Some("not listed".into());
    part.add(own).unwrap();
    scene.define(part).unwrap();
    for (name, layer) in [("seen", "not listed"), ("unseen", "all")] {
        let mut instance = Object::new(name, Geometry::Instance("part".into()));
        instance.layer = Some(layer.into());
        scene.add(instance).unwrap();
    }
    let back = read(&write(&scene).0).0;
    let layer = |name: &str| back.object(name).unwrap().layer.as_deref();
    assert_eq!((layer("seen/own"), layer("unseen/own")), (Some("not listed"), Some("all")));
    assert!(back.hidden_layers().hides(back.object("unseen/own").unwrap()));
}

#[test]
fn two_bolts_stay_two_bolts() {
    let node = |x: f64| json!({ "name": "bolt", "translation": [x, 0.0, 0.0], "mesh": 0 });
    let mut scene = Scene::new();
    (scene.unit, scene.up) = (Unit::Metre, Up::Y);
    scene.add(Object::new("bolt", mesh())).unwrap();
    let (file, _) = write(&scene);
    let mut json = json_of(&file);
    json["nodes"] = json!([node(0.0), node(1.0), node(2.0)]);
    json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    let three = Memory { bytes: serde_json::to_vec(&json).unwrap(), ..file };
    let (scene, report) = read(&three);
    let names: Vec<_> = scene.objects().iter().map(|o| (o.name(), o.label.as_deref())).collect();
    assert_eq!(names, [("bolt", None), ("bolt.001", Some("bolt")), ("bolt.002", Some("bolt"))]);
    assert!(report.notes.iter().any(|note| note.contains("\"bolt\" becomes \"bolt.001\"")), "{report:?}");
    let (again, _) = write(&scene);
    let out = json_of(&again);
    let nodes: Vec<_> = out["nodes"].as_array().unwrap().iter().map(|n| n["name"].clone()).collect();
    assert_eq!(nodes, ["bolt"; 3]);
    assert_eq!(out["meshes"].as_array().unwrap().len(), 1);
    assert_eq!(out["meshes"][0]["name"], "bolt");
    let (twice, _) = read(&again);
    assert!(twice == scene, "{twice:?}");
    // A name that is given is a name.
    let mut renamed = scene.clone();
    renamed.rename("bolt.001", "screw").unwrap();
    assert_eq!(json_of(&write(&renamed).0)["nodes"][1]["name"], "screw");
    // Moved, turned up and in another unit, they are still called so.
    let converted = scene.converted(Unit::Inch, Up::Z).unwrap();
    assert_eq!(converted.objects()[2].label(), "bolt");
    let mut moved = scene.clone();
    moved.object_mut("bolt.002").unwrap().transform = Some(Matrix4::new_translation(&Vector::x()));
    assert_eq!(moved.objects()[2].renamed("bolt.002").label(), "bolt");
    assert_eq!(moved.objects()[2].renamed("nut").label(), "nut");
}

#[test]
fn numbers_of_an_unknown_unit_become_metres_and_that_is_said() {
    for up in [Up::Y, Up::Z] {
        let mut unknown = scene(Unit::Unknown, up);
        unknown.object_mut("plain").unwrap().transform = Some(Matrix4::new_translation(&Vector::x()));
        let (file, report) = write(&unknown);
        let said = report.losses.iter().filter(|note| note.contains("unit of the scene is unknown"));
        assert_eq!(said.count(), 1, "{:?}", report.losses);
        let mut metres = unknown.clone();
        metres.unit = Unit::Metre;
        let (same, report) = write(&metres);
        assert!(same.bytes == file.bytes && !report.losses.iter().any(|note| note.contains("unknown")));
        assert_eq!(read(&file).0.unit, Unit::Metre);
    }
}
