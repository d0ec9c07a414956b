//! Whatever the bytes: a scene, or one error that says where and what, never a panic, never more memory than a small
//! multiple of the file.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may stop at what should not be")]

use loftsman_gltf::Gltf;
use loftsman_kernel::plugin::{Format, Memory, ReadOptions, ReadReport};
use loftsman_kernel::scene::{Geometry, Scene};
use proptest::prelude::*;
use serde_json::{Value, json};

fn read(document: &Value) -> Result<(Scene, ReadReport), String> {
    read_bytes("h.gltf", document.to_string().into_bytes())
}

fn read_bytes(name: &str, bytes: Vec<u8>) -> Result<(Scene, ReadReport), String> {
    let mut file = Memory::new(name, bytes);
    file.siblings.insert("short.bin".to_owned(), vec![0; 8]);
    let result = Gltf.read(&file, &ReadOptions::default()).map_err(|e| e.to_string());
    if let Ok((scene, report)) = &result {
        assert!(report.adds_up(), "{report:?}");
        scene.check().unwrap();
    }
    result
}

#[track_caller]
fn refused(document: &Value, parts: &[&str]) {
    says(&read(document).map(|_| ()).unwrap_err(), parts);
}

#[track_caller]
fn says(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "\"{part}\" is missing in: {message}");
    }
    assert!(message.chars().count() < 500, "too long: {message}");
}

/// A triangle: three positions as floats, three indices as bytes.
fn triangle() -> Value {
    let bin = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAECAA==";
    json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": "t", "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" },
            { "bufferView": 0, "byteOffset": 36, "componentType": 5121, "count": 3, "type": "SCALAR" }
        ],
        "bufferViews": [{ "buffer": 0, "byteLength": 40 }],
        "buffers": [{ "byteLength": 40, "uri": format!("data:;base64,{bin}") }]
    })
}

/// The triangle with one value changed.
fn with(pointer: &str, value: Value) -> Value {
    let mut document = triangle();
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    let parent = document.pointer_mut(parent).unwrap();
    match parent {
        Value::Array(list) => list[key.parse::<usize>().unwrap()] = value,
        other => other[key] = value,
    }
    document
}

#[test]
fn the_triangle_itself_is_read() {
    let (scene, report) = read(&triangle()).unwrap();
    let Geometry::Mesh(mesh) = scene.object("t").unwrap().geometry() else { panic!("no mesh") };
    assert_eq!((mesh.points().len(), mesh.corners()), (3, [0, 1, 2].as_slice()));
    assert!(report.left_out.is_empty());
}

#[test]
fn documents_that_are_none_say_so() {
    refused(&json!({}), &["asset", "no asset"]);
    refused(&with("/asset/version", json!("1.0")), &["asset.version", "1.0", "convert"]);
    refused(&with("/asset/version", json!("3.0")), &["asset.version", "3.0"]);
    refused(&with("/asset", json!({ "version": "2.1", "minVersion": "2.1" })), &["asset.version", "2.1"]);
    assert!(
        read(&with("/asset", json!({ "version": "2.1" }))).is_ok(),
        "later minor versions are compatible"
    );
    refused(&with("/accessors/0/count", json!(-1)), &["accessors[0].count"]);
    refused(&with("/nodes/0/mesh", json!(1.5)), &["nodes[0].mesh", "1.5"]);
    refused(&with("/nodes/0/translation", json!([1, 2])), &["nodes[0].translation"]);
    let bytes = |text: &str| read_bytes("h.gltf", text.as_bytes().to_vec()).map(|_| ()).unwrap_err();
    says(&bytes(""), &["no JSON"]);
    says(&bytes("hello"), &["neither a GLB"]);
    says(&bytes("{\"asset\":"), &["ends in the middle", "cut off"]);
    let cut = bytes("{\"asset\":{\"version\":\"2.0\"},\n");
    assert!(cut.contains("line") && !cut.contains('?'), "{cut}");
    says(&bytes(&"{\"a\":".repeat(100_000)), &["cut off"]);
    says(&bytes(&"[".repeat(200_000)), &["neither a GLB"]);
    says(&bytes(&format!("{{\"nodes\":{}", "[".repeat(200_000))), &["h.gltf"]);
    let deep = format!(
        "{{\"asset\":{{\"version\":\"2.0\",\"extras\":{0}{1}}}}}",
        "[".repeat(200_000),
        "]".repeat(200_000)
    );
    assert!(read_bytes("h.gltf", deep.into_bytes()).is_ok(), "extras are not even looked at");
}

