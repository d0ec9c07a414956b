//! OBJ files of other programs, and what we make of them: Blender sees the same.

use std::path::PathBuf;

use loftsman_tests::oracle::{Oracle, list, number, object, text};
use serde_json::{Value, json};

use crate::save;

use crate::LOFTSMAN;

/// What Blender says of an object that must not change: names, counts, areas, boxes, and every layer by its kind.
const SAME: &[&str] = &[
    "name",
    "type",
    "vertices",
    "edges",
    "faces",
    "face_sizes",
    "smooth_faces",
    "components",
    "loose_vertices",
    "wire_edges",
    "area",
    "volume_signed",
    "wire_length",
    "bbox",
    "materials",
    "faces_per_material_slot",
    "uv_layers",
    "attributes",
    "custom_normals",
    "corner_normals",
];

fn alike(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap(), b.as_f64().unwrap());
            (a - b).abs() <= 1e-5 * a.abs().max(1.0)
        }
        (Value::Array(a), Value::Array(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| alike(a, b)),
        (Value::Object(a), Value::Object(b)) => {
            a.len() == b.len() && a.iter().all(|(key, a)| b.get(key).is_some_and(|b| alike(a, b)))
        }
        _ => a == b,
    }
}

#[test]
fn blender_sees_the_same_meshes_before_and_after() {
    let folder = tempfile::tempdir().unwrap();
    let data = loftsman_tests::repository().join("tests/data/obj");
    let names = [
        "box_longline",
        "concave_polygon",
        "cube_with_vertexcolors",
        "dodecahedron_poly",
        "hundred_cubes",
        "icosahedron",
        "moebius",
        "spider",
        "spot",
        "testmixed",
    ];
    let mut files: Vec<PathBuf> = Vec::new();
    for side in ["theirs", "ours"] {
        std::fs::create_dir(folder.path().join(side)).unwrap();
    }
    for name in names {
        let (theirs, ours) = (format!("theirs/{name}.obj"), format!("ours/{name}.obj"));
        std::fs::copy(data.join(format!("{name}.obj")), folder.path().join(&theirs)).unwrap();
        LOFTSMAN.done(folder.path(), &["convert", &theirs, &ours]);
        files.extend([folder.path().join(theirs), folder.path().join(ours)]);
    }
    let Some(reports) = Oracle::Blender.ask(&files, &[]) else { return };
    for (pair, name) in reports.chunks(2).zip(names) {
        let (theirs, ours) = (list(&pair[0], "objects"), list(&pair[1], "objects"));
        assert_eq!(theirs.len(), ours.len(), "{name}");
        for (a, b) in theirs.iter().zip(ours) {
            for key in SAME {
                assert!(alike(&a[key], &b[key]), "{name}, {key}:\n{}\n{}", a[key], b[key]);
            }
        }
    }
}

#[test]
fn surfaces_are_seen_as_meshes_and_their_exact_form_disturbs_nobody() {
    let folder = tempfile::tempdir().unwrap();
    let patch = json!({
        "u": { "degree": 2, "periodic": false, "knots": [0, 0, 0, 1, 1, 1] },
        "v": { "degree": 1, "periodic": false, "knots": [0, 0, 2, 2] },
        "points": [[[0, 0, 0], [0, 3, 0]], [[1, 0, 2], [1, 3, 2]], [[2, 0, 0], [2, 3, 0]]],
    });
    let objects = [
        json!({ "name": "roof", "surface": patch }),
        json!({ "name": "rib", "curve": { "degree": 1, "periodic": false, "knots": [0, 0, 1, 1], "points": [[0, 0, 0], [1, 1, 1]] } }),
        json!({ "name": "floor", "mesh": { "points": [[0, 0, 0], [2, 0, 0], [2, 3, 0], [0, 3, 0]], "faces": [[0, 1, 2, 3]] } }),
    ];
    save(folder.path(), "a.loft.json", &json!({ "loftsman": 1, "unit": "m", "up": "z", "objects": objects }));
    LOFTSMAN.done(folder.path(), &["convert", "a.loft.json", "a.obj"]);
    let file = folder.path().join("a.obj");
    assert!(std::fs::read_to_string(&file).unwrap().contains("\nsurf 0 1 0 2 "));
    let Some(reports) = Oracle::Blender.ask(std::slice::from_ref(&file), &[]) else { return };
    assert_eq!(list(&reports[0], "objects").len(), 3);
    assert_eq!(text(object(&reports[0], "rib"), "type"), "CURVE");
    // The parabola z = x (2 - x) from 0 to 2, along 3: its length is the integral of √(1 + (2 - 2 x)²).
    let length = 0.5 * (2.0 * 5.0_f64.sqrt() + 2.0_f64.asinh());
    let area = number(object(&reports[0], "roof"), "area");
    assert!((area / (3.0 * length) - 1.0).abs() < 2e-3, "{area}");
    assert_eq!(number(object(&reports[0], "floor"), "faces"), 1.0);
    let Some(reports) = Oracle::MeshLab.ask(&[file], &[]) else { return };
    let total: f64 = list(&reports[0], "meshes").iter().map(|m| number(m, "area")).sum();
    assert!((total / (3.0 * length + 6.0) - 1.0).abs() < 2e-3, "{total}");
}
