//! Whether a mesh is still the one that was written.

use loftsman_kernel::mesh::Mesh;

/// A number for the points and faces of a mesh, to the last bit (FNV-1a over 64 bits, Fowler, Noll and Vo 1991): another
/// one where somebody has moved a vertex.
pub(crate) fn fingerprint(mesh: &Mesh) -> u64 {
    let points = mesh.points().iter().flat_map(|p| [p.x, p.y, p.z]).map(f64::to_bits);
    let faces = mesh.faces().flat_map(|face| {
        std::iter::once(face.len() as u64).chain(face.iter().map(|&corner| u64::from(corner)))
    });
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for byte in points.chain(faces).flat_map(u64::to_le_bytes) {
        hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    }
    hash
}
