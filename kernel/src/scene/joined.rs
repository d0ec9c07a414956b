//! Which surfaces of a scene are joined by common edges, and how large what they make together is.

use std::borrow::Cow;
use std::collections::BTreeMap;

use crate::Point;
use crate::error::Result;
use crate::scene::{Geometry, Scene};
use crate::shape::{Location, Shape};
use crate::spline::{Curve, Direction, Surface};
use crate::topology::{CommonEdges, Groups, SAMPLES};

/// Edges are one where they are nearer than this part of the scene's size.
const NEAR: f64 = 1e-9;

/// What a surface of a scene hangs together with by common edges.
#[derive(Debug, Clone, PartialEq)]
pub struct Joined {
    /// The diagonal of the box around all of it, in the scene's coordinates.
    pub diagonal: f64,
    /// Edges and points nearer than this are one, in the scene's coordinates.
    pub near: f64,
    /// The numbers of the objects with which it has an edge in common, or a part of one, ascending.
    pub beside: Vec<usize>,
    /// Whether anywhere in what hangs together two edges are the same as sets of points only: their knots or degrees differ, they are run
    /// through at another speed, or one is a part of the other.
    pub as_points: bool,
}

impl Scene {
    /// For each object what it hangs together with; `None` for what is no surface or has no edge in common with another one.
    ///
    /// Edges are common where 9 points of one, evenly spaced in its parameter, are on the other to within 1e-9 of the scene's size; edges
    /// of which each sticks out of the other are not. Boxes are those of 9 × 9 points of each surface, so never larger than the surfaces are.
    ///
    /// A tolerance that is a part of this size is the same on both sides of every common edge; one that is a part of each
    /// surface's own size would tear them apart. `O(s log s)` for `s` surfaces of which few have boxes in common.
    ///
    /// # Errors
    /// When the hierarchy is broken ([`check_hierarchy`](Self::check_hierarchy)).
    pub fn joined(&self) -> Result<Vec<Option<Joined>>> {
        let world = self.world_transforms()?;
        let mut nets: Vec<(usize, Samples)> = Vec::new();
        for (index, (object, map)) in self.objects().iter().zip(&world).enumerate() {
            let placed = match map {
                Some(map) if matches!(object.geometry(), Geometry::Surface(_)) => {
                    // What overflows hangs together with nothing.
                    let Ok(placed) = object.geometry().transformed(map) else { continue };
                    Cow::Owned(placed)
                }
                _ => Cow::Borrowed(object.geometry()),
            };
            if let Geometry::Surface(surface) = &*placed {
                nets.extend(Samples::of(surface).map(|net| (index, net)));
            }
        }
        let mut answer = vec![None; self.objects().len()];
        let Some((low, high)) = nets.iter().map(|(_, net)| net.extent()).reduce(around) else {
            return Ok(answer);
        };
        let near = NEAR * (high - low).norm();
        if nets.len() < 2 || !(near.is_finite() && near > 0.0) {
            return Ok(answer);
        }
        let edges: Vec<Edge<'_>> = nets
            .iter()
            .enumerate()
            .flat_map(|(k, (_, net))| net.edges.iter().map(move |edge| Edge { owner: k, edge }))
            .filter(|edge| !edge.edge.is_point(near))
            .collect();
        let mut groups = Groups::new(nets.len());
        let mut beside = vec![Vec::new(); nets.len()];
        let mut as_points = Vec::new();
        for [a, b] in touching(&edges, near) {
            let (one, other) = (&edges[a], &edges[b]);
            let Some(alike) = one.edge.common(other.edge, near) else { continue };
            groups.join(one.owner, other.owner);
            beside[one.owner].push(nets[other.owner].0);
            beside[other.owner].push(nets[one.owner].0);
            if !alike {
                as_points.push(one.owner);
            }
        }
        let mut boxes: BTreeMap<usize, Group> = BTreeMap::new();
        for (k, (_, net)) in nets.iter().enumerate() {
            let own = net.extent();
            let new = Group { members: 0, extent: own, as_points: false };
            let group = boxes.entry(groups.root(k)).or_insert(new);
            (group.members, group.extent) = (group.members + 1, around(group.extent, own));
        }
        for k in as_points {
            boxes.entry(groups.root(k)).and_modify(|group| group.as_points = true);
        }
        for (k, (index, _)) in nets.iter().enumerate() {
            let group = boxes.get(&groups.root(k)).filter(|group| group.members > 1);
            answer[*index] = group.map(|group| {
                let mut beside = std::mem::take(&mut beside[k]);
                beside.sort_unstable();
                beside.dedup();
                let diagonal = (group.extent.1 - group.extent.0).norm();
                Joined { diagonal, near, beside, as_points: group.as_points }
            });
        }
        Ok(answer)
    }
}

