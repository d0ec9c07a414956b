//! What the cells of a surface leave out round extraordinary points, as holes with a border.

use loftsman_kernel::shape::{Border, Hole};

use super::SubdivisionSurface;
use super::pattern::{Pattern, Quadrant};
use crate::INFINITELY_SHARP;
use crate::topology::NONE;

/// A quadrant that is left out at an extraordinary corner, in coordinates from that corner, of which the first runs along the side that
/// follows it and the second along the side before.
#[derive(Debug, Clone)]
pub(crate) struct Rim {
    pub(crate) corner: usize,
    /// How long its sides are.
    pub(crate) size: f64,
    /// The two sides that are away from the corner, counterclockwise, in pieces along which the surface is one polynomial.
    outer: Vec<[[f64; 2]; 2]>,
}

/// Levels below a quadrant's own after which what is beyond its border is taken for regular.
const BELOW: u32 = 8;

impl Rim {
    /// Those of the quadrants that a face with a pattern leaves out. Cost: linear in these.
    pub(crate) fn all(pattern: &Pattern, left: &[Quadrant]) -> Vec<Self> {
        left.iter().filter_map(|&quadrant| Self::new(pattern, quadrant)).collect()
    }

    /// `None` where no corner of the face is one of the quadrant's, or the face is left out whole.
    fn new(pattern: &Pattern, quadrant: Quadrant) -> Option<Self> {
        let corner = (0..4).find(|&k| turned(quadrant.level, k, [0, 0]) == quadrant)?;
        if quadrant.level == 0 {
            return None;
        }
        let size = side(quadrant.level);
        // Along the line at `size` of either coordinate, what the other is where pieces end.
        let along = |swapped: bool| {
            let mut ends = vec![0.0];
            pieces(pattern, quadrant.level, &|level, j| {
                let beyond = 1 << (level - quadrant.level);
                turned(level, corner, if swapped { [j, beyond] } else { [beyond, j] })
            })
            .for_each(|end| ends.push(end));
            ends
        };
        let (first, second) = (along(false), along(true));
        let up = first.windows(2).map(|y| [[size, y[0]], [size, y[1]]]);
        let back = second.windows(2).rev().map(|x| [[x[1], size], [x[0], size]]);
        Some(Self { corner, size, outer: up.chain(back).collect() })
    }

    /// The hole on a face, with the pieces of its two sides at the corner, each given by how far from it they start and end, that are border
    /// too: along the one that follows it outwards, along the one before back.
    pub(crate) fn hole(&self, face: u32, degree: usize, sides: [&[[f64; 2]]; 2]) -> Hole {
        let [follows, before] = sides;
        let out = follows.iter().map(|x| [[x[0], 0.0], [x[1], 0.0]]);
        let back = before.iter().rev().map(|y| [[0.0, y[1]], [0.0, y[0]]]);
        let all = out.chain(self.outer.iter().copied()).chain(back);
        let place = |local| at(self.corner, local);
        let border = all.map(|[from, to]| Border { from: place(from), to: place(to), degree });
        Hole { face: Some(face), apex: place([0.0, 0.0]), border: border.collect() }
    }
}

/// The side of a quadrant of a level.
fn side(level: u32) -> f64 {
    0.5_f64.powi(level as i32)
}

/// The parameters of a place that is given in coordinates from a corner.
fn at(corner: usize, [x, y]: [f64; 2]) -> [f64; 2] {
    match corner {
        0 => [x, y],
        1 => [1.0 - y, x],
        2 => [1.0 - x, 1.0 - y],
        _ => [y, 1.0 - x],
    }
}

/// The quadrant of a level at a place that is counted from a corner.
fn turned(level: u32, corner: usize, [i, j]: [u64; 2]) -> Quadrant {
    let last = (1_u64 << level.min(60)) - 1;
    let (back_i, back_j) = (last.saturating_sub(i), last.saturating_sub(j));
    let (i, j) = match corner {
        0 => (i, j),
        1 => (back_j, i),
        2 => (back_i, back_j),
        _ => (j, back_i),
    };
    Quadrant { level, i, j }
}

/// Where the pieces end along one side, from 0 to that of a quadrant of a level: where what is beyond it is regular, given by level and number
/// along the side, that is one piece, else two halves.
fn pieces(
    pattern: &Pattern,
    level: u32,
    beyond: &dyn Fn(u32, u64) -> Quadrant,
) -> impl Iterator<Item = f64> + use<> {
    let (mut ends, mut rest) = (Vec::new(), vec![(level, 0_u64)]);
    let last = level + pattern.steps() + BELOW;
    while let Some((own, j)) = rest.pop() {
        if own < last && !pattern.is_regular(beyond(own, j)) {
            rest.extend([(own + 1, 2 * j + 1), (own + 1, 2 * j)]);
        } else {
            ends.push((j + 1) as f64 * side(own));
        }
    }
    ends.into_iter()
}

/// How far the hole reaches that is beyond a side.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Beyond {
    /// So far from the corner; 0 where there is none, for the face beyond is regular there or the surface ends at a crease.
    Hole(f64),
    /// The surface ends where it is smooth, with pieces without number.
    Nothing,
}

