//! The faces round one vertex, and how rows over them go back through refinement.
//!
//! What lies round a vertex after a refinement is made of what lay round it before, so that the limit there is known from a matrix
//! as large as its ring. The matrix is never made: a row over the refined ring is taken back to the ring before, in time linear in the
//! number of faces.

use loftsman_kernel::{Point, Vector};
use smallvec::SmallVec;

use super::rules::{Kind, VertexRule, kind, vertex_rule};
use crate::cage::{Cage, INFINITELY_SHARP, decayed};
use crate::row::Row;

/// A few numbers, on the stack for usual valences.
pub(super) type Few = SmallVec<[f64; 12]>;

/// A row over the ring of a vertex: coefficients of the vertex, of its neighbours along edges, and for each face of the vertex across
/// (or, on the way, of the point of the face).
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Mask {
    pub(super) vertex: f64,
    pub(super) edges: Few,
    pub(super) faces: Few,
}

impl Mask {
    pub(super) fn zero(edges: usize, faces: usize) -> Self {
        Self { vertex: 0.0, edges: Few::from_elem(0.0, edges), faces: Few::from_elem(0.0, faces) }
    }

    /// The sum of all coefficients.
    pub(super) fn sum(&self) -> f64 {
        self.vertex + self.edges.iter().sum::<f64>() + self.faces.iter().sum::<f64>()
    }

    pub(super) fn scale(&mut self, factor: f64) {
        self.vertex *= factor;
        self.edges.iter_mut().chain(&mut self.faces).for_each(|c| *c *= factor);
    }

    /// The largest difference from another.
    pub(super) fn distance(&self, other: &Self) -> f64 {
        let pairs = self.edges.iter().zip(&other.edges).chain(self.faces.iter().zip(&other.faces));
        pairs.fold((self.vertex - other.vertex).abs(), |most, (a, b)| most.max((a - b).abs()))
    }

    /// The row over the vertices and face points of the ring before, from one over the ring that it is refined to.
    pub(super) fn back(&self, sharpness: &Sharpness) -> Self {
        let (n, k) = (self.edges.len(), self.faces.len());
        let VertexRule { smooth, crease, corner, ends } = sharpness.rule();
        let mut before = Self::zero(n, k);
        before.faces.copy_from_slice(&self.faces);
        before.vertex += self.vertex * (corner + 0.75 * crease);
        if crease > 0.0 {
            for end in ends {
                before.edges[end] += self.vertex * crease / 8.0;
            }
        }
        if smooth > 0.0 {
            let count = n as f64;
            before.vertex += self.vertex * smooth * (count - 2.0) / count;
            let each = self.vertex * smooth / (count * count);
            before.edges.iter_mut().chain(&mut before.faces).for_each(|c| *c += each);
        }
        for (i, (&weight, &sharp)) in self.edges.iter().zip(&sharpness.edges).enumerate() {
            let smooth = 1.0 - sharp.min(1.0);
            let own = weight * (0.5 - 0.25 * smooth);
            before.vertex += own;
            before.edges[i] += own;
            if smooth > 0.0 {
                let each = 0.25 * weight * smooth;
                before.faces[i] += each;
                before.faces[if i == 0 { k - 1 } else { i - 1 }] += each;
            }
        }
        before
    }

    /// The same over the vertices across, where faces are quads: the point of a face is the mean of its corners.
    pub(super) fn across(mut self) -> Self {
        let n = self.edges.len();
        for (i, face) in self.faces.iter_mut().enumerate() {
            *face *= 0.25;
            self.vertex += *face;
            self.edges[i] += *face;
            self.edges[(i + 1) % n] += *face;
        }
        self
    }
}

/// What is sharp round a vertex: itself, and its edges, the boundary infinitely.
#[derive(Debug, Clone)]
pub(super) struct Sharpness {
    pub(super) vertex: f64,
    pub(super) edges: Few,
}

impl Sharpness {
    pub(super) fn rule(&self) -> VertexRule {
        vertex_rule(self.vertex, self.edges.iter().copied())
    }

    /// What is left after one refinement.
    pub(super) fn decayed(&self) -> Self {
        Self { vertex: decayed(self.vertex), edges: self.edges.iter().map(|&s| decayed(s)).collect() }
    }

    /// The number of refinements after which nothing changes any more: at most ten.
    pub(super) fn steps(&self) -> usize {
        let finite = |s: &&f64| **s < INFINITELY_SHARP;
        self.edges.iter().chain([&self.vertex]).filter(finite).fold(0.0, |most: f64, s| most.max(s.ceil()))
            as usize
    }
}

