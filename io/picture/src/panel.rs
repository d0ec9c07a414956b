//! The parts of a picture: drawings from several sides, and charts.

use crate::choices::Faces;
use crate::view::View;

/// What the curvature of a profile is drawn against.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Against {
    /// Arc length from the start of the curve. The default.
    #[default]
    ArcLength,
    /// The curve's own parameter.
    Parameter,
}

/// What a panel shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Shown {
    /// The scene from somewhere.
    Drawing(View),
    /// The curvature of its curves as a chart.
    Profile(Against),
}

/// One part of a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    pub(crate) shown: Shown,
    pub(crate) caption: Option<String>,
    pub(crate) objects: Option<Vec<String>>,
    /// The moment of its animations, in seconds.
    pub(crate) moment: Option<f64>,
    /// What the colours of faces show, where it is not what the picture says.
    pub(crate) faces: Option<Faces>,
}

impl Panel {
    /// A drawing of the scene. All parallel views of a picture have one scale.
    pub fn view(view: View) -> Self {
        Self { shown: Shown::Drawing(view), caption: None, objects: None, moment: None, faces: None }
    }

    /// A chart of the curvature of all curves, before and after. Where all curves are in one plane, curvature has a sign: positive to
    /// the left of the curve, as the automatic view of the scene shows it.
    pub fn profile(against: Against) -> Self {
        Self { shown: Shown::Profile(against), caption: None, objects: None, moment: None, faces: None }
    }

    /// Whether it shows how far things are from the state before.
    pub fn compares(&self) -> bool {
        self.faces == Some(Faces::Deviation)
    }

    /// Whether it is a drawing, and no chart.
    pub fn is_drawing(&self) -> bool {
        matches!(self.shown, Shown::Drawing(_))
    }

    /// Whether it shows the object of this name.
    pub fn shows(&self, name: &str) -> bool {
        self.objects.as_ref().is_none_or(|names| names.iter().any(|shown| shown == name))
    }

    /// Only these objects where none have been chosen: what a panel says itself goes first.
    #[must_use]
    pub fn or_objects<S: Into<String>>(self, names: impl IntoIterator<Item = S>) -> Self {
        if self.objects.is_some() { self } else { self.objects(names) }
    }

    /// The scene at a moment of its animations, in seconds, without marks and the state before. The drawing leaves room for all
    /// moments, so that pictures of several show each thing in one place and to one scale.
    #[must_use]
    pub fn at(self, seconds: f64) -> Self {
        Self { moment: Some(seconds), ..self }
    }

    /// What the colours of faces show here.
    #[must_use]
    pub fn faces(self, faces: Faces) -> Self {
        Self { faces: Some(faces), ..self }
    }

    /// A line of text below the panel.
    #[must_use]
    pub fn caption(mut self, caption: impl Into<String>) -> Self {
        self.caption = Some(caption.into()).filter(|caption| !caption.is_empty());
        self
    }

    /// The objects that it was told to show; `None` where it shows all.
    pub fn chosen(&self) -> Option<&[String]> {
        self.objects.as_deref()
    }

    /// Only these objects, with their states before and their marks.
    #[must_use]
    pub fn objects<S: Into<String>>(mut self, names: impl IntoIterator<Item = S>) -> Self {
        self.objects = Some(names.into_iter().map(Into::into).collect());
        self
    }
}
