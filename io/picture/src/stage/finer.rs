//! Triangles of a plug-in's surface divided until colours can be painted between their corners.

use std::collections::HashMap;
use std::sync::Arc;

use loftsman_kernel::Vector;
use loftsman_kernel::shape::{Derivative, Location};

use super::laid::{Laid, parameters};
use super::shell::{Edge, Shell, Skin, pair};

/// Sides that are longer are halved, in units of the stage: some 2 mm of a usual page.
const LONGEST: f64 = 0.04;
/// No more is halved where there are so many triangles, and no side oftener: it is a part of a shape that goes once across the page.
const MOST: usize = 1 << 18;
const OFTEN: usize = 12;

/// The same faces in triangles none of whose sides is long, each new corner on the surface itself; `None` where they are laid over none. A side is
/// halved for the triangles on both sides of it, so that nothing gapes.
pub(crate) fn finer(shell: &Shell) -> Option<Shell> {
    let mut all = Finer::new(shell)?;
    for _ in 0..OFTEN {
        if all.skin.triangles.len() > MOST || !all.halve() {
            break;
        }
    }
    let Finer { skin, points, normals, laid, .. } = all;
    Some(Shell { skin: Arc::new(skin), points, normals, laid: Some(laid) })
}

/// A corner of a triangle: its point and its place.
type Corner = [u32; 2];

struct Finer {
    skin: Skin,
    points: Vec<Vector>,
    normals: Vec<Vector>,
    laid: Laid,
    /// The points in the middles of sides, by their ends; the places there; and the first of all points there, by the first ones of both ends.
    middles: [HashMap<(u32, u32), u32>; 3],
}

impl Finer {
    fn new(shell: &Shell) -> Option<Self> {
        Some(Self {
            skin: Skin::clone(&shell.skin),
            points: shell.points.clone(),
            normals: shell.normals.clone(),
            laid: shell.laid.clone()?,
            middles: Default::default(),
        })
    }

    /// Halves all sides that are too long; whether there was one.
    fn halve(&mut self) -> bool {
        self.middles = Default::default();
        let (triangles, corners) =
            (std::mem::take(&mut self.skin.triangles), std::mem::take(&mut self.laid.corners));
        let slots = std::mem::take(&mut self.skin.slots);
        let mut any = false;
        for ((triangle, places), slot) in triangles.into_iter().zip(corners).zip(slots) {
            let all = [0, 1, 2].map(|k| [triangle[k], places[k]]);
            let middles = [0, 1, 2].map(|k| self.middle(all[k], all[(k + 1) % 3]));
            any |= middles.iter().any(Option::is_some);
            for part in self.parts(all, middles) {
                self.skin.triangles.push(part.map(|corner| corner[0]));
                self.laid.corners.push(part.map(|corner| corner[1]));
                self.skin.slots.push(slot);
            }
        }
        for edge in &mut self.skin.edges {
            *edge = through(edge, &self.middles[2], &self.laid.origins);
        }
        any
    }

    /// The parts of a triangle whose sides have middles, or have none.
    fn parts(&self, all: [Corner; 3], middles: [Option<Corner>; 3]) -> Vec<[Corner; 3]> {
        let count = middles.iter().flatten().count();
        // Turned so that with one middle it is that of the first side, and with two the last side has none.
        let turn = match count {
            1 => (0..3).find(|&k| middles[k].is_some()),
            2 => (0..3).find(|&k| middles[(k + 2) % 3].is_none()),
            _ => None,
        };
        let at = |k: usize| (k + turn.unwrap_or(0)) % 3;
        let [a, b, c] = [0, 1, 2].map(|k| all[at(k)]);
        match [0, 1, 2].map(|k| middles[at(k)]) {
            [Some(p), Some(q), Some(r)] => vec![[a, p, r], [p, b, q], [r, q, c], [p, q, r]],
            [Some(p), Some(q), None] => {
                let length = |one: Corner, other: Corner| {
                    (self.points[one[0] as usize] - self.points[other[0] as usize]).norm()
                };
                let rest = if length(a, q) <= length(p, c) {
                    [[a, p, q], [a, q, c]]
                } else {
                    [[a, p, c], [p, q, c]]
                };
                vec![[p, b, q], rest[0], rest[1]]
            }
            [Some(p), None, None] => vec![[a, p, c], [p, b, c]],
            _ => vec![all],
        }
    }

