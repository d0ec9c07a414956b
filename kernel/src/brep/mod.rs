//! Boundary representations: faces on surfaces, bounded by edges that they share, and what closed shells of them bound.
//!
//! A [`Brep`] is built from its [`Parts`], which name one another by their numbers, and is checked then: every number is one, loops are
//! chains that close, the shells of solids close, all with reasons. How far edges are from the surfaces that they lie on is
//! [measured](Brep::flaws) apart, since real files are not exact.
//!
//! All control vertices of a Brep are one list, [`points`](Brep::points): those of its surfaces, face after face, then those of
//! its edges' curves, then its vertices.

mod block;
mod build;
mod closest;
mod covering;
pub mod drawn;
mod flaws;
mod inside;
mod loose;
mod moved;
mod nesting;
mod parts;
mod projection;
mod shape;

#[cfg(test)]
mod tests;

pub use closest::FacePlace;
pub use flaws::Flaw;
pub use loose::{Moving, Opening};
pub use nesting::{LoopFlaw, is_around};
pub use parts::{Edge, Face, Parts, Shell, Solid, Use, Vertex};
pub use projection::Projected;

pub use crate::spline::form::{CurveForm, Frame, SurfaceForm};

use crate::Point;
use crate::spline::{Curve, Space, Surface};

/// Faces on surfaces that share their edges.
#[derive(Debug, Clone, PartialEq)]
pub struct Brep {
    /// Surfaces' control vertices, then curves', then vertices.
    net: Vec<Point>,
    /// Which of them belong to which face and to which edge.
    places: Places,
    faces: Vec<BareFace>,
    edges: Vec<BareEdge>,
    tolerances: Vec<f64>,
    shells: Vec<Shell>,
    solids: Vec<Solid>,
    /// For each edge the places where it is used: face, loop, number in the loop.
    uses: Vec<Vec<UsePlace>>,
    motion: loose::Motion,
    known: flaws::Known,
}

/// Where in the list of control vertices things start.
#[derive(Debug, Clone, PartialEq, Default)]
struct Places {
    faces: Vec<usize>,
    edges: Vec<usize>,
    vertices: usize,
    /// Where the polynomial pieces of each face start among those of all, and their number.
    cells: Vec<usize>,
}

/// A face without the control vertices of its surface.
#[derive(Debug, Clone, PartialEq)]
struct BareFace {
    name: Option<String>,
    color: Option<[f64; 4]>,
    spaces: [Space; 2],
    weights: Option<Vec<f64>>,
    form: SurfaceForm,
    reversed: bool,
    loops: Vec<Vec<Use>>,
    points: Vec<usize>,
}

/// An edge without the control vertices of its curve.
#[derive(Debug, Clone, PartialEq)]
struct BareEdge {
    space: Space,
    weights: Option<Vec<f64>>,
    range: (f64, f64),
    ends: [usize; 2],
    tolerance: f64,
    form: CurveForm,
}

/// Where an edge is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct UsePlace {
    /// The face.
    pub face: usize,
    /// The number of its loop.
    pub chain: usize,
    /// The number in the loop.
    pub number: usize,
}

impl Brep {
    /// All control vertices: those of its surfaces, face after face, row after row; those of its edges' curves; its vertices.
    pub fn points(&self) -> &[Point] {
        &self.net
    }

    /// How many faces there are.
    pub fn face_count(&self) -> usize {
        self.faces.len()
    }

    /// How many edges there are.
    pub fn edge_count(&self) -> usize {
        self.edges.len()
    }

    /// The vertices' points.
    pub fn vertices(&self) -> &[Point] {
        &self.net[self.places.vertices..]
    }

    /// How far from each vertex the ends of its edges may be.
    pub fn tolerances(&self) -> &[f64] {
        &self.tolerances
    }

    /// The shells.
    pub fn shells(&self) -> &[Shell] {
        &self.shells
    }

    /// The solids.
    pub fn solids(&self) -> &[Solid] {
        &self.solids
    }

    /// The surface of a face: a copy, `O(vertices)`. `None` where there is no such face.
    pub fn surface(&self, face: usize) -> Option<Surface> {
        let bare = self.faces.get(face)?;
        let [u, v] = bare.spaces.clone();
        let first = self.places.faces[face];
        let points = self.net[first..first + u.len() * v.len()].to_vec();
        Surface::build(u, v, points, bare.weights.clone()).ok()
    }

