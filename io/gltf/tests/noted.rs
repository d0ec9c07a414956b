//! What other programs note, tangents and names: there and back.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may stop at what should not be")]

use loftsman_gltf::Gltf;
use loftsman_kernel::Point;
use loftsman_kernel::material::{Channel, Image, ImageData, Material, Texture};
use loftsman_kernel::mesh::{Cloud, Layer, Mesh, Polyline};
use loftsman_kernel::plugin::{Format, Memory, ReadOptions, ReadReport, WriteOptions};
use loftsman_kernel::scene::{Geometry, Object, Scene};
use serde_json::{Value, json};

fn read(file: &Memory) -> (Scene, ReadReport) {
    let (scene, report) = Gltf.read(file, &ReadOptions::default()).unwrap();
    assert!(report.adds_up(), "{report:?}");
    (scene, report)
}

fn write_with(scene: &Scene, name: &str, options: &WriteOptions<'_>) -> (Memory, Vec<String>) {
    let mut file = Memory::new(name, "");
    let report = Gltf.write(scene, &mut file, options).unwrap();
    (file, report.told())
}

fn write(scene: &Scene) -> Memory {
    write_with(scene, "part.gltf", &WriteOptions::default()).0
}

fn json_of(file: &Memory) -> Value {
    serde_json::from_slice(&file.bytes).unwrap()
}

/// A triangle of another program, with notes wherever they may stand.
fn noted() -> Value {
    json!({
        "asset": { "version": "2.0", "copyright": "me ©", "extras": { "tool": [1, 2.5, "x"] } },
        "extras": "of the file",
        "scene": 0,
        "scenes": [{ "name": "Stage", "nodes": [0], "extras": { "light": true } }],
        "nodes": [{ "name": "t", "mesh": 0, "extras": { "price": 12, "deep": { "a": null } } }],
        "meshes": [{
            "name": "Mesh.001", "extras": { "targetNames": [], "id": 7 },
            "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }]
        }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5121, "count": 3, "type": "SCALAR" }
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 36 }, { "buffer": 0, "byteOffset": 36, "byteLength": 3 }
        ],
        "buffers": [{
            "byteLength": 40,
            "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAECAA=="
        }]
    })
}

#[test]
fn notes_of_other_programs_come_back() {
    let first = noted();
    let (scene, report) = read(&Memory::new("h.gltf", first.to_string()));
    assert!(report.left_out.is_empty(), "{report:?}");
    let second = json_of(&write(&scene));
    let at = |document: &Value, path: &str| document.pointer(path).cloned();
    for path in [
        "/asset/copyright",
        "/asset/extras",
        "/extras",
        "/scenes/0/name",
        "/scenes/0/extras",
        "/nodes/0/name",
        "/nodes/0/extras",
        "/meshes/0/name",
    ] {
        assert_eq!(at(&first, path), at(&second, path), "{path}");
    }
    assert_eq!(at(&second, "/meshes/0/extras"), Some(json!({ "id": 7 })));
    // Ours go beside theirs.
    let mut layered = scene.clone();
    layered.object_mut("t").unwrap().layer = Some("frames".into());
    let third = write(&layered);
    let extras = at(&json_of(&third), "/nodes/0/extras").unwrap();
    assert_eq!((&extras["price"], extras["loftsman"].is_string()), (&json!(12), true));
    let (back, _) = read(&third);
    assert_eq!(back.object("t").unwrap().layer.as_deref(), Some("frames"));
    assert_eq!(back.object("t").unwrap().statements, scene.object("t").unwrap().statements);
}

#[test]
fn notes_that_are_too_large_or_broken_are_counted() {
    let mut document = noted();
    document["nodes"][0]["extras"] = json!("x".repeat(2 << 20));
    let (scene, report) = read(&Memory::new("h.gltf", document.to_string()));
    assert!(scene.object("t").unwrap().statement("gltf extras").is_none());
    assert!(report.left_out.contains_key("extras of a node, larger than a megabyte"), "{report:?}");
    // Deeper than anyone may nest.
    let deep = format!("{}{}", "[".repeat(5000), "]".repeat(5000));
    let text = noted().to_string().replace("\"of the file\"", &deep);
    let (_, report) = read(&Memory::new("h.gltf", text));
    assert!(report.left_out.contains_key("extras of a file that cannot be read"), "{report:?}");
}

