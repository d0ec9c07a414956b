//! Drawings of ours as pixels: an interpreter of exactly the SVG that this crate writes, in the one font of the crate.
//!
//! A renderer of all of SVG is forty crates, text layout for all scripts and decoders for five kinds of images among them; ours
//! has six elements and one font without layout tables. What is not among these is an error, so that no picture lacks in
//! silence what its SVG shows.

mod letters;
mod outline;
mod reader;
mod style;

use std::collections::{BTreeMap, BTreeSet};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use tiny_skia::{
    FillRule, FilterQuality, IntSize, Paint, Path, Pattern, Pixmap, Rect, SpreadMode, Transform,
};

use crate::error::PictureError;
use reader::{Reader, Tag, Token};
use style::Style;

/// The widest and highest PNG image, in pixels.
pub const WIDEST: u32 = 16_384;

/// Renders a drawing of ours `width` pixels wide, as a PNG image; and the texts that have letters which the font lacks, each
/// with these.
///
/// # Errors
/// When the image would be larger than 16384 pixels, and when the drawing is none of ours.
pub(crate) fn render(svg: &str, width: u32) -> Result<(Vec<u8>, Lacking), PictureError> {
    if width == 0 || width > WIDEST {
        return Err(too_large("wide", f64::from(width)));
    }
    let mut tokens = Reader::new(svg);
    let page = match tokens.next() {
        Some(Ok(Token::Open(tag))) if tag.name == "svg" => tag,
        _ => return Err(PictureError::Render("it does not start with <svg>".to_owned())),
    };
    let mut canvas = Canvas::new(&page, width)?;
    let style = Style::default().with(&page).map_err(PictureError::Render)?;
    canvas.draw(tokens, style).map_err(PictureError::Render)?;
    Ok((png(&canvas.image)?, canvas.lacking))
}

/// Premultiplied pixels (red, green, blue, opacity) as a PNG image.
///
/// # Errors
/// When there are none, or more than memory has room for.
pub(crate) fn encode(pixels: Vec<u8>, [width, height]: [usize; 2]) -> Result<Vec<u8>, PictureError> {
    let size = |side: usize| u32::try_from(side).unwrap_or(0);
    let image = IntSize::from_wh(size(width), size(height)).and_then(|size| Pixmap::from_vec(pixels, size));
    png(&image.ok_or_else(|| no_room(width, height))?)
}

fn png(image: &Pixmap) -> Result<Vec<u8>, PictureError> {
    image.encode_png().map_err(|error| PictureError::Render(error.to_string()))
}

fn no_room(width: usize, height: usize) -> PictureError {
    PictureError::Render(format!("no room for {width} × {height} pixels"))
}

fn too_large(what: &'static str, value: f64) -> PictureError {
    PictureError::Size { what, unit: "pixels", value, least: 1.0, most: f64::from(WIDEST) }
}

/// Texts of a drawing with the letters in them that the font lacks, which are drawn as boxes.
pub(crate) type Lacking = BTreeMap<String, BTreeSet<char>>;

/// An image, and the map from the page's millimetres to its pixels.
struct Canvas {
    image: Pixmap,
    to_pixels: Transform,
    lacking: Lacking,
}

/// An element that is open.
struct Open<'a> {
    tag: Tag<'a>,
    style: Style,
}

impl Canvas {
    fn new(page: &Tag<'_>, width: u32) -> Result<Self, PictureError> {
        let [_, _, wide, high] = page.numbers("viewBox").map_err(PictureError::Render)?;
        let scale = width as f32 / wide;
        let height = (high * scale).round().max(1.0);
        if height > WIDEST as f32 {
            return Err(too_large("high", f64::from(height)));
        }
        // The cast is of a whole number between 1 and 16384; of what is none it gives 0, for which there is no room.
        let image =
            Pixmap::new(width, height as u32).ok_or_else(|| no_room(width as usize, height as usize))?;
        // As high as whole pixels are: a last row that the page covers in part would shine through.
        let to_pixels = Transform::from_scale(scale, height / high);
        Ok(Self { image, to_pixels, lacking: Lacking::new() })
    }

