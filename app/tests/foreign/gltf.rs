//! glTF: clean for the Khronos validator, and Blender shows what the scene holds.

use std::collections::BTreeMap;
use std::path::Path;

use loftsman_kernel::nalgebra::{Matrix4, Point3};
use loftsman_tests::curves::{box_json, curve, curve_json, document, tube_json};
use loftsman_tests::oracle::{Oracle, list, number, object, position, text};
use serde_json::{Value, json};

use crate::save;

use crate::LOFTSMAN;

/// One of everything: curves open and closed, surfaces open, closed and rational, a mesh, a cloud, colours.
fn everything(unit: &str) -> Value {
    document(
        unit,
        &[
            json!({ "name": "rib", "curve": curve_json(&curve("uneven", 3, false, 1.0)), "color": [0.8, 0.1, 0.1, 1.0] }),
            json!({ "name": "ring", "curve": curve_json(&curve("periodic", 3, true, 1.0)) }),
            json!({ "name": "hull", "surface": tube_json(8, 6, true), "color": [0.1, 0.6, 0.2, 1.0] }),
            json!({ "name": "sheet", "surface": tube_json(7, 5, false) }),
            json!({ "name": "keel", "mesh": box_json([0.0, 0.0, 0.0], [1.0, 2.0, 3.0]), "color": [0.2, 0.2, 0.9, 0.5] }),
            json!({ "name": "scan", "cloud": { "points": [[0, 0, 0], [1, 0, 0], [0, 1, 2]] } }),
        ],
    )
}

#[test]
fn the_validator_finds_nothing_to_say() {
    let folder = tempfile::tempdir().unwrap();
    save(folder.path(), "all.loft.json", &everything("mm"));
    let only = |name: &str, object: Value| save(folder.path(), name, &document("m", &[object]));
    only("mesh.loft.json", json!({ "name": "keel", "mesh": box_json([0.0; 3], [1.0; 3]) }));
    only("curve.loft.json", json!({ "name": "rib", "curve": curve_json(&curve("clamped", 2, false, 1e-3)) }));
    only("huge.loft.json", json!({ "name": "rib", "curve": curve_json(&curve("clamped", 5, true, 1e9)) }));
    only("cloud.loft.json", json!({ "name": "a\"b/ü", "cloud": { "points": [[0, 0, 0]] } }));
    save(folder.path(), "empty.loft.json", &document("m", &[]));
    let mut files = Vec::new();
    for name in ["all", "mesh", "curve", "huge", "cloud", "empty"] {
        for extension in ["glb", "gltf"] {
            let out = format!("{name}.{extension}");
            LOFTSMAN.done(folder.path(), &["convert", &format!("{name}.loft.json"), &out]);
            files.push(folder.path().join(out));
        }
    }
    let Some(reports) = Oracle::GltfValidator.ask(&files, &[]) else { return };
    for report in reports {
        assert_eq!((&report["errors"], &report["warnings"]), (&json!(0), &json!(0)), "{report:#}");
    }
}