#[test]
fn glb_headers_and_chunks_are_checked() {
    let mut json = triangle().to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let glb = |version: u32, extra: i64, chunk_extra: i64, kind: &[u8; 4]| {
        let mut bytes = b"glTF".to_vec();
        bytes.extend(version.to_le_bytes());
        bytes.extend(((20 + json.len()) as i64 + extra).to_le_bytes()[..4].iter());
        bytes.extend((json.len() as i64 + chunk_extra).to_le_bytes()[..4].iter());
        bytes.extend(kind);
        bytes.extend(&json);
        bytes
    };
    let error = |bytes: Vec<u8>| read_bytes("h.glb", bytes).map(|_| ()).unwrap_err();
    assert!(read_bytes("h.glb", glb(2, 0, 0, b"JSON")).is_ok());
    says(&error(glb(1, 0, 0, b"JSON")), &["byte 4", "version 1"]);
    says(&error(glb(2, 4, 0, b"JSON")), &["byte 8", "4 are missing"]);
    says(&error(glb(2, 0, 4, b"JSON")), &["byte 12", "only"]);
    says(&error(glb(2, 0, i64::from(u32::MAX) - json.len() as i64, b"JSON")), &["byte 12"]);
    says(&error(glb(2, 0, 0, b"BIN\0")), &["first chunk"]);
    says(&error(glb(2, -8, -8, b"JSON")), &["cut off"]);
    says(&error(b"glTF\x02\0\0".to_vec()), &["within its header"]);
    let mut trailing = glb(2, 0, 0, b"JSON");
    trailing.extend(b"more");
    assert!(read_bytes("h.glb", trailing).unwrap().1.notes[0].contains("4 bytes after the end"));
    for cut in 0..200 {
        let bytes = glb(2, 0, 0, b"JSON");
        assert!(read_bytes("h.glb", bytes[..cut].to_vec()).is_err());
    }
}

