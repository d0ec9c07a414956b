//! Pictures of a scene, and of what a recipe did to it: the crate `loftsman-picture`, how recipes and command lines
//! ask for them, and files for them.

mod fields;

use std::path::Path;

use loftsman_kernel::plugin::{Mark, ParameterError, Parameters, Registry, nearest};
use loftsman_kernel::scene::{Geometry, MOST_PLACED, Object, Scene};
pub use loftsman_picture::*;
use serde_json::Value;

use self::fields::PANEL;
pub use self::fields::{AGAINST, FACE_WORDS, FIELDS, VIEWS};
use crate::error::{Error, Result};
pub use crate::picture_name::is_picture;
use crate::picture_name::is_png;

/// How wide a PNG is unless told otherwise, in pixels.
pub const PIXELS: u32 = 1600;

/// How a picture is to look, before there is a scene.
#[derive(Debug, Clone, PartialEq)]
#[allow(clippy::struct_excessive_bools, reason = "each is a switch of its own, named as users name it")]
pub struct Look {
    /// A line above the picture.
    pub title: Option<String>,
    /// From where the scene is seen, where there are no panels.
    pub view: View,
    /// What is shown, in every panel that does not say itself; everything if `None`.
    pub objects: Option<Vec<String>>,
    /// The parts of the picture; none for a single drawing.
    pub panels: Vec<Panel>,
    /// Panels in a row.
    pub columns: Option<usize>,
    /// Whether the state before is shown.
    pub before: bool,
    /// Whether the points are shown that something was fitted to.
    pub points: bool,
    /// Whether and how frames of animations are shown.
    pub frames: Frames,
    /// The moment of its animations that is shown, in seconds; as objects are if `None`.
    pub moment: Option<f64>,
    /// Curvature combs.
    pub combs: Combs,
    /// Beads on curves.
    pub beads: Beads,
    /// Control polygons and nets.
    pub polygons: bool,
    /// Arrows from control vertices before to where they are.
    pub movements: bool,
    /// Segments dark and light in turn.
    pub segments: bool,
    /// What the colours of faces show.
    pub faces: Faces,
    /// Labels of marks.
    pub labels: bool,
    /// Parameters beside curves, and those of lines of equal `u` and `v` on surfaces.
    pub parameters: bool,
    /// Marks of what was asked.
    pub marks: bool,
    /// The legend.
    pub legend: bool,
    /// Light on dark.
    pub dark: bool,
    /// The width of the page, in millimetres.
    pub width: Option<f64>,
    /// The greatest height of a drawing, in millimetres.
    pub height: Option<f64>,
    /// The width of a PNG.
    pub pixels: u32,
}

impl Default for Look {
    /// One drawing with control polygons, marks, labels and the state before.
    fn default() -> Self {
        Self {
            title: None,
            view: View::Automatic,
            objects: None,
            panels: Vec::new(),
            columns: None,
            before: true,
            points: true,
            frames: Frames::Off,
            moment: None,
            combs: Combs::Off,
            beads: Beads::Off,
            polygons: true,
            movements: false,
            segments: false,
            faces: Faces::Shaded,
            labels: true,
            parameters: false,
            marks: true,
            legend: true,
            dark: false,
            width: None,
            height: None,
            pixels: PIXELS,
        }
    }
}

