//! Under the drawing: axes, scale bar, what is what, and what was left out.

use loftsman_kernel::Vector;
use loftsman_kernel::scene::Unit;

use crate::draw::paint::{self, mapped};
use crate::draw::{dots, few, mark};
use crate::sheet::{Caption, Fill, Sample, Stroke};
use crate::stage::Projection;
use crate::svg::{Element, length};
use crate::text;
use crate::theme::{Color, Theme};

/// Sizes, in millimetres: of the words, from row to row, of the samples, and from entry to entry.
const SIZE: f64 = 2.9;
const ROW: f64 = 5.0;
const SAMPLE: f64 = 8.0;
const GAP: f64 = 6.0;

/// Room for axes and scale bar at the left.
const LEFT: f64 = 46.0;

/// The longest scale bar.
const LONGEST_BAR: f64 = LEFT - 20.0;

/// The most notes, and lines of one that is a list.
const NOTES: usize = 6;
const NOTE_LINES: usize = 2;

/// What a legend needs to know of the page.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Facts<'a> {
    pub(crate) theme: Theme,
    /// Where the legend begins, how wide the page is and its border.
    pub(crate) top: f64,
    pub(crate) width: f64,
    pub(crate) margin: f64,
    /// The view of all drawings, where they share one.
    pub(crate) view: Option<&'a Projection>,
    /// Millimetres of the page a unit of the scene, where there is one scale, and the unit.
    pub(crate) scale: Option<(f64, Unit)>,
}

/// The legend's elements, and where on the page it ends.
pub(crate) fn draw(caption: &Caption, facts: &Facts<'_>) -> (String, f64) {
    let Facts { theme, top, width, margin, view, scale } = *facts;
    let mut out = String::new();
    if let Some(view) = view {
        out.push_str(&axes(theme, view, [margin + 4.0, top + 6.0], 6.0));
    }
    if let Some((millimetres, unit)) = scale {
        let left = if view.is_some() { 15.0 } else { 1.0 };
        out.push_str(&scale_bar(theme, millimetres, [margin + left, top + 6.0], unit));
    }
    let room = if view.is_some() || scale.is_some() { LEFT } else { 0.0 };

    // Entries flow in rows of the width that is left.
    let (start, end) = (margin + room, width - margin);
    let (mut x, mut y) = (start, top + 1.5);
    for scale in &caption.scales {
        // Numbers are not cut.
        for (i, line) in text::wrapped_in(&scale.title(), SIZE, end - x, 6).iter().enumerate() {
            y += if i > 0 { 0.85 * ROW } else { 0.0 };
            out.push_str(&words_at(&text::fitting(line, SIZE, end - x), x, y + 0.35 * SIZE, theme.ink()));
        }
        let ends = (scale.end, scale.is_exceeded());
        out.push_str(&color_bar(theme, ends, BAR.min(end - x), [x, y + ROW]));
        y += 3.0 * ROW;
    }
    for (sample, words) in &caption.legend {
        let wide = SAMPLE + 1.5 + text::width(words) * SIZE;
        if x > start && x + wide > end {
            (x, y) = (start, y + ROW);
        }
        out.push_str(&draw_sample(theme, *sample, x, y));
        let words = text::fitting(words, SIZE, end - x - SAMPLE - 1.5);
        out.push_str(&words_at(&words, x + SAMPLE + 1.5, y + 0.35 * SIZE, theme.ink()));
        x += wide + GAP;
    }
    let mut bottom = y + 1.5;
    let notes =
        caption.all_notes(|note| text::wrapped_in(note, SIZE, end - start, usize::MAX).len() <= NOTE_LINES);
    let more = notes.len().saturating_sub(NOTES);
    let more = (more > 0).then(|| format!("and {more} more notes of this kind"));
    for note in caption.others().iter().chain(notes.iter().take(NOTES)).chain(&more) {
        for line in text::wrapped(note, SIZE, end - start) {
            bottom += ROW * 0.85;
            out.push_str(&words_at(&text::fitting(&line, SIZE, end - start), start, bottom, theme.faint()));
        }
    }
    let left = if room > 0.0 { top + 8.0 } else { bottom };
    (Element::new("g").attribute("id", "legend").around(&out), bottom.max(left))
}

