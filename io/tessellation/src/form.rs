//! How far a triangle can be from its piece of a patch, certified from Bézier coefficients.
//!
//! Let a triangle join three points of a patch `S = A / W`, and let `n·x = c` be a plane through them. The function
//! `F = n·A - c W` is a polynomial that vanishes at the triangle's corners, and `F / W` is the signed distance of the
//! patch from the plane. So it is `F`'s error under linear interpolation by zero: with `λ` the barycentric
//! coordinates of a parameter `x`, and `d_ij` the steps between the corners' parameters,
//!
//! ```text
//! -F(x) = ½ Σ_i λ_i (v_i - x)ᵀ H_i (v_i - x),    Σ_i λ_i (v_i - x)(v_i - x)ᵀ = Σ_{i<j} λ_i λ_j d_ij d_ijᵀ
//! ```
//!
//! where each `H_i` is a mean of `F`'s second derivatives, whose entries lie between the least and the largest Bézier
//! coefficient over the cell. Their middles `M` make a quadratic form of which the maximum over the triangle is known
//! in closed form, signs and all: a saddle cut along an asymptote costs nothing. What the middles leave, half the
//! widths `R`, adds at most `(R_uu h² + 2 R_uv h k + R_vv k²) / 8` over a triangle whose box is `h × k` (the variance
//! of anything within `h` is at most `h²/4`). The widths shrink with the cell, so the bound tends to the exact error.

use loftsman_kernel::Vector;

use crate::bezier::restrict;
use crate::patch::{Homogeneous, Patch};

/// The second derivatives of a patch over a box of it, and its least weight there. Kept from cell to cell: its room
/// is used again.
#[derive(Debug, Default)]
pub(crate) struct Form {
    uu: Vec<Homogeneous>,
    uv: Vec<Homogeneous>,
    vv: Vec<Homogeneous>,
    weights: Vec<[f64; 1]>,
    least: f64,
}

impl Form {
    /// Takes the box from `low` to `high` of a patch.
    pub(crate) fn set(&mut self, patch: &Patch, low: [f64; 2], high: [f64; 2]) {
        let (p, q) = (patch.rows, patch.columns);
        let take = |out: &mut Vec<Homogeneous>, net: &[Homogeneous], rows: usize, columns: usize| {
            out.clear();
            out.extend_from_slice(net);
            if !out.is_empty() {
                restrict(out, rows, columns, low, high);
            }
        };
        take(&mut self.uu, &patch.uu, p.saturating_sub(2), q);
        take(&mut self.uv, &patch.uv, p.saturating_sub(1), q.saturating_sub(1));
        take(&mut self.vv, &patch.vv, p, q.saturating_sub(2));
        self.least = 1.0;
        if patch.rational {
            self.weights.clear();
            self.weights.extend(patch.net.iter().map(|h| [h[3]]));
            restrict(&mut self.weights, p, q, low, high);
            self.least = self.weights.iter().map(|w| w[0]).fold(f64::MAX, f64::min);
        }
    }

    /// What the second derivatives of `n·A - c W` can be, for the plane through `point` with this normal.
    pub(crate) fn across(&self, normal: &Vector, point: &Vector) -> Ranges {
        let offset = normal.dot(point);
        let range = |net: &[Homogeneous]| {
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for h in net {
                let value = normal.x * h[0] + normal.y * h[1] + normal.z * h[2] - offset * h[3];
                // Coefficients are finite: comparisons will do, where `min` would have to look for a NaN.
                low = if low < value { low } else { value };
                high = if high > value { high } else { value };
            }
            if net.is_empty() { [0.0; 2] } else { [0.5 * (low + high), 0.5 * (high - low)] }
        };
        Ranges {
            uu: range(&self.uu),
            uv: range(&self.uv),
            vv: range(&self.vv),
            share: 1.0 / (8.0 * self.least),
        }
    }
}

/// Middles and half widths of the second derivatives of a function over a cell.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ranges {
    uu: [f64; 2],
    uv: [f64; 2],
    vv: [f64; 2],
    /// One over eight times the least weight.
    share: f64,
}

impl Ranges {
    /// `dᵀ M d`.
    fn middle(&self, [u, v]: [f64; 2]) -> f64 {
        self.uu[0] * u * u + 2.0 * self.uv[0] * u * v + self.vv[0] * v * v
    }

    /// `R` over a box.
    fn width(&self, [u, v]: [f64; 2]) -> f64 {
        self.uu[1] * u * u + 2.0 * self.uv[1] * u * v + self.vv[1] * v * v
    }

    /// The largest distance along an edge of parameters.
    pub(crate) fn along(&self, from: [f64; 2], to: [f64; 2]) -> f64 {
        let d = [to[0] - from[0], to[1] - from[1]];
        (self.middle(d).abs() + self.width(d.map(f64::abs))) * self.share
    }

    /// The largest distance over a triangle of parameters.
    pub(crate) fn triangle(&self, [x, y, z]: [[f64; 2]; 3]) -> f64 {
        let step = |a: [f64; 2], b: [f64; 2]| [b[0] - a[0], b[1] - a[1]];
        let m = [self.middle(step(y, z)), self.middle(step(x, z)), self.middle(step(x, y))];
        let span = |k: usize| x[k].max(y[k]).max(z[k]) - x[k].min(y[k]).min(z[k]);
        (largest(m) + self.width([span(0), span(1)])) * self.share
    }
}

/// `8 max |½ Σ_{i<j} λ_i λ_j m_ij|` over the triangle, `m_ij` given by the corner opposite.
///
/// On an edge the maximum is `m/8` in the middle. Inside, the only critical point has `λ_0 : λ_1 : λ_2` as
/// `a (b + c - a) : b (c + a - b) : c (a + b - c)`, their sum `D = 2 (ab + bc + ca) - a² - b² - c²`, and the value
/// `a b c / (2 D)`.
fn largest([a, b, c]: [f64; 3]) -> f64 {
    let edges = a.abs().max(b.abs()).max(c.abs());
    let shares = [a * (b + c - a), b * (c + a - b), c * (a + b - c)];
    let sum: f64 = shares.iter().sum();
    if sum != 0.0 && shares.iter().all(|s| s * sum > 0.0) {
        edges.max((4.0 * a * b * c / sum).abs())
    } else {
        edges
    }
}
