//! The extraordinary points of a surface whose knot intervals differ.

use loftsman_kernel::error::Result;
use loftsman_kernel::shape::{Derivative, Stencil};

use super::{SubdivisionSurface, of_limit, refused};
use crate::cage::Cage;
use crate::catmull_clark::{Refinement, limit_position, limit_stencils, sectors};
use crate::error::SubdivisionError;
use crate::part::Part;
use crate::topology::NONE;

/// An extraordinary vertex as a corner of a face: its number, that of the half-edge that leaves it there, and of how many corners on from the
/// face's first it is.
struct At {
    vertex: usize,
    half: usize,
    turns: usize,
}

impl SubdivisionSurface {
    /// What is asked of an extraordinary corner of a face: rows over the cage, or, of the middle of a face that is no quad, over the refined
    /// cage and taken back.
    pub(super) fn uneven_corner(&self, face: usize, corner: usize, by: Derivative) -> Result<Stencil> {
        let [of, part] = self.layout.faces[face];
        let (of, topology) = (of as usize, self.cage.topology());
        let start = topology.face_corners(of).start;
        if part == NONE || corner == 0 {
            let (half, turns) =
                if part == NONE { (start + corner, corner) } else { (start + part as usize, 0) };
            let at = At { vertex: topology.origin(half as u32) as usize, half, turns };
            return asked(&self.cage, &at, by, || format!("corner {corner} of face {of} of the cage"));
        }
        // The face comes first in its neighbourhood, and so does its middle among those of faces.
        let near = Part::of_faces(topology, &[of], 2);
        let small = near.to_cage(&self.cage).map_err(refused)?;
        let vertex = small.points().len() + small.topology().edge_count();
        let refined = Refinement::new(small, 1).map_err(refused)?;
        let at = At { vertex, half: 4 * part as usize + 2, turns: 2 };
        let row = asked(refined.finest(), &at, by, || format!("the middle of face {of} of the cage"))?;
        let rows = refined.stencils(1).map_err(refused)?;
        let each = row.iter().flat_map(|(v, c)| rows[v].iter().map(move |(k, d)| (k, c * d)));
        Ok(each.map(|(k, c)| (near.kept[k] as usize, c)).collect())
    }
}

/// The row of what is asked of the limit of a vertex, seen from a corner.
fn asked(cage: &Cage, at: &At, by: Derivative, place: impl Fn() -> String) -> Result<Stencil> {
    if by == Derivative::POSITION {
        return limit_position(cage, at.vertex).map_err(refused);
    }
    let limit = limit_stencils(cage, at.vertex, sector(cage, at)?).map_err(refused)?;
    let [a, b] = limit.tangents;
    let tangents = match at.turns {
        0 => [a, b],
        1 => [b.scaled(-1.0), a],
        2 => [a.scaled(-1.0), b.scaled(-1.0)],
        _ => [b, a.scaled(-1.0)],
    };
    of_limit(crate::LimitStencils { position: limit.position, tangents }, by, place)
}

/// The sector of a vertex that a corner is in.
fn sector(cage: &Cage, at: &At) -> Result<usize> {
    let topology = cage.topology();
    let count = sectors(cage, at.vertex).map_err(refused)?;
    let place = topology.around(at.vertex).position(|h| h as usize == at.half).unwrap_or(0);
    let sharp = |e: u32| cage.sharpness(e as usize) >= crate::INFINITELY_SHARP;
    let lasting: Vec<usize> =
        topology.vertex_edges(at.vertex).enumerate().filter(|(_, e)| sharp(*e)).map(|(k, _)| k).collect();
    let is_corner = lasting.len() > 2 || cage.vertex_sharpness(at.vertex) >= crate::INFINITELY_SHARP;
    Ok(match lasting[..] {
        _ if count < 2 => 0,
        [a, b] if !is_corner => usize::from(!(a..b).contains(&place)),
        _ => place,
    })
}

/// The error of a face on which places are not known.
pub(super) fn differs(cage: &Cage, face: usize) -> SubdivisionError {
    let edges = cage.topology().face_edges(face);
    let d: Vec<String> = edges.iter().take(8).map(|&e| cage.interval(e as usize).to_string()).collect();
    let problem = format!(
        "has edges with the knot intervals {}: places between vertices are known where opposite edges of quads have the same, and of other \
         faces each edge and the next but one; give the edges of each row of faces one interval, or refine the cage instead (levels, with \
         limit = true: a mesh with its vertices on the surface)",
        d.join(", ")
    );
    SubdivisionError::Face { face, problem }
}

/// The error of an edge without an interval where there are no pieces.
pub(super) fn vanishes(cage: &Cage, edge: usize) -> SubdivisionError {
    let [from, to] = cage.topology().ends(edge).map(|v| v as usize);
    let problem =
        "has the knot interval 0: places between vertices are known where such an edge goes from one inner vertex of four quads, with nothing \
         sharp there, to another, or along the boundary from one of two quads to another, and the edges that go on beyond them have intervals \
         above 0; give it a small one, or refine the cage instead (levels, with limit = true: a mesh with its vertices on the surface)"
            .to_owned();
    SubdivisionError::Edge { from, to, problem }
}
