//! Filled, extruded and lofted regions: MeshLab measures what we report, and finds solids closed.

use loftsman_tests::curves::document;
use loftsman_tests::oracle::{Oracle, list, number};
use serde_json::{Value, json};

use crate::save;

use crate::LOFTSMAN;

fn ring(name: &str, radius: f64, height: f64) -> Value {
    let corners: Vec<[f64; 3]> = (0..48)
        .map(|i| {
            let angle = std::f64::consts::TAU * f64::from(i) / 48.0;
            [radius * angle.cos(), 0.7 * radius * angle.sin(), height]
        })
        .collect();
    let knots: Vec<i32> = (0..=48).collect();
    json!({ "name": name, "curve": { "degree": 3, "periodic": true, "knots": knots, "points": corners } })
}

#[test]
fn meshlab_measures_regions_and_solids() {
    let folder = tempfile::tempdir().unwrap();
    let rings = [ring("outer", 2.0, 0.0), ring("hole", 0.8, 0.0), ring("lid", 1.0, 3.0)];
    save(folder.path(), "rings.loft.json", &document("m", &rings));
    let steps = [
        ("sheet", json!({ "op": "fill", "objects": ["outer", "hole"], "name": "made", "size": 0.3 })),
        ("tube", json!({ "op": "extrude", "objects": ["outer", "hole"], "by": [0.2, 0, 2], "name": "made" })),
        ("cone", json!({ "op": "loft", "sections": ["outer", "lid"], "name": "made" })),
    ];
    let (mut files, mut reported) = (Vec::new(), Vec::new());
    for (name, step) in steps {
        let rest = ["outer", "hole", "lid"].map(|o| json!({ "op": "delete", "object": o }));
        let all: Vec<Value> = std::iter::once(step).chain(rest).collect();
        let out = format!("{name}.obj");
        let recipe = json!({ "input": "rings.loft.json", "output": [out], "step": all });
        save(folder.path(), &format!("{name}.json"), &recipe);
        let report = LOFTSMAN.done(folder.path(), &["run", &format!("{name}.json"), "--json"]);
        let report: Value = serde_json::from_str(&report).unwrap();
        reported.push(report["steps"][0].clone());
        files.push(folder.path().join(out));
    }
    let Some(seen) = Oracle::MeshLab.ask(&files, &[]) else { return };
    for (reported, seen) in reported.iter().zip(&seen) {
        let mesh = &list(seen, "meshes")[0];
        let (area, expected) = (number(mesh, "area"), reported["area"].as_f64().unwrap());
        assert!((area / expected - 1.0).abs() < 1e-5, "area {area}, reported {expected}");
        let Some(expected) = reported["volume"].as_f64() else {
            assert_eq!(reported["op"], "fill", "{reported:#}");
            continue;
        };
        assert_eq!(mesh["watertight"], true, "{mesh:#}");
        let volume = number(mesh, "volume");
        assert!((volume / expected - 1.0).abs() < 1e-5, "volume {volume}, reported {expected}");
    }
}
