//! Files whose vertices are split, as exporters write them that keep normals by vertex: what `subdivide` makes of them, welded and not.

use std::fmt::Write;

use loftsman_tests::bench::Bench;
use serde_json::{Value, json};

use crate::LOFTSMAN;

/// The faces of a box, whose corner `k` is at `[k & 1, k >> 1 & 1, k >> 2]`.
const BOX: [[usize; 4]; 6] =
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
/// Of each its normal.
const NORMALS: [[i32; 3]; 6] = [[0, 0, -1], [0, 0, 1], [0, -1, 0], [0, 1, 0], [-1, 0, 0], [1, 0, 0]];

fn corner(k: usize) -> [f64; 3] {
    [(k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64]
}

/// An OBJ of points and faces.
fn obj(points: &[[f64; 3]], faces: &[Vec<usize>]) -> String {
    let mut text = "# Units: mm\no cage\n".to_owned();
    points.iter().for_each(|[x, y, z]| writeln!(text, "v {x} {y} {z}").unwrap());
    for face in faces {
        let corners: Vec<String> = face.iter().map(|v| (v + 1).to_string()).collect();
        writeln!(text, "f {}", corners.join(" ")).unwrap();
    }
    text
}

fn whole() -> (Vec<[f64; 3]>, Vec<Vec<usize>>) {
    ((0..8).map(corner).collect(), BOX.map(Vec::from).to_vec())
}

/// Each face with vertices of its own.
fn split((points, faces): (Vec<[f64; 3]>, Vec<Vec<usize>>)) -> (Vec<[f64; 3]>, Vec<Vec<usize>>) {
    let mut next = 0..;
    let own = faces.iter().map(|f| f.iter().map(|_| next.next().unwrap()).collect()).collect();
    (faces.iter().flatten().map(|&v| points[v]).collect(), own)
}

/// Two boxes that have one corner in common: one vertex for both, or one for each.
fn touching(one: bool) -> (Vec<[f64; 3]>, Vec<Vec<usize>>) {
    let (mut points, mut faces) = whole();
    points.extend((0..8).map(corner).map(|p| p.map(|x| x + 1.0)));
    faces.extend(BOX.map(|f| f.map(|v| v + 8).to_vec()));
    if one {
        // Vertex 8 lies where vertex 7 does.
        points.remove(8);
        faces.iter_mut().flatten().for_each(|v| match *v {
            8 => *v = 7,
            other => *v = other - usize::from(other > 8),
        });
    }
    (points, faces)
}

/// The result of a recipe of one step on a file: what the step notes, and the object.
fn subdivided(bench: &Bench, file: &str, fields: Value) -> (String, Value) {
    let mut step = fields;
    step["op"] = "subdivide".into();
    let recipe = json!({ "input": file, "output": "out.loft.json", "step": [step] });
    bench.write("recipe.json", recipe.to_string());
    let report = bench.json(&["run", "recipe.json"]);
    let document: Value = serde_json::from_slice(&bench.read("out.loft.json")).unwrap();
    (report["steps"][0]["notes"].to_string(), document["objects"][0].clone())
}

/// All points, sorted.
fn points(of: &Value) -> Vec<[f64; 3]> {
    let mut all: Vec<[f64; 3]> = serde_json::from_value(of["points"].clone()).unwrap();
    all.sort_by(|a, b| a.partial_cmp(b).unwrap());
    all
}

/// Two lists of points, which are the same but for rounding.
fn same(a: &[[f64; 3]], b: &[[f64; 3]], digits: f64) {
    assert_eq!(a.len(), b.len());
    let off = a.iter().flatten().zip(b.iter().flatten()).map(|(x, y)| (x - y).abs());
    assert!(off.fold(0.0, f64::max) < digits, "{a:?}\n{b:?}");
}

#[test]
fn an_obj_with_a_vertex_for_each_corner_of_a_face_is_one_cage() {
    let bench = LOFTSMAN.bench();
    let ((points_of, faces), (own, apart)) = (whole(), split(whole()));
    bench.write("whole.obj", obj(&points_of, &faces)).write("split.obj", obj(&own, &apart));
    let fields = |weld: bool| json!({ "levels": 2, "limit": true, "weld": weld });
    let (_, expected) = subdivided(&bench, "whole.obj", fields(false));
    let (note, welded) = subdivided(&bench, "split.obj", fields(true));
    assert!(note.contains("16 vertices are made one with another in the same place"), "{note}");
    let (expected, welded) = (&expected["mesh"], &welded["mesh"]);
    same(&points(welded), &points(expected), 1e-15);
    assert_eq!(points(welded).len(), 98);
    assert_eq!(welded["faces"].as_array().unwrap().len(), 96);
    // As it is: six sheets, of 25 points each, whose corners stay.
    let (note, sheets) = subdivided(&bench, "split.obj", fields(false));
    let told = "vertices 0 and 8 are in one place, and so are 15 others: they stay apart, and a seam between them is a boundary; weld = true makes them one";
    assert!(note.contains(told), "{note}");
    let sheets = points(&sheets["mesh"]);
    assert_eq!(sheets.len(), 150);
    assert_eq!(sheets.iter().filter(|p| **p == [1.0; 3]).count(), 3);
}

#[test]
fn a_fan_that_touches_another_keeps_a_vertex_of_its_own() {
    let bench = LOFTSMAN.bench();
    let fields = |weld: bool| json!({ "surface": true, "weld": weld });
    let files = [("two.obj", touching(false)), ("one.obj", touching(true))];
    for (name, (points_of, faces)) in &files {
        bench.write(name, obj(points_of, faces));
        let (own, apart) = split((points_of.clone(), faces.clone()));
        bench.write(&format!("split-{name}"), obj(&own, &apart));
    }
    // Vertices that may not be one stay two, and that is said; one vertex for both is refused, with what does.
    let (note, expected) = subdivided(&bench, "two.obj", fields(false));
    let told = "vertices 7 and 8 are in one place: they stay apart, for one vertex would join several fans of faces there";
    assert!(note.contains(told) && !note.contains("weld = true"), "{note}");
    bench.write(
        "recipe.json",
        json!({ "input": "one.obj", "output": "no.loft.json",
        "step": [{ "op": "subdivide", "surface": true }] })
        .to_string(),
    );
    bench.fails(&["run", "recipe.json"], 1, &["vertex 7 joins several fans", "weld = true does"]);
    for (file, merged) in [
        ("two.obj", "no vertex is"),
        ("one.obj", "no vertex is"),
        ("split-two.obj", "32 "),
        ("split-one.obj", "32 "),
    ] {
        let (note, object) = subdivided(&bench, file, fields(true));
        assert!(note.contains(&format!("; {merged}")), "{file}: {note}");
        assert!(note.contains("at 1 place vertices stay apart") && note.contains("at [1, 1, 1]"), "{note}");
        let (cage, wanted) = (&object["shape"], &expected["shape"]);
        assert_eq!(points(cage), points(wanted), "{file}");
        assert_eq!(points(cage).iter().filter(|p| **p == [1.0; 3]).count(), 2);
        assert_eq!(cage["faces"].as_array().unwrap().len(), 12);
    }
}

/// A GLB of the box in triangles, with four vertices for each side, for each has a normal.
fn glb() -> Vec<u8> {
    let mut bin = Vec::new();
    let mut floats = |values: &mut dyn Iterator<Item = f64>| {
        values.for_each(|x| bin.extend((x as f32).to_le_bytes()));
    };
    floats(&mut BOX.iter().flatten().flat_map(|&k| corner(k)));
    floats(&mut NORMALS.iter().flat_map(|n| [n; 4]).flatten().map(|&x| f64::from(x)));
    for k in 0..6_u16 {
        [0, 1, 2, 0, 2, 3].into_iter().for_each(|c: u16| bin.extend((4 * k + c).to_le_bytes()));
    }
    let view =
        |offset: usize, length: usize| json!({ "buffer": 0, "byteOffset": offset, "byteLength": length });
    let vectors =
        |view: usize| json!({ "bufferView": view, "componentType": 5126, "count": 24, "type": "VEC3" });
    let mut positions = vectors(0);
    (positions["min"], positions["max"]) = (json!([0, 0, 0]), json!([1, 1, 1]));
    let mut text = json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0, "name": "cage" }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "NORMAL": 1 }, "indices": 2 }] }],
        "accessors": [positions, vectors(1), { "bufferView": 2, "componentType": 5123, "count": 36, "type": "SCALAR" }],
        "bufferViews": [view(0, 288), view(288, 288), view(576, 72)],
        "buffers": [{ "byteLength": bin.len() }]
    })
    .to_string()
    .into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let chunk = |kind: &[u8; 4], data: &[u8]| [&(data.len() as u32).to_le_bytes(), &kind[..], data].concat();
    let chunks = [chunk(b"JSON", &text), chunk(b"BIN\0", &bin)].concat();
    [&b"glTF"[..], &2_u32.to_le_bytes(), &(12 + chunks.len() as u32).to_le_bytes(), &chunks].concat()
}

