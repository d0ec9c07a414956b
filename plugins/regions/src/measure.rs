//! Areas and volumes of meshes.

use loftsman_kernel::Vector;
use loftsman_kernel::mesh::Mesh;

/// Fans of triangles about each face's first corner, relative to the mesh's first point: sizes far from the origin
/// then cancel nothing.
fn triangles(mesh: &Mesh) -> impl Iterator<Item = [Vector; 3]> + '_ {
    let origin = mesh.points().first().copied().unwrap_or_default();
    let at = move |i: u32| mesh.points()[i as usize] - origin;
    mesh.faces().flat_map(move |face| {
        let first = at(face[0]);
        face[1..].windows(2).map(move |pair| [first, at(pair[0]), at(pair[1])])
    })
}

/// The area of a mesh's faces, `Σ ½|(b - a) × (c - a)|`; faces of more than three corners as fans.
pub fn area(mesh: &Mesh) -> f64 {
    triangles(mesh).map(|[a, b, c]| (b - a).cross(&(c - a)).norm() / 2.0).sum()
}

/// The volume that a closed mesh bounds, `Σ a·(b × c)/6`: positive where faces run counterclockwise seen from
/// outside.
pub fn volume(mesh: &Mesh) -> f64 {
    triangles(mesh).map(|[a, b, c]| a.dot(&b.cross(&c))).sum::<f64>() / 6.0
}
