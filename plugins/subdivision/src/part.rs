//! Some faces of a cage as a small cage of their own.

use std::sync::Arc;

use loftsman_kernel::Point;

use crate::cage::{BoundaryRule, Cage};
use crate::error::Result;
use crate::topology::{NONE, Topology};

/// What the whole says of its edges and vertices.
pub(crate) struct Said<'a> {
    pub(crate) crease: &'a dyn Fn(usize) -> f64,
    pub(crate) corner: &'a dyn Fn(usize) -> f64,
    /// The knot interval of an edge, where there are any.
    pub(crate) interval: Option<&'a dyn Fn(usize) -> f64>,
}

/// Some faces and their vertices, in an order that follows from how they hang together alone: whatever their numbers in the whole, faces
/// with the same surroundings have the same part. Vertices on the rim may have lost faces.
#[derive(Debug)]
pub(crate) struct Part {
    /// Corners of the whole, face after face, the face itself first.
    halves: Vec<u32>,
    starts: Vec<usize>,
    /// The vertices of the whole that are kept, in the order in which the corners come to them.
    pub(crate) kept: Vec<u32>,
    /// The number among these of the vertex at each corner.
    corners: Vec<u32>,
}

impl Part {
    /// A face, which becomes number 0 with corner `start` as its first, and all that share a vertex with it. Cost: the corners of the
    /// faces there.
    pub(crate) fn around_face(topology: &Topology, face: usize, start: usize) -> Self {
        let own = topology.face_corners(face);
        let size = own.len();
        let mut halves: Vec<u32> =
            (0..size).map(|k| (own.start + (start + k) % size.max(1)) as u32).collect();
        let mut starts = vec![0, size];
        for first in firsts(&round(topology, &halves), |h| topology.face_of(h)) {
            if topology.face_of(first) as usize == face {
                continue;
            }
            let mut half = first;
            loop {
                halves.push(half);
                half = topology.next(half);
                if half == first {
                    break;
                }
            }
            starts.push(halves.len());
        }
        Self::numbered(topology, halves, starts)
    }

    /// The faces at a vertex, which become numbers 0, 1, … counterclockwise, and all that share a vertex with them.
    pub(crate) fn around_vertex(topology: &Topology, vertex: usize) -> Self {
        let own: Vec<usize> = topology.vertex_faces(vertex).map(|f| f as usize).collect();
        Self::of_faces(topology, &own, 1)
    }

    /// Faces, in their order, with all that share a vertex with one of them, and so on for so many rings. Cost: the corners of the faces there.
    pub(crate) fn of_faces(topology: &Topology, faces: &[usize], rings: usize) -> Self {
        let mut all: Vec<u32> = faces.iter().map(|&f| f as u32).collect();
        let mut start = 0;
        for _ in 0..rings {
            let own = all[start..].iter().flat_map(|&f| topology.face_corners(f as usize).map(|h| h as u32));
            let round: Vec<u32> =
                own.flat_map(|h| topology.vertex_faces(topology.origin(h) as usize)).collect();
            start = if start == 0 { faces.len() } else { all.len() };
            all.extend(round);
            all = firsts(&all, |f| f);
        }
        let (mut halves, mut starts) = (Vec::new(), vec![0]);
        for face in firsts(&all, |f| f) {
            halves.extend(topology.face_corners(face as usize).map(|h| h as u32));
            starts.push(halves.len());
        }
        Self::numbered(topology, halves, starts)
    }

    /// Faces with as many rings round them as their refinement needs: with knot intervals weights depend on those of the next ring.
    pub(crate) fn to_refine(cage: &Cage, faces: &[usize]) -> Self {
        Self::of_faces(cage.topology(), faces, if cage.has_intervals() { 2 } else { 1 })
    }

    /// With its vertices numbered.
    fn numbered(topology: &Topology, halves: Vec<u32>, starts: Vec<usize>) -> Self {
        let vertices: Vec<u32> = halves.iter().map(|&h| topology.origin(h)).collect();
        let kept = firsts(&vertices, |v| v);
        let mut places: Vec<(u32, u32)> = kept.iter().zip(0..).map(|(&v, k)| (v, k)).collect();
        places.sort_unstable();
        let place = |v: &u32| match places.binary_search_by_key(v, |p| p.0) {
            Ok(at) => places[at].1,
            Err(_) => 0,
        };
        let corners = vertices.iter().map(place).collect();
        Self { halves, starts, kept, corners }
    }

    /// The part as a cage of its own, with the points and the sharpness of the whole; no holes.
    pub(crate) fn to_cage(&self, whole: &Cage) -> Result<Cage> {
        let interval = |e| whole.interval(e);
        let said = Said {
            crease: &|e| whole.crease(e),
            corner: &|v| whole.corner(v),
            interval: whole.has_intervals().then_some(&interval as &dyn Fn(usize) -> f64),
        };
        let mut cage = self.cage(whole.topology(), &said, whole.boundary())?;
        cage.points = self.kept.iter().map(|&v| whole.points()[v as usize]).collect();
        Ok(cage)
    }