#[test]
fn a_picture_of_many_nodes_is_not_copied_without_end() {
    // A thousand nodes show a mesh with half a megabyte of notes: the file is small, the scene must be too.
    let mut document = noted();
    document["meshes"][0]["extras"] = json!("x".repeat(1 << 19));
    let nodes: Vec<Value> = (0..1000).map(|_| json!({ "mesh": 0 })).collect();
    document["scenes"][0]["nodes"] = (0..1000).collect();
    document["nodes"] = json!(nodes);
    let file = Memory::new("h.gltf", document.to_string());
    let error = Gltf.read(&file, &ReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("meshes[0]") && error.contains("MB"), "{error}");
}

/// A square with texture coordinates and a material with a normal map.
fn bumpy(image: ImageData) -> Scene {
    let points = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| Point::new(x, y, 0.0));
    let mut mesh = Mesh::new(points.to_vec(), &[[0, 1, 2, 3]]).unwrap();
    mesh.uvs = Layer::per_point(vec![[0.0, 0.0], [0.0, 1.0], [-1.0, 1.0], [-1.0, 0.0]]);
    let mut scene = Scene::new();
    scene.images.add(Image::new("bumps", image)).unwrap();
    let mut material = Material::new("plaster", [1.0; 4]);
    material.textures.insert(Channel::Normal, Texture::new("bumps"));
    scene.materials.add(material).unwrap();
    let mut object = Object::new("wall", mesh.into());
    object.materials = vec!["plaster".into()];
    scene.add(object).unwrap();
    scene
}

fn png() -> Vec<u8> {
    b"\x89PNG\r\n\x1a\n".to_vec()
}

fn embedded() -> ImageData {
    ImageData::Embedded { media_type: "image/png".into(), bytes: png().into() }
}

fn mesh(scene: &Scene) -> &Mesh {
    let Geometry::Mesh(mesh) = scene.objects()[0].geometry() else { panic!("no mesh") };
    mesh
}

#[test]
fn normal_maps_get_tangents_and_the_scene_does_not() {
    let file = write(&bumpy(embedded()));
    let attributes = &json_of(&file)["meshes"][0]["primitives"][0]["attributes"];
    assert!(attributes.get("TANGENT").is_some() && attributes.get("NORMAL").is_some(), "{attributes}");
    assert!(mesh(&read(&file).0).tangents.is_empty(), "they are made again");
    let text = String::from_utf8(file.bytes.clone()).unwrap().replace("made_tangents", "other_tangents");
    let other = Memory { bytes: text.into_bytes(), ..file };
    let (scene, _) = read(&other);
    // Here u grows against y, and v along x: the picture is seen from behind or not as u × v says.
    assert!(!mesh(&scene).tangents.is_empty());
    for t in mesh(&scene).tangents.values() {
        assert!((t[0]).abs() < 1e-6 && (t[1] + 1.0).abs() < 1e-6 && t[3] == 1.0, "{t:?}");
    }
    // Tangents that a file has are kept as they are.
    let mut scene = scene;
    let count = mesh(&scene).points().len();
    let Geometry::Mesh(own) = scene.object_mut("wall").unwrap().geometry_mut() else { panic!("no mesh") };
    own.tangents = Layer::per_point(vec![[0.0, 0.6, 0.8, -1.0]; count]);
    let (back, _) = read(&write(&scene));
    for t in mesh(&back).tangents.values() {
        assert!((t[1] - 0.6).abs() < 1e-7 && (t[2] - 0.8).abs() < 1e-7 && t[3] == -1.0, "{t:?}");
    }
}

