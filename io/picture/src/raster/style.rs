//! How an element looks: what its attributes say, and what it has from the elements around it.

use tiny_skia::{LineCap, LineJoin, Stroke, StrokeDash, Transform};

use super::reader::{Tag, number};

/// Attributes that say where an element is or what it means, not how it looks.
const ELSEWHERE: [&str; 20] = [
    "class",
    "cx",
    "cy",
    "d",
    "font-family",
    "height",
    "href",
    "id",
    "preserveAspectRatio",
    "r",
    "transform",
    "viewBox",
    "width",
    "x",
    "x1",
    "x2",
    "xmlns",
    "y",
    "y1",
    "y2",
];

/// How an element looks.
#[derive(Debug, Clone)]
pub(super) struct Style {
    pub(super) fill: Option<[u8; 3]>,
    pub(super) stroke: Option<[u8; 3]>,
    pub(super) pen: Stroke,
    /// Whether the fill covers the stroke.
    pub(super) stroke_first: bool,
    /// The size of letters, in millimetres.
    pub(super) size: f32,
    /// Which part of a text is to the left of its place: 0, a half or 1.
    pub(super) anchor: f32,
}

impl Default for Style {
    /// What SVG says of elements that say nothing.
    fn default() -> Self {
        Self {
            fill: Some([0; 3]),
            stroke: None,
            pen: Stroke::default(),
            stroke_first: false,
            size: 16.0,
            anchor: 0.0,
        }
    }
}

impl Style {
    /// The style of an element in one of this style.
    pub(super) fn with(&self, tag: &Tag<'_>) -> Result<Self, String> {
        let mut style = self.clone();
        for (name, value) in &tag.attributes {
            let unknown = || format!("{name}=\"{value}\" is unknown");
            match (*name, value.as_ref()) {
                ("fill", color) => style.fill = paint(color).ok_or_else(unknown)?,
                ("stroke", color) => style.stroke = paint(color).ok_or_else(unknown)?,
                ("stroke-width", width) => style.pen.width = number(width)?,
                ("stroke-dasharray", dashes) => {
                    let list = dashes.split(' ').map(number).collect::<Result<_, _>>()?;
                    style.pen.dash = Some(StrokeDash::new(list, 0.0).ok_or_else(unknown)?);
                }
                ("stroke-linecap", "butt") => style.pen.line_cap = LineCap::Butt,
                ("stroke-linecap", "round") => style.pen.line_cap = LineCap::Round,
                ("stroke-linejoin", "round") => style.pen.line_join = LineJoin::Round,
                ("paint-order", "stroke") => style.stroke_first = true,
                ("font-size", size) => style.size = number(size)?,
                ("text-anchor", "start") => style.anchor = 0.0,
                ("text-anchor", "middle") => style.anchor = 0.5,
                ("text-anchor", "end") => style.anchor = 1.0,
                (known, _) if ELSEWHERE.contains(&known) => {}
                _ => return Err(unknown()),
            }
        }
        Ok(style)
    }
}

/// A colour, or none; `None` where it is neither.
fn paint(text: &str) -> Option<Option<[u8; 3]>> {
    if text == "none" {
        return Some(None);
    }
    let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6)?;
    let [_, r, g, b] = u32::from_str_radix(digits, 16).ok()?.to_be_bytes();
    Some(Some([r, g, b]))
}

/// `translate(x y) rotate(angle)`: where a turned text stands.
pub(super) fn turned(text: &str) -> Result<Transform, String> {
    let parts = text.strip_prefix("translate(").and_then(|rest| rest.strip_suffix(')')).and_then(|rest| {
        let (place, angle) = rest.split_once(") rotate(")?;
        let (x, y) = place.split_once(' ')?;
        Some([x, y, angle])
    });
    let [x, y, angle] = parts.ok_or_else(|| format!("transform=\"{text}\" is unknown"))?.map(number);
    Ok(Transform::from_translate(x?, y?).pre_concat(Transform::from_rotate(angle?)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tag(attributes: &[(&'static str, &'static str)]) -> Tag<'static> {
        let attributes = attributes.iter().map(|(name, value)| (*name, (*value).into())).collect();
        Tag { name: "path", attributes, empty: true }
    }

    #[test]
    fn what_is_said_goes_before_what_is_around() {
        let around =
            Style::default().with(&tag(&[("stroke", "#0102ff"), ("stroke-linecap", "round")])).unwrap();
        let inner = around.with(&tag(&[("fill", "none"), ("stroke-linecap", "butt"), ("id", "a")])).unwrap();
        assert_eq!((inner.fill, inner.stroke), (None, Some([1, 2, 255])));
        assert_eq!((around.pen.line_cap, inner.pen.line_cap), (LineCap::Round, LineCap::Butt));
    }

    #[test]
    fn what_is_not_drawn_is_refused() {
        for bad in [("opacity", "0.5"), ("fill", "red"), ("fill", "#12345"), ("stroke-linecap", "square")] {
            assert!(Style::default().with(&tag(&[bad])).is_err(), "{bad:?}");
        }
        assert!(turned("rotate(3)").is_err());
    }

    #[test]
    fn turned_texts_go_up() {
        let mut tip = tiny_skia::Point::from_xy(1.0, 0.0);
        turned("translate(5 7) rotate(-90)").unwrap().map_point(&mut tip);
        assert!((tip.x - 5.0).abs() < 1e-6 && (tip.y - 6.0).abs() < 1e-6, "{tip:?}");
    }
}
