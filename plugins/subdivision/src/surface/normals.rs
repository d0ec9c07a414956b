//! The normals of triangles as they are put down: by points, and by corners along creases that never end.

use loftsman_kernel::Vector;
use loftsman_kernel::mesh::Layer;
use smallvec::SmallVec;

use crate::catmull_clark::is_alike;

/// The normals of points, those of their sides, and which of them each corner has.
#[derive(Debug, Default)]
pub(super) struct Normals {
    values: Vec<Vector>,
    /// Of each point, which of the values its corners have.
    of_points: Vec<SmallVec<[u32; 2]>>,
    /// Of each point, the normal of corners that have none of their own side.
    points: Vec<Option<Vector>>,
    /// Of each corner, its value.
    corners: Vec<u32>,
    /// Whether a corner has another normal than its point.
    differ: bool,
}

impl Normals {
    /// One more point, and the normal of the surface there, where it has one.
    pub(super) fn point(&mut self, normal: Option<Vector>) {
        self.points.push(normal);
        self.of_points.push(SmallVec::new());
    }

    /// One more corner, at a point, and the normal that the surface has on its side there, where it has several.
    pub(super) fn corner(&mut self, point: u32, side: Option<Vector>) {
        let at = point as usize;
        let normal = side.or(self.points[at]).unwrap_or_else(Vector::z);
        let mut known = self.of_points[at].iter().copied();
        let index = known.find(|&k| is_alike(&self.values[k as usize], &normal));
        let index = index.unwrap_or_else(|| {
            self.values.push(normal);
            let index = self.values.len() as u32 - 1;
            self.differ |= !self.of_points[at].is_empty();
            self.of_points[at].push(index);
            index
        });
        self.corners.push(index);
    }

    /// By points where no point has two.
    pub(super) fn into_layer(self) -> Layer<Vector> {
        if self.differ {
            return Layer::per_corner(self.values, self.corners);
        }
        let of_points = self.of_points.iter().filter_map(|own| self.values.get(*own.first()? as usize));
        Layer::per_point(of_points.copied().collect())
    }
}
