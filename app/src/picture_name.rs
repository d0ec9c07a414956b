//! Which files are pictures, by their names.

use std::path::Path;

/// Whether a file is to be a picture: `.svg` or `.png`.
pub fn is_picture(path: &Path) -> bool {
    is_png(path) || path.extension().is_some_and(|e| e.eq_ignore_ascii_case("svg"))
}

/// Whether it is a PNG image.
pub(crate) fn is_png(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"))
}
