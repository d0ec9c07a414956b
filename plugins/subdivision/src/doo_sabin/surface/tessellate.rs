//! A Doo-Sabin surface as triangles.

use std::collections::BTreeMap;

use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::mesh::{Layer, Mesh};
use loftsman_kernel::plugin::{Chord, Drawn, Faceted, Fineness};
use loftsman_kernel::shape::Location;
use loftsman_kernel::{Point, Vector};

use super::node::{Node, basis};
use super::{DooSabinSurface, beside};
use crate::doo_sabin::refine::refine;
use crate::surface::refused;
use crate::topology::NONE;

/// Points, at most.
const MOST: usize = 1 << 21;
/// Points beyond which nothing is halved for the sake of the angle.
const MOST_FOR_ANGLE: usize = 1 << 17;
/// A neighbourhood that is smaller than this part of the chord is not looked into.
const ENOUGH: f64 = 0.01;
/// Levels that are looked into, at most.
const LEVELS: u32 = 56;

impl DooSabinSurface {
    /// The neighbourhood of each face.
    pub(super) fn nodes(&self) -> crate::error::Result<Vec<Node<Vector>>> {
        let fine = refine(&self.cage)?;
        let point = |v: u32| fine.points()[v as usize].coords;
        let node =
            |&half: &u32| Node { rings: self.rings(half).map(|ring| ring.into_iter().map(point).collect()) };
        Ok(self.layout.corners.iter().map(node).collect())
    }
}

impl Node<Vector> {
    /// The point at a place, and the normal there, of any length.
    fn at(&self, u: f64, v: f64) -> (Vector, Vector) {
        for (corner, (a, b)) in [(0, (0.0, 0.0)), (2, (1.0, 1.0))] {
            if self.rings[corner].len() != 4 && (u, v) == (a, b) {
                let (point, [along_u, along_v]) = self.corner(corner);
                return (point, along_u.cross(&along_v));
            }
        }
        let Some((piece, (u, v), _)) = self.piece((u, v), LEVELS) else {
            return (self.rings[0][0], Vector::zeros());
        };
        let net = piece.net();
        let sum = |a: [f64; 3], b: [f64; 3]| {
            net.iter().enumerate().fold(Vector::zeros(), |sum, (k, p)| sum + *p * (a[k / 3] * b[k % 3]))
        };
        let (du, dv) = (sum(basis(u, 1), basis(v, 0)), sum(basis(u, 0), basis(v, 1)));
        (sum(basis(u, 0), basis(v, 0)), du.cross(&dv))
    }

    /// The limits of the four corners.
    fn corners(&self) -> [Vector; 4] {
        [0, 1, 2, 3].map(|k| self.corner(k).0)
    }

    /// A bound of `|S - L|` over the piece, `L` linear on the two halves of its square (below and above `u = v`) between the corners: so one of the
    /// distance of the piece from its two triangles.
    ///
    /// Regular: linear interpolation leaves at most `(|S_uu| + 2 |S_uv| + |S_vv|) / 8`, and derivatives of a spline are within those of its
    /// vertices. Else `L` differs from what is linear on the quarters by what it is off in their corners, and the rest is the quarters'; one
    /// that is small lies in the hull of its vertices, as do its corners.
    fn beyond(&self, small: f64, level: u32) -> f64 {
        if self.is_regular() {
            let net = self.net();
            let p = |i: usize, j: usize| *net[3 * i + j];
            let most = |all: &mut dyn Iterator<Item = Vector>| all.fold(0.0, |m: f64, v| larger(m, v.norm()));
            let uu = most(&mut (0..3).map(|j| p(0, j) - p(1, j) * 2.0 + p(2, j)));
            let vv = most(&mut (0..3).map(|i| p(i, 0) - p(i, 1) * 2.0 + p(i, 2)));
            let uv = most(&mut (0..4).map(|k| {
                let (i, j) = (k / 2, k % 2);
                p(i, j) - p(i + 1, j) - p(i, j + 1) + p(i + 1, j + 1)
            }));
            return (uu + 2.0 * uv + vv) / 8.0;
        }
        let [a, b, c, d] = self.corners();
        let hull = self.rings.iter().flatten().fold(0.0, |m: f64, p| larger(m, (p - a).norm()));
        if 2.0 * hull <= small || level >= LEVELS {
            return 2.0 * hull;
        }
        let quarters = self.quarters();
        let [of_a, of_b, of_c, of_d] = quarters.each_ref().map(Node::corners);
        // The middles of the sides, and the middle, which is on the diagonal.
        let off = [
            of_a[1] - (a + b) * 0.5,
            of_b[2] - (b + c) * 0.5,
            of_c[3] - (c + d) * 0.5,
            of_d[0] - (d + a) * 0.5,
            of_a[2] - (a + c) * 0.5,
        ];
        let off = off.iter().fold(0.0, |m: f64, v| larger(m, v.norm()));
        off + quarters.iter().fold(0.0, |m: f64, q| larger(m, q.beyond(small, level + 1)))
    }

