//! The control cage of a subdivision surface.

mod build;
mod degenerate;

pub(crate) use build::{between, checked_interval, end, present};

use std::sync::Arc;

use loftsman_kernel::Point;
use loftsman_kernel::mesh::Mesh;

use crate::error::Result;
use crate::topology::Topology;

/// A sharpness from here on is infinite, as OpenSubdiv has it: it does not decay.
pub const INFINITELY_SHARP: f64 = 10.0;

/// What becomes of the boundary of a cage under Catmull-Clark refinement. Its edges are infinitely sharp in either case, so that
/// the boundary of the surface is the cubic spline of the boundary of the cage.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BoundaryRule {
    /// A boundary vertex with one face is rounded like the others (OpenSubdiv's `VTX_BOUNDARY_EDGE_ONLY`).
    EdgeOnly,
    /// A boundary vertex with one face is a corner, and stays (`VTX_BOUNDARY_EDGE_AND_CORNER`).
    #[default]
    EdgeAndCorner,
}

/// A polygon mesh as the control cage of a subdivision surface: faces of any size, vertices of any valence, boundaries, creases.
///
/// Sharpness, of edges and of vertices, runs from 0 (smooth) to infinity: the surface is refined by the rules of a crease as often as
/// the sharpness says and smoothly from then on; [`INFINITELY_SHARP`] (10) or more never ends. Knot intervals make the schemes
/// non-uniform: one an edge for Catmull-Clark, one an end of an edge for Doo-Sabin. What is not said costs no memory. The topology is
/// shared between copies.
#[derive(Debug, Clone, PartialEq)]
pub struct Cage {
    pub(crate) points: Vec<Point>,
    pub(crate) topology: Arc<Topology>,
    /// The sharpness of each edge; edges beyond the end have none.
    pub(crate) creases: Vec<f64>,
    /// The sharpness of each vertex; vertices beyond the end have none.
    pub(crate) corners: Vec<f64>,
    /// Whether each face is a hole; faces beyond the end are none.
    pub(crate) holes: Vec<bool>,
    /// The interval of each edge, or nothing where all are 1.
    pub(crate) intervals: Vec<f64>,
    /// The intervals at both ends of each edge, or nothing where all are 1.
    pub(crate) end_intervals: Vec<[f64; 2]>,
    pub(crate) boundary: BoundaryRule,
}

impl Cage {
    /// The cage of a mesh's points and faces. What else the mesh has (normals, materials, loose lines) is not looked at.
    ///
    /// # Errors
    /// As for [`new`](Self::new).
    pub fn from_mesh(mesh: &Mesh) -> Result<Self> {
        Self::from_parts(mesh.points().to_vec(), mesh.corners().to_vec(), mesh.starts())
    }

    /// Pairs of vertices with the same coordinates: the first of each place, and another one. What looks like one vertex in a picture is two to
    /// the scheme, and where a seam runs there, its edges are boundaries. Cost: sorting.
    pub fn coincident(&self) -> Vec<[usize; 2]> {
        // Zeros of either sign are the same.
        let at = |v: usize| self.points[v].coords.map(|c| c + 0.0);
        let by_place = |&a: &usize, &b: &usize| {
            let pairs = at(a).iter().zip(&at(b)).map(|(x, y)| x.total_cmp(y)).find(|order| order.is_ne());
            pairs.unwrap_or(a.cmp(&b))
        };
        let mut order: Vec<usize> = (0..self.points.len()).collect();
        order.sort_unstable_by(by_place);
        let runs = order.chunk_by(|&a, &b| at(a) == at(b));
        let mut pairs: Vec<[usize; 2]> = runs.flat_map(|run| run[1..].iter().map(|&v| [run[0], v])).collect();
        pairs.sort_unstable();
        pairs
    }

    /// The mesh of its points and of the faces that are no holes. Linear.
    ///
    /// # Errors
    /// When a coordinate is not finite: one as large as numbers go may overflow where points are refined.
    pub fn to_mesh(&self) -> Result<Mesh> {
        let topology = &self.topology;
        let (mut corners, mut starts) = (Vec::with_capacity(topology.corner_count()), vec![0]);
        for face in (0..topology.face_count()).filter(|&f| !self.is_hole(f)) {
            corners.extend_from_slice(topology.face(face));
            starts.push(corners.len());
        }
        Ok(Mesh::from_parts(self.points.clone(), corners, starts)?)
    }

    /// The vertices.
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// The vertices, to be moved.
    pub fn points_mut(&mut self) -> &mut [Point] {
        &mut self.points
    }

    /// Who neighbours whom.
    pub fn topology(&self) -> &Topology {
        &self.topology
    }

    /// The same, to be shared with [`from_topology`](Self::from_topology): a cage of other points costs these points.
    pub fn shared_topology(&self) -> Arc<Topology> {
        self.topology.clone()
    }

    /// What becomes of the boundary.
    pub fn boundary(&self) -> BoundaryRule {
        self.boundary
    }

    /// The sharpness that was given to an edge, 0 where none was. A boundary edge is infinitely sharp whatever this says.
    pub fn crease(&self, edge: usize) -> f64 {
        self.creases.get(edge).copied().unwrap_or(0.0)
    }

    /// The sharpness that was given to a vertex, 0 where none was.
    pub fn corner(&self, vertex: usize) -> f64 {
        self.corners.get(vertex).copied().unwrap_or(0.0)
    }

    /// Whether a face is a hole: it takes part in refinement, and is not shown.
    pub fn is_hole(&self, face: usize) -> bool {
        self.holes.get(face).copied().unwrap_or(false)
    }

    /// Whether edges carry knot intervals, so that Catmull-Clark refinement is non-uniform.
    pub fn has_intervals(&self) -> bool {
        !self.intervals.is_empty()
    }

    /// The knot interval of an edge, for Catmull-Clark refinement; 1 where none was given.
    pub fn interval(&self, edge: usize) -> f64 {
        self.intervals.get(edge).copied().unwrap_or(1.0)
    }

    /// Whether ends of edges carry knot intervals, so that Doo-Sabin refinement is non-uniform.
    pub fn has_end_intervals(&self) -> bool {
        !self.end_intervals.is_empty()
    }

    /// The knot intervals of a vertex's own in the direction of an edge, at the edge's two ends (as [`Topology::edge`] lists them),
    /// for Doo-Sabin refinement; 1 where none was given.
    pub fn end_interval(&self, edge: usize) -> [f64; 2] {
        self.end_intervals.get(edge).copied().unwrap_or([1.0; 2])
    }

    /// The sharpness by which an edge is refined: infinite on the boundary.
    #[inline]
    pub(crate) fn sharpness(&self, edge: usize) -> f64 {
        if self.topology.is_boundary_edge(edge) { f64::INFINITY } else { self.crease(edge) }
    }

    /// The sharpness by which a vertex is refined: infinite at corners of the boundary, where these are kept.
    #[inline]
    pub(crate) fn vertex_sharpness(&self, vertex: usize) -> f64 {
        let kept = self.boundary == BoundaryRule::EdgeAndCorner
            && self.topology.is_boundary_vertex(vertex)
            && self.topology.around(vertex).nth(1).is_none();
        if kept { f64::INFINITY } else { self.corner(vertex) }
    }
}

/// What is left of a sharpness after one refinement.
#[inline]
pub(crate) fn decayed(sharpness: f64) -> f64 {
    if sharpness >= INFINITELY_SHARP { sharpness } else { (sharpness - 1.0).max(0.0) }
}
