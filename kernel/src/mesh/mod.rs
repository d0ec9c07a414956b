//! Polygon meshes (faces of any size), polylines and point clouds.

mod by_point;
pub mod color;
pub mod distance;
mod layer;
mod moved;
pub mod triangulate;

pub use by_point::ByPoint;
pub use layer::{Layer, NONE};

use crate::error::{Error, Result};
use crate::text::counted;
use crate::{Point, Vector};

/// A named set of faces; a face may be in several.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FaceGroup {
    /// Its name.
    pub name: String,
    /// The faces in it, ascending.
    pub faces: Vec<u32>,
}

/// A polygon mesh: points, faces of three or more corners, loose lines, and what belongs to points, corners and
/// faces.
///
/// Corners are numbered through all faces: corner `c` of face `f` is entry `starts[f] + c` of the corner arrays.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    points: Vec<Point>,
    corners: Vec<u32>,
    starts: Vec<usize>,
    line_corners: Vec<u32>,
    line_starts: Vec<usize>,
    /// Unit normals.
    pub normals: Layer<Vector>,
    /// Tangents as normal maps want them (glTF 2.0, §3.7.2.1): a unit vector along `u`, and 1 or -1, the sign `s` of
    /// the bitangent `s n × t`.
    pub tangents: Layer<[f64; 4]>,
    /// Texture coordinates, `(0, 0)` at the lower left of the picture.
    pub uvs: Layer<[f64; 2]>,
    /// Further sets of texture coordinates.
    pub more_uvs: Vec<Layer<[f64; 2]>>,
    /// Colours: linear red, green, blue, alpha.
    pub colors: Layer<[f64; 4]>,
    /// The material of each face: a place among [`Object::materials`](crate::scene::Object::materials). Empty
    /// where all faces have the first.
    pub materials: Vec<u32>,
    /// The smoothing group of each face, 0 for flat ones. Empty where nothing is said of smoothing.
    pub smoothing: Vec<u32>,
    /// Named sets of faces.
    pub groups: Vec<FaceGroup>,
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
                let problem = format!("has {}: a face needs at least 3", counted(size, "corner[|s]"));
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

    /// The loose lines: chains of two or more points, drawn segment by segment.
    pub fn lines(&self) -> impl Iterator<Item = &[u32]> + '_ {
        self.line_starts.windows(2).map(|pair| &self.line_corners[pair[0]..pair[1]])
    }

    /// Puts loose lines in the place of those that were there: the points of all chains one after the other, and
    /// where each chain starts among them (one more entry than chains; both empty for none).
    ///
    /// # Errors
    /// When a chain has fewer than two points or an index that does not exist, or the starts do not ascend from 0
    /// to the number of indices.
    pub fn set_lines(&mut self, corners: Vec<u32>, starts: Vec<usize>) -> Result<()> {
        if !(corners.is_empty() && starts.len() < 2)
            && (starts.first() != Some(&0) || starts.last() != Some(&corners.len()))
        {
            return Err(Error::Invalid("the line starts must run from 0 to the number of indices".into()));
        }
        for (line, pair) in starts.windows(2).enumerate() {
            if pair[1] < pair[0] + 2 {
                let size = pair[1].saturating_sub(pair[0]);
                return Err(Error::Invalid(format!(
                    "line {line} has {size} points: a line needs at least 2"
                )));
            }
        }
        if let Some(index) = corners.iter().find(|&&i| i as usize >= self.points.len()) {
            let count = self.points.len();
            return Err(Error::Invalid(format!(
                "a line refers to point {index}, but there are only {count}"
            )));
        }
        (self.line_corners, self.line_starts) = (corners, starts);
        Ok(())
    }

    /// For each point the first that has its coordinates: files that keep normals by point have several in one place. `O(n log n)`.
    pub fn welded(&self) -> Vec<u32> {
        // 0.0 and -0.0 are one place.
        let key = |k: u32| {
            let p = &self.points[k as usize];
            [p.x + 0.0, p.y + 0.0, p.z + 0.0].map(f64::to_bits)
        };
        let mut order: Vec<u32> = (0..self.points.len() as u32).collect();
        order.sort_unstable_by_key(|&index| (key(index), index));
        let mut same = vec![0; order.len()];
        for run in order.chunk_by(|&a, &b| key(a) == key(b)) {
            run.iter().for_each(|&index| same[index as usize] = run[0]);
        }
        same
    }

    /// The unit normal of a face: the direction of its area vector (Newell), taken about its first corner and
    /// scaled so that nothing overflows. `None` for a face without area.
    pub fn face_normal(&self, face: usize) -> Option<Vector> {
        let corners = &self.corners[*self.starts.get(face)?..*self.starts.get(face + 1)?];
        let origin = self.points[*corners.first()? as usize];
        let size = corners.iter().map(|&k| (self.points[k as usize] - origin).amax()).fold(0.0, f64::max);
        let arm = |k: u32| (self.points[k as usize] - origin) / size;
        let area =
            corners.windows(2).fold(Vector::zeros(), |sum, pair| sum + arm(pair[0]).cross(&arm(pair[1])));
        area.try_normalize(0.0).filter(|n| n.iter().all(|c| c.is_finite()))
    }

    /// Turns every face over: it keeps its first corner and runs the other way round. Normals stay as they are.
    pub fn reverse_faces(&mut self) {
        let starts = &self.starts;
        // Where each corner's new content comes from.
        let mut order = Vec::with_capacity(self.corners.len());
        for pair in starts.windows(2) {
            order.push(pair[0]);
            order.extend((pair[0] + 1..pair[1]).rev());
        }
        self.corners = order.iter().map(|&c| self.corners[c]).collect();
        let order = |c: usize| order[c];
        self.normals.reorder(order);
        self.tangents.reorder(order);
        self.uvs.reorder(order);
        self.more_uvs.iter_mut().for_each(|layer| layer.reorder(order));
        self.colors.reorder(order);
    }

    /// Turns the mesh inside out: faces over ([`reverse_faces`](Self::reverse_faces)) and normals round.
    pub fn turn_inside_out(&mut self) {
        self.reverse_faces();
        self.normals.values_mut().iter_mut().for_each(|n| *n = -*n);
        // The bitangent stays where it was.
        self.tangents.values_mut().iter_mut().for_each(|t| t[3] = -t[3]);
    }

    /// Checks what the public fields hold: that it fits the points, corners and faces.
    ///
    /// # Errors
    /// With the layer, its place and what is wrong there.
    pub fn check(&self) -> Result<()> {
        let (points, corners, faces) = (self.points.len(), self.corners.len(), self.face_count());
        self.normals.check("normals", points, corners)?;
        self.tangents.check("tangents", points, corners)?;
        self.uvs.check("texture coordinates", points, corners)?;
        self.more_uvs.iter().try_for_each(|l| l.check("further texture coordinates", points, corners))?;
        self.colors.check("colours", points, corners)?;
        for (what, found) in
            [("material slots", self.materials.len()), ("smoothing groups", self.smoothing.len())]
        {
            if found != 0 && found != faces {
                let problem = format!("{found} {what} for {faces} faces: there must be one a face, or none");
                return Err(Error::Invalid(problem));
            }
        }
        for FaceGroup { name, faces: members } in &self.groups {
            let ascending = members.is_sorted_by(|a, b| a < b);
            if !ascending || members.last().is_some_and(|&f| f as usize >= faces) {
                let problem = format!("the group \"{name}\" must list some of the {faces} faces, ascending");
                return Err(Error::Invalid(problem));
            }
        }
        Ok(())
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
