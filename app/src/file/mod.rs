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

use loftsman_kernel::plugin::{ReadOptions, ReadReport, Registry, WriteOptions, WriteReport};
use loftsman_kernel::scene::Scene;

pub use input::{Content, Input};
pub use output::{Outputs, Produced};
pub use sequence::Sequence;

use crate::error::Result;

/// The scene of a file, in any format of a registry, and what was kept and left out of it: as [`read`](crate::read), with options and
/// a registry of one's own. Where the options name no kinds of shape, the registry's are used.
///
/// # Errors
/// As for [`read`](crate::read).
pub fn read_with(
    path: impl AsRef<Path>,
    options: &ReadOptions<'_>,
    registry: &Registry,
) -> Result<(Scene, ReadReport)> {
    let input = Input::open(path)?;
    let Content { scene, report, .. } = input.read(input.format(registry)?.as_ref(), options, registry)?;
    Ok((scene, report))
}

/// Writes a scene to a file: as [`write`](fn@crate::write), with options and a registry of one's own. Where the options name no
/// tessellator, the registry's is used.
///
/// # Errors
/// As for [`write`](fn@crate::write).
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