/// Surfaces that hang together.
struct Group {
    members: usize,
    extent: (Point, Point),
    as_points: bool,
}

/// An edge, and whose it is.
struct Edge<'a> {
    owner: usize,
    edge: &'a Sampled,
}

/// The pairs of edges of different owners whose boxes come within `near` of one another, each once: a sweep along the axis along which the edges' boxes are
/// spread most.
fn touching(edges: &[Edge<'_>], near: f64) -> Vec<[usize; 2]> {
    let middle = |edge: &Edge<'_>| edge.edge.low + (edge.edge.high - edge.edge.low) * 0.5;
    let Some((low, high)) = edges.iter().map(middle).map(|p| (p, p)).reduce(around) else {
        return Vec::new();
    };
    let axis = (high - low).imax();
    let mut order: Vec<usize> = (0..edges.len()).collect();
    order.sort_by(|&a, &b| edges[a].edge.low[axis].total_cmp(&edges[b].edge.low[axis]).then(a.cmp(&b)));
    let mut open: Vec<usize> = Vec::new();
    let mut pairs = Vec::new();
    for b in order {
        let new = edges[b].edge;
        open.retain(|&a| edges[a].edge.high[axis] + near >= new.low[axis]);
        let meets = |old: &Sampled| {
            (0..3).all(|k| old.low[k] <= new.high[k] + near && new.low[k] <= old.high[k] + near)
        };
        let found = open.iter().filter(|&&a| edges[a].owner != edges[b].owner && meets(edges[a].edge));
        pairs.extend(found.map(|&a| [a.min(b), a.max(b)]));
        open.push(b);
    }
    pairs.sort_unstable();
    pairs
}

fn around(a: (Point, Point), b: (Point, Point)) -> (Point, Point) {
    (a.0.inf(&b.0), a.1.sup(&b.1))
}

/// Points of a surface, evenly in its parameters, row after row, and its edges.
struct Samples {
    points: Vec<Point>,
    edges: Vec<Sampled>,
}

impl Samples {
    /// `None` where a point is not finite.
    fn of(surface: &Surface) -> Option<Self> {
        let at = |(a, b): (f64, f64), i: usize| {
            if i + 1 == SAMPLES { b } else { a + (b - a) * (i as f64 / (SAMPLES - 1) as f64) }
        };
        let point = |at: Location| -> Option<Point> {
            let (u, v) = at.on_surface().ok()?;
            surface.point(u, v).ok().filter(|p| p.iter().all(|c| c.is_finite()))
        };
        let (u, v) = (surface.u().domain(), surface.v().domain());
        let mut points = Vec::with_capacity(SAMPLES * SAMPLES);
        for i in 0..SAMPLES {
            for j in 0..SAMPLES {
                points.push(point(Location::Surface(at(u, i), at(v, j)))?);
            }
        }
        let edges = surface.edges()?;
        let sampled = CommonEdges::sampled(edges, &point)?;
        let edges = edges.iter().zip(sampled).map(|(edge, points)| {
            let direction = if edge.along_u { Direction::V } else { Direction::U };
            let curve = surface.isocurve(direction, edge.fixed).ok()?;
            let (low, high) = curve.hull_bounds();
            Some(Sampled { curve, points, low, high })
        });
        Some(Self { edges: edges.collect::<Option<_>>()?, points })
    }

    fn extent(&self) -> (Point, Point) {
        let first = self.points[0];
        self.points.iter().fold((first, first), |all, &p| around(all, (p, p)))
    }
}

/// An edge where it is in the scene.
struct Sampled {
    curve: Curve,
    points: [Point; SAMPLES],
    /// The box of its control vertices.
    low: Point,
    high: Point,
}

impl Sampled {
    /// Whether it is a pole, which is nobody's edge.
    fn is_point(&self, near: f64) -> bool {
        self.points.iter().all(|p| (p - self.points[0]).norm() <= near)
    }

    /// Whether it and another one are one edge or one is a part of the other, and whether they are so piece by piece: run through either way,
    /// with the same knots.
    fn common(&self, other: &Self, near: f64) -> Option<bool> {
        let together = |(a, b): (&Point, &Point)| (a - b).norm() <= near;
        let ahead = self.points.iter().zip(&other.points).all(together);
        let back = ahead || self.points.iter().rev().zip(&other.points).all(together);
        if back {
            return Some(self.is_alike(other, !ahead, near));
        }
        (self.is_on(other, near) || other.is_on(self, near)).then_some(false)
    }

    /// Whether all samples are on another edge. Those in the box are looked at, the middle first: where it is not there, no other is.
    fn is_on(&self, other: &Self, near: f64) -> bool {
        let within = |p: &Point| (0..3).all(|k| p[k] >= other.low[k] - near && p[k] <= other.high[k] + near);
        let on = |p: &Point| {
            let found = other.curve.closest(*p);
            found.is_ok_and(|found| found.distance <= near)
        };
        const FIRST: [usize; SAMPLES] = [4, 0, 8, 2, 6, 1, 3, 5, 7];
        self.points.iter().all(within) && FIRST.iter().all(|&k| on(&self.points[k]))
    }

    /// Whether two edges that are run through alike, or one `backward`, are cut into the same pieces with the same control vertices.
    fn is_alike(&self, other: &Self, backward: bool, near: f64) -> bool {
        let (a, b) = (self.curve.space(), other.curve.space());
        if a.degree() != b.degree() || a.is_periodic() != b.is_periodic() {
            return false;
        }
        let shares = |curve: &Curve, backward: bool| -> Vec<f64> {
            let ((start, end), flat) = (curve.domain(), curve.space().flat());
            let share = |t: &f64| (t - start) / (end - start);
            if backward {
                flat.iter().rev().map(|t| 1.0 - share(t)).collect()
            } else {
                flat.iter().map(share).collect()
            }
        };
        let (own, its) = (shares(&self.curve, false), shares(&other.curve, backward));
        let (n, m) = (self.curve.points().len(), other.curve.points().len());
        let vertex = |k: usize| if backward { n - 1 - k } else { k };
        let weight = |curve: &Curve, k: usize| curve.weights().map_or(1.0, |w| w[k]);
        let whole = weight(&self.curve, 0) / weight(&other.curve, vertex(0));
        n == m
            && own.len() == its.len()
            && own.iter().zip(&its).all(|(x, y)| (x - y).abs() <= NEAR)
            && (0..n).all(|k| {
                let (x, y) = (self.curve.points()[k], other.curve.points()[vertex(k)]);
                let (w, v) = (weight(&self.curve, k), whole * weight(&other.curve, vertex(k)));
                (x - y).norm() <= near && (w - v).abs() <= NEAR * w.max(v)
            })
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
        let diagonals = |scene: &Scene| {
            scene.joined().unwrap().into_iter().map(|j| j.map(|j| j.diagonal)).collect::<Vec<_>>()
        };
        assert_eq!(diagonals(&scene), [Some(5_f64.sqrt()), Some(5_f64.sqrt()), None]);
        let found = scene.joined().unwrap()[0].clone().unwrap();
        assert_eq!((found.beside, found.as_points), (vec![1], false));
        // What a transform brings there is there.
        scene.object_mut("corner").unwrap().transform =
            Some(nalgebra::Matrix4::new_translation(&crate::Vector::new(0.0, -1.0, 0.0)));
        assert_eq!(diagonals(&scene), [Some(10_f64.sqrt()); 3]);
    }

    #[test]
    fn a_pole_a_point_and_nothing_are_no_edges() {
        let mut scene = Scene::new();
        assert!(scene.joined().unwrap().is_empty());
        let tip = |z: f64| patch([[0.0; 3], [0.0; 3], [0.0, 1.0, z], [1.0, 0.0, z]]);
        scene.add(Object::new("a", Geometry::Surface(tip(1.0)))).unwrap();
        scene.add(Object::new("b", Geometry::Surface(tip(-1.0)))).unwrap();
        assert_eq!(scene.joined().unwrap(), [None, None]);
        let mut points = Scene::new();
        points.add(Object::new("a", Geometry::Surface(patch([[1.0; 3]; 4])))).unwrap();
        assert_eq!(points.joined().unwrap(), [None]);
    }
}
