//! The limit surface of a cage as a shape: edited, faired, measured and joined like any other.

pub(crate) mod apart;
mod cells;
mod cut;
pub(crate) mod declared;
mod edges;
pub(crate) mod facing;
pub(crate) mod fill;
pub(crate) mod grids;
mod ground;
pub(crate) mod holes;
mod last;
mod layout;
mod leaf;
pub(crate) mod left_out;
mod local;
pub(crate) mod net;
mod nets;
mod normals;
pub(crate) mod patches;
pub(crate) mod pattern;
pub(crate) mod places;
pub(crate) mod quads;
mod regular;
mod sampled;
mod sided;
mod spans;
mod template;
pub(crate) mod tessellate;
mod tree;
mod uneven;

use std::sync::Arc;

use loftsman_kernel::Point;
use loftsman_kernel::error::Error;
use loftsman_kernel::shape::{
    Cells, Derivative, Domain, Edges, Interval, Location, Neighbours, Shape, Stencil,
};
use smallvec::SmallVec;

use crate::cage::{Cage, present};
use crate::catmull_clark::{limit_position, limit_stencils};
use crate::error::{Result, SubdivisionError};
use crate::topology::NONE;

pub use left_out::LeftOut;
pub use patches::Patches;

use layout::Layout;
pub(crate) use spans::same;

/// Levels below the last on which anything is sharp to a finite degree, down to which there are cells.
const DEPTH: u32 = 8;
/// The largest depth of cells that can be asked for.
const DEEPEST: u32 = 24;
/// Within 2 to minus this of an extraordinary vertex a place is the vertex.
const LEVELS: u32 = 40;

/// The limit surface of a cage under Catmull-Clark subdivision, as a [`Shape`]: its control vertices are the points of the cage, and
/// each point of the surface is a row over them.
///
/// *Faces.* A quad of the cage that is no hole is one face, another face one for each corner; they are numbered in the order of the
/// cage's faces and their corners ([`face_of`](Self::face_of), [`cage_face`](Self::cage_face)). The domain of each is `[0, 1]²`. On a
/// quad `u` runs along the first edge and `v` from it; on the part of another face, from its corner, `u` along the edge that follows
/// (to its middle) and `v` along the one before, and `(1, 1)` is the middle.
///
/// *Locations.* `Location::Face(face, u, v)`: to rounding exact everywhere, with all derivatives, by refining the face's neighbourhood
/// until the place is in a bicubic piece (Stam 1998, without eigenvectors, which makes creases of any sharpness no other case). At an
/// extraordinary vertex itself, and within 2⁻⁴⁰ of it, it is the limit position; first derivatives there are tangents whose lengths say
/// nothing, and higher ones do not exist. `Location::Vertex(vertex)` is the limit of a vertex of the cage, `[1, 0]` and `[0, 1]` two
/// tangents there, refused where each side has its own (a crease that is sharp for ever, a corner of several faces).
///
/// *Knot intervals.* Where opposite edges of every quad have the same (a row of faces has one interval, as the knots of a tensor-product
/// spline), the surface consists of bicubic pieces again: of a grid it is the spline with these knots, and round an extraordinary vertex
/// there are rings of pieces, whatever the intervals of the vertex's edges are. Faces keep `[0, 1]²`. At extraordinary vertices tangents span the
/// tangent plane, in no particular direction. A face whose interval in one direction is 0 is a curve, or a point.
///
/// *Cost.* Making one is linear in the cage. A row costs what is near, whatever the size of the cage: some 2 µs where the face is regular.
/// Where it is not, faces with the same surroundings (the same valences and creases, whatever their places) have the same pieces: the
/// first of them costs some 30 µs for each level, all others what regular ones cost. A face of which several corners are not regular, and one
/// that is no quad, is refined once for that, which costs some 20 µs: its parts have one such corner each, and so few kinds of surroundings, however
/// irregular the cage. Many places in one piece cost less than 1 µs each.
///
/// # Example
///
/// ```
/// use loftsman_kernel::Point;
/// use loftsman_kernel::edit::{Ask, Edit};
/// use loftsman_kernel::functional::position;
/// use loftsman_kernel::shape::{Derivative, Location, Shape};
/// use loftsman_subdivision::{Cage, SubdivisionSurface};
///
/// let corner = |k: usize| Point::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
/// let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
/// let cube = SubdivisionSurface::new(Cage::new((0..8).map(corner).collect(), &faces)?)?;
/// let wanted = Point::new(0.9, 0.9, 0.9);
/// let edited = Edit::new(&cube).ask(position(Location::Vertex(7)).to(wanted)).solve()?;
/// let there = edited.shape().value(Location::Vertex(7), Derivative::POSITION)?;
/// assert!((there - wanted.coords).norm() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct SubdivisionSurface {
    cage: Cage,
    layout: Arc<Layout>,
    depth: u32,
}

