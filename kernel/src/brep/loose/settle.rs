//! The end of an edit: what follows is brought along, what did not move is as it was.

use std::sync::Arc;

use super::super::{Brep, CurveForm, Edge, Face, SurfaceForm};
use super::{Follower, Motion};
use crate::Vector;
use crate::error::Result;

/// What did not move, as it was before it was made ready.
#[derive(Debug, Default)]
pub(in super::super) struct Rest {
    faces: Vec<(usize, Face)>,
    edges: Vec<(usize, Edge)>,
}

impl Brep {
    /// Brings edges and vertices to where the faces are that may move.
    pub(in super::super) fn follow(&mut self) {
        let Motion::Ready(loose) = &self.motion else { return };
        let loose = Arc::clone(loose);
        self.known = super::super::flaws::Known::default();
        for Follower { vertex, row } in &loose.followers {
            let mut way = Vector::zeros();
            for (from, c) in row.iter() {
                way += (self.net[from] - loose.base[from]) * c;
            }
            self.net[*vertex] = loose.base[*vertex] + way;
        }
    }

    /// Ends an edit; what there is to tell.
    pub(in super::super) fn settle(&mut self) -> Result<Vec<String>> {
        let Some(loose) = self.loose().map(Arc::clone) else { return Ok(Vec::new()) };
        self.follow();
        self.motion = Motion::None;
        self.known = super::super::flaws::Known::default();
        let moved: Vec<usize> = loose
            .faces
            .iter()
            .copied()
            .filter(|&face| self.range_of(face).any(|k| self.net[k] != loose.base[k]))
            .collect();
        let mut rest = Rest::default();
        for &face in &loose.faces {
            if moved.contains(&face) {
                self.faces[face].form = SurfaceForm::Spline;
            } else {
                rest.faces.extend(loose.original.faces.get(face).map(|own| (face, own.clone())));
            }
        }
        let mut edges = Vec::new();
        for &edge in &loose.edges {
            if self.range_of_edge(edge).any(|k| self.net[k] != loose.base[k]) {
                self.edges[edge].form = CurveForm::Spline;
                edges.push(edge);
            } else {
                rest.edges.extend(loose.original.edges.get(edge).map(|own| (edge, own.clone())));
            }
        }
        self.motion = Motion::Settled(Arc::new(rest));
        self.tell(&loose, &moved, &edges)
    }

    /// After an edit: the same Brep, of which faces and edges that might have moved and did not are what they were before it, to the last bit, without the
    /// knots that the edit put into them. It has other control vertices then. As it is where nothing was edited. `O(points)`.
    ///
    /// # Errors
    /// As for [`Brep::new`].
    pub fn without_spare_knots(&self) -> Result<Self> {
        let Motion::Settled(rest) = &self.motion else { return Ok(self.clone()) };
        let mut parts = self.parts();
        for (face, own) in &rest.faces {
            parts.faces[*face].clone_from(own);
        }
        for (edge, own) in &rest.edges {
            parts.edges[*edge].clone_from(own);
        }
        Self::new(parts)
    }
}
