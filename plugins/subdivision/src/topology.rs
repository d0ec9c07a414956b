//! Who neighbours whom in a polygon mesh, by half-edges.

mod around;
mod build;
mod deferred;
mod sides;
mod split;

pub use around::Around;

use deferred::{Deferred, Pairing};
use loftsman_kernel::parallel;

/// Stands for "none" among half-edges: the outer side of a boundary edge.
pub const NONE: u32 = u32::MAX;

/// Vertices, edges and faces of an oriented manifold polygon mesh with or without boundary.
///
/// Corner `h` of the mesh (faces one after the other, each counterclockwise from outside) is also the *half-edge* from its vertex to
/// the next vertex of the face, with the face on its left. An edge is one half-edge (on the boundary) or two that run against each
/// other. All in arrays of 32 bits: 4 numbers a half-edge where faces differ in size, 2 where all are quads, and 2 an edge, 1 a vertex. What a refinement makes
/// of a cage has its corners at once; its edges, which follow from its parent's, are found when they are first asked for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Topology {
    vertices: usize,
    edges: usize,
    /// The vertex at which each half-edge starts.
    corners: Vec<u32>,
    /// Where each face starts among the corners, and the face of each corner; nothing where all faces are quads.
    polygons: Option<Polygons>,
    pairing: Deferred,
}

/// Faces of any size.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Polygons {
    starts: Vec<u32>,
    face_of: Vec<u32>,
}

