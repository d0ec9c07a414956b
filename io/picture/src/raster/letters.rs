//! Texts as outlines of the letters of the one font.

use std::collections::BTreeSet;

use tiny_skia::{Path, PathBuilder};
use ttf_parser::{GlyphId, OutlineBuilder};

use crate::text;

/// The outlines of a line of text, `anchor` of whose width is to the left of its place on the base line; `None` where nothing is seen.
///
/// As in SVG, spaces at the ends are not there, and several in a row are one. What the font lacks is its box. Its letters stand
/// side by side: it has no tables that would move them.
pub(super) fn outline(words: &str, [x, y]: [f32; 2], size: f32, anchor: f32) -> Option<Path> {
    let font = text::font()?;
    let scale = size / f32::from(font.units_per_em());
    let glyphs: Vec<GlyphId> = words
        .split(' ')
        .filter(|word| !word.is_empty())
        .flat_map(|word| [' '].into_iter().chain(word.chars()))
        .skip(1)
        .map(|letter| font.glyph_index(letter).unwrap_or_default())
        .collect();
    let advance = |glyph: &GlyphId| f32::from(font.glyph_hor_advance(*glyph).unwrap_or(0)) * scale;
    let width: f32 = glyphs.iter().map(advance).sum();
    let mut pen = Pen { path: PathBuilder::new(), origin: [x - anchor * width, y], scale };
    for glyph in &glyphs {
        // A glyph without an outline is a space.
        let _ = font.outline_glyph(*glyph, &mut pen);
        pen.origin[0] += advance(glyph);
    }
    pen.path.finish()
}

/// The letters of a text that the font lacks.
pub(super) fn lacking(words: &str) -> BTreeSet<char> {
    let Some(font) = text::font() else { return BTreeSet::new() };
    words.chars().filter(|&letter| letter != ' ' && font.glyph_index(letter).is_none()).collect()
}

/// Draws letters, whose y goes up, onto the page, whose y goes down.
struct Pen {
    path: PathBuilder,
    origin: [f32; 2],
    scale: f32,
}

impl Pen {
    fn at(&self, x: f32, y: f32) -> (f32, f32) {
        (self.origin[0] + x * self.scale, self.origin[1] - y * self.scale)
    }
}

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.path.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.path.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.at(x1, y1), self.at(x, y));
        self.path.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2), (x, y)) = (self.at(x1, y1), self.at(x2, y2), self.at(x, y));
        self.path.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.path.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_stand_where_they_should() {
        // DejaVu Sans: "l" is 569 of 2048 wide, its stem goes from 193 to 377, from the base line up to 1556.
        let bounds = |words: &str, anchor| outline(words, [10.0, 20.0], 2.048, anchor).unwrap().bounds();
        let near = |a: f32, b: f32| (a - b).abs() < 1e-5;
        let one = bounds("l", 0.0);
        assert!(near(one.left(), 10.193) && near(one.right(), 10.377), "{one:?}");
        assert!(near(one.top(), 20.0 - 1.556) && near(one.bottom(), 20.0), "{one:?}");
        assert!(near(bounds("ll", 0.0).right(), 10.377 + 0.569));
        assert!(near(bounds("ll", 1.0).left(), 10.193 - 2.0 * 0.569));
        assert!(near(bounds("ll", 0.5).left(), 10.193 - 0.569));
        assert_eq!(bounds("  l   l ", 0.5), bounds("l l", 0.5));
        assert!(outline(" ", [0.0; 2], 3.0, 0.0).is_none());
        // What the font lacks is a box.
        assert!(bounds("船", 0.0).width() > 0.5);
    }
}
