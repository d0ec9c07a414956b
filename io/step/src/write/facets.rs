//! Meshes: triangles by index, as AP242 has them.

use loftsman_kernel::mesh::{Mesh, triangulate};

use super::paint::Group;
use super::print::{Printer, list, real, references};

impl Printer {
    /// A mesh as a shell of triangulated faces, one for each group of its faces; these, and whether a polygon of very many corners was cut as a fan.
    pub(super) fn mesh(&mut self, mesh: &Mesh, name: &str, groups: &[Group]) -> (u64, Vec<u64>, bool) {
        let points = mesh.points();
        let (mut corners, mut fan) = (vec![Vec::new(); groups.len()], false);
        let mut group_of = vec![0; mesh.face_count()];
        for (number, group) in groups.iter().enumerate() {
            group.faces.iter().for_each(|&face| group_of[face] = number);
        }
        for (face, group) in mesh.faces().zip(group_of) {
            triangulate::face(points, face, &mut corners[group]);
            fan |= face.len() > triangulate::EARS;
        }
        let count = points.len();
        let rows = list(points.iter().map(|p| list(p.iter().map(|&c| real(c)))));
        let coordinates = self.put(&format!("COORDINATES_LIST('',{count},{rows})"));
        let mut faces = Vec::with_capacity(groups.len());
        for corners in corners {
            let triangles = corners
                .chunks_exact(3)
                .map(|three| list(three.iter().map(|&k| (k as usize + 1).to_string())));
            let triangles = list(triangles);
            // No normals and no indices of its own: corners are numbers in the list.
            faces
                .push(self.put(&format!("TRIANGULATED_FACE('',#{coordinates},{count},(),$,(),{triangles})")));
        }
        (self.put(&format!("TESSELLATED_SHELL({name},{},$)", references(&faces))), faces, fan)
    }
}