impl Look {
    /// The look that a table with [`FIELDS`] describes.
    ///
    /// # Errors
    /// When a field is unknown or wrong.
    pub fn from_parameters(fields: &Parameters) -> std::result::Result<Self, ParameterError> {
        fields.check(FIELDS)?;
        let usual = Self::default();
        let flag = |name: &str, usual: bool| if fields.has(name) { fields.flag(name) } else { Ok(usual) };
        let number = |name: &str| if fields.has(name) { fields.number(name).map(Some) } else { Ok(None) };
        let panels = fields.tables("panel")?.iter().map(panel).collect::<std::result::Result<_, _>>()?;
        let combs = match fields.value("combs") {
            Some(Value::Number(_)) => Combs::Scale(fields.number("combs")?),
            _ if fields.flag("combs")? => Combs::Automatic,
            _ => Combs::Off,
        };
        let beads = match fields.value("knots") {
            Some(Value::Number(_)) => Beads::Uniform(fields.count("knots")?),
            _ if fields.flag("knots")? => Beads::Knots,
            _ => Beads::Off,
        };
        let frames = match fields.value("frames") {
            Some(Value::Number(_)) => Frames::Fading(fields.count("frames")?),
            _ => Frames::from(fields.flag("frames")?),
        };
        let frames = match fields.has("film") {
            true if frames != Frames::Off => {
                return Err(
                    fields.error("film", "frames are side by side or in one drawing: leave `frames` out")
                );
            }
            true => Frames::Film(fields.count("film")?),
            false => frames,
        };
        let pixels = fields.count_or("pixels", PIXELS as usize)?;
        Ok(Self {
            title: if fields.has("title") { Some(fields.text("title")?.to_owned()) } else { None },
            view: view(fields)?,
            objects: objects(fields)?,
            panels,
            columns: if fields.has("columns") { Some(fields.count("columns")?) } else { None },
            before: flag("before", usual.before)?,
            points: flag("points", usual.points)?,
            frames,
            moment: None,
            combs,
            beads,
            polygons: flag("polygons", usual.polygons)?,
            movements: flag("movements", usual.movements)?,
            segments: flag("segments", usual.segments)?,
            faces: faces(fields)?.unwrap_or_default(),
            labels: flag("labels", usual.labels)?,
            parameters: flag("parameters", usual.parameters)?,
            marks: flag("marks", usual.marks)?,
            legend: flag("legend", usual.legend)?,
            dark: flag("dark", usual.dark)?,
            width: number("width")?,
            height: number("height")?,
            // What does not fit is too many pixels, and the renderer says so.
            pixels: u32::try_from(pixels).unwrap_or(u32::MAX),
        })
    }

    /// The same at a moment of the scene's animations, in seconds.
    #[must_use]
    pub fn at(self, seconds: f64) -> Self {
        Self { moment: Some(seconds), ..self }
    }

    /// What is not drawn: objects on hidden layers, and what was asked for of some objects that are shown, since beads and
    /// alternating segments are of curves only, and combs of curves and surfaces.
    pub fn unmet(&self, scene: &Scene) -> Vec<String> {
        let panels = self.spelt(scene).shown();
        let shown = |name: &str| panels.iter().any(|panel| panel.is_drawing() && panel.shows(name));
        let hidden = scene.hidden_layers();
        let without = |of_surfaces: bool| -> Option<String> {
            let has = |geometry: &Geometry| match geometry {
                Geometry::Curve(_) | Geometry::Group | Geometry::Instance(_) => true,
                Geometry::Surface(_) | Geometry::Trimmed(_) => of_surfaces,
                _ => false,
            };
            let others = scene.objects().iter();
            let others = others.filter(|o| !has(o.geometry()) && shown(o.name()) && !hidden.hides(o));
            let others: Vec<String> =
                others.map(|o| format!("\"{}\" ({})", o.name(), o.geometry().kind())).collect();
            let (few, more) = others.split_at(others.len().min(5));
            let more = if more.is_empty() { String::new() } else { format!(" and {} more", more.len()) };
            (!few.is_empty()).then(|| format!("{}{more}", few.join(", ")))
        };
        let asked = [
            (self.combs != Combs::Off, "curvature combs are of curves and surfaces", true),
            (self.beads != Beads::Off, "beads at knots are of curves", false),
            (self.segments, "alternating segments are of curves", false),
        ];
        let asked = asked.iter().filter(|(asked, ..)| *asked);
        let asked =
            asked.filter_map(|(_, what, surfaces)| Some(format!("{what}: none for {}", without(*surfaces)?)));
        let count = scene.hidden_count();
        let unseen = (count > 0).then(|| match count {
            1 => "one object is on a hidden layer: it is not drawn".to_owned(),
            _ => format!("{count} objects are on hidden layers: they are not drawn"),
        });
        asked.chain(unseen).collect()
    }

