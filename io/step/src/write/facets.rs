//! Meshes: triangles by index, as AP242 has them.

use loftsman_kernel::mesh::{Mesh, triangulate};

use super::print::{Printer, list, real};

impl Printer {
    /// A mesh as a shell of one triangulated face, and whether a polygon of very many corners was cut as a fan.
    pub(super) fn mesh(&mut self, mesh: &Mesh, name: &str) -> (u64, bool) {
        let points = mesh.points();
        let (mut corners, mut fan) = (Vec::new(), false);
        for face in mesh.faces() {
            triangulate::face(points, face, &mut corners);
            fan |= face.len() > triangulate::EARS;
        }
        let count = points.len();
        let rows = list(points.iter().map(|p| list(p.iter().map(|&c| real(c)))));
        let coordinates = self.put(&format!("COORDINATES_LIST('',{count},{rows})"));
        let triangles =
            corners.chunks_exact(3).map(|three| list(three.iter().map(|&k| (k as usize + 1).to_string())));
        let triangles = list(triangles);
        // No normals and no indices of its own: corners are numbers in the list.
        let face = self.put(&format!("TRIANGULATED_FACE('',#{coordinates},{count},(),$,(),{triangles})"));
        (self.put(&format!("TESSELLATED_SHELL({name},(#{face}),$)")), fan)
    }
}
