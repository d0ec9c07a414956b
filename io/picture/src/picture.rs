//! What a picture shows and how: the builder, and the order in which things are drawn.

use loftsman_kernel::plugin::Mark;
use loftsman_kernel::scene::Scene;

use crate::draw;
use crate::error::PictureError;
use crate::layout::Layout;
use crate::png;
use crate::sheet::Sheet;
use crate::stage::Stage;
use crate::svg::{Element, length};
use crate::text;
use crate::theme::Theme;
use crate::view::View;

/// The border of the page, in millimetres.
const MARGIN: f64 = 9.0;

/// The narrowest and widest page, in millimetres.
const WIDTHS: (f64, f64) = (40.0, 2000.0);

/// Whether curvature combs are drawn, and how long their teeth are.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Combs {
    /// No combs. The default.
    #[default]
    Off,
    /// Combs whose usual tooth is about a twelfth of the scene. A few teeth of much more curvature than the rest
    /// (the nose of an aerofoil) are cut, and the legend says so.
    Automatic,
    /// A tooth is this times the curvature long; its unit is the scene's unit of length, squared.
    Scale(f64),
}

/// Whether beads are drawn on curves, and where.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Beads {
    /// No beads. The default.
    #[default]
    Off,
    /// A bead at every knot within the domain.
    Knots,
    /// This many beads a knot span, uniform in the parameter: where they crowd, the curve runs slowly
    /// (Bartels and Beatty 1989, §5).
    Uniform(usize),
}

/// A picture of a scene.
///
/// Every method changes one thing and gives the picture back; [`to_svg`](Self::to_svg) and
/// [`to_png`](Self::to_png) make it. The same picture has the same bytes whenever it is made, whatever fonts the machine has.
#[derive(Debug, Clone)]
pub struct Picture<'a> {
    scene: &'a Scene,
    before: Option<&'a Scene>,
    marks: &'a [Mark],
    title: Option<String>,
    view: View,
    theme: Theme,
    combs: Combs,
    beads: Beads,
    control_polygons: bool,
    labels: bool,
    legend: bool,
    width: f64,
    height: Option<f64>,
}

/// What the modules of `draw` need to know of a picture.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Choices {
    pub(crate) combs: Combs,
    pub(crate) beads: Beads,
    pub(crate) control_polygons: bool,
    pub(crate) labels: bool,
}

impl<'a> Picture<'a> {
    /// A picture of a scene: its objects and their control polygons, a legend and a scale bar, 180 mm wide.
    pub fn of(scene: &'a Scene) -> Self {
        Self {
            scene,
            before: None,
            marks: &[],
            title: None,
            view: View::Automatic,
            theme: Theme::Light,
            combs: Combs::Off,
            beads: Beads::Off,
            control_polygons: true,
            labels: true,
            legend: true,
            width: 180.0,
            height: None,
        }
    }

    /// The scene as it was before: what differs is drawn lighter, under the new.
    #[must_use]
    pub fn before(mut self, scene: &'a Scene) -> Self {
        self.before = Some(scene);
        self
    }

    /// What was asked of the objects: points moved and kept, directions, curvatures, locked vertices.
    #[must_use]
    pub fn marks(mut self, marks: &'a [Mark]) -> Self {
        self.marks = marks;
        self
    }

