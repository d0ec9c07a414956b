//! The limit surface of a cage under Doo-Sabin subdivision as a shape.

mod declared;
mod edges;
mod layout;
mod leaf;
mod left_out;
mod nets;
mod node;
mod patches;
mod rule;
mod spans;
mod tessellate;

use std::ops::Range;
use std::sync::Arc;

use loftsman_kernel::Point;
use loftsman_kernel::error::Error;
use loftsman_kernel::shape::{
    Cell, CellNet, CellSide, Cells, Chart, Derivative, Domain, Edges, Hole, Interval, Location, Neighbours,
    Shape, Stencil,
};
use smallvec::SmallVec;

use self::layout::{Layout, kind, vanishes};
use self::leaf::Near;
use self::node::Node;
use super::limit::is_uniform;
use super::refine::stencil;
use crate::cage::{Cage, present};
use crate::error::{Result, SubdivisionError};
use crate::natural::seen_from;
use crate::surface::refused;
use crate::topology::NONE;

/// Levels round an extraordinary point down to which there are cells.
const DEPTH: u32 = 8;
/// The largest depth of cells that can be asked for.
const DEEPEST: u32 = 24;
/// Within 2 to minus this of an extraordinary point a place is the point.
const LEVELS: u32 = 40;
/// Vertices round one piece, at most: rows over them are kept densely.
const MOST: usize = 2048;

/// The limit surface of a cage under Doo-Sabin subdivision, as a [`Shape`]: its control vertices are the points of the cage, and each point
/// of the surface is a row over them.
///
/// *Faces.* Each corner of a face of the cage, whose vertex is inside and whose face is no hole, is one face of the surface, numbered in the order
/// of the cage's faces and their corners ([`face_of`](Self::face_of), [`cage_corner`](Self::cage_corner)). The domain of each is `[0, 1]²`:
/// `(0, 0)` is the limit of the middle of the cage's face, `(1, 1)` that of the vertex, `(1, 0)` and `(0, 1)` those of the edge
/// before the corner and of the edge that follows. Where the cage's face is a quad and the vertex has four edges, it is one biquadratic
/// piece.
///
/// *Intervals.* End intervals ([`Cage::with_end_interval`]) make it non-uniform (Sederberg, Zheng, Sewell and Sabin 1998): of a grid the
/// biquadratic spline whose spans they are, a vertex without one a double knot. All along a row of faces vertices have the same across it, on either
/// side of the row's vertices perhaps another; what is round a face that is no quad, or a vertex that has not four edges, may differ from
/// edge to edge. Where a vertex has 0 on a line, its faces have no extent along it: they are lines or points, and triangles leave them out.
///
/// *Boundary.* The surface ends where its last complete pieces do, as a spline with floating ends does: half of a face inside the cage's.
///
/// *Locations.* `Location::Face(face, u, v)`: to rounding exact everywhere, with all derivatives, by refining the piece's neighbourhood
/// until the place is in a biquadratic one (Stam 1998, without eigenvectors). At the middle of a face that is no quad, at the limit of a
/// vertex that has not four edges, and within 2⁻⁴⁰ of these, it is the limit position; first derivatives there are tangents whose
/// lengths say nothing, and higher ones do not exist. `Location::Vertex(vertex)` is the limit of a vertex inside the cage.
///
/// *Energies.* The neighbourhood of an extraordinary point halves from level to level, so that a level adds a quarter of what the one
/// before did to areas. Second derivatives by `u` and `v` grow as fast as it shrinks: the surface is smooth, the parameters are not. So stretch and bend are
/// taken by the coordinates of the characteristic map ([`Cells::chart`]), in which a level adds a quarter to these, too, of what the one before
/// did, or little more; but at an extraordinary point round which intervals differ, where they are taken by `u` and `v`, and the depth is a
/// part of what they are.
///
/// *Cost.* Making one is linear in the cage; a row costs what is near, and in an irregular face that for each level.
#[derive(Debug, Clone)]
pub struct DooSabinSurface {
    cage: Cage,
    layout: Arc<Layout>,
    depth: u32,
}

impl DooSabinSurface {
    /// The limit surface of a cage. Creases, corners and the rule for the boundary say nothing here; knot intervals that are all equal are left out,
    /// for they change nothing. Cost: linear.
    ///
    /// # Errors
    /// When end intervals differ along a row of faces, for then only the limits of faces are known ([`limit_stencils`](super::limit_stencils)), not
    /// places between; when one of 0 is not a double knot, or all are; when the surface is not smooth by them at a face or vertex of five
    /// edges and more; when an inner vertex has two edges; when no piece is left.
    pub fn new(cage: Cage) -> Result<Self> {
        Self::with_depth(cage, DEPTH)
    }

