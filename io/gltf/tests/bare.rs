//! What files of other programs leave unsaid stays unsaid: names, materials; and matrices stay as they were.

#![allow(clippy::unwrap_used, reason = "a test may stop at what should not be")]

use loftsman_gltf::Gltf;
use loftsman_kernel::mesh::{Cloud, Layer, Mesh};
use loftsman_kernel::plugin::{Format, Memory, ReadOptions, WriteOptions};
use loftsman_kernel::scene::{Geometry, Object, Scene};
use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Point, Vector};
use nalgebra::Matrix4;
use serde_json::{Value, json};

fn write(scene: &Scene) -> Memory {
    let mut file = Memory::new("c.gltf", "");
    Gltf.write(scene, &mut file, &WriteOptions::default()).unwrap();
    file
}

fn read(file: &Memory) -> Scene {
    let (scene, report) = Gltf.read(file, &ReadOptions::default()).unwrap();
    assert!(report.adds_up());
    scene
}

fn json_of(file: &Memory) -> Value {
    serde_json::from_slice(&file.bytes).unwrap()
}

/// A file of another program: nodes by matrices in single precision, without names, a primitive without a material.
fn bare() -> Memory {
    let turn = |angle: f64, axis: [f64; 3], at: [f64; 3]| {
        let axis = nalgebra::Unit::new_normalize(Vector::from(axis));
        let mut map = Matrix4::from_axis_angle(&axis, angle);
        map.fixed_view_mut::<3, 1>(0, 3).copy_from(&Vector::from(at));
        map.iter().map(|&x| f64::from(x as f32)).collect::<Vec<f64>>()
    };
    let points: Vec<u8> = [[90.0_f32, 10.0, 3.0], [91.5, 12.0, 4.0], [92.0, 11.0, -7.25]]
        .iter()
        .flatten()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let red = json!({ "name": "red", "pbrMetallicRoughness": { "baseColorFactor": [1, 0, 0, 1] } });
    let attributes = json!({ "POSITION": 0 });
    let root = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0, 3] }],
        "nodes": [
            { "matrix": turn(0.3, [1.0, 2.0, 3.0], [136.860_107_421_875, -64.5, -36.2]), "children": [1, 2] },
            { "matrix": turn(2.5, [0.1, 2.0, -3.0], [-294.7, 73.98, 16.18]), "mesh": 0 },
            { "matrix": turn(-1.1, [5.0, 0.2, 0.3], [0.5, 1e-3, 7.0]), "mesh": 1 },
            { "name": "named", "mesh": 1 }
        ],
        "meshes": [
            { "primitives": [{ "attributes": attributes }] },
            { "primitives": [{ "attributes": attributes, "material": 0 }, { "attributes": attributes }] }
        ],
        "materials": [red],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
            "min": [90, 10, -7.25], "max": [92, 12, 4] }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
        "buffers": [{ "byteLength": 36, "uri": "b.bin" }]
    });
    let mut file = Memory::new("b.gltf", root.to_string());
    file.siblings.insert("b.bin".into(), points);
    file
}

#[test]
fn what_has_no_name_and_no_material_gets_none_and_matrices_stay_as_they_were() {
    let file = bare();
    let scene = read(&file);
    let names: Vec<_> = scene.objects().iter().map(|o| o.name().to_owned()).collect();
    assert_eq!(names, ["node 0", "node 1", "node 2", "named"]);
    let first = write(&scene);
    let out = json_of(&first);
    for (node, of) in out["nodes"].as_array().unwrap().iter().zip(json_of(&file)["nodes"].as_array().unwrap())
    {
        assert_eq!(node.get("name"), of.get("name"));
        // The turn of the matrix to the last bit; what moves it goes with the centre of its mesh.
        for k in (0..12).filter(|_| of.get("matrix").is_some()) {
            assert_eq!(node["matrix"][k], of["matrix"][k], "{node}");
        }
    }
    assert!(
        out["meshes"].as_array().unwrap().iter().all(|mesh| mesh.get("name").is_none_or(|n| n == "named"))
    );
    let materials: Vec<_> = out["materials"].as_array().unwrap().iter().map(|m| m["name"].clone()).collect();
    assert_eq!(materials, ["red"]);
    assert!(out["meshes"][0]["primitives"][0].get("material").is_none());

    // Nothing is baked, and nothing changes any more.
    let second = read(&first);
    for (a, b) in scene.objects().iter().zip(second.objects()) {
        assert_eq!((a.name(), a.transform, a.geometry()), (b.name(), b.transform, b.geometry()));
        assert_eq!((&a.materials, &a.statements), (&b.materials, &b.statements));
    }
    assert_eq!(first.bytes, write(&second).bytes);

    // Who gives it a name or a colour finds it in the file.
    let mut renamed = second.clone();
    renamed.rename("node 1", "wheel").unwrap();
    renamed.object_mut("wheel").unwrap().color = Some([0.0, 1.0, 0.0, 1.0]);
    let out = json_of(&write(&renamed));
    assert_eq!(out["nodes"][1]["name"], "wheel");
    assert!(out["meshes"][0]["primitives"][0].get("material").is_some());
}

