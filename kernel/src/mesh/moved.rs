//! Meshes with their points elsewhere: normals turn with the faces around them.

use super::{Layer, Mesh};
use crate::error::{Error, Result};
use crate::{Point, Vector};

/// What faces say of the direction at a value of a layer, before and after; no length where they say nothing.
type Turn = [Vector; 2];

impl Mesh {
    /// The same mesh with other points, as in a frame of an animation. Each normal, and each tangent, is turned as the
    /// faces of its corners are: by the smallest rotation that takes the sum of their unit normals, weighted by the angles
    /// at the corners, from where it was to where it is. It stays where faces without area say nothing. So normals follow
    /// the faces as they did, to second order in the size of these (at an open edge to first: to half the angle between
    /// neighbouring normals), and where all is moved and turned as one, those along their faces' sum are exact. `O(corners)`.
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
        let before = self.corner_normals();
        let after = moved.corner_normals();
        for (normal, [from, to]) in
            moved.normals.values_mut().iter_mut().zip(self.turns(&self.normals, &before, &after))
        {
            *normal = turned(normal, &from, &to);
        }
        for (tangent, [from, to]) in
            moved.tangents.values_mut().iter_mut().zip(self.turns(&self.tangents, &before, &after))
        {
            let along = turned(&Vector::new(tangent[0], tangent[1], tangent[2]), &from, &to);
            tangent[..3].copy_from_slice(along.as_slice());
        }
        Ok(moved)
    }

    /// For each corner, the unit normal of its face times the angle of the face there; zero where it has none.
    fn corner_normals(&self) -> Vec<Vector> {
        let mut all = Vec::with_capacity(self.corners.len());
        for (face, corners) in self.faces().enumerate() {
            let normal = self.face_normal(face).unwrap_or_else(Vector::zeros);
            let count = corners.len();
            let side = |from: u32, to: u32| {
                let way = self.points[to as usize] - self.points[from as usize];
                // Scaled first, so that no square overflows or vanishes.
                (way / way.amax()).try_normalize(0.0).filter(|w| w.iter().all(|c| c.is_finite()))
            };
            for (k, &corner) in corners.iter().enumerate() {
                let next = side(corner, corners[(k + 1) % count]);
                let last = side(corner, corners[(k + count - 1) % count]);
                let angle = match (next, last) {
                    (Some(next), Some(last)) => next.cross(&last).norm().atan2(next.dot(&last)),
                    _ => 0.0,
                };
                all.push(normal * angle);
            }
        }
        all
    }

    fn turns<T>(&self, layer: &Layer<T>, before: &[Vector], after: &[Vector]) -> Vec<Turn> {
        let mut turns = vec![[Vector::zeros(); 2]; layer.values().len()];
        for (corner, (&point, (before, after))) in
            self.corners.iter().zip(before.iter().zip(after)).enumerate()
        {
            // A face that has no area at one time says nothing of the way to the other.
            let says = *before != Vector::zeros() && *after != Vector::zeros();
            if says && let Some(turn) = turns.get_mut(layer.index(corner, point) as usize) {
                turn[0] += before;
                turn[1] += after;
            }
        }
        turns
    }
}

/// A vector turned by the smallest rotation that takes one direction to another; as it is where one of them is none.
fn turned(v: &Vector, from: &Vector, to: &Vector) -> Vector {
    let (Some(a), Some(b)) = (from.try_normalize(1e-12), to.try_normalize(1e-12)) else { return *v };
    let cosine = a.dot(&b);
    if cosine < -1.0 + 1e-9 {
        // Half a turn about any axis across: what lies along is what counts.
        return v - a * (2.0 * a.dot(v));
    }
    // Rodrigues' formula with the axis a × b, whose length is the sine.
    let axis = a.cross(&b);
    v * cosine + axis.cross(v) + axis * (axis.dot(v) / (1.0 + cosine))
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
                let points = mesh.points().iter().map(|p| turn * p * size + Vector::x()).collect();
                let moved = mesh.moved(points).unwrap();
                for (before, after) in mesh.normals.values().iter().zip(moved.normals.values()) {
                    // Only about the faces' own direction may a tilt be turned otherwise; these normals have next to none.
                    assert!((turn * before - after).norm() < 0.12, "{before} {after}");
                }
                assert!(moved.tangents.values().iter().all(|t| t[3] == -1.0));
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
