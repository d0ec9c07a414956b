//! Meshes without points that no face has.

use loftsman_kernel::error::Result;
use loftsman_kernel::mesh::{Layer, Mesh};

/// A mesh without loose lines, as refinement makes them, without the points that no face has: those inside of holes. What belongs to points goes
/// with them. Linear.
pub(crate) fn used(mesh: Mesh) -> Result<Mesh> {
    let mut place = vec![u32::MAX; mesh.points().len()];
    mesh.corners().iter().for_each(|&v| place[v as usize] = 0);
    let kept: Vec<usize> = (0..place.len()).filter(|&v| place[v] == 0).collect();
    if kept.len() == place.len() {
        return Ok(mesh);
    }
    (0..).zip(&kept).for_each(|(new, &v)| place[v] = new);
    let points = kept.iter().map(|&v| mesh.points()[v]).collect();
    let corners = mesh.corners().iter().map(|&v| place[v as usize]).collect();
    let mut less = Mesh::from_parts(points, corners, mesh.starts().to_vec())?;
    less.normals = of_kept(mesh.normals, &kept);
    less.tangents = of_kept(mesh.tangents, &kept);
    less.uvs = of_kept(mesh.uvs, &kept);
    less.more_uvs = mesh.more_uvs.into_iter().map(|layer| of_kept(layer, &kept)).collect();
    less.colors = of_kept(mesh.colors, &kept);
    (less.materials, less.smoothing, less.groups) = (mesh.materials, mesh.smoothing, mesh.groups);
    Ok(less)
}

/// What belongs to corners stays as it is; what belongs to points, for those that are kept.
fn of_kept<T: Copy>(layer: Layer<T>, kept: &[usize]) -> Layer<T> {
    if layer.corners().is_some() || layer.is_empty() {
        return layer;
    }
    Layer::per_point(kept.iter().filter_map(|&v| layer.values().get(v).copied()).collect())
}
