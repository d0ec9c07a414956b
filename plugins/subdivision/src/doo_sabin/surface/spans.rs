//! Knot intervals of a Doo-Sabin cage: whether places between vertices are known with them, and what they make of each ring.

use std::collections::BTreeMap;
use std::sync::Arc;

use loftsman_kernel::parallel;

use super::rule::{Extraordinary, Rule};
use crate::cage::Cage;
use crate::doo_sabin::refine::intervals;
use crate::error::{Result, SubdivisionError};
use crate::surface::same;
use crate::topology::NONE;

/// What to do where places between vertices are not known.
const INSTEAD: &str =
    "or refine the cage instead (levels, with limit = true: a mesh with its vertices on the surface)";

/// What intervals make of the faces of a cage and of its inner vertices.
#[derive(Debug, Default)]
pub(super) struct Spans {
    /// Of faces, and after these of vertices, that are no quads and have intervals that differ.
    uneven: BTreeMap<usize, Arc<Extraordinary>>,
}

impl Spans {
    /// Of a cage without intervals, nothing. Cost: linear, and for each face that is no quad and vertex that has not four edges, where
    /// intervals differ there, some fifty times the square of its size.
    ///
    /// # Errors
    /// When intervals of the vertices at the two ends of an edge, away from it in one face, differ: there are no pieces then; when one of 0 is not
    /// as a double knot of a tensor-product spline is; when the surface is not smooth at a face or vertex by its intervals.
    pub(super) fn new(cage: &Cage) -> Result<Self> {
        let topology = cage.topology();
        if !cage.has_end_intervals() {
            return Ok(Self::default());
        }
        let faces = topology.face_count();
        // Others have no pieces.
        let counts = |f: usize| topology.face(f).iter().any(|&v| !topology.is_boundary_vertex(v as usize));
        let mut corners = (0..faces).filter(|&f| counts(f)).flat_map(|f| topology.face_corners(f));
        corners.try_for_each(|half| check(cage, half as u32))?;
        let of = |k: usize| {
            let own: Vec<f64> = if k < faces {
                if topology.face_corners(k).len() == 4 || !counts(k) {
                    return Ok(None);
                }
                topology.face_corners(k).map(|h| intervals(cage, h as u32)[1]).collect()
            } else {
                let vertex = k - faces;
                if topology.is_boundary_vertex(vertex) || topology.around(vertex).count() == 4 {
                    return Ok(None);
                }
                of_vertex(cage, topology.around(vertex).next().unwrap_or(NONE))
            };
            if own.iter().all(|d| same(*d, own[0])) {
                return Ok(None);
            }
            let n = own.len();
            let refused = |problem: String| {
                if k < faces {
                    SubdivisionError::Face { face: k, problem }
                } else {
                    SubdivisionError::Vertex { vertex: k - faces, problem }
                }
            };
            let whose = if k < faces { "corners" } else { "edges" };
            if n > super::MOST {
                return Err(refused(format!(
                    "has {n} {whose} with intervals that differ, and at most {} can be looked at: make them the same, or divide it",
                    super::MOST
                )));
            }
            Extraordinary::new(own).map(|face| Some((k, Arc::new(face)))).ok_or_else(|| {
                refused(format!(
                    "has {n} {whose} with intervals so different that the surface is not smooth there: bring them nearer to each other, {INSTEAD}"
                ))
            })
        };
        let found = parallel::map(faces + topology.vertex_count(), of);
        let uneven = found.into_iter().filter_map(Result::transpose).collect::<Result<_>>()?;
        Ok(Self { uneven })
    }

