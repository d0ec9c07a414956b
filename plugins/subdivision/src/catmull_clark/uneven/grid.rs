//! A vertex of a grid, by its intervals: on a tensor-product spline.

use crate::cage::Cage;
use crate::catmull_clark::ring::{Limit, Ring};
use crate::catmull_clark::weights::Weights;
use crate::row::Row;

/// What the intervals round a vertex look like.
pub(super) enum Neighbourhood {
    /// All that counts are equal: the limit is that of the uniform scheme.
    Even,
    /// Four quads whose opposite edges agree.
    Grid(Grid),
    /// Anything else.
    Other,
}

/// Four edges at a vertex, and the interval of each and of the edge that goes on beyond it.
pub(super) struct Grid {
    /// Counterclockwise: the vertex itself, its neighbours, those across.
    vertex: u32,
    near: [u32; 4],
    far: [u32; 4],
    intervals: [f64; 4],
    beyond: [f64; 4],
}

impl Neighbourhood {
    /// Cost: the size of the faces there.
    pub(super) fn at(weights: &Weights<'_>, vertex: usize) -> Self {
        let cage = weights.cage;
        if is_even(weights, vertex) {
            return Self::Even;
        }
        Grid::at(weights, cage, vertex).map_or(Self::Other, Self::Grid)
    }
}

/// Whether all edges of the faces round a vertex, and all beyond, have the same interval.
fn is_even(weights: &Weights<'_>, vertex: usize) -> bool {
    let (cage, topology) = (weights.cage, weights.cage.topology());
    let Some(first) = topology.vertex_edges(vertex).next() else { return true };
    let d = cage.interval(first as usize);
    d > 0.0
        && topology.vertex_faces(vertex).all(|face| {
            topology
                .face_edges(face as usize)
                .iter()
                .all(|&e| cage.interval(e as usize) == d && weights.beyond(e as usize) == [2.0 * d; 2])
        })
}

impl Grid {
    fn at(weights: &Weights<'_>, cage: &Cage, vertex: usize) -> Option<Self> {
        let topology = cage.topology();
        let halves: Vec<u32> = topology.around(vertex).take(5).collect();
        let halves: [u32; 4] = halves.try_into().ok()?;
        let quad = |h: u32| topology.face_corners(topology.face_of(h) as usize).len() == 4;
        if topology.is_boundary_vertex(vertex) || !halves.iter().all(|&h| quad(h)) {
            return None;
        }
        let ring = Ring::new(cage, vertex);
        let sharp = |v: usize| Ring::new(cage, v).sharpness.vertex > 0.0;
        if ring.limit() != Limit::Smooth || ring.steps() > 0 || sharp(vertex) {
            return None;
        }
        // The edge of half `h` and what is beyond its start and its end.
        let edge = |h: u32| {
            let e = topology.edge_of(h) as usize;
            let [a, b] = weights.beyond(e);
            if topology.halves(e)[0] == h { (cage.interval(e), [a, b]) } else { (cage.interval(e), [b, a]) }
        };
        let own = halves.map(edge);
        for (k, &half) in halves.iter().enumerate() {
            let (this, next, back) = (own[k], own[(k + 1) % 4], own[(k + 2) % 4]);
            let (before, second) = (own[(k + 3) % 4], topology.next(half));
            let third = topology.next(second);
            // Beside the next edge, from this one's end; and beside this one, from the far corner.
            let (out, along) = (edge(second), edge(third));
            let fits = cage.crease(topology.edge_of(second) as usize) <= 0.0
                && cage.crease(topology.edge_of(third) as usize) <= 0.0
                && out == (next.0, [2.0 * before.0, next.1[1]])
                && along == (this.0, [this.1[1], 2.0 * back.0]);
            if !fits {
                return None;
            }
        }
        let end = |h: u32| topology.origin(topology.next(h));
        Some(Self {
            vertex: vertex as u32,
            near: halves.map(end),
            far: halves.map(|h| end(topology.next(h))),
            intervals: own.map(|(d, _)| d),
            beyond: own.map(|(_, [_, beyond])| 0.5 * beyond),
        })
    }

    /// Along edges `k` and `k + 2`: how the point depends on the vertex before, the vertex and the vertex after, and how the direction
    /// there does.
    ///
    /// With the spans `c, a | b, d` the points that a knot inserted twice gives, `Q₋ = P + b/(c+a+b) (P₋ - P)` and
    /// `Q₊ = P + a/(a+b+d) (P₊ - P)`, are on the tangent, and the point divides them as `a : b`.
    fn across(&self, k: usize) -> ([f64; 3], Option<[f64; 3]>) {
        let [b, a] = [self.intervals[k], self.intervals[k + 2]];
        let [d, c] = [self.beyond[k], self.beyond[k + 2]];
        let (back, forth) = (part(b, c + a), part(a, b + d));
        let at = if a + b > 0.0 { part(a, b) } else { 0.5 };
        let position = [(1.0 - at) * back, (1.0 - at) * (1.0 - back) + at * (1.0 - forth), at * forth];
        let direction = [-back, back - forth, forth];
        (position, (back + forth > 0.0).then_some(direction))
    }

    fn row(&self, along: [f64; 3], across: [f64; 3]) -> Row {
        // Edge 0 goes on, edge 1 to the left, 2 back, 3 to the right; face k lies between edges k and k + 1.
        let net = [
            [self.far[2], self.near[2], self.far[1]],
            [self.near[3], self.vertex, self.near[1]],
            [self.far[3], self.near[0], self.far[0]],
        ];
        let mut row = Row::default();
        for (u, line) in along.iter().zip(net) {
            for (v, vertex) in across.iter().zip(line) {
                row.add(vertex, u * v);
            }
        }
        row.tidy();
        row
    }

    pub(super) fn position(&self) -> Row {
        self.row(self.across(0).0, self.across(1).0)
    }

    /// `None` where the spline has a corner or a crease: where both intervals on a line are zero.
    pub(super) fn tangents(&self) -> Option<[Row; 2]> {
        let ((along, du), (across, dv)) = (self.across(0), self.across(1));
        Some([self.row(du?, across), self.row(along, dv?)])
    }
}

/// `a / (a + b)`; of nothing, nothing.
fn part(a: f64, b: f64) -> f64 {
    if a + b > 0.0 { a / (a + b) } else { 0.0 }
}
