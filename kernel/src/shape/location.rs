//! Where on a shape something is asked, and what: places, orders of derivatives, sides.

pub use crate::space::Side;
use std::fmt;

use crate::error::{Error, Result};

/// Where on a shape: `u` on a curve, `(u, v)` on a surface; on a surface of many faces a face and a place on it, or a vertex.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Location {
    /// A parameter of a curve.
    Curve(f64),
    /// A pair of parameters of a surface.
    Surface(f64, f64),
    /// A face of a surface that has many ([`Shape::faces`](super::Shape::faces)), and a pair of parameters on it.
    Face(u32, f64, f64),
    /// Where a control vertex of a surface of many faces has most influence: of a subdivision surface its limit.
    Vertex(u32),
}

impl Location {
    /// The number of parameters that can be varied: 1 or 2; none at a vertex.
    pub fn parameters(self) -> usize {
        match self {
            Self::Curve(_) => 1,
            Self::Surface(..) | Self::Face(..) => 2,
            Self::Vertex(_) => 0,
        }
    }

    /// Whether it is a place of a surface of many faces.
    pub fn is_on_face(self) -> bool {
        matches!(self, Self::Face(..) | Self::Vertex(_))
    }

    /// The place whose parameters are those of others, each times its share; `None` where these are not all on one curve, one patch or one face. `O(n)`.
    pub fn mean(places: &[(Self, f64)]) -> Option<Self> {
        let (mut on, mut at) = (None, [0.0; 2]);
        for &(place, share) in places {
            let (face, [u, v]) = match place {
                Self::Curve(u) => (Self::Curve(0.0), [u, 0.0]),
                Self::Surface(u, v) => (Self::Surface(0.0, 0.0), [u, v]),
                Self::Face(face, u, v) => (Self::Face(face, 0.0, 0.0), [u, v]),
                Self::Vertex(_) => return None,
            };
            if on.is_some_and(|on| on != face) {
                return None;
            }
            (on, at) = (Some(face), [at[0] + share * u, at[1] + share * v]);
        }
        on.map(|on| match on {
            Self::Curve(_) => Self::Curve(at[0]),
            Self::Face(face, ..) => Self::Face(face, at[0], at[1]),
            _ => Self::Surface(at[0], at[1]),
        })
    }

    /// The parameter on a curve.
    ///
    /// # Errors
    /// [`Error::LocationKind`] where this is a location on a surface.
    pub fn on_curve(self) -> Result<f64> {
        match self {
            Self::Curve(u) => Ok(u),
            Self::Surface(..) => Err(Error::LocationKind { found: 2, expected: 1 }),
            Self::Face(..) | Self::Vertex(_) => {
                Err(Error::FaceLocation { wanted: "one parameter u on a curve" })
            }
        }
    }

    /// The two parameters on a surface.
    ///
    /// # Errors
    /// [`Error::LocationKind`] where this is a location on a curve.
    pub fn on_surface(self) -> Result<(f64, f64)> {
        match self {
            Self::Surface(u, v) => Ok((u, v)),
            Self::Curve(_) => Err(Error::LocationKind { found: 1, expected: 2 }),
            Self::Face(..) | Self::Vertex(_) => Err(Error::FaceLocation { wanted: "[u, v] on this surface" }),
        }
    }
}

impl From<f64> for Location {
    fn from(u: f64) -> Self {
        Self::Curve(u)
    }
}

impl From<[f64; 2]> for Location {
    fn from([u, v]: [f64; 2]) -> Self {
        Self::Surface(u, v)
    }
}

impl From<(f64, f64)> for Location {
    fn from((u, v): (f64, f64)) -> Self {
        Self::Surface(u, v)
    }
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Curve(u) => write!(f, "{u}"),
            Self::Surface(u, v) => write!(f, "[{u}, {v}]"),
            Self::Face(face, u, v) => write!(f, "[{u}, {v}] of face {face}"),
            Self::Vertex(vertex) => write!(f, "vertex {vertex}"),
        }
    }
}

/// The order of a derivative: how often by `u` and, on a surface, by `v`. The default is the position itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Derivative {
    /// Times by `u`.
    pub u: usize,
    /// Times by `v`; 0 on a curve.
    pub v: usize,
}

impl Derivative {
    /// No derivative: the position.
    pub const POSITION: Self = Self { u: 0, v: 0 };
}

impl From<usize> for Derivative {
    fn from(u: usize) -> Self {
        Self { u, v: 0 }
    }
}

impl From<[usize; 2]> for Derivative {
    fn from([u, v]: [usize; 2]) -> Self {
        Self { u, v }
    }
}

/// A side in each parameter; a curve looks at the first only.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash, PartialOrd, Ord)]
pub struct Sides {
    /// In `u`.
    pub u: Side,
    /// In `v`.
    pub v: Side,
}

impl From<Side> for Sides {
    /// The same side in both parameters.
    fn from(side: Side) -> Self {
        Self { u: side, v: side }
    }
}

impl From<[Side; 2]> for Sides {
    fn from([u, v]: [Side; 2]) -> Self {
        Self { u, v }
    }
}
