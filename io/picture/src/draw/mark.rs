//! Marks: where something was asked of a shape, and what.

use loftsman_kernel::Vector;
use loftsman_kernel::plugin::MarkKind;

use crate::labels::Label;
use crate::path::{Path, Spot};
use crate::sheet::{Layer, Sample, Sheet, Stroke};
use crate::stage::{Spotlight, Stage};
use crate::svg::{Element, escaped, length};
use crate::text;
use crate::theme::{Color, Theme};
use crate::view::Lens;

/// The radius of the largest glyph, in millimetres.
const RADIUS: f64 = 1.0;
/// Length of arrows for directions, of arrow heads, and of an osculating arc to each side, in millimetres.
const ARROW: f64 = 13.0;
const HEAD: f64 = 2.2;
const ARC: f64 = 11.0;

/// Labels that are drawn; more would hide the drawing.
const LABELLED: usize = 40;

/// Marks that are drawn.
const MOST: usize = 5000;

/// How much of the paper is in the colours of marks that are behind faces.
const BEHIND: f64 = 0.6;

/// What a mark is drawn with.
#[derive(Clone, Copy)]
struct Inks {
    ink: Color,
    accent: Color,
    paper: Color,
    /// Whether nothing but paper is around it, or faces.
    halo: bool,
}

impl Inks {
    fn new(theme: Theme) -> Self {
        Self { ink: theme.ink(), accent: theme.accent(), paper: theme.paper(), halo: false }
    }

    /// Those of a mark that may be behind faces: pale.
    fn of(sheet: &Sheet, hidden: bool) -> Self {
        let own = Self { halo: sheet.depth.is_some() && !hidden, ..Self::new(sheet.theme) };
        let pale = |color: Color| if hidden { color.mixed(own.paper, BEHIND) } else { color };
        Self { ink: pale(own.ink), accent: pale(own.accent), ..own }
    }
}

/// Draws all marks and asks for their labels; marks at one place share one label.
pub(crate) fn draw(sheet: &mut Sheet, stage: &Stage<'_>, labels: bool) {
    let mut groups: Vec<Label> = Vec::new();
    let mut behind = 0;
    for light in stage.marks.iter().take(MOST) {
        let spot = sheet.spot(&light.position);
        let hidden = sheet.hides(&light.position);
        behind += usize::from(hidden);
        let inks = Inks::of(sheet, hidden);
        let glyph = glyph(sheet, stage, light, (spot, inks));
        let group = format!(
            "<g class=\"mark {}\">\n<title>{}</title>\n{glyph}</g>\n",
            class(light.mark.kind),
            escaped(&light.mark.label)
        );
        sheet.put(Layer::Marks, &group);
        sheet.caption.explain(Sample::Mark(light.mark.kind), label(light.mark.kind));
        let line = text::clipped(&text::rounded(&light.mark.label), 48);
        // Locked vertices are explained by the legend: a label each would say nothing more.
        if !labels || line.is_empty() || light.mark.kind == MarkKind::Locked {
            continue;
        }
        let near = |g: &Label| (g.anchor[0] - spot[0]).hypot(g.anchor[1] - spot[1]) < 1.0;
        match groups.iter().position(near) {
            Some(i) if groups[i].lines.contains(&line) => {}
            Some(i) if groups[i].lines.len() < 5 => groups[i].lines.push(line),
            None if groups.len() < LABELLED => {
                let color = sheet.theme.ink();
                groups.push(Label { anchor: spot, lines: vec![line], color, row: None });
            }
            _ => {}
        }
    }
    if behind > 0 {
        sheet.caption.note("pale marks are behind faces".to_owned());
    }
    if stage.marks.len() > MOST {
        sheet.caption.note(format!("{MOST} of {} marks are drawn", stage.marks.len()));
    }
    sheet.labels.extend(groups);
}

fn class(kind: MarkKind) -> &'static str {
    match kind {
        MarkKind::Moved => "moved",
        MarkKind::Kept => "kept",
        MarkKind::Slides => "slides",
        MarkKind::Direction => "direction",
        MarkKind::Curvature => "curvature",
        MarkKind::Locked => "locked",
        _ => "other",
    }
}

fn label(kind: MarkKind) -> &'static str {
    match kind {
        MarkKind::Moved => "moved point",
        MarkKind::Kept => "kept point",
        MarkKind::Slides => "place that slides",
        MarkKind::Direction => "derivative or direction",
        MarkKind::Curvature => "curvature (osculating circle)",
        MarkKind::Locked => "locked vertex",
        _ => "constraint",
    }
}

