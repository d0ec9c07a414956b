//! Scenes in files: reading by extension or content, writing whole or not at all.
//!
//! * [`input`]: a file and its siblings, never outside its folder.
//! * [`output`]: several output files, made in memory, then put in place together, also where the process is killed.
//! * [`sequence`]: one file for each frame of a scene's animations.

mod commit;
pub mod input;
mod journal;
pub mod output;
pub mod sequence;

use std::path::Path;

#[cfg(doc)]
use loftsman_kernel::plugin::Format;
use loftsman_kernel::plugin::{ReadOptions, ReadReport, Registry, WriteOptions, WriteReport};
use loftsman_kernel::scene::Scene;

pub use input::{Content, Input};
use output::format_for;
pub use output::{Outputs, Produced};
pub use sequence::Sequence;

use crate::error::Result;

/// The scene of a file, in any format known here, found by its extension or, failing that, its content; and what was kept
/// and what was left out of it. [`read_scene`] gives the scene alone.
///
/// # Errors
/// When the file cannot be read, its format is unknown, its content breaks the format's rules, or nothing of it could be kept.
pub fn read(path: impl AsRef<Path>) -> Result<(Scene, ReadReport)> {
    read_with(path, &ReadOptions::default(), crate::registry())
}

/// The scene of a file, as [`read`] gives it, without an account of what was left out.
///
/// # Errors
/// As for [`read`].
pub fn read_scene(path: impl AsRef<Path>) -> Result<Scene> {
    Ok(read(path)?.0)
}

/// As [`read`], with options and a registry of one's own. Where the options name no kinds of shape, the registry's are used.
///
/// # Errors
/// As for [`read`].
pub fn read_with(
    path: impl AsRef<Path>,
    options: &ReadOptions<'_>,
    registry: &Registry,
) -> Result<(Scene, ReadReport)> {
    let input = Input::open(path)?;
    let Content { scene, report, .. } = input.read(input.format(registry)?.as_ref(), options, registry)?;
    Ok((scene, report))
}

/// Writes a scene to a file, in the format of its extension. The file appears whole or not at all; an existing
/// one survives a failure. Splines that the format cannot hold are tessellated as finely as it [has](Format::fineness) them by
/// itself. The report says how each object went out.
///
/// # Errors
/// When the format is unknown or cannot hold the scene, or the file cannot be written.
pub fn write(scene: &Scene, path: impl AsRef<Path>) -> Result<WriteReport> {
    let (path, registry) = (path.as_ref(), crate::registry());
    let fineness = format_for(path, registry)?.fineness();
    write_with(scene, path, &WriteOptions { fineness, ..WriteOptions::default() }, registry)
}

/// As [`write`](fn@write), with options and a registry of one's own. Where the options name no tessellator, the registry's
/// is used.
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