/// How long a bar of colours is, and of how many pieces it is made.
const BAR: f64 = 48.0;
const PIECES: usize = 64;

/// A bar of colours with the values at its ends (and beyond them) and in its middle.
fn color_bar(theme: Theme, (most, beyond): (f64, bool), long: f64, [x, y]: [f64; 2]) -> String {
    let mut out = String::new();
    let wide = long / PIECES as f64;
    for i in 0..PIECES {
        let share = 2.0 * (i as f64 + 0.5) / PIECES as f64 - 1.0;
        // Each a little over the next, so that no gap shows between them.
        let piece = Element::new("rect").length("x", x + i as f64 * wide).length("y", y - 1.5);
        let piece = piece.length("width", wide + 0.05).length("height", 3.0);
        out.push_str(&piece.attribute("fill", &mapped(share).hex()).empty());
    }
    let frame = Element::new("rect").length("x", x).length("y", y - 1.5).length("width", long);
    let frame =
        frame.length("height", 3.0).attribute("fill", "none").attribute("stroke", &theme.faint().hex());
    out.push_str(&frame.length("stroke-width", 0.2).empty());
    let (least, more) = if beyond { ("≤ ", "≥ ") } else { ("", "") };
    let ends = [(0.0, least, -most, "start"), (0.5, "", 0.0, "middle"), (1.0, more, most, "end")];
    for (share, sign, value, anchor) in ends {
        if most == 0.0 && share != 0.5 {
            continue;
        }
        let text = Element::new("text").length("x", x + share * long).length("y", y + 1.5 + 1.1 * SIZE);
        let text = text.length("font-size", SIZE).attribute("text-anchor", anchor);
        out.push_str(
            &text.attribute("fill", &theme.ink().hex()).text(&format!("{sign}{}", text::figure(value))),
        );
    }
    out
}

fn words_at(words: &str, x: f64, y: f64, color: Color) -> String {
    let text = Element::new("text").length("x", x).length("y", y).length("font-size", SIZE);
    text.attribute("fill", &color.hex()).text(words)
}

