//! Vertices with more than one tangent plane: on a crease that is sharp for ever, and at corners of more faces than one.

use loftsman_kernel::error::{Error, Result};

use super::{SubdivisionSurface, refused};
use crate::catmull_clark::sectors;
use crate::topology::NONE;

/// Where the corners of a face are, in their order.
const CORNERS: [&str; 4] = ["[0, 0]", "[1, 0]", "[1, 1]", "[0, 1]"];

impl SubdivisionSurface {
    /// Refuses a vertex where tangents, and a normal, are those of one side only.
    ///
    /// # Errors
    /// Naming places that say which side.
    pub(super) fn check_one_sided(&self, vertex: usize) -> Result<()> {
        let sides = sectors(&self.cage, vertex).map_err(refused)?;
        if sides < 2 {
            return Ok(());
        }
        let topology = self.cage.topology();
        let places = topology.around(vertex).filter_map(|half| {
            let face = topology.face_of(half);
            // Of a hole nothing is asked.
            let first = Some(self.layout.first[face as usize]).filter(|first| *first != NONE)?;
            let corners = topology.face_corners(face as usize);
            let corner = half as usize - corners.start;
            let (own, uv) = match corners.len() {
                4 => (first, *CORNERS.get(corner)?),
                _ => (first + corner as u32, CORNERS[0]),
            };
            Some(format!("{{ face = {own}, uv = {uv} }}"))
        });
        let places: Vec<String> = places.take(4).collect();
        Err(Error::Invalid(format!(
            "vertex {vertex} has tangents and a normal of its own on each of {sides} sides, of what is sharp there for ever: say whose by a face, as {}",
            places.join(" or ")
        )))
    }
}
