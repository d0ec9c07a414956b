//! A Brep as a shape: the surfaces of its faces, one after another.

use smallvec::{SmallVec, smallvec};

use super::{BareFace, Brep};
use crate::Point;
use crate::error::{Error, Result};
use crate::shape::{
    Bonds, Cell, Cells, Derivative, Domain, Grid, Interval, Location, Neighbours, Patch, Shape, Share, Sides,
    Splines, Stencil,
};
use crate::solve::Symmetric;
use crate::spline::{Product, Space, smoothness_of_product};

/// Where the cells of each face start, and the number of all.
pub(super) fn cell_starts(faces: &[BareFace]) -> Vec<usize> {
    let mut starts = Vec::with_capacity(faces.len() + 1);
    let mut count = 0_usize;
    for face in faces {
        starts.push(count);
        count = count.saturating_add(face.product(0).cell_count());
    }
    starts.push(count);
    starts
}

impl BareFace {
    /// Its surface without control vertices, of which `first` is the first.
    pub(super) fn product(&self, first: usize) -> Product<'_> {
        let [u, v] = &self.spaces;
        Product { u, v, weights: self.weights.as_deref(), first }
    }

    /// How many control vertices its surface has.
    pub(super) fn vertex_count(&self) -> usize {
        self.spaces[0].len() * self.spaces[1].len()
    }
}

impl Brep {
    /// The surface of a face without its control vertices.
    pub(super) fn product(&self, face: usize) -> Option<Product<'_>> {
        Some(self.faces.get(face)?.product(*self.places.faces.get(face)?))
    }

    /// The face and its parameters that a location is on.
    fn on_face(&self, at: Location) -> Result<(Product<'_>, (f64, f64))> {
        match at {
            Location::Face(face, u, v) => {
                let count = self.faces.len();
                let product = self.product(face as usize).ok_or_else(|| {
                    Error::Invalid(format!("there is no face {face}: the brep has {count}, numbered from 0"))
                })?;
                Ok((product, (u, v)))
            }
            Location::Curve(_) => Err(Error::LocationKind { found: 1, expected: 2 }),
            Location::Surface(..) | Location::Vertex(_) => Err(Error::Invalid(
                "a place on a brep is on one of its faces: give { face = number, uv = [u, v] }".into(),
            )),
        }
    }

    /// The control vertices of a face's surface.
    pub(super) fn range_of(&self, face: usize) -> std::ops::Range<usize> {
        match (self.faces.get(face), self.places.faces.get(face)) {
            (Some(bare), Some(&first)) => first..first + bare.vertex_count(),
            _ => 0..0,
        }
    }

    /// The control vertices of an edge's curve.
    pub(super) fn range_of_edge(&self, edge: usize) -> std::ops::Range<usize> {
        match (self.edges.get(edge), self.places.edges.get(edge)) {
            (Some(bare), Some(&first)) => first..first + bare.space.len(),
            _ => 0..0,
        }
    }
}

fn interval(space: &Space) -> Interval {
    let (start, end) = space.domain();
    Interval { start, end, periodic: space.is_periodic() }
}

/// Its faces' surfaces, whole; parameters are each surface's own. Its edges' curves and its vertices are control vertices too, which no
/// place depends on: they [follow](Shape::follow).
impl Shape for Brep {
    fn control_vertices(&self) -> &[Point] {
        &self.net
    }

    /// Surfaces' control vertices that are moved keep their forms (a plane, a cylinder) until the Brep is
    /// [settled](Shape::settle): see [`with_points`](Brep::with_points) for one that is right at once.
    fn control_vertices_mut(&mut self) -> &mut [Point] {
        self.known = super::flaws::Known::default();
        &mut self.net
    }

    fn stencil(&self, at: Location, derivative: Derivative) -> Result<Stencil> {
        let (product, at) = self.on_face(at)?;
        product.stencil(at, derivative, None)
    }

    fn stencil_on(&self, at: Location, derivative: Derivative, sides: Sides) -> Result<Stencil> {
        let (product, at) = self.on_face(at)?;
        product.stencil(at, derivative, Some(sides))
    }

    fn domain(&self) -> Domain {
        self.face_domain(0)
    }

