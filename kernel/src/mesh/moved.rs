//! Meshes with their points elsewhere: normals turn with the faces around them.

use nalgebra::Matrix3;

use super::{Layer, Mesh};
use crate::error::{Error, Result};
use crate::{Point, Vector, direction};

impl Mesh {
    /// The same mesh with other points, as in a frame of an animation. Each normal, and each tangent, is turned as the
    /// faces of its corners are: by the rotation that comes nearest to all that these do to their normals and to the directions
    /// of their sides, `max tr(Rᵀ Σ b aᵀ)`, weighted by the angles at the corners (Kabsch 1976). It stays where faces without
    /// area say nothing. What is moved and turned as one has its normals and tangents turned exactly; else they follow the faces
    /// to second order in the size of these, at an open edge to first. `O(corners)`.
    ///
    /// # Errors
    /// When there are more or fewer points than it has, a coordinate is not finite, or the mesh does not pass its
    /// [`check`](Mesh::check).
    pub fn moved(&self, points: Vec<Point>) -> Result<Self> {
        let (found, expected) = (points.len(), self.points.len());
        if found != expected {
            return Err(Error::Invalid(format!("{found} points for a mesh of {expected}")));
        }
        if let Some((index, p)) = points.iter().enumerate().find(|(_, p)| !p.iter().all(|c| c.is_finite())) {
            return Err(Error::VertexNotFinite { index, x: p.x, y: p.y, z: p.z });
        }
        self.check()?;
        let mut moved = self.clone();
        moved.points = points;
        if self.normals.is_empty() && self.tangents.is_empty() || self.points == moved.points {
            return Ok(moved);
        }
        let before = self.corner_frames();
        let after = moved.corner_frames();
        let turns = self.turns(&self.normals, &before, &after);
        for (normal, turn) in moved.normals.values_mut().iter_mut().zip(turns) {
            *normal = turn * *normal;
        }
        let turns = self.turns(&self.tangents, &before, &after);
        for (tangent, turn) in moved.tangents.values_mut().iter_mut().zip(turns) {
            let along = turn * Vector::new(tangent[0], tangent[1], tangent[2]);
            tangent[..3].copy_from_slice(along.as_slice());
        }
        Ok(moved)
    }

    /// For each corner the unit normal of its face and the directions of the two sides there, as columns, with the angle
    /// between these; `None` where the face has no area or a side no length.
    fn corner_frames(&self) -> Vec<Option<(Matrix3<f64>, f64)>> {
        let mut all = Vec::with_capacity(self.corners.len());
        for (face, corners) in self.faces().enumerate() {
            let normal = self.face_normal(face);
            let count = corners.len();
            let side = |from: u32, to: u32| {
                let way = self.points[to as usize] - self.points[from as usize];
                direction(&way)
            };
            for (k, &corner) in corners.iter().enumerate() {
                let next = side(corner, corners[(k + 1) % count]);
                let last = side(corner, corners[(k + count - 1) % count]);
                all.push(match (normal, next, last) {
                    (Some(normal), Some(next), Some(last)) => {
                        let angle = next.cross(&last).norm().atan2(next.dot(&last));
                        Some((Matrix3::from_columns(&[normal, next, last]), angle))
                    }
                    _ => None,
                });
            }
        }
        all
    }

    /// The rotation of each value of a layer.
    fn turns<T>(
        &self,
        layer: &Layer<T>,
        before: &[Option<(Matrix3<f64>, f64)>],
        after: &[Option<(Matrix3<f64>, f64)>],
    ) -> Vec<Matrix3<f64>> {
        let mut sums = vec![Matrix3::zeros(); layer.values().len()];
        for (corner, (&point, frames)) in self.corners.iter().zip(before.iter().zip(after)).enumerate() {
            // A face that has no area at one time says nothing of the way to the other.
            if let (Some((before, angle)), Some((after, _))) = frames
                && let Some(sum) = sums.get_mut(layer.index(corner, point) as usize)
            {
                *sum += after * before.transpose() * *angle;
            }
        }
        sums.iter().map(|sum| rotation(sum).unwrap_or_else(Matrix3::identity)).collect()
    }
}

