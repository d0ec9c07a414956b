//! A mesh that several nodes show is read once, shared, and written once.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may stop at what should not be")]

use std::sync::Arc;

use loftsman_gltf::Gltf;
use loftsman_kernel::mesh::{Cloud, Mesh, Polyline};
use loftsman_kernel::placement::transform_point;
use loftsman_kernel::plugin::{Format, Memory, ReadOptions, WriteOptions};
use loftsman_kernel::scene::{Animation, Definition, Geometry, Object, Scene, Unit, Up};
use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Point, Vector};
use loftsman_tessellation::Adaptive;
use nalgebra::Matrix4;
use serde_json::{Value, json};

fn write(scene: &Scene) -> (Memory, Value) {
    let tessellator = Adaptive::default();
    let options = WriteOptions { tessellator: Some(&tessellator), ..WriteOptions::default() };
    let mut file = Memory::new("s.gltf", "");
    let report = Gltf.write(scene, &mut file, &options).unwrap();
    assert!(report.objects.len() >= scene.objects().len());
    let json = serde_json::from_slice(&file.bytes).unwrap();
    (file, json)
}

fn read(file: &Memory) -> Scene {
    let (scene, report) = Gltf.read(file, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    assert!(report.adds_up());
    scene.check().unwrap();
    scene
}

fn is_shared(scene: &Scene, a: &str, b: &str) -> bool {
    let [a, b] = [a, b].map(|name| scene.object(name).unwrap().shared_geometry());
    Arc::ptr_eq(a, b)
}

fn length(json: &Value, list: &str) -> usize {
    json[list].as_array().map_or(0, Vec::len)
}

/// A tetrahedron.
fn body() -> Mesh {
    let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let points = points.map(|[x, y, z]| Point::new(x, y, z)).to_vec();
    Mesh::new(points, &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]).unwrap()
}

/// `count` copies of one object, each a step further along x.
fn row(object: &Object, count: usize) -> Scene {
    let mut scene = Scene::new();
    (scene.unit, scene.up) = (Unit::Metre, Up::Y);
    for k in 0..count {
        let mut copy = object.renamed(if k == 0 { "bolt".into() } else { format!("bolt.{k:03}") });
        copy.transform = (k > 0).then(|| Matrix4::new_translation(&Vector::new(k as f64, 0.0, 0.0)));
        scene.add(copy).unwrap();
    }
    scene
}

#[test]
fn copies_are_one_mesh_there_and_back() {
    let scene = row(&Object::new("", body().into()), 5);
    let (file, json) = write(&scene);
    assert_eq!((length(&json, "nodes"), length(&json, "meshes"), length(&json, "accessors")), (5, 1, 2));
    let back = read(&file);
    for k in 1..5 {
        assert!(is_shared(&back, "bolt", &format!("bolt.{k:03}")));
    }
    assert_eq!(back.world_transforms().unwrap(), scene.world_transforms().unwrap());
    // Again the same, to the byte.
    let (again, _) = write(&back);
    let (third, _) = write(&read(&again));
    assert_eq!((&again.bytes, &again.siblings), (&third.bytes, &third.siblings));
    // One of them is changed, the others are not.
    let mut back = back;
    let Geometry::Mesh(mesh) = back.object_mut("bolt.002").unwrap().geometry_mut() else { panic!("no mesh") };
    mesh.points_mut()[1].x = 9.0;
    assert_eq!(back.object("bolt").unwrap().geometry().points()[1].x, 1.0);
    let (file, json) = write(&back);
    assert_eq!(length(&json, "meshes"), 2);
    let back = read(&file);
    assert!(is_shared(&back, "bolt", "bolt.004") && !is_shared(&back, "bolt", "bolt.002"));
    assert_eq!(back.object("bolt.002").unwrap().geometry().points()[1].x, 9.0);
}

