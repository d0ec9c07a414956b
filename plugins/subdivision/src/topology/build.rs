//! A topology from faces, with what is wrong named.

use super::{Deferred, NONE, Pairing, Polygons, Topology};
use crate::error::{Result, SubdivisionError};
use loftsman_kernel::text::counted;

impl Topology {
    /// The topology of faces over `vertices` vertices: the vertex at each corner, face after face, and where each face starts among
    /// them (one more entry than faces). Edges are numbered by their vertices: the smaller one first, then the larger. Cost: linear
    /// but for sorting the edges at each vertex.
    ///
    /// # Errors
    /// When a face has fewer than three corners, an index that does not exist or a vertex twice; an edge has three faces, or two that
    /// run it the same way; the faces at a vertex are not one fan, or there is none.
    pub fn new(vertices: usize, corners: Vec<u32>, starts: &[usize]) -> Result<Self> {
        check_sizes(vertices, corners.len(), starts)?;
        check_faces(vertices, &corners, starts)?;
        let (starts, face_of) = polygons(corners.len(), starts);
        let quads = corners.len() == 4 * (starts.len() - 1)
            && starts.iter().enumerate().all(|(f, &s)| s as usize == 4 * f);
        let polygons = (!quads).then_some(Polygons { starts, face_of });
        let topology = Self::paired(vertices, corners, polygons)?;
        topology.check_fans()?;
        Ok(topology)
    }

    /// The topology of some faces of one that is whole: vertices on its rim may have lost faces, so that round these alone
    /// [`around`](Self::around) need not reach all. Nothing is checked but what pairing finds.
    ///
    /// # Errors
    /// When an edge has three faces, or two that run it the same way.
    pub(crate) fn part(vertices: usize, corners: Vec<u32>, starts: &[usize]) -> Result<Self> {
        let (starts, face_of) = polygons(corners.len(), starts);
        let quads = starts.iter().enumerate().all(|(f, &s)| s as usize == 4 * f);
        let polygons = (!quads).then_some(Polygons { starts, face_of });
        Self::paired(vertices, corners, polygons)
    }

    /// With its edges, and a half-edge that leaves each vertex: on the boundary one that has nothing on its right.
    fn paired(vertices: usize, corners: Vec<u32>, polygons: Option<Polygons>) -> Result<Self> {
        let mut topology = Self { vertices, edges: 0, corners, polygons, pairing: Deferred::default() };
        let pairing = topology.find_edges()?;
        (topology.edges, topology.pairing) = (pairing.edges.len(), pairing.into());
        Ok(topology)
    }

    /// Pairs the half-edges: those with the same smaller vertex are brought together by counting, and sorted by the other.
    fn find_edges(&self) -> Result<Pairing> {
        let vertices = self.vertices;
        let count = self.corners.len() as u32;
        let ends = |h: u32| (self.corners[h as usize], self.corners[self.next(h) as usize]);
        let mut places = vec![0u32; vertices + 1];
        for h in 0..count {
            let (a, b) = ends(h);
            places[a.min(b) as usize + 1] += 1;
        }
        for v in 0..vertices {
            places[v + 1] += places[v];
        }
        let mut sorted = vec![(0u32, 0u32); count as usize];
        let mut at = places.clone();
        for h in 0..count {
            let (a, b) = ends(h);
            let place = &mut at[a.min(b) as usize];
            sorted[*place as usize] = (a.max(b), h);
            *place += 1;
        }
        let mut edges = Vec::with_capacity(count as usize / 2 + 1);
        let mut edge_of = vec![0u32; count as usize];
        for v in 0..vertices {
            let bucket = &mut sorted[places[v] as usize..places[v + 1] as usize];
            bucket.sort_unstable();
            for run in bucket.chunk_by(|a, b| a.0 == b.0) {
                let first = run[0].1;
                let (from, to) = ends(first);
                let wrong = |problem: String| {
                    let (from, to) = (from as usize, to as usize);
                    Err(SubdivisionError::Edge { from, to, problem })
                };
                let second = match run {
                    [_] => NONE,
                    [_, (_, second)] if ends(*second) == (to, from) => *second,
                    [_, (_, second)] => {
                        let (one, other) = (self.face_of(first), self.face_of(*second));
                        return wrong(self.same_way(one as usize, other as usize));
                    }
                    more => {
                        let faces: Vec<usize> = more.iter().map(|(_, h)| self.face_of(*h) as usize).collect();
                        if let Some(problem) = self.repeated(&faces) {
                            return wrong(problem);
                        }
                        let faces: Vec<String> = faces.iter().take(8).map(usize::to_string).collect();
                        return wrong(format!(
                            "has {} faces ({}): an edge has one or two; take the mesh apart there",
                            more.len(),
                            faces.join(", ")
                        ));
                    }
                };
                for (_, h) in run {
                    edge_of[*h as usize] = edges.len() as u32;
                }
                edges.push([first, second]);
            }
        }
        let mut leaving = vec![NONE; vertices];
        for (h, (&v, &edge)) in self.corners.iter().zip(&edge_of).enumerate() {
            let leaves = &mut leaving[v as usize];
            if *leaves == NONE || edges[edge as usize] == [h as u32, NONE] {
                *leaves = h as u32;
            }
        }
        Ok(Pairing { edge_of, edges, leaving })
    }