#[test]
fn blender_shows_what_the_scene_holds() {
    let folder = tempfile::tempdir().unwrap();
    save(folder.path(), "all.loft.json", &everything("m"));
    save(folder.path(), "small.loft.json", &everything("mm"));
    LOFTSMAN.done(folder.path(), &["convert", "all.loft.json", "all.glb"]);
    LOFTSMAN.done(folder.path(), &["convert", "small.loft.json", "small.gltf"]);
    let files = [folder.path().join("all.glb"), folder.path().join("small.gltf")];
    let Some(reports) = Oracle::Blender.ask(&files, &["--eval"]) else { return };
    for (report, unit) in reports.iter().zip([1.0, 1e-3]) {
        for name in ["rib", "ring", "hull", "sheet", "keel", "scan"] {
            assert_eq!(object(report, name)["type"], "MESH", "{name}");
        }
        // The box stands as it was written, z up, in metres: its corners and its volume say so.
        let keel = object(report, "keel");
        let corners: Vec<_> = list(keel, "bbox").iter().map(position).collect();
        for (axis, size) in [1.0, 2.0, 3.0].into_iter().enumerate() {
            assert!(
                corners[0][axis].abs() <= 1e-6
                    && (corners[1][axis] - size * unit).abs() <= 1e-6 * unit.max(0.1)
            );
        }
        let volume = number(keel, "welded_at_1e-6/volume_signed");
        assert!((volume / (6.0 * unit.powi(3)) - 1.0).abs() < 1e-5, "faces outward: {volume}");
        assert_eq!(keel["welded_at_1e-6"]["watertight"], true);
        // Curves are line strips: edges, no faces, of the curves' lengths (from chords, hence the tolerance).
        let rib = object(report, "rib");
        assert_eq!(number(rib, "faces"), 0.0);
        assert_eq!(number(rib, "wire_edges"), number(rib, "edges"));
        assert_eq!(
            number(object(report, "ring"), "vertices"),
            number(object(report, "ring"), "edges"),
            "closed"
        );
        assert_eq!(number(object(report, "scan"), "loose_vertices"), 3.0);
        // A closed surface has no seam once welded: only its two ends are boundary.
        let hull = object(report, "hull");
        assert_eq!(number(hull, "welded_at_1e-6/components"), 1.0);
        assert_eq!(number(hull, "welded_at_1e-6/euler"), 0.0, "a tube");
        assert!(
            number(hull, "corner_normals/max_degrees_from_face") < 30.0,
            "smooth normals follow the faces"
        );
        assert_eq!(number(hull, "corner_normals/corners_facing_away"), 0.0);
        // Colours: the material of each, unshiny.
        for (name, colour) in [("rib", [0.8, 0.1, 0.1]), ("hull", [0.1, 0.6, 0.2]), ("keel", [0.2, 0.2, 0.9])]
        {
            let material = text(object(report, name), "materials/0");
            let material = list(report, "materials").iter().find(|m| m["name"] == material).unwrap();
            let base: Vec<f64> = list(material, "base_colour").iter().filter_map(Value::as_f64).collect();
            assert!((0..3).all(|k| (base[k] - colour[k]).abs() < 1e-3), "{name} is {base:?}");
            assert_eq!(number(material, "metallic"), 0.0);
        }
    }
}

/// A unit square of two triangles with a material each, values by corner, a loose edge; a moved child; a curve, a
/// surface and a mesh with frames.
fn painted_and_moving() -> Value {
    let square = json!({
        "points": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 2]],
        "faces": [[0, 1, 2], [0, 2, 3]], "lines": [[0, 4]], "materials": [0, 1],
        "normals": { "values": [[0, 0, 1], [0, 0.6, 0.8]], "corners": [0, 0, 0, 1, 1, 1] },
        "uvs": { "values": [[0, 0], [1, 0], [1, 1], [0.5, 0.75]], "corners": [0, 1, 2, 0, 2, 3] }
    });
    let tinted = json!({
        "points": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 2]], "faces": [[0, 1, 2], [0, 2, 3]],
        "colors": [[1, 0, 0, 1], [0, 1, 0, 1], [0, 0, 1, 1], [1, 1, 0, 0.5], [1, 1, 1, 1]]
    });
    let moved = |points: &Value, k: usize| -> Value {
        let up = |p: &Value| json!([p[0], p[1], p[2].as_f64().unwrap() + k as f64]);
        points.as_array().unwrap().iter().map(up).collect()
    };
    let frames = |points: &Value| json!({ "rate": 24, "frames": (0..13).map(|k| moved(points, k)).collect::<Vec<_>>() });
    let curve = curve_json(&curve("clamped", 3, false, 1.0));
    let tube = tube_json(8, 6, false);
    // The frames of a surface list its points row after row.
    let net: Value =
        tube["points"].as_array().unwrap().iter().flat_map(|row| row.as_array().unwrap().clone()).collect();
    let shift = json!([[1, 0, 0, 1_000_000], [0, 1, 0, 20], [0, 0, 1, 30], [0, 0, 0, 1]]);
    let mut document = document(
        "m",
        &[
            json!({ "name": "crane ü", "group": {}, "transform": shift }),
            json!({ "name": "square", "mesh": square, "materials": ["red", "see-through"], "parent": "crane ü" }),
            json!({ "name": "tinted", "mesh": tinted }),
            json!({ "name": "rib", "animation": frames(&curve["points"]), "curve": curve }),
            json!({ "name": "hull", "animation": frames(&net), "surface": tube }),
            json!({ "name": "box", "animation": frames(&box_json([0.0; 3], [1.0; 3])["points"]),
                    "mesh": box_json([0.0; 3], [1.0; 3]) }),
            json!({ "name": "empty", "group": {} }),
            json!({ "name": "flat", "mesh": { "points": [[0, 0, 0], [1, 0, 0]], "faces": [[0, 1, 1]] } }),
            json!({ "name": "nothing", "mesh": { "points": [], "faces": [] } }),
        ],
    );
    document["materials"] = json!([
        { "name": "red", "base_color": [1, 0, 0, 1], "roughness": 0.25, "double_sided": true },
        { "name": "see-through", "base_color": [0, 1, 0, 0.5], "blend": true, "emissive": [0, 0, 3] }
    ]);
    document
}

