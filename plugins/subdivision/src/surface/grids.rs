//! Regular quads put together to rectangles: one bicubic B-spline surface each.

use std::collections::BTreeSet;

use loftsman_kernel::Point;
use loftsman_kernel::space::Space;
use loftsman_kernel::spline::Surface;

use super::net::turned;
use crate::error::Result;
use crate::topology::{NONE, Topology};

/// A quad of a rectangle, and the corner of it that is the rectangle's first.
type Placed = (usize, usize);

/// The quads that have a net, each once, as the largest rectangles found by going right and then up from those furthest left and down.
/// Neighbours belong to one rectangle where their nets agree to the bit in the twelve vertices that they share: so a crease, in which
/// each side is mirrored, is never inside. Cost: linear.
pub(super) fn grids(topology: &Topology, nets: &mut [Option<Box<[Point; 16]>>]) -> Result<Vec<Surface>> {
    let mut all = Vec::new();
    for face in 0..nets.len() {
        if nets[face].is_none() {
            continue;
        }
        let first = Walk { topology, nets }.first((face, 0));
        let rows = Walk { topology, nets }.rows(first);
        all.push(surface(&rows, nets)?);
        rows.iter().flatten().for_each(|&(face, _)| nets[face] = None);
    }
    Ok(all)
}

struct Walk<'a> {
    topology: &'a Topology,
    nets: &'a [Option<Box<[Point; 16]>>],
}

impl Walk<'_> {
    /// The neighbour beyond a side of a placed quad (0 below, 1 right, 2 above, 3 left), where one surface goes on.
    fn beyond(&self, (face, turn): Placed, side: usize) -> Option<Placed> {
        let start = self.topology.face_corners(face).start;
        let twin = self.topology.twin((start + (turn + side) % 4) as u32);
        if twin == NONE {
            return None;
        }
        let next = self.topology.face_of(twin) as usize;
        let corner = twin as usize - self.topology.face_corners(next).start;
        // Its own side `side + 2` is the one that is shared.
        let other = (next, (corner + 6 - side) % 4);
        let (own, its) = (self.net((face, turn))?, self.net(other)?);
        let (di, dj) = [(0, -1), (1, 0), (0, 1), (-1, 0)][side];
        let shared = (0..16_isize).all(|k| {
            let (i, j) = (k / 4 + di, k % 4 + dj);
            let inside = (0..4).contains(&i) && (0..4).contains(&j);
            !inside || own[(4 * i + j) as usize] == its[k as usize]
        });
        shared.then_some(other)
    }

    fn net(&self, (face, turn): Placed) -> Option<[Point; 16]> {
        self.nets.get(face)?.as_ref().map(|net| turned(net, turn))
    }

    /// As far left as there is a way, and then down.
    fn first(&self, from: Placed) -> Placed {
        let mut at = from;
        for side in [3, 0] {
            let start = at;
            for _ in 0..self.nets.len() {
                match self.beyond(at, side) {
                    Some(next) if next.0 != start.0 => at = next,
                    _ => break,
                }
            }
        }
        at
    }

    /// Rows of quads, each to the right of the one before, row above row.
    fn rows(&self, first: Placed) -> Vec<Vec<Placed>> {
        let mut used = BTreeSet::from([first.0]);
        let mut row = vec![first];
        while let Some(next) = self.beyond(row[row.len() - 1], 1).filter(|next| used.insert(next.0)) {
            row.push(next);
        }
        let mut rows = vec![row];
        while let Some(row) = self.above(&rows[rows.len() - 1]) {
            if !row.iter().all(|(face, _)| used.insert(*face)) {
                break;
            }
            rows.push(row);
        }
        rows
    }

    /// The row above one, where all of it is there and hangs together.
    fn above(&self, row: &[Placed]) -> Option<Vec<Placed>> {
        let above: Vec<Placed> = row.iter().map(|&quad| self.beyond(quad, 2)).collect::<Option<_>>()?;
        let mut faces: Vec<usize> = above.iter().map(|(face, _)| *face).collect();
        faces.sort_unstable();
        let distinct = faces.windows(2).all(|pair| pair[0] != pair[1]);
        (distinct && above.windows(2).all(|pair| self.beyond(pair[0], 1) == Some(pair[1]))).then_some(above)
    }
}

/// The surface over a rectangle: uniform, one unit a quad.
fn surface(rows: &[Vec<Placed>], nets: &[Option<Box<[Point; 16]>>]) -> Result<Surface> {
    let (width, height) = (rows.first().map_or(0, Vec::len), rows.len());
    let mut points = vec![Point::origin(); (width + 3) * (height + 3)];
    for (b, row) in rows.iter().enumerate() {
        for (a, &(face, turn)) in row.iter().enumerate() {
            let Some(net) = nets[face].as_ref().map(|net| turned(net, turn)) else { continue };
            for (k, p) in net.into_iter().enumerate() {
                points[(a + k / 4) * (height + 3) + b + k % 4] = p;
            }
        }
    }
    let space = |quads: usize| Space::floating_uniform(3, quads + 3);
    Ok(Surface::new(space(width)?, space(height)?, points)?)
}
