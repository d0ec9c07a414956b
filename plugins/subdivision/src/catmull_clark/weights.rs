//! What each new point is made of.

use smallvec::SmallVec;

use super::rules::{Kind, VertexRule, kind, vertex_rule};
use crate::cage::Cage;
use crate::leading::Leading;
use crate::row::{Row, Sum};

/// The weights of one refinement of a cage.
///
/// Uniform: Catmull and Clark 1978. By knot intervals: Sederberg, Zheng, Sewell and Sabin 1998, section 4, where `d` is the interval of
/// an edge and `b` the sum of the two intervals *beyond* one of its ends (those two edges further round that vertex, on either side).
/// Where so many intervals are zero that a weight is `0/0`, the zeros are one small number that goes to zero ([`Leading`]).
pub(crate) struct Weights<'a> {
    pub(crate) cage: &'a Cage,
    /// The intervals beyond both ends of each edge; nothing where the cage has no intervals.
    beyond: Vec<[f64; 2]>,
}

impl<'a> Weights<'a> {
    /// Cost: nothing for a uniform cage, linear otherwise.
    pub(crate) fn new(cage: &'a Cage) -> Self {
        let mut weights = Self { cage, beyond: Vec::new() };
        if cage.has_intervals() {
            weights.find_beyond();
        }
        weights
    }

    /// The same of a part of a cage, where what is beyond the ends of edges is known from the whole; nothing for a uniform one.
    pub(crate) fn with_beyond(cage: &'a Cage, beyond: Vec<[f64; 2]>) -> Self {
        Self { cage, beyond }
    }

    /// The intervals beyond both ends of an edge of a cage with intervals.
    pub(super) fn beyond(&self, edge: usize) -> [f64; 2] {
        self.beyond[edge]
    }

    fn find_beyond(&mut self) {
        let topology = self.cage.topology();
        self.beyond = vec![[0.0; 2]; topology.edge_count()];
        for vertex in 0..topology.vertex_count() {
            for (edge, beyond) in beyond_at(self.cage, vertex) {
                let end = usize::from(topology.ends(edge)[0] as usize != vertex);
                self.beyond[edge][end] = beyond;
            }
        }
    }

    /// Whether nothing at a vertex is sharp. Cost: its valence where edges are sharp anywhere, and nothing otherwise.
    #[inline]
    pub(crate) fn is_smooth(&self, vertex: usize) -> bool {
        let cage = self.cage;
        let topology = cage.topology();
        if topology.is_boundary_vertex(vertex) || cage.corner(vertex) > 0.0 {
            return false;
        }
        cage.creases.is_empty()
            || topology.around(vertex).all(|h| cage.crease(topology.edge_of(h) as usize) <= 0.0)
    }

    /// Whether an edge is neither sharp nor of the boundary.
    #[inline]
    pub(crate) fn is_smooth_edge(&self, edge: usize) -> bool {
        self.cage.crease(edge) <= 0.0 && !self.cage.topology().is_boundary_edge(edge)
    }

    /// The rule of a vertex.
    pub(crate) fn rule(&self, vertex: usize) -> VertexRule {
        if self.is_smooth(vertex) {
            return VertexRule::SMOOTH;
        }
        vertex_rule(self.cage.vertex_sharpness(vertex), sharpnesses(self.cage, vertex).iter().copied())
    }

    /// The new point of a face: the mean of its vertices, or `Σ w_i P_i / Σ w_i` with
    /// `w_i = (d + b + d' + b') (e + c + e' + c')`, where `d` is the edge towards the next vertex and `b` beyond that one, `d'` and `b'`
    /// the same of the edge across, `e …` towards the vertex before.
    pub(crate) fn face(&self, face: usize, mut add: impl FnMut(u32, f64)) {
        let topology = self.cage.topology();
        let corners = topology.face_corners(face);
        let n = corners.len();
        let vertices = topology.face(face);
        if self.beyond.is_empty() {
            let weight = 1.0 / n as f64;
            return vertices.iter().for_each(|&v| add(v, weight));
        }
        // Of edge c of the face: its interval and what is beyond its start, beyond its end.
        let side = |c: usize, at_end: bool| {
            let half = (corners.start + c % n) as u32;
            let edge = topology.edge_of(half) as usize;
            let end = usize::from((topology.halves(edge)[0] != half) != at_end);
            self.cage.interval(edge) + self.beyond[edge][end]
        };
        let weight = |c: usize| {
            let forwards = side(c, true) + side(c + 2 * n - 2, false);
            let backwards = side(c + n - 1, false) + side(c + 1, true);
            forwards * backwards
        };
        let total: f64 = (0..n).map(weight).sum();
        if total > 0.0 {
            return vertices.iter().enumerate().for_each(|(c, &vertex)| add(vertex, weight(c) / total));
        }
        vertices.iter().zip(self.collapsed_face(face)).for_each(|(&vertex, share)| add(vertex, share));
    }

