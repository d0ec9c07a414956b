//! Where on the surface the corners of refined faces are.

use crate::topology::NONE;

/// A part of a face of the surface, by the parameters of its corners.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    pub(crate) face: u32,
    pub(crate) corners: [[f64; 2]; 4],
}

const WHOLE: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

impl Place {
    /// All of a face.
    pub(crate) fn whole(face: u32) -> Self {
        Self { face, corners: WHOLE }
    }

    /// The part at a corner of what is itself such a part or, where there is none, a face of the cage that is no quad, on which the surface's
    /// faces are numbered from `first` on. It starts at the corner, goes on to the middle of the edge that follows and to the face's middle.
    pub(crate) fn child(part: Option<Self>, first: u32, corner: usize) -> Self {
        match part {
            Some(part) => part.quarter(corner),
            None if first == NONE => Self::whole(NONE),
            None => Self::whole(first + corner as u32),
        }
    }

    fn quarter(self, corner: usize) -> Self {
        let before = (corner + 3) % 4;
        let corners = [self.corners[corner], self.middle(corner), self.centre(), self.middle(before)];
        Self { face: self.face, corners }
    }

    /// The part at a corner, its corners numbered as those of the whole.
    pub(crate) fn part(self, corner: usize) -> Self {
        let mut part = self.quarter(corner);
        part.corners.rotate_right(corner);
        part
    }

    /// The middle of the edge that follows a corner.
    pub(crate) fn middle(&self, corner: usize) -> [f64; 2] {
        let [a, b] = [self.corners[corner], self.corners[(corner + 1) % 4]];
        [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]
    }

    pub(crate) fn centre(&self) -> [f64; 2] {
        let [a, _, c, _] = self.corners;
        [0.5 * (a[0] + c[0]), 0.5 * (a[1] + c[1])]
    }
}