fn glyph(sheet: &mut Sheet, stage: &Stage<'_>, light: &Spotlight<'_>, (spot, inks): (Spot, Inks)) -> String {
    let theme = sheet.theme;
    let mut out = String::new();
    match light.mark.kind {
        MarkKind::Moved => {
            let from = sheet.spot(&light.before);
            ink_arrow(sheet, from, spot, 6);
            if inks.halo {
                out.push_str(&halo(theme, from, spot, 0.45));
            }
            out.push_str(&arrow(from, spot, inks.accent.hex(), 0.45));
        }
        MarkKind::Direction => {
            if let Some(direction) = light.vector.and_then(|v| unit(sheet.layout.shift(&light.position, &v)))
            {
                let length = within(sheet, spot, direction);
                let to = [0, 1].map(|i| spot[i] + direction[i] * length);
                ink_arrow(sheet, spot, to, 5);
                if inks.halo {
                    out.push_str(&halo(theme, spot, to, 0.3));
                }
                out.push_str(&arrow(spot, to, inks.ink.hex(), 0.3));
            }
        }
        MarkKind::Curvature => out.push_str(&osculating(sheet, stage, light, inks.ink)),
        _ => {}
    }
    out.push_str(&glyph_at(inks, light.mark.kind, spot));
    // The whole glyph, not its middle alone.
    for [x, y] in [[RADIUS, 0.0], [0.0, RADIUS]] {
        sheet.ink.segment([spot[0] - x, spot[1] - y], [spot[0] + x, spot[1] + y], 8);
    }
    out
}

/// Leaves the ink of an arrow, its head included.
fn ink_arrow(sheet: &mut Sheet, from: Spot, to: Spot, weight: u16) {
    sheet.ink.segment(from, to, weight);
    let distance = (to[0] - from[0]).hypot(to[1] - from[1]);
    if let Some([x, y]) = unit([to[0] - from[0], to[1] - from[1]]) {
        let head = HEAD.min(0.6 * distance);
        let back = [to[0] - 1.12 * x * head, to[1] - 1.12 * y * head];
        let wing = [0.36 * head * -y, 0.36 * head * x];
        sheet.ink.segment(
            [back[0] - wing[0], back[1] - wing[1]],
            [back[0] + wing[0], back[1] + wing[1]],
            weight,
        );
    }
}

/// How long an arrow is that ends on the sheet; half as long as others at least, so that it is seen to be one.
fn within(sheet: &Sheet, spot: Spot, direction: Spot) -> f64 {
    let room = sheet.ink.area();
    let free = (0..2).map(|i| match direction[i] {
        d if d > 0.0 => (room.high[i] - spot[i]) / d,
        d if d < 0.0 => (room.low[i] - spot[i]) / d,
        _ => f64::INFINITY,
    });
    free.fold(ARROW, f64::min).max(0.5 * ARROW)
}

/// The directions in the picture's plane in which a mark's glyph reaches out from its place, x to the right and y up.
pub(crate) fn reaches(light: &Spotlight<'_>, lens: Lens) -> Vec<Spot> {
    let Some(vector) = light.vector else { return Vec::new() };
    let flat = lens.shift(&light.position, &vector);
    match (light.mark.kind, unit([flat.x, flat.y])) {
        (MarkKind::Direction, Some(along)) => vec![along],
        // The arc runs across the curvature vector.
        (MarkKind::Curvature, Some([x, y])) => vec![[-y, x], [y, -x]],
        _ => Vec::new(),
    }
}

/// The glyph at the place itself.
pub(crate) fn point(theme: Theme, kind: MarkKind, spot: Spot) -> String {
    glyph_at(Inks::new(theme), kind, spot)
}

fn glyph_at(inks: Inks, kind: MarkKind, [x, y]: Spot) -> String {
    let circle = |radius: f64| Element::new("circle").length("cx", x).length("cy", y).length("r", radius);
    let (ink, paper, accent) = (inks.ink.hex(), inks.paper.hex(), inks.accent.hex());
    match kind {
        MarkKind::Moved => {
            circle(0.95).attribute("fill", &accent).attribute("stroke", &paper).length("stroke-width", 0.2)
        }
        MarkKind::Slides => {
            circle(0.75).attribute("fill", &paper).attribute("stroke", &ink).length("stroke-width", 0.35)
        }
        MarkKind::Kept => {
            circle(0.85).attribute("fill", &ink).attribute("stroke", &paper).length("stroke-width", 0.2)
        }
        MarkKind::Direction | MarkKind::Curvature => {
            circle(0.5).attribute("fill", &ink).attribute("stroke", "none")
        }
        MarkKind::Locked => {
            let r = 0.9;
            let data = format!(
                "M{a} {b}L{c} {d}M{a} {d}L{c} {b}",
                a = length(x - r),
                b = length(y - r),
                c = length(x + r),
                d = length(y + r)
            );
            Element::new("path")
                .attribute("d", &data)
                .attribute("fill", "none")
                .attribute("stroke", &ink)
                .length("stroke-width", 0.3)
        }
        _ => circle(0.8).attribute("fill", &paper).attribute("stroke", &ink).length("stroke-width", 0.3),
    }
    .empty()
}