#[test]
fn what_differs_is_a_mesh_of_its_own_of_the_same_vertices() {
    let mut scene = row(&Object::new("", body().into()), 6);
    scene.object_mut("bolt.001").unwrap().color = Some([1.0, 0.0, 0.0, 1.0]);
    scene
        .object_mut("bolt.002")
        .unwrap()
        .statements
        .push(("gltf mesh extras".into(), "{\"steel\":1}".into()));
    scene.object_mut("bolt.003").unwrap().statements.push(("gltf mesh name".into(), "screw".into()));
    // Shear is baked into points of its own.
    scene.object_mut("bolt.004").unwrap().transform.as_mut().unwrap()[(0, 1)] = 0.5;
    let (file, json) = write(&scene);
    // Indices and positions once for all but the sheared one.
    assert_eq!(length(&json, "accessors"), 4, "{json}");
    let names = json["meshes"].as_array().unwrap().iter().map(|m| m["name"].clone()).collect::<Vec<_>>();
    let node = |name: &str| {
        let nodes = json["nodes"].as_array().unwrap();
        nodes.iter().find(|n| n["name"] == name).unwrap()["mesh"].clone()
    };
    assert!(names.contains(&json!("screw")) && node("bolt") == node("bolt.005"));
    let back = read(&file);
    for name in ["bolt.001", "bolt.002", "bolt.003", "bolt.005"] {
        assert!(is_shared(&back, "bolt", name), "{name}");
    }
    for (a, b) in scene.objects().iter().zip(back.objects()) {
        assert_eq!(a.color, b.color);
        let place = |scene: &Scene, o: &Object, p: &Point| {
            let map = scene.world_transforms().unwrap()[scene.position(o.name()).unwrap()];
            map.map_or(*p, |map| transform_point(&map, p))
        };
        for (p, q) in a.geometry().points().iter().zip(b.geometry().points()) {
            assert!((place(&scene, a, p) - place(&back, b, q)).norm() < 1e-6);
        }
    }
    let told = |name: &str, what: &str| back.object(name).unwrap().statement(what).map(str::to_owned);
    assert_eq!(told("bolt.002", "gltf mesh extras").unwrap(), "{\"steel\":1}");
    assert_eq!(told("bolt.003", "gltf mesh name").unwrap(), "screw");
}

#[test]
fn splines_are_cut_and_read_once() {
    let circle = Curve::circle(Point::origin(), Vector::z(), 1.0).unwrap();
    let scene = row(&Object::new("", circle.into()), 4);
    let (file, json) = write(&scene);
    assert_eq!(length(&json, "meshes"), 1);
    let back = read(&file);
    for k in 1..4 {
        assert!(is_shared(&back, "bolt", &format!("bolt.{k:03}")));
    }
    assert_eq!(back.object("bolt.003").unwrap().geometry(), scene.object("bolt").unwrap().geometry());
    // Another unit: read back in it, and still shared.
    let inches = scene.converted(Unit::Inch, Up::Z).unwrap();
    let back = read(&write(&inches).0);
    assert!(back.unit == Unit::Inch && is_shared(&back, "bolt", "bolt.003"));
}

#[test]
fn what_moves_has_a_mesh_of_its_own() {
    let mut scene = row(&Object::new("", body().into()), 3);
    let frames: Vec<Vec<Point>> =
        (0..3).map(|k| body().points().iter().map(|p| p * (1.0 + f64::from(k))).collect()).collect();
    scene.object_mut("bolt.001").unwrap().animation = Some(Animation { rate: 12.0, frames: frames.clone() });
    let (file, json) = write(&scene);
    assert_eq!(length(&json, "meshes"), 2);
    let back = read(&file);
    assert!(is_shared(&back, "bolt", "bolt.002"));
    assert_eq!(back.object("bolt.001").unwrap().animation.as_ref().unwrap().frames, frames);
    assert!(back.object("bolt").unwrap().animation.is_none());
}

