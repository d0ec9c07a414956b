//! Cages that look like others and are none: edges without length, faces without area.

use loftsman_kernel::Vector;

use super::Cage;
use crate::error::{Result, SubdivisionError};

/// A face whose vertices are no further from a line than this part of its length has no area.
const LINE: f64 = 1e-14;

impl Cage {
    /// Refuses edges both of whose ends are in one place, and faces all of whose vertices are on one line: what is refined from them is
    /// defined, and hardly what is meant. Cost: linear.
    ///
    /// # Errors
    /// The first such edge, else the first such face.
    pub fn check_shape(&self) -> Result<()> {
        for edge in 0..self.topology.edge_count() {
            let [from, to] = self.topology.ends(edge).map(|v| v as usize);
            if self.points[from] == self.points[to] {
                let problem = "has no length, for both are in one place: merge the two vertices in the faces there, or move one".to_owned();
                return Err(SubdivisionError::Edge { from, to, problem });
            }
        }
        for face in 0..self.topology.face_count() {
            if self.is_flat(face) {
                let [first, second] = [0, 1].map(|k| self.topology.face(face)[k]);
                let problem = format!(
                    "has no area, for all its vertices ({first}, {second}, …) are on one line: take it out of the mesh, or move one of them"
                );
                return Err(SubdivisionError::Face { face, problem });
            }
        }
        Ok(())
    }

    /// Whether all vertices of a face are on one line.
    fn is_flat(&self, face: usize) -> bool {
        let vertices = self.topology.face(face);
        let first = self.points[vertices[0] as usize];
        let arms = || vertices[1..].iter().map(|&v| self.points[v as usize] - first);
        let size = arms().fold(0.0_f64, |most, arm| most.max(arm.amax()));
        // In units of the face, so that no square vanishes or overflows.
        let longest = arms().fold(Vector::zeros(), |best, arm| {
            let arm = arm / size;
            if arm.norm_squared() > best.norm_squared() { arm } else { best }
        });
        size.is_finite() && arms().all(|arm| (arm / size).cross(&longest).norm() <= LINE)
    }
}