    /// The same with cells down to a depth from 1 to 24, 8 for [`new`](Self::new): the number of levels round an extraordinary point that
    /// integrals are taken over. What is left out has `4^-depth` of the parameters of each face there, and about that share of its area; volumes have
    /// [cones](Cells::holes) there instead, and are off by some `16^-depth`.
    ///
    /// # Errors
    /// As for [`new`](Self::new); when the depth is another.
    pub fn with_depth(mut cage: Cage, depth: u32) -> Result<Self> {
        if !(1..=DEEPEST).contains(&depth) {
            let (place, value) = ("cells".to_owned(), f64::from(depth));
            return Err(SubdivisionError::Value { what: "depth", place, value, needed: "from 1 to 24" });
        }
        if is_uniform(&cage) {
            cage.end_intervals = Vec::new();
        }
        cage.intervals = Vec::new();
        (cage.creases, cage.corners) = (Vec::new(), Vec::new());
        let layout = Arc::new(Layout::new(&cage, depth)?);
        Ok(Self { cage, layout, depth })
    }

    /// The cage.
    pub fn cage(&self) -> &Cage {
        &self.cage
    }

    /// The cage, taken out.
    pub fn into_cage(self) -> Cage {
        self.cage
    }

    /// The depth of cells round extraordinary points.
    pub fn depth(&self) -> u32 {
        self.depth
    }

    /// The number of the surface's face at a corner of a face of the cage; `None` where the vertex is on the boundary or the face is a hole.
    ///
    /// # Errors
    /// When there is no such face or corner.
    pub fn face_of(&self, face: usize, corner: usize) -> Result<Option<u32>> {
        let topology = self.cage.topology();
        present("face", face, topology.face_count())?;
        let corners = topology.face_corners(face);
        present("corner", corner, corners.len())?;
        let own = self.layout.faces[corners.start + corner];
        Ok((own != NONE).then_some(own))
    }

    /// The face of the cage, and its corner, that a face of the surface belongs to.
    ///
    /// # Errors
    /// When there is no such face.
    pub fn cage_corner(&self, face: u32) -> Result<(usize, usize)> {
        present("face of the surface", face as usize, self.layout.corners.len())?;
        let (topology, half) = (self.cage.topology(), self.layout.corners[face as usize]);
        let of = topology.face_of(half) as usize;
        Ok((of, half as usize - topology.face_corners(of).start))
    }

    /// Whether a face is one biquadratic piece.
    ///
    /// # Errors
    /// When there is no such face.
    pub fn is_regular(&self, face: u32) -> Result<bool> {
        present("face of the surface", face as usize, self.layout.corners.len())?;
        Ok(kind(&self.cage, self.layout.corners[face as usize]) == 0)
    }

    /// Whether all faces are.
    fn is_all_regular(&self) -> bool {
        self.layout.corners.iter().all(|&half| kind(&self.cage, half) == 0)
    }

    /// The corners of the cage in the rings round a piece: vertices of the cage refined once.
    fn rings(&self, half: u32) -> [Vec<u32>; 4] {
        let topology = self.cage.topology();
        let own = topology.face_corners(topology.face_of(half) as usize);
        let (first, size) = (own.start, own.len());
        let at = half as usize - first;
        let face = (0..size).map(|k| (first + (at + k) % size) as u32).collect();
        let before = topology.previous(half);
        let (twin, over) = (topology.twin(before), topology.twin(half));
        let mut round = vec![half];
        let mut next = twin;
        while next != half && next != NONE {
            round.push(next);
            next = topology.twin(topology.previous(next));
        }
        [
            face,
            vec![half, before, topology.next(twin), twin],
            round,
            vec![half, topology.next(over), over, topology.next(half)],
        ]
    }

    /// The surroundings of a face. Cost, where it was not asked for last: the vertices that it depends on times the corners round it.
    fn near(&self, face: usize) -> Result<Arc<Near>> {
        self.layout.kept.near(face, || self.rows(face))
    }

    fn rows(&self, face: usize) -> Result<Near> {
        let topology = self.cage.topology();
        let half = self.layout.corners[face];
        let vertex = topology.origin(half) as usize;
        let faces = topology.vertex_faces(vertex);
        let mut base: Vec<usize> =
            faces.flat_map(|f| topology.face(f as usize).iter().map(|&v| v as usize)).collect();
        base.sort_unstable();
        base.dedup();
        if base.len() > MOST {
            let problem = format!(
                "has {} vertices in the faces round it, and at most {MOST} can be looked at: refine the cage, or divide its largest faces \
                 and fans",
                base.len()
            );
            return Err(SubdivisionError::Vertex { vertex, problem });
        }
        let mut rings: [Vec<Vec<f64>>; 4] = Default::default();
        for (rows, ring) in rings.iter_mut().zip(self.rings(half)) {
            for corner in ring {
                let mut row = vec![0.0; base.len()];
                for (v, c) in stencil(&self.cage, corner as usize)?.iter() {
                    if let Ok(at) = base.binary_search(&v) {
                        row[at] += c;
                    }
                }
                rows.push(row);
            }
        }
        Ok(Near { base, node: Node { rings, rules: self.layout.spans.rules(&self.cage, half) } })
    }