    /// A line of text above the drawing.
    #[must_use]
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = Some(title.into()).filter(|title| !title.is_empty());
        self
    }

    /// From where the scene is seen.
    #[must_use]
    pub fn view(mut self, view: View) -> Self {
        self.view = view;
        self
    }

    /// The colours.
    #[must_use]
    pub fn theme(mut self, theme: Theme) -> Self {
        self.theme = theme;
        self
    }

    /// Curvature combs on curves.
    #[must_use]
    pub fn combs(mut self, combs: Combs) -> Self {
        self.combs = combs;
        self
    }

    /// Beads on curves.
    #[must_use]
    pub fn beads(mut self, beads: Beads) -> Self {
        self.beads = beads;
        self
    }

    /// Whether control polygons and nets are drawn; they are unless told otherwise.
    #[must_use]
    pub fn control_polygons(mut self, on: bool) -> Self {
        self.control_polygons = on;
        self
    }

    /// Whether marks have labels; they have unless told otherwise.
    #[must_use]
    pub fn labels(mut self, on: bool) -> Self {
        self.labels = on;
        self
    }

    /// Whether there is a legend, with scale bar and axes; there is unless told otherwise.
    #[must_use]
    pub fn legend(mut self, on: bool) -> Self {
        self.legend = on;
        self
    }

    /// The width of the page in millimetres, 40 to 2000; texts and lines keep their size. 180 at first.
    #[must_use]
    pub fn width(mut self, millimetres: f64) -> Self {
        self.width = millimetres;
        self
    }

    /// The greatest height of the drawing in millimetres (title and legend come on top), 10 to 2000. Two
    /// thirds of the width or so at first.
    #[must_use]
    pub fn height(mut self, millimetres: f64) -> Self {
        self.height = Some(millimetres);
        self
    }

    /// The picture as an SVG document.
    ///
    /// Linear in the size of the scene; the document stays within what can be seen: chains are thinned out where
    /// the eye could not tell, and what is left out is noted under the legend.
    ///
    /// # Errors
    /// When the hierarchy is cyclic, a transform overflows, or an option is out of its range.
    pub fn to_svg(&self) -> Result<String, PictureError> {
        self.check()?;
        let (unit, up) = (self.scene.unit, self.scene.up);
        let before = self.before.map(|scene| scene.converted(unit, up)).transpose()?;
        let stage = Stage::new(self.scene, before.as_deref(), self.marks, self.view)?;
        let choices = Choices {
            combs: self.combs,
            beads: self.beads,
            control_polygons: self.control_polygons,
            labels: self.labels,
        };
        let combs = draw::comb::Combing::of(&stage, &choices);
        let bounds = draw::bounds(&stage, &combs, &choices);
        let top = if self.title.is_some() { MARGIN + 7.0 } else { MARGIN };
        let highest = self.height.unwrap_or(0.65 * self.width);
        let layout = Layout::fit(&bounds, self.width, MARGIN, top, highest);
        let mut sheet = Sheet::new(self.theme, layout);
        draw::draw(&mut sheet, &stage, &combs, &choices, unit);
        let mut content = sheet.content();
        let labels = crate::labels::place(&sheet.labels, &sheet.ink, self.theme);
        content.push_str(&Element::new("g").attribute("id", "labels").around(&labels));
        let mut bottom = layout.area.high[1] + MARGIN;
        if self.legend {
            let (legend, end) = draw::legend::draw(&sheet, &stage, self.width, MARGIN, unit);
            content.push_str(&legend);
            bottom = end + 0.6 * MARGIN;
        }
        Ok(self.document(&content, bottom))
    }

    /// The picture as a PNG image of this many pixels across (1 to 16384).
    ///
    /// # Errors
    /// As for [`to_svg`](Self::to_svg), and when the image would be too large.
    pub fn to_png(&self, width: u32) -> Result<Vec<u8>, PictureError> {
        png::render(&self.to_svg()?, width)
    }

    fn check(&self) -> Result<(), PictureError> {
        let (least, most) = WIDTHS;
        if !(self.width >= least && self.width <= most) {
            return Err(PictureError::Size { what: "wide", unit: "mm", value: self.width, least, most });
        }
        if let Some(value) = self.height.filter(|h| !(*h >= 10.0 && *h <= most)) {
            return Err(PictureError::Size { what: "high", unit: "mm", value, least: 10.0, most });
        }
        if let Combs::Scale(scale) = self.combs
            && !(scale > 0.0 && scale.is_finite())
        {
            return Err(PictureError::Option {
                what: "a comb scale of",
                found: scale.to_string(),
                needed: "a positive finite number",
            });
        }
        Ok(())
    }

    /// The document around the drawing.
    fn document(&self, content: &str, height: f64) -> String {
        let paper = Element::new("rect")
            .attribute("class", "paper")
            .length("width", self.width)
            .length("height", height)
            .attribute("fill", &self.theme.paper().hex())
            .empty();
        let mut body = String::new();
        if let Some(title) = &self.title {
            body.push_str(&Element::new("title").text(title));
        }
        body.push_str(&paper);
        body.push_str(content);
        if let Some(title) = &self.title {
            let size = 4.2;
            // A line of the width that there is, shorter by whole characters where it must be.
            let room = self.width - 2.0 * MARGIN;
            let fits = (room / (text::width(title).max(1e-9) * size) * title.chars().count() as f64) as usize;
            let text = Element::new("text")
                .attribute("class", "title")
                .length("x", MARGIN)
                .length("y", MARGIN + 3.0)
                .length("font-size", size)
                .attribute("fill", &self.theme.ink().hex());
            body.push_str(&text.text(&text::clipped(title, fits.max(4))));
        }
        let svg = Element::new("svg")
            .attribute("xmlns", "http://www.w3.org/2000/svg")
            .attribute("width", &format!("{}mm", length(self.width)))
            .attribute("height", &format!("{}mm", length(height)))
            .attribute("viewBox", &format!("0 0 {} {}", length(self.width), length(height)))
            .attribute("font-family", text::FAMILY)
            .attribute("stroke-linejoin", "round")
            .attribute("stroke-linecap", "round");
        format!("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n{}", svg.around(&body))
    }
}
