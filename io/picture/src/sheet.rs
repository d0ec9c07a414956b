//! The page under construction: layers of elements, where ink is, what the legend and the notes say.

use loftsman_kernel::Vector;

use crate::labels::{Ink, Label};
use crate::layout::{Layout, Rect};
use crate::path::{Path, Spot};
use crate::svg::Element;
use crate::theme::{Color, Theme};

/// What covers what: later ones are drawn over earlier ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Layer {
    /// Faces of surfaces and meshes.
    Faces,
    /// The state before.
    Old,
    /// Curvature combs.
    Combs,
    /// Control polygons and nets.
    Nets,
    /// Curves and polylines.
    Curves,
    /// Loose points.
    Clouds,
    /// Knots.
    Beads,
    /// Marks.
    Marks,
}

impl Layer {
    /// All layers, from the bottom up, with the `id` of their groups.
    const ALL: [(Self, &'static str); 8] = [
        (Self::Faces, "faces"),
        (Self::Old, "before"),
        (Self::Combs, "combs"),
        (Self::Nets, "control-polygons"),
        (Self::Curves, "curves"),
        (Self::Clouds, "clouds"),
        (Self::Beads, "knots"),
        (Self::Marks, "marks"),
    ];
}

/// A stroke.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stroke {
    pub(crate) color: Color,
    /// In millimetres.
    pub(crate) width: f64,
    /// Whether it is dashed.
    pub(crate) dashed: bool,
}

impl Stroke {
    /// An unbroken stroke.
    pub(crate) fn plain(color: Color, width: f64) -> Self {
        Self { color, width, dashed: false }
    }

    /// The same stroke, dashed.
    pub(crate) fn dashed(self) -> Self {
        Self { dashed: true, ..self }
    }

    /// The element of a stroked path.
    pub(crate) fn path(self, class: &str, data: String) -> Element {
        let element = Element::new("path")
            .attribute("class", class)
            .attribute("d", &data)
            .attribute("fill", "none")
            .attribute("stroke", &self.color.hex())
            .length("stroke-width", self.width);
        if self.dashed { element.attribute("stroke-dasharray", "1.2 0.8") } else { element }
    }
}

/// What an entry of the legend shows beside its words.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Sample {
    /// A line.
    Line(Stroke),
    /// A line with squares at its ends.
    Net(Stroke),
    /// A few teeth of a comb.
    Comb(Color),
    /// A bead.
    Bead(Color),
    /// A dot of a cloud.
    Dot(Color),
    /// A piece of a face.
    Face(Color),
    /// A mark's glyph.
    Mark(loftsman_kernel::plugin::MarkKind),
}

/// The page under construction.
#[derive(Debug)]
pub(crate) struct Sheet {
    pub(crate) theme: Theme,
    pub(crate) layout: Layout,
    /// Where lines are, so that labels can keep away from them.
    pub(crate) ink: Ink,
    layers: Vec<(Layer, String)>,
    /// Sample and words of each entry of the legend, in the order in which they came up.
    pub(crate) legend: Vec<(Sample, String)>,
    /// Labels to be placed when everything else is drawn.
    pub(crate) labels: Vec<Label>,
    /// What was left out, for the reader to know.
    pub(crate) notes: Vec<String>,
}

impl Sheet {
    /// An empty sheet.
    pub(crate) fn new(theme: Theme, layout: Layout) -> Self {
        let ink = Ink::new(layout.area.grown(6.0));
        Self {
            theme,
            layout,
            ink,
            layers: Vec::new(),
            legend: Vec::new(),
            labels: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// Puts a finished element on a layer.
    pub(crate) fn put(&mut self, layer: Layer, element: &str) {
        match self.layers.iter_mut().find(|(l, _)| *l == layer) {
            Some((_, content)) => content.push_str(element),
            None => self.layers.push((layer, element.to_owned())),
        }
    }

    /// Adds an entry to the legend unless it is there.
    pub(crate) fn explain(&mut self, sample: Sample, words: impl Into<String>) {
        let words = words.into();
        if !self.legend.iter().any(|(s, w)| *s == sample && *w == words) {
            self.legend.push((sample, words));
        }
    }

    /// A point of the stage on the page.
    pub(crate) fn spot(&self, p: &Vector) -> Spot {
        self.layout.spot(p)
    }

    /// The path through points of the stage, which also leaves its ink.
    pub(crate) fn chain<'a>(
        &mut self,
        points: impl IntoIterator<Item = &'a Vector>,
        closed: bool,
        weight: u16,
    ) -> Path {
        let mut path = Path::default();
        let (mut first, mut last) = (None, None);
        for p in points {
            let spot = self.layout.spot(p);
            if let Some(from) = last {
                self.ink.segment(from, spot, weight);
            }
            first.get_or_insert(spot);
            last = Some(spot);
            path.line_to(spot);
        }
        if let (true, Some(from), Some(to)) = (closed, last, first) {
            self.ink.segment(from, to, weight);
            path.close();
        }
        path
    }

    /// Everything on all layers, each in a group.
    pub(crate) fn content(&self) -> String {
        let mut out = String::new();
        for (layer, id) in Layer::ALL {
            if let Some((_, content)) = self.layers.iter().find(|(l, _)| *l == layer) {
                out.push_str(&Element::new("g").attribute("id", id).around(content));
            }
        }
        out
    }
}

/// Dots at these places as one path: round line caps do the rest. `gap` keeps dots that would cover one another
/// from being drawn twice; at most `most` are drawn. Gives the places that were kept.
pub(crate) fn spread(places: impl Iterator<Item = Spot>, area: &Rect, gap: f64, most: usize) -> Vec<Spot> {
    let [width, height] = area.size();
    let (columns, rows) = ((width / gap).ceil() as usize + 1, (height / gap).ceil() as usize + 1);
    let mut taken = vec![false; columns * rows];
    let mut kept: Vec<Spot> = places
        .filter(|[x, y]| {
            // The cast saturates, so that what is beyond the area counts to its border.
            let column = (((x - area.low[0]) / gap) as usize).min(columns - 1);
            let row = (((y - area.low[1]) / gap) as usize).min(rows - 1);
            !std::mem::replace(&mut taken[row * columns + column], true)
        })
        .collect();
    if kept.len() > most {
        let step = kept.len().div_ceil(most);
        kept = kept.into_iter().step_by(step).collect();
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spread_places_are_apart_and_few() {
        let area = Rect { low: [0.0, 0.0], high: [100.0, 10.0] };
        let places = (0..100_000).map(|i| [f64::from(i) * 1e-3, 5.0]);
        assert_eq!(spread(places.clone(), &area, 1.0, 1000).len(), 100);
        assert!(spread(places, &area, 0.1, 300).len() <= 300);
        assert_eq!(spread([[-5.0, 1e9]].into_iter(), &area, 1.0, 9).len(), 1);
    }
}