#[test]
fn buffers_views_and_accessors_stay_in_their_bounds() {
    refused(&with("/buffers/0/byteLength", json!(41)), &["buffers[0]", "41 bytes", "only 40"]);
    refused(&with("/buffers/0/uri", json!("short.bin")), &["buffers[0]", "short.bin", "only 8"]);
    refused(&with("/buffers/0/uri", json!("gone.bin")), &["buffers[0]", "\"gone.bin\"", "missing"]);
    for path in
        ["../../etc/passwd", "/etc/passwd", "a/../../b", "..%2F..%2Fetc%2Fpasswd", "file:///etc/passwd"]
    {
        refused(&with("/buffers/0/uri", json!(path)), &["buffers[0]"]);
    }
    refused(&with("/buffers/0", json!({ "byteLength": 40 })), &["buffers[0]", "no uri"]);
    refused(&with("/bufferViews/0/byteLength", json!(41)), &["bufferViews[0]", "41 bytes", "only 40"]);
    refused(&with("/bufferViews/0/byteOffset", json!(u64::MAX)), &["bufferViews[0]"]);
    refused(&with("/bufferViews/0/buffer", json!(7)), &["buffers[7]", "the last of the buffers is 0"]);
    refused(&with("/bufferViews/0/byteStride", json!(0)), &["bufferViews[0].byteStride", "0 bytes"]);
    refused(&with("/bufferViews/0/byteStride", json!(8)), &["accessors[0]", "overlap", "stride of 8"]);
    refused(
        &with("/accessors/0/count", json!(4)),
        &["accessors[0]", "do not fit", "primitives[0].attributes.POSITION"],
    );
    refused(&with("/accessors/0/count", json!(u64::MAX)), &["accessors[0]", "do not fit"]);
    refused(&with("/accessors/0/byteOffset", json!(u64::MAX)), &["accessors[0]", "do not fit"]);
    refused(&with("/accessors/0/bufferView", json!(9)), &["bufferViews[9]"]);
    refused(&with("/accessors/0/componentType", json!(5124)), &["accessors[0]", "5124"]);
    refused(&with("/accessors/0/componentType", json!(4_294_972_422_u64)), &["accessors[0]", "4294972422"]);
    refused(&with("/accessors/0/type", json!("VEC5")), &["accessors[0]", "VEC5"]);
    refused(&with("/accessors/0/type", json!("MAT4")), &["accessors[0]", "MAT4"]);
    refused(&with("/accessors/1/componentType", json!(5120)), &["accessors[1]", "unsigned"]);
    refused(&with("/meshes/0/primitives/0/mode", json!(7)), &["meshes[0].primitives[0].mode", "7"]);
    refused(
        &with("/meshes/0/primitives/0/indices", json!(5)),
        &["meshes[0].primitives[0].indices", "accessors[5]"],
    );
    refused(&with("/meshes/0/primitives/0/attributes", json!({ "POSITION": 1 })), &["POSITION", "VEC3"]);
    refused(
        &with("/meshes/0/primitives/0/attributes", json!({ "POSITION": 0, "NORMAL": 1 })),
        &["accessors[1]", "elements of 1 numbers where 3"],
    );
    refused(&with("/meshes/0/primitives/0/material", json!(3)), &["materials[3]", "no materials"]);
    // An index that no vertex has: the last of the three bytes says 200.
    let bin = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAHIAA==";
    refused(
        &with("/buffers/0/uri", json!(format!("data:;base64,{bin}"))),
        &["accessors[1]", "index 2 is 200", "only 3"],
    );
    // NaN as the first coordinate.
    let bin = "AADAfwAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAECAA==";
    refused(
        &with("/buffers/0/uri", json!(format!("data:;base64,{bin}"))),
        &["accessors[0]", "vertex 0", "NaN", "finite"],
    );
}

#[test]
fn sparse_accessors_are_checked() {
    let sparse = |count: u64, index_type: u64, index_offset: u64| {
        json!({
            "componentType": 5126, "count": 3, "type": "VEC3",
            "sparse": {
                "count": count,
                "indices": { "bufferView": 0, "byteOffset": index_offset, "componentType": index_type },
                "values": { "bufferView": 0 }
            }
        })
    };
    // Indices 0, 1, 2 are at byte 36, three positions at byte 0: they are put over zeros.
    let (scene, _) = read(&with("/accessors/0", sparse(3, 5121, 36))).unwrap();
    assert_eq!(scene.objects()[0].geometry().points()[1].x, 1.0);
    refused(&with("/accessors/0", sparse(4, 5121, 36)), &["accessors[0]", "sparse elements"]);
    refused(&with("/accessors/0", sparse(3, 5126, 0)), &["accessors[0]", "5126"]);
    refused(&with("/accessors/0", sparse(3, 5121, 0)), &["accessors[0].sparse.indices", "not above"]);
    refused(
        &with("/accessors/0", sparse(1, 5121, 14)),
        &["accessors[0].sparse.indices", "sparse index 0 is 128"],
    );
    refused(&with("/accessors/0", sparse(u64::MAX, 5125, 0)), &["accessors[0]", "sparse elements"]);
}

