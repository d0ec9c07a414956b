//! Subdivision once more, by lists of faces and nothing else: what the crate is compared with.

use std::collections::BTreeMap;

use loftsman_kernel::{Point, Vector};
use loftsman_subdivision::{BoundaryRule, Cage, Result};

/// A mesh with what is sharp.
#[derive(Debug, Clone, Default)]
pub(crate) struct Plain {
    pub(crate) points: Vec<Vector>,
    pub(crate) faces: Vec<Vec<usize>>,
    pub(crate) creases: BTreeMap<[usize; 2], f64>,
    pub(crate) corners: BTreeMap<usize, f64>,
    /// Whether a boundary vertex of one face is rounded.
    pub(crate) rounded: bool,
}

/// An edge with its number, its faces and its sharpness, which is infinite on the boundary.
struct Edge {
    number: usize,
    faces: Vec<usize>,
    sharpness: f64,
}

pub(crate) fn ends(a: usize, b: usize) -> [usize; 2] {
    [a.min(b), a.max(b)]
}

/// What is left of a sharpness a level on.
fn less(sharpness: f64) -> f64 {
    if sharpness >= 10.0 { f64::INFINITY } else { (sharpness - 1.0).max(0.0) }
}

impl Plain {
    pub(crate) fn of(cage: &Cage) -> Self {
        let topology = cage.topology();
        let mut plain = Self {
            points: cage.points().iter().map(|p| p.coords).collect(),
            faces: (0..topology.face_count())
                .map(|f| topology.face(f).iter().map(|&v| v as usize).collect())
                .collect(),
            rounded: cage.boundary() == BoundaryRule::EdgeOnly,
            ..Self::default()
        };
        for e in (0..topology.edge_count()).filter(|&e| cage.crease(e) > 0.0) {
            let [a, b] = topology.edge(e).unwrap().map(|v| v as usize);
            plain.creases.insert(ends(a, b), cage.crease(e));
        }
        for v in (0..plain.points.len()).filter(|&v| cage.corner(v) > 0.0) {
            plain.corners.insert(v, cage.corner(v));
        }
        plain
    }

    pub(crate) fn cage(&self) -> Result<Cage> {
        let points = self.points.iter().map(|p| Point::from(*p)).collect();
        let rule = if self.rounded { BoundaryRule::EdgeOnly } else { BoundaryRule::EdgeAndCorner };
        let mut cage = Cage::new(points, &self.faces)?.with_boundary(rule);
        for (&[a, b], &sharpness) in &self.creases {
            cage = cage.with_crease(a, b, sharpness)?;
        }
        for (&v, &sharpness) in &self.corners {
            cage = cage.with_corner(v, sharpness)?;
        }
        Ok(cage)
    }

    /// The faces at each edge.
    pub(crate) fn edges(&self) -> BTreeMap<[usize; 2], Vec<usize>> {
        let mut all: BTreeMap<[usize; 2], Vec<usize>> = BTreeMap::new();
        for (f, face) in self.faces.iter().enumerate() {
            for k in 0..face.len() {
                all.entry(ends(face[k], face[(k + 1) % face.len()])).or_default().push(f);
            }
        }
        all
    }

    pub(crate) fn middle(&self, face: &[usize]) -> Vector {
        face.iter().map(|&v| self.points[v]).sum::<Vector>() / face.len() as f64
    }

    /// Catmull and Clark's next mesh: vertices, then those of edges, then those of faces.
    pub(crate) fn refined(&self) -> Self {
        let count = self.points.len();
        let mut edges: BTreeMap<[usize; 2], Edge> = BTreeMap::new();
        for (number, (ends, faces)) in self.edges().into_iter().enumerate() {
            let own = self.creases.get(&ends).copied().unwrap_or(0.0);
            let sharpness = if faces.len() < 2 { f64::INFINITY } else { own };
            edges.insert(ends, Edge { number, faces, sharpness });
        }
        let middles: Vec<Vector> = self.faces.iter().map(|f| self.middle(f)).collect();
        let mut around: Vec<Vec<([usize; 2], f64)>> = vec![Vec::new(); count];
        for (ends, edge) in &edges {
            ends.iter().for_each(|&v| around[v].push((*ends, edge.sharpness)));
        }
        let mut at_vertex: Vec<Vec<usize>> = vec![Vec::new(); count];
        for (f, face) in self.faces.iter().enumerate() {
            face.iter().for_each(|&v| at_vertex[v].push(f));
        }
        let mut fine = Self { rounded: self.rounded, ..Self::default() };
        for v in 0..count {
            let is_end = at_vertex[v].len() == 1 && !self.rounded;
            let own = if is_end { f64::INFINITY } else { self.corners.get(&v).copied().unwrap_or(0.0) };
            fine.points.push(self.vertex_point(v, own, &around[v], &at_vertex[v], &middles));
            if less(own) > 0.0 && !is_end {
                fine.corners.insert(v, less(own));
            }
        }
        for (&[a, b], edge) in &edges {
            let straight = (self.points[a] + self.points[b]) / 2.0;
            fine.points.push(match edge.faces[..] {
                [f, g] => {
                    let smooth = (straight * 2.0 + middles[f] + middles[g]) / 4.0;
                    let s = edge.sharpness.min(1.0);
                    smooth * (1.0 - s) + straight * s
                }
                _ => straight,
            });
            if edge.faces.len() == 2 && less(edge.sharpness) > 0.0 {
                for v in [a, b] {
                    fine.creases.insert(ends(v, count + edge.number), less(edge.sharpness));
                }
            }
        }
        let first = fine.points.len();
        fine.points.extend(&middles);
        for (f, face) in self.faces.iter().enumerate() {
            let n = face.len();
            let edge = |k: usize| count + edges[&ends(face[k % n], face[(k + 1) % n])].number;
            fine.faces.extend((0..n).map(|k| vec![face[k], edge(k), first + f, edge(k + n - 1)]));
        }
        fine
    }