    /// Draws what the page holds.
    fn draw(&mut self, tokens: Reader<'_>, page: Style) -> Result<(), String> {
        let mut open: Vec<Open<'_>> = Vec::new();
        for token in tokens {
            match token? {
                Token::Open(tag) => {
                    let style = open.last().map_or(&page, |around| &around.style).with(&tag)?;
                    self.element(&tag, &style)?;
                    if !tag.empty {
                        open.push(Open { tag, style });
                    }
                }
                Token::Text(words) => match open.last() {
                    Some(around) if around.tag.name == "text" => {
                        self.text(&around.tag, &around.style, &words)?;
                    }
                    Some(around) if around.tag.name == "title" => {}
                    _ if words.trim().is_empty() => {}
                    _ => return Err(format!("the text {words:?} is in no element for texts")),
                },
                Token::Close => {
                    open.pop();
                }
            }
        }
        Ok(())
    }

    /// Draws an element that has no text.
    fn element(&mut self, tag: &Tag<'_>, style: &Style) -> Result<(), String> {
        let path = match tag.name {
            "g" | "title" | "text" => return Ok(()),
            "image" => return self.shading(tag),
            "path" => outline::of_data(tag.text("d")?)?,
            "line" => {
                let [x1, y1, x2, y2] = ["x1", "y1", "x2", "y2"].map(|name| tag.number(name));
                outline::line([x1?, y1?], [x2?, y2?])
            }
            "circle" => {
                let [x, y, r] = ["cx", "cy", "r"].map(|name| tag.number(name));
                outline::circle([x?, y?], r?)
            }
            "rect" => {
                let [x, y] = ["x", "y"].map(|name| tag.number_or(name, 0.0));
                let [width, height] = ["width", "height"].map(|name| tag.number(name));
                Rect::from_xywh(x?, y?, width?, height?).map(tiny_skia::PathBuilder::from_rect)
            }
            other => return Err(format!("the element <{other}> is unknown")),
        };
        if let Some(path) = path {
            self.path(&path, style, self.to_pixels);
        }
        Ok(())
    }

    fn text(&mut self, tag: &Tag<'_>, style: &Style, words: &str) -> Result<(), String> {
        let to_pixels = match tag.attribute("transform") {
            Some(turned) => self.to_pixels.pre_concat(style::turned(turned)?),
            None => self.to_pixels,
        };
        let lacking = letters::lacking(words);
        if !lacking.is_empty() {
            self.lacking.insert(words.trim().to_owned(), lacking);
        }
        let at = [tag.number_or("x", 0.0)?, tag.number_or("y", 0.0)?];
        if let Some(path) = letters::outline(words, at, style.size, style.anchor) {
            self.path(&path, style, to_pixels);
        }
        Ok(())
    }

    /// Fills and strokes a path, in the order of its style.
    fn path(&mut self, path: &Path, style: &Style, to_pixels: Transform) {
        let mut paint = Paint { anti_alias: true, ..Paint::default() };
        for stroke in [style.stroke_first, !style.stroke_first] {
            if stroke && let Some([r, g, b]) = style.stroke {
                paint.set_color_rgba8(r, g, b, 255);
                self.image.stroke_path(path, &paint, &style.pen, to_pixels, None);
            }
            let flat = path.bounds().width() == 0.0 || path.bounds().height() == 0.0;
            if !stroke
                && !flat
                && let Some([r, g, b]) = style.fill
            {
                paint.set_color_rgba8(r, g, b, 255);
                self.image.fill_path(path, &paint, FillRule::Winding, to_pixels, None);
            }
        }
    }

    /// Draws the image of the faces, stretched over its place on the page.
    fn shading(&mut self, tag: &Tag<'_>) -> Result<(), String> {
        let data =
            tag.text("href")?.strip_prefix("data:image/png;base64,").ok_or("an image is no PNG of ours")?;
        let png = STANDARD.decode(data).map_err(|error| format!("an image: {error}"))?;
        let image = Pixmap::decode_png(&png).map_err(|error| format!("an image: {error}"))?;
        let [x, y, width, height] = ["x", "y", "width", "height"].map(|name| tag.number(name));
        let [wide, high] = [image.width(), image.height()].map(|side| side as f32);
        let place = Transform::from_row(width? / wide, 0.0, 0.0, height? / high, x?, y?);
        let shader =
            Pattern::new(image.as_ref(), SpreadMode::Pad, FilterQuality::Bicubic, 1.0, Transform::identity());
        let paint = Paint { shader, ..Paint::default() };
        if let Some(all) = Rect::from_xywh(0.0, 0.0, wide, high) {
            self.image.fill_rect(all, &paint, self.to_pixels.pre_concat(place), None);
        }
        Ok(())
    }
}
