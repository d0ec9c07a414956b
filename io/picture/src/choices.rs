//! What is drawn of each object.

pub use loftsman_kernel::spline::curvature::CurvatureMeasure as Curvature;

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

/// Whether frames of animations are drawn, and how.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Frames {
    /// None: what moves is drawn as it is. The default.
    #[default]
    Off,
    /// In the drawing, dashed: a drag on its way. Of many, six evenly spread.
    Dashed,
    /// In the drawing, so many evenly spread, the fainter the earlier: an onion skin.
    Fading(usize),
    /// Side by side, so many evenly spread from the first to the last: a film strip. Each view has a drawing for each, all to one
    /// scale and with nothing of the state before.
    Film(usize),
}

impl From<bool> for Frames {
    /// Dashed, or off.
    fn from(on: bool) -> Self {
        if on { Self::Dashed } else { Self::Off }
    }
}

/// What the colours of faces show.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Faces {
    /// Objects in their own colours, lit. The default.
    #[default]
    Shaded,
    /// Stripes that a striped world would be mirrored in: where surfaces meet, stripes that break show a gap, those with kinks show a
    /// jump of curvature (G¹ only), smooth ones G².
    Zebra,
    /// The curvature of surfaces, splines and plug-ins' alike: blue where it is negative, vermilion where it is positive.
    Curvature(Curvature),
    /// The distance from the state before, to its nearest point; blue on the side away from its normal. Of meshes how far each point
    /// has moved.
    Deviation,
}

/// What the modules of `draw` need to know of a picture.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Choices {
    pub(crate) combs: Combs,
    pub(crate) beads: Beads,
    pub(crate) control_polygons: bool,
    pub(crate) movements: bool,
    pub(crate) alternate: bool,
    pub(crate) labels: bool,
    pub(crate) parameters: bool,
    pub(crate) faces: Faces,
    /// Whether the state before is drawn; it may be there to compare with alone.
    pub(crate) old: bool,
}