    /// DeRose, Kass and Truong (1998), as OpenSubdiv takes what is fractional: where the rule is another one a level on, the mean of both rules by
    /// the mean of the sharpnesses that end.
    fn vertex_point(
        &self,
        v: usize,
        own: f64,
        edges: &[([usize; 2], f64)],
        faces: &[usize],
        middles: &[Vector],
    ) -> Vector {
        let p = self.points[v];
        let n = edges.len() as f64;
        let other = |e: &[usize; 2]| self.points[e[0] + e[1] - v];
        let rule = |own: f64, sharp: &[&([usize; 2], f64)]| match sharp {
            _ if own > 0.0 || sharp.len() > 2 => p,
            [a, b] => (p * 6.0 + other(&a.0) + other(&b.0)) / 8.0,
            _ => {
                let face = faces.iter().map(|&f| middles[f]).sum::<Vector>() / n;
                let edge = edges.iter().map(|(e, _)| (p + other(e)) / 2.0).sum::<Vector>() / n;
                (face + edge * 2.0 + p * (n - 3.0)) / n
            }
        };
        let now: Vec<_> = edges.iter().filter(|e| e.1 > 0.0).collect();
        let then: Vec<_> = edges.iter().filter(|e| less(e.1) > 0.0).collect();
        let kind = |own: f64, sharp: usize| if own > 0.0 { 3 } else { sharp.clamp(1, 3) };
        if kind(own, now.len()) == kind(less(own), then.len()) {
            return rule(own, &now);
        }
        let ending: Vec<f64> =
            edges.iter().map(|e| e.1).chain([own]).filter(|s| *s > 0.0 && less(*s) == 0.0).collect();
        let share = (ending.iter().sum::<f64>() / ending.len() as f64).min(1.0);
        rule(own, &now) * share + rule(less(own), &then) * (1.0 - share)
    }

    /// Doo and Sabin's next mesh: a vertex for each corner; faces of faces, of inner edges, of inner vertices.
    pub(crate) fn dual(&self) -> Self {
        let mut fine = Self::default();
        let mut corner: BTreeMap<(usize, usize), usize> = BTreeMap::new();
        for (f, face) in self.faces.iter().enumerate() {
            let n = face.len();
            for (i, &v) in face.iter().enumerate() {
                let weight = |j: usize| match j {
                    0 => (n as f64 + 5.0) / (4.0 * n as f64),
                    _ => (3.0 + 2.0 * (std::f64::consts::TAU * j as f64 / n as f64).cos()) / (4.0 * n as f64),
                };
                corner.insert((f, v), fine.points.len());
                fine.points.push((0..n).map(|j| self.points[face[(i + j) % n]] * weight(j)).sum());
            }
            fine.faces.push(face.iter().map(|&v| corner[&(f, v)]).collect());
        }
        let mut after: BTreeMap<(usize, usize), usize> = BTreeMap::new();
        let edges = self.edges();
        for (&[a, b], faces) in edges.iter().filter(|(_, faces)| faces.len() == 2) {
            let runs = |f: usize| {
                let face = &self.faces[f];
                let k = face.iter().position(|&v| v == a).unwrap();
                face[(k + 1) % face.len()] == b
            };
            let (f, g) = if runs(faces[0]) { (faces[0], faces[1]) } else { (faces[1], faces[0]) };
            fine.faces.push(vec![corner[&(f, b)], corner[&(f, a)], corner[&(g, a)], corner[&(g, b)]]);
            // Counterclockwise round each end the face after the other.
            after.insert((g, a), f);
            after.insert((f, b), g);
        }
        for v in 0..self.points.len() {
            let own: Vec<usize> = (0..self.faces.len()).filter(|f| self.faces[*f].contains(&v)).collect();
            if own.len() < 3 || !own.iter().all(|&f| after.contains_key(&(f, v))) {
                continue;
            }
            let mut ring = vec![own[0]];
            while after[&(ring[ring.len() - 1], v)] != own[0] {
                ring.push(after[&(ring[ring.len() - 1], v)]);
            }
            fine.faces.push(ring.iter().map(|&f| corner[&(f, v)]).collect());
        }
        fine
    }

    /// Area and volume of the faces, each as triangles round its middle.
    pub(crate) fn measures(&self) -> [f64; 2] {
        let (mut area, mut volume) = (0.0, 0.0);
        for face in &self.faces {
            let middle = self.middle(face);
            for k in 0..face.len() {
                let (a, b) = (self.points[face[k]], self.points[face[(k + 1) % face.len()]]);
                area += 0.5 * (a - middle).cross(&(b - middle)).norm();
                volume += middle.dot(&a.cross(&b)) / 6.0;
            }
        }
        [area, volume]
    }
}
