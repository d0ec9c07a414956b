//! Labels as they are drawn: their lines of text, and the leader to what they name.

use super::{BESIDE, LEADING, Label, SIZE};
use crate::layout::Rect;
use crate::path::Spot;
use crate::svg::Element;
use crate::theme::{Color, Theme};

/// A leader of a number ends so far from it, in millimetres; one that is nearly level further off, since it would be read as a minus.
pub(super) const GAP: f64 = 0.4;
pub(super) const LEVEL_GAP: f64 = 1.1;
/// Level is what rises by less than this part of its way.
const LEVEL: f64 = 0.3;

/// The ends of the line from a label's anchor to its text; none where they are close together.
pub(super) fn leader(label: &Label, rect: &Rect, radius: f64) -> Option<[Spot; 2]> {
    let near = [0, 1].map(|i| label.anchor[i].clamp(rect.low[i], rect.high[i]));
    let d = [near[0] - label.anchor[0], near[1] - label.anchor[1]];
    let distance = d[0].hypot(d[1]);
    (radius > BESIDE && distance > 2.5).then(|| {
        let start = [0, 1].map(|i| label.anchor[i] + d[i] * 1.4 / distance);
        let level = label.row.is_some() && d[1].abs() < LEVEL * d[0].abs();
        let gap = if level { LEVEL_GAP.min(distance - 1.6) } else { GAP };
        [start, [0, 1].map(|i| near[i] - d[i] * gap / distance)]
    })
}

/// A label with its leader, as SVG; `halo` keeps what is beneath away from both.
pub(super) fn draw(label: &Label, rect: &Rect, radius: f64, (theme, halo): (Theme, bool)) -> String {
    let mut out = String::new();
    if let Some([start, end]) = leader(label, rect, radius) {
        let line = |class: &str, color: Color, width: f64| {
            let line = Element::new("line").attribute("class", class);
            let line = line.length("x1", start[0]).length("y1", start[1]);
            let line = line.length("x2", end[0]).length("y2", end[1]);
            line.attribute("stroke", &color.hex()).length("stroke-width", width).empty()
        };
        if halo {
            out.push_str(&line("halo", theme.paper(), 0.6));
            out.push_str(&line("leader", theme.ink(), 0.15));
        } else {
            out.push_str(&line("leader", theme.faint(), 0.15));
        }
    }
    // Beside its anchor a text is flush with it; above or below it is centred.
    let (anchor, x) = if rect.low[0] >= label.anchor[0] {
        ("start", rect.low[0])
    } else if rect.high[0] <= label.anchor[0] {
        ("end", rect.high[0])
    } else {
        ("middle", (rect.low[0] + rect.high[0]) / 2.0)
    };
    for (i, line) in label.lines.iter().enumerate() {
        let text = Element::new("text")
            .attribute("class", "label")
            .length("x", x)
            .length("y", rect.low[1] + LEADING * (i as f64 + 0.78))
            .length("font-size", SIZE)
            .attribute("text-anchor", anchor)
            .attribute("fill", &label.color.hex())
            .attribute("stroke", &theme.paper().hex())
            .length("stroke-width", 0.7)
            .attribute("stroke-linejoin", "round")
            .attribute("paint-order", "stroke");
        out.push_str(&text.text(line));
    }
    out
}