fn draw_sample(theme: Theme, sample: Sample, x: f64, y: f64) -> String {
    let line = |stroke: Stroke| {
        stroke.path("sample", format!("M{} {}h{}", length(x), length(y), length(SAMPLE))).empty()
    };
    match sample {
        Sample::Line(stroke) => line(stroke),
        Sample::Alternate(one, other) => {
            let part = |stroke: Stroke, x: f64, wide: f64| {
                stroke.path("sample", format!("M{} {}h{}", length(x), length(y), length(wide))).empty()
            };
            part(other, x + 0.5 * SAMPLE, 0.5 * SAMPLE) + &part(one, x, 0.5 * SAMPLE)
        }
        Sample::Movement => {
            let color = theme.accent().mixed(theme.paper(), 0.25);
            mark::arrow([x, y], [x + SAMPLE, y], color.hex(), 0.22)
        }
        Sample::Net(stroke) => {
            let square = |x: f64| format!("M{} {}h1.2v1.2h-1.2z", length(x - 0.6), length(y - 0.6));
            let squares = Element::new("path")
                .attribute("d", &(square(x + 0.6) + &square(x + SAMPLE - 0.6)))
                .attribute("fill", &theme.paper().hex())
                .attribute("stroke", &stroke.color.hex())
                .length("stroke-width", 0.22);
            line(stroke) + &squares.empty()
        }
        Sample::Comb(color) => {
            let teeth: String = (0..=8)
                .map(|i| f64::from(i) / 8.0)
                .map(|t| {
                    let tall = 1.2 + 1.3 * (t * std::f64::consts::PI).sin();
                    format!("M{} {}v-{}", length(x + t * SAMPLE), length(y + 1.3), length(tall))
                })
                .collect();
            let tone = color.mixed(theme.paper(), 0.5);
            let base = format!("M{} {}h{}", length(x), length(y + 1.3), length(SAMPLE));
            Stroke::plain(tone, 0.1).path("sample", teeth).empty()
                + &Stroke::plain(color, 0.3).path("sample", base).empty()
        }
        Sample::Bead(color) => {
            let data = dots(&[[x + SAMPLE / 2.0, y]]);
            line(Stroke::plain(color, 0.5))
                + &Stroke::plain(color, 1.4).path("sample", data.clone()).empty()
                + &Stroke::plain(theme.paper(), 0.7).path("sample", data).empty()
        }
        Sample::Dot(color) => {
            let spots = [0.25, 0.5, 0.75].map(|t| [x + t * SAMPLE, y]);
            Stroke::plain(color, 0.7).path("sample", dots(&spots)).empty()
        }
        Sample::Spot(color) => few(theme, color, &[[x + SAMPLE / 2.0, y]], "sample"),
        Sample::Face(fill) => draw_fill(theme, fill, [x, y], SAMPLE),
        Sample::Lined(fill, stroke) => {
            let half = 0.5 * SAMPLE;
            let data = format!("M{} {}h{}", length(x + half), length(y), length(half));
            stroke.path("sample", data).empty() + &draw_fill(theme, fill, [x, y], half)
        }
        Sample::Number(number) => Element::new("text")
            .length("x", x + SAMPLE)
            .length("y", y + 0.35 * SIZE)
            .length("font-size", SIZE)
            .attribute("text-anchor", "end")
            .attribute("fill", &theme.ink().hex())
            .text(&format!("{number}:")),
        Sample::Mark(kind) => {
            use loftsman_kernel::plugin::MarkKind;
            let (beside, end) = ([x + SAMPLE - 1.5, y], [x + SAMPLE - 0.5, y]);
            match kind {
                MarkKind::Moved => {
                    mark::arrow([x, y], end, theme.accent().hex(), 0.45) + &mark::point(theme, kind, end)
                }
                MarkKind::Direction => {
                    mark::arrow([x, y], end, theme.ink().hex(), 0.3) + &mark::point(theme, kind, [x, y])
                }
                MarkKind::Curvature => {
                    let data = format!(
                        "M{} {}q{} -2.4 {} 0",
                        length(x),
                        length(y + 0.6),
                        length(SAMPLE / 2.0),
                        length(SAMPLE)
                    );
                    Stroke::plain(theme.ink(), 0.25).dashed().path("sample", data).empty()
                        + &mark::point(theme, kind, [x + SAMPLE / 2.0, y - 0.6])
                }
                _ => mark::point(theme, kind, beside),
            }
        }
    }
}

/// A piece of a face, so wide.
fn draw_fill(theme: Theme, fill: Fill, [x, y]: [f64; 2], wide: f64) -> String {
    let piece = |x: f64, wide: f64| {
        Element::new("rect").length("x", x).length("y", y - 1.5).length("width", wide).length("height", 3.0)
    };
    match fill {
        Fill::Plain(color) => piece(x, wide)
            .attribute("fill", &theme.lit(color, 0.7).hex())
            .attribute("stroke", &color.mixed(theme.ink(), 0.25).hex())
            .length("stroke-width", 0.2)
            .empty(),
        Fill::Stripes => {
            let frame = piece(x, wide).attribute("fill", &paint::LIGHT.hex());
            let frame = frame.attribute("stroke", &theme.faint().hex()).length("stroke-width", 0.2).empty();
            let stripe = |k: u8| {
                let left = x + (2.0 * f64::from(k) + 0.5) * wide / 8.0;
                piece(left, wide / 8.0).attribute("fill", &paint::DARK.hex()).empty()
            };
            frame + &(0..4).map(stripe).collect::<String>()
        }
        Fill::Map => (0..16_u8)
            .map(|k| {
                let part = wide / 16.0;
                let color = mapped((f64::from(k) - 7.5) / 7.5);
                piece(x + f64::from(k) * part, part + 0.05).attribute("fill", &color.hex()).empty()
            })
            .collect(),
    }
}