    /// The picture of a scene with this look.
    pub fn picture<'a>(&self, scene: &'a Scene, before: Option<&'a Scene>, marks: &'a [Mark]) -> Picture<'a> {
        let mut picture = Picture::of(scene)
            .view(self.view)
            .frames(self.frames)
            .combs(self.combs)
            .beads(self.beads)
            .control_polygons(self.polygons)
            .movements(self.movements)
            .alternate(self.segments)
            .faces(self.faces)
            .draw_before(self.before)
            .labels(self.labels)
            .parameters(self.parameters)
            .legend(self.legend)
            .theme(if self.dark { Theme::Dark } else { Theme::Light });
        // What is compared with is needed whether it is drawn or not.
        let compared = self.faces == Faces::Deviation || self.panels.iter().any(Panel::compares);
        if let (true, Some(before)) = (self.before || compared, before) {
            picture = picture.before(before);
        }
        if self.marks {
            picture = picture.marks(marks);
        }
        if let Some(title) = &self.title {
            picture = picture.title(title);
        }
        if let Some(width) = self.width {
            picture = picture.width(width);
        }
        if let Some(height) = self.height {
            picture = picture.height(height);
        }
        if let Some(columns) = self.columns {
            picture = picture.columns(columns);
        }
        picture.panels(self.shown())
    }

    /// The first object that is to be shown and that a scene has not: its place in a recipe, and what is wrong.
    pub(crate) fn absent(&self, scene: &Scene) -> Option<(String, String)> {
        let of_panels = self.panels.iter().map(Panel::chosen).zip(0..);
        let chosen = of_panels.map(|(names, panel)| (names, format!("picture.panel[{panel}]")));
        let chosen = std::iter::once((self.objects.as_deref(), "picture".to_owned())).chain(chosen);
        let begins = |name: &str, scene: &Scene| {
            let stem = name.strip_suffix('*');
            stem.is_some_and(|stem| scene.objects().iter().any(|o| o.name().starts_with(stem)))
        };
        let named = chosen.flat_map(|(names, whose)| {
            let each = names.unwrap_or_default().iter().zip(0..);
            each.map(move |(name, at)| (name, format!("{whose}.objects[{at}]")))
        });
        // What instances show has names of its own, which are looked for last.
        let unknown: Vec<_> =
            named.filter(|(name, _)| scene.get(name).is_none() && !begins(name, scene)).collect();
        if unknown.is_empty() {
            return None;
        }
        let flat = scene.flattened(MOST_PLACED).ok()?;
        let (name, place) =
            unknown.into_iter().find(|(name, _)| flat.get(name).is_none() && !begins(name, &flat))?;
        let near = nearest(name, flat.objects().iter().map(Object::name)).map(str::to_owned);
        Some((place, PictureError::Object { name: name.clone(), near }.to_string()))
    }

    /// The same with every name that ends in `*`, and that no object has, replaced by those of all objects that begin so, in the order of the scene, what
    /// instances show among them: what a step adds is called `frames`, `frames.001`, … One with which none begins stays.
    pub(crate) fn spelt(&self, scene: &Scene) -> Self {
        let lists = || self.panels.iter().filter_map(Panel::chosen).chain(self.objects.as_deref());
        if !lists().flatten().any(|name| name.ends_with('*')) {
            return self.clone();
        }
        let Ok(flat) = scene.flattened(MOST_PLACED) else { return self.clone() };
        let spelt = |names: &[String]| -> Vec<String> {
            let mut all: Vec<String> = Vec::with_capacity(names.len());
            for name in names {
                let stem = name.strip_suffix('*').filter(|_| flat.get(name).is_none());
                let found = flat.objects().iter().map(Object::name);
                let found = found.filter(|own| stem.is_some_and(|stem| own.starts_with(stem)));
                let before = all.len();
                all.extend(found.map(str::to_owned));
                if all.len() == before {
                    all.push(name.clone());
                }
            }
            all
        };
        let panel = |panel: &Panel| match panel.chosen() {
            Some(names) => panel.clone().objects(spelt(names)),
            None => panel.clone(),
        };
        Self {
            objects: self.objects.as_deref().map(spelt),
            panels: self.panels.iter().map(panel).collect(),
            ..self.clone()
        }
    }

    /// The parts of the picture, each with the objects that it shows: one where none are given.
    fn shown(&self) -> Vec<Panel> {
        let panels = if self.panels.is_empty() { vec![Panel::view(self.view)] } else { self.panels.clone() };
        let of = |panel: Panel| match &self.objects {
            Some(names) => panel.or_objects(names.iter().cloned()),
            None => panel,
        };
        let at = |panel: Panel| match self.moment {
            Some(moment) => panel.at(moment),
            None => panel,
        };
        panels.into_iter().map(|panel| at(of(panel))).collect()
    }
}

