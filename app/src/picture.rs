//! Pictures of a scene, and of what a recipe did to it: the crate `loftsman-picture`, and files for it.

use std::path::Path;

pub use loftsman_picture::*;

use crate::error::{Error, Result};

/// How wide a PNG is unless told otherwise, in pixels.
pub const PIXELS: u32 = 1600;

/// Whether a file is to be a picture: `.svg` or `.png`.
pub fn is_picture(path: &Path) -> bool {
    is_png(path) || path.extension().is_some_and(|e| e.eq_ignore_ascii_case("svg"))
}

fn is_png(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"))
}

/// The bytes of a picture for a file of this name: PNG of `pixels` across where it ends so, else SVG.
///
/// # Errors
/// When the scene cannot be drawn: its hierarchy is cyclic, or the picture has no reasonable size.
pub fn encode(path: &Path, picture: &Picture<'_>, pixels: u32) -> Result<Vec<u8>> {
    let bytes = if is_png(path) { picture.to_png(pixels) } else { picture.to_svg().map(String::into_bytes) };
    bytes.map_err(|e| Error::file(path.display().to_string(), e.to_string()))
}