    /// The same over each of `4^level` parts, the largest.
    fn beyond_parts(&self, parts: u32, small: f64) -> f64 {
        if parts == 0 {
            return self.beyond(small, 0);
        }
        self.quarters().iter().fold(0.0, |m: f64, q| larger(m, q.beyond_parts(parts - 1, small)))
    }
}

/// The larger of two; infinite where one is no number.
fn larger(a: f64, b: f64) -> f64 {
    if b.is_nan() { f64::INFINITY } else { a.max(b) }
}

/// The states of a surface as the same triangles: every face a grid of `2^k × 2^k` quads, in two triangles each, `k` the least with which the
/// triangles are within the chord, by a bound, and turn by no more than the angle as far as that takes no more than some hundred thousand
/// points. Nothing gapes: neighbours have the points of their side in common.
///
/// # Errors
/// [`Error::NoExtent`] where all is one point; when there is no state, the states are different surfaces, the fineness is not positive,
/// or more than two million vertices are needed.
pub(super) fn tessellate(states: &[&DooSabinSurface], fineness: &Fineness) -> Result<Faceted> {
    let Some(first) = states.first() else {
        return Err(Error::Invalid("there is no state of the surface to tessellate".into()));
    };
    let alike = |s: &&DooSabinSurface| {
        s.cage.topology() == first.cage.topology() && s.layout.corners == first.layout.corners
    };
    if !states.iter().all(alike) {
        return Err(Error::Invalid(
            "the states of the surface have different faces: they are not one surface".into(),
        ));
    }
    let positive = |x: f64| x.is_finite() && x > 0.0;
    let (Chord::Absolute(chord) | Chord::Relative(chord)) = fineness.chord;
    if !positive(chord) || !positive(fineness.angle) {
        return Err(Error::Invalid(
            "the chord and the angle of a tessellation must be positive and finite".into(),
        ));
    }
    let nodes: Vec<Vec<Node<Vector>>> =
        states.iter().map(|s| s.nodes().map_err(refused)).collect::<Result<_>>()?;
    let sizes: Vec<f64> = nodes.iter().map(|nodes| size(nodes)).collect();
    let largest = sizes.iter().fold(0.0, |m: f64, s| larger(m, *s));
    if largest <= 0.0 {
        return Err(Error::NoExtent("all of the surface is one point".into()));
    }
    if !largest.is_finite() {
        return Err(Error::Invalid("a coordinate of the surface is too large to be measured".into()));
    }
    let chords: Vec<f64> = sizes
        .iter()
        .map(|size| match fineness.chord {
            Chord::Absolute(chord) => chord,
            Chord::Relative(part) => part * size,
        })
        .collect();
    let tolerance = chords.iter().copied().fold(0.0, f64::max);
    let count = first.layout.corners.len();
    let points = |level: u32| count.saturating_mul(1 << (2 * level.min(20)));
    let mut level = 0;
    let mut error;
    loop {
        if points(level) > MOST {
            return Err(Error::Invalid(format!(
                "more than {MOST} points would be needed: allow a larger chord than {tolerance}"
            )));
        }
        error = 0.0_f64;
        let mut fits = true;
        for (nodes, chord) in nodes.iter().zip(&chords).filter(|(_, chord)| **chord > 0.0) {
            let worst = nodes.iter().fold(0.0, |m: f64, n| larger(m, n.beyond_parts(level, ENOUGH * chord)));
            fits &= worst <= *chord;
            error = error.max(worst);
        }
        if fits {
            break;
        }
        level += 1;
    }
    let mut mesh = Grid::new(first, level);
    mesh.place(&nodes);
    while mesh.turns() > fineness.angle && points(level + 1) <= MOST_FOR_ANGLE && error > 1e-9 * largest {
        level += 1;
        mesh = Grid::new(first, level);
        mesh.place(&nodes);
        error = nodes.iter().zip(&chords).filter(|(_, chord)| **chord > 0.0).fold(
            0.0,
            |m: f64, (nodes, chord)| {
                nodes.iter().fold(m, |m, n| larger(m, n.beyond_parts(level, ENOUGH * chord)))
            },
        );
    }
    mesh.finish(tolerance, error)
}

/// The diagonal of the box of a surface's corners and of the vertices round them: at least its size.
fn size(nodes: &[Node<Vector>]) -> f64 {
    let all = || nodes.iter().flat_map(Node::corners);
    let Some(start) = all().next() else { return 0.0 };
    let (low, high) = all().fold((start, start), |(low, high), p| (low.inf(&p), high.sup(&p)));
    (high - low).norm()
}

/// The same grid on every face, points on sides in common.
struct Grid {
    per_side: usize,
    faces: Vec<[usize; 4]>,
    places: Vec<(usize, f64, f64)>,
    states: Vec<Vec<Point>>,
    normals: Vec<Vector>,
}