impl SubdivisionSurface {
    /// The limit surface of a cage. Knot intervals that are all equal are left out, for they change nothing. Cost: linear; with knot
    /// intervals some microseconds a face more.
    ///
    /// # Errors
    /// When knot intervals differ on opposite edges of a quad (of another face: on an edge and the next but one): the surface there consists of
    /// no pieces, and only the limits of vertices are known ([`limit_stencils`]); when all faces are holes.
    pub fn new(cage: Cage) -> Result<Self> {
        Self::with_depth(cage, DEPTH)
    }

    /// The same with cells down to a depth from 1 to 24, 8 for [`new`](Self::new): the number of levels round an extraordinary vertex
    /// that integrals are taken over.
    ///
    /// What is left out has `4^-depth` of the parameters of each face there. Its share of the face's area goes down by `λ²` a level, where
    /// the sub-dominant eigenvalue `λ` is 0.41 for valence 3, 0.55 for 5, 0.58 for 6 and less than 0.66 for any: at depth 8 some `1e-6`,
    /// `1e-4`, `2e-4` of it. Volumes have [cones](Cells::holes) there instead, and are off by what goes down by `λ² μ` a level, where the next eigenvalue that does
    /// not turn, `μ`, is 0.17 for valence 3, 0.32 for 5, 0.38 for 6: at depth 8 some `1e-9` of all for 5, `5e-9` for 6. [`left_out`](Self::left_out) computes bounds of both.
    ///
    /// Second derivatives by `u` and `v` have a finite energy only where all valences are 3 and 4: with 5 edges what a level adds to it grows by `4 λ²`, 1.21,
    /// from one to the next. So round an inner vertex where nothing is sharp, stretch and bend are taken by the coordinates of its characteristic map
    /// ([`Cells::chart`]), where what a level adds falls to `(μ/λ)²` of it, `μ` being the next eigenvalue: 0.17 for 3 edges, 0.38 for 5, 0.50 for 6, at depth 8
    /// some 1e-6, 4e-4 and 4e-3 of the energy is left out. At creases, corners and on the boundary, and with knot intervals, it is taken by `u` and `v`, and the depth is a
    /// part of what it is.
    ///
    /// # Errors
    /// As for [`new`](Self::new); when the depth is another.
    pub fn with_depth(mut cage: Cage, depth: u32) -> Result<Self> {
        if !(1..=DEEPEST).contains(&depth) {
            let (place, value) = ("cells".to_owned(), f64::from(depth));
            return Err(SubdivisionError::Value { what: "depth", place, value, needed: "from 1 to 24" });
        }
        if crate::catmull_clark::is_uniform(&cage) {
            cage.intervals = Vec::new();
        }
        cage.end_intervals = Vec::new();
        if let Some(face) = spans::uneven_face(&cage) {
            return Err(uneven::differs(&cage, face));
        }
        if let Some(edge) = spans::vanishing_edge(&cage) {
            return Err(uneven::vanishes(&cage, edge));
        }
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

    /// The depth of cells round extraordinary vertices.
    pub fn depth(&self) -> u32 {
        self.depth
    }

    /// The number of the surface's face on a face of the cage: of a quad the one that it is, whatever the corner, of another face that
    /// at one of its corners. `None` for a hole.
    ///
    /// # Errors
    /// When there is no such face or corner.
    pub fn face_of(&self, face: usize, corner: usize) -> Result<Option<u32>> {
        let topology = self.cage.topology();
        present("face", face, topology.face_count())?;
        let corners = topology.face_corners(face).len();
        present("corner", corner, corners)?;
        let first = self.layout.first[face];
        Ok((first != NONE).then(|| first + if corners == 4 { 0 } else { corner as u32 }))
    }

    /// The face of the cage that a face of the surface is on, and its corner where that is no quad.
    ///
    /// # Errors
    /// When there is no such face.
    pub fn cage_face(&self, face: u32) -> Result<(usize, Option<usize>)> {
        let all = &self.layout.faces;
        let [of, corner] = *all.get(face as usize).ok_or(SubdivisionError::Missing {
            what: "face of the surface",
            index: face as usize,
            count: all.len(),
        })?;
        Ok((of as usize, (corner != NONE).then_some(corner as usize)))
    }

    /// The place of a vertex of the cage on its first face that is shown. `None` where all its faces are holes.
    ///
    /// # Errors
    /// When there is no such vertex.
    pub fn place_of(&self, vertex: usize) -> Result<Option<Location>> {
        let topology = self.cage.topology();
        present("vertex", vertex, topology.vertex_count())?;
        for half in topology.around(vertex) {
            let face = topology.face_of(half) as usize;
            let corners = topology.face_corners(face);
            let corner = half as usize - corners.start;
            if let Some(own) = self.face_of(face, corner)? {
                let at = if corners.len() == 4 { corner } else { 0 };
                let (u, v) = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)][at];
                return Ok(Some(Location::Face(own, u, v)));
            }
        }
        Ok(None)
    }

    /// Whether a face is one bicubic piece.
    ///
    /// # Errors
    /// When there is no such face.
    pub fn is_regular(&self, face: u32) -> Result<bool> {
        present("face of the surface", face as usize, self.layout.faces.len())?;
        Ok(self.layout.pattern(face as usize).is_regular(pattern::Quadrant::WHOLE))
    }

    /// Whether all faces at a vertex are holes.
    fn is_hidden(&self, vertex: usize) -> bool {
        !self.cage.holes.is_empty()
            && self.cage.topology().vertex_faces(vertex).all(|face| self.cage.is_hole(face as usize))
    }

    /// Whether a face has no extent along `u`, and along `v`: where a knot interval of its is zero.
    fn vanishes(&self, face: usize) -> [bool; 2] {
        let [of, part] = self.layout.faces[face];
        if part != NONE || !self.cage.has_intervals() {
            return [false; 2];
        }
        let edges = self.cage.topology().face_edges(of as usize);
        [0, 1].map(|k| self.cage.interval(edges[k] as usize) <= 0.0)
    }

    fn on_face(&self, face: u32, u: f64, v: f64, by: Derivative) -> loftsman_kernel::error::Result<Stencil> {
        let count = self.layout.faces.len();
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
        let pattern = self.layout.pattern(face);
        let near = 0.5_f64.powi(LEVELS as i32);
        for (corner, (a, b)) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].into_iter().enumerate() {
            if pattern.corners[corner].extraordinary && f64::max((u - a).abs(), (v - b).abs()) < near {
                let [of, part] = self.layout.faces[face];
                let place = || match part {
                    NONE => format!("corner {corner} of face {of} of the cage"),
                    _ => format!("corner {corner} of part {part} of face {of} of the cage"),
                };
                if self.cage.has_intervals() {
                    return self.uneven_corner(face, corner, by);
                }
                if by == Derivative::POSITION {
                    return leaf::position(&self.cage, &self.layout, face, corner).map_err(refused);
                }
                let limit = leaf::limit(&self.cage, &self.layout, face, corner).map_err(refused)?;
                return of_limit(limit, by, place);
            }
        }
        // Exactly zero, and not what rounding leaves of vertices in one place.
        if self.vanishes(face).into_iter().zip([by.u, by.v]).any(|(vanishes, order)| vanishes && order > 0) {
            return Ok(Stencil::new());
        }
        let found = leaf::leaf(&self.cage, &self.layout, face, (u, v), LEVELS + 16).map_err(refused)?;
        match found {
            Some(leaf) => Ok(leaf.stencil(u, v, by)),
            None => {
                Err(Error::Invalid(format!("[{u}, {v}] of face {face} is too near an extraordinary vertex")))
            }
        }
    }
}

