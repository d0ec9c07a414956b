//! glTF: clean for the Khronos validator, and Blender shows what the scene holds.

use loftsman_tests::curves::{box_json, curve, curve_json, document, tube_json};
use loftsman_tests::oracle::{Oracle, list, number, object, position, text};
use loftsman_tests::program;
use serde_json::{Value, json};

use crate::save;

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
            program::succeed(folder.path(), &["convert", &format!("{name}.loft.json"), &out]);
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
    program::succeed(folder.path(), &["convert", "all.loft.json", "all.glb"]);
    program::succeed(folder.path(), &["convert", "small.loft.json", "small.gltf"]);
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