#[test]
fn a_glb_with_a_vertex_for_each_normal_is_one_cage() {
    let bench = LOFTSMAN.bench();
    let triangles: Vec<Vec<usize>> =
        BOX.iter().flat_map(|f| [vec![f[0], f[1], f[2]], vec![f[0], f[2], f[3]]]).collect();
    bench.write("box.glb", glb()).write("box.obj", obj(&whole().0, &triangles));
    let fields = |weld: bool| json!({ "levels": 3, "limit": true, "weld": weld });
    let (_, expected) = subdivided(&bench, "box.obj", fields(false));
    let (note, welded) = subdivided(&bench, "box.glb", fields(true));
    assert!(note.contains("16 vertices are made one with another in the same place"), "{note}");
    same(&points(&welded["mesh"]), &points(&expected["mesh"]), 1e-15);
    let (note, sheets) = subdivided(&bench, "box.glb", fields(false));
    assert!(note.contains("are in one place") && note.contains("weld = true makes them one"), "{note}");
    // Six sheets of two triangles each, of which the two corners with one triangle stay where they are.
    let is_corner = |p: &&[f64; 3]| p.iter().all(|x| *x == 0.0 || *x == 1.0);
    assert_eq!(points(&sheets["mesh"]).iter().filter(is_corner).count(), 12);
    // The cage of a surface: eight vertices, closed, with an inside.
    let (note, cage) = subdivided(&bench, "box.glb", json!({ "surface": true, "weld": true }));
    assert!(note.contains("8 points and 12 faces are the cage"), "{note}");
    assert_eq!(points(&cage["shape"]), points(&json!({ "points": whole().0 })));
    let told = bench.json(&["info", "out.loft.json"]);
    assert!(told["objects"][0]["volume"].as_f64().is_some_and(|v| v > 0.1 && v < 1.0), "{told}");
}