    /// The middle of a side that is too long.
    fn middle(&mut self, one: Corner, other: Corner) -> Option<Corner> {
        let [a, b] = [one, other].map(|corner| self.points[corner[0] as usize]);
        if (a - b).norm() <= LONGEST {
            return None;
        }
        let at = self.between(one[1], other[1])?;
        let place = *self.middles[1].entry(pair(one[1], other[1])).or_insert_with(|| {
            self.laid.places.push(at);
            self.laid.places.len() as u32 - 1
        });
        if let Some(&point) = self.middles[0].get(&pair(one[0], other[0])) {
            return Some([point, place]);
        }
        let point = self.points.len() as u32;
        self.middles[0].insert(pair(one[0], other[0]), point);
        let ends = pair(self.laid.origins[one[0] as usize], self.laid.origins[other[0] as usize]);
        let origin = *self.middles[2].entry(ends).or_insert(point);
        let position = if origin == point {
            let value = self.laid.surface().and_then(|shape| shape.value(at, Derivative::POSITION).ok());
            value.filter(|p| p.iter().all(|c| c.is_finite())).unwrap_or(0.5 * (a + b))
        } else {
            // What is doubled is in one place to the last bit.
            self.points[origin as usize]
        };
        let [m, n] = [one, other].map(|corner| self.normals[corner[0] as usize]);
        let mean = (m + n).try_normalize(0.0).unwrap_or(m);
        self.points.push(position);
        self.normals.push(self.laid.normal(at, &mean).unwrap_or(mean));
        self.laid.origins.push(origin);
        Some([point, place])
    }

    /// The place between two others; `None` where they are on two faces.
    fn between(&self, one: u32, other: u32) -> Option<Location> {
        let [one, other] = [one, other].map(|k| self.laid.places[k as usize]);
        let ((face, a), (of, b)) = (parameters(one)?, parameters(other)?);
        (face == of).then(|| self.laid.clamped(one, [0, 1].map(|k| 0.5 * (a[k] + b[k]))))
    }
}

/// An edge that goes through the middles of its segments.
fn through(edge: &Edge, middles: &HashMap<(u32, u32), u32>, origins: &[u32]) -> Edge {
    let mut points = Vec::with_capacity(edge.points.len());
    for (k, &point) in edge.points.iter().enumerate() {
        if k > 0 {
            let [a, b] = [edge.points[k - 1], point].map(|p| origins[p as usize]);
            points.extend(middles.get(&pair(a, b)));
        }
        points.push(point);
    }
    Edge { kind: edge.kind, points, beside: edge.beside.clone() }
}

#[cfg(test)]
mod tests {
    use loftsman_kernel::Point;
    use loftsman_kernel::plugin::{Chord, CustomShape, Drawn, Fineness};
    use loftsman_subdivision::{Cage, SubdivisionSurface};

    use super::*;

    /// A cube with sharp edges round one of its faces.
    fn cube() -> CustomShape {
        let corner = |k: usize| Point::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let mut cage = Cage::new((0..8).map(corner).collect(), &faces).unwrap();
        for (a, b) in [(4, 5), (5, 7), (7, 6), (6, 4)] {
            cage = cage.with_crease(a, b, f64::INFINITY).unwrap();
        }
        SubdivisionSurface::new(cage).unwrap().into()
    }

    #[test]
    fn finer_triangles_lie_on_the_surface_and_close() {
        let shape = cube();
        let found = shape.tessellate(&Fineness { chord: Chord::Relative(1e-2), angle: 1.0 }).unwrap();
        let Drawn::Mesh(mesh) = found.drawn else { panic!("a surface") };
        let shell = Laid::shell(shape.clone(), mesh, &found.corners).unwrap().unwrap();
        let fine = finer(&shell).unwrap();
        let laid = fine.laid.as_ref().unwrap();
        assert!(fine.skin.triangles.len() > 2 * shell.skin.triangles.len());
        assert_eq!(fine.skin.triangles.len(), laid.corners.len());
        assert_eq!(fine.points.len(), laid.origins.len());
        let mut sides = std::collections::BTreeMap::new();
        for (triangle, own) in fine.skin.triangles.iter().zip(&laid.corners) {
            for k in 0..3 {
                let [a, b] = [triangle[k], triangle[(k + 1) % 3]].map(|p| laid.origins[p as usize]);
                *sides.entry(pair(a, b)).or_insert(0) += 1;
                assert!((fine.points[a as usize] - fine.points[b as usize]).norm() <= LONGEST);
                let at = laid.places[own[k] as usize];
                let there = shape.shape().unwrap().value(at, Derivative::POSITION).unwrap();
                assert!((there - fine.points[triangle[k] as usize]).norm() < 1e-12, "{at}");
            }
        }
        assert!(sides.values().all(|count| *count == 2), "a closed surface has two triangles at each side");
        // Edges go along sides still, and the crease has two normals all along.
        for edge in &fine.skin.edges {
            assert!(edge.points.windows(2).all(|s| sides.contains_key(&pair(s[0], s[1]))));
        }
        let doubled = (0..).zip(&laid.origins).filter(|(k, origin)| k != *origin).count();
        let sharp = fine.skin.edges.iter().filter(|edge| edge.kind == super::super::shell::Kind::Sharp);
        let along: usize = sharp.map(|edge| edge.points.len() - 1).sum();
        assert_eq!((doubled, along > 80), (along, true));
    }
}
