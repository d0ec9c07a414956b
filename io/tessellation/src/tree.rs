//! The cells of one patch: quadrilaterals of parameters that share vertices and edges.
//!
//! An edge is cut at the middle of its parameters or not at all, and remembers that it was; a cell has four edges.
//! So whoever looks at an edge, from either side, sees the same vertices on it, and no crack can open.

use loftsman_kernel::Vector;

use crate::normals::normal;
use crate::patch::Patch;

/// No kids.
const NONE: u32 = u32::MAX;

/// A vertex: its parameters in the patch (dyadic fractions, exact), its point, and the unit normal (or zero).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Vertex {
    pub(crate) at: [f64; 2],
    pub(crate) point: Vector,
    pub(crate) normal: Vector,
}

#[derive(Debug, Clone, Copy)]
struct Edge {
    ends: [u32; 2],
    /// The first of its two halves.
    kids: u32,
    /// Whether no cell may cut it: an edge of the surface, cut by its own data only.
    fixed: bool,
}

/// A cell: corners counterclockwise, edge `k` from corner `k` to the next.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cell {
    pub(crate) corners: [u32; 4],
    pub(crate) edges: [u32; 4],
}

/// How a cell is divided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Cut {
    /// From the middle of edge 0 to that of edge 2.
    Even,
    /// From the middle of edge 1 to that of edge 3.
    Odd,
    /// Two edges that meet at this corner must stay whole: three cells around a vertex inside.
    Corner(usize),
    /// More edges must stay whole: a cell inside, and one along each edge.
    Inset,
}

/// The vertices and edges of a patch. Sides are edges 0 (`v = 0`), 1 (`u = 1`), 2 (`v = 1`) and 3 (`u = 0`).
#[derive(Debug, Clone, Default)]
pub(crate) struct Tree {
    pub(crate) vertices: Vec<Vertex>,
    edges: Vec<Edge>,
}