#[test]
fn blender_shows_materials_layers_hierarchy_and_key_frames() {
    let folder = tempfile::tempdir().unwrap();
    save(folder.path(), "all.loft.json", &painted_and_moving());
    for out in ["all.glb", "all.gltf"] {
        LOFTSMAN.done(folder.path(), &["convert", "all.loft.json", out]);
    }
    let files = ["all.glb", "all.gltf"].map(|name| folder.path().join(name));
    if let Some(reports) = Oracle::GltfValidator.ask(&files, &[]) {
        for report in reports {
            assert_eq!((&report["errors"], &report["warnings"]), (&json!(0), &json!(0)), "{report:#}");
        }
    }
    let Some(reports) = Oracle::Blender.ask(&files, &["--eval", "--frames", "0,6,12"]) else { return };
    for report in &reports {
        let square = object(report, "square");
        assert_eq!(square["parent"], "crane ü");
        assert_eq!(list(square, "matrix_world/0")[3], 1e6);
        assert_eq!((number(square, "faces"), number(square, "wire_edges")), (2.0, 1.0));
        assert_eq!(square["faces_per_material_slot"], json!({ "0": 1, "1": 1 }));
        assert_eq!(square["custom_normals"], true);
        let tilt = number(square, "corner_normals/max_degrees_from_face");
        assert!((tilt - 0.8_f64.acos().to_degrees()).abs() < 0.1, "{tilt}");
        assert_eq!(square["uv_layers"][0]["range"], json!([[0.0, 0.0], [1.0, 1.0]]));
        let attributes = list(object(report, "tinted"), "attributes");
        assert!(attributes.iter().any(|a| a["type"].as_str().unwrap().contains("COLOR")), "{attributes:?}");
        for (slot, name, colour) in [(0, "red", [1.0, 0.0, 0.0]), (1, "see-through", [0.0, 1.0, 0.0])] {
            assert_eq!(square["materials"][slot], name);
            let material = list(report, "materials").iter().find(|m| m["name"] == name).unwrap();
            let base: Vec<f64> = list(material, "base_colour").iter().filter_map(Value::as_f64).collect();
            assert!((0..3).all(|k| (base[k] - colour[k]).abs() < 1e-3), "{name} is {base:?}");
            assert_eq!(number(material, "metallic"), 0.0);
        }
        for name in ["rib", "hull", "box"] {
            let keys = list(object(report, name), "shape_keys");
            assert_eq!(
                (keys.len(), &keys[1]["name"], &keys[13]["name"]),
                (14, &json!("frame 0"), &json!("frame 12"))
            );
            // Frame k lies k higher than the first.
            let low = |frame: usize| position(&report["frames"][frame]["objects"][name]["bbox"][0])[2];
            for (frame, k) in [(1, 6.0), (2, 12.0)] {
                assert!(
                    (low(frame) - low(0) - k).abs() < 1e-4,
                    "{name} at frame {k}: {}",
                    low(frame) - low(0)
                );
            }
        }
        assert_eq!(object(report, "empty")["type"], "EMPTY");
    }
}

