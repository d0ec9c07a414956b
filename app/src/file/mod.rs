//! Scenes in files: reading by extension or content, writing whole or not at all.
//!
//! * [`input`]: a file and its siblings, never outside its folder.
//! * [`output`]: several output files, made in memory, then put in place together.

mod commit;
pub mod input;
pub mod output;

use std::path::Path;

use loftsman_kernel::plugin::{ReadOptions, ReadReport, Registry, WriteOptions, WriteReport};
use loftsman_kernel::scene::Scene;

pub use input::Input;
pub use output::{Outputs, Produced};

use crate::error::Result;

/// The scene of a file, in any format known here, found by its extension or, failing that, its content.
///
/// # Errors
/// When the file cannot be read, its format is unknown, or its content breaks the format's rules.
pub fn read(path: impl AsRef<Path>) -> Result<Scene> {
    Ok(read_with(path, &ReadOptions::default(), crate::registry())?.0)
}

/// As [`read`], with options and a registry of one's own; also returns what was kept and what was left out.
///
/// # Errors
/// As for [`read`].
pub fn read_with(
    path: impl AsRef<Path>,
    options: &ReadOptions<'_>,
    registry: &Registry,
) -> Result<(Scene, ReadReport)> {
    let input = Input::open(path)?;
    let format = input.format(registry)?;
    Ok(format.read(&input, options)?)
}

/// Writes a scene to a file, in the format of its extension. The file appears whole or not at all; an existing
/// one survives a failure. Splines that the format cannot hold are tessellated to a thousandth of their size.
///
/// # Errors
/// When the format is unknown or cannot hold the scene, or the file cannot be written.
pub fn write(scene: &Scene, path: impl AsRef<Path>) -> Result<()> {
    write_with(scene, path, &WriteOptions::default(), crate::registry())?;
    Ok(())
}

/// As [`write`](fn@write), with options and a registry of one's own; also returns how each object went out. Where the
/// options name no tessellator, the registry's is used.
///
/// # Errors
/// As for [`write`](fn@write).
pub fn write_with(
    scene: &Scene,
    path: impl AsRef<Path>,
    options: &WriteOptions<'_>,
    registry: &Registry,
) -> Result<WriteReport> {
    let mut outputs = Outputs::new();
    let report = outputs.scene(scene, path.as_ref(), options, registry)?;
    outputs.commit()?;
    Ok(report)
}
