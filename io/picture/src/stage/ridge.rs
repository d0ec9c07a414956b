//! Where triangles meet at an angle: on which side of them a point is that has its foot there.

use std::collections::{BTreeMap, BTreeSet};

use loftsman_kernel::Vector;

use super::shell::pair;

/// Triangles that meet at more are sharp there: its cosine, of 45 degrees.
const SHARP: f64 = 0.7;

/// The sharp edges and vertices of triangles, each with the sum of the unit normals round it, at vertices every one times the angle that its triangle has
/// there: of a point whose foot is there it says the side, which the normal of one of the triangles does not (Bærentzen and Aanæs 2005).
#[derive(Debug, Default)]
pub(super) struct Ridges {
    edges: BTreeMap<(u32, u32), Vector>,
    vertices: BTreeMap<u32, Vector>,
}

impl Ridges {
    /// Of triangles over some points, where `origin` says which of them are one. Takes `n log n`.
    pub(super) fn of(triangles: &[[u32; 3]], points: &[Vector], origin: impl Fn(u32) -> u32) -> Self {
        let mut beside: BTreeMap<(u32, u32), Vec<Vector>> = BTreeMap::new();
        let mut around: BTreeMap<u32, Vec<(Vector, f64)>> = BTreeMap::new();
        for triangle in triangles {
            let corners = triangle.map(|k| points[k as usize]);
            let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
            let Some(normal) = normal.try_normalize(0.0) else { continue };
            for k in 0..3 {
                let [a, b, c] = [0, 1, 2].map(|by| (k + by) % 3);
                let angle = (corners[b] - corners[a]).angle(&(corners[c] - corners[a]));
                around.entry(origin(triangle[a])).or_default().push((normal, angle));
                beside.entry(pair(origin(triangle[a]), origin(triangle[b]))).or_default().push(normal);
            }
        }
        beside.retain(|_, normals| normals.iter().any(|n| n.dot(&normals[0]) < SHARP));
        let ends: BTreeSet<u32> = beside.keys().flat_map(|&(a, b)| [a, b]).collect();
        let turned = |(vertex, normals): &(u32, Vec<(Vector, f64)>)| {
            ends.contains(vertex) || normals.iter().any(|(n, _)| n.dot(&normals[0].0) < SHARP)
        };
        let sum = |normals: Vec<(Vector, f64)>| normals.iter().map(|(n, angle)| n * *angle).sum();
        let vertices = around.into_iter().filter(turned).map(|(vertex, normals)| (vertex, sum(normals)));
        let vertices = vertices.collect();
        let edges = beside.into_iter().map(|(edge, normals)| (edge, normals.iter().sum())).collect();
        Self { edges, vertices }
    }

    /// The normal at the place of a triangle with these shares of its corners, by their origins; `None` where it is not sharp there.
    pub(super) fn normal(&self, triangle: [u32; 3], shares: [f64; 3]) -> Option<Vector> {
        let on: Vec<u32> = (0..3).filter(|&k| shares[k] > 0.0).map(|k| triangle[k]).collect();
        match on[..] {
            [vertex] => self.vertices.get(&vertex).copied(),
            [a, b] => self.edges.get(&pair(a, b)).copied(),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tetrahedron with one sharp tip, seen from outside and from within at its corners and edges.
    #[test]
    fn sides_are_known_at_edges_and_tips() {
        let points =
            [Vector::zeros(), Vector::x(), Vector::y(), Vector::new(2.0, 2.0, 0.3)].map(|p| p * 2.0).to_vec();
        let middle: Vector = points.iter().sum::<Vector>() / 4.0;
        let triangles: Vec<[u32; 3]> = [[0, 1, 2], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
            .map(|[a, b, c]: [u32; 3]| {
                let [p, q, r] = [a, b, c].map(|k| points[k as usize]);
                if (q - p).cross(&(r - p)).dot(&(p - middle)) > 0.0 { [a, b, c] } else { [a, c, b] }
            })
            .to_vec();
        let ridges = Ridges::of(&triangles, &points, |k| k);
        let mut found = 0;
        for triangle in &triangles {
            for shares in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.5, 0.0], [0.0, 0.3, 0.7]] {
                let Some(normal) = ridges.normal(*triangle, shares) else { continue };
                let at: Vector = (0..3).map(|k| points[triangle[k] as usize] * shares[k]).sum();
                assert!(normal.dot(&(at - middle)) > 0.0, "{triangle:?} {shares:?}");
                found += 1;
            }
        }
        assert!(found >= 12, "{found}");
        assert_eq!(ridges.normal([0, 1, 2], [0.2, 0.3, 0.5]), None);
    }
}