/// A rope that swings, frame by frame, as a document.
fn swinging(frames: usize) -> Value {
    let (vertices, spans) = (20, 17);
    let frame = |k: usize| -> Value {
        let time = k as f64 / 24.0;
        let point = |i: usize| {
            let s = i as f64 / (vertices - 1) as f64;
            let angle = 9.0 * s + 3.0 * time;
            json!([3.0 * s, 0.4 * s * angle.sin(), s * (time + 0.5 * angle.cos())])
        };
        (0..vertices).map(point).collect()
    };
    let knots: Vec<usize> = [vec![0; 3], (0..=spans).collect(), vec![spans; 3]].concat();
    let curve = json!({ "degree": 3, "periodic": false, "knots": knots, "points": frame(frames - 1) });
    let animation = json!({ "rate": 24, "frames": (0..frames).map(frame).collect::<Vec<_>>() });
    document("m", &[json!({ "name": "rope", "curve": curve, "animation": animation })])
}

#[test]
fn blender_plays_a_rope_and_its_tube_as_the_files_of_frames_show_them() {
    let folder = tempfile::tempdir().unwrap();
    save(folder.path(), "rope.loft.json", &swinging(48));
    let tube = json!({ "op": "tube", "radius": 0.05, "sides": 12, "caps": "round", "name": "hose" });
    let recipe = json!({ "input": "rope.loft.json", "output": ["rope.glb", "rope_##.obj"], "step": [tube] });
    std::fs::write(folder.path().join("r.json"), recipe.to_string()).unwrap();
    LOFTSMAN.done(folder.path(), &["run", "r.json"]);
    let film = [folder.path().join("rope.glb")];
    if let Some(reports) = Oracle::GltfValidator.ask(&film, &[]) {
        assert_eq!(
            (&reports[0]["errors"], &reports[0]["warnings"]),
            (&json!(0), &json!(0)),
            "{:#}",
            reports[0]
        );
    }
    let shown = [0, 23, 47];
    let stills = shown.map(|k| folder.path().join(format!("rope_{k:02}.obj")));
    let Some(films) = Oracle::Blender.ask(&film, &["--eval", "--frames", "0,23,47"]) else { return };
    let Some(stills) = Oracle::Blender.ask(&stills, &[]) else { return };
    for name in ["rope", "hose"] {
        let keys = list(object(&films[0], name), "shape_keys");
        assert_eq!((keys.len(), &keys[48]["name"]), (49, &json!("frame 47")), "{name}");
    }
    let mut ways = Vec::new();
    for (k, still) in stills.iter().enumerate() {
        let corners =
            |report: &Value| -> Vec<[f64; 3]> { list(report, "bbox").iter().map(position).collect() };
        let (film, still) =
            (corners(&films[0]["frames"][k]["objects"]["hose"]), corners(object(still, "hose")));
        for (film, still) in film.iter().zip(&still) {
            assert!(crate::apart(*film, *still) < 1e-5, "frame {}: {film:?} {still:?}", shown[k]);
        }
        ways.push(film[1][2]);
    }
    // The end rises by a metre a second.
    assert!(ways[2] > ways[0] + 1.0, "{ways:?}");
}