/// What a point belongs to: a face of the surface, or a side that it has in common with others; points where sides meet by the face, edge
/// or vertex of the cage.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
enum Name {
    OfFace(u32),
    OfEdge(u32),
    OfVertex(u32),
    /// On the side between two corners of one face, or of one vertex, that of the second corner.
    Along(u32, bool, usize),
    Inside(u32, usize, usize),
}

impl Grid {
    fn new(surface: &DooSabinSurface, level: u32) -> Self {
        let (topology, layout) = (surface.cage.topology(), &surface.layout);
        let n = 1_usize << level;
        let mut numbers: BTreeMap<Name, usize> = BTreeMap::new();
        let (mut faces, mut places) = (Vec::new(), Vec::new());
        let step = 1.0 / n as f64;
        for (face, &half) in layout.corners.iter().enumerate() {
            let before = topology.previous(half);
            let [_, _, over, after] = beside(&surface.cage, half);
            let mut number = |i: usize, j: usize| {
                let name = match (i, j) {
                    (0, 0) => Name::OfFace(topology.face_of(half)),
                    _ if (i, j) == (n, 0) => Name::OfEdge(topology.edge_of(before)),
                    _ if (i, j) == (n, n) => Name::OfVertex(topology.origin(half)),
                    _ if (i, j) == (0, n) => Name::OfEdge(topology.edge_of(half)),
                    // Side v = 0 of a corner is side u = 0 of the one before it, and side u = 1 is side v = 1 of the one clockwise round
                    // the vertex.
                    (i, 0) => Name::Along(half, false, i),
                    (0, j) => Name::Along(after.unwrap_or(NONE), false, j),
                    _ if i == n => Name::Along(half, true, j),
                    _ if j == n => Name::Along(over.unwrap_or(NONE), true, i),
                    (i, j) => Name::Inside(half, i, j),
                };
                let next = places.len();
                let number = *numbers.entry(name).or_insert(next);
                if number == next {
                    places.push((face, i as f64 * step, j as f64 * step));
                }
                number
            };
            let mut before: Vec<usize> = (0..=n).map(|j| number(0, j)).collect();
            for i in 1..=n {
                let row: Vec<usize> = (0..=n).map(|j| number(i, j)).collect();
                for j in 0..n {
                    faces.push([before[j], row[j], row[j + 1], before[j + 1]]);
                }
                before = row;
            }
        }
        Self { per_side: n, faces, places, states: Vec::new(), normals: Vec::new() }
    }

    fn place(&mut self, states: &[Vec<Node<Vector>>]) {
        for (k, nodes) in states.iter().enumerate() {
            let both = self.places.iter().map(|&(face, u, v)| nodes[face].at(u, v));
            let (points, normals): (Vec<Point>, Vec<Vector>) = both.map(|(p, n)| (Point::from(p), n)).unzip();
            if k == 0 {
                self.normals = normals;
            }
            self.states.push(points);
        }
    }

    /// The largest angle between the normals of the two triangles of a quad and of neighbours in a row.
    fn turns(&self) -> f64 {
        let Some(points) = self.states.first() else { return 0.0 };
        let normal = |f: &[usize; 4]| {
            let [a, b, c, d] = f.map(|k| points[k]);
            (c - a).cross(&(d - b))
        };
        let mut most = 0.0_f64;
        for pair in self
            .faces
            .windows(2)
            .enumerate()
            .filter(|(k, _)| (k + 1) % self.per_side != 0 || self.per_side == 1)
        {
            let (a, b) = (normal(&pair.1[0]), normal(&pair.1[1]));
            if self.per_side > 1 && a.norm() > 0.0 && b.norm() > 0.0 {
                most = most.max(a.cross(&b).norm().atan2(a.dot(&b)));
            }
        }
        // A single quad on each face: its corners' normals say how it turns.
        for f in &self.faces {
            for k in 0..4 {
                let (a, b) = (self.normals[f[k]], self.normals[f[(k + 1) % 4]]);
                if a.norm() > 0.0 && b.norm() > 0.0 {
                    most = most.max(a.cross(&b).norm().atan2(a.dot(&b)));
                }
            }
        }
        most
    }

    fn finish(self, tolerance: f64, error: f64) -> Result<Faceted> {
        let triangles: Vec<[usize; 3]> =
            self.faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let Some(points) = self.states.first() else {
            return Err(Error::Invalid("there is no state of the surface to tessellate".into()));
        };
        let mut mesh = Mesh::new(points.clone(), &triangles)?;
        let normals: Option<Vec<Vector>> = self.normals.iter().map(|n| n.try_normalize(0.0)).collect();
        mesh.normals = normals.map_or_else(Layer::none, Layer::per_point);
        let places = self.places.iter().map(|&(face, u, v)| Location::Face(face as u32, u, v)).collect();
        Ok(Faceted {
            drawn: Drawn::Mesh(mesh),
            states: self.states,
            tolerance,
            error,
            certified: true,
            places,
        })
    }
}