#[test]
fn a_few_bytes_get_no_gigabytes() {
    let zeros = |count: u64| json!({ "componentType": 5126, "count": count, "type": "VEC3" });
    refused(&with("/accessors/0", zeros(1_000_000_000)), &["POSITION", "64 times", "split"]);
    // Many primitives of the same vertices, many nodes of the same mesh.
    let big = 400_000;
    let mut many = with("/accessors/0", zeros(big));
    many["meshes"] = Value::Array(vec![many["meshes"][0].clone(); 40]);
    many["nodes"] = (0..40).map(|i| json!({ "mesh": i })).collect();
    many["scenes"][0]["nodes"] = (0..40).collect();
    let (scene, _) = read(&many).unwrap();
    let first = scene.objects()[0].geometry_id();
    assert!(scene.objects().iter().all(|o| o.geometry_id() == first), "the same primitives are one geometry");
    // Each of vertices of its own.
    many["accessors"] = (0..40).map(|_| zeros(big)).chain([many["accessors"][1].clone()]).collect();
    for (k, mesh) in many["meshes"].as_array_mut().unwrap().iter_mut().enumerate() {
        mesh["primitives"] = json!([{ "attributes": { "POSITION": k }, "indices": 40 }]);
    }
    refused(&many, &["64 times"]);
    let mut same = with("/accessors/0", zeros(big));
    same["nodes"] = (0..1000).map(|_| json!({ "mesh": 0 })).collect();
    same["scenes"][0]["nodes"] = (0..1000).collect();
    // They share it, as long as they do not bend it, each in its own way.
    let (scene, _) = read(&same).unwrap();
    let first = scene.objects()[0].geometry_id();
    assert!(scene.objects().len() == 1000 && scene.objects().iter().all(|o| o.geometry_id() == first));
    same["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": 0 }]);
    same["nodes"] = (1..=1000).map(|k| json!({ "mesh": 0, "weights": [k] })).collect();
    refused(&same, &["too many nodes bend the same mesh"]);
    // Their names are their own.
    let mut named = triangle();
    named["meshes"][0]["name"] = json!("n".repeat(1 << 20));
    named["nodes"] = (0..1000).map(|_| json!({ "mesh": 0 })).collect();
    named["scenes"][0]["nodes"] = (0..1000).collect();
    assert!(read(&named).unwrap_err().contains("64 times"));
    let mut empty = triangle();
    empty["nodes"] = Value::Array(vec![json!({}); 2_000_000]);
    empty["scenes"][0]["nodes"] = (0..2_000_000).collect();
    refused(&empty, &["64 times"]);
    // An animation that never ends.
    let mut endless = triangle();
    endless["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": 0 }]);
    endless["accessors"].as_array_mut().unwrap().extend([
        // Times 0, 1, and then 2^100 or so: from the positions' bytes 0, 1 and a pair that is large.
        json!({ "bufferView": 1, "componentType": 5126, "count": 3, "type": "SCALAR" }),
        json!({ "componentType": 5126, "count": 3, "type": "SCALAR" }),
    ]);
    endless["bufferViews"].as_array_mut().unwrap().push(json!({ "buffer": 1, "byteLength": 12 }));
    let times = "data:;base64,AAAAAAAAgD8AAIBx";
    endless["buffers"].as_array_mut().unwrap().push(json!({ "byteLength": 12, "uri": times }));
    endless["animations"] = json!([{
        "channels": [{ "sampler": 0, "target": { "node": 0, "path": "weights" } }],
        "samplers": [{ "input": 2, "output": 3 }]
    }]);
    refused(&endless, &["animations[0].channels[0]", "64 times"]);
}

#[test]
fn hierarchies_that_are_none_are_refused() {
    refused(&with("/scenes/0/nodes", json!([5])), &["scenes[0].nodes", "node 5 does not exist"]);
    refused(&with("/scenes/0/nodes", json!([0, 0])), &["scenes[0].nodes", "twice"]);
    refused(&with("/nodes/0/children", json!([0])), &["nodes[0].children", "hangs under itself"]);
    let nodes = json!([{ "children": [1] }, { "children": [2] }, { "children": [1] }]);
    refused(&with("/nodes", nodes.clone()), &["nodes[2].children", "hangs under itself"]);
    let mut cyclic = with("/nodes", json!([{ "children": [1] }, { "children": [0] }]));
    cyclic.as_object_mut().unwrap().remove("scenes");
    // A scene that is not there, also where none is.
    refused(&cyclic, &["scene", "the document has none"]);
    cyclic.as_object_mut().unwrap().remove("scene");
    refused(&cyclic, &["cyclic"]);
    refused(&with("/scene", json!(4)), &["scenes[4]"]);
    refused(&with("/nodes/0/mesh", json!(4)), &["meshes[4]"]);
    refused(&with("/nodes/0/camera", json!(0)), &["nodes[0]", "camera"]);
    refused(&with("/nodes/0/rotation", json!([0, 0, 0, 0])), &["nodes[0].rotation", "length 1"]);
    let mut matrix = vec![0.0; 16];
    matrix[3] = 1.0;
    refused(&with("/nodes/0/matrix", json!(matrix)), &["nodes[0].matrix", "0 0 0 1"]);
    // A chain of a hundred thousand nodes is deep, not wrong.
    let count = 100_000;
    let chain: Vec<Value> =
        (0..count).map(|i| if i + 1 < count { json!({ "children": [i + 1] }) } else { json!({}) }).collect();
    match read(&with("/nodes", chain.into())) {
        Ok((scene, _)) => assert_eq!(scene.objects().len(), count),
        Err(error) => says(&error, &["64 times"]),
    }
}