/// Splines and a mesh, below nodes that turn, stretch and mirror, and twice by instances; `size` is about how large they are.
fn nested(unit: &str, up: &str, size: f64) -> Value {
    let turned = |scale: f64, at: f64| -> Value {
        let (c, s) = (0.8 * scale, 0.6 * scale);
        json!([[c, -s, 0.0, at], [s, c, 0.0, -at], [0.0, 0.0, scale, 2.0 * at], [0.0, 0.0, 0.0, 1.0]])
    };
    let block = box_json([0.0; 3], [size, 2.0 * size, 3.0 * size]);
    let scaled = |mut surface: Value| -> Value {
        for p in
            surface["points"].as_array_mut().unwrap().iter_mut().flat_map(|row| row.as_array_mut().unwrap())
        {
            p.as_array_mut().unwrap().iter_mut().for_each(|x| *x = (x.as_f64().unwrap() * size).into());
        }
        surface
    };
    json!({
        "loftsman": 1, "unit": unit, "up": up,
        "definitions": [{ "name": "bolt", "objects": [
            { "name": "thread", "curve": curve_json(&curve("uneven", 3, false, size)) },
            { "name": "shank", "surface": scaled(tube_json(8, 6, true)), "transform": turned(0.5, size) },
        ] }],
        "objects": [
            { "name": "ship", "group": {}, "transform": turned(1.0, 3.0 * size) },
            { "name": "hull", "parent": "ship", "surface": scaled(tube_json(8, 6, false)), "transform": turned(-2.0, size) },
            { "name": "rib", "parent": "hull", "curve": curve_json(&curve("periodic", 3, true, size)), "transform": turned(0.25, size) },
            { "name": "far", "curve": curve_json(&curve("clamped", 2, false, size)), "transform": turned(1.0, 500.0 * size) },
            { "name": "keel", "parent": "ship", "mesh": block },
            { "name": "left", "instance": { "definition": "bolt" }, "transform": turned(1.0, 7.0 * size) },
            { "name": "right", "instance": { "definition": "bolt" }, "transform": turned(1.5, -7.0 * size) },
        ],
    })
}

fn matrix(rows: &Value) -> Matrix4<f64> {
    if rows.is_null() {
        return Matrix4::identity();
    }
    Matrix4::from_fn(|i, j| rows[i][j].as_f64().unwrap())
}

/// Where the points of each object are in the scene, and its exact spline, by its name.
fn placed(document: &Value) -> BTreeMap<String, ([f64; 6], Value)> {
    let objects = list(document, "objects");
    let named = |name: &str| objects.iter().find(|o| o["name"] == name).unwrap();
    let mut all = BTreeMap::new();
    for object in objects {
        let (mut at, mut above) = (matrix(&object["transform"]), &object["parent"]);
        while let Some(parent) = above.as_str() {
            (at, above) = (matrix(&named(parent)["transform"]) * at, &named(parent)["parent"]);
        }
        let kinds = ["curve", "surface", "mesh"];
        let shape = object["same_as"]["object"].as_str().map_or(object, named);
        let geometry = kinds.iter().map(|kind| &shape[*kind]).find(|g| !g.is_null()).unwrap_or(&Value::Null);
        let mut bounds: [f64; 6] =
            std::array::from_fn(|k| if k < 3 { f64::INFINITY } else { f64::NEG_INFINITY });
        let mut open: Vec<&Value> = vec![&geometry["points"]];
        while let Some(next) = open.pop() {
            let Some(inner) = next.as_array() else { continue };
            if inner.first().is_some_and(Value::is_array) {
                open.extend(inner);
                continue;
            }
            let p = [0, 1, 2].map(|k| inner[k].as_f64().unwrap());
            let q = at.transform_point(&Point3::from(p));
            for k in 0..3 {
                (bounds[k], bounds[k + 3]) = (bounds[k].min(q[k]), bounds[k + 3].max(q[k]));
            }
        }
        let exact = if shape["mesh"].is_null() { geometry.clone() } else { Value::Null };
        all.insert(object["name"].as_str().unwrap().to_owned(), (bounds, exact));
    }
    all
}

fn read_as_document(folder: &Path, file: &str) -> (Value, String) {
    let told = LOFTSMAN.done(folder, &["convert", file, "read.loft.json"]);
    (serde_json::from_str(&std::fs::read_to_string(folder.join("read.loft.json")).unwrap()).unwrap(), told)
}

