//! What the corners of a cell say of it.

use loftsman_kernel::Vector;

use crate::bezier::{less, more};
use crate::tree::Vertex;
use crate::triangulation::normal_of;

/// The box of a cell's parameters.
pub(super) fn bounds(corners: &[&Vertex; 4]) -> [[f64; 2]; 2] {
    let bound = |k: usize, pick: fn(f64, f64) -> f64| {
        let [a, b, c, d] = corners.map(|corner| corner.at[k]);
        pick(pick(a, b), pick(c, d))
    };
    [[bound(0, less), bound(1, less)], [bound(0, more), bound(1, more)]]
}

/// A normal across both diagonals of a cell, of any length.
pub(super) fn crossing(corners: &[&Vertex; 4]) -> Vector {
    let (s, t) = (corners[2].point - corners[0].point, corners[3].point - corners[1].point);
    let cross = s.cross(&t);
    if cross.norm_squared() > 1e-18 * s.norm_squared() * t.norm_squared() {
        return cross;
    }
    normal_of([corners[0], corners[1], corners[2]])
}

/// The direction from a vertex to another.
pub(super) fn leg(from: &Vertex, to: &Vertex) -> Option<Vector> {
    (to.point - from.point).try_normalize(0.0)
}

/// The angle between unit vectors, right to rounding also where it is small (Kahan).
pub(super) fn angle(a: &Vector, b: &Vector) -> f64 {
    2.0 * (a - b).norm().atan2((a + b).norm())
}
