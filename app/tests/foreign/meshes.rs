//! OBJ meshes: MeshLab measures what we say; surfaces go out both as `surf` and tessellated.

use loftsman_tests::curves::{box_json, document, tube_json};
use loftsman_tests::oracle::{Oracle, list, number};
use serde_json::json;

use crate::save;

use crate::LOFTSMAN;

#[test]
fn meshlab_measures_a_box() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = json!({ "name": "keel", "mesh": box_json([0.0; 3], [1.0, 2.0, 3.0]) });
    save(folder.path(), "box.loft.json", &document("m", &[mesh]));
    LOFTSMAN.done(folder.path(), &["convert", "box.loft.json", "box.obj"]);
    let Some(reports) = Oracle::MeshLab.ask(&[folder.path().join("box.obj")], &[]) else { return };
    let seen = &list(&reports[0], "meshes")[0];
    assert_eq!(number(seen, "vertices"), 8.0);
    assert_eq!(seen["polygon_sizes"], json!({ "4": 6 }), "quadrangles stay quadrangles");
    assert!((number(seen, "area") - 22.0).abs() < 1e-5 && (number(seen, "volume") - 6.0).abs() < 1e-5);
}

#[test]
fn meshlab_measures_a_tessellated_tube() {
    let folder = tempfile::tempdir().unwrap();
    let surface = json!({ "name": "hull", "surface": tube_json(12, 6, true) });
    save(folder.path(), "tube.loft.json", &document("m", &[surface]));
    let tolerances = [1e-2, 1e-3, 1e-4];
    let files: Vec<_> = tolerances
        .iter()
        .map(|tolerance| {
            let out = format!("tube-{tolerance}.obj");
            let tolerance = tolerance.to_string();
            LOFTSMAN.done(folder.path(), &["convert", "tube.loft.json", &out, "--tolerance", &tolerance]);
            folder.path().join(out)
        })
        .collect();
    let Some(reports) = Oracle::MeshLab.ask(&files, &["--weld"]) else { return };
    // The control net's circle of 12 vertices of radius r carries a nearly round curve of radius 0.9575 r; what is
    // checked is that areas converge like the tolerance and that welding closes the seam.
    let areas: Vec<f64> = reports.iter().map(|r| number(&list(r, "meshes")[0], "area")).collect();
    let faces: Vec<f64> = reports.iter().map(|r| number(&list(r, "meshes")[0], "faces")).collect();
    assert!(faces[0] < faces[1] && faces[1] < faces[2], "finer is more: {faces:?}");
    for (area, tolerance) in areas.iter().zip(tolerances) {
        // A mesh within t of a surface of about unit curvature loses at most a few t of its relative area.
        assert!((area / areas[2] - 1.0).abs() <= 8.0 * tolerance, "areas {areas:?}");
    }
    for report in &reports {
        let topology = &list(report, "meshes")[0]["welded"]["topology"];
        assert_eq!(number(topology, "number_holes"), 2.0, "open at both ends only: {topology:#}");
        assert_eq!(topology["is_mesh_two_manifold"], true, "{topology:#}");
    }
}

#[test]
fn meshlab_finds_closed_surfaces_watertight_and_their_areas_right() {
    // Closed by coinciding edges, with poles and without: no welding is needed. Areas are OpenCASCADE's.
    let folder = tempfile::tempdir().unwrap();
    let golden: serde_json::Value =
        serde_json::from_str(include_str!("../../../tests/golden/tessellation.json")).unwrap();
    let entries: Vec<_> = list(&golden, "surfaces").iter().filter(|s| s.get("points").is_some()).collect();
    assert_eq!(entries.len(), 4);
    let files: Vec<_> = entries
        .iter()
        .map(|entry| {
            let name = entry["name"].as_str().unwrap();
            let degree = |d: usize| entry["degrees"][d].as_u64().unwrap() as usize;
            let columns = entry["knots"][1].as_array().unwrap().len() - degree(1) - 1;
            let rows =
                |field: &str| list(entry, field).chunks(columns).map(<[_]>::to_vec).collect::<Vec<_>>();
            let direction =
                |d: usize| json!({ "degree": degree(d), "periodic": false, "knots": entry["knots"][d] });
            let mut surface = json!({ "u": direction(0), "v": direction(1), "points": rows("points") });
            if entry.get("weights").is_some() {
                surface["weights"] = json!(rows("weights"));
            }
            let document = document("m", &[json!({ "name": name, "surface": surface })]);
            save(folder.path(), &format!("{name}.loft.json"), &document);
            let tolerance = number(entry, "tolerance").to_string();
            LOFTSMAN.done(
                folder.path(),
                &["convert", &format!("{name}.loft.json"), &format!("{name}.obj"), "--tolerance", &tolerance],
            );
            folder.path().join(format!("{name}.obj"))
        })
        .collect();
    let Some(reports) = Oracle::MeshLab.ask(&files, &[]) else { return };
    for (entry, report) in entries.iter().zip(&reports) {
        let (name, seen) = (entry["name"].as_str().unwrap(), &list(report, "meshes")[0]);
        let closed = matches!(name, "sphere" | "torus");
        assert_eq!(seen["watertight"], closed, "{name}: {seen:#}");
        // A mesh within t of a surface whose least radius is some hundred t is off by a few parts in a hundred at most.
        let (area, exact) = (number(seen, "area"), number(entry, "area"));
        assert!((area / exact - 1.0).abs() < 0.02, "{name}: {area} of {exact}");
    }
}
