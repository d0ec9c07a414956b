//! Polygon meshes (faces of any size), polylines and point clouds.

use crate::error::{Error, Result};
use crate::{Point, Vector};

/// A polygon mesh: points, faces of three or more corners, and what belongs to each corner or point.
///
/// Corners are numbered through all faces: corner `c` of face `f` is entry `starts[f] + c` of the corner arrays.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    points: Vec<Point>,
    corners: Vec<u32>,
    starts: Vec<usize>,
    /// Unit normals, one a point; empty where there are none.
    pub normals: Vec<Vector>,
    /// Texture coordinates, one a point; empty where there are none.
    pub uvs: Vec<[f64; 2]>,
    /// Colours (linear red, green, blue, alpha), one a point; empty where there are none.
    pub colors: Vec<[f64; 4]>,
}

impl Mesh {
    /// A mesh of these points and faces; each face lists the indices of its points, counterclockwise from
    /// outside.
    ///
    /// # Errors
    /// When a face has fewer than three corners or an index that does not exist, or a coordinate is not finite.
    pub fn new<F: AsRef<[usize]>>(points: Vec<Point>, faces: &[F]) -> Result<Self> {
        let mut corners = Vec::with_capacity(faces.len() * 3);
        let mut starts = Vec::with_capacity(faces.len() + 1);
        starts.push(0);
        for (face, indices) in faces.iter().enumerate() {
            for &index in indices.as_ref() {
                let corner = u32::try_from(index).unwrap_or(u32::MAX);
                corners.push(corner);
            }
            starts.push(corners.len());
            if let Some(&index) = indices.as_ref().iter().find(|&&i| i >= points.len()) {
                let problem = format!("refers to point {index}, but there are only {}", points.len());
                return Err(Error::Face { face, problem });
            }
        }
        Self::from_parts(points, corners, starts)
    }

    /// A mesh of points, corners and face starts (`faces + 1` of them, the first 0, the last the number of
    /// corners).
    ///
    /// # Errors
    /// As for [`new`](Self::new); also when the starts do not ascend from 0 to the number of corners.
    pub fn from_parts(points: Vec<Point>, corners: Vec<u32>, starts: Vec<usize>) -> Result<Self> {
        if let Some((index, p)) = points.iter().enumerate().find(|(_, p)| !p.iter().all(|c| c.is_finite())) {
            return Err(Error::VertexNotFinite { index, x: p.x, y: p.y, z: p.z });
        }
        if starts.first() != Some(&0) || starts.last() != Some(&corners.len()) {
            return Err(Error::Invalid("the face starts must run from 0 to the number of corners".into()));
        }
        for (face, pair) in starts.windows(2).enumerate() {
            if pair[1] < pair[0] + 3 {
                let size = pair[1].saturating_sub(pair[0]);
                let problem = format!("has {size} corners: a face needs at least 3");
                return Err(Error::Face { face, problem });
            }
            if let Some(&index) = corners[pair[0]..pair[1]].iter().find(|&&i| i as usize >= points.len()) {
                let problem = format!("refers to point {index}, but there are only {}", points.len());
                return Err(Error::Face { face, problem });
            }
        }
        Ok(Self { points, corners, starts, ..Self::default() })
    }

    /// The points.
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// The points, to be moved.
    pub fn points_mut(&mut self) -> &mut [Point] {
        &mut self.points
    }

    /// The point index of every corner, face after face.
    pub fn corners(&self) -> &[u32] {
        &self.corners
    }

    /// Where each face starts among the corners; one more entry than faces.
    pub fn starts(&self) -> &[usize] {
        &self.starts
    }

    /// The number of faces.
    pub fn face_count(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// The faces, each as the indices of its points.
    pub fn faces(&self) -> impl Iterator<Item = &[u32]> + '_ {
        self.starts.windows(2).map(|pair| &self.corners[pair[0]..pair[1]])
    }

    /// The number of triangles that the faces make, fan by fan: `Σ (corners - 2)`.
    pub fn triangle_count(&self) -> usize {
        self.corners.len() - 2 * self.face_count()
    }
}

/// A chain of points joined by straight segments; closed where the last is joined to the first.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Polyline {
    /// The points, without a repeated last one where closed.
    pub points: Vec<Point>,
    /// Whether a segment joins the last point to the first.
    pub closed: bool,
}

/// Loose points.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Cloud {
    /// The points.
    pub points: Vec<Point>,
}