    /// Whether a place is an extraordinary point of a face, by the corner that it is at.
    fn extraordinary(&self, face: usize, u: f64, v: f64) -> Option<usize> {
        let kind = kind(&self.cage, self.layout.corners[face]);
        let near = |a: f64, b: f64| f64::max((u - a).abs(), (v - b).abs()) < 0.5_f64.powi(LEVELS as i32);
        match kind {
            _ if kind & 1 == 1 && near(0.0, 0.0) => Some(0),
            _ if kind & 2 == 2 && near(1.0, 1.0) => Some(2),
            _ => None,
        }
    }

    fn on_face(&self, face: u32, u: f64, v: f64, by: Derivative) -> loftsman_kernel::error::Result<Stencil> {
        let count = self.layout.corners.len();
        let face = face as usize;
        if face >= count {
            let problem = format!("is not there: the surface has {count}, numbered from 0");
            return Err(Error::Face { face, problem });
        }
        for value in [u, v] {
            if !(0.0..=1.0).contains(&value) {
                return Err(Error::Outside { value, start: 0.0, end: 1.0 });
            }
        }
        let near = self.near(face).map_err(refused)?;
        let node = &near.node;
        let back = |row: &[f64]| -> Stencil {
            near.base.iter().zip(row).filter(|(_, c)| **c != 0.0).map(|(&v, &c)| (v, c)).collect()
        };
        // Exactly zero, and not what rounding leaves of three equal vertices.
        if node.vanishes().into_iter().zip([by.u, by.v]).any(|(vanishes, order)| vanishes && order > 0) {
            return Ok(std::iter::empty::<(usize, f64)>().collect());
        }
        if let Some(corner) = self.extraordinary(face, u, v) {
            let (position, [along_u, along_v]) = node.corner(corner);
            let (of, at) = self.cage_corner(face as u32).map_err(refused)?;
            return match (by.u, by.v) {
                (0, 0) => Ok(back(&position)),
                (1, 0) => Ok(back(&along_u)),
                (0, 1) => Ok(back(&along_v)),
                (a, b) => Err(Error::Invalid(format!(
                    "a derivative [{a}, {b}] at the {} of corner {at} of face {of} of the cage: an extraordinary point has a position [0, 0] and \
                     two tangents [1, 0], [0, 1]; ask for others beside it",
                    if corner == 0 { "face" } else { "vertex" }
                ))),
            };
        }
        match self.layout.kept.leaf(face, &near, [u, v], LEVELS + 16) {
            Some(leaf) => Ok(leaf.stencil([u, v], by)),
            None => {
                Err(Error::Invalid(format!("[{u}, {v}] of face {face} is too near an extraordinary point")))
            }
        }
    }

    fn on_vertex(&self, vertex: u32, by: Derivative) -> loftsman_kernel::error::Result<Stencil> {
        let (topology, count) = (self.cage.topology(), self.cage.points().len());
        if vertex as usize >= count {
            return Err(Error::NoVertex { index: i64::from(vertex), count });
        }
        let is_there = |h: &u32| self.layout.faces[*h as usize] != NONE;
        let has_extent = |h: &u32| is_there(h) && (0..2).all(|side| !vanishes(&self.cage, *h, side));
        let mut around = topology.around(vertex as usize);
        let half = around.clone().find(has_extent).or_else(|| around.find(is_there));
        match half.map(|h| self.layout.faces[h as usize]) {
            Some(face) => self.on_face(face, 1.0, 1.0, by),
            None => Err(Error::Invalid(format!(
                "vertex {vertex} is on the boundary of the cage, or has nothing but holes round it, where there is no surface: ask of a vertex inside"
            ))),
        }
    }
}

impl Shape for DooSabinSurface {
    fn control_vertices(&self) -> &[Point] {
        self.cage.points()
    }

    fn control_vertices_mut(&mut self) -> &mut [Point] {
        self.cage.points_mut()
    }

    fn stencil(&self, at: Location, by: Derivative) -> loftsman_kernel::error::Result<Stencil> {
        let order = by.u.max(by.v);
        if order > loftsman_kernel::error::MAX_DEGREE {
            return Err(Error::DerivativeOrder { order });
        }
        match at {
            Location::Face(face, u, v) => self.on_face(face, u, v, by),
            Location::Vertex(vertex) => self.on_vertex(vertex, by),
            Location::Curve(_) | Location::Surface(..) => Err(Error::Invalid(format!(
                "{at} is no place of a subdivision surface, which has many faces: give {{ face = number, uv = [u, v] }} or {{ vertex = number \
                 }}"
            ))),
        }
    }