    /// The weights in the point of a face all of whose weights vanish.
    fn collapsed_face(&self, face: usize) -> Vec<f64> {
        let topology = self.cage.topology();
        let corners = topology.face_corners(face);
        let n = corners.len();
        let side = |c: usize, at_end: bool| {
            let half = (corners.start + c % n) as u32;
            let edge = topology.edge_of(half) as usize;
            let end = usize::from((topology.halves(edge)[0] != half) != at_end);
            Leading::new(self.cage.interval(edge), 1.0) + Leading::new(self.beyond[edge][end], 2.0)
        };
        let weight = |c: usize| {
            let forwards = side(c, true) + side(c + 2 * n - 2, false);
            forwards * (side(c + n - 1, false) + side(c + 1, true))
        };
        Leading::shares(&(0..n).map(weight).collect::<Vec<_>>())
    }

    /// The weights of an edge's ends in the point of the edge alone: halves, or `(d + b₁, d + b₀)` over their sum.
    #[inline]
    pub(crate) fn middle(&self, edge: usize) -> [f64; 2] {
        let Some([at_start, at_end]) = self.beyond.get(edge) else { return [0.5; 2] };
        let d = self.cage.interval(edge);
        let (start, end) = (d + at_end, d + at_start);
        let total = start + end;
        if total > 0.0 { [start / total, end / total] } else { [0.5; 2] }
    }

    #[inline]
    fn add_middle(&self, edge: usize, weight: f64, sum: &mut impl Sum) {
        let ([a, b], [from, to]) = (self.middle(edge), self.cage.topology().ends(edge));
        sum.vertex(from, weight * a);
        sum.vertex(to, weight * b);
    }

    /// The weights of the faces on the left and right of an inner edge: quarters, or half the intervals on the other side over those on
    /// both.
    #[inline]
    fn beside(&self, edge: usize) -> [f64; 2] {
        if self.beyond.is_empty() {
            return [0.25; 2];
        }
        let topology = self.cage.topology();
        let d = |half: u32| self.cage.interval(topology.edge_of(half) as usize);
        let [left, right] =
            topology.halves(edge).map(|half| d(topology.previous(half)) + d(topology.next(half)));
        let total = 2.0 * (left + right);
        if total > 0.0 { [right / total, left / total] } else { [0.0; 2] }
    }

    /// The new point of an edge: half from its ends and half from its faces where it is smooth, from its ends alone where it is sharp,
    /// blended where it is less than once.
    #[inline]
    pub(crate) fn edge(&self, edge: usize, sum: &mut impl Sum) {
        let smooth = 1.0 - self.cage.sharpness(edge).min(1.0);
        if smooth <= 0.0 {
            return self.add_middle(edge, 1.0, sum);
        }
        let topology = self.cage.topology();
        let [left, right] = self.beside(edge).map(|w| w * smooth);
        self.add_middle(edge, 1.0 - left - right, sum);
        let [one, other] = topology.halves(edge);
        sum.face(topology.face_of(one), left);
        sum.face(topology.face_of(other), right);
    }

    /// The new point of a vertex, by its [rule](Self::rule).
    pub(crate) fn vertex(&self, vertex: usize, sum: &mut impl Sum) {
        let VertexRule { smooth, crease, mut corner, ends } = self.rule(vertex);
        if crease > 0.0 {
            let mut edges = self.cage.topology().vertex_edges(vertex);
            let first = edges.nth(ends[0]).map_or(0, |e| e as usize);
            let second = edges.nth(ends[1] - ends[0] - 1).map_or(0, |e| e as usize);
            let (d0, d1) = (self.cage.interval(first), self.cage.interval(second));
            let total = 2.0 * (d0 + d1);
            if total > 0.0 {
                self.add_middle(first, crease * d1 / total, sum);
                self.add_middle(second, crease * d0 / total, sum);
                corner += 0.5 * crease;
            } else {
                corner += crease;
            }
        }
        if smooth > 0.0 {
            self.smooth_vertex(vertex, smooth, sum);
        }
        if corner > 0.0 {
            sum.vertex(vertex as u32, corner);
        }
    }