fn panel(fields: &Parameters) -> std::result::Result<Panel, ParameterError> {
    fields.check(PANEL)?;
    let mut panel = if fields.has("profile") {
        if fields.has("view") {
            return Err(fields.error("view", "a profile is not seen from anywhere: leave one of both out"));
        }
        Panel::profile(fields.choice("profile", &AGAINST)?)
    } else {
        Panel::view(view(fields)?)
    };
    if fields.has("caption") {
        panel = panel.caption(fields.text("caption")?);
    }
    if let Some(faces) = faces(fields)? {
        if !panel.is_drawing() {
            return Err(fields.error("faces", "a profile has no faces: leave one of both out"));
        }
        panel = panel.faces(faces);
    }
    Ok(match objects(fields)? {
        Some(names) => panel.objects(names),
        None => panel,
    })
}

fn faces(fields: &Parameters) -> std::result::Result<Option<Faces>, ParameterError> {
    fields.has("faces").then(|| fields.choice("faces", &FACE_WORDS)).transpose()
}

fn view(fields: &Parameters) -> std::result::Result<View, ParameterError> {
    match fields.value("view") {
        None => Ok(View::Automatic),
        Some(Value::Array(_)) => fields.vector("view").map(View::From),
        Some(_) => fields.choice("view", &VIEWS),
    }
}

fn objects(fields: &Parameters) -> std::result::Result<Option<Vec<String>>, ParameterError> {
    if !fields.has("objects") {
        return Ok(None);
    }
    let names = fields.list("objects")?.iter().enumerate().map(|(i, name)| {
        let text = name.as_str().map(str::to_owned);
        text.ok_or_else(|| fields.error(&format!("objects[{i}]"), "the name of an object is needed here"))
    });
    names.collect::<std::result::Result<_, _>>().map(Some)
}

/// Whether a picture can be written to a file of this name: always, with the feature `picture`.
///
/// # Errors
/// Without the feature.
pub fn check(_: &Path) -> Result<()> {
    Ok(())
}

/// The bytes of the picture of a scene with this look, for a file of this name, and what of it could not be drawn. Breps are cut by the
/// registry's tessellator.
///
/// # Errors
/// As for [`encode`].
pub fn draw(
    path: &Path,
    look: &Look,
    scene: &Scene,
    before: Option<&Scene>,
    marks: &[Mark],
    registry: &Registry,
) -> Result<(Vec<u8>, Vec<String>)> {
    let mut picture = look.spelt(scene).picture(scene, before, marks);
    if let Some(tessellator) = registry.tessellator() {
        picture = picture.tessellator(tessellator);
    }
    encode(path, &picture, look.pixels)
}

/// The bytes of a picture for a file of this name: PNG of `pixels` across where it ends so, else SVG; and what of it could not
/// be drawn.
///
/// # Errors
/// When the scene cannot be drawn: its hierarchy is cyclic, or the picture has no reasonable size.
pub fn encode(path: &Path, picture: &Picture<'_>, pixels: u32) -> Result<(Vec<u8>, Vec<String>)> {
    let made = if is_png(path) {
        picture.to_png_noted(pixels)
    } else {
        picture.to_svg().map(|svg| (svg.into_bytes(), Vec::new()))
    };
    made.map_err(|e| Error::file(path.display().to_string(), e.to_string()))
}

#[cfg(test)]
mod tests;
