//! The normals that a surface has on the sides of creases which never end.

use loftsman_kernel::mesh::{Layer, NONE};
use loftsman_kernel::{Vector, parallel};

use super::limit::{applied, even_rows, is_uniform};
use super::ring::{Limit, Ring};
use super::uneven;
use super::weights::Weights;
use crate::cage::{Cage, INFINITELY_SHARP};
use crate::error::Result;
use crate::frame::LimitFrame;

/// Two unit normals that differ by less are one: that is rounding.
const ALIKE: f64 = 1e-9;

/// The normals of the limits of all vertices, for the corners of [`Cage::to_mesh`]: of a vertex where the surface is smooth, on the boundary and
/// at the end of a crease one; where creases of infinite sharpness pass, and at corners, each face's corner has that of its own
/// [sector](super::sectors). By points where no vertex has more than one; nothing where some have none. `frames` are those of all vertices
/// ([`limit_frames`](super::limit_frames)). Cost: linear in the corners, and that of the rows of the vertices that have several.
///
/// # Errors
/// When knot intervals leave a vertex without a limit, as for [`limit_stencils`](super::limit_stencils).
pub fn limit_normals(cage: &Cage, frames: &[LimitFrame]) -> Result<Layer<Vector>> {
    let Some(mut values) = frames.iter().map(LimitFrame::normal).collect::<Option<Vec<Vector>>>() else {
        return Ok(Layer::none());
    };
    let all: Vec<u32> = (0..cage.points().len() as u32).collect();
    let sides = side_normals(cage, &all)?;
    if sides.is_empty() {
        return Ok(Layer::per_point(values));
    }
    let topology = cage.topology();
    let mut own: Vec<u32> = (0..topology.corner_count() as u32).map(|half| topology.origin(half)).collect();
    let mut last = (NONE, values.len());
    for (half, normal) in sides {
        let Some(normal) = normal else { return Ok(Layer::none()) };
        let vertex = topology.origin(half);
        if last.0 != vertex {
            last = (vertex, values.len());
        }
        let known = std::iter::once(vertex as usize).chain(last.1..values.len());
        let mut alike = known.filter(|&k| is_alike(&values[k], &normal));
        own[half as usize] = match alike.next() {
            Some(known) => known as u32,
            None => {
                values.push(normal);
                values.len() as u32 - 1
            }
        };
    }
    if values.len() == frames.len() {
        return Ok(Layer::per_point(values));
    }
    let shown = (0..topology.face_count()).filter(|&face| !cage.is_hole(face));
    let corners = shown.flat_map(|face| &own[topology.face_corners(face)]).copied().collect();
    Ok(Layer::per_corner(values, corners))
}

/// Whether two unit normals are the same but for rounding.
pub(crate) fn is_alike(a: &Vector, b: &Vector) -> bool {
    (a - b).norm() <= ALIKE
}

/// Of those of some vertices that have more than one [sector](super::sectors): for each corner of a face there, by its half-edge, the unit
/// normal of its sector; `None` where that has none.
pub(crate) fn side_normals(cage: &Cage, vertices: &[u32]) -> Result<Vec<(u32, Option<Vector>)>> {
    let split: Vec<usize> = vertices.iter().map(|&v| v as usize).filter(|&v| may_be_split(cage, v)).collect();
    let weights = (!split.is_empty() && !is_uniform(cage)).then(|| Weights::new(cage));
    let of = |k: usize| -> Result<Vec<(u32, Option<Vector>)>> {
        let vertex = split[k];
        let sectors = sectors_of_faces(cage, vertex);
        let count = sectors.iter().max().map_or(0, |most| most + 1);
        if count < 2 {
            return Ok(Vec::new());
        }
        let normal = |sector| -> Result<Option<Vector>> {
            let tangents = match &weights {
                Some(weights) => uneven::frame(weights, vertex, sector)?.1,
                None => Some(even_rows(cage, vertex, sector).1),
            };
            let Some(tangents) = tangents else { return Ok(None) };
            let tangents = tangents.map(|row| applied(&row, cage));
            Ok(LimitFrame { point: cage.points()[vertex], tangents }.normal())
        };
        let normals = (0..count).map(normal).collect::<Result<Vec<_>>>()?;
        let halves = cage.topology().around(vertex);
        Ok(halves.zip(sectors).map(|(half, sector)| (half, normals[sector])).collect())
    };
    let found = parallel::map(split.len(), of).into_iter().collect::<Result<Vec<_>>>()?;
    Ok(found.into_iter().flatten().collect())
}

/// Whether something is sharp for ever at a vertex but the boundary.
fn may_be_split(cage: &Cage, vertex: usize) -> bool {
    let lasting = |edge: u32| cage.crease(edge as usize) >= INFINITELY_SHARP;
    cage.corner(vertex) >= INFINITELY_SHARP || cage.topology().vertex_edges(vertex).any(lasting)
}

/// The sector that each face of a vertex is in, in the order of [`vertex_faces`](crate::Topology::vertex_faces).
fn sectors_of_faces(cage: &Cage, vertex: usize) -> Vec<usize> {
    let ring = Ring::new(cage, vertex);
    let (edges, faces) = ring.size();
    let sector = |face: usize| match ring.limit() {
        Limit::Smooth | Limit::Dart(_) => 0,
        // On the boundary the crease is that, and all faces are between its ends.
        Limit::Crease([a, b]) => usize::from(edges == faces && !(a..b).contains(&face)),
        Limit::Corner => face,
    };
    (0..faces).map(sector).collect()
}
