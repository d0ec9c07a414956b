//! Where a mesh is not watertight.

use std::collections::HashMap;

use loftsman_kernel::mesh::Mesh;

/// Where a mesh is not watertight.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Leaks {
    /// Edges that only one face has.
    pub open_edges: usize,
    /// The connected sets that these make, rims of holes as a rule.
    pub rims: usize,
    /// Edges with neighbours of which one is turned over.
    pub turned_edges: usize,
    /// Edges that three or more faces share, and not in pairs that run both ways.
    pub crowded_edges: usize,
    /// The middle of one of the edges.
    pub at: [f64; 3],
}

impl Leaks {
    /// Where faces of a mesh have no neighbour, or none that fits; `None` where it is watertight. `O(e log e)` in its edges.
    pub(super) fn of(mesh: &Mesh) -> Option<Self> {
        let same = mesh.welded();
        // Both ends of an edge, the lower first, and whether a face runs from it to the higher.
        let mut edges: Vec<(u64, bool)> = Vec::with_capacity(mesh.corners().len());
        for face in mesh.faces() {
            let ends = face.iter().zip(face.iter().skip(1).chain(face.first()));
            for (a, b) in ends.map(|(a, b)| (same[*a as usize], same[*b as usize])).filter(|(a, b)| a != b) {
                edges.push((u64::from(a.min(b)) << 32 | u64::from(a.max(b)), a < b));
            }
        }
        edges.sort_unstable();
        let (mut open, mut turned, mut crowded) = (Vec::new(), Vec::new(), Vec::new());
        for uses in edges.chunk_by(|a, b| a.0 == b.0) {
            let forth = uses.iter().filter(|(_, forth)| *forth).count();
            match uses.len() {
                n if n == 2 * forth => {}
                1 => open.push(uses[0].0),
                2 => turned.push(uses[0].0),
                _ => crowded.push(uses[0].0),
            }
        }
        let ends = |edge: u64| [(edge >> 32) as u32, edge as u32];
        let one = *open.first().or(turned.first()).or(crowded.first())?;
        let [a, b] = ends(one).map(|index| mesh.points()[index as usize].coords);
        Some(Self {
            open_edges: open.len(),
            rims: connected(open.iter().map(|&edge| ends(edge))),
            turned_edges: turned.len(),
            crowded_edges: crowded.len(),
            at: (a * 0.5 + b * 0.5).into(),
        })
    }
}

/// How many connected sets edges make.
fn connected(edges: impl Iterator<Item = [u32; 2]>) -> usize {
    let mut above: HashMap<u32, u32> = HashMap::new();
    let mut sets = 0;
    for ends in edges {
        let [a, b] = ends.map(|end| {
            sets += usize::from(!above.contains_key(&end));
            let mut top = *above.entry(end).or_insert(end);
            while let Some(&next) = above.get(&top).filter(|&&next| next != top) {
                // Half of the way is shortened each time.
                let beyond = above.get(&next).copied().unwrap_or(next);
                above.insert(top, beyond);
                top = beyond;
            }
            top
        });
        if a != b {
            above.insert(a.max(b), a.min(b));
            sets -= 1;
        }
    }
    sets
}
