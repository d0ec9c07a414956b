//! What of a surface follows from its topology alone: its faces, their cells, its edges, and what was refined.

use std::collections::BTreeMap;
use std::sync::Mutex;

use super::leaf::Last;
use super::pattern::{Pattern, Quadrant};
use super::template::Templates;
use crate::cage::Cage;
use crate::error::{Result, SubdivisionError};
use crate::natural::{Natural, Naturals};
use crate::topology::NONE;

/// Faces that are kept: a few side by side, and those of several threads.
const LAST: usize = 16;

/// Faces of the surface, cells and edges of all.
#[derive(Debug)]
pub(super) struct Layout {
    /// The face of the cage of each face of the surface, and of the part of one that is no quad its corner, else [`NONE`].
    pub(super) faces: Vec<[u32; 2]>,
    /// The first face of the surface of each face of the cage; [`NONE`] for a hole.
    pub(super) first: Vec<u32>,
    /// The number of each face's pattern among those that there are.
    pub(super) pattern_of: Vec<u32>,
    pub(super) patterns: Vec<Pattern>,
    /// The cells of a face of each pattern.
    pub(super) quadrants: Vec<Vec<Quadrant>>,
    /// What these leave out.
    pub(super) left: Vec<Vec<Quadrant>>,
    /// The first cell of each face, and the number of all.
    pub(super) cells: Vec<usize>,
    /// Face and side of each edge of the boundary.
    pub(super) edges: Vec<(u32, u8)>,
    /// What faces with the same surroundings have in common.
    pub(super) templates: Templates,
    /// The coordinates in which the surface is smooth at extraordinary vertices.
    pub(super) naturals: Naturals,
    /// The faces that were asked for last, each in the place of its number.
    last: [Mutex<Option<Last>>; LAST],
}

impl Layout {
    /// Cost: linear; a face costs its corners' valences.
    pub(super) fn new(cage: &Cage, depth: u32) -> Result<Self> {
        let topology = cage.topology();
        let (mut faces, mut first) = (Vec::new(), Vec::with_capacity(topology.face_count()));
        let (mut patterns, mut pattern_of) = (Vec::new(), Vec::new());
        let mut known: BTreeMap<Pattern, u32> = BTreeMap::new();
        let mut edges = Vec::new();
        let shown =
            |edge: u32| topology.edge_faces(edge as usize).filter(|&f| !cage.is_hole(f as usize)).count();
        for face in 0..topology.face_count() {
            if cage.is_hole(face) {
                first.push(NONE);
                continue;
            }
            first.push(faces.len() as u32);
            let halves = topology.face_corners(face);
            let own = faces.len() as u32;
            let quad = halves.len() == 4;
            for (corner, half) in halves.clone().enumerate() {
                if shown(topology.edge_of(half as u32)) == 1 {
                    if quad {
                        edges.push((own, corner as u8));
                    } else {
                        // The first half belongs to this corner's part, the other to the next one's.
                        edges.push((own + corner as u32, 0));
                        edges.push((own + ((corner + 1) % halves.len()) as u32, 3));
                    }
                }
                if quad && corner > 0 {
                    continue;
                }
                let pattern =
                    if quad { Pattern::of_quad(cage, face) } else { Pattern::of_part(cage, half as u32) };
                pattern_of.push(*known.entry(pattern).or_insert_with(|| {
                    patterns.push(pattern);
                    patterns.len() as u32 - 1
                }));
                faces.push([face as u32, if quad { NONE } else { corner as u32 }]);
            }
        }
        if faces.is_empty() {
            let problem = "is a hole, as are all others: leave one to be shown".to_owned();
            return Err(SubdivisionError::Face { face: 0, problem });
        }
        let (quadrants, left): (Vec<Vec<Quadrant>>, Vec<Vec<Quadrant>>) =
            patterns.iter().map(|p| p.quadrants(depth)).unzip();
        let mut cells = vec![0];
        let mut count = 0;
        for &pattern in &pattern_of {
            count += quadrants[pattern as usize].len();
            cells.push(count);
        }
        let (templates, last) = (Templates::default(), std::array::from_fn(|_| Mutex::new(None)));
        let naturals = Naturals::new(Natural::catmull_clark);
        Ok(Self {
            faces,
            first,
            pattern_of,
            patterns,
            quadrants,
            left,
            cells,
            edges,
            templates,
            naturals,
            last,
        })
    }

    /// Where a face is kept that was asked for last, unless another has come to its place.
    pub(super) fn last(&self, face: usize) -> &Mutex<Option<Last>> {
        &self.last[face % LAST]
    }

    pub(super) fn pattern(&self, face: usize) -> &Pattern {
        &self.patterns[self.pattern_of[face] as usize]
    }
}