    /// Whether all faces of each vertex are reached from its half-edge.
    fn check_fans(&self) -> Result<()> {
        let mut faces = vec![0u32; self.vertices];
        self.corners.iter().for_each(|&v| faces[v as usize] += 1);
        for vertex in 0..self.vertices {
            if faces[vertex] == 0 {
                let problem = "belongs to no face: remove it".to_owned();
                return Err(SubdivisionError::Vertex { vertex, problem });
            }
            let reached = self.around(vertex).count();
            if reached != faces[vertex] as usize {
                let problem = format!(
                    "joins several fans of faces ({reached} of its {} faces hang together): give each fan a vertex of its own",
                    faces[vertex]
                );
                return Err(SubdivisionError::Vertex { vertex, problem });
            }
        }
        Ok(())
    }
}

/// The starts in 32 bits, and the face of each corner.
fn polygons(corners: usize, starts: &[usize]) -> (Vec<u32>, Vec<u32>) {
    let mut face_of = Vec::with_capacity(corners);
    for (face, pair) in starts.windows(2).enumerate() {
        face_of.resize(pair[1], face as u32);
    }
    (starts.iter().map(|&s| s as u32).collect(), face_of)
}

/// Whether 32 bits are enough.
pub(super) fn check_room(what: &str, count: usize) -> Result<()> {
    const LIMIT: usize = (u32::MAX - 1) as usize;
    if count > LIMIT {
        return Err(SubdivisionError::TooLarge { what: format!("{count} {what}"), limit: LIMIT });
    }
    Ok(())
}

fn check_sizes(vertices: usize, corners: usize, starts: &[usize]) -> Result<()> {
    check_room("vertices", vertices)?;
    check_room("corners of faces", corners)?;
    for (face, pair) in starts.windows(2).enumerate() {
        if pair[1] < pair[0].saturating_add(3) {
            let problem = format!(
                "has {}: a face needs at least 3",
                counted(pair[1].saturating_sub(pair[0]), "corner[|s]")
            );
            return Err(SubdivisionError::Face { face, problem });
        }
    }
    if starts.first() != Some(&0) || starts.last() != Some(&corners) || starts.len() < 2 {
        let problem = match starts.len() {
            0 | 1 => "is missing: a cage needs at least one face",
            _ => {
                "does not start where the corners do, or the last does not end with them: starts run from 0 to the number of corners"
            }
        };
        return Err(SubdivisionError::Face { face: 0, problem: problem.to_owned() });
    }
    Ok(())
}

fn check_faces(vertices: usize, corners: &[u32], starts: &[usize]) -> Result<()> {
    let mut seen = vec![u32::MAX; vertices];
    for (face, pair) in starts.windows(2).enumerate() {
        for &v in &corners[pair[0]..pair[1]] {
            let problem = match seen.get_mut(v as usize) {
                None => format!("refers to vertex {v}, but there are only {vertices}"),
                Some(last) if *last == face as u32 => {
                    format!("has vertex {v} twice: split it into faces that pass each vertex once")
                }
                Some(last) => {
                    *last = face as u32;
                    continue;
                }
            };
            return Err(SubdivisionError::Face { face, problem });
        }
    }
    Ok(())
}