impl Tree {
    /// A patch as one cell; its sides run in the direction of their parameters.
    pub(crate) fn new(patch: &Patch) -> (Self, Cell) {
        // Room for what a patch usually comes to.
        let mut tree = Self { vertices: Vec::with_capacity(24), edges: Vec::with_capacity(48) };
        for at in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
            tree.vertex(patch, at);
        }
        let edges = [[0, 1], [1, 2], [3, 2], [0, 3]].map(|ends| tree.edge(ends, false));
        (tree, Cell { corners: [0, 1, 2, 3], edges })
    }

    fn vertex(&mut self, patch: &Patch, at: [f64; 2]) -> u32 {
        let jet = patch.jet(at);
        self.vertices.push(Vertex { at, point: jet.point, normal: normal(patch, at, &jet) });
        self.vertices.len() as u32 - 1
    }

    fn edge(&mut self, ends: [u32; 2], fixed: bool) -> u32 {
        self.edges.push(Edge { ends, kids: NONE, fixed });
        self.edges.len() as u32 - 1
    }

    /// The vertex in the middle of an edge that is cut.
    pub(crate) fn middle(&self, edge: u32) -> Option<u32> {
        let kids = self.edges[edge as usize].kids;
        (kids != NONE).then(|| self.edges[kids as usize].ends[1])
    }

    /// Whether an edge is whole and must stay so.
    pub(crate) fn blocked(&self, edge: u32) -> bool {
        let edge = &self.edges[edge as usize];
        edge.fixed && edge.kids == NONE
    }

    /// Keeps cells from cutting a side any further.
    pub(crate) fn fix(&mut self, side: usize) {
        let mut open = vec![side as u32];
        while let Some(edge) = open.pop() {
            let edge = &mut self.edges[edge as usize];
            edge.fixed = true;
            if edge.kids != NONE {
                open.extend([edge.kids, edge.kids + 1]);
            }
        }
    }

    /// Cuts an edge, unless it is: the vertex in its middle.
    fn cut_edge(&mut self, patch: &Patch, edge: u32) -> u32 {
        if let Some(middle) = self.middle(edge) {
            return middle;
        }
        let Edge { ends: [a, b], fixed, .. } = self.edges[edge as usize];
        let (x, y) = (self.vertices[a as usize].at, self.vertices[b as usize].at);
        let middle = self.vertex(patch, [0.5 * (x[0] + y[0]), 0.5 * (x[1] + y[1])]);
        let kids = self.edge([a, middle], fixed);
        self.edge([middle, b], fixed);
        self.edges[edge as usize].kids = kids;
        middle
    }

    /// The half of a cut edge that ends at a vertex.
    fn half(&self, edge: u32, end: u32) -> u32 {
        let Edge { ends, kids, .. } = self.edges[edge as usize];
        if ends[0] == end { kids } else { kids + 1 }
    }

    /// The two, three or five cells that a cell is cut into.
    pub(crate) fn cut(&mut self, patch: &Patch, cell: &Cell, how: Cut, out: &mut Vec<Cell>) {
        let turned = |by: usize| Cell {
            corners: [0, 1, 2, 3].map(|k| cell.corners[(k + by) % 4]),
            edges: [0, 1, 2, 3].map(|k| cell.edges[(k + by) % 4]),
        };
        match how {
            Cut::Even => self.halve(patch, &turned(0), out),
            Cut::Odd => self.halve(patch, &turned(1), out),
            Cut::Corner(k) => self.cut_corner(patch, &turned(k), out),
            Cut::Inset => self.inset(patch, cell, out),
        }
    }

    fn halve(&mut self, patch: &Patch, cell: &Cell, out: &mut Vec<Cell>) {
        let ([c0, c1, c2, c3], [e0, e1, e2, e3]) = (cell.corners, cell.edges);
        let (a, b) = (self.cut_edge(patch, e0), self.cut_edge(patch, e2));
        let new = self.edge([a, b], false);
        out.push(Cell { corners: [c0, a, b, c3], edges: [self.half(e0, c0), new, self.half(e2, c3), e3] });
        out.push(Cell { corners: [a, c1, c2, b], edges: [self.half(e0, c1), e1, self.half(e2, c2), new] });
    }

    /// Edges 0 and 3, which meet at corner 0, stay whole.
    fn cut_corner(&mut self, patch: &Patch, cell: &Cell, out: &mut Vec<Cell>) {
        let ([c0, c1, c2, c3], [e0, e1, e2, e3]) = (cell.corners, cell.edges);
        let (a, b) = (self.cut_edge(patch, e1), self.cut_edge(patch, e2));
        let m = self.centre(patch, cell);
        let [x, y, z] = [c0, a, b].map(|end| self.edge([m, end], false));
        out.push(Cell { corners: [c0, c1, a, m], edges: [e0, self.half(e1, c1), y, x] });
        out.push(Cell { corners: [m, a, c2, b], edges: [y, self.half(e1, c2), self.half(e2, c2), z] });
        out.push(Cell { corners: [c0, m, b, c3], edges: [x, z, self.half(e2, c3), e3] });
    }

    fn inset(&mut self, patch: &Patch, cell: &Cell, out: &mut Vec<Cell>) {
        let middle = self.centre_at(cell);
        let inner = cell.corners.map(|c| {
            let at = self.vertices[c as usize].at;
            self.vertex(patch, [0.5 * (at[0] + middle[0]), 0.5 * (at[1] + middle[1])])
        });
        let spokes = [0, 1, 2, 3].map(|k| self.edge([cell.corners[k], inner[k]], false));
        let ring = [0, 1, 2, 3].map(|k| self.edge([inner[k], inner[(k + 1) % 4]], false));
        for k in 0..4 {
            let next = (k + 1) % 4;
            out.push(Cell {
                corners: [cell.corners[k], cell.corners[next], inner[next], inner[k]],
                edges: [cell.edges[k], spokes[next], ring[k], spokes[k]],
            });
        }
        out.push(Cell { corners: inner, edges: ring });
    }

    fn centre_at(&self, cell: &Cell) -> [f64; 2] {
        [0, 1].map(|d| 0.25 * cell.corners.iter().map(|&c| self.vertices[c as usize].at[d]).sum::<f64>())
    }

    fn centre(&mut self, patch: &Patch, cell: &Cell) -> u32 {
        let at = self.centre_at(cell);
        self.vertex(patch, at)
    }

    /// The vertices of a cell's edge from a corner to the next, without the last.
    pub(crate) fn chain(&self, cell: &Cell, side: usize, out: &mut Vec<u32>) {
        let edge = cell.edges[side];
        if self.edges[edge as usize].kids == NONE {
            out.push(cell.corners[side]);
        } else {
            self.walk(edge, cell.corners[side], out);
        }
    }

    /// The vertices of a side, its direction being that of its parameter, both ends included.
    pub(crate) fn side(&self, side: usize, out: &mut Vec<u32>) {
        let ends = self.edges[side].ends;
        out.clear();
        self.walk(side as u32, ends[0], out);
        out.push(ends[1]);
    }

    /// The number of vertices around a cell.
    pub(crate) fn around(&self, cell: &Cell) -> usize {
        cell.edges.iter().map(|&edge| 1 + self.cuts(edge)).sum()
    }

    /// The number of vertices between the ends of an edge.
    #[inline]
    fn cuts(&self, edge: u32) -> usize {
        let kids = self.edges[edge as usize].kids;
        if kids == NONE { 0 } else { self.cuts_within(kids) }
    }

    /// The same of a cut edge with these halves.
    fn cuts_within(&self, kids: u32) -> usize {
        1 + self.cuts(kids) + self.cuts(kids + 1)
    }

    /// The fractions of a side's inner vertices, ascending.
    pub(crate) fn fractions(&self, side: usize, out: &mut impl Extend<f64>) {
        self.inner(side as u32, side % 2, out);
    }

    fn inner(&self, edge: u32, direction: usize, out: &mut impl Extend<f64>) {
        let kids = self.edges[edge as usize].kids;
        if kids != NONE {
            self.inner(kids, direction, out);
            out.extend([self.vertices[self.edges[kids as usize].ends[1] as usize].at[direction]]);
            self.inner(kids + 1, direction, out);
        }
    }

    fn walk(&self, edge: u32, from: u32, out: &mut Vec<u32>) {
        let Edge { ends, kids, .. } = self.edges[edge as usize];
        if kids == NONE {
            out.push(from);
        } else if ends[0] == from {
            self.walk(kids, from, out);
            self.walk(kids + 1, self.edges[kids as usize].ends[1], out);
        } else {
            self.walk(kids + 1, from, out);
            self.walk(kids, self.edges[kids as usize].ends[1], out);
        }
    }

    /// Cuts a side so that there is a vertex at this dyadic fraction of it.
    pub(crate) fn cut_side(&mut self, patch: &Patch, side: usize, at: f64) {
        let (mut edge, mut low, mut high) = (side as u32, 0.0, 1.0);
        loop {
            let middle = 0.5 * (low + high);
            if !(at > low && at < high && middle > low && middle < high) {
                return;
            }
            self.cut_edge(patch, edge);
            let kids = self.edges[edge as usize].kids;
            if at < middle {
                (edge, high) = (kids, middle);
            } else {
                (edge, low) = (kids + 1, middle);
            }
        }
    }
}