/// Small arrows along the axes of the scene, as the view shows them; an axis that points at the viewer is left
/// out.
pub(crate) fn axes(theme: Theme, projection: &Projection, corner: [f64; 2], long: f64) -> String {
    let mut out = String::new();
    let turned = [("x", Vector::x()), ("y", Vector::y()), ("z", Vector::z())]
        .map(|(name, axis)| (name, projection.direction(&axis)));
    // Where arrows go left or down, the origin moves right or up.
    let reach = |i: usize| turned.iter().map(|(_, d)| d[i]).fold(0.0, f64::min) * -long;
    let origin = [corner[0] - 3.0 + reach(0), corner[1] - reach(1)];
    let color = theme.faint();
    for (name, d) in turned {
        let along = [d.x, -d.y];
        if along[0].hypot(along[1]) < 0.2 {
            continue;
        }
        let tip = [0, 1].map(|i| origin[i] + along[i] * long);
        out.push_str(&mark::arrow(origin, tip, color.hex(), 0.25));
        let at = [0, 1].map(|i| origin[i] + along[i] * (long + 1.6));
        let text = Element::new("text")
            .length("x", at[0])
            .length("y", at[1] + 0.9)
            .length("font-size", 2.6)
            .attribute("text-anchor", "middle")
            .attribute("fill", &color.hex());
        out.push_str(&text.text(name));
    }
    out
}

/// A bar as long as 1, 2 or 5 times a power of ten of the scene's unit.
fn scale_bar(theme: Theme, millimetres: f64, [x, y]: [f64; 2], unit: Unit) -> String {
    let (value, bar) = bar(millimetres);
    let color = theme.faint();
    let data = format!(
        "M{} {}v1.6M{} {}h{}m0 -0.8v1.6",
        length(x),
        length(y - 0.8),
        length(x),
        length(y),
        length(bar)
    );
    let bar_path = Stroke::plain(color, 0.3).path("scale-bar", data).empty();
    let text = Element::new("text")
        .length("x", x + bar / 2.0)
        .length("y", y - 1.4)
        .length("font-size", 2.6)
        .attribute("text-anchor", "middle")
        .attribute("fill", &color.hex());
    bar_path + &text.text(&long(value, unit))
}

/// How long the scale bar is, in the scene's unit and in millimetres of the page, where a unit of the scene is as many `millimetres` long.
pub(crate) fn bar(millimetres: f64) -> (f64, f64) {
    round_bar(millimetres, LONGEST_BAR)
}

/// A length as the scale bar says it.
pub(crate) fn long(value: f64, unit: Unit) -> String {
    let one = unit == Unit::Unknown && value == 1.0;
    format!("{} {}", text::number(value), if one { "unit".into() } else { unit.symbol() })
}

/// The largest 1, 2 or 5 · 10ᵏ units that is at most `most` millimetres, and how many millimetres it is.
fn round_bar(millimetres: f64, most: f64) -> (f64, f64) {
    let longest = most / millimetres;
    let power = longest.log10().floor();
    let mut best = (0.0, 0.0);
    for digit in [1.0, 2.0, 5.0, 10.0] {
        // In two steps where the power itself would underflow.
        let value = digit * 10_f64.powf(power);
        if value <= longest * (1.0 + 1e-9) {
            best = (value, value * millimetres);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_bars_are_round_and_fit() {
        for (millimetres, value) in [(162.0, 0.1), (3.0, 5.0), (26.0, 1.0), (1.3e10, 2e-9), (8e-8, 2e8)] {
            let (found, bar) = round_bar(millimetres, 26.0);
            assert!((found / value - 1.0).abs() < 1e-9, "{found} {value}");
            assert!(bar <= 26.001 && bar > 10.0);
        }
    }
}