#[test]
fn what_a_file_needs_and_we_lack_is_refused_by_name() {
    for (extension, advice) in [
        ("KHR_draco_mesh_compression", "without compression"),
        ("EXT_meshopt_compression", "without compression"),
        ("EXT_mesh_gpu_instancing", "a node for each instance"),
        ("VENDOR_unheard_of", "without this extension"),
    ] {
        let mut document = triangle();
        document["extensionsRequired"] = json!(["KHR_mesh_quantization", extension]);
        refused(&document, &["extensionsRequired[1]", extension, advice]);
    }
    // Used, but not said to be needed.
    let draco = json!({ "KHR_draco_mesh_compression": { "bufferView": 0 } });
    refused(
        &with("/meshes/0/primitives/0/extensions", draco),
        &["primitives[0]", "KHR_draco_mesh_compression"],
    );
    let meshopt = json!({ "EXT_meshopt_compression": { "buffer": 0 } });
    refused(&with("/bufferViews/0/extensions", meshopt), &["bufferViews[0]", "EXT_meshopt_compression"]);
}

#[test]
fn what_we_have_nothing_for_is_counted() {
    let mut document = triangle();
    document["skins"] = json!([{ "joints": [0] }]);
    document["cameras"] = json!([{ "type": "perspective" }]);
    document["nodes"] = json!([
        { "mesh": 0, "skin": 0, "extras": { "price": 3 }, "extensions": { "KHR_lights_punctual": { "light": 0 } } },
        { "camera": 0 }, { "name": "elsewhere" }
    ]);
    document["scenes"][0]["nodes"] = json!([0, 1]);
    document["meshes"][0]["primitives"][0]["attributes"] =
        json!({ "POSITION": 0, "JOINTS_0": 0, "_HEAT": 0 });
    document["accessors"][0]["extras"] = json!({ "from": "elsewhere" });
    document["meshes"].as_array_mut().unwrap().push(json!({ "primitives": [] }));
    document["animations"] = json!([{
        "channels": [{ "sampler": 0, "target": { "node": 0, "path": "rotation" } }],
        "samplers": [{ "input": 0, "output": 0 }]
    }]);
    document["images"] =
        json!([{ "uri": "../../etc/passwd" }, { "uri": "http://x/y.png" }, { "uri": "ok%20.png" }]);
    document["textures"] = json!([{ "source": 0 }]);
    document["materials"] = json!([{ "normalTexture": { "index": 0 } }]);
    let (scene, report) = read(&document).unwrap();
    for what in [
        "skin",
        "camera",
        "KHR_lights_punctual",
        "extras of an accessor",
        "JOINTS_0",
        "_HEAT",
        "rotation",
        "node outside",
        "mesh that no node",
        "leads out of the folder",
        "http://x/y.png",
        "texture whose picture",
    ] {
        assert!(report.left_out.keys().any(|k| k.contains(what)), "{what}: {report:#?}");
    }
    assert_eq!((scene.objects().len(), scene.images.len(), scene.materials.len()), (2, 1, 1));
    assert_eq!(scene.objects()[0].statement("gltf extras"), Some(r#"{"price":3}"#));
}

#[test]
fn tangents_of_three_numbers_are_refused() {
    let attributes = json!({ "POSITION": 0, "TANGENT": 0 });
    refused(&with("/meshes/0/primitives/0/attributes", attributes), &["accessors[0]", "3 numbers where 4"]);
}

#[test]
fn morph_targets_bend_by_weights_or_are_counted() {
    let targets = json!([{ "POSITION": 0 }, { "POSITION": 0 }]);
    let mut document = with("/meshes/0/primitives/0/targets", targets);
    let corner = |scene: &Scene, k: usize| scene.objects()[k].geometry().points()[1].x;
    let unmoved = corner(&read(&triangle()).unwrap().0, 0);
    let (scene, report) = read(&document).unwrap();
    let counted = |report: &ReadReport| {
        report
            .left_out
            .iter()
            .filter(|(why, _)| why.contains("nothing animates"))
            .map(|(_, n)| n)
            .sum::<usize>()
    };
    assert_eq!((corner(&scene, 0), counted(&report)), (unmoved, 2));
    // The mesh's own weights show its default shape; a node's come before them, whichever node is first.
    document["meshes"][0]["weights"] = json!([0.5, 0.25]);
    document["nodes"] =
        json!([{ "mesh": 0 }, { "mesh": 0, "weights": [1, 1] }, { "mesh": 0, "weights": [0, 0] }]);
    document["scenes"][0]["nodes"] = json!([0, 1, 2]);
    let (scene, report) = read(&document).unwrap();
    assert_eq!([0, 1, 2].map(|k| corner(&scene, k) / unmoved), [1.75, 3.0, 1.0]);
    assert_eq!(counted(&report), 2);
    document["meshes"][0]["weights"].take();
    let (scene, _) = read(&document).unwrap();
    assert_eq!([0, 1, 2].map(|k| corner(&scene, k) / unmoved), [1.0, 3.0, 1.0]);
}

#[test]
fn primitives_without_sense_are_left_out() {
    let left_out = |document: &Value| read(document).unwrap().1.left_out;
    assert!(
        left_out(&with("/accessors/1/count", json!(2)))
            .contains_key("vertex left over at the end of a primitive")
    );
    assert!(left_out(&with("/accessors/1/count", json!(0))).contains_key("primitive without vertices"));
    let none = with("/meshes/0/primitives/0/attributes", json!({}));
    assert!(left_out(&none).contains_key("primitive without positions"));
    let flat = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAEBAA==";
    let flat = with("/buffers/0/uri", json!(format!("data:;base64,{flat}")));
    assert!(left_out(&flat).contains_key("triangle that uses a vertex twice"));
}

#[test]
fn extras_that_lie_change_nothing() {
    for (own, what) in [
        (json!("{"), "cannot be read"),
        (json!(r#"{"curve":{"degree":3,"knots":[0,1],"points":[[0,0,0]]}}"#), "exact spline that cannot be"),
        (
            json!(r#"{"curve":{"degree":1,"knots":[0,0,1,1],"points":[[0,0,0],[1,0,0]]},"shown_by":"0"}"#),
            "changed since",
        ),
    ] {
        let (scene, report) = read(&with("/nodes/0/extras", json!({ "loftsman": own }))).unwrap();
        assert_eq!(scene.objects()[0].geometry().kind(), "mesh");
        assert!(report.left_out.keys().any(|k| k.contains(what)), "{report:?}");
    }
    let noted = json!({ "loftsman": r#"{"transform":[[0,0,0,0],[0,0,0,0],[0,0,0,0],[0,0,0,1]],"place":[[0,0,0,0],[0,0,0,0],[0,0,0,0],[0,0,0,1]]}"# });
    let (scene, _) = read(&with("/nodes/0/extras", noted)).unwrap();
    assert_eq!(scene.objects()[0].transform, None);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn altered_bytes_do_no_harm(at in prop::collection::vec((0.0..1.0_f64, any::<u8>()), 1..6), glb: bool) {
        let mut bytes = triangle().to_string().into_bytes();
        if glb {
            bytes.resize(bytes.len().next_multiple_of(4), b' ');
            let mut head = b"glTF\x02\0\0\0".to_vec();
            head.extend((20 + bytes.len() as u32).to_le_bytes());
            head.extend((bytes.len() as u32).to_le_bytes());
            head.extend(b"JSON");
            bytes.splice(0..0, head);
        }
        for (place, byte) in at {
            let place = (place * bytes.len() as f64) as usize;
            bytes[place] = byte;
        }
        let _ = read_bytes("h.gltf", bytes);
    }
}
