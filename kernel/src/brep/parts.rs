//! What a Brep is made of.

use super::{CurveForm, SurfaceForm};
use crate::Point;
use crate::spline::trimmed::ParameterCurve;
use crate::spline::{Curve, Surface};

/// A point where edges end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vertex {
    /// Where it is.
    pub point: Point,
    /// How far from it the ends of its edges may be, in the scene's unit.
    pub tolerance: f64,
}

/// A curve between two vertices, shared by the faces that it bounds.
#[derive(Debug, Clone, PartialEq)]
pub struct Edge {
    /// The curve that it is a part of.
    pub curve: Curve,
    /// Where on the curve it starts and ends, the first less than the second. On a periodic curve the end may be up to one
    /// period behind the start, beyond the domain.
    pub range: (f64, f64),
    /// The vertices at its start and at its end, by their numbers; the same one twice where it closes.
    pub ends: [usize; 2],
    /// How far from it the surfaces of its faces may be, in the scene's unit.
    pub tolerance: f64,
    /// What the curve is beside a spline.
    pub form: CurveForm,
}

/// An edge in a loop.
#[derive(Debug, Clone, PartialEq)]
pub struct Use {
    /// The edge's number.
    pub edge: usize,
    /// Whether the loop runs from the edge's end to its start.
    pub reversed: bool,
    /// The same edge in the parameter plane of the face's surface, where that is known: from the edge's start to its end,
    /// whichever way the loop runs, not always at the edge's speed.
    pub parameters: Option<ParameterCurve>,
}

/// A part of a surface.
///
/// Loops run counterclockwise around it as seen from the tip of its [normal](Self::reversed): the part is to their left.
#[derive(Debug, Clone, PartialEq)]
pub struct Face {
    /// What it is called, where the file says so.
    pub name: Option<String>,
    /// Linear red, green, blue, alpha, where it is not that of the object.
    pub color: Option<[f64; 4]>,
    /// The surface that it is a part of.
    pub surface: Surface,
    /// What the surface is beside a spline.
    pub form: SurfaceForm,
    /// Whether its normal, which points out of a solid, is `-S_u × S_v`.
    pub reversed: bool,
    /// The closed loops that bound it, each a chain of edges that ends where it starts. On a closed surface none need go around
    /// the others; without loops it is the whole surface.
    pub loops: Vec<Vec<Use>>,
    /// Vertices alone in it, as files have them at poles.
    pub points: Vec<usize>,
}

/// Faces that hang together by their edges.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Shell {
    /// The faces' numbers.
    pub faces: Vec<usize>,
}

/// What closed shells bound.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Solid {
    /// What it is called, where the file says so.
    pub name: Option<String>,
    /// The number of the shell around it.
    pub outer: usize,
    /// The numbers of the shells around what is hollow in it; their faces' normals point into the hollow.
    pub voids: Vec<usize>,
}

/// All parts of a [`Brep`](super::Brep), which name one another by their numbers.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Parts {
    /// The vertices.
    pub vertices: Vec<Vertex>,
    /// The edges.
    pub edges: Vec<Edge>,
    /// The faces. Those of no shell stand alone.
    pub faces: Vec<Face>,
    /// The shells; a face belongs to one at most.
    pub shells: Vec<Shell>,
    /// The solids; a shell belongs to one at most.
    pub solids: Vec<Solid>,
}