/// What has neither colour nor material nor colours of vertices gets no material, whatever it is.
#[test]
fn what_is_not_styled_gets_no_material() {
    let corner = |k: u8| Point::new(f64::from(k & 1), f64::from(k >> 1), 0.0);
    let mesh = Mesh::new((0..4).map(corner).collect(), &[[0_usize, 1, 3, 2]]).unwrap();
    let mut colored = mesh.clone();
    colored.colors = Layer::per_point(vec![[1.0, 0.0, 0.0, 1.0]; 4]);
    let curve = Curve::bezier((0..4).map(|k| corner(k) * 3.0).collect()).unwrap();
    let mut scene = Scene::new();
    scene.add(Object::new("mesh", mesh.clone().into())).unwrap();
    scene.add(Object::new("curve", curve.into())).unwrap();
    scene.add(Object::new("cloud", Cloud { points: vec![corner(3)] }.into())).unwrap();
    let plain = write(&scene);
    assert_eq!(json_of(&plain).get("materials"), None);
    assert!(read(&plain).objects().iter().all(|o| o.statements.is_empty() && o.materials.is_empty()));
    assert_eq!(plain.bytes, write(&read(&plain)).bytes);

    // Colours of vertices are seen as what they are, and not as those of a metal.
    scene.add(Object::new("colored", colored.into())).unwrap();
    let mut painted = Object::new("painted", mesh.into());
    painted.color = Some([0.0, 1.0, 0.0, 1.0]);
    scene.add(painted).unwrap();
    let file = write(&scene);
    let out = json_of(&file);
    let materials: Vec<_> = out["materials"].as_array().unwrap().iter().map(|m| m["name"].clone()).collect();
    assert_eq!(materials, ["vertex colors", "color 2"]);
    assert_eq!(out["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"], json!([1.0, 1.0, 1.0, 1.0]));
    assert_eq!(out["materials"][0]["pbrMetallicRoughness"]["metallicFactor"], json!(0.0));
    let second = read(&file);
    assert!(second.materials.is_empty() && second.object("colored").unwrap().materials.is_empty());
    assert_eq!(file.bytes, write(&second).bytes);
}

