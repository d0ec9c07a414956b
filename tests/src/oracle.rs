//! Foreign programs asked for a second opinion: Blender, MeshLab, OpenCASCADE and the Khronos validator.
//!
//! `scripts/oracles.sh` installs them into `$LOFTSMAN_ORACLES` (by default `~/.cache/loftsman-oracles`). Where they
//! are missing a test is skipped aloud, or fails if `LOFTSMAN_REQUIRE_ORACLES` is set, as it is in `.ci/run`.

use std::ffi::OsStr;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

/// A foreign program with a script in `tests/oracles` that asks it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Oracle {
    /// Blender 5.0 without a window.
    Blender,
    /// Blender's modifier "Subdivision Surface" on a cage.
    BlenderSubdivision,
    /// Blender's import of a glTF file, and its export beside it.
    BlenderPass,
    /// MeshLab.
    MeshLab,
    /// OpenCASCADE, on STEP and IGES files.
    OpenCascade,
    /// The Khronos glTF validator.
    GltfValidator,
}

impl Oracle {
    /// The interpreter, below the folder of the oracles, and the script.
    fn parts(self) -> (&'static str, &'static str) {
        match self {
            Self::Blender => ("blender/bin/python", "blender_report.py"),
            Self::BlenderSubdivision => ("blender/bin/python", "blender_subdivide.py"),
            Self::BlenderPass => ("blender/bin/python", "blender_pass.py"),
            Self::MeshLab => ("python/bin/python", "meshlab_report.py"),
            Self::OpenCascade => ("python/bin/python", "occt_report.py"),
            Self::GltfValidator => ("node/node_modules/gltf-validator", "gltf_validate.mjs"),
        }
    }

    /// Its reports on these files, one each, in order; `None`, said aloud, where it is not installed.
    ///
    /// # Panics
    /// When it is missing but required, cannot be started, or answers something that is no report.
    pub fn ask(self, files: &[PathBuf], options: &[&str]) -> Option<Vec<Value>> {
        let (home, script) = self.parts();
        let folder = folder();
        let installed = folder.join(home);
        if !installed.exists() {
            let problem =
                format!("{self:?} is not at {}; scripts/oracles.sh installs it", installed.display());
            assert!(std::env::var_os("LOFTSMAN_REQUIRE_ORACLES").is_none(), "{problem}");
            // Past the test harness, which would keep it from being seen.
            let _ = writeln!(std::io::stderr(), "SKIPPED: {problem}");
            return None;
        }
        let interpreter = if self == Self::GltfValidator { PathBuf::from("node") } else { installed };
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("oracles").join(script);
        let ask = |files: &[PathBuf]| {
            let mut command = Command::new(&interpreter);
            command
                .arg(&script)
                .args(files)
                .args(options)
                .env("LOFTSMAN_ORACLES", &folder)
                .stdin(Stdio::null());
            let output =
                command.output().unwrap_or_else(|e| panic!("{} does not start: {e}", interpreter.display()));
            let reports: Result<Vec<Value>, _> =
                serde_json::Deserializer::from_slice(&output.stdout).into_iter().collect();
            match reports {
                Ok(reports) if reports.len() == files.len() => reports,
                _ => panic!(
                    "{self:?} gives no report ({}) on {files:?}:\n{}",
                    output.status,
                    String::from_utf8_lossy(&output.stderr)
                ),
            }
        };
        // Blender takes all files in one launch; the others start fast and take one.
        Some(match self {
            Self::Blender | Self::BlenderSubdivision => ask(files),
            _ => files.chunks(1).flat_map(ask).collect(),
        })
    }
}

/// Where the oracles are installed.
fn folder() -> PathBuf {
    let set = |name| std::env::var_os(name).filter(|v: &std::ffi::OsString| !v.is_empty()).map(PathBuf::from);
    set("LOFTSMAN_ORACLES")
        .or_else(|| set("XDG_CACHE_HOME").map(|cache| cache.join("loftsman-oracles")))
        .or_else(|| set("HOME").map(|home| home.join(".cache/loftsman-oracles")))
        .unwrap_or_default()
}

/// A value inside a report by its path, `"objects/0/name"`.
///
/// # Panics
/// When there is none.
pub fn at<'a>(report: &'a Value, path: &str) -> &'a Value {
    report.pointer(&format!("/{path}")).unwrap_or_else(|| panic!("no {path} in the report:\n{report:#}"))
}

/// The number at a path of a report.
///
/// # Panics
/// When there is none.
pub fn number(report: &Value, path: &str) -> f64 {
    at(report, path).as_f64().unwrap_or_else(|| panic!("{path} is no number in the report:\n{report:#}"))
}

/// The text at a path of a report.
///
/// # Panics
/// When there is none.
pub fn text<'a>(report: &'a Value, path: &str) -> &'a str {
    at(report, path).as_str().unwrap_or_else(|| panic!("{path} is no text in the report:\n{report:#}"))
}

/// The list at a path of a report.
///
/// # Panics
/// When there is none.
pub fn list<'a>(report: &'a Value, path: &str) -> &'a [Value] {
    at(report, path).as_array().unwrap_or_else(|| panic!("{path} is no list in the report:\n{report:#}"))
}

/// Three numbers as a position.
///
/// # Panics
/// When the value is something else.
pub fn position(value: &Value) -> [f64; 3] {
    let numbers: Option<Vec<f64>> = value.as_array().map(|a| a.iter().filter_map(Value::as_f64).collect());
    match numbers.as_deref() {
        Some(&[x, y, z]) => [x, y, z],
        _ => panic!("{value} is no position"),
    }
}

/// The object of this name in one of Blender's reports.
///
/// # Panics
/// When there is none, or Blender could not open the file.
pub fn object<'a>(report: &'a Value, name: &str) -> &'a Value {
    assert!(report.get("error").is_none(), "Blender did not open the file: {}", report["error"]);
    list(report, "objects")
        .iter()
        .find(|o| o["name"] == name)
        .unwrap_or_else(|| panic!("Blender sees no object named {name}; it sees {:?}", names(report)))
}

/// The names of the objects that Blender sees.
pub fn names(report: &Value) -> Vec<&str> {
    report["objects"].as_array().into_iter().flatten().filter_map(|o| o["name"].as_str()).collect()
}

/// Whether a file's extension is this one.
pub fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension() == Some(OsStr::new(extension))
}
