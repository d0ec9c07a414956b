//! Why a picture could not be made.

use loftsman_kernel::error::Figure;

/// What is wrong with a scene or a request for a picture.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PictureError {
    /// The hierarchy of a scene is cyclic or names parents that do not exist.
    #[error(transparent)]
    Scene(#[from] loftsman_kernel::Error),
    /// An object or a mark is where no number goes: a transform overflows, or a mark is not finite.
    #[error(
        "\"{object}\" or a mark on it has a coordinate that is not finite in the scene: correct its transform"
    )]
    Place {
        /// The object.
        object: String,
    },
    /// A page or an image of a size that cannot be.
    #[error("a picture cannot be {} {unit} {what}: choose from {least} to {most}", Figure(*.value))]
    Size {
        /// `"wide"` or `"high"`.
        what: &'static str,
        /// `"mm"` or `"pixels"`.
        unit: &'static str,
        /// What was asked for.
        value: f64,
        /// The least possible.
        least: f64,
        /// The most possible.
        most: f64,
    },
    /// A comb scale or a viewing direction that is not a usable number.
    #[error("{what} {found} cannot be used: give {needed}")]
    Option {
        /// Which option.
        what: &'static str,
        /// What was given.
        found: String,
        /// What it should be.
        needed: &'static str,
    },
    /// A panel asks for an object that the scene does not have.
    #[error("the scene has no object \"{name}\"{}", near.as_ref().map(|n| format!("; did you mean \"{n}\"?")).unwrap_or_default())]
    Object {
        /// Its name.
        name: String,
        /// The name most like it.
        near: Option<String>,
    },
    /// A curvature profile of a panel without curves.
    #[error(
        "a curvature profile needs a curve, and there is none among {0}: choose other objects, or leave it out"
    )]
    NoCurve(String),
    /// A film of a scene in which nothing moves.
    #[error(
        "nothing in the scene is animated, so that there are no frames for a film: keep some (`drag` with `frames = true`)"
    )]
    Still,
    /// Faces that cover one another so often that to find out which is seen would take minutes.
    #[error(
        "the faces of this scene cover one another {0:.0} times over on the page: too much to tell what is seen; show fewer objects, or a smaller page"
    )]
    Covered(f64),
    /// The renderer refused the drawing.
    #[error("the picture could not be rendered: {0}")]
    Render(String),
}