#[test]
fn pictures_go_along() {
    let scene = bumpy(ImageData::File("tex/bumps 1.png".into()));
    let mut source = Memory::new("in.obj", "");
    source.pictures.insert("tex/bumps 1.png".into(), png());
    let options = WriteOptions { pictures: Some(&source), ..WriteOptions::default() };
    let (text, notes) = write_with(&scene, "part.gltf", &options);
    assert_eq!(text.pictures, source.pictures);
    assert!(!notes.iter().any(|n| n.contains("bumps")), "{notes:?}");
    assert_eq!(json_of(&text)["images"][0]["uri"], "tex/bumps%201.png");
    let (binary, _) = write_with(&scene, "part.glb", &options);
    assert!(binary.pictures.is_empty());
    assert_eq!(read(&binary).0.images.as_slice()[0].data, embedded());
    // A picture that is not there would leave a file that no program opens without complaint.
    let nowhere = Memory::new("in.obj", "");
    let options = WriteOptions { pictures: Some(&nowhere), ..WriteOptions::default() };
    let (without, notes) = write_with(&scene, "part.gltf", &options);
    assert!(json_of(&without).get("images").is_none());
    assert!(notes.iter().any(|n| n.contains("bumps") && n.contains("left out")), "{notes:?}");
    for outside in ["../bumps.png", "/etc/passwd", "a/../../b.png", "tex\\b.png"] {
        assert!(loftsman_kernel::plugin::Sink::picture(&mut Memory::new("a", ""), outside, b"").is_err());
    }
}

#[test]
fn notes_that_are_no_json_are_said() {
    let mut scene = Scene::new();
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Point::from).to_vec();
    let mut object = Object::new("t", Mesh::new(corners, &[[0, 1, 2]]).unwrap().into());
    let pair = |key: &str, text: &str| (key.to_owned(), text.to_owned());
    object.statements = vec![pair("gltf extras", "{"), pair("gltf mesh extras", "[1]")];
    scene.add(object).unwrap();
    scene.statements = vec![pair("gltf what", "1"), pair("gltf scene name", "not json")];
    let (file, notes) = write_with(&scene, "part.gltf", &WriteOptions::default());
    assert!(notes.iter().any(|note| note.starts_with("2 statements headed")), "{notes:?}");
    let value = json_of(&file);
    assert_eq!(
        (&value["meshes"][0]["extras"], &value["scenes"][0]["name"]),
        (&json!([1]), &json!("not json"))
    );
}

/// Nodes of a file with a mesh each, by name, with the numbers of their placements; what does nothing is left out.
fn placements(document: &Value) -> Vec<(String, Value)> {
    let usual = [
        ("translation", json!([0.0, 0.0, 0.0])),
        ("rotation", json!([0.0, 0.0, 0.0, 1.0])),
        ("scale", json!([1.0, 1.0, 1.0])),
        ("matrix", Value::Null),
    ];
    let real = |value: &Value| -> Value {
        value.as_array().map_or(Value::Null, |list| list.iter().map(|x| x.as_f64().unwrap()).collect())
    };
    let nodes = document["nodes"].as_array().unwrap();
    let mut all: Vec<_> = nodes
        .iter()
        .map(|node| {
            let said = usual.iter().map(|(key, usual)| (*key, real(&node[*key]), usual));
            let said = said.filter(|(_, value, usual)| !value.is_null() && value != *usual);
            let said: serde_json::Map<String, Value> =
                said.map(|(key, value, _)| (key.to_owned(), value)).collect();
            (node["name"].as_str().unwrap_or_default().to_owned(), Value::Object(said))
        })
        .collect();
    all.sort_by(|a, b| (&a.0, a.1.to_string()).cmp(&(&b.0, b.1.to_string())));
    all
}