/// Blender keeps what hangs at an object and drops what stands at the file; lines only where it is told to.
#[test]
fn what_comes_back_from_blender_is_as_large_and_stands_as_it_went() {
    let folder = tempfile::tempdir().unwrap();
    let cases = [
        ("mm", "z", 20.0),
        ("cm", "y", 20.0),
        ("m", "z", 2.0),
        ("m", "y", 2.0),
        ("in", "z", 9.0),
        ("mm", "y", 8.0),
    ];
    for (number, (unit, up, size)) in cases.into_iter().enumerate() {
        let name = format!("{unit}-{up}.glb");
        save(folder.path(), "scene.loft.json", &nested(unit, up, size));
        LOFTSMAN.done(folder.path(), &["convert", "scene.loft.json", &name]);
        let (went, _) = read_as_document(folder.path(), &name);
        let edges = number % 2 == 0;
        let options: &[&str] = if edges { &["--edges"] } else { &[] };
        if Oracle::BlenderPass.ask(&[folder.path().join(&name)], options).is_none() {
            return;
        }
        let (came, told) = read_as_document(folder.path(), &format!("{unit}-{up}-blender.glb"));
        assert_eq!((&came["unit"], &came["up"]), (&went["unit"], &went["up"]), "{name}");
        assert_eq!(told.contains("have no lines or faces in the file any more"), !edges, "{told}");
        let (went, came) = (placed(&went), placed(&came));
        assert!(
            went.keys().eq(came.keys()) && went.len() == 11,
            "{name}: {:?} {:?}",
            went.keys(),
            came.keys()
        );
        for (object, (bounds, exact)) in &went {
            let (found, same) = &came[object];
            assert!(exact == same, "{name}: the exact spline of {object}");
            let far = bounds.iter().filter(|x| x.is_finite()).fold(size, |far, x| far.max(x.abs()));
            for (a, b) in bounds.iter().zip(found) {
                assert!(
                    a == b || (a - b).abs() <= 1e-6 * far,
                    "{name}: {object} is at {found:?} and not at {bounds:?}"
                );
            }
        }
    }
}

/// What Blender moves or stretches moves and stretches the spline; where it changes the vertices they count, and it is told.
#[test]
fn what_blender_moves_is_moved_and_what_it_reshapes_is_a_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let objects = [
        json!({ "name": "hull", "surface": tube_json(8, 6, true) }),
        json!({ "name": "rib", "curve": curve_json(&curve("uneven", 3, false, 1.0)) }),
    ];
    save(folder.path(), "scene.loft.json", &document("mm", &objects));
    let pass = |options: &[&str]| {
        LOFTSMAN.done(folder.path(), &["convert", "scene.loft.json", "s.glb"]);
        Oracle::BlenderPass.ask(&[folder.path().join("s.glb")], options)?;
        Some(read_as_document(folder.path(), "s-blender.glb"))
    };
    let Some((moved, _)) = pass(&["--edges", "--move", "hull", "0.5", "0.25", "-1", "--scale", "rib", "3"])
    else {
        return;
    };
    let was = placed(&read_as_document(folder.path(), "s.glb").0);
    let found = placed(&moved);
    for k in 0..6 {
        let by = [500.0, 250.0, -1000.0][k % 3];
        assert!((found["hull"].0[k] - was["hull"].0[k] - by).abs() < 1e-3, "{found:?}");
        assert!((found["rib"].0[k] - 3.0 * was["rib"].0[k]).abs() < 1e-5, "{found:?}");
    }
    assert!(found["hull"].1 == was["hull"].1 && found["rib"].1 == was["rib"].1);
    let (baked, told) = pass(&["--edges", "--scale", "hull", "3", "--apply"]).unwrap();
    let hull = object(&baked, "hull");
    assert!(hull["surface"].is_null() && !hull["mesh"].is_null());
    assert!(told.contains("exact spline whose mesh was changed since: the mesh is taken instead"), "{told}");
    let mesh = placed(&baked)["hull"].0;
    let size = |bounds: &[f64; 6]| bounds[5] - bounds[2];
    assert!((size(&mesh) / (3.0 * size(&was["hull"].0)) - 1.0).abs() < 0.2, "in millimetres too: {mesh:?}");
}
