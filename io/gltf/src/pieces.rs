//! Geometry as glTF primitives: single-precision attributes and indices.

use loftsman_kernel::mesh::{Mesh, Polyline};
use loftsman_kernel::{Error, Point, Result, Vector};

use crate::triangulate;

/// How far from the origin, in multiples of its own size, a shape may be before it is moved there. A coordinate
/// then is rounded by less than 5e-7 of the size.
const FAR: f64 = 8.0;

/// What one primitive is made of.
#[derive(Debug, Default)]
pub(crate) struct Piece {
    pub(crate) mode: u8,
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) normals: Vec<[f32; 3]>,
    pub(crate) uvs: Vec<[f32; 2]>,
    pub(crate) colors: Vec<[f32; 4]>,
    pub(crate) indices: Option<Vec<u32>>,
    /// What the positions were moved by: the node moves them back.
    pub(crate) centre: Vector,
    /// What had to be changed, for the report.
    pub(crate) remarks: Vec<&'static str>,
}

pub(crate) const POINTS: u8 = 0;
pub(crate) const LINE_STRIP: u8 = 3;
pub(crate) const TRIANGLES: u8 = 4;

impl Piece {
    fn new(mode: u8, points: &[Point]) -> Result<Self> {
        let centre = centre(points);
        let mut positions = Vec::with_capacity(points.len());
        for (index, p) in points.iter().enumerate() {
            let local = p - centre;
            let single = [local.x as f32, local.y as f32, local.z as f32];
            if !single.iter().all(|x| x.is_finite()) {
                return Err(Error::VertexNotFinite { index, x: p.x, y: p.y, z: p.z });
            }
            positions.push(single);
        }
        Ok(Self { mode, positions, centre: centre.coords, ..Self::default() })
    }

    /// The triangles of a mesh. Those that single precision leaves without extent are left out.
    pub(crate) fn mesh(mesh: &Mesh) -> Result<Self> {
        let by_point = mesh.by_point()?;
        let mesh = by_point.mesh.as_ref();
        let mut piece = Self::new(TRIANGLES, mesh.points())?;
        let mut indices = Vec::with_capacity(3 * mesh.triangle_count());
        let mut scratch = Vec::new();
        for face in mesh.faces() {
            scratch.clear();
            triangulate::face(mesh.points(), face, &mut scratch);
            for t in scratch.chunks_exact(3) {
                let [a, b, c] = [t[0], t[1], t[2]].map(|k| piece.positions[k as usize]);
                if a != b && b != c && c != a {
                    indices.extend_from_slice(t);
                }
            }
        }
        if indices.len() < 3 * mesh.triangle_count() {
            piece.remarks.push("triangles without extent were left out");
        }
        if mesh.faces().any(|f| f.len() > triangulate::EARS) {
            piece.remarks.push("very large faces were cut as fans");
        }
        piece.indices = Some(indices);
        piece.attributes(mesh);
        Ok(piece)
    }

    fn attributes(&mut self, mesh: &Mesh) {
        let count = mesh.points().len();
        if mesh.normals.values().len() == count {
            // glTF refuses normals that are not of unit length.
            let units = mesh.normals.values().iter().map(|n| {
                let n = n.try_normalize(0.0)?;
                Some([n.x as f32, n.y as f32, n.z as f32])
            });
            match units.collect::<Option<Vec<_>>>() {
                Some(normals) => self.normals = normals,
                None => self.remarks.push("normals without length were left out, and all others with them"),
            }
        }
        if mesh.uvs.values().len() == count {
            let uvs: Vec<_> =
                mesh.uvs.values().iter().map(|uv| [uv[0] as f32, (1.0 - uv[1]) as f32]).collect();
            if uvs.iter().flatten().all(|x| x.is_finite()) {
                self.uvs = uvs;
            } else {
                self.remarks.push("texture coordinates that are not finite were left out");
            }
        }
        if mesh.colors.values().len() == count {
            let inside = mesh.colors.values().iter().flatten().all(|c| (0.0..=1.0).contains(c));
            if !inside {
                self.remarks.push("colours outside 0 to 1 were cut off there");
            }
            self.colors = mesh.colors.values().iter().map(|c| c.map(|x| shade(x) as f32)).collect();
        }
    }

    /// A line strip; a closed one comes back to its first vertex by its indices.
    pub(crate) fn line(line: &Polyline) -> Result<Self> {
        let mut piece = Self::new(LINE_STRIP, &line.points)?;
        if line.closed {
            let count = line.points.len() as u32;
            piece.indices = Some((0..count).chain([0]).collect());
        }
        Ok(piece)
    }

    /// Loose points.
    pub(crate) fn cloud(points: &[Point]) -> Result<Self> {
        Self::new(POINTS, points)
    }
}

/// A colour value within 0 to 1; NaN and -0 become 0.
pub(crate) fn shade(value: f64) -> f64 {
    if value > 0.0 { value.min(1.0) } else { 0.0 }
}

/// The middle of the points' box where they are far from the origin, else the origin.
fn centre(points: &[Point]) -> Point {
    let Some(&first) = points.first() else { return Point::origin() };
    let (low, high) = points.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
    let largest = low.coords.amax().max(high.coords.amax());
    let size = (high - low).norm();
    if size > 0.0 && size.is_finite() && largest > FAR * size {
        low + (high - low) * 0.5
    } else {
        Point::origin()
    }
}