    /// The rules of the rings round the piece at a corner, which are in the order of `DooSabinSurface::rings`; nothing without intervals.
    pub(super) fn rules(&self, cage: &Cage, half: u32) -> Option<Box<[Rule; 4]>> {
        if !cage.has_end_intervals() {
            return None;
        }
        let topology = cage.topology();
        let along = |h: u32| intervals(cage, h)[0];
        let [own, across] = intervals(cage, half);
        let face = topology.face_of(half) as usize;
        let corners = topology.face_corners(face);
        let at = half as usize - corners.start;
        let of_face = || (0..corners.len()).map(|k| corners.start + (at + k) % corners.len());
        let in_face = self.ring(face, at, || of_face().map(|h| intervals(cage, h as u32)[1]).collect());
        let vertex = topology.origin(half) as usize;
        let place = topology.around(vertex).position(|h| h == half).unwrap_or(0);
        let round = self.ring(topology.face_count() + vertex, place, || of_vertex(cage, half));
        let before = topology.previous(half);
        let (twin, over) = (topology.twin(before), topology.twin(half));
        let back = [own, along(before), intervals(cage, twin)[1], across];
        let on = [own, along(topology.next(over)), along(over), across];
        Some(Box::new([in_face, Rule::Quad(back), round, Rule::Quad(on)]))
    }

    /// Whether a face is no quad and has intervals that differ.
    pub(super) fn is_uneven_face(&self, face: usize) -> bool {
        self.uneven.contains_key(&face)
    }

    /// Whether a vertex has not four edges and intervals that differ.
    pub(super) fn is_uneven_vertex(&self, cage: &Cage, vertex: usize) -> bool {
        self.uneven.contains_key(&(cage.topology().face_count() + vertex))
    }

    /// The rule of a face or vertex, seen from a corner.
    fn ring(&self, name: usize, at: usize, own: impl FnOnce() -> Vec<f64>) -> Rule {
        if let Some(face) = self.uneven.get(&name) {
            return Rule::Other(face.clone(), at);
        }
        let own = own();
        match own[..] {
            [a, b, c, d] => Rule::Quad([a, b, c, d]),
            _ => Rule::Even(own.first().copied().unwrap_or(1.0)),
        }
    }
}

/// The intervals of the face that an inner vertex becomes, from its corner in the face of a half-edge that leaves the vertex: across an edge between
/// two corners the vertex has its interval along the edge of the cage between these.
fn of_vertex(cage: &Cage, half: u32) -> Vec<f64> {
    let topology = cage.topology();
    let mut all: Vec<f64> = Vec::new();
    let mut next = half;
    loop {
        all.push(intervals(cage, next)[1]);
        next = topology.twin(topology.previous(next));
        if next == half || next == NONE {
            return all;
        }
    }
}

/// Whether pieces can be at a corner.
fn check(cage: &Cage, half: u32) -> Result<()> {
    let topology = cage.topology();
    let (before, next) = (topology.previous(half), topology.next(half));
    let face = topology.face_of(half) as usize;
    // Away from the edge of the half-edge, on its face.
    let [here, there] = [intervals(cage, half)[1], intervals(cage, next)[0]];
    let [from, to] = [half, next].map(|h| topology.origin(h));
    let [away, on] = [before, topology.next(next)].map(|h| topology.origin(h));
    if !same(here, there) {
        let problem = format!(
            "has beside its edge between vertices {from} and {to} the intervals {here} (of vertex {from} towards {away}) and {there} (of vertex {to} \
             towards {on}): places between vertices are known where these two are the same, as all along a row of a spline's; make them so, \
             {INSTEAD}"
        );
        return Err(SubdivisionError::Face { face, problem });
    }
    if here > 0.0 || is_double(cage, half) {
        return Ok(());
    }
    let problem = format!(
        "has the interval 0 towards {away}: places between vertices are known where all faces round such a vertex are four quads, its interval \
         in the opposite direction is 0, too, and those of the vertices before and after it on that line are not; give it a small one, {INSTEAD}"
    );
    Err(SubdivisionError::Vertex { vertex: from as usize, problem })
}

/// Whether an interval of 0 that a corner's vertex has along the edge before is a double knot.
fn is_double(cage: &Cage, half: u32) -> bool {
    let topology = cage.topology();
    let (vertex, across) = (topology.origin(half) as usize, topology.next(topology.next(half)));
    let is_quad = topology.next(topology.next(across)) == half;
    let goes_on = topology.is_boundary_vertex(vertex) || {
        let round = of_vertex(cage, half);
        round.len() == 4 && round[2] <= 0.0
    };
    is_quad && goes_on && intervals(cage, across)[1] > 0.0
}
