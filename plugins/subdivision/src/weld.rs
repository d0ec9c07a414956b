//! Limits of cages with zero intervals: what is one point of the surface becomes one point of the mesh.

use loftsman_kernel::Vector;
use loftsman_kernel::mesh::{Layer, Mesh};

use crate::cage::Cage;
use crate::error::Result;
use crate::frame::LimitFrame;

/// Limits of the two ends of an edge without an interval are one point of the surface, but for rounding: so near to each other, by the
/// size of the surface and by that of the coordinates that it was made of.
const ROUNDING: [f64; 2] = [1e-12, 1e-13];

/// The mesh of the limits of a cage's vertices, where those that zero intervals bring together are one and faces without area are not
/// there; with normals where each point has one. `size` is the largest coordinate of what all this was made of.
pub(crate) fn welded(cage: &Cage, frames: &[LimitFrame], size: f64) -> Result<Mesh> {
    let topology = cage.topology();
    let pairs = (0..topology.edge_count()).filter(|&e| cage.interval(e) == 0.0);
    let faces = (0..topology.face_count()).filter(|&f| !cage.is_hole(f));
    let corners = faces.map(|f| topology.face(f).iter().map(|&v| v as usize).collect());
    welded_by(frames, pairs.map(|e| topology.ends(e).map(|v| v as usize)), corners, size)
}

/// The mesh of limits and faces over them, those of the pairs that are in one place being one.
pub(crate) fn welded_by(
    frames: &[LimitFrame],
    pairs: impl Iterator<Item = [usize; 2]>,
    faces: impl Iterator<Item = Vec<usize>>,
    size: f64,
) -> Result<Mesh> {
    let mut group: Vec<usize> = (0..frames.len()).collect();
    let extent = frames.iter().fold(0.0, |most: f64, f| most.max((f.point - frames[0].point).amax()));
    let near = ROUNDING[0] * extent + ROUNDING[1] * size;
    for [a, b] in pairs {
        if (frames[a].point - frames[b].point).amax() <= near {
            let (a, b) = (root(&mut group, a), root(&mut group, b));
            group[a.max(b)] = a.min(b);
        }
    }
    let mut place = vec![usize::MAX; frames.len()];
    let (mut points, mut normals): (Vec<_>, Vec<Option<Vector>>) = (Vec::new(), Vec::new());
    for (vertex, frame) in frames.iter().enumerate() {
        let first = root(&mut group, vertex);
        if first == vertex {
            place[vertex] = points.len();
            points.push(frame.point);
            normals.push(None);
        }
        // The first of a group comes before the others. Not each has a normal of its own.
        place[vertex] = place[first];
        let normal = &mut normals[place[first]];
        *normal = normal.or_else(|| frame.normal());
    }
    let mut kept = Vec::new();
    for mut corners in faces {
        corners.iter_mut().for_each(|v| *v = place[*v]);
        corners.dedup();
        while corners.len() > 1 && corners.first() == corners.last() {
            corners.pop();
        }
        if corners.len() > 2 {
            kept.push(corners);
        }
    }
    let mut mesh = Mesh::new(points, &kept)?;
    mesh.normals = normals.into_iter().collect::<Option<Vec<_>>>().map_or_else(Layer::none, Layer::per_point);
    Ok(mesh)
}

/// The first of a vertex's group.
pub(crate) fn root(group: &mut [usize], mut vertex: usize) -> usize {
    while group[vertex] != vertex {
        group[vertex] = group[group[vertex]];
        vertex = group[vertex];
    }
    vertex
}
