//! What a picture shows and how: the builder.

use loftsman_kernel::error::Figure;
use loftsman_kernel::plugin::{Mark, Tessellator};
use loftsman_kernel::scene::Scene;

use crate::choices::{Beads, Choices, Combs, Faces, Frames};
use crate::error::PictureError;
use crate::panel::Panel;
use crate::theme::Theme;
use crate::view::View;

/// The narrowest and widest page, in millimetres.
const WIDTHS: (f64, f64) = (40.0, 2000.0);

/// The most frames that a picture shows.
const MOST_FRAMES: usize = 100;

/// A picture of a scene.
///
/// Every method changes one thing and gives the picture back; [`to_svg`](Self::to_svg) and
/// [`to_png`](Self::to_png) make it. The same picture has the same bytes whenever it is made, whatever fonts the machine has.
#[derive(Clone)]
pub struct Picture<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) before: Option<&'a Scene>,
    pub(crate) marks: &'a [Mark],
    pub(crate) title: Option<String>,
    pub(crate) view: View,
    pub(crate) panels: Vec<Panel>,
    pub(crate) columns: Option<usize>,
    pub(crate) theme: Theme,
    pub(crate) choices: Choices,
    pub(crate) frames: Frames,
    pub(crate) legend: bool,
    pub(crate) width: f64,
    pub(crate) height: Option<f64>,
    pub(crate) tessellator: Option<&'a dyn Tessellator>,
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
            panels: Vec::new(),
            columns: None,
            theme: Theme::Light,
            choices: Choices {
                combs: Combs::Off,
                beads: Beads::Off,
                control_polygons: true,
                movements: false,
                alternate: false,
                labels: true,
                parameters: false,
                faces: Faces::Shaded,
                old: true,
            },
            frames: Frames::Off,
            legend: true,
            width: 180.0,
            height: None,
            tessellator: None,
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

    /// Who cuts Breps into triangles: without one they are not drawn, and the legend says so.
    #[must_use]
    pub fn tessellator(mut self, tessellator: &'a dyn Tessellator) -> Self {
        self.tessellator = Some(tessellator);
        self
    }

    /// A line of text above the drawing.
    #[must_use]
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = Some(title.into()).filter(|title| !title.is_empty());
        self
    }

    /// From where the scene is seen, where there are no panels.
    #[must_use]
    pub fn view(mut self, view: View) -> Self {
        self.view = view;
        self
    }

    /// Several drawings and charts on one page, row after row, instead of one drawing.
    #[must_use]
    pub fn panels(mut self, panels: impl IntoIterator<Item = Panel>) -> Self {
        self.panels = panels.into_iter().collect();
        self
    }

    /// How many panels a row has; otherwise that follows from their number and shape.
    #[must_use]
    pub fn columns(mut self, columns: usize) -> Self {
        self.columns = Some(columns);
        self
    }

    /// Whether frames of animations are drawn, and how; `true` is [`Frames::Dashed`].
    #[must_use]
    pub fn frames(mut self, how: impl Into<Frames>) -> Self {
        self.frames = how.into();
        self
    }

    /// Whether arrows lead from every control vertex before to where it is now.
    #[must_use]
    pub fn movements(mut self, on: bool) -> Self {
        self.choices.movements = on;
        self
    }

    /// Whether the segments of curves (from knot to knot) are dark and light in turn.
    #[must_use]
    pub fn alternate(mut self, on: bool) -> Self {
        self.choices.alternate = on;
        self
    }

    /// The colours.
    #[must_use]
    pub fn theme(mut self, theme: Theme) -> Self {
        self.theme = theme;
        self
    }

    /// Curvature combs on curves, and on some isoparametric lines of surfaces.
    #[must_use]
    pub fn combs(mut self, combs: Combs) -> Self {
        self.choices.combs = combs;
        self
    }

    /// Beads on curves.
    #[must_use]
    pub fn beads(mut self, beads: Beads) -> Self {
        self.choices.beads = beads;
        self
    }

    /// Whether control polygons and nets are drawn; they are unless caption otherwise.
    #[must_use]
    pub fn control_polygons(mut self, on: bool) -> Self {
        self.choices.control_polygons = on;
        self
    }

    /// Whether parameters are written beside curves, and on surfaces those of lines of equal `u` and `v`, and the numbers of vertices of meshes, polylines and
    /// cages (of 500 at most), where these are seen; they are not
    /// unless asked for. What has no room, or is out of sight, is counted in the legend.
    #[must_use]
    pub fn parameters(mut self, on: bool) -> Self {
        self.choices.parameters = on;
        self
    }

    /// What the colours of faces show, in all panels that do not say it themselves.
    #[must_use]
    pub fn faces(mut self, faces: Faces) -> Self {
        self.choices.faces = faces;
        self
    }

    /// Whether the state [before](Self::before) is drawn; it is unless it is there to be compared with alone
    /// ([`Faces::Deviation`]).
    #[must_use]
    pub fn draw_before(mut self, on: bool) -> Self {
        self.choices.old = on;
        self
    }

    /// Whether marks have labels; they have unless caption otherwise.
    #[must_use]
    pub fn labels(mut self, on: bool) -> Self {
        self.choices.labels = on;
        self
    }

    /// Whether there is a legend, with scale bar and axes; there is unless caption otherwise.
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

    pub(crate) fn check(&self) -> Result<(), PictureError> {
        let (least, most) = WIDTHS;
        if !(self.width >= least && self.width <= most) {
            return Err(PictureError::Size { what: "wide", unit: "mm", value: self.width, least, most });
        }
        if let Some(value) = self.height.filter(|h| !(*h >= 10.0 && *h <= most)) {
            return Err(PictureError::Size { what: "high", unit: "mm", value, least: 10.0, most });
        }
        if self.columns == Some(0) {
            return Err(PictureError::Option {
                what: "a number of columns of",
                found: "0".to_owned(),
                needed: "1 or more",
            });
        }
        if let Frames::Fading(count) | Frames::Film(count) = self.frames
            && !(1..=MOST_FRAMES).contains(&count)
        {
            return Err(PictureError::Option {
                what: "a number of frames of",
                found: count.to_string(),
                needed: "1 to 100",
            });
        }
        if let Combs::Scale(scale) = self.choices.combs
            && !(scale > 0.0 && scale.is_finite())
        {
            return Err(PictureError::Option {
                what: "a comb scale of",
                found: Figure(scale).to_string(),
                needed: "a positive finite number",
            });
        }
        Ok(())
    }
}