    /// The curve of an edge: a copy, `O(vertices)`. `None` where there is no such edge.
    pub fn curve(&self, edge: usize) -> Option<Curve> {
        let bare = self.edges.get(edge)?;
        let first = self.places.edges[edge];
        let points = self.net[first..first + bare.space.len()].to_vec();
        Curve::build(bare.space.clone(), points, bare.weights.clone()).ok()
    }

    /// A face whole: a copy. `None` where there is no such face.
    pub fn face(&self, face: usize) -> Option<Face> {
        let bare = self.faces.get(face)?;
        Some(Face {
            name: bare.name.clone(),
            color: bare.color,
            surface: self.surface(face)?,
            form: bare.form,
            reversed: bare.reversed,
            loops: bare.loops.clone(),
            points: bare.points.clone(),
        })
    }

    /// An edge whole: a copy. `None` where there is no such edge.
    pub fn edge(&self, edge: usize) -> Option<Edge> {
        let bare = self.edges.get(edge)?;
        Some(Edge {
            curve: self.curve(edge)?,
            range: bare.range,
            ends: bare.ends,
            tolerance: bare.tolerance,
            form: bare.form,
        })
    }

    /// The loops of a face; none where there is no such face.
    pub fn loops(&self, face: usize) -> &[Vec<Use>] {
        self.faces.get(face).map_or(&[], |face| &face.loops)
    }

    /// The vertices that are alone in a face.
    pub fn lone_vertices(&self, face: usize) -> &[usize] {
        self.faces.get(face).map_or(&[], |face| &face.points)
    }

    /// What a face is called.
    pub fn face_name(&self, face: usize) -> Option<&str> {
        self.faces.get(face)?.name.as_deref()
    }

    /// The colour of a face where it has one of its own.
    pub fn face_color(&self, face: usize) -> Option<[f64; 4]> {
        self.faces.get(face)?.color
    }

    /// What the surface of a face is beside a spline.
    pub fn surface_form(&self, face: usize) -> SurfaceForm {
        self.faces.get(face).map(|face| face.form).unwrap_or_default()
    }

    /// Whether the normal of a face is `-S_u × S_v`.
    pub fn is_reversed(&self, face: usize) -> bool {
        self.faces.get(face).is_some_and(|face| face.reversed)
    }

    /// The vertices at the start and at the end of an edge. `None` where there is no such edge.
    pub fn ends(&self, edge: usize) -> Option<[usize; 2]> {
        Some(self.edges.get(edge)?.ends)
    }

    /// Where in the loops an edge is used; nowhere where no face has it.
    pub fn uses(&self, edge: usize) -> &[UsePlace] {
        self.uses.get(edge).map_or(&[], Vec::as_slice)
    }

    /// The edges that some faces do not close at: those that are not used twice among them, once in each direction, ascending.
    /// `O(uses)`.
    pub fn open_edges(&self, faces: &[usize]) -> Vec<usize> {
        let mut turns = std::collections::BTreeMap::new();
        for one in faces.iter().flat_map(|&face| self.loops(face)).flatten() {
            let [along, against] = turns.entry(one.edge).or_insert([0_usize; 2]);
            *(if one.reversed { against } else { along }) += 1;
        }
        turns.into_iter().filter(|(_, turns)| *turns != [1, 1]).map(|(edge, _)| edge).collect()
    }

    /// Whether some faces close: no edge of them is [open](Self::open_edges), and a face without edges is a closed surface.
    pub fn is_closed(&self, faces: &[usize]) -> bool {
        let whole = |face: usize| {
            self.loops(face).is_empty() && !self.surface(face).is_some_and(|surface| build::closes(&surface))
        };
        self.open_edges(faces).is_empty() && !faces.iter().any(|&face| whole(face))
    }

    /// All its parts: copies, `O(vertices)`. [`new`](Self::new) makes the same Brep of them.
    pub fn parts(&self) -> Parts {
        let vertices = self.vertices().iter().zip(&self.tolerances);
        Parts {
            vertices: vertices.map(|(&point, &tolerance)| Vertex { point, tolerance }).collect(),
            edges: (0..self.edges.len()).filter_map(|edge| self.edge(edge)).collect(),
            faces: (0..self.faces.len()).filter_map(|face| self.face(face)).collect(),
            shells: self.shells.clone(),
            solids: self.solids.clone(),
        }
    }
}
