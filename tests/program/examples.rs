//! Every recipe under `examples/` runs on its own input and writes what it says.

use std::path::Path;

use loftsman_tests::program;
use serde_json::Value;

/// Copies a folder's files, without what a user's own runs left in `out`.
fn copy(from: &Path, to: &Path) {
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
    copy(&program::repository().join("examples"), &examples);
    let mut ran = 0;
    for entry in std::fs::read_dir(&examples).unwrap().map(Result::unwrap) {
        for name in ["recipe.toml", "recipe.json"] {
            let recipe = entry.path().join(name);
            if !recipe.exists() {
                continue;
            }
            let run = || {
                let report = program::json(folder.path(), &["run", &recipe.to_string_lossy()]);
                for step in report["steps"].as_array().unwrap() {
                    // In document units: the largest numbers here are second derivatives by parameters over [0, 1], some
                    // thousand times the size of the shapes; their rounding is a thousand times 1e-16.
                    let residual = step["residual"].as_f64().unwrap_or(0.0);
                    assert!(residual <= 2e-12, "{}: {step:#}", recipe.display());
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
