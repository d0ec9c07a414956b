//! The bicubic net of a face where nothing is extraordinary, infinitely sharp creases taken as boundaries.

use smallvec::{SmallVec, smallvec};

use super::spans::Around;
use crate::cage::{Cage, INFINITELY_SHARP};
use crate::catmull_clark::weights::beyond_of;
use crate::topology::Topology;

/// Coefficients of vertices of the cage: four at most, those of a corner mirrored twice.
pub(super) type Row = SmallVec<[(u32, f64); 4]>;

/// The places of a face's corners in the net of 4 × 4, and from each the steps along the edge that follows and along the one before.
const PLACES: [([isize; 2], [isize; 2], [isize; 2]); 4] = [
    ([1, 1], [1, 0], [0, 1]),
    ([2, 1], [0, 1], [-1, 0]),
    ([2, 2], [-1, 0], [0, -1]),
    ([1, 2], [0, -1], [1, 0]),
];

/// The rows, over the vertices of the cage, of the 16 vertices of the uniform bicubic B-spline patch over a face, `u` after `u`; `None`
/// where the face is not regular.
///
/// Regular is a quad at each of whose corners nothing is sharp to a finite degree and which, seen from the face, is one of these: four
/// quads and nothing sharp; two quads between two edges of a crease or boundary; one quad between two sharp edges at a corner. The other
/// side of a crease does not matter. Beyond a crease the net is mirrored in it, as [`patch_stencils`](crate::catmull_clark::patch_stencils)
/// does beyond a boundary. Cost: the valences of the corners.
///
/// With knot intervals the face is regular where they are, too, those of a tensor-product spline: the same along parallel edges, as far as
/// they have a say. The net is that of the same patch with uniform knots over the face.
pub(super) fn net(cage: &Cage, face: usize) -> Option<[Row; 16]> {
    net_by(cage, face, &|edge| beyond_of(cage, edge))
}

/// The same of a part of a cage, where it is said what is beyond the ends of edges.
pub(super) fn net_by(cage: &Cage, face: usize, beyond: &dyn Fn(usize) -> [f64; 2]) -> Option<[Row; 16]> {
    let topology = cage.topology();
    let corners = topology.face_corners(face);
    if corners.len() != 4 {
        return None;
    }
    let mut net: [Row; 16] = std::array::from_fn(|_| Row::default());
    let mut around = Around::default();
    for (half, (at, a, b)) in corners.zip(PLACES) {
        let rows = corner(cage, half as u32)?;
        if cage.has_intervals() {
            quads(cage, half as u32, &mut |quad, turns| {
                let [c, d] = [[-a[0], -a[1]], [-b[0], -b[1]]];
                let mut directions = [a, b, c, d];
                directions.rotate_left(turns);
                around.quad(cage, quad, at, directions, beyond);
            });
        }
        for (row, back) in rows.into_iter().zip([[0, 0], [1, 0], [0, 1], [1, 1]]) {
            let [i, j] = [0, 1].map(|k| (at[k] - back[0] * a[k] - back[1] * b[k]) as usize);
            net[4 * i + j] = row;
        }
    }
    if cage.has_intervals() { around.uniform(net) } else { Some(net) }
}

/// The quads at a regular corner that its net is made of, by the half-edges that leave it in them, and how often each is turned
/// counterclockwise from the face itself.
fn quads(cage: &Cage, half: u32, each: &mut dyn FnMut(u32, usize)) {
    let topology = cage.topology();
    let sharp = |h: u32| cage.sharpness(topology.edge_of(h) as usize) >= INFINITELY_SHARP;
    each(half, 0);
    let (right, left) = (sharp(half), sharp(topology.previous(half)));
    if !left {
        let second = turn(topology, half);
        each(second, 1);
        if !right {
            let third = turn(topology, second);
            each(third, 2);
            each(turn(topology, third), 3);
        }
    } else if !right {
        each(topology.next(topology.twin(half)), 3);
    }
}

/// Of a corner of a face: its own row, and those beyond it along the edge that follows, along the one before, and across.
fn corner(cage: &Cage, half: u32) -> Option<[Row; 4]> {
    let topology = cage.topology();
    let v = topology.origin(half);
    let (mut lasting, mut edges) = (0, 0);
    for edge in topology.vertex_edges(v as usize) {
        let sharpness = cage.sharpness(edge as usize);
        lasting += usize::from(sharpness >= INFINITELY_SHARP);
        edges += 1;
        if sharpness > 0.0 && sharpness < INFINITELY_SHARP {
            return None;
        }
    }
    let own_sharpness = cage.vertex_sharpness(v as usize);
    if own_sharpness > 0.0 && own_sharpness < INFINITELY_SHARP {
        return None;
    }
    let is_corner = own_sharpness > 0.0 || lasting > 2;
    let quad = |h: u32| topology.face_corners(topology.face_of(h) as usize).len() == 4;
    let sharp = |h: u32| cage.sharpness(topology.edge_of(h) as usize) >= INFINITELY_SHARP;
    let (along, before) = (end(topology, half), topology.origin(topology.previous(half)));
    let at = |v: u32| -> Row { smallvec![(v, 1.0)] };
    let mirrored = |point: u32, inside: u32| -> Row { smallvec![(point, 2.0), (inside, -1.0)] };
    match (lasting, is_corner, sharp(half), sharp(topology.previous(half))) {
        (0, false, ..) => {
            if edges != 4 || !topology.around(v as usize).all(quad) {
                return None;
            }
            let second = turn(topology, turn(topology, half));
            let third = turn(topology, second);
            Some([at(v), at(end(topology, second)), at(end(topology, third)), at(across(topology, second))])
        }
        (2, false, true, false) => {
            let left = turn(topology, half);
            if !quad(left) || !sharp(topology.previous(left)) {
                return None;
            }
            let far = topology.origin(topology.previous(left));
            Some([at(v), at(far), mirrored(v, before), mirrored(far, across(topology, left))])
        }
        (2, false, false, true) => {
            let right = topology.next(topology.twin(half));
            if !quad(right) || !sharp(right) {
                return None;
            }
            let far = end(topology, right);
            Some([at(v), mirrored(v, along), at(far), mirrored(far, across(topology, right))])
        }
        (_, true, true, true) => {
            let diagonal: Row =
                smallvec![(v, 4.0), (along, -2.0), (before, -2.0), (across(topology, half), 1.0)];
            Some([at(v), mirrored(v, along), mirrored(v, before), diagonal])
        }
        _ => None,
    }
}

/// The next half-edge that leaves the same vertex, counterclockwise.
fn turn(topology: &Topology, half: u32) -> u32 {
    topology.twin(topology.previous(half))
}

/// The vertex at which a half-edge ends.
fn end(topology: &Topology, half: u32) -> u32 {
    topology.origin(topology.next(half))
}

/// The vertex across a quad.
fn across(topology: &Topology, half: u32) -> u32 {
    end(topology, topology.next(half))
}