/// The rotation `R` for which `tr(Rᵀ M)` is largest; `None` where the matrix has no rank of two, so that there is no one.
fn rotation(m: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let svd = m.try_svd(true, true, f64::EPSILON, 100)?;
    let (u, v_t) = (svd.u?, svd.v_t?);
    // Values descend: where a reflection would be nearer, the direction that counts least gives way.
    if svd.singular_values[1] <= 1e-9 * svd.singular_values[0] {
        return None;
    }
    let sign = (u.determinant() * v_t.determinant()).signum();
    Some(u * Matrix3::from_diagonal(&Vector::new(1.0, 1.0, sign)) * v_t)
        .filter(|r| r.iter().all(|c| c.is_finite()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Rotation3, Unit};

    /// A tube of `rows` rings of `sides` points about the z axis, bent by `bend`, with the normals of the tube.
    fn tube(rows: usize, sides: usize, bend: f64, by_corner: bool) -> Mesh {
        let (mut points, mut normals, mut faces) = (Vec::new(), Vec::new(), Vec::new());
        for row in 0..rows {
            let s = row as f64 / (rows - 1) as f64 * 3.0;
            let (sine, cosine) = (bend * s).sin_cos();
            let centre = match bend == 0.0 {
                true => Point::new(0.0, 0.0, s),
                false => Point::new((1.0 - cosine) / bend, 0.0, sine / bend),
            };
            let across = Vector::new(cosine, 0.0, -sine);
            for side in 0..sides {
                let angle = std::f64::consts::TAU * side as f64 / sides as f64;
                let out = across * angle.cos() + Vector::y() * angle.sin();
                points.push(centre + out * 0.2);
                normals.push(out);
                if row + 1 < rows {
                    let (a, b) = (row * sides + side, row * sides + (side + 1) % sides);
                    faces.push([a, b, b + sides, a + sides]);
                }
            }
        }
        let mut mesh = Mesh::new(points, &faces).unwrap();
        mesh.normals = if by_corner {
            let corners = mesh.corners().to_vec();
            Layer::per_corner(normals, corners)
        } else {
            Layer::per_point(normals)
        };
        mesh
    }

    #[test]
    fn what_is_turned_has_its_normals_turned() {
        for by_corner in [false, true] {
            let mut mesh = tube(6, 7, 0.4, by_corner);
            mesh.tangents = Layer::per_point(vec![[0.6, 0.0, 0.8, -1.0]; 42]);
            let axis = Unit::new_normalize(Vector::new(1.0, -2.0, 0.5));
            for (angle, size) in [(0.7, 1.0), (2.9, 1e-9), (-1.3, 1e9)] {
                let turn = Rotation3::from_axis_angle(&axis, angle);
                let points = mesh.points().iter().map(|p| turn * p * size + Vector::x() * size).collect();
                let moved = mesh.moved(points).unwrap();
                for (before, after) in mesh.normals.values().iter().zip(moved.normals.values()) {
                    assert!((turn * before - after).norm() < 1e-9, "{before} {after}");
                }
                let along = turn * Vector::new(0.6, 0.0, 0.8);
                for t in moved.tangents.values() {
                    assert!((Vector::new(t[0], t[1], t[2]) - along).norm() < 1e-9 && t[3] == -1.0);
                }
            }
            assert_eq!(mesh.moved(mesh.points().to_vec()).unwrap(), mesh);
        }
    }

    #[test]
    fn what_is_bent_has_the_normals_of_the_bent_shape() {
        let straight = tube(60, 24, 0.0, true);
        for bend in [0.1, 0.5, 1.0, 2.0] {
            let bent = tube(60, 24, bend, true);
            let moved = straight.moved(bent.points().to_vec()).unwrap();
            let worst = moved.normals.values().iter().zip(bent.normals.values());
            let worst = worst.map(|(a, b)| a.angle(b).to_degrees()).fold(0.0, f64::max);
            assert!(worst < 1.5 * bend.max(1.0), "bent by {bend}: {worst} degrees");
            let stale = straight.normals.values().iter().zip(bent.normals.values());
            let stale = stale.map(|(a, b)| a.angle(b).to_degrees()).fold(0.0, f64::max);
            assert!(stale > 5.0 * worst, "the test would not see normals that stay");
        }
    }

    #[test]
    fn faces_without_area_leave_normals_alone() {
        let mesh = tube(3, 4, 0.0, false);
        let moved = mesh.moved(vec![Point::origin(); 12]).unwrap();
        assert_eq!(moved.normals, mesh.normals);
        assert!(mesh.moved(vec![Point::origin(); 11]).is_err());
        assert!(mesh.moved(vec![Point::new(0.0, f64::NAN, 0.0); 12]).is_err());
        // And turned over.
        let mut over = mesh.points().to_vec();
        over.iter_mut().for_each(|p| p.x = -p.x);
        assert!(mesh.moved(over).unwrap().normals.values().iter().all(|n| (n.norm() - 1.0).abs() < 1e-12));
    }
}