impl SubdivisionSurface {
    /// The [holes](loftsman_kernel::shape::Cells::holes) of all faces. Cost: linear.
    pub(super) fn all_holes(&self) -> Vec<Hole> {
        let layout = &self.layout;
        let patterns = layout.patterns.iter().zip(&layout.left);
        let rims: Vec<Vec<Rim>> = patterns.map(|(pattern, left)| Rim::all(pattern, left)).collect();
        let mut all = Vec::new();
        for (face, &pattern) in layout.pattern_of.iter().enumerate() {
            for rim in rims.get(pattern as usize).into_iter().flatten() {
                let sides = self.beyond(face, rim.corner).map(|beyond| self.uncovered(beyond, rim.size));
                let [follows, before] = &sides;
                all.push(rim.hole(face as u32, 3, [follows, before]));
            }
        }
        all
    }

    /// The pieces of a side of a hole along which there are cells beyond it, or nothing.
    fn uncovered(&self, beyond: Beyond, size: f64) -> Vec<[f64; 2]> {
        let Beyond::Hole(reach) = beyond else { return Vec::new() };
        // With knot intervals what is beside the corner's quadrant on each level is halved.
        let halves = |from: f64, to: f64| {
            let middle = 0.5 * (from + to);
            if self.cage.has_intervals() { vec![[from, middle], [middle, to]] } else { vec![[from, to]] }
        };
        if reach <= 0.0 {
            return halves(0.0, size);
        }
        let mut ends = vec![size];
        while ends.last().is_some_and(|&end| end > reach) {
            ends.push(0.5 * ends[ends.len() - 1]);
        }
        ends.windows(2).rev().flat_map(|pair| halves(pair[1], pair[0])).collect()
    }

    /// What is beyond the two sides of a face at a corner: beyond the one that follows it, and beyond the one before.
    fn beyond(&self, face: usize, corner: usize) -> [Beyond; 2] {
        let [of, part] = self.layout.faces[face];
        let topology = self.cage.topology();
        let halves = topology.face_corners(of as usize);
        if part != NONE && corner == 2 {
            // At the middle of a face its parts follow one another.
            let (first, count) = (face - part as usize, halves.len());
            let part_at = |k: usize| Beyond::Hole(self.reach(first + k % count, 2));
            return [part_at(part as usize + count - 1), part_at(part as usize + 1)];
        }
        let half = (halves.start + if part == NONE { corner } else { part as usize }) as u32;
        let before = topology.previous(half);
        let twin = topology.twin(half);
        let leaving =
            [(half, if twin == NONE { NONE } else { topology.next(twin) }), (before, topology.twin(before))];
        leaving.map(|(edge, other)| match self.at_half(other) {
            Some((there, corner, part)) => {
                Beyond::Hole(self.reach(there, corner) * share(part) / share(self.layout.faces[face][1]))
            }
            None if self.cage.sharpness(topology.edge_of(edge) as usize) >= INFINITELY_SHARP => {
                Beyond::Hole(0.0)
            }
            None => Beyond::Nothing,
        })
    }

    /// The face of the surface at the start of a half-edge, which of its corners that is, and the part of its cage's face that it is. `None` where
    /// nothing is shown.
    fn at_half(&self, half: u32) -> Option<(usize, usize, u32)> {
        if half == NONE {
            return None;
        }
        let topology = self.cage.topology();
        let of = topology.face_of(half) as usize;
        let first = self.layout.first[of];
        if first == NONE {
            return None;
        }
        let halves = topology.face_corners(of);
        let at = half as usize - halves.start;
        let whole = halves.len() == 4;
        Some(if whole { (first as usize, at, NONE) } else { (first as usize + at, 0, at as u32) })
    }

    /// How far the hole at a corner of a face reaches along its sides; 0 where there is none.
    fn reach(&self, face: usize, corner: usize) -> f64 {
        let pattern = self.layout.pattern(face);
        if pattern.corners[corner].extraordinary { side(pattern.steps() + self.depth) } else { 0.0 }
    }
}

/// How much of an edge of the cage a side of a face is: of a part of one that is no quad the half.
fn share(part: u32) -> f64 {
    if part == NONE { 1.0 } else { 0.5 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::pattern::Corner;

    /// Seen from any corner the border of a quadrant runs round it, and goes on where neighbours on the other side of it have pieces of half its
    /// size.
    #[test]
    fn borders_run_round_their_corners() {
        let corner = Corner { steps: 0, extraordinary: true };
        let pattern = Pattern { corners: [corner; 4], ..Pattern::default() };
        for (depth, pieces) in [(1, 4), (2, 2), (5, 2)] {
            let rims = Rim::all(&pattern, &pattern.quadrants(depth).1);
            assert_eq!(rims.len(), 4);
            for rim in rims {
                let hole = rim.hole(3, 3, [&[], &[]]);
                assert_eq!((hole.border.len(), hole.size()), (pieces, side(2 * depth)), "{hole:?}");
                assert!(hole.border.windows(2).all(|pair| pair[0].to == pair[1].from), "{hole:?}");
                let open = rim.hole(3, 3, [&[[0.0, rim.size]], &[[0.0, rim.size]]]);
                let (first, last) = (open.border[0], open.border[open.border.len() - 1]);
                assert!(first.from == hole.apex && last.to == hole.apex, "{open:?}");
                assert!(open.border.windows(2).all(|pair| pair[0].to == pair[1].from), "{open:?}");
            }
        }
    }
}
