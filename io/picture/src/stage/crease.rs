//! Creases inside the faces of a Brep: where a surface has a corner along a knot line, or where it closes with one.

use std::collections::{BTreeMap, BTreeSet, HashSet};

use loftsman_kernel::Vector;
use loftsman_kernel::mesh::{Mesh, NONE};
use loftsman_kernel::plugin::TessellatedBrep;

use super::shell::{Edge, Kind, Side, Sides, pair};
use crate::chain::linked;

/// Triangles of one face whose normals turn by more along a side have a crease there: its cosine, of one degree.
const STRAIGHT: f64 = 0.999_848;

/// What a side of two triangles of one face is to the eye: nothing, where the normals are one at either end. At both ends they differ only
/// along a crease: around a pole every triangle has a normal of its own, and shares those at its far side.
fn bend(sides: &Sides<'_>, list: &[Side]) -> Option<Kind> {
    let [one, other] = list else { return None };
    match sides.is_within(one, other, STRAIGHT) {
        [false, false] if sides.is_smooth(one, other) => Some(Kind::Smooth),
        [false, false] => Some(Kind::Sharp),
        _ => None,
    }
}

/// The creases inside faces, as chains of points: triangles never reach across one, and have the normal of their own side there. What is an edge of
/// the Brep is none of them. Linear in the corners but for a sort of what is creased.
pub(super) fn creases(cut: &TessellatedBrep) -> Vec<Edge> {
    let TessellatedBrep { mesh, edges, faces, .. } = cut;
    let bent = bent(mesh);
    let known: HashSet<(u32, u32)> =
        edges.iter().flat_map(|chain| chain.windows(2)).map(|s| pair(s[0], s[1])).collect();
    let inside: BTreeSet<(u32, u32)> = mesh
        .faces()
        .flat_map(|corners| (0..corners.len()).map(|k| [corners[k], corners[(k + 1) % corners.len()]]))
        .filter(|ends| ends.iter().all(|end| bent[*end as usize]))
        .map(|[a, b]| pair(a, b))
        .filter(|ends| !known.contains(ends))
        .collect();
    let sides = Sides::new(mesh, inside.iter().copied());
    let mut found: BTreeMap<u32, Vec<(usize, usize)>> = BTreeMap::new();
    for (a, b) in inside {
        let list = sides.at(a, b);
        let face = |side: &Side| faces[side.0 as usize];
        if bend(&sides, list).is_some() && face(&list[0]) == face(&list[1]) {
            found.entry(face(&list[0]) as u32).or_default().push((a as usize, b as usize));
        }
    }
    let chains = found.into_values().flat_map(|segments| linked(&segments));
    let points = chains.map(|chain| chain.into_iter().map(|k| k as u32).collect());
    points.filter_map(|points| bent_edge(&sides, points)).collect()
}

/// A chain of points along which triangles of one face meet at an angle, as sharp as it is anywhere; `None` where it is smooth.
pub(super) fn bent_edge(sides: &Sides<'_>, points: Vec<u32>) -> Option<Edge> {
    let lists: Vec<&[Side]> = points.windows(2).map(|s| sides.at(s[0], s[1])).collect();
    let bends: Vec<Kind> = lists.iter().filter_map(|list| bend(sides, list)).collect();
    let kind = if bends.contains(&Kind::Sharp) { Kind::Sharp } else { *bends.first()? };
    let both = |list: &&[Side]| Some([list.first()?.0, list.get(1)?.0]);
    let beside = lists.iter().filter(|_| kind == Kind::Smooth).filter_map(both).collect();
    Some(Edge { kind, points, beside })
}

/// Which points have corners with normals that differ.
fn bent(mesh: &Mesh) -> Vec<bool> {
    let mut first: Vec<Option<&Vector>> = vec![None; mesh.points().len()];
    let mut bent = vec![false; first.len()];
    for (corner, &point) in mesh.corners().iter().enumerate() {
        let index = mesh.normals.index(corner, point);
        let Some(normal) = mesh.normals.values().get(index as usize).filter(|_| index != NONE) else {
            continue;
        };
        let at = point as usize;
        bent[at] |= first[at].get_or_insert(normal).dot(normal) < STRAIGHT;
    }
    bent
}