/// A displacement of the page, a millimetre long; `None` where it has no direction.
fn unit([x, y]: Spot) -> Option<Spot> {
    // Scaled first: lengths of vectors of the scene may be anything.
    let size = x.abs().max(y.abs());
    let (x, y) = (x / size, y / size);
    let norm = x.hypot(y);
    norm.is_finite().then(|| [x / norm, y / norm])
}

/// Paper around an arrow, so that it is seen on faces of its own colour.
fn halo(theme: Theme, from: Spot, to: Spot, width: f64) -> String {
    let Some(Arrow { shaft, head }) = Arrow::of(from, to) else { return String::new() };
    let around = |data: &str, width: f64| {
        let line = Stroke::plain(theme.paper(), width).path("halo", data.to_owned());
        line.attribute("stroke-linejoin", "round").empty()
    };
    around(&shaft, width + 0.5) + &around(&head, 0.5)
}

/// An arrow; one too short for its head is a line.
pub(crate) fn arrow(from: Spot, to: Spot, color: String, width: f64) -> String {
    let Some(Arrow { shaft, head }) = Arrow::of(from, to) else { return String::new() };
    let shaft = Element::new("path")
        .attribute("class", "arrow")
        .attribute("d", &shaft)
        .attribute("fill", "none")
        .attribute("stroke", &color)
        .length("stroke-width", width);
    let triangle = Element::new("path").attribute("d", &head).attribute("fill", &color);
    shaft.empty() + &triangle.empty()
}

/// The paths of an arrow.
struct Arrow {
    shaft: String,
    head: String,
}

impl Arrow {
    /// One that leads somewhere.
    fn of(from: Spot, to: Spot) -> Option<Self> {
        let distance = (to[0] - from[0]).hypot(to[1] - from[1]);
        let along = unit([to[0] - from[0], to[1] - from[1]])?;
        let head = HEAD.min(0.6 * distance);
        let neck = [0, 1].map(|i| to[i] - along[i] * head);
        let mut shaft = Path::default();
        shaft.move_to(from);
        shaft.line_to(neck);
        let wing = |side: f64| {
            let across = [-along[1] * side, along[0] * side];
            [0, 1].map(|i| neck[i] - along[i] * 0.12 * head + across[i] * 0.36 * head)
        };
        let mut triangle = Path::default();
        for spot in [to, wing(1.0), neck, wing(-1.0)] {
            triangle.line_to(spot);
        }
        triangle.close();
        Some(Self { shaft: shaft.finish(), head: triangle.finish() })
    }
}

/// An arc of the osculating circle about the mark, seen as the view sees it. The mark's vector is the curvature
/// vector `κN`: the centre is at `N/κ`. Nothing where the curve is straight.
fn osculating(sheet: &mut Sheet, stage: &Stage<'_>, light: &Spotlight<'_>, ink: Color) -> String {
    let size = stage.projection.size;
    let Some(normal) = light.vector.map(|v| v * size) else { return String::new() };
    let curvature = normal.norm();
    if !(curvature > 1e-6 && curvature.is_finite()) {
        return String::new();
    }
    let (radius, normal) = (1.0 / curvature, normal / curvature);
    let centre = light.position + normal * radius;
    // The tangent is not known here; in a planar view it is across the normal.
    let Some(tangent) = Vector::new(-normal.y, normal.x, 0.0).try_normalize(1e-9) else {
        return String::new();
    };
    let half = (ARC / (radius * sheet.layout.scale)).min(std::f64::consts::PI);
    let mut path = Path::default();
    let mut last: Option<Spot> = None;
    for i in -24..=24 {
        let (s, c) = (half * f64::from(i) / 24.0).sin_cos();
        let spot = sheet.spot(&(centre + (tangent * s - normal * c) * radius));
        if let Some(from) = last {
            sheet.ink.segment(from, spot, 6);
        }
        last = Some(spot);
        path.line_to(spot);
    }
    Stroke::plain(ink, 0.25).dashed().path("osculating", path.finish()).empty()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrows_point_where_they_go() {
        let text = arrow([0.0, 0.0], [10.0, 0.0], "#000".into(), 0.3);
        assert!(text.contains("d=\"M0 0L7.8 0\"") && text.contains("M10 0L7.536 0.792"), "{text}");
        assert_eq!(arrow([1.0, 1.0], [1.0, 1.0], "#000".into(), 0.3), "");
    }

    #[test]
    fn directions_of_any_length_are_directions() {
        for size in [1e-300, 1e-9, 1.0, 1e300] {
            let [x, y] = unit([3.0 * size, -4.0 * size]).unwrap();
            assert!((x - 0.6).abs() < 1e-15 && (y + 0.8).abs() < 1e-15);
        }
        assert_eq!(unit([0.0, 0.0]), None);
    }
}
