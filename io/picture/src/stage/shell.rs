//! Faces as they are drawn, of Breps and of shapes of plug-ins alike: triangles with normals, and edges as chains of their points.

use std::collections::HashMap;
use std::sync::Arc;

use loftsman_kernel::Vector;
use loftsman_kernel::mesh::{Mesh, NONE};

use super::laid::Laid;

/// Faces that meet at a smaller angle are smooth there: its cosine, of 8 degrees.
const SMOOTH: f64 = 0.99;

/// What an edge is to the eye.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Two faces meet at an angle, or one has a crease.
    Sharp,
    /// Two faces go on into one another, or one has a crease of a few degrees.
    Smooth,
    /// Less or more than two faces meet.
    Open,
    /// A seam without a corner, or where one surface goes on as another face: nothing to be seen, but where it turns away.
    Within,
}

/// An edge as a chain of points.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Edge {
    pub(crate) kind: Kind,
    pub(crate) points: Vec<u32>,
    /// The triangles on both sides of each of its segments, of a smooth one along which points are doubled.
    pub(crate) beside: Vec<[u32; 2]>,
}

/// Triangles and edges, wherever their points are.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Skin {
    pub(crate) triangles: Vec<[u32; 3]>,
    /// The colours that faces have of their own, behind that of the object.
    pub(crate) colors: Vec<Option<[f64; 4]>>,
    /// For each triangle which of them it has.
    pub(crate) slots: Vec<u32>,
    /// Those that are to be drawn: where a face meets itself at a seam, or two halves of one cylinder meet, there is nothing to see.
    pub(crate) edges: Vec<Edge>,
}

impl Skin {
    /// The colour that all faces have, where they have one of their own.
    pub(crate) fn color(&self) -> Option<[f64; 4]> {
        let first = *self.slots.first()?;
        let all = self.slots.iter().all(|slot| *slot == first);
        self.colors.get(first as usize).copied().flatten().filter(|_| all)
    }
}

/// Faces on the stage.
#[derive(Debug, Clone)]
pub(crate) struct Shell {
    pub(crate) skin: Arc<Skin>,
    pub(crate) points: Vec<Vector>,
    /// At each point, of any length; points are doubled where faces meet at an angle.
    pub(crate) normals: Vec<Vector>,
    /// The shape that they are laid over, of a plug-in's.
    pub(crate) laid: Option<Laid>,
}

impl Shell {
    /// Under which numbers the values are that are painted at the corners of a triangle: by the places of a shape, where it is laid over one,
    /// else by points.
    pub(crate) fn painted_at(&self, triangle: usize) -> [usize; 3] {
        let own = match &self.laid {
            Some(laid) => laid.corners[triangle],
            None => self.skin.triangles[triangle],
        };
        own.map(|k| k as usize)
    }
}

/// Two points, the smaller number first.
pub(super) fn pair(a: u32, b: u32) -> (u32, u32) {
    (a.min(b), a.max(b))
}

/// A side of a triangle: which triangle, and the numbers of its normals at both ends.
pub(super) type Side = (u32, [u32; 2]);

/// The sides of triangles that lie on edges, by their points.
pub(super) struct Sides<'a> {
    mesh: &'a Mesh,
    all: HashMap<(u32, u32), Vec<Side>>,
}

impl<'a> Sides<'a> {
    /// Those of the triangles of a mesh that are between certain pairs of points.
    pub(super) fn new(mesh: &'a Mesh, pairs: impl Iterator<Item = (u32, u32)>) -> Self {
        let mut all: HashMap<_, _> = pairs.map(|pair| (pair, Vec::new())).collect();
        for (triangle, (corners, starts)) in mesh.faces().zip(mesh.starts().windows(2)).enumerate() {
            for k in 0..corners.len() {
                let next = (k + 1) % corners.len();
                if let Some(list) = all.get_mut(&pair(corners[k], corners[next])) {
                    let [a, b] = if corners[k] < corners[next] { [k, next] } else { [next, k] };
                    let normals = [a, b].map(|k| mesh.normals.index(starts[0] + k, corners[k]));
                    list.push((triangle as u32, normals));
                }
            }
        }
        Self { mesh, all }
    }

    /// Those between two points.
    pub(super) fn at(&self, a: u32, b: u32) -> &[Side] {
        self.all.get(&pair(a, b)).map_or(&[], Vec::as_slice)
    }

    /// Whether two triangles go on into one another along a side.
    pub(super) fn is_smooth(&self, one: &Side, other: &Side) -> bool {
        self.is_within(one, other, SMOOTH) == [true; 2]
    }

    /// Whether the normals of two triangles at either end of a side have an angle between them of at least this cosine.
    pub(super) fn is_within(&self, one: &Side, other: &Side, cosine: f64) -> [bool; 2] {
        let normals = &self.mesh.normals;
        let at = |index: u32| normals.values().get(index as usize).filter(|_| index != NONE);
        [0, 1].map(|k| at(one.1[k]).zip(at(other.1[k])).is_some_and(|(a, b)| a.dot(b) >= cosine))
    }
}
