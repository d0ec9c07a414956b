//! Some faces of a cage as a small cage of their own.

use std::sync::Arc;

use loftsman_kernel::Point;

use crate::cage::{BoundaryRule, Cage};
use crate::error::Result;
use crate::topology::Topology;

/// Faces of a whole and their vertices. Vertices on the rim may have lost faces.
pub(crate) struct Part {
    /// Corners of the whole, face after face.
    halves: Vec<u32>,
    starts: Vec<usize>,
    /// The vertices of the whole that are kept, ascending.
    pub(crate) kept: Vec<u32>,
}

/// What the whole says of its edges and vertices.
pub(crate) struct Said<'a> {
    pub(crate) crease: &'a dyn Fn(usize) -> f64,
    pub(crate) corner: &'a dyn Fn(usize) -> f64,
    /// The knot interval of an edge, where there are any.
    pub(crate) interval: Option<&'a dyn Fn(usize) -> f64>,
}

impl Part {
    /// A face, which becomes number 0 with corner `start` as its first, and all that share a vertex with it.
    pub(crate) fn around_face(topology: &Topology, face: usize, start: usize) -> Self {
        let corners = topology.face_corners(face);
        let size = corners.len();
        let mut part = Self::empty();
        part.halves.extend((0..size).map(|k| (corners.start + (start + k) % size.max(1)) as u32));
        part.starts.push(size);
        part.add_faces_at(topology, corners.map(|h| topology.origin(h as u32)), &[face as u32]);
        part
    }

    /// The faces at a vertex, which become numbers 0, 1, … counterclockwise, and all that share a vertex with them.
    pub(crate) fn around_vertex(topology: &Topology, vertex: usize) -> Self {
        let own: Vec<u32> = topology.vertex_faces(vertex).collect();
        let mut part = Self::empty();
        own.iter().for_each(|&f| part.add(topology, f));
        let ring = part.halves.clone();
        part.add_faces_at(topology, ring.iter().map(|&h| topology.origin(h)), &own);
        part
    }

    fn empty() -> Self {
        Self { halves: Vec::new(), starts: vec![0], kept: Vec::new() }
    }

    fn add(&mut self, topology: &Topology, face: u32) {
        self.halves.extend(topology.face_corners(face as usize).map(|h| h as u32));
        self.starts.push(self.halves.len());
    }

    /// Adds the faces at some vertices, each once, ascending, but for those that are there.
    fn add_faces_at(&mut self, topology: &Topology, vertices: impl Iterator<Item = u32>, but: &[u32]) {
        let mut vertices: Vec<u32> = vertices.collect();
        vertices.sort_unstable();
        vertices.dedup();
        let mut faces: Vec<u32> = vertices.iter().flat_map(|&v| topology.vertex_faces(v as usize)).collect();
        faces.sort_unstable();
        faces.dedup();
        let mut but = but.to_vec();
        but.sort_unstable();
        faces.retain(|f| but.binary_search(f).is_err());
        faces.iter().for_each(|&f| self.add(topology, f));
        self.kept = self.halves.iter().map(|&h| topology.origin(h)).collect();
        self.kept.sort_unstable();
        self.kept.dedup();
    }

    /// The number in the small cage of a vertex of the whole that is kept.
    pub(crate) fn place(&self, vertex: u32) -> u32 {
        self.kept.binary_search(&vertex).unwrap_or_default() as u32
    }

    /// The small cage, with what the whole says; its points are not set.
    pub(crate) fn cage(&self, whole: &Topology, said: &Said<'_>, boundary: BoundaryRule) -> Result<Cage> {
        let corners = self.halves.iter().map(|&h| self.place(whole.origin(h))).collect();
        let topology = Topology::part(self.kept.len(), corners, &self.starts)?;
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
