//! Where the vertices of a cage come to lie on the surface, and its tangent planes there.

use loftsman_kernel::{Point, Vector, parallel};

use loftsman_kernel::shape::Stencil;

use super::masks;
use super::ring::Ring;
use super::uneven::{self, Local};
use super::weights::Weights;
use crate::cage::{Cage, INFINITELY_SHARP, present};
use crate::error::{Result, SubdivisionError};
use crate::frame::{LimitFrame, LimitStencils};
use crate::row::Row;

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
/// plane need not exist.
///
/// By knot intervals: where the vertex is one of a grid (four quads whose opposite edges agree) the point and the tangents of the
/// bicubic spline with these knots, in closed form, multiple knots included (at a triple one, where the spline has a crease, the tangents
/// on the vertex's side). Elsewhere the neighbourhood is refined until its weights
/// stay the same to rounding, which takes at most some fifty levels, and the eigenvectors of what they come to are taken back through
/// these. Their error is that of rounding, where eigenvalues lie apart.
///
/// Cost: linear in the size of the ring; with unequal intervals that for each level, some milliseconds.
///
/// # Errors
/// When there is no such vertex or sector; when knot intervals leave the vertex without a limit (eigenvalues that meet those of the
/// point) or without a tangent plane: where all intervals on a line through it are zero, the surface has a corner or a crease.
pub fn limit_stencils(cage: &Cage, vertex: usize, sector: usize) -> Result<LimitStencils> {
    present("sector", sector, sectors(cage, vertex)?)?;
    if is_uniform(cage) {
        return Ok(rows(cage, vertex, sector));
    }
    let local = Local::new(cage, vertex)?;
    let rows = uneven_rows(&Weights::new(&local.cage), local.vertex, sector);
    let rows = rows.map_err(|error| renamed(error, vertex))?;
    let back = |s: Stencil| -> Stencil { s.iter().map(|(v, c)| (local.names[v] as usize, c)).collect() };
    Ok(LimitStencils { position: back(rows.position), tangents: rows.tangents.map(back) })
}

/// The row of the limit of a vertex that is there, whether it has a tangent plane or not.
pub(crate) fn limit_position(cage: &Cage, vertex: usize) -> Result<Stencil> {
    if is_uniform(cage) {
        return Ok(even_position(cage, vertex).into_stencil());
    }
    let local = Local::new(cage, vertex)?;
    let row = uneven::position(&Weights::new(&local.cage), local.vertex);
    let row = row.map_err(|error| renamed(error, vertex))?.into_stencil();
    Ok(row.iter().map(|(v, c)| (local.names[v] as usize, c)).collect())
}

/// The [rows](limit_stencils) of the limits of all vertices, on creases and at corners in their first sector; in parallel with the
/// feature `parallel`. Cost: linear in what comes out.
///
/// # Errors
/// As for [`limit_stencils`].
pub fn all_limit_stencils(cage: &Cage) -> Result<Vec<LimitStencils>> {
    cage.topology().find_edges_now();
    let count = cage.points().len();
    if is_uniform(cage) {
        return Ok(parallel::map(count, |vertex| rows(cage, vertex, 0)));
    }
    let weights = Weights::new(cage);
    parallel::map(count, |vertex| uneven_rows(&weights, vertex, 0)).into_iter().collect()
}

/// The rows of a vertex that is there, in a sector that is there, by intervals.
fn uneven_rows(weights: &Weights<'_>, vertex: usize, sector: usize) -> Result<LimitStencils> {
    let (position, tangents) = uneven::frame(weights, vertex, sector)?;
    let tangents = tangents.ok_or_else(|| {
        let problem = "has a limit by its knot intervals, and no tangent plane there: ask for its point alone (`limit_points`), or give \
                       its edges intervals above zero and nearer to each other";
        SubdivisionError::Vertex { vertex, problem: problem.to_owned() }
    })?;
    Ok(LimitStencils { position: position.into_stencil(), tangents: tangents.map(Row::into_stencil) })
}

/// An error of a vertex, by its number in the whole.
fn renamed(error: SubdivisionError, vertex: usize) -> SubdivisionError {
    match error {
        SubdivisionError::Vertex { problem, .. } => SubdivisionError::Vertex { vertex, problem },
        other => other,
    }
}

/// The rows of a vertex that is there, in a sector that is there, of a uniform cage.
fn rows(cage: &Cage, vertex: usize, sector: usize) -> LimitStencils {
    let (position, tangents) = even_rows(cage, vertex, sector);
    LimitStencils { position: position.into_stencil(), tangents: tangents.map(Row::into_stencil) }
}

