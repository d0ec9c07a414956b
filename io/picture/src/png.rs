//! SVG to PNG, with the one font of the crate.

use std::sync::Arc;

use resvg::{tiny_skia, usvg};

use crate::error::PictureError;
use crate::text;

/// The widest image, in pixels.
const WIDEST: u32 = 16_384;

/// Renders a drawing of ours `width` pixels wide.
pub(crate) fn render(svg: &str, width: u32) -> Result<Vec<u8>, PictureError> {
    let size = |what, value: f64| PictureError::Size {
        what,
        unit: "pixels",
        value,
        least: 1.0,
        most: f64::from(WIDEST),
    };
    if width == 0 || width > WIDEST {
        return Err(size("wide", f64::from(width)));
    }
    let mut fonts = usvg::fontdb::Database::new();
    fonts.load_font_data(text::FONT.to_vec());
    for set in [
        usvg::fontdb::Database::set_sans_serif_family::<&str>,
        usvg::fontdb::Database::set_serif_family::<&str>,
    ] {
        set(&mut fonts, "DejaVu Sans");
    }
    let options = usvg::Options {
        fontdb: Arc::new(fonts),
        font_family: "DejaVu Sans".to_owned(),
        ..usvg::Options::default()
    };
    let render = |problem: String| PictureError::Render(problem);
    let tree = usvg::Tree::from_str(svg, &options).map_err(|error| render(error.to_string()))?;
    let scale = width as f32 / tree.size().width();
    let height = (tree.size().height() * scale).round().max(1.0);
    if height > WIDEST as f32 {
        return Err(size("high", f64::from(height)));
    }
    let mut image = tiny_skia::Pixmap::new(width, height as u32)
        .ok_or_else(|| render(format!("no room for {width} × {height} pixels")))?;
    resvg::render(&tree, tiny_skia::Transform::from_scale(scale, scale), &mut image.as_mut());
    image.encode_png().map_err(|error| render(error.to_string()))
}
