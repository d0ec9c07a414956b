//! From a picture's wishes to a page: panels in rows and columns, drawings to one scale, title and legend.

use std::borrow::Cow;
use std::collections::HashMap;

use loftsman_kernel::plugin::Mark;
use loftsman_kernel::scene::{Geometry, MOST_PLACED, Scene, Unit};

use crate::chart::Chart;
use crate::choices::{Choices, Faces, Frames};
use crate::draw::comb::{Combing, Measure};
use crate::draw::paint::Painting;
use crate::draw::{self, legend};
use crate::error::PictureError;
use crate::film;
use crate::layout::{Layout, Rect};
use crate::panel::{Panel, Shown};
use crate::picture::Picture;
use crate::sheet::{Caption, Sheet};
use crate::stage::scenery::Scenery;
use crate::stage::solid::Solids;
use crate::stage::{Projection, Stage};
use crate::svg::{Element, length};
use crate::text::{self, wrapped};
use crate::theme::Theme;
use crate::view::{Lens, View};

/// The border of the page, in millimetres; what is between columns and between rows; captions.
const MARGIN: f64 = 9.0;
const GUTTER: f64 = 9.0;
const CAPTION: f64 = 6.5;

/// How much room the axes of a panel take on the left, below it.
const AXES: f64 = 9.0;

/// The size of captions, and from line to line.
const SIZE: f64 = 3.2;
const LEADING: f64 = 4.2;

/// Drawings more than this many times wider than high go one below the other.
const WIDE: f64 = 1.8;

/// A panel, ready to be put somewhere.
struct Part<'a> {
    panel: &'a Panel,
    stage: Stage<'a>,
    content: Content,
}

enum Content {
    Drawing { combs: Combing, bounds: Rect, painting: Painting },
    Chart(Chart),
}

/// A panel that shows what the instances show that it names, and what hangs under the groups; `flat` is the scene without instances.
fn with_contents(panel: &Panel, scene: &Scene, flat: &Scene) -> Panel {
    let mut panel = panel.clone();
    let Some(names) = &mut panel.objects else { return panel };
    let named = |name: &&String, is: fn(&Geometry) -> bool| scene.get(name).is_some_and(|o| is(o.geometry()));
    let instances = names.iter().filter(|name| named(name, |g| matches!(g, Geometry::Instance(_))));
    let within: Vec<String> = instances.map(|name| format!("{name}/")).collect();
    let groups: Vec<&str> = names
        .iter()
        .filter(|name| named(name, |g| matches!(g, Geometry::Group)))
        .map(String::as_str)
        .collect();
    let inside = |name: &str| scene.get(name).is_none() && within.iter().any(|w| name.starts_with(w));
    let mut more: Vec<String> = if within.is_empty() {
        Vec::new()
    } else {
        flat.objects().iter().map(|o| o.name().to_owned()).filter(|name| inside(name)).collect()
    };
    more.extend(below(flat, groups));
    names.extend(more);
    panel
}

/// All that hangs under objects of these names, at any depth.
fn below(scene: &Scene, tops: Vec<&str>) -> Vec<String> {
    if tops.is_empty() {
        return Vec::new();
    }
    let mut children: HashMap<&str, Vec<&str>> = HashMap::new();
    for object in scene.objects() {
        if let Some(parent) = &object.parent {
            children.entry(parent).or_default().push(object.name());
        }
    }
    let (mut found, mut open) = (Vec::new(), tops);
    while let Some(name) = open.pop() {
        // Taken out, so that a circle of parents ends.
        for child in children.remove(name).unwrap_or_default() {
            found.push(child.to_owned());
            open.push(child);
        }
    }
    found
}

