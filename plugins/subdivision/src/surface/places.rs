//! Where on the surface the vertices of refined cages are.

use loftsman_kernel::shape::Location;

use super::SubdivisionSurface;
use crate::cage::Cage;
use crate::topology::{NONE, Topology};

/// Of each face of a cage, refined some times, its corners as parameters of a face of the surface; nothing for one that is no quad yet.
pub(super) struct Places {
    faces: Vec<Option<Part>>,
    /// The first face of the surface on each face that is no quad.
    first: Vec<u32>,
}

/// A part of a face of the surface.
#[derive(Clone, Copy)]
struct Part {
    face: u32,
    corners: [[f64; 2]; 4],
}

const WHOLE: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

impl Places {
    /// Those of the surface's own cage.
    pub(super) fn new(surface: &SubdivisionSurface) -> Self {
        let (topology, first) = (surface.cage.topology(), &surface.layout.first);
        let quad = |face: usize| topology.face_corners(face).len() == 4;
        let part = |face: usize| quad(face).then(|| Part { face: first[face], corners: WHOLE });
        Self { faces: (0..first.len()).map(part).collect(), first: first.clone() }
    }

    /// Those of the cage refined once more: child `k` of a face starts at its corner `k`, goes on to the middle of the edge that follows
    /// and to the face's middle.
    pub(super) fn refined(&self, before: &Topology) -> Self {
        let mut faces = Vec::with_capacity(before.corner_count());
        for (face, part) in self.faces.iter().enumerate() {
            for corner in 0..before.face_corners(face).len() {
                faces.push(Some(match part {
                    Some(part) => part.child(corner),
                    None => {
                        let own = self.first.get(face).filter(|&&first| first != NONE);
                        Part { face: own.map_or(NONE, |first| first + corner as u32), corners: WHOLE }
                    }
                }));
            }
        }
        Self { faces, first: Vec::new() }
    }

    /// The place of each vertex of the cage they are of, on the first face that is shown; the surface's first corner where there is none.
    pub(super) fn of_vertices(&self, cage: &Cage) -> Vec<Location> {
        let topology = cage.topology();
        let mut places = vec![Location::Face(0, 0.0, 0.0); topology.vertex_count()];
        for face in (0..topology.face_count()).rev().filter(|&face| !cage.is_hole(face)) {
            let Some(part) = self.faces[face] else { continue };
            for (&vertex, [u, v]) in topology.face(face).iter().zip(part.corners) {
                places[vertex as usize] = Location::Face(part.face, u, v);
            }
        }
        places
    }
}

impl Part {
    fn child(self, corner: usize) -> Self {
        let [[a, b], [c, d]] = [[corner, (corner + 1) % 4], [(corner + 2) % 4, (corner + 3) % 4]]
            .map(|pair| pair.map(|k| self.corners[k]));
        let mean = |points: &[[f64; 2]]| {
            let share = 1.0 / points.len() as f64;
            [0, 1].map(|k| points.iter().map(|p| p[k]).sum::<f64>() * share)
        };
        // a is the corner, b follows, d is before it.
        Self { face: self.face, corners: [a, mean(&[a, b]), mean(&[a, b, c, d]), mean(&[a, d])] }
    }
}