impl Parts {
    /// Puts vertices and edges in the order of keys, one for each as they are now; those with equal keys stay in the order that they are in. What names
    /// them by their numbers names them by the new ones. What has no key goes behind all that have, and a number of nothing stays. `O(n log n)`.
    ///
    /// ```
    /// use loftsman_kernel::{Point, brep::Brep};
    /// let block = Brep::block(Point::origin(), Point::new(1.0, 2.0, 3.0))?;
    /// let mut parts = block.parts();
    /// let backwards = |count: usize| (0..count).rev().collect::<Vec<_>>();
    /// parts.sort_by_keys(&backwards(8), &backwards(12));
    /// assert_eq!(parts.vertices[7], block.parts().vertices[0]);
    /// parts.sort_by_keys(&backwards(8), &backwards(12));
    /// assert_eq!(Brep::new(parts)?, block);
    /// # Ok::<(), loftsman_kernel::Error>(())
    /// ```
    pub fn sort_by_keys<K: Ord>(&mut self, vertices: &[K], edges: &[K]) {
        let vertex_at = sort_by_keys(&mut self.vertices, vertices);
        let edge_at = sort_by_keys(&mut self.edges, edges);
        self.renumber(&vertex_at, &edge_at);
    }

    /// Takes out the edges that no face has, and the vertices that no edge left and no face has; the rest stays in its order, named by its new
    /// numbers. `O(n)`.
    ///
    /// ```
    /// use loftsman_kernel::{Point, brep::Brep};
    /// let mut parts = Brep::block(Point::origin(), Point::new(1.0, 2.0, 3.0))?.parts();
    /// (parts.shells, parts.solids) = (vec![], vec![]);
    /// parts.faces.truncate(1);
    /// parts.drop_unused();
    /// assert_eq!((parts.edges.len(), parts.vertices.len()), (4, 4));
    /// assert_eq!(Brep::new(parts)?.face_count(), 1);
    /// # Ok::<(), loftsman_kernel::Error>(())
    /// ```
    pub fn drop_unused(&mut self) {
        let (mut edges, mut vertices) = (vec![false; self.edges.len()], vec![false; self.vertices.len()]);
        let mark = |used: &mut [bool], number: usize| {
            if let Some(used) = used.get_mut(number) {
                *used = true;
            }
        };
        for face in &self.faces {
            face.loops.iter().flatten().for_each(|one| mark(&mut edges, one.edge));
            face.points.iter().for_each(|&vertex| mark(&mut vertices, vertex));
        }
        for (edge, _) in self.edges.iter().zip(&edges).filter(|(_, used)| **used) {
            edge.ends.iter().for_each(|&end| mark(&mut vertices, end));
        }
        let (vertex_at, edge_at) =
            (keep_used(&mut self.vertices, &vertices), keep_used(&mut self.edges, &edges));
        self.renumber(&vertex_at, &edge_at);
    }

    /// Names vertices and edges by where they have come to. A number of nothing stays.
    fn renumber(&mut self, vertex_at: &[usize], edge_at: &[usize]) {
        let now = |places: &[usize], old: usize| places.get(old).copied().unwrap_or(old);
        for edge in &mut self.edges {
            edge.ends = edge.ends.map(|end| now(vertex_at, end));
        }
        for face in &mut self.faces {
            face.loops.iter_mut().flatten().for_each(|one| one.edge = now(edge_at, one.edge));
            face.points.iter_mut().for_each(|vertex| *vertex = now(vertex_at, *vertex));
        }
    }
}

/// Takes what is not used out of a list. Where each of the others has come to.
fn keep_used<T>(list: &mut Vec<T>, used: &[bool]) -> Vec<usize> {
    let mut keep = used.iter();
    list.retain(|_| keep.next().copied().unwrap_or(false));
    let before = used.iter().scan(0, |count, used| {
        let place = *count;
        *count += usize::from(*used);
        Some(place)
    });
    before.collect()
}

/// Sorts a list by keys. Where each of its things has come to.
fn sort_by_keys<T, K: Ord>(list: &mut Vec<T>, keys: &[K]) -> Vec<usize> {
    let mut all: Vec<(usize, T)> = std::mem::take(list).into_iter().enumerate().collect();
    all.sort_by_key(|(old, _)| (keys.get(*old).is_none(), keys.get(*old)));
    let mut places = vec![0; all.len()];
    for (new, (old, _)) in all.iter().enumerate() {
        places[*old] = new;
    }
    list.extend(all.into_iter().map(|(_, item)| item));
    places
}