/// The picture as an SVG document.
pub(crate) fn compose(picture: &Picture<'_>) -> Result<String, PictureError> {
    let (unit, up) = (picture.scene.unit, picture.scene.up);
    let scene = picture.scene.seen(MOST_PLACED)?;
    let before = picture.before.map(|scene| scene.seen(MOST_PLACED)).transpose()?;
    let before = before.as_ref().map(|scene| scene.converted(unit, up)).transpose()?;
    let (mut scene, mut before, mut marks) = (scene, before, Cow::Borrowed(picture.marks));
    let hidden = picture.scene.hidden_layers();
    if !hidden.is_empty() {
        let is_hidden = |name: &str| scene.get(name).is_some_and(|object| hidden.hides(object));
        if let Some(before) = &mut before {
            // What is hidden now was so before, whatever layer it was on.
            before.to_mut().empty(|object| is_hidden(object.name()))?;
        }
        marks.to_mut().retain(|mark| !is_hidden(&mark.object));
    }
    for colored in [Some(&mut scene), before.as_mut()].into_iter().flatten() {
        if colored.colored_layers() > 0 {
            colored.to_mut().color_by_layer()?;
        }
    }
    let only = [Panel::view(picture.view)];
    let panels: &[Panel] = if picture.panels.is_empty() { &only } else { &picture.panels };
    let panels: Vec<Panel> = panels.iter().map(|panel| with_contents(panel, picture.scene, &scene)).collect();
    let panels = film::strip(panels, picture.frames, &scene)?;
    // Several panels may show one moment, from several sides.
    let mut moments: Vec<f64> = panels.iter().filter_map(|panel| panel.moment).collect();
    moments.sort_by(f64::total_cmp);
    moments.dedup();
    let stills = moments.iter().map(|moment| scene.at(*moment)).collect::<Result<Vec<Scene>, _>>()?;
    let shown: Vec<&Scene> =
        [Some(&*scene), before.as_deref()].into_iter().flatten().chain(&stills).collect();
    let solids = Solids::of(&shown, picture.tessellator)?;
    // What let go on the way is marked in its moments only.
    let ends: Vec<Mark> = marks.iter().filter(|mark| mark.stays()).cloned().collect();
    let scenery = Scenery::new(&scene, (before.as_deref(), None), &ends, picture.frames, &panels, &solids)?;
    let at = |(moment, still): (&f64, &Scene)| followed(&marks, *moment, &scene, still);
    let moving: Vec<Vec<Mark>> = moments.iter().zip(&stills).map(at).collect();
    let still =
        |(still, marks)| Scenery::new(still, (None, Some(&*scene)), marks, Frames::Off, &panels, &solids);
    let sceneries = stills
        .iter()
        .zip(moving.iter().map(Vec::as_slice))
        .map(still)
        .collect::<Result<Vec<_>, PictureError>>()?;
    let of = |panel: &Panel| {
        let at = panel.moment.and_then(|moment| moments.iter().position(|m| m.total_cmp(&moment).is_eq()));
        at.and_then(|at| sceneries.get(at)).unwrap_or(&scenery)
    };
    let mut parts = panels
        .iter()
        .map(|panel| Part::new(panel, of(panel), &picture.choices))
        .collect::<Result<Vec<_>, PictureError>>()?;
    measure(&mut parts, &picture.choices);

    let top = if picture.title.is_some() { MARGIN + 7.0 } else { MARGIN };
    let columns = picture.columns.unwrap_or_else(|| columns(&parts)).min(parts.len());
    let cell = ((picture.width - 2.0 * MARGIN) - GUTTER * (columns - 1) as f64) / columns as f64;
    // Beside one another, what is higher than wide may be as high as a drawing alone.
    let tallest = parts.iter().map(Part::tallness).fold(0.9, f64::max);
    let usual = if parts.len() == 1 {
        0.65 * picture.width
    } else {
        (tallest * cell).min(0.65 * picture.width).max(0.9 * cell)
    };
    let highest = picture.height.unwrap_or(usual);
    parts.chunks_mut(columns).for_each(align);
    // One scale for all that have one: the smallest that each of them needs.
    let common = parts.iter().filter_map(|p| p.scale(cell, highest)).fold(f64::INFINITY, f64::min);
    let common = if common.is_finite() { common } else { cell / 4.0 };

    let several = parts.iter().filter_map(Part::view).any(|view| !view.looks_like(parts[0].view_or(view)));
    let count = parts.len();
    let panels: Vec<&Panel> = parts.iter().map(|part| part.panel).collect();
    let (mut content, mut caption, mut y) = (String::new(), Caption::default(), top);
    for (row, list) in parts.chunks(columns).enumerate() {
        let high = list.iter().map(|part| part.height(common, cell, highest)).fold(0.0, f64::max);
        let mut lines = 0;
        for (column, part) in list.iter().enumerate() {
            let left = MARGIN + column as f64 * (cell + GUTTER);
            let area = Rect { low: [left, y], high: [left + cell, y + high] };
            let number = row * columns + column + 1;
            let mut sheet = part.sheet(picture.theme, area, common, highest, caption, count == 1);
            sheet.name = (count > 1).then(|| match &part.panel.caption {
                Some(caption) => text::clipped(caption, 30),
                None => side(part.panel, &panels).map_or_else(|| format!("drawing {number}"), str::to_owned),
            });
            part.draw(&mut sheet, &picture.choices, unit)?;
            let suffix = if count == 1 { String::new() } else { format!("-{number}") };
            content.push_str(&sheet.content(&suffix));
            content.push_str(&part.caption(picture.theme, &area, several));
            lines = lines.max(part.lines(cell, several).len());
            caption = sheet.caption;
        }
        let captions = if lines > 0 { CAPTION + LEADING * (lines - 1) as f64 } else { 0.0 };
        y += high + captions.max(if several { 9.0 } else { 0.0 }) + GUTTER;
    }
    let mut bottom = y - GUTTER + MARGIN;
    if picture.legend {
        let views = || parts.iter().filter_map(Part::view);
        let facts = legend::Facts {
            theme: picture.theme,
            top: bottom,
            width: picture.width,
            margin: MARGIN,
            view: views().next().filter(|_| !several),
            scale: views().find(|view| view.lens().is_parallel()).map(|view| (common / view.size, unit)),
        };
        let (legend, end) = legend::draw(&caption, &facts);
        content.push_str(&legend);
        bottom = end + 0.6 * MARGIN;
    }
    Ok(document(picture, &content, bottom))
}

