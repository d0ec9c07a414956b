//! Whether a mesh and the surface that it was made of are still those that were written.

use loftsman_kernel::Point;
use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::spline::trimmed::ParameterCurve;
use loftsman_kernel::spline::{Space, Surface, Trimmed};

/// A number for what it was fed, to the last bit (FNV-1a over 64 bits, Fowler, Noll and Vo 1991).
struct Hash(u64);

impl Hash {
    fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    fn feed(&mut self, value: u64) {
        for byte in value.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    fn numbers(&mut self, values: &[f64]) {
        values.iter().for_each(|value| self.feed(value.to_bits()));
    }

    fn space(&mut self, space: &Space) {
        self.feed(space.degree() as u64);
        self.feed(space.flat().len() as u64);
        self.numbers(space.flat());
    }

    fn vertex(&mut self, points: &[Point], weights: Option<&[f64]>, vertex: usize) {
        let Point { coords } = points[vertex];
        self.numbers(coords.as_slice());
        self.numbers(weights.map_or(&[], |weights| &weights[vertex..=vertex]));
    }

    /// Knots and control vertices as they stand in a file: unrolled where it is periodic.
    fn surface(&mut self, surface: &Surface) {
        let (u, v) = (surface.u(), surface.v());
        self.space(u);
        self.space(v);
        for j in 0..v.unrolled_len() {
            for i in 0..u.unrolled_len() {
                let vertex = u.vertex(i) * v.len() + v.vertex(j);
                self.vertex(surface.points(), surface.weights(), vertex);
            }
        }
    }

    fn chain(&mut self, chain: &[ParameterCurve]) {
        self.feed(chain.len() as u64);
        for part in chain {
            let (from, to) = part.range();
            self.numbers(&[from, to]);
            let curve = part.curve();
            self.space(curve.space());
            for k in 0..curve.space().unrolled_len() {
                self.vertex(curve.points(), curve.weights(), curve.space().vertex(k));
            }
        }
    }
}

/// That of the points and faces of a mesh: another one where somebody has moved a vertex.
pub(crate) fn mesh(mesh: &Mesh) -> u64 {
    let mut hash = Hash::new();
    mesh.points().iter().for_each(|p| hash.numbers(p.coords.as_slice()));
    for face in mesh.faces() {
        hash.feed(face.len() as u64);
        face.iter().for_each(|&corner| hash.feed(u64::from(corner)));
    }
    hash.0
}

/// That of a surface: another one where somebody has moved a control vertex or a knot.
pub(crate) fn surface(surface: &Surface) -> u64 {
    let mut hash = Hash::new();
    hash.surface(surface);
    hash.0
}

/// That of a trimmed surface by its loops, which bound the mesh, too: special curves and points do not.
pub(crate) fn trimmed(trimmed: &Trimmed) -> u64 {
    let mut hash = Hash::new();
    hash.surface(trimmed.surface());
    for region in trimmed.regions() {
        hash.chain(&region.outer);
        region.holes.iter().for_each(|hole| hash.chain(hole));
    }
    hash.0
}
