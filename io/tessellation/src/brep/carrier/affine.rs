//! Surfaces that are affine in their parameters: the nearest place in closed form.

use loftsman_kernel::Vector;

use crate::normals::normal;
use crate::patch::{Patch, project};

/// A plane `origin + u a + v b`, over a domain. Feet are found by a division each.
#[derive(Debug)]
pub(super) struct Affine {
    origin: Vector,
    along: [Vector; 2],
    /// The vectors that have the product 1 with one of these and 0 with the other.
    dual: [Vector; 2],
    /// The unit normal.
    pub(super) normal: Vector,
    low: [f64; 2],
    high: [f64; 2],
}

impl Affine {
    /// Of a single patch of degree 1 in both directions that is a parallelogram, to rounding.
    pub(super) fn of(patches: &[Patch], breaks: &[Vec<f64>; 2]) -> Option<Self> {
        let [patch] = patches else { return None };
        let (false, 2, 2) = (patch.rational, patch.rows, patch.columns) else { return None };
        let [a, b, c, d] = [0, 1, 2, 3].map(|k: usize| project(&patch.net[k]));
        let low = [breaks[0][0], breaks[1][0]];
        let high = [breaks[0][1], breaks[1][1]];
        let along = [(c - a) / (high[0] - low[0]), (b - a) / (high[1] - low[1])];
        let [uu, uv, vv] = [along[0].norm_squared(), along[0].dot(&along[1]), along[1].norm_squared()];
        let area = uu * vv - uv * uv;
        let size = (c - a).norm().max((b - a).norm());
        // Slanted directions and long strips would lose digits: those are searched for as on any surface.
        if (d - c - (b - a)).norm() > 1e-14 * size || area.is_nan() || area <= 1e-2 * uu * vv {
            return None;
        }
        let dual = [(along[0] * vv - along[1] * uv) / area, (along[1] * uu - along[0] * uv) / area];
        let normal = normal(patch, [0.5; 2], &patch.jet([0.5; 2]));
        Some(Self { origin: a, along, dual, normal, low, high })
    }

    /// The nearest place, where it lies within the domain or is brought there by rounding alone, and its distance.
    pub(super) fn foot(&self, point: &Vector) -> Option<([f64; 2], f64)> {
        let off = point - self.origin;
        let mut at = [0.0; 2];
        for d in 0..2 {
            let (low, high) = (self.low[d], self.high[d]);
            let x = low + self.dual[d].dot(&off);
            at[d] = x.clamp(low, high);
            if (x - at[d]).abs() > 1e-12 * (high - low) || x.is_nan() {
                return None;
            }
        }
        let on = self.along[0] * (at[0] - self.low[0]) + self.along[1] * (at[1] - self.low[1]);
        Some((at, (off - on).norm()))
    }
}
