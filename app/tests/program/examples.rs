//! Every recipe under `examples/` runs on its own input and writes what it says.

use std::path::Path;

use loftsman::kernel::scene::Geometry;
use serde_json::Value;

use crate::LOFTSMAN;

/// Copies a folder's files, without what a user's own runs left in `out`.
pub(crate) fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap().map(Result::unwrap) {
        if entry.file_type().unwrap().is_file() {
            std::fs::copy(entry.path(), to.join(entry.file_name())).unwrap();
        } else if entry.file_name() != "out" {
            copy(&entry.path(), &to.join(entry.file_name()));
        }
    }
}

#[test]
fn every_example_runs_and_writes_the_same_bytes_again() {
    let folder = tempfile::tempdir().unwrap();
    let examples = folder.path().join("examples");
    copy(&loftsman_tests::repository().join("examples"), &examples);
    let mut ran = 0;
    for entry in std::fs::read_dir(&examples).unwrap().map(Result::unwrap) {
        for name in ["recipe.toml", "recipe.json"] {
            let recipe = entry.path().join(name);
            if !recipe.exists() {
                continue;
            }
            let run = || {
                let report = LOFTSMAN.json(folder.path(), &["run", &recipe.to_string_lossy()]);
                for step in report["steps"].as_array().unwrap() {
                    // In document units: the largest numbers here are second derivatives by parameters over [0, 1], some
                    // thousand times the size of the shapes; their rounding is a thousand times 1e-16.
                    let residual = step["residual"].as_f64().unwrap_or(0.0);
                    // What moves drifts off what holds it by parts in a million of its size, which is ten here.
                    // Sections are drawn within their tolerance.
                    let drawn = step["op"] == "simulate" || step["op"] == "section";
                    let allowed = if drawn { 1e-5 } else { 2e-12 };
                    assert!(residual <= allowed, "{}: {step:#}", recipe.display());
                }
                let outputs = report["outputs"].as_array().unwrap();
                assert!(!outputs.is_empty(), "{} writes nothing", recipe.display());
                let written = |output: &Value| {
                    let path = folder.path().join(output["path"].as_str().unwrap());
                    let bytes = std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
                    assert_eq!(bytes.len() as u64, output["bytes"].as_u64().unwrap(), "{}", path.display());
                    (path, bytes)
                };
                outputs.iter().map(written).collect::<Vec<_>>()
            };
            assert!(run() == run(), "{} gives different bytes when run again", recipe.display());
            ran += 1;
        }
    }
    assert!(ran > 0, "there are examples");
}

/// What `examples/gates` says of itself: which poles are touched, that the line passes every gate, and what it gains.
#[test]
fn the_line_through_the_gates_touches_seven_poles() {
    let folder = tempfile::tempdir().unwrap();
    let examples = folder.path().join("examples");
    copy(&loftsman_tests::repository().join("examples"), &examples);
    let report =
        LOFTSMAN.json(folder.path(), &["run", &examples.join("gates/recipe.toml").to_string_lossy()]);
    let steps = report["steps"].as_array().unwrap();
    let energy = |step: usize| steps[step]["energy"][1].as_f64().unwrap();
    assert!(energy(0) > 0.0 && energy(1) > 2.8 * energy(0), "{} and {}", energy(0), energy(1));
    let scene = loftsman::read_scene(folder.path().join("out/gates/course.loft.json")).unwrap();
    let line = scene.curve("line").unwrap();
    let told = steps[0]["constraints"].as_array().unwrap();
    let pull = |end: String| {
        let one = told.iter().find(|c| c["name"].as_str().unwrap().ends_with(&end));
        one.unwrap_or_else(|| panic!("{end} in {told:?}"))["multipliers"][0].as_f64().unwrap()
    };
    let mut touched = Vec::new();
    for gate in 1..=9 {
        let poles = match scene.object(&format!("gate {gate}")).unwrap().geometry() {
            Geometry::Polyline(poles) => poles.points.clone(),
            other => panic!("{other:?}"),
        };
        let (low, high) = (poles[0], poles[1]);
        let at = line.point(low.x).unwrap();
        assert!((at.x - low.x).abs() < 1e-9 && at.z == 0.0, "gate {gate}: {at}");
        assert!(low.y - 1e-12 <= at.y && at.y <= high.y + 1e-12, "gate {gate}: {at}");
        let (up, down) =
            (pull(format!("at {} ≥ {}", low.x, low.y)), pull(format!("at {} ≤ {}", low.x, high.y)));
        // A pole that is touched pushes the line away, one that is not does nothing.
        let (on_low, on_high) = (at.y - low.y < 1e-12, high.y - at.y < 1e-12);
        assert!(if on_low { up > 0.0 } else { up == 0.0 }, "gate {gate}: {up}");
        assert!(if on_high { down < 0.0 } else { down == 0.0 }, "gate {gate}: {down}");
        if on_low || on_high {
            touched.push(gate);
        } else {
            assert!((at.y - low.y).min(high.y - at.y) > 0.1, "gate {gate}: {at}");
        }
    }
    assert_eq!(touched, [1, 2, 3, 4, 5, 7, 8]);
}
