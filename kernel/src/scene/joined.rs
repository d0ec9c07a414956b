//! Which surfaces of a scene are joined by common edges, and how large what they make together is.

use std::collections::BTreeMap;

use crate::Point;
use crate::error::Result;
use crate::scene::placement::transform_point;
use crate::scene::{Geometry, Scene};
use crate::shape::{Location, Shape};
use crate::spline::Surface;
use crate::topology::{CommonEdges, SAMPLES};

/// Edges are one where they are nearer than this part of the scene's size.
const NEAR: f64 = 1e-9;

impl Scene {
    /// For each object the diagonal of the box around all surfaces that it hangs together with by common edges, in the
    /// scene's coordinates (transforms applied); `None` for what is no surface or has no edge in common with another one.
    ///
    /// Edges are common where 9 points of them, evenly spaced in their parameters in either direction, coincide to
    /// within 1e-9 of the scene's size. Boxes are those of 9 × 9 points of each surface, so never larger than the
    /// surfaces are.
    ///
    /// A tolerance that is a part of this size is the same on both sides of every common edge; one that is a part of each
    /// surface's own size would tear them apart. `O(s log s)` for `s` surfaces.
    ///
    /// # Errors
    /// When the hierarchy is broken ([`check_hierarchy`](Self::check_hierarchy)).
    pub fn joined_diagonals(&self) -> Result<Vec<Option<f64>>> {
        let world = self.world_transforms()?;
        let mut nets: Vec<(usize, Samples)> = Vec::new();
        for (index, (object, map)) in self.objects().iter().zip(&world).enumerate() {
            if let Geometry::Surface(surface) = object.geometry() {
                let place = |p: Point| map.as_ref().map_or(p, |map| transform_point(map, &p));
                nets.extend(Samples::of(surface, place).map(|net| (index, net)));
            }
        }
        let mut answer = vec![None; self.objects().len()];
        let Some((low, high)) = nets.iter().map(|(_, net)| net.extent()).reduce(around) else {
            return Ok(answer);
        };
        let near = NEAR * (high - low).norm();
        if !(near.is_finite() && near > 0.0) {
            return Ok(answer);
        }
        let mut common = CommonEdges::new(nets.len(), low, near);
        for (k, (_, net)) in nets.iter().enumerate() {
            net.edges.iter().for_each(|edge| common.add(k, *edge));
        }
        let roots: Vec<usize> = (0..nets.len()).map(|k| common.group(k)).collect();
        let mut boxes: BTreeMap<usize, (usize, (Point, Point))> = BTreeMap::new();
        for (root, (_, net)) in roots.iter().zip(&nets) {
            let own = net.extent();
            boxes
                .entry(*root)
                .and_modify(|(members, all)| (*members, *all) = (*members + 1, around(*all, own)))
                .or_insert((1, own));
        }
        for (root, (index, _)) in roots.iter().zip(&nets) {
            answer[*index] = boxes
                .get(root)
                .filter(|(members, _)| *members > 1)
                .map(|(_, (low, high))| (high - low).norm());
        }
        Ok(answer)
    }
}

fn around(a: (Point, Point), b: (Point, Point)) -> (Point, Point) {
    (a.0.inf(&b.0), a.1.sup(&b.1))
}

/// Points of a surface, evenly in its parameters, row after row, and those of its edges.
struct Samples {
    points: Vec<Point>,
    edges: Vec<[Point; SAMPLES]>,
}

impl Samples {
    /// `None` where a point is not finite.
    fn of(surface: &Surface, place: impl Fn(Point) -> Point) -> Option<Self> {
        let at = |(a, b): (f64, f64), i: usize| {
            if i + 1 == SAMPLES { b } else { a + (b - a) * (i as f64 / (SAMPLES - 1) as f64) }
        };
        let point = |at: Location| -> Option<Point> {
            let (u, v) = at.on_surface().ok()?;
            Some(place(surface.point(u, v).ok()?)).filter(|p| p.iter().all(|c| c.is_finite()))
        };
        let (u, v) = (surface.u().domain(), surface.v().domain());
        let mut points = Vec::with_capacity(SAMPLES * SAMPLES);
        for i in 0..SAMPLES {
            for j in 0..SAMPLES {
                points.push(point(Location::Surface(at(u, i), at(v, j)))?);
            }
        }
        Some(Self { points, edges: CommonEdges::sampled(surface.edges()?, &point)? })
    }

    fn extent(&self) -> (Point, Point) {
        let first = self.points[0];
        self.points.iter().fold((first, first), |all, &p| around(all, (p, p)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Object;
    use crate::spline::Space;

    fn patch(corners: [[f64; 3]; 4]) -> Surface {
        let line = || Space::open(1, vec![0.0, 0.0, 1.0, 1.0]).unwrap();
        Surface::new(line(), line(), corners.map(Point::from).to_vec()).unwrap()
    }

    #[test]
    fn patches_hang_together_by_edges_and_not_by_corners() {
        let square = |x: f64, y: f64| {
            patch([[x, y, 0.0], [x, y + 1.0, 0.0], [x + 1.0, y, 0.0], [x + 1.0, y + 1.0, 0.0]])
        };
        // The second one's common edge runs the other way.
        let turned = patch([[2.0, 1.0, 0.0], [2.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0]]);
        let mut scene = Scene::new();
        for (name, surface) in [("a", square(0.0, 0.0)), ("b", turned), ("corner", square(2.0, 1.0))] {
            scene.add(Object::new(name, Geometry::Surface(surface))).unwrap();
        }
        let found = scene.joined_diagonals().unwrap();
        assert_eq!(found, [Some(5_f64.sqrt()), Some(5_f64.sqrt()), None]);
        // What a transform brings there is there.
        scene.object_mut("corner").unwrap().transform =
            Some(nalgebra::Matrix4::new_translation(&crate::Vector::new(0.0, -1.0, 0.0)));
        assert_eq!(scene.joined_diagonals().unwrap(), [Some(10_f64.sqrt()); 3]);
    }

    #[test]
    fn a_pole_a_point_and_nothing_are_no_edges() {
        let mut scene = Scene::new();
        assert!(scene.joined_diagonals().unwrap().is_empty());
        let tip = |z: f64| patch([[0.0; 3], [0.0; 3], [0.0, 1.0, z], [1.0, 0.0, z]]);
        scene.add(Object::new("a", Geometry::Surface(tip(1.0)))).unwrap();
        scene.add(Object::new("b", Geometry::Surface(tip(-1.0)))).unwrap();
        assert_eq!(scene.joined_diagonals().unwrap(), [None, None]);
        let mut points = Scene::new();
        points.add(Object::new("a", Geometry::Surface(patch([[1.0; 3]; 4])))).unwrap();
        assert_eq!(points.joined_diagonals().unwrap(), [None]);
    }
}
