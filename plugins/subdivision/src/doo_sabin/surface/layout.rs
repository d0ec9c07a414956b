//! What of a surface follows from its topology alone: its faces, cells and edges.

use super::super::refine::intervals;
use super::leaf::Kept;
use super::spans::Spans;
use crate::cage::Cage;
use crate::error::{Result, SubdivisionError};
use crate::natural::{Natural, Naturals};
use crate::surface::holes::Rim;
use crate::surface::pattern::{Corner, Pattern, Quadrant};
use crate::topology::NONE;

/// What of a surface follows from its topology alone.
#[derive(Debug)]
pub(super) struct Layout {
    /// The corner of the cage of each face.
    pub(super) corners: Vec<u32>,
    /// The face at each corner; [`NONE`] where there is none.
    pub(super) faces: Vec<u32>,
    /// The first cell of each face, and the number of all.
    pub(super) cells: Vec<usize>,
    /// Quadrants of the four kinds of faces: whether the face of the cage is no quad, and whether its vertex has not four edges.
    pub(super) quadrants: [Vec<Quadrant>; 4],
    /// What these leave out of each kind.
    pub(super) rims: [Vec<Rim>; 4],
    /// Face and side of each edge of the boundary.
    pub(super) edges: Vec<(u32, u8)>,
    /// What knot intervals make of faces and vertices.
    pub(super) spans: Spans,
    /// The coordinates in which the surface is smooth at extraordinary points.
    pub(super) naturals: Naturals,
    /// The faces that were asked for last.
    pub(super) kept: Kept,
}

/// The place of a corner's kind among the four.
pub(super) fn kind(cage: &Cage, half: u32) -> usize {
    let topology = cage.topology();
    let face = topology.face_corners(topology.face_of(half) as usize).len() != 4;
    let vertex = topology.around(topology.origin(half) as usize).count() != 4;
    usize::from(face) + 2 * usize::from(vertex)
}

impl Layout {
    pub(super) fn new(cage: &Cage, depth: u32) -> Result<Self> {
        let topology = cage.topology();
        for vertex in 0..topology.vertex_count() {
            if !topology.is_boundary_vertex(vertex) && topology.around(vertex).nth(2).is_none() {
                let problem = "has two faces and two edges, and no piece of a Doo-Sabin surface belongs to such a one: refine the mesh once by \
                               the same scheme (scheme = \"doo-sabin\", levels = 1), then all have four"
                    .to_owned();
                return Err(SubdivisionError::Vertex { vertex, problem });
            }
        }
        let shown = |half: u32| {
            !cage.is_hole(topology.face_of(half) as usize)
                && !topology.is_boundary_vertex(topology.origin(half) as usize)
        };
        let corners: Vec<u32> = (0..topology.corner_count() as u32).filter(|&h| shown(h)).collect();
        if corners.is_empty() {
            let problem =
                "shows no piece of the surface, and no other face does: a piece belongs to a corner whose vertex has faces all round it, and \
                 whose face is no hole"
                    .to_owned();
            return Err(SubdivisionError::Face { face: 0, problem });
        }
        let spans = Spans::new(cage)?;
        if !corners.iter().any(|&half| intervals(cage, half).iter().all(|d| *d > 0.0)) {
            let vertex = corners.first().map_or(0, |&half| topology.origin(half)) as usize;
            let problem =
                "and all others inside the cage have intervals of 0, so that the surface has no extent: give some one above".to_owned();
            return Err(SubdivisionError::Vertex { vertex, problem });
        }
        let mut faces = vec![NONE; topology.corner_count()];
        (0..).zip(&corners).for_each(|(k, &h)| faces[h as usize] = k);
        let patterns = [0, 1, 2, 3].map(|kind| {
            let corner = |extraordinary| Corner { steps: 0, extraordinary };
            let plain = Corner::default();
            let corners = [corner(kind & 1 == 1), plain, corner(kind & 2 == 2), plain];
            Pattern { corners, ..Pattern::default() }
        });
        let rims = patterns.map(|pattern| Rim::all(&pattern, &pattern.quadrants(depth).1));
        let quadrants = patterns.map(|pattern| pattern.quadrants(depth).0);
        let mut cells = vec![0];
        let (mut count, mut edges) = (0, Vec::new());
        for (face, &half) in (0..).zip(&corners) {
            count += quadrants[kind(cage, half)].len();
            cells.push(count);
            let ends = |side: &usize| ends(cage, half, *side, |other| faces[other as usize] != NONE);
            edges.extend((0..4).filter(ends).map(|side| (face, side as u8)));
        }
        let naturals = Naturals::new(Natural::doo_sabin);
        Ok(Self { corners, faces, cells, quadrants, rims, edges, spans, naturals, kept: Kept::default() })
    }
}

/// The corners whose faces lie beyond the four sides of that at a corner: side 0 is `v = 0`, the others follow counterclockwise.
pub(super) fn beside(cage: &Cage, half: u32) -> [Option<u32>; 4] {
    let topology = cage.topology();
    let some = |h: u32| (h != NONE).then_some(h);
    let (before, after) = (topology.previous(half), topology.next(half));
    let over = some(topology.twin(half)).map(|twin| topology.next(twin));
    [Some(before), some(topology.twin(before)), over, Some(after)]
}

/// Whether by intervals the piece at a corner has no extent in the direction across a side.
pub(super) fn vanishes(cage: &Cage, half: u32, side: usize) -> bool {
    cage.has_end_intervals() && intervals(cage, half)[1 - side % 2] <= 0.0
}

/// Whether the surface ends at a side of the piece at a corner, those without extent across it being passed over.
pub(super) fn ends(cage: &Cage, half: u32, side: usize, is_there: impl Fn(u32) -> bool) -> bool {
    // Of none without extent, and of no side without length.
    if vanishes(cage, half, side) || vanishes(cage, half, side + 1) {
        return false;
    }
    let (mut half, mut side) = (half, side);
    loop {
        match beside(cage, half)[side] {
            // There are no two of these one after the other.
            Some(other) if is_there(other) => {
                // Sides 0 and 3 of neighbours meet, and 1 and 2.
                let entered = [3, 2, 1, 0][side];
                if !vanishes(cage, other, entered) {
                    return false;
                }
                (half, side) = (other, (entered + 2) % 4);
            }
            _ => return true,
        }
    }
}
