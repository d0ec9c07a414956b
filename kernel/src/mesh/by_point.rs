//! Meshes for formats that know attributes of points only.

use std::borrow::Cow;

use super::{Layer, Mesh, NONE};
use crate::error::Result;
use crate::{Point, Vector};

/// How many variants of one point are compared before a corner gets a point of its own. It bounds the work at a
/// pole, where every corner may differ; more doubling than needed is all that it can cost.
const VARIANTS: usize = 16;

/// A mesh whose layers all belong to points, made from one whose layers need not.
#[derive(Debug, Clone, PartialEq)]
pub struct ByPoint<'a> {
    /// The mesh: the old points first, in their order, then the doubled ones.
    pub mesh: Cow<'a, Mesh>,
    /// The old point of each doubled one.
    pub doubled: Vec<u32>,
    /// How many corners lacked a value that others have: normals were filled with the face's own, tangents with the x
    /// axis, texture coordinates with 0, colours with white.
    pub filled: usize,
}

impl Mesh {
    /// The same mesh with points doubled where corners at a point differ in a layer, so that every layer belongs
    /// to points (as glTF and graphics cards want it). A mesh that is so already is borrowed.
    ///
    /// Points keep their indices; doubled ones come after them. `O(corners)`.
    ///
    /// # Errors
    /// When the mesh does not pass its [`check`](Mesh::check), or has more points than indices can name.
    pub fn by_point(&self) -> Result<ByPoint<'_>> {
        self.check()?;
        let layers =
            [self.normals.corners(), self.tangents.corners(), self.uvs.corners(), self.colors.corners()];
        if layers.iter().all(Option::is_none) && self.more_uvs.iter().all(|l| l.corners().is_none()) {
            return Ok(ByPoint { mesh: Cow::Borrowed(self), doubled: Vec::new(), filled: 0 });
        }
        let old = self.points.len();
        // The first corner seen at each new point, and the next variant of the same old one.
        let mut next = vec![NONE; old];
        let mut representative = vec![usize::MAX; old];
        let mut doubled = Vec::new();
        let mut corners = Vec::with_capacity(self.corners.len());
        for (corner, &point) in self.corners.iter().enumerate() {
            let mut at = point as usize;
            for step in 0.. {
                if representative[at] == usize::MAX {
                    representative[at] = corner;
                    break;
                }
                if self.alike(representative[at], corner, point) {
                    break;
                }
                if next[at] != NONE && step < VARIANTS {
                    at = next[at] as usize;
                    continue;
                }
                // A new variant goes to the front, right behind the point itself: the latest is the likeliest.
                let new = representative.len();
                representative.push(corner);
                next.push(next[point as usize]);
                next[point as usize] = u32::try_from(new).unwrap_or(NONE);
                doubled.push(point);
                at = new;
                break;
            }
            corners.push(u32::try_from(at).unwrap_or(NONE));
        }
        let mut filled = 0;
        let mut points: Vec<Point> = Vec::with_capacity(representative.len());
        points.extend(&self.points);
        points.extend(doubled.iter().map(|&p| self.points[p as usize]));
        let mut mesh = Self::from_parts(points, corners, self.starts.clone())?;
        let source = |i: usize| if i < old { i as u32 } else { doubled[i - old] };
        mesh.normals = self.spread(&self.normals, &representative, source, &mut filled, |corner| {
            self.face_normal(self.face_of(corner)).unwrap_or_else(Vector::zeros)
        });
        mesh.tangents =
            self.spread(&self.tangents, &representative, source, &mut filled, |_| [1.0, 0.0, 0.0, 1.0]);
        mesh.uvs = self.spread(&self.uvs, &representative, source, &mut filled, |_| [0.0; 2]);
        mesh.more_uvs = (self.more_uvs.iter())
            .map(|layer| self.spread(layer, &representative, source, &mut filled, |_| [0.0; 2]))
            .collect();
        mesh.colors = self.spread(&self.colors, &representative, source, &mut filled, |_| [1.0; 4]);
        mesh.materials.clone_from(&self.materials);
        mesh.smoothing.clone_from(&self.smoothing);
        mesh.groups.clone_from(&self.groups);
        mesh.line_corners.clone_from(&self.line_corners);
        mesh.line_starts.clone_from(&self.line_starts);
        Ok(ByPoint { mesh: Cow::Owned(mesh), doubled, filled })
    }

    /// Whether corners at one point differ in a layer, so that [`by_point`](Self::by_point) doubles points.
    pub(crate) fn differs_at_points(&self) -> bool {
        let layers =
            [self.normals.corners(), self.tangents.corners(), self.uvs.corners(), self.colors.corners()];
        let by_corner =
            layers.iter().any(Option::is_some) || self.more_uvs.iter().any(|l| l.corners().is_some());
        by_corner && self.any_at_points(|a, b, point| !self.alike(a, b, point))
    }

    /// Whether corners at one point that have a colour have different ones.
    pub(crate) fn colors_differ_at_points(&self) -> bool {
        let differ = |a, b, point| match (self.colors.at(a, point), self.colors.at(b, point)) {
            (Some(a), Some(b)) => a != b,
            _ => false,
        };
        self.colors.corners().is_some() && self.any_at_points(differ)
    }

    /// Whether something holds of the first corner at a point and another one there.
    fn any_at_points(&self, holds: impl Fn(usize, usize, u32) -> bool) -> bool {
        let mut first = vec![usize::MAX; self.points.len()];
        self.corners.iter().enumerate().any(|(corner, &point)| match first.get_mut(point as usize) {
            Some(seen) if *seen == usize::MAX => {
                *seen = corner;
                false
            }
            Some(seen) => holds(*seen, corner, point),
            None => false,
        })
    }

    /// Whether two corners at one point have the same values in every layer.
    fn alike(&self, a: usize, b: usize, point: u32) -> bool {
        fn same<T: PartialEq>(layer: &Layer<T>, a: usize, b: usize, point: u32) -> bool {
            layer.index(a, point) == layer.index(b, point) || layer.at(a, point) == layer.at(b, point)
        }
        same(&self.normals, a, b, point)
            && same(&self.tangents, a, b, point)
            && same(&self.uvs, a, b, point)
            && same(&self.colors, a, b, point)
            && self.more_uvs.iter().all(|layer| same(layer, a, b, point))
    }

    /// A layer's values at the points' representative corners.
    fn spread<T: Clone>(
        &self,
        layer: &Layer<T>,
        representative: &[usize],
        source: impl Fn(usize) -> u32,
        filled: &mut usize,
        mut fill: impl FnMut(Option<usize>) -> T,
    ) -> Layer<T> {
        if layer.is_empty() {
            return Layer::none();
        }
        let values = representative.iter().enumerate().map(|(i, &corner)| {
            let used = (corner != usize::MAX).then_some(corner);
            layer.at(corner, source(i)).cloned().unwrap_or_else(|| {
                *filled += usize::from(used.is_some());
                fill(used)
            })
        });
        Layer::per_point(values.collect())
    }

    fn face_of(&self, corner: Option<usize>) -> usize {
        corner.map_or(usize::MAX, |corner| self.starts.partition_point(|&s| s <= corner) - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two squares that share an edge.
    fn squares() -> Mesh {
        let at = |x: f64, y: f64| Point::new(x, y, 0.0);
        let points = vec![at(0.0, 0.0), at(1.0, 0.0), at(2.0, 0.0), at(0.0, 1.0), at(1.0, 1.0), at(2.0, 1.0)];
        Mesh::new(points, &[[0, 1, 4, 3], [1, 2, 5, 4]]).unwrap()
    }

    #[test]
    fn points_are_doubled_only_where_corners_differ() {
        let mut mesh = squares();
        // Two charts: the shared edge lies at u = 1 in the first and at u = 0 in the second; colours are per point.
        let corners = vec![0, 1, 2, 3, 0, 1, 2, 3];
        mesh.uvs = Layer::per_corner(vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], corners);
        mesh.colors = Layer::per_point((0..6).map(|i| [f64::from(i) / 5.0, 0.0, 0.0, 1.0]).collect());
        let flat = mesh.by_point().unwrap();
        assert_eq!((flat.doubled.as_slice(), flat.filled), ([1, 4].as_slice(), 0));
        let out = &flat.mesh;
        out.check().unwrap();
        for (corner, (&new, &point)) in out.corners().iter().zip(mesh.corners()).enumerate() {
            assert_eq!(out.points()[new as usize], mesh.points()[point as usize]);
            assert_eq!(out.uvs.at(corner, new), mesh.uvs.at(corner, point));
            assert_eq!(out.colors.at(corner, new), mesh.colors.at(corner, point));
        }
        assert!(matches!(out.by_point().unwrap().mesh, Cow::Borrowed(_)));
    }

    #[test]
    fn equal_values_under_different_indices_double_nothing() {
        let mut mesh = squares();
        mesh.normals = Layer::per_corner(vec![Vector::z(); 8], (0..8).collect());
        assert!(mesh.by_point().unwrap().doubled.is_empty());
    }

    #[test]
    fn a_corner_without_a_normal_gets_its_faces_own() {
        let mut mesh = squares();
        mesh.normals = Layer::per_corner(vec![Vector::x()], vec![0, 0, 0, 0, NONE, NONE, NONE, NONE]);
        let flat = mesh.by_point().unwrap();
        assert_eq!(flat.filled, 4);
        let normals = flat.mesh.normals.values();
        let of = |corner: usize| normals[flat.mesh.corners()[corner] as usize];
        assert_eq!((of(0), of(4), of(5)), (Vector::x(), Vector::z(), Vector::z()));
    }

    #[test]
    fn a_pole_of_many_charts_costs_no_square() {
        let n = 200_000_u32;
        let mut points = vec![Point::origin()];
        points.extend((0..n).map(|i| {
            let angle = f64::from(i) * std::f64::consts::TAU / f64::from(n);
            Point::new(angle.cos(), angle.sin(), 0.0)
        }));
        let faces: Vec<[usize; 3]> = (0..n as usize).map(|i| [0, 1 + i, 1 + (i + 1) % n as usize]).collect();
        let mut mesh = Mesh::new(points, &faces).unwrap();
        let uvs = (0..3 * n).map(|c| [f64::from(c), 0.0]).collect();
        mesh.uvs = Layer::per_corner(uvs, (0..3 * n).collect());
        assert_eq!(mesh.by_point().unwrap().mesh.points().len(), 3 * n as usize);
    }
}
