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
use wide::f64x4;

use crate::bezier::{halve, less, more, restrict};
use crate::patch::{Homogeneous, Patch};

/// The second derivatives of a patch over a box of it, and its least weight there. Kept from cell to cell: its room
/// is used again.
#[derive(Debug, Default)]
pub(crate) struct Form {
    uu: Net,
    uv: Net,
    vv: Net,
    /// Empty where all are one.
    weights: Net<1>,
    /// One over eight times the least weight.
    share: f64,
    /// The box.
    low: [f64; 2],
    high: [f64; 2],
    /// Whether the coefficients are in the order in which they are asked.
    arranged: bool,
}

impl Form {
    /// Takes the box from `low` to `high` of a patch.
    pub(crate) fn set(&mut self, patch: &Patch, low: [f64; 2], high: [f64; 2]) {
        let (p, q) = (patch.rows, patch.columns);
        self.uu.set(|out| patch.uu(out), p.saturating_sub(2), q, low, high);
        self.uv.set(|out| patch.uv(out), p.saturating_sub(1), q.saturating_sub(1), low, high);
        self.vv.set(|out| patch.vv(out), p, q.saturating_sub(2), low, high);
        let weights = patch.net.iter().take(if patch.rational { p * q } else { 0 });
        self.weights.set(|out| out.extend(weights.map(|h| [h[3]])), p, q, low, high);
        (self.low, self.high, self.arranged) = (low, high, false);
    }

    /// Whether this is the box that it has.
    pub(crate) fn is(&self, low: [f64; 2], high: [f64; 2]) -> bool {
        (self.low, self.high) == (low, high)
    }

    /// Becomes the lower half of its box in a direction; the other becomes the upper one.
    pub(crate) fn halve(&mut self, upper: &mut Self, direction: usize) {
        self.uu.halve(&mut upper.uu, direction);
        self.uv.halve(&mut upper.uv, direction);
        self.vv.halve(&mut upper.vv, direction);
        self.weights.halve(&mut upper.weights, direction);
        (upper.low, upper.high) = (self.low, self.high);
        let middle = 0.5 * (self.low[direction] + self.high[direction]);
        (self.high[direction], upper.low[direction]) = (middle, middle);
        (self.arranged, upper.arranged) = (false, false);
    }

    /// Brings the coefficients into the order in which they are asked, which nobody does of a cell that is cut because its
    /// edges are.
    pub(crate) fn arrange(&mut self) {
        if self.arranged {
            return;
        }
        self.arranged = true;
        [&mut self.uu, &mut self.uv, &mut self.vv].into_iter().for_each(Net::arrange);
        let least = self.weights.points.iter().map(|w| w[0]).reduce(less).unwrap_or(1.0);
        self.share = 1.0 / (8.0 * least);
    }

    /// What the second derivatives of `n·A - c W` can be, for the plane through `point` with this normal, of any length.
    #[inline]
    pub(crate) fn across(&self, normal: &Vector, point: &Vector) -> Ranges {
        self.ranges(normal.x, normal.y, normal.z, normal.dot(point), self.share_of(normal))
    }

    /// Of `n·A - c W`. Numbers one by one are handed over in registers; written as a vector and read as another they would
    /// have to be waited for.
    fn ranges(&self, x: f64, y: f64, z: f64, offset: f64, share: f64) -> Ranges {
        let plane = [x, y, z, offset].map(f64x4::splat);
        let [uu, uv, vv] = [&self.uu, &self.uv, &self.vv].map(|of| of.range(&plane));
        Ranges { uu, uv, vv, share }
    }

    /// The largest distance from the plane through `point` with this normal, of any length, along an edge of parameters: of
    /// an edge along one of the parameters the second derivatives by that one are all that matters.
    pub(crate) fn along(&self, normal: &Vector, point: &Vector, from: [f64; 2], to: [f64; 2]) -> f64 {
        let [u, v] = [to[0] - from[0], to[1] - from[1]];
        if u != 0.0 && v != 0.0 {
            return self.across(normal, point).along(from, to);
        }
        let (second, step) = ([&self.uu, &self.vv][usize::from(v != 0.0)], u + v);
        let most = second.largest(normal.x, normal.y, normal.z, normal.dot(point));
        most * (step * step) * self.share_of(normal)
    }

    /// One over eight times the least weight and a normal's length; zero where it has none.
    fn share_of(&self, normal: &Vector) -> f64 {
        let length = normal.norm();
        if length > 0.0 { self.share / length } else { 0.0 }
    }
}

/// The Bézier coefficients of a derivative over a box.
#[derive(Debug, Default)]
struct Net<const L: usize = 4> {
    rows: usize,
    columns: usize,
    points: Vec<[f64; L]>,
    /// The points four at a time, coordinate by coordinate; the last four are filled up with the last one.
    blocks: Vec<[f64x4; 4]>,
}

impl<const L: usize> Net<L> {
    fn set(
        &mut self,
        points: impl FnOnce(&mut Vec<[f64; L]>),
        rows: usize,
        columns: usize,
        low: [f64; 2],
        high: [f64; 2],
    ) {
        (self.rows, self.columns) = (rows, columns);
        self.points.clear();
        points(&mut self.points);
        if !self.points.is_empty() {
            restrict(&mut self.points, rows, columns, low, high);
        }
    }

