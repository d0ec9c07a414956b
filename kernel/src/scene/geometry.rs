//! What objects are.

use std::borrow::Cow;

use crate::Point;
use crate::brep::Brep;
use crate::error::{Error, Result};
use crate::kind::{CustomShape, DeclaredShape, Drawn};
use crate::mesh::{Cloud, Mesh, Polyline};
use crate::shape::Shape;
use crate::spline::{Curve, Surface, Trimmed};

/// What an object is.
#[non_exhaustive]
#[allow(
    clippy::large_enum_variant,
    reason = "objects that are alike share theirs: a few hundred bytes each buy plain matching"
)]
#[derive(Debug, Clone, PartialEq)]
pub enum Geometry {
    /// Nothing of its own: a group that others hang under.
    Group,
    /// Nothing of its own: all objects of the definition of this name are shown where it is.
    Instance(String),
    /// A spline curve.
    Curve(Curve),
    /// A spline surface.
    Surface(Surface),
    /// A spline surface of which loops bound a part.
    Trimmed(Trimmed),
    /// Faces on surfaces that share their edges, and the solids that they bound.
    Brep(Brep),
    /// A polygon mesh.
    Mesh(Mesh),
    /// A chain of straight segments.
    Polyline(Polyline),
    /// Loose points.
    Cloud(Cloud),
    /// A shape of a plug-in.
    Custom(CustomShape),
}

/// What to do where a curve is wanted and a polyline is there.
pub(crate) const CURVE_OF_POLYLINE: &str = "the operation \"polyline\" with curve = true, or \"fit\" with degree = 1 and interpolate = true, \
     makes a curve of a polyline";

/// What to do where a polyline is wanted and a mesh of lines is there.
pub(crate) const LINES_OF_MESH: &str = "converted to OBJ and read from there each is a polyline";

impl Geometry {
    /// What it is called in documents: `"curve"`, `"surface"`, `"trimmed"`, `"brep"`, `"mesh"`, `"polyline"`, `"cloud"`,
    /// `"group"`, `"instance"`; of a shape of a plug-in, the name of its kind.
    pub fn kind(&self) -> &str {
        match self {
            Self::Group => "group",
            Self::Instance(_) => "instance",
            Self::Curve(_) => "curve",
            Self::Surface(_) => "surface",
            Self::Trimmed(_) => "trimmed",
            Self::Brep(_) => "brep",
            Self::Mesh(_) => "mesh",
            Self::Polyline(_) => "polyline",
            Self::Cloud(_) => "cloud",
            Self::Custom(custom) => custom.kind(),
        }
    }

    /// The points it is kept as: control vertices (of a Brep, those of its surfaces, of its edges, and its vertices), mesh points, polyline or cloud points; groups and
    /// instances have none, and shapes whose plug-in is not here.
    pub fn points(&self) -> &[Point] {
        match self {
            Self::Group | Self::Instance(_) => &[],
            Self::Curve(curve) => curve.points(),
            Self::Surface(surface) => surface.points(),
            Self::Trimmed(trimmed) => trimmed.surface().points(),
            Self::Brep(brep) => brep.points(),
            Self::Mesh(mesh) => mesh.points(),
            Self::Polyline(line) => &line.points,
            Self::Cloud(cloud) => &cloud.points,
            Self::Custom(custom) => custom.points(),
        }
    }

    /// What it is, in words: its kind, whole, and of a mesh of nothing but lines what makes polylines of these.
    pub fn noun(&self) -> Cow<'_, str> {
        match self {
            Self::Trimmed(_) => "trimmed surface".into(),
            _ if self.is_lines() => format!("mesh of lines ({LINES_OF_MESH})").into(),
            _ => self.kind().into(),
        }
    }

    /// Whether it is a mesh of nothing but lines.
    pub(crate) fn is_lines(&self) -> bool {
        matches!(self, Self::Mesh(mesh) if mesh.face_count() == 0 && mesh.lines().next().is_some())
    }

    /// What it is and what it is not, and what to do about that where an operation does: `"a polyline, not a curve: …"`. `wanted` has its
    /// article.
    pub fn other_than(&self, wanted: &str) -> String {
        let kind = crate::text::a(&self.noun());
        match self {
            Self::Polyline(_) => format!("{kind}, not {wanted}: {CURVE_OF_POLYLINE}"),
            Self::Trimmed(_) => format!("{kind}, not {wanted}: \"untrim\" makes it a whole surface"),
            _ => format!("{kind}, not {wanted}"),
        }
    }

    /// The shape that it is, or (of a trimmed surface, and of a Brep face by face) is a part of: what has values at locations.
    ///
    /// # Errors
    /// When it has none: a mesh, a polyline, a cloud, a group or an instance; [`Error::UnknownKind`] where its plug-in
    /// is not here.
    pub fn shape(&self) -> Result<&dyn Shape> {
        match self {
            Self::Curve(curve) => Ok(curve),
            Self::Surface(surface) => Ok(surface),
            Self::Trimmed(trimmed) => Ok(trimmed.surface()),
            Self::Brep(brep) => Ok(brep),
            Self::Custom(custom) => custom.shape(),
            other => Err(Error::Invalid(format!(
                "a {} is not a curve or surface: fit one to it first",
                other.kind()
            ))),
        }
    }

    /// Whether nothing is known of it but what a document says: its plug-in is not here.
    pub fn is_unknown(&self) -> bool {
        matches!(self, Self::Custom(custom) if custom.shape_kind().is_none())
    }
}

macro_rules! into_geometry {
    ($($kind:ident),*) => {$(
        impl From<$kind> for Geometry {
            fn from(value: $kind) -> Self {
                Self::$kind(value)
            }
        }
        impl From<&$kind> for Geometry {
            fn from(value: &$kind) -> Self {
                Self::$kind(value.clone())
            }
        }
    )*};
}
into_geometry!(Curve, Surface, Trimmed, Brep, Mesh, Polyline, Cloud);

impl From<CustomShape> for Geometry {
    fn from(shape: CustomShape) -> Self {
        Self::Custom(shape)
    }
}

impl From<Drawn> for Geometry {
    fn from(drawn: Drawn) -> Self {
        match drawn {
            Drawn::Line(line) => Self::Polyline(line),
            Drawn::Mesh(mesh) => Self::Mesh(mesh),
        }
    }
}

impl<S: DeclaredShape> From<S> for Geometry {
    fn from(shape: S) -> Self {
        Self::Custom(shape.into())
    }
}