/// What is asked of the limit of a vertex.
fn of_limit(
    limit: crate::LimitStencils,
    by: Derivative,
    place: impl Fn() -> String,
) -> loftsman_kernel::error::Result<Stencil> {
    let [u, v] = limit.tangents;
    match (by.u, by.v) {
        (0, 0) => Ok(limit.position),
        (1, 0) => Ok(u),
        (0, 1) => Ok(v),
        (a, b) => Err(Error::Invalid(format!(
            "a derivative [{a}, {b}] at {}: the limit of a vertex has a position [0, 0] and two tangents [1, 0], [0, 1]; ask for others \
             beside it",
            place()
        ))),
    }
}

/// What a cage refuses, as what the kernel does.
pub(crate) fn refused(error: SubdivisionError) -> Error {
    match error {
        SubdivisionError::Kernel(error) => error,
        other => Error::Invalid(other.to_string()),
    }
}

impl Shape for SubdivisionSurface {
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
            Location::Vertex(vertex) => {
                let count = self.cage.points().len();
                if vertex as usize >= count {
                    return Err(Error::NoVertex { index: i64::from(vertex), count });
                }
                if self.is_hidden(vertex as usize) {
                    return Err(Error::Invalid(format!(
                        "vertex {vertex} has nothing but holes round it, where there is no surface: ask of a vertex of a face that is shown"
                    )));
                }
                if by == Derivative::POSITION {
                    return limit_position(&self.cage, vertex as usize).map_err(refused);
                }
                self.check_one_sided(vertex as usize)?;
                let limit = limit_stencils(&self.cage, vertex as usize, 0).map_err(refused)?;
                of_limit(limit, by, || format!("vertex {vertex}"))
            }
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
        Some(self.layout.faces.len())
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
impl Neighbours for SubdivisionSurface {
    fn around(&self, vertex: usize) -> SmallVec<[usize; 8]> {
        let topology = self.cage.topology();
        let edges = topology.vertex_edges(vertex);
        let mut all: SmallVec<[usize; 8]> = edges.map(|edge| topology.other_end(edge, vertex)).collect();
        all.sort_unstable();
        all
    }
}