    /// `(n - 2)/n P + Σ (E_i + F_i) / n²` with the neighbours `E`, the new points of faces `F`; by intervals
    /// `(n - 3)/n P + 3/n Σ (m_i M_i + f_i F_i) / Σ (m_i + f_i)` with the points `M` of the edges alone,
    /// `m_i = (d_{i+1} + d_{i-1}) (d_{i+2} + d_{i-2}) / 2` and `f_i = d_{i+2} d_{i-1}` for the face between edges `i` and `i + 1`.
    fn smooth_vertex(&self, vertex: usize, share: f64, sum: &mut impl Sum) {
        let topology = self.cage.topology();
        if self.beyond.is_empty() {
            let n = topology.around(vertex).count() as f64;
            sum.vertex(vertex as u32, share * (n - 2.0) / n);
            let each = share / (n * n);
            for half in topology.around(vertex) {
                sum.vertex(topology.origin(topology.next(half)), each);
                sum.face(topology.face_of(half), each);
            }
            return;
        }
        let halves: Vec<u32> = topology.around(vertex).collect();
        let n = halves.len();
        let d = |k: usize| self.cage.interval(topology.edge_of(halves[k % n]) as usize);
        let of_edge = |k: usize| (d(k + 1) + d(k + n - 1)) * (d(k + 2) + d(k + 2 * n - 2)) / 2.0;
        let of_face = |k: usize| d(k + 2) * d(k + n - 1);
        let total: f64 = (0..n).map(|k| of_edge(k) + of_face(k)).sum();
        sum.vertex(vertex as u32, share * (n as f64 - 3.0) / n as f64);
        let each = 3.0 * share / n as f64;
        let parts = if total > 0.0 {
            (0..n).map(of_edge).chain((0..n).map(of_face)).map(|w| w / total).collect()
        } else {
            collapsed_vertex(n, d)
        };
        for (k, &half) in halves.iter().enumerate() {
            self.add_middle(topology.edge_of(half) as usize, each * parts[k], sum);
            sum.face(topology.face_of(half), each * parts[n + k]);
        }
    }
}

/// The sharpness of the edges round a vertex.
fn sharpnesses(cage: &Cage, vertex: usize) -> SmallVec<[f64; 12]> {
    cage.topology().vertex_edges(vertex).map(|edge| cage.sharpness(edge as usize)).collect()
}

/// The edges at a vertex, and the sum of the intervals beyond it of each.
///
/// Beyond a crease or the boundary the intervals continue along it; across it, as at a corner, they are mirrored, which makes the
/// crease the spline of its own vertices.
fn beyond_at(cage: &Cage, vertex: usize) -> impl Iterator<Item = (usize, f64)> {
    let edges: SmallVec<[u32; 12]> = cage.topology().vertex_edges(vertex).collect();
    let d: SmallVec<[f64; 12]> = edges.iter().map(|&e| cage.interval(e as usize)).collect();
    let n = edges.len();
    let kind = kind(cage.vertex_sharpness(vertex), sharpnesses(cage, vertex).iter().copied());
    edges.into_iter().enumerate().map(move |(k, edge)| {
        let beyond = match kind {
            Kind::Smooth => d[(k + 2) % n] + d[(k + 2 * n - 2) % n],
            Kind::Crease([a, b]) if k == a => 2.0 * d[b],
            Kind::Crease([a, b]) if k == b => 2.0 * d[a],
            _ => 2.0 * d[k],
        };
        (edge as usize, beyond)
    })
}

/// The intervals beyond both ends of an edge. Cost: the valences of these.
pub(crate) fn beyond_of(cage: &Cage, edge: usize) -> [f64; 2] {
    cage.topology().ends(edge).map(|vertex| {
        beyond_at(cage, vertex as usize).find(|(own, _)| *own == edge).map_or(0.0, |(_, beyond)| beyond)
    })
}

/// The weights of the edges and of the faces at a smooth vertex where all of them vanish.
fn collapsed_vertex(n: usize, d: impl Fn(usize) -> f64) -> Vec<f64> {
    let d = |k: usize| Leading::new(d(k), 1.0);
    let of_edge = |k: usize| (d(k + 1) + d(k + n - 1)) * (d(k + 2) + d(k + 2 * n - 2)) * 0.5;
    let of_face = |k: usize| d(k + 2) * d(k + n - 1);
    Leading::shares(&(0..n).map(of_edge).chain((0..n).map(of_face)).collect::<Vec<_>>())
}

/// A row of coefficients, faces taken apart into their vertices.
pub(crate) struct Rows<'a> {
    pub(crate) weights: &'a Weights<'a>,
    pub(crate) row: Row,
    pub(crate) factor: f64,
}

impl Sum for Rows<'_> {
    fn vertex(&mut self, vertex: u32, weight: f64) {
        self.row.add(vertex, weight * self.factor);
    }

    fn face(&mut self, face: u32, weight: f64) {
        let weight = weight * self.factor;
        if weight != 0.0 {
            self.weights.face(face as usize, |v, w| self.row.add(v, w * weight));
        }
    }
}
