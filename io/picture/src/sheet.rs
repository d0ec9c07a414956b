//! The page under construction: layers of elements, where ink is, what the legend and the notes say.

mod caption;

use std::collections::HashSet;

use loftsman_kernel::Vector;

use self::caption::Why;
pub(crate) use self::caption::{Caption, Fill, Sample};
use crate::depth::{Depth, IN_SURFACE, Run};
use crate::labels::{Ink, Label};
use crate::layout::{Layout, Rect};
use crate::path::{Path, Spot};
use crate::svg::Element;
use crate::theme::{Color, Theme};
use crate::traces::Traces;

/// What covers what: later ones are drawn over earlier ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Layer {
    /// Faces of surfaces and meshes.
    Faces,
    /// Axes and grid of a chart.
    Axes,
    /// The state before.
    Old,
    /// Frames of animations.
    Frames,
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
    /// A few loose points.
    Points,
    /// Marks.
    Marks,
}

impl Layer {
    /// All layers, from the bottom up, with the `id` of their groups.
    const ALL: [(Self, &'static str); 11] = [
        (Self::Faces, "faces"),
        (Self::Axes, "axes"),
        (Self::Old, "before"),
        (Self::Frames, "frames"),
        (Self::Combs, "combs"),
        (Self::Nets, "control-polygons"),
        (Self::Curves, "curves"),
        (Self::Clouds, "clouds"),
        (Self::Beads, "knots"),
        (Self::Points, "points"),
        (Self::Marks, "marks"),
    ];
}

/// A stroke.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stroke {
    pub(crate) color: Color,
    /// In millimetres.
    pub(crate) width: f64,
    /// Lengths of dashes and gaps, where it is dashed.
    pub(crate) dashes: Option<&'static str>,
}

impl Stroke {
    /// An unbroken stroke.
    pub(crate) fn plain(color: Color, width: f64) -> Self {
        Self { color, width, dashes: None }
    }

    /// The same stroke, dashed.
    pub(crate) fn dashed(self) -> Self {
        Self { dashes: Some("1.2 0.8"), ..self }
    }

    /// The element of a stroked path.
    pub(crate) fn path(self, class: &str, data: String) -> Element {
        let element = Element::new("path")
            .attribute("class", class)
            .attribute("d", &data)
            .attribute("fill", "none")
            .attribute("stroke", &self.color.hex())
            .length("stroke-width", self.width);
        match self.dashes {
            Some(dashes) => element.attribute("stroke-dasharray", dashes),
            None => element,
        }
    }
}

/// A panel of the page under construction.
#[derive(Debug)]
pub(crate) struct Sheet {
    pub(crate) theme: Theme,
    pub(crate) layout: Layout,
    /// Where lines are, so that labels can keep away from them.
    pub(crate) ink: Ink,
    layers: Vec<(Layer, String)>,
    /// The depth of the faces, where there are any.
    pub(crate) depth: Option<Depth>,
    /// Where the lines of solids are, so that those of the state before are not drawn over them.
    pub(crate) traces: Traces,
    /// Labels to be placed when everything else is drawn.
    pub(crate) labels: Vec<Label>,
    /// What the drawing is called, where there are several on the page.
    pub(crate) name: Option<String>,
    /// What the reader is caption about it.
    pub(crate) caption: Caption,
}

impl Sheet {
    /// An empty sheet, whose labels may stand anywhere in `room`; what is caption goes on after `caption`.
    pub(crate) fn new(theme: Theme, layout: Layout, room: Rect, caption: Caption) -> Self {
        Self {
            theme,
            layout,
            ink: Ink::new(room),
            layers: Vec::new(),
            depth: None,
            traces: Traces::default(),
            labels: Vec::new(),
            name: None,
            caption,
        }
    }