/// What a vertex is in the limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Limit {
    /// Smooth.
    Smooth,
    /// The end of a crease along this edge.
    Dart(usize),
    /// On a crease along these two edges.
    Crease([usize; 2]),
    /// A corner.
    Corner,
}

/// The faces round a vertex.
#[derive(Debug, Clone)]
pub(super) struct Ring<'a> {
    cage: &'a Cage,
    vertex: usize,
    halves: SmallVec<[u32; 12]>,
    pub(super) sharpness: Sharpness,
}

impl<'a> Ring<'a> {
    pub(super) fn new(cage: &'a Cage, vertex: usize) -> Self {
        let topology = cage.topology();
        let edges = topology.vertex_edges(vertex).map(|edge| cage.sharpness(edge as usize)).collect();
        let sharpness = Sharpness { vertex: cage.vertex_sharpness(vertex), edges };
        Self { cage, vertex, halves: topology.around(vertex).collect(), sharpness }
    }

    /// The numbers of edges and faces.
    pub(super) fn size(&self) -> (usize, usize) {
        (self.sharpness.edges.len(), self.halves.len())
    }

    /// What it is once all finite sharpness is gone.
    pub(super) fn limit(&self) -> Limit {
        let lasting = |s: f64| if s >= INFINITELY_SHARP { s } else { 0.0 };
        let edges = self.sharpness.edges.iter().copied().map(lasting);
        match kind(lasting(self.sharpness.vertex), edges.clone()) {
            Kind::Corner => Limit::Corner,
            Kind::Crease(ends) => Limit::Crease(ends),
            Kind::Smooth => {
                edges.enumerate().find(|(_, s)| *s > 0.0).map_or(Limit::Smooth, |(k, _)| Limit::Dart(k))
            }
        }
    }

    /// How often the ring has to be refined until it consists of quads and nothing finite is sharp.
    pub(super) fn steps(&self) -> usize {
        let topology = self.cage.topology();
        let quads = topology.is_quads()
            || self.halves.iter().all(|&h| topology.face_corners(topology.face_of(h) as usize).len() == 4);
        self.sharpness.steps().max(usize::from(!quads))
    }

    /// The mask over the ring as it is, from one over the ring refined so often. The faces of what comes are points of faces, unless
    /// nothing was refined.
    fn back(&self, mut mask: Mask, steps: usize) -> Mask {
        let mut levels = vec![self.sharpness.clone()];
        while levels.len() < steps {
            levels.push(levels[levels.len() - 1].decayed());
        }
        for level in (0..steps).rev() {
            mask = mask.back(&levels[level]);
            if level > 0 {
                mask = mask.across();
            }
        }
        mask
    }

    /// The neighbours along the edges, with what a mask has for them.
    fn neighbours<'b>(&'b self, mask: &'b Mask) -> impl Iterator<Item = (u32, f64)> + 'b {
        let topology = self.cage.topology();
        let edges = topology.vertex_edges(self.vertex).zip(&mask.edges);
        edges.map(|(edge, &weight)| (topology.other_end(edge, self.vertex) as u32, weight))
    }

    /// The sum of a mask over the ring refined so often, by the means of the faces of the cage (which nobody looks at without
    /// refinement). Cost: the number of faces here, however large they are.
    pub(super) fn apply(&self, mask: Mask, steps: usize, faces: &[Point]) -> Vector {
        let (topology, points) = (self.cage.topology(), self.cage.points());
        let mask = self.back(mask, steps);
        let mut sum = points[self.vertex].coords * mask.vertex;
        for (v, weight) in self.neighbours(&mask) {
            sum += points[v as usize].coords * weight;
        }
        for (&half, &weight) in self.halves.iter().zip(&mask.faces) {
            sum += weight
                * if steps == 0 {
                    points[topology.origin(topology.next(topology.next(half))) as usize].coords
                } else {
                    faces[topology.face_of(half) as usize].coords
                };
        }
        sum
    }

    /// The row over the vertices of the cage of a mask over the ring refined so often.
    pub(super) fn row(&self, mask: Mask, steps: usize) -> Row {
        let mask = self.back(mask, steps);
        let topology = self.cage.topology();
        let mut row = Row::default();
        row.add(self.vertex as u32, mask.vertex);
        self.neighbours(&mask).for_each(|(v, weight)| row.add(v, weight));
        for (&half, &weight) in self.halves.iter().zip(&mask.faces) {
            if steps == 0 {
                row.add(topology.origin(topology.next(topology.next(half))), weight);
            } else {
                let corners = topology.face(topology.face_of(half) as usize);
                corners.iter().for_each(|&v| row.add(v, weight / corners.len() as f64));
            }
        }
        row.tidy();
        row
    }
}
