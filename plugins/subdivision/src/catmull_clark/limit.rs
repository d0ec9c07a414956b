//! Where the vertices of a cage come to lie on the surface, and its tangent planes there.

use loftsman_kernel::{Point, Vector, parallel};

use super::masks;
use super::ring::Ring;
use crate::cage::{Cage, INFINITELY_SHARP, present};
use crate::error::{Result, SubdivisionError};
use crate::frame::{LimitFrame, LimitStencils};

/// The number of sides on which the surface has tangents of its own at a vertex: one where it is smooth, on the boundary and at the end
/// of a crease; two on a crease; at a corner one for each face. Sector 0 of a crease lies to the left of its first edge (in the order of
/// [`Topology::vertex_edges`](crate::Topology::vertex_edges)), that of a corner is its first face.
///
/// # Errors
/// When there is no such vertex.
pub fn sectors(cage: &Cage, vertex: usize) -> Result<usize> {
    present("vertex", vertex, cage.points().len())?;
    let ring = Ring::new(cage, vertex);
    let (edges, faces) = ring.size();
    Ok(masks::sectors(ring.limit(), edges, faces))
}

/// The rows of the limit of a vertex: its point, and tangents in a [sector](sectors), 0 for the first.
///
/// Exact, to rounding, for faces of any size, any valence, and sharpness of any kind: finite sharpness and faces that are no quads are
/// refined away first. The point is that of Halstead, Kass and DeRose (1993) where nothing is sharp; the tangents are left eigenvectors
/// of the scheme as it is, so that they are those of the surface also where OpenSubdiv takes masks of another (creases with other than
/// two faces on a side; ends of creases). Where three eigenvalues are equal (valence 2) or a corner has more than one face, a tangent
/// plane need not exist. Cost: linear in the size of the ring; where the cage has knot intervals, in the number of its edges, too.
///
/// # Errors
/// When there is no such vertex or sector; when knot intervals differ, for then no limit is known.
pub fn limit_stencils(cage: &Cage, vertex: usize, sector: usize) -> Result<LimitStencils> {
    check_uniform(cage)?;
    present("sector", sector, sectors(cage, vertex)?)?;
    Ok(rows(cage, vertex, sector))
}

/// The [rows](limit_stencils) of the limits of all vertices, on creases and at corners in their first sector; in parallel with the
/// feature `parallel`. Cost: linear in what comes out.
///
/// # Errors
/// When knot intervals differ, for then no limit is known.
pub fn all_limit_stencils(cage: &Cage) -> Result<Vec<LimitStencils>> {
    check_uniform(cage)?;
    Ok(parallel::map(cage.points().len(), |vertex| rows(cage, vertex, 0)))
}

/// The rows of a vertex that is there, in a sector that is there.
fn rows(cage: &Cage, vertex: usize, sector: usize) -> LimitStencils {
    let ring = Ring::new(cage, vertex);
    let (steps, limit, (edges, faces)) = (ring.steps(), ring.limit(), ring.size());
    let tangents = masks::tangents(limit, edges, faces, sector);
    LimitStencils {
        position: ring.row(masks::position(limit, edges, faces), steps).into_stencil(),
        tangents: tangents.map(|mask| ring.row(mask, steps).into_stencil()),
    }
}

/// The limits of all vertices. Cost: linear; most quickly where all faces are quads; in parallel with the feature `parallel`.
///
/// # Errors
/// When knot intervals differ, for then no limit is known.
pub fn limit_points(cage: &Cage) -> Result<Vec<Point>> {
    check_uniform(cage)?;
    let means = means(cage);
    Ok(parallel::map(cage.points().len(), |vertex| {
        if is_regular(cage, vertex) {
            return smooth_point(cage, vertex);
        }
        let ring = Ring::new(cage, vertex);
        let (edges, faces) = ring.size();
        let mask = masks::position(ring.limit(), edges, faces);
        Point::from(ring.apply(mask, ring.steps(), &means))
    }))
}

/// The limits of all vertices with their tangents, on creases and at corners those of the first [sector](sectors). Cost: linear, in
/// parallel with the feature `parallel`.
///
/// # Errors
/// When knot intervals differ, for then no limit is known.
pub fn limit_frames(cage: &Cage) -> Result<Vec<LimitFrame>> {
    check_uniform(cage)?;
    let means = means(cage);
    let waves: Vec<[f64; 3]> = (0..USUAL).map(wave).collect();
    Ok(parallel::map(cage.points().len(), |vertex| {
        if is_regular(cage, vertex)
            && let Some(frame) = smooth_frame(cage, vertex, &waves)
        {
            return frame;
        }
        let ring = Ring::new(cage, vertex);
        let (limit, steps, (edges, faces)) = (ring.limit(), ring.steps(), ring.size());
        let apply = |mask| ring.apply(mask, steps, &means);
        LimitFrame {
            point: Point::from(apply(masks::position(limit, edges, faces))),
            tangents: masks::tangents(limit, edges, faces, 0).map(apply),
        }
    }))
}