    /// The domain of the face's surface; the unit square where there is no such face.
    fn face_domain(&self, face: u32) -> Domain {
        match self.faces.get(face as usize) {
            Some(face) => face.spaces.iter().map(interval).collect(),
            None => smallvec![Interval { start: 0.0, end: 1.0, periodic: false }; 2],
        }
    }

    fn faces(&self) -> Option<usize> {
        Some(self.faces.len())
    }

    fn boxed(&self) -> Box<dyn Shape> {
        Box::new(self.clone())
    }

    /// Face by face. The rest of the control vertices, which no surface has, count by themselves.
    fn smoothness(&self, order: usize) -> Option<Symmetric> {
        let mut entries = Vec::new();
        for (face, &first) in self.faces.iter().zip(&self.places.faces) {
            let own = smoothness_of_product(&face.spaces[0], &face.spaces[1], order);
            for i in 0..own.size() {
                entries.extend(own.row(i).filter(|(j, _)| *j <= i).map(|(j, c)| (first + i, first + j, c)));
            }
        }
        let surfaces = self.places.edges.first().copied().unwrap_or(self.places.vertices);
        entries.extend((surfaces..self.net.len()).map(|k| (k, k, 1.0)));
        Some(Symmetric::from_entries(self.net.len(), entries))
    }

    fn cells(&self) -> Option<&dyn Cells> {
        Some(self)
    }

    fn neighbours(&self) -> Option<&dyn Neighbours> {
        Some(self)
    }

    fn bonds(&self) -> Option<&dyn Bonds> {
        Some(self)
    }

    fn follow(&mut self) {
        Brep::follow(self);
    }

    fn settle(&mut self) -> Result<Vec<String>> {
        Brep::settle(self).map(|told| told.iter().map(ToString::to_string).collect())
    }
}

/// Those of its faces' surfaces, whole.
impl Cells for Brep {
    fn count(&self) -> usize {
        self.places.cells.last().copied().unwrap_or(0)
    }

    fn cell(&self, index: usize) -> Option<Cell> {
        let face = self.places.cells.partition_point(|&start| start <= index).checked_sub(1)?;
        self.product(face)?.cell(index - self.places.cells[face], u32::try_from(face).ok())
    }

    fn patch(&self, face: Option<u32>) -> Option<Patch<'_>> {
        let Product { u, v, weights, first } = self.product(face? as usize)?;
        Some(Patch { face, splines: Splines { u, v: Some(v), weights }, first })
    }

    fn patches(&self) -> Vec<Patch<'_>> {
        let patch = |face: usize| self.patch(u32::try_from(face).ok());
        self.may_move().into_iter().filter_map(patch).collect()
    }

    /// Where a face has loops.
    fn is_partial(&self) -> bool {
        self.faces.iter().any(|face| !face.loops.is_empty())
    }

    fn shares(&self) -> Result<Option<Vec<Share>>> {
        self.shares_of_cells()
    }

    fn senses(&self) -> Option<Result<Vec<f64>>> {
        Some(self.senses_of_faces())
    }
}

/// Those beside a vertex in the net of its surface, or of its edge's curve.
impl Neighbours for Brep {
    fn around(&self, vertex: usize) -> SmallVec<[usize; 8]> {
        let before = |starts: &[usize]| starts.partition_point(|&start| start <= vertex).checked_sub(1);
        let row = |space: &Space| Grid {
            rows: 1,
            columns: space.len(),
            rows_wrap: false,
            columns_wrap: space.is_periodic(),
        };
        let (first, grid) = if let Some(edge) = before(&self.places.edges) {
            (self.places.edges[edge], row(&self.edges[edge].space))
        } else if let Some(face) = before(&self.places.faces) {
            let [u, v] = &self.faces[face].spaces;
            let grid = Grid {
                rows: u.len(),
                columns: v.len(),
                rows_wrap: u.is_periodic(),
                columns_wrap: v.is_periodic(),
            };
            (self.places.faces[face], grid)
        } else {
            return SmallVec::new();
        };
        // Beyond the last edge's curve are the vertices, which have no net.
        grid.around(vertex - first).into_iter().map(|k| first + k).collect()
    }
}
