//! Which quadrants of a face are bicubic: known from what its corners and edges are, without refining anything.

use super::regular;
use crate::cage::{Cage, INFINITELY_SHARP};

/// What a corner of a face is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(crate) struct Corner {
    /// Levels until nothing is sharp to a finite degree and all faces are quads.
    pub(crate) steps: u8,
    /// Whether the surface is no bicubic spline round it even then.
    pub(crate) extraordinary: bool,
}

/// What the corners of a face are, and how many levels each edge, from a corner to the next, is sharp to a finite degree.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(crate) struct Pattern {
    pub(crate) corners: [Corner; 4],
    pub(crate) edges: [u8; 4],
    /// Levels before there are pieces anywhere: with knot intervals, where those round it are no tensor-product spline's yet.
    pub(crate) before: u8,
    /// So many quadrants side by side from an extraordinary corner, and from what is sharp to a finite degree, are none: 1, and 2 with knot
    /// intervals, for these say different things on the two sides of an edge that ends there.
    pub(crate) reach: Reach,
}

/// Quadrants at an extraordinary or sharp corner that are not bicubic.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(crate) enum Reach {
    /// The one at the corner.
    #[default]
    One,
    /// Two by two.
    Two,
}

/// A quadrant: `[i, i + 1] × [j, j + 1]` of `2^-level`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Quadrant {
    pub(crate) level: u32,
    pub(crate) i: u64,
    pub(crate) j: u64,
}

impl Quadrant {
    pub(crate) const WHOLE: Self = Self { level: 0, i: 0, j: 0 };

    /// The quadrant of a level that holds a place: at a border the one to its right.
    pub(crate) fn holding(level: u32, u: f64, v: f64) -> Self {
        let count = (1u64 << level.min(52)) as f64;
        let index = |x: f64| (x * count).floor().clamp(0.0, count - 1.0) as u64;
        Self { level, i: index(u), j: index(v) }
    }

    /// The one that it is a part of, and the number of the corner that it shares with it; `None` for the whole.
    pub(crate) fn parent(self) -> Option<(Self, usize)> {
        let level = self.level.checked_sub(1)?;
        let corner = match (self.i % 2, self.j % 2) {
            (0, 0) => 0,
            (1, 0) => 1,
            (1, _) => 2,
            _ => 3,
        };
        Some((Self { level, i: self.i / 2, j: self.j / 2 }, corner))
    }

    /// Its four parts, the corner of each being that of the whole with the same number.
    pub(crate) fn parts(self) -> [Self; 4] {
        let level = self.level + 1;
        [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(a, b)| Self { level, i: 2 * self.i + a, j: 2 * self.j + b })
    }
}

impl Pattern {
    /// That of a quad of a cage.
    pub(crate) fn of_quad(cage: &Cage, face: usize) -> Self {
        let mut pattern = Self::default();
        let halves = cage.topology().face_corners(face);
        for ((half, corner), edge) in halves.zip(&mut pattern.corners).zip(&mut pattern.edges) {
            *corner = Corner::new(cage, half as u32);
            *edge = levels(cage.sharpness(cage.topology().edge_of(half as u32) as usize));
        }
        pattern.by_intervals(cage, || regular::net(cage, face).is_some())
    }

    /// With what knot intervals do to it. A face with an extraordinary corner has no piece on its first level anyway.
    fn by_intervals(mut self, cage: &Cage, is_piece: impl Fn() -> bool) -> Self {
        if cage.has_intervals() {
            self.reach = Reach::Two;
            let has_piece = self.corners.iter().any(|c| c.extraordinary) || self.steps() > 0 || is_piece();
            self.before = u8::from(!has_piece);
        }
        self
    }

    /// That of the part of a face, not a quad, at one of its corners, after a refinement.
    pub(crate) fn of_part(cage: &Cage, half: u32) -> Self {
        let topology = cage.topology();
        let edge = |h: u32| levels(cage.sharpness(topology.edge_of(h) as usize)).saturating_sub(1);
        let (next, before) = (edge(half), edge(topology.previous(half)));
        let own = Corner::new(cage, half);
        let own = Corner { steps: own.steps.saturating_sub(1), ..own };
        let on_edge = |steps: u8| Corner { steps, extraordinary: false };
        let middle = Corner { steps: 0, extraordinary: true };
        let corners = [own, on_edge(next), middle, on_edge(before)];
        Self { corners, edges: [next, 0, 0, before], ..Self::default() }.by_intervals(cage, || false)
    }