    /// Notes that `shown` of `all` things of an object (`"control vertices"`) are drawn where that leaves out more than a quarter of those
    /// that are at places of their own (`apart`): things that cover one another are hardly missed.
    pub(crate) fn note_thinned(
        &mut self,
        object: &str,
        (shown, apart): (usize, usize),
        (all, things): (usize, &'static str),
    ) {
        if shown * 4 < apart * 3 {
            let count = format!("{shown} of {all}");
            self.caption.thin(Why::Close(things), object, count, self.name.as_ref());
        }
    }

    /// Notes that so many parameters of an object are at places that are out of sight.
    pub(crate) fn note_behind(&mut self, object: &str, count: usize) {
        if count > 0 {
            self.caption.thin(Why::Behind, object, count.to_string(), self.name.as_ref());
        }
    }

    /// Puts a finished element on a layer.
    pub(crate) fn put(&mut self, layer: Layer, element: &str) {
        match self.layers.iter_mut().find(|(l, _)| *l == layer) {
            Some((_, content)) => content.push_str(element),
            None => self.layers.push((layer, element.to_owned())),
        }
    }

    /// A point of the stage on the page.
    pub(crate) fn spot(&self, p: &Vector) -> Spot {
        self.layout.spot(p)
    }

    /// The parts of a chain of the stage that are seen and that faces hide, in order; depths less than `slack` millimetres apart
    /// are the same.
    pub(crate) fn runs<'a>(&self, points: impl IntoIterator<Item = &'a Vector>, slack: f64) -> Vec<Run> {
        let places = points.into_iter().map(|p| self.layout.place(p));
        match &self.depth {
            Some(depth) => depth.runs(places, slack),
            None => vec![Run { seen: true, spots: places.map(|p| [p.x, p.y]).collect() }],
        }
    }

    /// Whether faces hide a point of the stage.
    pub(crate) fn hides(&self, p: &Vector) -> bool {
        self.depth.as_ref().is_some_and(|depth| depth.hides(&self.layout.place(p), IN_SURFACE))
    }

    /// A chain of the stage as paths, of what is seen of it and of what faces hide; it also leaves its ink.
    pub(crate) fn parted<'a>(
        &mut self,
        points: impl IntoIterator<Item = &'a Vector>,
        weight: u16,
    ) -> [String; 2] {
        let mut paths = [Path::default(), Path::default()];
        for run in self.runs(points, IN_SURFACE) {
            let path = &mut paths[usize::from(!run.seen)];
            for (i, &spot) in run.spots.iter().enumerate() {
                if i == 0 {
                    path.move_to(spot);
                } else {
                    path.line_to(spot);
                    self.ink.segment(run.spots[i - 1], spot, if run.seen { weight } else { 1 });
                }
            }
        }
        paths.map(Path::finish)
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

    /// Everything on all layers, each in a group, and the labels. The groups of a panel have ids that end with its
    /// `suffix`.
    pub(crate) fn content(&mut self, suffix: &str) -> String {
        let mut out = String::new();
        for (layer, id) in Layer::ALL {
            if let Some((_, content)) = self.layers.iter().find(|(l, _)| *l == layer) {
                out.push_str(&Element::new("g").attribute("id", &format!("{id}{suffix}")).around(content));
            }
        }
        let look = (self.theme, self.depth.is_some());
        let known = self.caption.apart.len();
        let found = crate::labels::place(&self.labels, &self.ink, look, &mut self.caption.apart);
        for (at, words) in self.caption.apart.iter().enumerate().skip(known) {
            self.caption.legend.push((Sample::Number(at + 1), words.clone()));
        }
        for (object, count) in found.left {
            self.caption.thin(Why::Unlabelled, &object, count.to_string(), self.name.as_ref());
        }
        if !found.drawn.is_empty() {
            let labels = Element::new("g").attribute("id", &format!("labels{suffix}"));
            out.push_str(&labels.around(&found.drawn));
        }
        out
    }
}

/// Places that are worth drawing: of those that share a square of side `gap` the first, and of what is left at
/// most `most`, evenly along the list.
pub(crate) fn spread(places: impl Iterator<Item = Spot>, gap: f64, most: usize) -> Vec<Spot> {
    // The casts saturate; what is that far off the page coincides.
    let square = |[x, y]: Spot| ((x / gap).floor() as i64, (y / gap).floor() as i64);
    let mut taken = HashSet::new();
    let kept: Vec<Spot> = places.filter(|&place| taken.insert(square(place))).collect();
    let step = kept.len().div_ceil(most).max(1);
    kept.into_iter().step_by(step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spread_places_are_apart_and_few() {
        let places = (0..100_000).map(|i| [f64::from(i) * 1e-3, 5.0]);
        assert_eq!(spread(places.clone(), 1.0, 1000).len(), 100);
        assert!(spread(places, 0.1, 300).len() <= 300);
        assert_eq!(spread([[-5.0, 1e300]].into_iter(), 1.0, 9).len(), 1);
    }
}
