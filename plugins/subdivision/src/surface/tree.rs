//! Faces of a cage, refined as far as each needs.
//!
//! A face is refined with nothing but the faces round it, for what it becomes depends on nothing else. Faces that are refined together
//! are a batch: a cage of their own, in which the faces on the rim are there for the sake of the others only.

use loftsman_kernel::error::Result;
use loftsman_kernel::{Point, Vector};
use smallvec::SmallVec;

use super::cut::Cut;
use super::places::Place;
use super::refused;
use crate::cage::Cage;
use crate::catmull_clark::{limit_frames_of, refine};
use crate::part::Part;
use crate::topology::NONE;

/// Faces that were refined together, in each state.
pub(super) struct Batch {
    pub(super) cages: Vec<Cage>,
    /// The number of each vertex among all points; [`NONE`] on the rim.
    pub(super) names: Vec<u32>,
    /// The unit normal of each vertex that has a number, in each state.
    pub(super) normals: Vec<Vec<Option<Vector>>>,
}

/// A face of a batch.
pub(super) struct Node {
    pub(super) batch: u32,
    pub(super) face: u32,
    /// Where on the surface it is; `None` where it is no quad yet, with the number of the surface's first face on it.
    pub(super) place: std::result::Result<Place, u32>,
    /// Its first child and their number, where it was refined, and the number of its middle.
    pub(super) children: Option<(u32, u32, u32)>,
    /// Whether it is one of those that the surface consists of: not yet one of them, or no longer, where it is not.
    pub(super) is_shown: bool,
    pub(super) since: Since,
    pub(super) level: u32,
}

/// Levels on which those that a face came from were near enough.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Since {
    pub(super) proved: u32,
    pub(super) found: u32,
}

/// The middle of an edge between two points.
#[derive(Clone, Copy)]
struct Middle {
    other: u32,
    name: u32,
    /// Whether a face at the edge is split, so that the point is in the mesh.
    is_there: bool,
}

/// All faces and points.
pub(super) struct Tree {
    pub(super) batches: Vec<Batch>,
    pub(super) nodes: Vec<Node>,
    /// The limits of all vertices, in each state.
    pub(super) points: Vec<Vec<Point>>,
    /// The normals of all, in the first state.
    pub(super) normals: Vec<Option<Vector>>,
    /// The middles of edges, at the end with the smaller number.
    middles: Vec<SmallVec<[Middle; 4]>>,
}

impl Tree {
    /// The faces that are shown, of the same cage in several states. `first` is the number of the surface's first face on each.
    pub(super) fn new(cages: Vec<Cage>, first: &[u32]) -> Result<Self> {
        let count = cages[0].points().len();
        let mut tree = Self {
            batches: Vec::new(),
            nodes: Vec::new(),
            points: vec![Vec::new(); cages.len()],
            normals: Vec::new(),
            middles: Vec::new(),
        };
        let names = (0..count as u32).collect();
        tree.name(count);
        tree.add_batch(cages, names, 0..count as u32)?;
        let cage = &tree.batches[0].cages[0];
        for face in (0..cage.topology().face_count()).filter(|&face| !cage.is_hole(face)) {
            let quad = cage.topology().face(face).len() == 4;
            tree.nodes.push(Node {
                batch: 0,
                face: face as u32,
                place: if quad { Ok(Place::whole(first[face])) } else { Err(first[face]) },
                children: None,
                is_shown: true,
                since: Since::default(),
                level: 0,
            });
        }
        Ok(tree)
    }

    /// Room for more points.
    fn name(&mut self, more: usize) {
        let count = self.normals.len() + more;
        self.points.iter_mut().for_each(|points| points.resize(count, Point::origin()));
        self.normals.resize(count, None);
        self.middles.resize(count, SmallVec::new());
    }

    /// Adds cages; the limits of the vertices that are numbered from `fresh` on are put down.
    fn add_batch(&mut self, cages: Vec<Cage>, names: Vec<u32>, fresh: std::ops::Range<u32>) -> Result<()> {
        let named: Vec<u32> = (0..names.len() as u32).filter(|&v| names[v as usize] != NONE).collect();
        let mut normals = vec![vec![None; names.len()]; cages.len()];
        for (state, cage) in cages.iter().enumerate() {
            let frames = limit_frames_of(cage, &named).map_err(refused)?;
            for (&v, frame) in named.iter().zip(frames) {
                let name = names[v as usize] as usize;
                let normal = frame.normal();
                normals[state][v as usize] = normal;
                if fresh.contains(&(name as u32)) {
                    self.points[state][name] = frame.point;
                    if state == 0 {
                        self.normals[name] = normal;
                    }
                }
            }
        }
        self.batches.push(Batch { cages, names, normals });
        Ok(())
    }

    /// The numbers of the corners of a face.
    pub(super) fn corners(&self, node: &Node) -> SmallVec<[u32; 4]> {
        let batch = &self.batches[node.batch as usize];
        let corners = batch.cages[0].topology().face(node.face as usize);
        corners.iter().map(|&v| batch.names[v as usize]).collect()
    }

    fn middle(&self, a: u32, b: u32) -> Option<&Middle> {
        let (a, b) = (a.min(b), a.max(b));
        self.middles[a as usize].iter().find(|m| m.other == b)
    }

    /// The middle of an edge, where it is in the mesh.
    pub(super) fn shown_middle(&self, a: u32, b: u32) -> Option<u32> {
        self.middle(a, b).filter(|m| m.is_there).map(|m| m.name)
    }

