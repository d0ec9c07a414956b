//! Files written by Loftsman, opened by programs we did not write.
//!
//! Where a program is not installed its tests are skipped aloud: `scripts/oracles.sh` installs all of them.
#![allow(clippy::unwrap_used, clippy::panic, reason = "these are tests, their helpers included")]

mod blender_curves;
mod cages;
mod enclosed;
mod every_file;
mod example;
#[cfg(all(feature = "step", feature = "iges"))]
mod forms;
mod gltf;
#[cfg(feature = "iges")]
mod iges;
mod meshes;
mod motion;
mod obj;
mod regions;
#[cfg(feature = "step")]
mod step;
mod subdivision;

use std::path::{Path, PathBuf};

use loftsman_tests::program::Program;
use serde_json::Value;

/// The program, as cargo has built it for these tests.
const LOFTSMAN: Program = Program::at(env!("CARGO_BIN_EXE_loftsman"));

/// Writes a native document into a folder.
fn save(folder: &Path, name: &str, document: &Value) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, document.to_string()).unwrap();
    path
}

/// The largest difference of two positions along an axis.
fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max)
}
