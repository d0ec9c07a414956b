//! Meshes: points, faces, lines, and the layers that belong to points or corners.

use std::io;

use loftsman_kernel::mesh::{Layer, Mesh, NONE};

use super::layout::Layout;

/// Writes the fields of a mesh.
pub(super) fn write(mesh: &Mesh, out: &mut Layout<'_>) -> io::Result<()> {
    out.key("points")?;
    out.points(mesh.points())?;
    out.key("faces")?;
    out.faces(mesh.faces())?;
    if mesh.lines().next().is_some() {
        out.key("lines")?;
        out.faces(mesh.lines())?;
    }
    if is_there(&mesh.normals) {
        out.key("normals")?;
        layer(&mesh.normals, |n| [n.x, n.y, n.z], out)?;
    }
    if is_there(&mesh.tangents) {
        out.key("tangents")?;
        layer(&mesh.tangents, |&t| t, out)?;
    }
    if is_there(&mesh.uvs) {
        out.key("uvs")?;
        layer(&mesh.uvs, |&uv| uv, out)?;
    }
    if !mesh.more_uvs.is_empty() {
        out.key("more_uvs")?;
        out.open_list()?;
        for uvs in &mesh.more_uvs {
            out.entry()?;
            layer(uvs, |&uv| uv, out)?;
        }
        out.close_list()?;
    }
    if is_there(&mesh.colors) {
        out.key("colors")?;
        layer(&mesh.colors, |&color| color, out)?;
    }
    for (key, numbers) in [("materials", &mesh.materials), ("smoothing", &mesh.smoothing)] {
        if !numbers.is_empty() {
            out.key(key)?;
            out.indices(numbers.iter().map(|&n| Some(n)))?;
        }
    }
    if !mesh.groups.is_empty() {
        out.key("groups")?;
        out.open_list()?;
        for group in &mesh.groups {
            out.entry()?;
            out.open_table()?;
            out.key("name")?;
            out.text(&group.name)?;
            out.key("faces")?;
            out.indices(group.faces.iter().map(|&f| Some(f)))?;
            out.close_table()?;
        }
        out.close_list()?;
    }
    Ok(())
}

/// Whether a layer says anything, were it only that no corner has a value.
fn is_there<T>(layer: &Layer<T>) -> bool {
    !layer.is_empty() || layer.corners().is_some()
}

/// A list of values a point, or a table of values and the index of each corner's.
fn layer<T, const N: usize>(
    layer: &Layer<T>,
    row: impl Fn(&T) -> [f64; N],
    out: &mut Layout<'_>,
) -> io::Result<()> {
    let Some(corners) = layer.corners() else { return out.rows(layer.values().iter().map(row)) };
    out.open_table()?;
    out.key("values")?;
    out.rows(layer.values().iter().map(row))?;
    out.key("corners")?;
    out.indices(corners.iter().map(|&c| (c != NONE).then_some(c)))?;
    out.close_table()
}
