//! Segments and triangles of a shape of a plug-in.

use crate::error::{Error, Result};
use crate::mesh::{Mesh, Polyline};
use crate::shape::Location;
use crate::text::short;
use crate::{Point, Vector};

/// What a shape is drawn as.
#[allow(
    clippy::large_enum_variant,
    reason = "there is one at a time: a few hundred bytes buy plain matching"
)]
#[derive(Debug, Clone, PartialEq)]
pub enum Drawn {
    /// A curve, as segments.
    Line(Polyline),
    /// A surface, as triangles with normals.
    Mesh(Mesh),
}

impl Drawn {
    /// What it is, in the plural: `"segments"` or `"triangles"`.
    pub fn what(&self) -> &'static str {
        match self {
            Self::Line(_) => "segments",
            Self::Mesh(_) => "triangles",
        }
    }

    /// Its points.
    pub fn points(&self) -> &[Point] {
        match self {
            Self::Line(line) => &line.points,
            Self::Mesh(mesh) => mesh.points(),
        }
    }
}

/// A shape in each of its states as segments or triangles, the same ones in all of them, and how near these are.
#[derive(Debug, Clone, PartialEq)]
pub struct Faceted {
    /// The first state.
    pub drawn: Drawn,
    /// The points of each state, in the order of those of the first; as many in all.
    pub states: Vec<Vec<Point>>,
    /// The chord asked for, as a length: that of the largest state.
    pub tolerance: f64,
    /// The largest distance between the shape and its segments or triangles, in any state.
    pub error: f64,
    /// Whether that is a bound. If not, it is the largest that was found in many places.
    pub certified: bool,
    /// Where on the shape each point is; empty where that is not known.
    pub places: Vec<Location>,
    /// Of triangles, where each of their corners is as seen from inside the triangle, in the order of the mesh's corners: all three on one face,
    /// and at borders of faces, at seams and at poles, where a point has several places, that beside the triangle. Empty of segments, and where
    /// it is not known.
    pub corners: Vec<Location>,
}

impl Faceted {
    /// What somebody else made, if it is what it says.
    pub(super) fn checked(self, states: usize) -> Result<Self> {
        let count = self.drawn.points().len();
        let wrong =
            |problem: &str| Err(Error::Invalid(format!("a tessellation that its plug-in made {problem}")));
        if self.states.len() != states || self.states.iter().any(|points| points.len() != count) {
            return wrong("does not have the same points in each state");
        }
        if !self.places.is_empty() && self.places.len() != count {
            return wrong("does not have a place for each point");
        }
        let of_mesh = if let Drawn::Mesh(mesh) = &self.drawn { mesh.corners().len() } else { 0 };
        if !self.corners.is_empty() && self.corners.len() != of_mesh {
            return wrong("does not have a place for each corner of its triangles");
        }
        if !self
            .states
            .iter()
            .chain([&self.drawn.points().to_vec()])
            .flatten()
            .all(|p| p.iter().all(|c| c.is_finite()))
        {
            return wrong("has a point that is not finite");
        }
        if let Drawn::Mesh(mesh) = &self.drawn {
            mesh.check()?;
        }
        Ok(self)
    }

    /// What to say of how near it is, where that is not certified: the distance in units of `scale`.
    pub fn remark(&self, scale: f64) -> Option<String> {
        let apart = self.error * scale;
        (!self.certified).then(|| {
            format!("its error of {apart} was found in many places, not certified", apart = short(apart))
        })
    }
}

/// Unit normals at points, as the mean of those of the triangles around them.
pub(super) fn normals(points: &[Point], corners: &[u32]) -> Vec<Vector> {
    let mut sums = vec![Vector::zeros(); points.len()];
    for triangle in corners.chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|k| triangle[k] as usize);
        let across = (points[b] - points[a]).cross(&(points[c] - points[a]));
        for corner in [a, b, c] {
            sums[corner] += across;
        }
    }
    sums.into_iter().map(|sum| sum.try_normalize(0.0).unwrap_or_else(Vector::z)).collect()
}
