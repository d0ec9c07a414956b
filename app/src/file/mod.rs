//! Scenes in files: reading by extension or content, writing whole or not at all.
//!
//! * [`input`]: a file and its siblings, never outside its folder.
//! * [`output`]: several output files, made in memory, then put in place together, also where the process is killed.

mod commit;
pub mod input;
mod journal;
pub mod output;

use std::path::Path;

use loftsman_kernel::plugin::{
    Field, Format, FormatError, Parameters, Place, ReadOptions, ReadReport, Registry, Source, WriteOptions,
    WriteReport,
};
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

/// As [`read`], with options and a registry of one's own; also returns what was kept and what was left out. Where the
/// options name no kinds of shape, the registry's are used.
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
    check_reading(format.as_ref(), &options.own, Source::name(&input))?;
    Ok(format.read(&input, &knowing(options, registry))?)
}

/// The same options with the registry's kinds of shape, where they name none.
pub(crate) fn knowing<'a>(options: &ReadOptions<'a>, registry: &'a Registry) -> ReadOptions<'a> {
    let kinds = if options.kinds.is_empty() { registry.shape_kinds() } else { options.kinds };
    ReadOptions { kinds, ..options.clone() }
}

/// Refuses options that the format has not when it reads: a format of someone else may not look at what it does not know.
fn check_reading(format: &dyn Format, own: &Parameters, file: &str) -> Result<()> {
    check_options(format.declaration().name, own, format.declaration().reading_options(), file)
}

/// The same when it writes.
fn check_writing(format: &dyn Format, own: &Parameters, file: &str) -> Result<()> {
    check_options(format.declaration().name, own, format.declaration().writing_options(), file)
}

fn check_options(
    format: &str,
    own: &Parameters,
    known: impl Iterator<Item = &'static Field> + Clone,
    file: &str,
) -> Result<()> {
    let error = |problem| FormatError::new(file, Place::File, problem);
    own.check(known).map_err(|e| error(format!("an option of the format {format}: {e}")).into())
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
