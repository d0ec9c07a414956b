//! What objects are.

use crate::Point;
use crate::mesh::{Cloud, Mesh, Polyline};
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
    /// A polygon mesh.
    Mesh(Mesh),
    /// A chain of straight segments.
    Polyline(Polyline),
    /// Loose points.
    Cloud(Cloud),
}

impl Geometry {
    /// What it is called in documents: `"curve"`, `"surface"`, `"trimmed"`, `"mesh"`, `"polyline"`, `"cloud"`, `"group"`, `"instance"`.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Group => "group",
            Self::Instance(_) => "instance",
            Self::Curve(_) => "curve",
            Self::Surface(_) => "surface",
            Self::Trimmed(_) => "trimmed",
            Self::Mesh(_) => "mesh",
            Self::Polyline(_) => "polyline",
            Self::Cloud(_) => "cloud",
        }
    }

    /// The points it is kept as: control vertices, mesh points, polyline or cloud points; groups and
    /// instances have none.
    pub fn points(&self) -> &[Point] {
        match self {
            Self::Group | Self::Instance(_) => &[],
            Self::Curve(curve) => curve.points(),
            Self::Surface(surface) => surface.points(),
            Self::Trimmed(trimmed) => trimmed.surface().points(),
            Self::Mesh(mesh) => mesh.points(),
            Self::Polyline(line) => &line.points,
            Self::Cloud(cloud) => &cloud.points,
        }
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
into_geometry!(Curve, Surface, Trimmed, Mesh, Polyline, Cloud);