    /// Whether the surface is bicubic on a quadrant.
    pub(crate) fn is_regular(&self, quadrant: Quadrant) -> bool {
        let Quadrant { level, i, j } = quadrant;
        let last = 1u64 << level.min(60);
        if level < u32::from(self.before) {
            return false;
        }
        // The places of the level on it, and those round it where they count, too.
        let more = u64::from(self.reach == Reach::Two);
        let places = |i: u64| i.saturating_sub(more)..=(i + 1 + more).min(last);
        places(i).flat_map(|a| places(j).map(move |b| (a, b))).all(|(a, b)| {
            let corner = match (a == 0, a == last, b == 0, b == last) {
                (true, _, true, _) => self.corners[0],
                (_, true, true, _) => self.corners[1],
                (_, true, _, true) => self.corners[2],
                (true, _, _, true) => self.corners[3],
                (_, _, true, _) => self.on(0),
                (_, true, _, _) => self.on(1),
                (_, _, _, true) => self.on(2),
                (true, _, _, _) => self.on(3),
                _ => Corner::default(),
            };
            !corner.extraordinary && level >= u32::from(corner.steps)
        })
    }

    fn on(&self, edge: usize) -> Corner {
        Corner { steps: self.edges[edge], extraordinary: false }
    }

    /// The levels until only extraordinary vertices are left.
    pub(crate) fn steps(&self) -> u32 {
        let corners = self.corners.iter().map(|c| c.steps);
        u32::from(corners.chain(self.edges).chain([self.before]).max().unwrap_or(0))
    }

    /// The largest quadrants that are bicubic, down to `depth` levels below those that are sharp, and those of the last level that are
    /// not. The parts of one follow each other, so that the way to the next is short.
    pub(crate) fn quadrants(&self, depth: u32) -> (Vec<Quadrant>, Vec<Quadrant>) {
        let last = self.steps() + depth;
        let (mut all, mut left, mut rest) = (Vec::new(), Vec::new(), vec![Quadrant::WHOLE]);
        while let Some(quadrant) = rest.pop() {
            if self.is_regular(quadrant) {
                all.push(quadrant);
            } else if quadrant.level < last {
                rest.extend(quadrant.parts().into_iter().rev());
            } else if quadrant.parts().into_iter().all(|part| self.is_regular(part)) {
                // Beside an extraordinary corner with knot intervals.
                all.extend(quadrant.parts());
            } else {
                left.push(quadrant);
            }
        }
        (all, left)
    }
}

impl Corner {
    /// What the vertex of a corner is, seen from its face. Cost: its valence.
    fn new(cage: &Cage, half: u32) -> Self {
        let topology = cage.topology();
        let vertex = topology.origin(half) as usize;
        let own = cage.vertex_sharpness(vertex);
        let (mut steps, mut lasting) = (levels(own), 0);
        for edge in topology.vertex_edges(vertex) {
            let sharpness = cage.sharpness(edge as usize);
            lasting += usize::from(sharpness >= INFINITELY_SHARP);
            steps = steps.max(levels(sharpness));
        }
        let quad = |h: u32| topology.face_corners(topology.face_of(h) as usize).len() == 4;
        let mut faces = 0;
        for h in topology.around(vertex) {
            faces += 1;
            if !quad(h) {
                steps = steps.max(1);
            }
        }
        let is_corner = own >= INFINITELY_SHARP || lasting > 2;
        let sharp = |h: u32| cage.sharpness(topology.edge_of(h) as usize) >= INFINITELY_SHARP;
        let (on_right, on_left) = (sharp(half), sharp(topology.previous(half)));
        let extraordinary = match (lasting, is_corner) {
            (0, false) => faces != 4,
            (2, false) if on_right && !on_left => {
                let left = topology.twin(topology.previous(half));
                !sharp(topology.previous(left))
            }
            (2, false) if on_left && !on_right => !sharp(topology.next(topology.twin(half))),
            (_, true) => !(on_right && on_left),
            _ => true,
        };
        Self { steps, extraordinary }
    }
}

/// The number of refinements until a finite sharpness is gone.
fn levels(sharpness: f64) -> u8 {
    if sharpness >= INFINITELY_SHARP { 0 } else { sharpness.max(0.0).ceil() as u8 }
}