impl Topology {
    /// The number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.vertices
    }

    /// The number of edges.
    pub fn edge_count(&self) -> usize {
        self.edges
    }

    /// The number of faces.
    pub fn face_count(&self) -> usize {
        self.polygons.as_ref().map_or(self.corners.len() / 4, |p| p.starts.len() - 1)
    }

    /// The number of corners of all faces, which is that of half-edges.
    pub fn corner_count(&self) -> usize {
        self.corners.len()
    }

    /// The vertex at every corner, face after face.
    pub fn corners(&self) -> &[u32] {
        &self.corners
    }

    /// Whether every face has four corners.
    pub fn is_quads(&self) -> bool {
        self.polygons.is_none()
    }

    /// The corners of a face: a range of half-edges. Empty for a face that is not there.
    #[inline]
    pub fn face_corners(&self, face: usize) -> std::ops::Range<usize> {
        match &self.polygons {
            None if face < self.corners.len() / 4 => 4 * face..4 * face + 4,
            Some(p) if face + 1 < p.starts.len() => p.starts[face] as usize..p.starts[face + 1] as usize,
            _ => 0..0,
        }
    }

    /// The vertices of a face, counterclockwise. Empty for a face that is not there.
    #[inline]
    pub fn face(&self, face: usize) -> &[u32] {
        &self.corners[self.face_corners(face)]
    }

    /// The edges of a face: edge `c` runs from its corner `c` to the next. Empty for a face that is not there.
    #[inline]
    pub fn face_edges(&self, face: usize) -> &[u32] {
        &self.pairing().edge_of[self.face_corners(face)]
    }

    /// The two vertices of an edge, in the direction of its first half-edge.
    ///
    /// # Panics
    /// As every index below, it must exist; these are the inner loops of refinement.
    #[inline]
    pub(crate) fn ends(&self, edge: usize) -> [u32; 2] {
        let first = self.pairing().edges[edge][0];
        [self.corners[first as usize], self.corners[self.next(first) as usize]]
    }

    /// The two vertices of an edge, the first where its first face runs from. `None` for an edge that is not there.
    pub fn edge(&self, edge: usize) -> Option<[u32; 2]> {
        (edge < self.edges).then(|| self.ends(edge))
    }

    /// The faces of an edge: the one on its left, and the one on its right, where there is one.
    pub fn edge_faces(&self, edge: usize) -> impl Iterator<Item = u32> + '_ {
        self.pairing().edges.get(edge).into_iter().flatten().filter(|&&h| h != NONE).map(|&h| self.face_of(h))
    }

    /// Whether an edge has one face only.
    #[inline]
    pub fn is_boundary_edge(&self, edge: usize) -> bool {
        self.pairing().edges.get(edge).is_some_and(|pair| pair[1] == NONE)
    }

    /// Whether a vertex lies on the boundary.
    #[inline]
    pub fn is_boundary_vertex(&self, vertex: usize) -> bool {
        self.pairing().leaving.get(vertex).is_some_and(|&h| self.twin(h) == NONE)
    }

    /// The number of edges at a vertex. Cost: that number.
    pub fn valence(&self, vertex: usize) -> usize {
        self.vertex_edges(vertex).count()
    }

    /// The edge between two vertices, in either direction. Cost: the smaller of the two valences.
    pub fn edge_between(&self, a: usize, b: usize) -> Option<usize> {
        let there = |vertex: usize, other: usize| {
            self.vertex_edges(vertex).map(move |edge| (edge as usize, self.other_end(edge, vertex) == other))
        };
        // Side by side, so that a hub with many spokes costs no more than the spoke.
        for (from_a, from_b) in there(a, b).zip(there(b, a)) {
            if let Some((edge, _)) = [from_a, from_b].into_iter().find(|(_, found)| *found) {
                return Some(edge);
            }
        }
        None
    }

    /// The end of an edge that is not this vertex.
    #[inline]
    pub(crate) fn other_end(&self, edge: u32, vertex: usize) -> usize {
        let [a, b] = self.ends(edge as usize);
        if a as usize == vertex { b as usize } else { a as usize }
    }

    /// The half-edges of an edge.
    #[inline]
    pub(crate) fn halves(&self, edge: usize) -> [u32; 2] {
        self.pairing().edges[edge]
    }

    /// The vertex at which a half-edge starts.
    #[inline]
    pub(crate) fn origin(&self, half: u32) -> u32 {
        self.corners[half as usize]
    }

    /// The edge of a half-edge.
    #[inline]
    pub(crate) fn edge_of(&self, half: u32) -> u32 {
        self.pairing().edge_of[half as usize]
    }

    /// The face of a half-edge.
    #[inline]
    pub(crate) fn face_of(&self, half: u32) -> u32 {
        self.polygons.as_ref().map_or(half / 4, |p| p.face_of[half as usize])
    }

    /// The half-edge that follows in the face.
    #[inline]
    pub(crate) fn next(&self, half: u32) -> u32 {
        match &self.polygons {
            None => (half & !3) | ((half + 1) & 3),
            Some(p) => {
                let face = p.face_of[half as usize] as usize;
                if half + 1 == p.starts[face + 1] { p.starts[face] } else { half + 1 }
            }
        }
    }

    /// The half-edge that precedes in the face.
    #[inline]
    pub(crate) fn previous(&self, half: u32) -> u32 {
        match &self.polygons {
            None => (half & !3) | (half.wrapping_sub(1) & 3),
            Some(p) => {
                let face = p.face_of[half as usize] as usize;
                if half == p.starts[face] { p.starts[face + 1] - 1 } else { half - 1 }
            }
        }
    }

    /// The half-edge on the other side of its edge, or [`NONE`].
    #[inline]
    pub(crate) fn twin(&self, half: u32) -> u32 {
        self.pairing().twin(half)
    }

    /// Finds the edges now, by all threads, where they are deferred: what goes on to ask for them on many threads begins with this.
    pub(crate) fn find_edges_now(&self) {
        self.pairing.find_now();
    }

    /// Edges and half-edges, found now where that is not done.
    #[inline]
    fn pairing(&self) -> &Pairing {
        self.pairing.get()
    }

    /// The bytes that the arrays take which are there.
    pub fn bytes(&self) -> usize {
        let polygons = self.polygons.as_ref().map_or(0, |p| p.starts.len() + p.face_of.len());
        4 * (self.corners.len() + polygons) + self.pairing.bytes()
    }
}

/// Whether work may be done side by side, where there is much.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Threads {
    All,
    /// For what others wait for: whoever waits for other threads meanwhile may be given what waits for him.
    One,
}

/// `work` on every index below `count`, several results each, one after the other.
fn flat<const N: usize>(
    threads: Threads,
    count: usize,
    work: impl Fn(u32) -> [u32; N] + Sync + Send,
) -> Vec<u32> {
    many(threads, count, |k| work(k as u32)).into_flattened()
}

/// Fewer than these are done before other threads would have begun.
const MANY: usize = 1 << 12;

/// `work` on every index below `count`, side by side where they are many and may be.
fn many<R: Send>(threads: Threads, count: usize, work: impl Fn(usize) -> R + Sync + Send) -> Vec<R> {
    if count < MANY || threads == Threads::One {
        (0..count).map(work).collect()
    } else {
        parallel::map(count, work)
    }
}