/// The triangle of the standard, shown by four nodes, with a morph target that moves it up.
#[test]
fn nodes_that_bend_a_mesh_alike_share_it() {
    let bin = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAECAA==";
    let document = json!({
        "asset": { "version": "2.0" },
        "scenes": [{ "nodes": [0, 1, 2, 3] }],
        "nodes": [
            { "name": "a", "mesh": 0 }, { "name": "b", "mesh": 0, "weights": [2.0] },
            { "name": "c", "mesh": 0, "weights": [2.0] }, { "name": "d", "mesh": 0, "weights": [0.0] }
        ],
        "meshes": [{ "primitives": [{
            "attributes": { "POSITION": 0 }, "indices": 1, "targets": [{ "POSITION": 0 }]
        }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" },
            { "bufferView": 0, "byteOffset": 36, "componentType": 5121, "count": 3, "type": "SCALAR" }
        ],
        "bufferViews": [{ "buffer": 0, "byteLength": 40 }],
        "buffers": [{ "byteLength": 40, "uri": format!("data:;base64,{bin}") }]
    });
    let scene = read(&Memory::new("m.gltf", document.to_string()));
    assert!(is_shared(&scene, "a", "d") && is_shared(&scene, "b", "c") && !is_shared(&scene, "a", "b"));
    let x = |name: &str| scene.object(name).unwrap().geometry().points()[1].x;
    assert_eq!((x("a"), x("b")), (1.0, 3.0));
}

#[test]
fn definitions_become_nodes_that_share_their_meshes() {
    let mut scene = Scene::new();
    (scene.unit, scene.up) = (Unit::Metre, Up::Y);
    let mut bolt = Definition::new("bolt");
    bolt.add(Object::new("head", body().into())).unwrap();
    scene.define(bolt).unwrap();
    let mut pair = Definition::new("pair");
    for (name, x) in [("left", -1.0), ("right", 1.0)] {
        let mut object = Object::new(name, Geometry::Instance("bolt".into()));
        object.transform = Some(Matrix4::new_translation(&Vector::new(x, 0.0, 0.0)));
        pair.add(object).unwrap();
    }
    scene.define(pair).unwrap();
    for k in 0..3 {
        let mut object = Object::new(format!("pair {k}"), Geometry::Instance("pair".into()));
        object.transform = Some(Matrix4::new_translation(&Vector::new(0.0, f64::from(k), 0.0)));
        scene.add(object).unwrap();
    }
    let (file, json) = write(&scene);
    assert_eq!((length(&json, "nodes"), length(&json, "meshes"), length(&json, "accessors")), (15, 1, 2));
    let back = read(&file);
    let at = back.position("pair 2/left/head").unwrap();
    let map = back.world_transforms().unwrap()[at].unwrap();
    assert_eq!(transform_point(&map, &Point::new(1.0, 0.0, 0.0)), Point::new(0.0, 2.0, 0.0));
    assert!(is_shared(&back, "pair 0/left/head", "pair 2/right/head"));
}

/// A surface shown with and without a colour is two meshes of the same vertices in the file; read again it is one shape, and the file is as long as it was.
#[test]
fn an_exact_shape_in_two_colours_stays_shared() {
    let ring = Curve::circle(Point::new(2.0, 0.0, 0.0), Vector::y(), 1.0).unwrap();
    let pipe = loftsman_kernel::spline::Surface::extrusion(&ring, Vector::new(0.0, 3.0, 0.0)).unwrap();
    let line = Curve::bezier(vec![Point::origin(), Point::new(1.0, 2.0, 0.0), Point::new(3.0, 0.0, 1.0)]);
    let points = vec![Point::origin(), Point::new(1.0, 2.0, 0.0), Point::new(3.0, 0.0, 1.0)];
    let chain = Polyline { points: points.clone(), closed: false };
    // Lines without a material that others have, and the other way round.
    for geometry in
        [Geometry::from(pipe), Geometry::from(line.unwrap()), chain.into(), Cloud { points }.into()]
    {
        let mut scene = row(&Object::new("", geometry.clone()), 4);
        scene.object_mut("bolt.001").unwrap().color = Some([1.0, 0.0, 0.0, 1.0]);
        scene.object_mut("bolt.003").unwrap().color = Some([0.0, 0.0, 1.0, 1.0]);
        let (file, json) = write(&scene);
        let back = read(&file);
        for object in scene.objects() {
            assert_eq!(back.object(object.name()).unwrap().color, object.color, "{}", object.name());
        }
        for name in ["bolt.001", "bolt.002", "bolt.003"] {
            assert!(is_shared(&back, "bolt", name), "{name}");
            assert_eq!(back.object(name).unwrap().geometry(), &geometry, "{name}");
        }
        let (again, second) = write(&back);
        for list in ["meshes", "accessors"] {
            assert_eq!(length(&json, list), length(&second, list), "{list}");
        }
        assert_eq!((file.bytes.len(), file.siblings.len()), (again.bytes.len(), again.siblings.len()));
        // What only looks alike is not the same.
        let mut other = scene.clone();
        let Geometry::Curve(curve) = &geometry else { continue };
        other.object_mut("bolt.001").unwrap().set_geometry(curve.elevate(1).unwrap());
        let back = read(&write(&other).0);
        assert!(!is_shared(&back, "bolt", "bolt.001") && is_shared(&back, "bolt", "bolt.002"));
    }
}