    /// How a quad is cut.
    pub(super) fn cut(&self, corners: &[u32]) -> Cut {
        Cut::new([0, 1, 2, 3].map(|k| self.shown_middle(corners[k], corners[(k + 1) % 4]).is_some()))
    }

    /// The numbers of a quad's corners, of the middles of its edges and of its own, as far as they are known, else [`NONE`].
    pub(super) fn numbers(&self, node: &Node, corners: &[u32]) -> [u32; 9] {
        let mut all = [NONE; 9];
        all[..4].copy_from_slice(&corners[..4]);
        for k in 0..4 {
            all[4 + k] = self.middle(corners[k], corners[(k + 1) % 4]).map_or(NONE, |m| m.name);
        }
        all[8] = node.children.map_or(NONE, |(_, _, centre)| centre);
        all
    }

    /// The faces that the surface consists of.
    pub(super) fn shown(&self) -> impl Iterator<Item = usize> {
        (0..self.nodes.len()).filter(|&k| self.nodes[k].is_shown)
    }

    /// Puts the children of a face that was refined in its place.
    pub(super) fn split(&mut self, node: usize, since: Since) {
        let Some((first, count, _)) = self.nodes[node].children else { return };
        self.nodes[node].is_shown = false;
        for child in &mut self.nodes[first as usize..(first + count) as usize] {
            (child.is_shown, child.since) = (true, since);
        }
        let corners = self.corners(&self.nodes[node]);
        for (k, &a) in corners.iter().enumerate() {
            let b = corners[(k + 1) % corners.len()];
            let (a, b) = (a.min(b), a.max(b));
            if let Some(middle) = self.middles[a as usize].iter_mut().find(|m| m.other == b) {
                middle.is_there = true;
            }
        }
    }

    /// Refines faces, as far as they are not: their children are there, and not yet in their places. `nodes` ascend.
    pub(super) fn refine(&mut self, nodes: &[usize]) -> Result<()> {
        let mut wanted: Vec<(u32, usize)> = nodes
            .iter()
            .filter(|&&k| self.nodes[k].children.is_none())
            .map(|&k| (self.nodes[k].batch, k))
            .collect();
        wanted.sort_unstable();
        for run in wanted.chunk_by(|a, b| a.0 == b.0) {
            let own: Vec<usize> = run.iter().map(|(_, node)| *node).collect();
            self.refine_batch(run[0].0 as usize, &own)?;
        }
        Ok(())
    }

    fn refine_batch(&mut self, batch: usize, nodes: &[usize]) -> Result<()> {
        let (cages, names) = (&self.batches[batch].cages, &self.batches[batch].names);
        let topology = cages[0].topology();
        let mut faces: Vec<usize> = nodes.iter().map(|&k| self.nodes[k].face as usize).collect();
        // Where most are refined, all are: that is plain arithmetic.
        let (before, names) = if 2 * faces.len() > topology.face_count() {
            (cages.clone(), names.clone())
        } else {
            let part = Part::to_refine(&cages[0], &faces);
            let first = part.to_cage(&cages[0]).map_err(refused)?;
            let moved = cages.iter().map(|cage| Cage {
                points: part.kept.iter().map(|&v| cage.points()[v as usize]).collect(),
                ..first.clone()
            });
            let names = part.kept.iter().map(|&v| names[v as usize]).collect();
            let all = moved.collect();
            faces = (0..faces.len()).collect();
            (all, names)
        };
        let old = before[0].shared_topology();
        let (vertices, edges) = (old.vertex_count(), old.edge_count());
        let mut names_after = vec![NONE; vertices + edges + old.face_count()];
        let start = self.normals.len() as u32;
        let mut next = start;
        for (&node, &face) in nodes.iter().zip(&faces) {
            let first_child = self.nodes.len() as u32;
            let corners = old.face(face);
            for (k, (&v, &edge)) in corners.iter().zip(old.face_edges(face)).enumerate() {
                names_after[v as usize] = names[v as usize];
                let [a, b] = [v, corners[(k + 1) % corners.len()]].map(|v| names[v as usize]);
                let (a, b) = (a.min(b), a.max(b));
                let known = self.middles[a as usize].iter().find(|m| m.other == b).map(|m| m.name);
                let name = known.unwrap_or_else(|| {
                    self.middles[a as usize].push(Middle { other: b, name: next, is_there: false });
                    next += 1;
                    next - 1
                });
                names_after[vertices + edge as usize] = name;
            }
            names_after[vertices + edges + face] = next;
            let own = &mut self.nodes[node];
            own.children = Some((first_child, corners.len() as u32, next));
            next += 1;
            let (place, level) = (own.place, own.level + 1);
            let start = old.face_corners(face).start;
            for corner in 0..corners.len() {
                self.nodes.push(Node {
                    batch: self.batches.len() as u32,
                    face: (start + corner) as u32,
                    place: Ok(match place {
                        Ok(place) => Place::child(Some(place), NONE, corner),
                        Err(first) => Place::child(None, first, corner),
                    }),
                    children: None,
                    is_shown: false,
                    since: Since::default(),
                    level,
                });
            }
        }
        let after = before.iter().map(refine).collect::<std::result::Result<Vec<_>, _>>().map_err(refused)?;
        self.name((next - start) as usize);
        self.add_batch(after, names_after, start..next)
    }
}