    fn domain(&self) -> Domain {
        [Interval { start: 0.0, end: 1.0, periodic: false }; 2].into_iter().collect()
    }

    fn faces(&self) -> Option<usize> {
        Some(self.layout.corners.len())
    }

    fn boxed(&self) -> Box<dyn Shape> {
        Box::new(self.clone())
    }

    fn cells(&self) -> Option<&dyn Cells> {
        Some(self)
    }

    fn edges(&self) -> Option<&dyn Edges> {
        Some(self)
    }

    fn neighbours(&self) -> Option<&dyn Neighbours> {
        Some(self)
    }
}

/// Vertices with a common edge.
impl Neighbours for DooSabinSurface {
    fn around(&self, vertex: usize) -> SmallVec<[usize; 8]> {
        let topology = self.cage.topology();
        if vertex >= topology.vertex_count() {
            return SmallVec::new();
        }
        let edges = topology.vertex_edges(vertex);
        let mut all: SmallVec<[usize; 8]> = edges.map(|edge| topology.other_end(edge, vertex)).collect();
        all.sort_unstable();
        all
    }
}

/// A regular face is one cell; of another the quadrants down to the surface's depth that are biquadratic.
impl Cells for DooSabinSurface {
    fn count(&self) -> usize {
        self.layout.cells.last().copied().unwrap_or(0)
    }

    fn cell(&self, index: usize) -> Option<Cell> {
        if index >= Cells::count(self) {
            return None;
        }
        let face = self.layout.cells.partition_point(|&first| first <= index).checked_sub(1)?;
        let half = *self.layout.corners.get(face)?;
        let quadrant = *self.layout.quadrants[kind(&self.cage, half)].get(index - self.layout.cells[face])?;
        let size = 0.5_f64.powi(quadrant.level as i32);
        let side = |k: u64| CellSide { start: k as f64 * size, end: (k + 1) as f64 * size, degree: 2 };
        let middle = |k: u64| (k as f64 + 0.5) * size;
        // Where a neighbourhood is too large for rows, the cell has no vertices, and whoever asks for rows there is told why.
        let place = [middle(quadrant.i), middle(quadrant.j)];
        let leaf =
            self.near(face).ok().and_then(|near| self.layout.kept.leaf(face, &near, place, quadrant.level));
        let vertices = leaf.map_or_else(SmallVec::new, |leaf| leaf.vertices.iter().copied().collect());
        let sides = [side(quadrant.i), side(quadrant.j)].into_iter().collect();
        Some(Cell { face: Some(face as u32), sides, rational: false, vertices })
    }

    /// The quadrants of the last level at extraordinary points, as large on all faces round one. Where the surface ends at one it does so with
    /// pieces without number, and no border is along its end.
    fn holes(&self) -> Vec<Hole> {
        let mut all = Vec::new();
        for (face, &half) in (0..).zip(&self.layout.corners) {
            let rims = &self.layout.rims[kind(&self.cage, half)];
            all.extend(rims.iter().map(|rim| rim.hole(face, 2, [&[], &[]])));
        }
        all
    }

    /// A limit surface has no gaps.
    fn always_meet(&self) -> bool {
        true
    }

    fn nets(
        &self,
        numbers: Range<usize>,
        origin: &Point,
        each: &mut dyn FnMut(CellNet<'_>),
    ) -> Option<loftsman_kernel::error::Result<()>> {
        Some(self.nets_of(numbers, origin, each))
    }

    /// The characteristic map of the extraordinary point that is nearest: of the middle of a face that is no quad, or the limit of a vertex that has not
    /// four edges.
    fn chart(&self, at: Location) -> Option<Chart> {
        let Location::Face(face, u, v) = at else { return None };
        let half = *self.layout.corners.get(face as usize)?;
        let topology = self.cage.topology();
        let corner = [0, 2].into_iter().find(|&k| seen_from(k, [u, v]).into_iter().all(|x| x <= 0.5))?;
        let (face, vertex) = (topology.face_of(half) as usize, topology.origin(half) as usize);
        let (n, is_uneven) = match corner {
            0 => (topology.face_corners(face).len(), self.layout.spans.is_uneven_face(face)),
            _ => (topology.around(vertex).count(), self.layout.spans.is_uneven_vertex(&self.cage, vertex)),
        };
        if n == 4 || is_uneven { None } else { self.layout.naturals.chart(n, corner, [u, v], 0.5) }
    }
}