    /// For each corner what is beyond the start and the end of the edge that follows it, from what is beyond those of the edges of the whole.
    pub(crate) fn beyond(&self, whole: &Topology, of: impl Fn(usize) -> [f64; 2]) -> Vec<[f64; 2]> {
        let one = |&h: &u32| {
            let edge = whole.edge_of(h) as usize;
            let [a, b] = of(edge);
            if whole.halves(edge)[0] == h { [a, b] } else { [b, a] }
        };
        self.halves.iter().map(one).collect()
    }

    /// The same for each edge of the [small cage](Self::cage), whose corners are numbered alike.
    pub(crate) fn by_edge(small: &Topology, beyond: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let mut all = vec![[0.0; 2]; small.edge_count()];
        for (h, &[a, b]) in (0..).zip(beyond) {
            let edge = small.edge_of(h) as usize;
            all[edge] = if small.halves(edge)[0] == h { [a, b] } else { [b, a] };
        }
        all
    }

    /// All that rows round the face depend on, as numbers: equal where these are equal. With knot intervals these count, and what is
    /// [beyond](Self::beyond).
    pub(crate) fn key(&self, cage: &Cage, beyond: &[[f64; 2]]) -> Vec<u32> {
        let mut key = vec![u32::from(cage.boundary() == BoundaryRule::EdgeOnly), self.starts.len() as u32];
        key.extend(self.starts.iter().map(|&s| s as u32));
        key.extend_from_slice(&self.corners);
        let mut say = |at: usize, sharpness: f64| {
            if sharpness > 0.0 {
                let bits = sharpness.to_bits();
                key.extend([at as u32, (bits >> 32) as u32, bits as u32]);
            }
        };
        for (k, &h) in self.halves.iter().enumerate() {
            say(k, cage.crease(cage.topology().edge_of(h) as usize));
        }
        for (k, &v) in self.kept.iter().enumerate() {
            say(k + self.halves.len(), cage.corner(v as usize));
        }
        if cage.has_intervals() {
            key.push(u32::MAX);
            for (&h, beyond) in self.halves.iter().zip(beyond) {
                for number in [cage.interval(cage.topology().edge_of(h) as usize), beyond[0], beyond[1]] {
                    let bits = number.to_bits();
                    key.extend([(bits >> 32) as u32, bits as u32]);
                }
            }
        }
        key
    }

    /// The number in the small cage of a vertex of the whole that is kept.
    pub(crate) fn place(&self, vertex: u32) -> u32 {
        self.kept.iter().position(|&v| v == vertex).unwrap_or_default() as u32
    }

    /// The small cage, with what the whole says; its points are not set.
    pub(crate) fn cage(&self, whole: &Topology, said: &Said<'_>, boundary: BoundaryRule) -> Result<Cage> {
        let topology = Topology::part(self.kept.len(), self.corners.clone(), &self.starts)?;
        let points = vec![Point::origin(); self.kept.len()];
        let mut cage = Cage::from_topology(points, Arc::new(topology))?.with_boundary(boundary);
        let edges = cage.topology.edge_count();
        if said.interval.is_some() {
            cage.intervals = vec![1.0; edges];
        }
        for (k, &h) in self.halves.iter().enumerate() {
            let (of, own) = (whole.edge_of(h) as usize, cage.topology.edge_of(k as u32) as usize);
            let sharpness = (said.crease)(of);
            if sharpness > 0.0 {
                cage.creases.resize(edges, 0.0);
                cage.creases[own] = sharpness;
            }
            if let Some(interval) = said.interval {
                cage.intervals[own] = interval(of);
            }
        }
        let corners: Vec<f64> = self.kept.iter().map(|&v| (said.corner)(v as usize)).collect();
        if corners.iter().any(|&s| s > 0.0) {
            cage.corners = corners;
        }
        Ok(cage)
    }
}

/// The half-edges that leave the corners of a face, into all faces that share a corner with it: corner after corner, counterclockwise as
/// far as there are faces, then clockwise.
fn round(topology: &Topology, corners: &[u32]) -> Vec<u32> {
    let mut all = Vec::new();
    for &own in corners {
        let mut half = topology.twin(topology.previous(own));
        while half != own && half != NONE {
            all.push(half);
            half = topology.twin(topology.previous(half));
        }
        if half == NONE {
            let mut twin = topology.twin(own);
            while twin != NONE {
                half = topology.next(twin);
                all.push(half);
                twin = topology.twin(half);
            }
        }
    }
    all
}

/// Of those with the same name the first, in their order.
fn firsts(all: &[u32], name: impl Fn(u32) -> u32) -> Vec<u32> {
    let mut sorted: Vec<(u32, usize)> = all.iter().enumerate().map(|(k, &x)| (name(x), k)).collect();
    sorted.sort_unstable();
    sorted.dedup_by_key(|pair| pair.0);
    let mut places: Vec<usize> = sorted.into_iter().map(|pair| pair.1).collect();
    places.sort_unstable();
    places.into_iter().map(|k| all[k]).collect()
}