/// Materials and embedded pictures without names stay without; who renames one finds the name in the file. A name that reads as JSON is still one.
#[test]
fn unnamed_materials_and_pictures_stay_unnamed() {
    let pixel = "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg==";
    let mut root = json_of(&bare());
    root["materials"] = json!([
        { "pbrMetallicRoughness": { "baseColorFactor": [1, 0, 0, 1], "baseColorTexture": { "index": 0 } } },
        { "name": "7", "pbrMetallicRoughness": { "baseColorTexture": { "index": 1 } } },
    ]);
    root["images"] = json!([{ "uri": pixel }, { "uri": pixel, "name": "dot" }]);
    root["textures"] = json!([{ "source": 0 }, { "source": 1 }]);
    root["meshes"][0]["primitives"][0]["material"] = json!(1);
    let uvs = json!({ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC2" });
    root["accessors"].as_array_mut().unwrap().push(uvs);
    for mesh in 0..2 {
        root["meshes"][mesh]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(1);
    }
    let mut file = Memory::new("b.gltf", root.to_string());
    file.siblings = bare().siblings;
    let scene = read(&file);
    let first = write(&scene);
    let named = |file: &Memory, list: &str| -> Vec<Value> {
        json_of(file)[list].as_array().unwrap().iter().map(|one| one["name"].clone()).collect()
    };
    let sorted = |mut names: Vec<Value>| {
        names.sort_by_key(Value::to_string);
        names
    };
    assert_eq!(sorted(named(&first, "materials")), [json!("7"), Value::Null]);
    assert_eq!(sorted(named(&first, "images")), [json!("dot"), Value::Null]);
    assert!(json_of(&first)["materials"].as_array().unwrap().iter().all(|m| m.get("extensions").is_none()));
    assert_eq!(first.bytes, write(&read(&first)).bytes);
}

/// Numbers that single precision holds are not rounded, and nothing is said of that; of others how much.
#[test]
fn rounding_is_told_where_there_is_some() {
    let told = |x: f64| {
        let mut scene = Scene::default();
        let points = vec![Point::origin(), Point::new(x, 0.0, 0.0), Point::new(0.0, 1.0, 0.25)];
        scene.add(Object::new("m", Mesh::new(points, &[[0, 1, 2]]).unwrap().into())).unwrap();
        let report = Gltf.write(&scene, &mut Memory::new("c.gltf", ""), &WriteOptions::default()).unwrap();
        report.notes.into_iter().find(|note| note.contains("single precision"))
    };
    assert_eq!(told(1.0), None);
    let rounded = told(0.1).unwrap();
    assert!(rounded.contains("1.5e-9 m"), "{rounded}");
}

/// Lines two by two, in any order, as other programs write the edges of a mesh: what is one chain is a polyline, and anything else stays a mesh of lines.
#[test]
fn lines_that_are_one_chain_are_a_polyline() {
    let file = |count: u32, pairs: &[[u32; 2]]| {
        let points = (0..count).flat_map(|k| [k as f32, (k * k) as f32, 0.5].map(f32::to_le_bytes));
        let indices = pairs.iter().flatten().map(|k| k.to_le_bytes());
        let bytes: Vec<u8> = points.chain(indices).flatten().collect();
        let (first, second) = (12 * count, bytes.len() as u32 - 12 * count);
        let root = json!({
            "asset": { "version": "2.0" },
            "scene": 0,
            "scenes": [{ "nodes": [0] }],
            "nodes": [{ "name": "wire", "mesh": 0 }],
            "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1, "mode": 1 }] }],
            "accessors": [
                { "bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3",
                  "min": [0, 0, 0.5], "max": [count - 1, (count - 1) * (count - 1), 0.5] },
                { "bufferView": 1, "componentType": 5125, "count": 2 * pairs.len(), "type": "SCALAR" }
            ],
            "bufferViews": [
                { "buffer": 0, "byteLength": first },
                { "buffer": 0, "byteOffset": first, "byteLength": second }
            ],
            "buffers": [{ "byteLength": bytes.len(), "uri": "b.bin" }]
        });
        let mut file = Memory::new("b.gltf", root.to_string());
        file.siblings.insert("b.bin".into(), bytes);
        file
    };
    type Case<'a> = (u32, &'a [[u32; 2]], Option<(&'a [u32], bool)>);
    let cases: [Case<'_>; 11] = [
        (4, &[[2, 3], [1, 0], [2, 1]], Some((&[0, 1, 2, 3], false))),
        (4, &[[3, 1], [0, 3], [0, 2]], Some((&[1, 3, 0, 2], false))),
        (4, &[[2, 3], [1, 0], [2, 1], [3, 0]], Some((&[0, 1, 2, 3], true))),
        (4, &[[0, 3], [2, 3], [1, 0], [2, 1]], Some((&[0, 3, 2, 1], true))),
        (2, &[[1, 0]], Some((&[0, 1], false))),
        // There and back, a point, a fork, two chains, a ring beside a chain, a point that no line has.
        (2, &[[1, 0], [0, 1]], None),
        (2, &[[0, 1], [1, 1]], None),
        (4, &[[0, 1], [1, 2], [1, 3]], None),
        (4, &[[0, 1], [2, 3]], None),
        (5, &[[0, 1], [2, 3], [3, 4], [4, 2]], None),
        (4, &[[0, 1], [1, 2]], None),
    ];
    for (count, pairs, wanted) in cases {
        let scene = read(&file(count, pairs));
        match (scene.object("wire").unwrap().geometry(), wanted) {
            (Geometry::Polyline(line), Some((order, closed))) => {
                let at = |k: &u32| Point::new(f64::from(*k), f64::from(k * k), 0.5);
                assert_eq!(line.points, order.iter().map(at).collect::<Vec<_>>(), "{pairs:?}");
                assert_eq!(line.closed, closed, "{pairs:?}");
            }
            (Geometry::Mesh(mesh), None) => {
                assert_eq!(mesh.lines().map(|l| l.len() - 1).sum::<usize>(), pairs.len());
            }
            (other, _) => panic!("{pairs:?}: a {}", other.kind()),
        }
        // What comes out is read as it was.
        let first = write(&scene);
        let again = read(&first);
        assert_eq!(
            again.object("wire").unwrap().geometry(),
            scene.object("wire").unwrap().geometry(),
            "{pairs:?}"
        );
        assert_eq!(first.bytes, write(&again).bytes, "{pairs:?}");
    }
}