    fn halve(&mut self, upper: &mut Self, direction: usize) {
        (upper.rows, upper.columns) = (self.rows, self.columns);
        upper.points.resize(self.points.len(), [0.0; L]);
        if !self.points.is_empty() {
            halve(&mut self.points, &mut upper.points, self.rows, self.columns, direction);
        }
    }
}

impl Net {
    fn arrange(&mut self) {
        let block =
            |[a, b, c, d]: &[Homogeneous; 4]| [0, 1, 2, 3].map(|l| f64x4::from([a[l], b[l], c[l], d[l]]));
        let (fours, rest) = self.points.as_chunks();
        self.blocks.resize(self.points.len().div_ceil(4), [f64x4::ZERO; 4]);
        self.blocks.iter_mut().zip(fours).for_each(|(out, four)| *out = block(four));
        if let ([.., out], Some(last)) = (&mut self.blocks[..], rest.last()) {
            let mut four = [*last; 4];
            four[..rest.len()].copy_from_slice(rest);
            *out = block(&four);
        }
    }

    /// The largest of what `n·A - c W` can be, whatever its sign.
    fn largest(&self, x: f64, y: f64, z: f64, offset: f64) -> f64 {
        let plane = [x, y, z, offset].map(f64x4::splat);
        let larger = |most: f64x4, block: &[f64x4; 4]| most.fast_max(values(&plane, block).abs());
        let [a, b, c, d] = self.blocks.iter().fold(f64x4::ZERO, larger).to_array();
        more(more(a, b), more(c, d))
    }

    /// Middle and half width of what `n·A - c W` can be.
    #[inline]
    fn range(&self, plane: &[f64x4; 4]) -> [f64; 2] {
        if self.blocks.is_empty() {
            return [0.0; 2];
        }
        let (mut low, mut high) = (f64x4::splat(f64::INFINITY), f64x4::splat(f64::NEG_INFINITY));
        for block in &self.blocks {
            let value = values(plane, block);
            // Coefficients are finite: comparisons will do, where `min` would have to look for a NaN.
            low = low.fast_min(value);
            high = high.fast_max(value);
        }
        let ([a, b, c, d], [e, f, g, h]) = (low.to_array(), high.to_array());
        let (low, high) = (less(less(a, b), less(c, d)), more(more(e, f), more(g, h)));
        [0.5 * (low + high), 0.5 * (high - low)]
    }
}

/// `n·A - c W` at four points.
fn values([x, y, z, offset]: &[f64x4; 4], [xs, ys, zs, ws]: &[f64x4; 4]) -> f64x4 {
    *x * *xs + *y * *ys + *z * *zs - *offset * *ws
}

/// Middles and half widths of the second derivatives of a function over a cell.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ranges {
    uu: [f64; 2],
    uv: [f64; 2],
    vv: [f64; 2],
    /// See [`Form::share_of`].
    share: f64,
}

impl Ranges {
    /// Of a function that is a distance: middle and half width of each second derivative.
    pub(crate) fn new(uu: [f64; 2], uv: [f64; 2], vv: [f64; 2]) -> Self {
        Self { uu, uv, vv, share: 0.125 }
    }

    /// The largest that each second derivative can be.
    pub(crate) fn largest(&self) -> [f64; 3] {
        [self.uu, self.uv, self.vv].map(|[middle, half]| middle.abs() + half)
    }

    /// How large the second derivatives are, about: the mixed one, which is none's own, in the middle.
    pub(crate) fn sizes(&self) -> [f64; 3] {
        [self.uu[0].abs() + self.uu[1], self.uv[0].abs(), self.vv[0].abs() + self.vv[1]]
    }

    /// The largest distance over a triangle, about: mostly what the middles say.
    pub(crate) fn about(&self, triangle: [[f64; 2]; 3]) -> f64 {
        let milder = |[middle, half]: [f64; 2]| [middle, 0.25 * half];
        Self { uu: milder(self.uu), uv: milder(self.uv), vv: milder(self.vv), ..*self }.triangle(triangle)
    }

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
        let span = |k: usize| more(more(x[k], y[k]), z[k]) - less(less(x[k], y[k]), z[k]);
        (largest(m) + self.width([span(0), span(1)])) * self.share
    }
}

/// `8 max |½ Σ_{i<j} λ_i λ_j m_ij|` over the triangle, `m_ij` given by the corner opposite.
///
/// On an edge the maximum is `m/8` in the middle. Inside, the only critical point has `λ_0 : λ_1 : λ_2` as
/// `a (b + c - a) : b (c + a - b) : c (a + b - c)`, their sum `D = 2 (ab + bc + ca) - a² - b² - c²`, and the value
/// `a b c / (2 D)`.
fn largest([a, b, c]: [f64; 3]) -> f64 {
    let edges = more(more(a.abs(), b.abs()), c.abs());
    let shares = [a * (b + c - a), b * (c + a - b), c * (a + b - c)];
    let sum: f64 = shares.iter().sum();
    if sum != 0.0 && shares.iter().all(|s| s * sum > 0.0) {
        more(edges, (4.0 * a * b * c / sum).abs())
    } else {
        edges
    }
}
