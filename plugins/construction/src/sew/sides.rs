//! Which way faces look: alike across their edges, and out of what they close.

use std::collections::BTreeSet;

use loftsman_kernel::brep::Parts;

/// Faces that hang together by edges.
#[derive(Debug, Default)]
pub(super) struct Group {
    pub(super) faces: Vec<usize>,
    /// Whether each of their edges has a face on both sides.
    pub(super) closed: bool,
    /// Whether they have two sides: no Möbius band.
    pub(super) sided: bool,
}

/// Turns a face over: its normal, and with it the way that its loops run.
pub(super) fn turn(parts: &mut Parts, face: usize) {
    let face = &mut parts.faces[face];
    face.reversed = !face.reversed;
    for uses in &mut face.loops {
        uses.reverse();
        uses.iter_mut().for_each(|one| one.reversed = !one.reversed);
    }
}

/// Where an edge is used: by which face, and whether against its direction.
type Sides = Vec<Vec<(usize, bool)>>;

fn sides(parts: &Parts) -> Sides {
    let mut sides = vec![Vec::new(); parts.edges.len()];
    for (number, face) in parts.faces.iter().enumerate() {
        for one in face.loops.iter().flatten() {
            sides[one.edge].push((number, one.reversed));
        }
    }
    sides
}

/// The groups of faces that hang together where two uses of an edge meet, by their first faces, each turned so that its faces look to one side; which
/// faces were turned. `O(n)`.
pub(super) fn groups(parts: &mut Parts) -> (Vec<Group>, BTreeSet<usize>) {
    let sides = sides(parts);
    let mut flipped: Vec<Option<bool>> = vec![None; parts.faces.len()];
    let mut groups = Vec::new();
    for first in 0..parts.faces.len() {
        if flipped[first].is_some() {
            continue;
        }
        flipped[first] = Some(false);
        let mut group = Group { faces: Vec::new(), closed: true, sided: true };
        let mut waiting = vec![first];
        while let Some(face) = waiting.pop() {
            group.faces.push(face);
            let own = flipped[face].unwrap_or_default();
            for one in parts.faces[face].loops.iter().flatten() {
                let [a, b] = sides[one.edge][..] else {
                    group.closed = false;
                    continue;
                };
                // Of a seam both are of this face.
                let (other, way) = if a == (face, one.reversed) { b } else { a };
                let alike = way == one.reversed;
                match flipped[other] {
                    None => {
                        flipped[other] = Some(own != alike);
                        waiting.push(other);
                    }
                    Some(known) => group.sided &= known == (own != alike),
                }
            }
        }
        group.faces.sort_unstable();
        groups.push(group);
    }
    let mut turned = BTreeSet::new();
    for group in groups.iter().filter(|group| group.sided) {
        // As few as may be.
        let count = group.faces.iter().filter(|&&face| flipped[face] == Some(true)).count();
        let which = 2 * count <= group.faces.len();
        turned.extend(group.faces.iter().filter(|&&face| flipped[face] == Some(which)));
    }
    turned.iter().for_each(|&face| turn(parts, face));
    (groups, turned)
}