/// Rotations, scales and matrices go out in the numbers that they came in, though a matrix in between would round them; what has been moved
/// since goes out where it is.
#[test]
fn placements_keep_their_numbers() {
    let rotation = [0.1, 0.2, 0.3, 0.86_f64.sqrt()];
    let (sin, cos) = 0.7_f64.sin_cos();
    let turned = [cos, sin, 0.0, 0.0, -sin, cos, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.1, 0.2, 0.3, 1.0];
    let mut document = noted();
    document["nodes"] = json!([
        { "name": "a", "mesh": 0, "rotation": rotation, "scale": [0.1, 0.3, 0.7], "translation": [0.1, 0.2, 0.7] },
        { "name": "b", "mesh": 0, "rotation": [-0.1, 0.0, 0.0, -(0.99_f64.sqrt())], "children": [2] },
        { "name": "c", "matrix": turned },
        { "name": "d", "mesh": 0, "scale": [-0.1, 0.1, 0.1], "rotation": [0.0, 0.1, 0.0, 0.99_f64.sqrt()] },
    ]);
    document["scenes"][0]["nodes"] = json!([0, 1, 3]);
    let (scene, _) = read(&Memory::new("h.gltf", document.to_string()));
    let once = write(&scene);
    assert_eq!(placements(&json_of(&once)), placements(&document));
    let (again, _) = read(&once);
    assert!(write(&again).bytes == once.bytes, "it is the same from then on");
    let mut moved = scene.clone();
    let map = moved.object_mut("a").unwrap().transform.as_mut().unwrap();
    map[(0, 3)] = 5.0;
    let (back, _) = read(&write(&moved));
    let (there, wanted) = (back.object("a").unwrap().transform, moved.object("a").unwrap().transform);
    assert!((there.unwrap() - wanted.unwrap()).amax() < 1e-15, "{there:?}");
}

#[test]
fn placements_of_every_file_keep_their_numbers() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/gltf");
    let mut compared = 0;
    for entry in std::fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let (path, bytes) = (entry.path(), std::fs::read(entry.path()).unwrap());
        if path.extension().is_none_or(|extension| extension != "glb") {
            continue;
        }
        let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        let document: Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
        let (scene, _) = read(&Memory::new("x.glb", bytes));
        let once = json_of(&write(&scene));
        let out = placements(&once);
        for placement in placements(&document).iter().filter(|(_, said)| said != &json!({})) {
            assert!(out.contains(placement), "{}: {placement:?} in {out:#?}", path.display());
            compared += 1;
        }
    }
    assert!(compared >= 3, "{compared}");
}

/// Lines and points of ours that another program passed on as nodes alone, as Blender exports them unless told otherwise, are said by name, and with what helps;
/// groups that were groups are not.
#[test]
fn lines_and_points_that_were_left_behind_are_said() {
    let points = |count: usize| (0..count).map(|k| Point::new(k as f64, 1.0, 0.0)).collect::<Vec<_>>();
    let mut scene = Scene::new();
    let mut add = |name: &str, geometry: Geometry| scene.add(Object::new(name, geometry)).unwrap();
    add("rig", Geometry::Group);
    add("pl", Polyline { points: points(3), closed: false }.into());
    add("dots", Cloud { points: points(5) }.into());
    add(
        "sail",
        Mesh::new(
            [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(|[x, y]| Point::new(x, y, 0.0)).to_vec(),
            &[[0, 1, 2]],
        )
        .unwrap()
        .into(),
    );
    let file = write(&scene);
    let (whole, report) = read(&file);
    assert!(!report.notes.iter().any(|note| note.contains("empty groups")), "{report:?}");
    assert_eq!(whole.object("dots").unwrap().geometry(), scene.object("dots").unwrap().geometry());
    let without = |names: &[&str]| {
        let mut document = json_of(&file);
        for node in document["nodes"].as_array_mut().unwrap() {
            if names.contains(&node["name"].as_str().unwrap()) {
                node.as_object_mut().unwrap().remove("mesh");
            }
        }
        let mut passed = Memory::new("passed.gltf", document.to_string());
        passed.siblings.clone_from(&file.siblings);
        let (scene, report) = read(&passed);
        for name in names {
            assert!(matches!(scene.object(name).unwrap().geometry(), Geometry::Group));
        }
        report.notes.into_iter().filter(|note| note.contains("empty groups")).collect::<Vec<_>>()
    };
    for (names, said) in [
        (&["pl", "dots"][..], "\"Loose Edges\" and \"Loose Points\" under Data > Mesh"),
        (&["pl"][..], "tick \"Loose Edges\" under"),
        (&["dots"][..], "tick \"Loose Points\" under"),
    ] {
        let [note] = &without(names)[..] else { panic!("{names:?}") };
        assert!(note.contains(said), "{note}");
        for name in ["rig", "pl", "dots", "sail"] {
            assert_eq!(note.contains(&format!("\"{name}\"")), names.contains(&name), "{note}");
        }
    }
    // A mesh that is gone was taken away: nobody leaves faces behind.
    assert!(without(&["sail"]).is_empty());
}
