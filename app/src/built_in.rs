//! Files read and written with everything that comes with Loftsman: the short way, above the recipes whose operations are among it.

use std::path::Path;

#[cfg(doc)]
use loftsman_kernel::plugin::Format;
use loftsman_kernel::plugin::{ReadOptions, ReadReport, WriteOptions, WriteReport};
use loftsman_kernel::scene::Scene;

use crate::error::Result;
use crate::file::output::format_for;
use crate::file::{read_with, write_with};
use crate::registry::registry;

/// The scene of a file, in any format known here, found by its extension or, failing that, its content; and what was kept
/// and what was left out of it. [`read_scene`] gives the scene alone.
///
/// # Errors
/// When the file cannot be read, its format is unknown, its content breaks the format's rules, or nothing of it could be kept.
pub fn read(path: impl AsRef<Path>) -> Result<(Scene, ReadReport)> {
    read_with(path, &ReadOptions::default(), registry())
}

/// The scene of a file, as [`read`] gives it, without an account of what was left out.
///
/// # Errors
/// As for [`read`].
pub fn read_scene(path: impl AsRef<Path>) -> Result<Scene> {
    Ok(read(path)?.0)
}

/// Writes a scene to a file, in the format of its extension. The file appears whole or not at all; an existing
/// one survives a failure. Splines that the format cannot hold are tessellated as finely as it [has](Format::fineness) them by
/// itself. The report says how each object went out.
///
/// # Errors
/// When the format is unknown or cannot hold the scene, or the file cannot be written.
pub fn write(scene: &Scene, path: impl AsRef<Path>) -> Result<WriteReport> {
    let (path, registry) = (path.as_ref(), registry());
    let fineness = format_for(path, registry)?.fineness();
    write_with(scene, path, &WriteOptions { fineness, ..WriteOptions::default() }, registry)
}