/// The means of all faces, where limits need them: nothing of a cage of quads without finite sharpness.
fn means(cage: &Cage) -> Vec<Point> {
    let finite = |s: &f64| *s > 0.0 && *s < INFINITELY_SHARP;
    if cage.topology().is_quads() && !cage.creases.iter().chain(&cage.corners).any(finite) {
        return Vec::new();
    }
    parallel::map(cage.topology().face_count(), |face| {
        let corners = cage.topology().face(face);
        let sum = corners.iter().fold(Vector::zeros(), |sum, &v| sum + cage.points()[v as usize].coords);
        Point::from(sum / corners.len() as f64)
    })
}

/// Whether a vertex is smooth and has nothing but quads round it.
fn is_regular(cage: &Cage, vertex: usize) -> bool {
    let topology = cage.topology();
    if topology.is_boundary_vertex(vertex) || cage.corner(vertex) > 0.0 {
        return false;
    }
    let plain = cage.creases.is_empty() && topology.is_quads();
    plain
        || topology.around(vertex).all(|h| {
            cage.crease(topology.edge_of(h) as usize) <= 0.0
                && topology.face_corners(topology.face_of(h) as usize).len() == 4
        })
}

/// `(n² P + 4 Σ E + Σ Q) / (n (n + 5))`.
fn smooth_point(cage: &Cage, vertex: usize) -> Point {
    let topology = cage.topology();
    let at = |half: u32| cage.points[topology.origin(half) as usize].coords;
    let (mut near, mut far, mut n) = (Vector::zeros(), Vector::zeros(), 0.0);
    for half in topology.around(vertex) {
        let next = topology.next(half);
        near += at(next);
        far += at(topology.next(next));
        n += 1.0;
    }
    Point::from((cage.points[vertex].coords * (n * n) + near * 4.0 + far) / (n * (n + 5.0)))
}

/// Valences below this have their cosines at hand.
const USUAL: usize = 33;

/// The cosine and sine of a turn by one of `n` edges, and the weight of the vertices across.
fn wave(n: usize) -> [f64; 3] {
    let angle = std::f64::consts::TAU / n.max(1) as f64;
    let lambda = (5.0 + angle.cos() + ((1.0 + angle.cos()) * (9.0 + angle.cos())).sqrt()) / 16.0;
    [angle.cos(), angle.sin(), 0.25 / (4.0 * lambda - 1.0)]
}

/// Point and tangents of a smooth vertex of usual valence, in one pass; differences from the vertex are summed, so that nothing is
/// lost far from the origin.
fn smooth_frame(cage: &Cage, vertex: usize, waves: &[[f64; 3]]) -> Option<LimitFrame> {
    let topology = cage.topology();
    let n = topology.around(vertex).count();
    let [cos, sin, across] = *waves.get(n).filter(|_| n > 2)?;
    let centre = cage.points[vertex];
    let at = |half: u32| cage.points[topology.origin(half) as usize] - centre;
    let (mut near, mut far) = (Vector::zeros(), Vector::zeros());
    let mut tangents = [Vector::zeros(); 2];
    let (mut c, mut s) = (1.0, 0.0);
    for half in topology.around(vertex) {
        let next = topology.next(half);
        let (e, q) = (at(next), at(topology.next(next)));
        near += e;
        far += q;
        let turned = (c * cos - s * sin, s * cos + c * sin);
        tangents[0] += e * c + q * (across * (c + turned.0));
        tangents[1] += e * s + q * (across * (s + turned.1));
        (c, s) = turned;
    }
    let count = n as f64;
    Some(LimitFrame { point: centre + (near * 4.0 + far) / (count * (count + 5.0)), tangents })
}

/// Whether the scheme is uniform: no knot intervals, or all the same.
pub(crate) fn check_uniform(cage: &Cage) -> Result<()> {
    let Some(&first) = cage.intervals.first() else { return Ok(()) };
    let Some(edge) = cage.intervals.iter().position(|&d| d != first) else { return Ok(()) };
    let [from, to] = cage.topology.ends(edge).map(|v| v as usize);
    let problem = format!(
        "has the knot interval {}, others {first}: limits are known where all are equal; refine instead",
        cage.intervals[edge]
    );
    Err(SubdivisionError::Edge { from, to, problem })
}
