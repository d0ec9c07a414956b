//! Which edges of a mesh are seen as its outline, as creases, as borders, or not at all.

use std::collections::HashMap;

use loftsman_kernel::Vector;

use crate::chain::linked;
use crate::depth::ON_FACE;
use crate::draw::face::{Weight, newell, trace};
use crate::path::Path;
use crate::sheet::Sheet;
use crate::view::Lens;

/// Faces that meet at more than this angle make a crease: the cosine of 30 degrees.
const CREASE: f64 = 0.866;

/// The edges of a mesh by weight, each as the first points at its ends. `O(corners)` but for a sort.
pub(super) fn weighed(
    (points, corners, starts): (&[Vector], &[u32], &[usize]),
    lens: Lens,
) -> [Vec<(usize, usize)>; 4] {
    let same = merged(points);
    let mut sides: Vec<Side> = Vec::with_capacity(corners.len());
    let mut normals = Vec::with_capacity(starts.len());
    let mut facing = Vec::with_capacity(starts.len());
    for (face, range) in starts.windows(2).enumerate() {
        let face_corners = &corners[range[0]..range[1]];
        let outline: Vec<Vector> = face_corners.iter().map(|&i| points[i as usize]).collect();
        let normal = newell(&outline);
        facing.push(outline.first().is_some_and(|p| normal.dot(&lens.toward(p)) > 0.0));
        normals.push(normal.try_normalize(1e-200).unwrap_or_else(Vector::zeros));
        for (i, &a) in face_corners.iter().enumerate() {
            let [a, b] = [a, face_corners[(i + 1) % face_corners.len()]].map(|k| same[k as usize]);
            sides.push(Side { ends: (a.min(b), a.max(b)), face, forward: a < b });
        }
    }
    sides.sort_unstable_by_key(|side| (side.ends, side.face));
    let mut by_weight: [Vec<(usize, usize)>; 4] = Default::default();
    let mut rest = &sides[..];
    while let Some(first) = rest.first() {
        let count = rest.iter().take_while(|side| side.ends == first.ends).count();
        let weight = match &rest[..count] {
            [one, other] => {
                // Neighbours of one orientation run through their edge in opposite directions.
                let flip = one.forward == other.forward;
                let same = if flip { -1.0 } else { 1.0 };
                if (facing[one.face] != facing[other.face]) != flip {
                    Weight::Outline
                } else if normals[one.face].dot(&normals[other.face]) * same < CREASE {
                    Weight::Crease
                } else {
                    Weight::Inner
                }
            }
            _ => Weight::Border,
        };
        by_weight[weight as usize].push((first.ends.0 as usize, first.ends.1 as usize));
        rest = &rest[count..];
    }
    by_weight
}

/// The outline, creases and borders of a mesh that hides nothing, as far as no face hides them, as path data; empty where it has no faces.
pub(super) fn silhouette(
    sheet: &mut Sheet,
    lens: Lens,
    points: &[Vector],
    (corners, starts): (&[u32], &[usize]),
) -> String {
    let by_weight = weighed((points, corners, starts), lens);
    let mut path = Path::default();
    for weight in [Weight::Crease, Weight::Outline, Weight::Border] {
        for chain in linked(&by_weight[weight as usize]) {
            for run in sheet.runs(chain.iter().map(|&i| &points[i]), ON_FACE) {
                trace(sheet, &run, &mut path);
            }
        }
    }
    path.finish()
}

/// The first of all points at a place, for each point: exporters split a mesh where normals or textures differ, which makes
/// it no border. `O(points)`.
fn merged(points: &[Vector]) -> Vec<u32> {
    let mut first: HashMap<[u64; 3], u32> = HashMap::with_capacity(points.len());
    // Adding 0 makes one zero of both.
    let key = |p: &Vector| [p.x, p.y, p.z].map(|c| (c + 0.0).to_bits());
    points.iter().zip(0..).map(|(p, index)| *first.entry(key(p)).or_insert(index)).collect()
}

/// A side of a face: its ends in order, and whether the face runs from the first to the second.
struct Side {
    ends: (u32, u32),
    face: usize,
    forward: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_at_one_place_are_one() {
        let points = [[0.0, 1.0, 2.0], [3.0, 1.0, 2.0], [-0.0, 1.0, 2.0], [3.0, 1.0, 2.0]].map(Vector::from);
        assert_eq!(merged(&points), [0, 1, 0, 1]);
    }
}