/// The same as rows, whatever the intervals are.
pub(super) fn even_rows(cage: &Cage, vertex: usize, sector: usize) -> (Row, [Row; 2]) {
    let ring = Ring::new(cage, vertex);
    let (steps, limit, (edges, faces)) = (ring.steps(), ring.limit(), ring.size());
    let tangents = masks::tangents(limit, edges, faces, sector);
    (ring.row(masks::position(limit, edges, faces), steps), tangents.map(|mask| ring.row(mask, steps)))
}

/// The row of the point alone.
pub(super) fn even_position(cage: &Cage, vertex: usize) -> Row {
    let ring = Ring::new(cage, vertex);
    let (edges, faces) = ring.size();
    ring.row(masks::position(ring.limit(), edges, faces), ring.steps())
}

/// The limits of all vertices. Cost: linear; most quickly where all faces are quads; in parallel with the feature `parallel`; with unequal
/// intervals that of [`limit_stencils`] for each vertex that is none of a grid.
///
/// # Errors
/// When knot intervals leave a vertex without a limit, as for [`limit_stencils`].
pub fn limit_points(cage: &Cage) -> Result<Vec<Point>> {
    cage.topology().find_edges_now();
    if !is_uniform(cage) {
        let weights = Weights::new(cage);
        let point = |vertex| Ok(Point::from(applied(&uneven::position(&weights, vertex)?, cage)));
        return parallel::map(cage.points().len(), point).into_iter().collect();
    }
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

/// The limits of all vertices with their tangents, on creases and at corners those of the first [sector](sectors); tangents are zero
/// where knot intervals leave no tangent plane. Cost: linear, in parallel with the feature `parallel`; with unequal intervals that of
/// [`limit_stencils`] for each vertex that is none of a grid.
///
/// # Errors
/// As for [`limit_points`].
pub fn limit_frames(cage: &Cage) -> Result<Vec<LimitFrame>> {
    frames(cage, cage.points().len(), |k| k)
}

/// Those of some vertices, which are there.
pub(crate) fn limit_frames_of(cage: &Cage, vertices: &[u32]) -> Result<Vec<LimitFrame>> {
    frames(cage, vertices.len(), |k| vertices[k] as usize)
}

/// The limit frames of so many vertices.
fn frames(
    cage: &Cage,
    count: usize,
    vertex: impl Fn(usize) -> usize + Sync + Send,
) -> Result<Vec<LimitFrame>> {
    cage.topology().find_edges_now();
    if !is_uniform(cage) {
        let weights = Weights::new(cage);
        let frame = |k| {
            let (position, tangents) = uneven::frame(&weights, vertex(k), 0)?;
            let tangents = tangents.map_or([Vector::zeros(); 2], |rows| rows.map(|row| applied(&row, cage)));
            Ok(LimitFrame { point: Point::from(applied(&position, cage)), tangents })
        };
        return parallel::map(count, frame).into_iter().collect();
    }
    let means = means(cage);
    let waves: Vec<[f64; 3]> = (0..USUAL).map(wave).collect();
    Ok(parallel::map(count, |k| {
        let vertex = vertex(k);
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

/// A row applied to the points of a cage.
pub(super) fn applied(row: &Row, cage: &Cage) -> Vector {
    row.0.iter().fold(Vector::zeros(), |sum, &(v, c)| sum + cage.points[v as usize].coords * c)
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

/// Whether there are no knot intervals, or all are the same and positive.
pub(crate) fn is_uniform(cage: &Cage) -> bool {
    cage.intervals.first().is_none_or(|&first| first > 0.0 && cage.intervals.iter().all(|&d| d == first))
}

/// Whether the scheme is uniform: no knot intervals, or all the same.
pub(super) fn check_uniform(cage: &Cage) -> Result<()> {
    let Some(&first) = cage.intervals.first() else { return Ok(()) };
    let Some(edge) = cage.intervals.iter().position(|&d| d != first) else { return Ok(()) };
    let [from, to] = cage.topology.ends(edge).map(|v| v as usize);
    let problem = format!(
        "has the knot interval {}, others {first}: a piece with uniform knots is there where all are equal; a `SubdivisionSurface` \
         has the places between vertices by intervals",
        cage.intervals[edge]
    );
    Err(SubdivisionError::Edge { from, to, problem })
}
