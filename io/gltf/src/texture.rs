//! Texture coordinates: `v` points up here and down in glTF.

/// The offset of a texture's transform in the other convention.
///
/// With `v` down, `KHR_texture_transform` maps `(u, v)` to `(o₁ + s₁ cos r u + s₂ sin r v, o₂ - s₁ sin r u + s₂ cos r v)`.
/// Putting `1 - v` on both sides leaves scale and rotation as they are, turns the rotation counterclockwise, and
/// gives the offset `(o₁ + s₂ sin r, 1 - o₂ - s₂ cos r)`.
pub(crate) fn flipped(offset: [f64; 2], rotation: f64, tiling: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = rotation.sin_cos();
    [offset[0] + tiling[1] * sin, 1.0 - offset[1] - tiling[1] * cos]
}

/// The offset with `v` down, of one with `v` up.
pub(crate) fn flipped_back(offset: [f64; 2], rotation: f64, tiling: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = rotation.sin_cos();
    [offset[0] - tiling[1] * sin, 1.0 - offset[1] - tiling[1] * cos]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transforms_mean_the_same_both_ways_up() {
        let (offset, rotation, tiling) = ([0.3, -0.2], 0.7_f64, [2.0, 3.0]);
        let (sin, cos) = rotation.sin_cos();
        let down = |[u, v]: [f64; 2]| {
            let (su, sv) = (tiling[0] * u, tiling[1] * v);
            [offset[0] + cos * su + sin * sv, offset[1] - sin * su + cos * sv]
        };
        let up_offset = flipped(offset, rotation, tiling);
        let up = |[u, v]: [f64; 2]| {
            let (su, sv) = (tiling[0] * u, tiling[1] * v);
            [up_offset[0] + cos * su - sin * sv, up_offset[1] + sin * su + cos * sv]
        };
        for uv in [[0.0, 0.0], [1.0, 0.0], [0.25, 0.75]] {
            let (a, b) = (down(uv), up([uv[0], 1.0 - uv[1]]));
            assert!((a[0] - b[0]).abs() < 1e-15 && (1.0 - a[1] - b[1]).abs() < 1e-15, "{a:?} {b:?}");
        }
        let back = flipped_back(up_offset, rotation, tiling);
        assert!((back[0] - offset[0]).abs() < 1e-15 && (back[1] - offset[1]).abs() < 1e-15);
        assert_eq!(flipped([0.0; 2], 0.0, [1.0; 2]), [0.0; 2]);
    }
}
