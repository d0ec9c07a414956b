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

/// The area inside the contours of `area-kept` and `symmetric-section`, and the volume of `bottle`, which the examples keep.
const KEPT: [f64; 3] = [3.439_948_452_237_159, 4.572_264_817_766_588, 5.244_532_437_012_21];

/// What an example makes: its folder, the file, the object, the quantity, and within which part of itself it is that. Where a formula says it
/// the formula is here; what an example keeps is what was there before; the rest are numbers of a run that was looked at.
const TOLD: &[(&str, &str, &str, &str, f64, f64)] = &[
    ("area-kept", "curves.loft.json", "a0", "area", KEPT[0], 1e-12),
    ("area-kept", "curves.loft.json", "a4", "area", KEPT[0], 1e-12),
    ("area-kept", "curves.loft.json", "b3", "area", KEPT[0], 1e-12),
    ("area-kept", "curves.loft.json", "c3", "area", KEPT[0], 1e-12),
    ("blade-section", "section.loft.json", "section", "length", 2.181_156, 1e-6),
    // A prism: its base times its height.
    ("blade-solid", "blade.loft.json", "blade", "volume", 0.182_384_308_750_99 * 0.5, 5e-4),
    ("bottle", "bottle.loft.json", "bottle", "volume", KEPT[2], 1e-12),
    ("bottle-sections", "sections.loft.json", "across", "area", 2.614_117, 1e-5),
    ("bottle-sections", "sections.loft.json", "along", "area", 3.527_705, 1e-5),
    // Both halves.
    ("canoe", "canoe.loft.json", "hull", "area", 6.215_282, 1e-6),
    ("canoe", "canoe.loft.json", "rail", "length", 5.079_912, 1e-6),
    ("car-body", "body.loft.json", "body in colours", "area", 8.853_9, 1e-3),
    ("doo-sabin-form", "knob.loft.json", "knob", "faces", 2112.0, 0.0),
    ("doo-sabin-form", "knob.loft.json", "knob", "volume", 3.979_054, 1e-6),
    // Kept: what it is of the cage as it comes.
    ("five-points", "head.loft.json", "head", "volume", 4.136_721_398_189, 1e-11),
    ("fuselage-section", "section.loft.json", "section", "area", 3.479_386, 1e-6),
    ("gates", "course.loft.json", "line", "length", 225.807_165, 1e-6),
    ("housing", "housing.step", "housing", "volume", 4.248_508, 1e-4),
    ("jug", "jug.loft.json", "jug", "area", 40_656.511, 1e-6),
    ("jug", "jug.loft.json", "lip", "area", 7_969.971, 1e-6),
    // Ellipses: π a b.
    ("jug", "jug.loft.json", "belly", "area", std::f64::consts::PI * 60.0 * 54.0, 1e-12),
    ("matched-deck", "ship.loft.json", "deck", "area", 30.613_739, 1e-6),
    ("pebble", "pebble.loft.json", "pebble", "volume", 106_957.624, 1e-6),
    ("pocket", "pocket.loft.json", "path 1", "area", 2_323.645_27, 1e-6),
    ("pocket", "pocket.loft.json", "rim", "length", 309.000_488, 1e-6),
    ("ring-on-rope", "rope.loft.json", "rope", "length", 4.235_374, 1e-4),
    ("sharper-nose", "section.loft.json", "section", "length", 2.124_798, 1e-6),
    ("ship-plate", "plate.loft.json", "plate", "area", 4.061_816, 1e-6),
    ("ship-plate", "plate.loft.json", "mould", "area", 4.552_305, 1e-6),
    ("shoelace", "lace.loft.json", "lace", "volume", 0.234_3, 1e-2),
    ("symmetric-section", "sections.loft.json", "tall", "area", KEPT[1], 1e-12),
    ("symmetric-section", "sections.loft.json", "waisted", "area", KEPT[1], 1e-12),
    ("thicker-blade", "section.loft.json", "section", "length", 2.198_829, 1e-6),
    // Pappus: the area of the section, an ellipse, along the path of its middle; the band is within its tolerance of that.
    ("trefoil", "trefoil.loft.json", "band", "volume", std::f64::consts::PI * 0.06 * 28.364_569_999_42, 1e-4),
    ("vase", "vase.loft.json", "ring", "length", 8.0 * std::f64::consts::PI, 1e-12),
    // Half a circle of radius 31, as long as it is.
    ("vase", "vase.loft.json", "handle path", "length", 31.0 * std::f64::consts::PI, 1e-12),
    ("vase", "vase.loft.json", "rim", "length", 48.0 * std::f64::consts::PI, 1e-12),
];

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
                    let measured = step["residual"].as_f64();
                    let residual = measured.or(step["numbers"]["distance"].as_f64()).unwrap_or(0.0);
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
                    if path.extension().is_some_and(|extension| extension == "svg") {
                        let faults = super::labels::faults(std::str::from_utf8(&bytes).unwrap());
                        assert!(faults.is_empty(), "{}: {faults:#?}", path.display());
                    }
                    (path, bytes)
                };
                outputs.iter().map(written).collect::<Vec<_>>()
            };
            assert!(run() == run(), "{} gives different bytes when run again", recipe.display());
            let example = entry.file_name().to_string_lossy().into_owned();
            let wanted: Vec<_> = TOLD.iter().filter(|told| told.0 == example).collect();
            assert!(!wanted.is_empty(), "{example}: a number is wanted that says whether it is right");
            for (_, file, object, quantity, value, within) in wanted {
                let path = format!("out/{example}/{file}");
                let info = LOFTSMAN.json(folder.path(), &["info", &path]);
                let objects = info["objects"].as_array().unwrap();
                let found = objects.iter().find(|o| o["name"] == *object);
                let found = found.unwrap_or_else(|| panic!("{path} has no {object}"))[*quantity].as_f64();
                let found = found.unwrap_or_else(|| panic!("{path}: {object} has no {quantity}"));
                assert!(
                    (found / value - 1.0).abs() <= *within,
                    "{path}: {quantity} of {object}: {found}, not {value}"
                );
            }
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