/// The marks where their places are in a scene at a moment, `still`; those that have none there are left out.
fn followed(marks: &[Mark], moment: f64, scene: &Scene, still: &Scene) -> Vec<Mark> {
    let follow = |mark: &Mark| {
        let mut mark = mark.clone();
        let objects = scene.get(&mark.object).zip(still.get(&mark.object));
        let there = objects.is_some_and(|(moves, still)| mark.go_to(moment, moves, still.geometry()));
        // Where it was before is not of this moment.
        mark.before = mark.position;
        there.then_some(mark)
    };
    marks.iter().filter_map(follow).collect()
}

/// Gives all combs one measure, and all drawings their bounds.
fn measure(parts: &mut [Part<'_>], choices: &Choices) {
    let combings = parts.iter().filter_map(|part| match &part.content {
        Content::Drawing { combs, .. } => Some(combs),
        Content::Chart(_) => None,
    });
    let size = parts.first().map_or(1.0, |part| part.stage.projection.size);
    let measure = Measure::of(combings, choices.combs, size);
    // Colours of one thing mean the same in all drawings.
    let ends: Vec<(Faces, f64)> = parts
        .iter()
        .filter_map(|part| match &part.content {
            Content::Drawing { painting, .. } => Some(painting.end()),
            Content::Chart(_) => None,
        })
        .collect();
    for part in parts {
        if let Content::Drawing { combs, bounds, painting } = &mut part.content {
            let (faces, _) = painting.end();
            let alike = || ends.iter().filter(|(other, _)| *other == faces);
            let end = alike().map(|(_, end)| *end).fold(0.0, f64::max);
            *painting = std::mem::take(painting).ending(end, alike().count() > 1);
            *combs = std::mem::take(combs).measured(measure);
            *bounds = draw::bounds(&part.stage, combs, choices);
        }
    }
}

/// Drawings beside one another that are seen the same way keep their heights, where that does not cost much room.
fn align(row: &mut [Part<'_>]) {
    let Some(first) = row.iter().find_map(Part::view).copied() else { return };
    let (mut low, mut high, mut most) = (f64::INFINITY, f64::NEG_INFINITY, 0.0_f64);
    let mut alike = row.iter_mut().filter(|part| part.view().is_some_and(|view| view.looks_like(&first)));
    let mut bounds: Vec<&mut Rect> = alike
        .by_ref()
        .filter_map(|part| match &mut part.content {
            Content::Drawing { bounds, .. } if bounds.low[0].is_finite() => Some(bounds),
            _ => None,
        })
        .collect();
    for rect in &bounds {
        (low, high, most) = (low.min(rect.low[1]), high.max(rect.high[1]), most.max(rect.size()[1]));
    }
    if high - low <= 1.35 * most {
        for rect in &mut bounds {
            (rect.low[1], rect.high[1]) = (low, high);
        }
    }
}

/// From where a panel shows the scene, in words, where no other does so from there.
fn side(panel: &Panel, all: &[&Panel]) -> Option<&'static str> {
    let Shown::Drawing(view) = panel.shown else { return None };
    let alike = all.iter().filter(|other| other.shown == panel.shown).count();
    view.words().filter(|_| alike == 1)
}

/// How many columns suit: wide drawings and charts go one below the other.
fn columns(parts: &[Part<'_>]) -> usize {
    let wide = parts.iter().all(|part| match &part.content {
        Content::Chart(_) => true,
        Content::Drawing { bounds, .. } => bounds.size()[0] > WIDE * bounds.size()[1],
    });
    let charts = parts.iter().any(|part| matches!(part.content, Content::Chart(_)));
    match parts.len() {
        count @ 2..=3 if !(wide || charts) => count,
        0..=3 => 1,
        4 => 2,
        _ => 3,
    }
}

impl<'a> Part<'a> {
    fn new(panel: &'a Panel, scenery: &Scenery<'a>, choices: &Choices) -> Result<Self, PictureError> {
        let only = panel.objects.as_deref();
        Ok(match panel.shown {
            Shown::Drawing(view) => {
                let stage = scenery.stage(view, only)?;
                let combs = Combing::of(&stage, choices);
                let painting = Painting::of(&stage, panel.faces.unwrap_or(choices.faces));
                Self { panel, stage, content: Content::Drawing { combs, bounds: Rect::NONE, painting } }
            }
            Shown::Profile(against) => {
                let stage = scenery.stage(View::Automatic, only)?;
                let chart = Chart::of(&stage, against)?;
                Self { panel, stage, content: Content::Chart(chart) }
            }
        })
    }

    /// How many times as high as wide a drawing is.
    fn tallness(&self) -> f64 {
        match &self.content {
            Content::Drawing { bounds, .. } => {
                let [width, height] = bounds.size();
                if width > 0.0 { height / width } else { 0.0 }
            }
            Content::Chart(_) => 0.0,
        }
    }

    /// The view of a drawing.
    fn view(&self) -> Option<&Projection> {
        matches!(self.content, Content::Drawing { .. }).then_some(&self.stage.projection)
    }

    fn view_or<'s>(&'s self, other: &'s Projection) -> &'s Projection {
        self.view().unwrap_or(other)
    }

    fn lens(&self) -> Lens {
        self.stage.projection.lens()
    }

    /// The largest scale of a drawing that shares its scale with others.
    fn scale(&self, cell: f64, highest: f64) -> Option<f64> {
        match &self.content {
            Content::Drawing { bounds, .. } if self.lens().is_parallel() => {
                Layout::scale_of(bounds, cell, highest)
            }
            _ => None,
        }
    }

    /// The scale of this drawing: a perspective has its own.
    fn own_scale(&self, common: f64, cell: f64, highest: f64) -> f64 {
        match &self.content {
            Content::Drawing { bounds, .. } if !self.lens().is_parallel() => {
                Layout::scale_of(bounds, cell, highest).unwrap_or(common)
            }
            _ => common,
        }
    }

    fn height(&self, common: f64, cell: f64, highest: f64) -> f64 {
        match &self.content {
            Content::Chart(_) => (0.5 * cell).clamp(28.0, 70.0).min(highest.max(28.0)),
            Content::Drawing { bounds, .. } => {
                let high = bounds.size()[1] * self.own_scale(common, cell, highest);
                high.max((0.2 * cell).min(highest))
            }
        }
    }

    fn sheet(
        &self,
        theme: Theme,
        area: Rect,
        common: f64,
        highest: f64,
        caption: Caption,
        alone: bool,
    ) -> Sheet {
        let bounds = match &self.content {
            Content::Drawing { bounds, .. } => *bounds,
            Content::Chart(_) => Rect::NONE,
        };
        let scale = self.own_scale(common, area.size()[0], highest);
        let layout = Layout::new(&bounds, scale, self.lens(), area);
        // Labels may stand a little beside the drawing, but not in the title above it or in the next panel.
        let spare = if alone { 5.0 } else { 0.45 * GUTTER };
        let room = Rect {
            low: [area.low[0] - spare, area.low[1]],
            high: [area.high[0] + spare, area.high[1] + if alone { spare } else { 1.0 }],
        };
        Sheet::new(theme, layout, room, caption)
    }

    fn draw(&self, sheet: &mut Sheet, choices: &Choices, unit: Unit) -> Result<(), PictureError> {
        match &self.content {
            Content::Drawing { combs, painting, .. } => {
                draw::draw(sheet, &self.stage, (combs, painting), choices, unit)
            }
            Content::Chart(chart) => {
                let area = sheet.layout.area;
                chart.draw(sheet, &self.stage, &area, unit);
                Ok(())
            }
        }
    }

    /// The caption below a panel, and its axes where the views of panels differ.
    fn caption(&self, theme: Theme, area: &Rect, with_axes: bool) -> String {
        let mut out = String::new();
        if let (true, Some(view)) = (with_axes, self.view()) {
            out.push_str(&legend::axes(theme, view, [area.low[0] + 3.0, area.high[1] + 7.5], 4.0));
        }
        let middle = (area.low[0] + area.high[0]) / 2.0;
        for (i, line) in self.lines(area.size()[0], with_axes).iter().enumerate() {
            let text = Element::new("text")
                .attribute("class", "caption")
                .length("x", middle)
                .length("y", area.high[1] + 4.8 + LEADING * i as f64)
                .length("font-size", SIZE)
                .attribute("text-anchor", "middle")
                .attribute("fill", &theme.ink().hex());
            out.push_str(&text.text(line));
        }
        out
    }

    /// The lines of the caption in a width, at most three; beside axes, which stand on its left, and about the middle all the same.
    fn lines(&self, width: f64, with_axes: bool) -> Vec<String> {
        let caption = self.panel.caption.as_deref().unwrap_or_default();
        let beside = with_axes && self.view().is_some();
        let room = if beside { (width - 2.0 * AXES).max(0.5 * width) } else { width };
        balanced(caption, room).iter().map(|line| text::fitting(line, SIZE, room)).collect()
    }
}

/// A text in as few lines as a width needs, these about equally long: no word stands alone below the others.
fn balanced(text: &str, width: f64) -> Vec<String> {
    let lines = wrapped(text, SIZE, width);
    (1..8)
        .map(|eighth| wrapped(text, SIZE, width * f64::from(eighth) / 8.0))
        .find(|narrow| narrow.len() == lines.len() && lines.len() < 3)
        .unwrap_or(lines)
}

/// The document around the drawing.
fn document(picture: &Picture<'_>, content: &str, height: f64) -> String {
    let (theme, width) = (picture.theme, picture.width);
    let paper = Element::new("rect")
        .attribute("class", "paper")
        .length("width", width)
        .length("height", height)
        .attribute("fill", &theme.paper().hex())
        .empty();
    let mut body = String::new();
    if let Some(title) = &picture.title {
        body.push_str(&Element::new("title").text(title));
    }
    body.push_str(&paper);
    body.push_str(content);
    if let Some(title) = &picture.title {
        let size = 4.2;
        let text = Element::new("text")
            .attribute("class", "title")
            .length("x", MARGIN)
            .length("y", MARGIN + 3.0)
            .length("font-size", size)
            .attribute("fill", &theme.ink().hex());
        body.push_str(&text.text(&text::fitting(title, size, width - 2.0 * MARGIN)));
    }
    let svg = Element::new("svg")
        .attribute("xmlns", "http://www.w3.org/2000/svg")
        .attribute("width", &format!("{}mm", length(width)))
        .attribute("height", &format!("{}mm", length(height)))
        .attribute("viewBox", &format!("0 0 {} {}", length(width), length(height)))
        .attribute("font-family", text::FAMILY)
        .attribute("stroke-linejoin", "round")
        .attribute("stroke-linecap", "round");
    format!("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n{}", svg.around(&body))
}
