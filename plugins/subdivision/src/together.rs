//! Vertices of a mesh in one place made one.

use loftsman_kernel::error::Result;
use loftsman_kernel::mesh::{Layer, Mesh};

/// The mesh with one vertex at each place, numbered in the order in which places come first, without its loose lines; files that keep normals and
/// texture coordinates by vertex have several where these differ. Such values are those of the corners of faces then; normals, which are those of what
/// was split, are left out. `O(n log n)`.
pub(crate) fn together(mesh: &Mesh) -> Result<Mesh> {
    let first = mesh.welded();
    let mut place = vec![0_u32; first.len()];
    let mut points = Vec::new();
    for (k, &own) in first.iter().enumerate() {
        if own as usize == k {
            place[k] = points.len() as u32;
            points.push(mesh.points()[k]);
        }
    }
    let corners = mesh.corners().iter().map(|&v| place[first[v as usize] as usize]).collect();
    let mut one = Mesh::from_parts(points, corners, mesh.starts().to_vec())?;
    one.uvs = of_corners(&mesh.uvs, mesh);
    one.more_uvs = mesh.more_uvs.iter().map(|layer| of_corners(layer, mesh)).collect();
    one.colors = of_corners(&mesh.colors, mesh);
    (one.materials, one.smoothing) = (mesh.materials.clone(), mesh.smoothing.clone());
    one.groups.clone_from(&mesh.groups);
    Ok(one)
}

/// What belongs to points, for the corners at them.
fn of_corners<T: Copy>(layer: &Layer<T>, mesh: &Mesh) -> Layer<T> {
    if layer.corners().is_some() || layer.is_empty() {
        return layer.clone();
    }
    Layer::per_corner(layer.values().to_vec(), mesh.corners().to_vec())
}
