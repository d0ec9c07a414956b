//! A cage made, and what is said of its edges, vertices and faces.

use std::sync::Arc;

use loftsman_kernel::Point;

use super::{BoundaryRule, Cage};
use crate::error::{Result, SubdivisionError};
use crate::topology::Topology;

impl Cage {
    /// The cage of these points and faces; each face lists the indices of its points, counterclockwise from outside. Cost:
    /// linear, but for sorting the edges at each vertex.
    ///
    /// # Errors
    /// When a coordinate is not finite; a face has fewer than three corners, an index that does not exist or a vertex twice; an edge
    /// has three faces, or two that run it the same way; the faces at a vertex make several fans, or there is none.
    pub fn new<F: AsRef<[usize]>>(points: Vec<Point>, faces: &[F]) -> Result<Self> {
        let (mut corners, mut starts) = (Vec::with_capacity(4 * faces.len()), vec![0]);
        for (face, indices) in faces.iter().enumerate() {
            for &index in indices.as_ref() {
                if index >= points.len() {
                    let problem = format!("refers to vertex {index}, but there are only {}", points.len());
                    return Err(SubdivisionError::Face { face, problem });
                }
                corners.push(u32::try_from(index).unwrap_or(u32::MAX));
            }
            starts.push(corners.len());
        }
        Self::from_parts(points, corners, &starts)
    }

    /// The cage of points, corners and face starts (one more than faces, the first 0, the last the number of corners).
    ///
    /// # Errors
    /// As for [`new`](Self::new).
    pub fn from_parts(points: Vec<Point>, corners: Vec<u32>, starts: &[usize]) -> Result<Self> {
        let topology = Topology::new(points.len(), corners, starts)?;
        Self::from_topology(points, Arc::new(topology))
    }

    /// The cage of points over a topology that is there already.
    ///
    /// # Errors
    /// When there are not as many points as vertices, or a coordinate is not finite.
    pub fn from_topology(points: Vec<Point>, topology: Arc<Topology>) -> Result<Self> {
        if points.len() != topology.vertex_count() {
            let vertex = points.len().min(topology.vertex_count());
            let (given, needed) = (points.len(), topology.vertex_count());
            let problem =
                format!("is where points and faces differ: {given} points were given for {needed} vertices");
            return Err(SubdivisionError::Vertex { vertex, problem });
        }
        if let Some((vertex, p)) = points.iter().enumerate().find(|(_, p)| !p.iter().all(|c| c.is_finite())) {
            let problem = format!("is ({}, {}, {}): coordinates must be finite numbers", p.x, p.y, p.z);
            return Err(SubdivisionError::Vertex { vertex, problem });
        }
        Ok(Self {
            points,
            topology,
            creases: Vec::new(),
            corners: Vec::new(),
            holes: Vec::new(),
            intervals: Vec::new(),
            end_intervals: Vec::new(),
            boundary: BoundaryRule::default(),
        })
    }

    /// The cage with this rule for its boundary.
    #[must_use]
    pub fn with_boundary(mut self, rule: BoundaryRule) -> Self {
        self.boundary = rule;
        self
    }

    /// The cage with a sharpness in `[0, ∞]` for the edge between two vertices, in the place of what it had. Cost: the smaller valence, once
    /// the first is said.
    ///
    /// # Errors
    /// When there is no such edge, or the sharpness is negative or NaN.
    pub fn with_crease(mut self, from: usize, to: usize, sharpness: f64) -> Result<Self> {
        let edge = self.edge_between(from, to)?;
        self.creases.resize(self.topology.edge_count(), 0.0);
        self.creases[edge] = checked_sharpness(|| between(from, to), sharpness)?;
        Ok(self)
    }

    /// The cage with a sharpness in `[0, ∞]` for a vertex, in the place of what it had.
    ///
    /// # Errors
    /// When there is no such vertex, or the sharpness is negative or NaN.
    pub fn with_corner(mut self, vertex: usize, sharpness: f64) -> Result<Self> {
        present("vertex", vertex, self.points.len())?;
        self.corners.resize(self.points.len(), 0.0);
        self.corners[vertex] = checked_sharpness(|| format!("vertex {vertex}"), sharpness)?;
        Ok(self)
    }

    /// The cage with a face that is a hole: it takes part in refinement, and is not shown.
    ///
    /// # Errors
    /// When there is no such face.
    pub fn with_hole(mut self, face: usize) -> Result<Self> {
        present("face", face, self.topology.face_count())?;
        self.holes.resize(self.topology.face_count(), false);
        self.holes[face] = true;
        Ok(self)
    }

    /// The cage with a knot interval (0, or between 1e-100 and 1e100) on the edge between two vertices, for Catmull-Clark
    /// refinement. Edges of which nothing is said have 1.
    ///
    /// # Errors
    /// When there is no such edge, or the interval is neither 0 nor between 1e-100 and 1e100.
    pub fn with_interval(mut self, from: usize, to: usize, interval: f64) -> Result<Self> {
        let edge = self.edge_between(from, to)?;
        self.intervals.resize(self.topology.edge_count(), 1.0);
        self.intervals[edge] = checked_interval(|| between(from, to), interval)?;
        Ok(self)
    }

    /// The cage with a knot interval (0, or between 1e-100 and 1e100) that the vertex `at` has in the direction of its edge to
    /// `towards`, for Doo-Sabin refinement, where intervals belong to vertices. Those of which nothing is said are 1.
    ///
    /// # Errors
    /// When there is no such edge, or the interval is neither 0 nor between 1e-100 and 1e100.
    pub fn with_end_interval(mut self, at: usize, towards: usize, interval: f64) -> Result<Self> {
        let edge = self.edge_between(at, towards)?;
        self.end_intervals.resize(self.topology.edge_count(), [1.0; 2]);
        let end = usize::from(self.topology.ends(edge)[0] as usize != at);
        self.end_intervals[edge][end] = checked_interval(|| self::end(at, towards), interval)?;
        Ok(self)
    }

    fn edge_between(&self, from: usize, to: usize) -> Result<usize> {
        self.topology.edge_between(from, to).ok_or(SubdivisionError::NoEdge { from, to })
    }
}

/// An edge, for messages.
pub(crate) fn between(from: usize, to: usize) -> String {
    format!("the edge between vertices {from} and {to}")
}

/// A vertex in the direction of one of its edges, for messages.
pub(crate) fn end(at: usize, towards: usize) -> String {
    format!("vertex {at} towards {towards}")
}

/// Whether there is such a thing.
pub(crate) fn present(what: &'static str, index: usize, count: usize) -> Result<()> {
    if index < count { Ok(()) } else { Err(SubdivisionError::Missing { what, index, count }) }
}

/// A number in `[0, ∞]`.
fn checked_sharpness(place: impl FnOnce() -> String, value: f64) -> Result<f64> {
    let needed = "0 (smooth) or more; 10 is as sharp as can be";
    let wrong = |place| SubdivisionError::Value { what: "sharpness", place, value, needed };
    if value >= 0.0 { Ok(value) } else { Err(wrong(place())) }
}

/// Nothing, or a number whose products with its like neither vanish nor overflow, not even when it was halved a hundred times.
pub(crate) fn checked_interval(place: impl FnOnce() -> String, value: f64) -> Result<f64> {
    let needed = "0, or between 1e-100 and 1e100; only ratios count, so scale all alike";
    let wrong = |place| SubdivisionError::Value { what: "interval", place, value, needed };
    if value == 0.0 || (1e-100..=1e100).contains(&value) { Ok(value) } else { Err(wrong(place())) }
}
