//! How much of a cell counts as the shape, where loops bound it.

use smallvec::SmallVec;

use super::{Cell, Location};
use crate::quadrature::gauss_legendre;

/// Points along a curved border at most; more parts are what is finer then.
const MOST: usize = 32;

/// How much of a [`Cell`] counts as the shape.
#[derive(Debug, Clone, PartialEq)]
pub enum Share {
    /// All of it.
    Whole,
    /// None of it.
    Nothing,
    /// What loops leave of it.
    Part(CellPart),
}

/// The part of a cell's box that loops bound, ready to be integrated over: by Green's theorem
/// `∬ f du dv = ∮ A dv` with `A(u, v) = ∫ f ds` from the lower side of the box to `u`, so that its points lie on lines along `u` that end on
/// the border.
#[derive(Debug, Clone, PartialEq)]
pub struct CellPart {
    low: [f64; 2],
    high: [f64; 2],
    /// Intervals of `v` over which all of `u` counts, and how often.
    boxes: Vec<(f64, f64, f64)>,
    /// Pieces of border within the box, with the part to their left: their Bézier points `(u w, v w, w)`.
    borders: Vec<Vec<[f64; 3]>>,
}

impl CellPart {
    pub(crate) fn new(
        low: [f64; 2],
        high: [f64; 2],
        boxes: Vec<(f64, f64, f64)>,
        borders: Vec<Vec<[f64; 3]>>,
    ) -> Self {
        Self { low, high, boxes, borders }
    }

    /// The pieces of border within the cell, with the part to their left: their Bézier points `(u w, v w, w)`.
    pub fn borders(&self) -> &[Vec<[f64; 3]>] {
        &self.borders
    }

    /// Whether [`gauss_points`](Self::gauss_points) with these counts are exact for polynomials.
    pub fn is_exact(&self, counts: [usize; 2]) -> bool {
        self.borders.iter().all(|net| {
            let degree = net.len().saturating_sub(1);
            let count = counts[0] + counts[1];
            net.iter().all(|p| p[2] == net[0][2]) && (degree <= 1 || degree * count <= MOST)
        })
    }

    /// Gauss–Legendre points with their weights, some of which are negative: exact for polynomials of degree `2 counts - 1` in `u` and in `v` where
    /// the border is polynomial, too (up to degree 3, or 32 points along a piece); spectral for other borders. All is cut in so many
    /// parts along `u` and along the border. `O(counts²)` for each piece of border.
    pub fn gauss_points(&self, counts: [usize; 2], parts: usize) -> Vec<([f64; 2], f64)> {
        let [nu, nv] = counts.map(|count| count.max(1));
        let parts = parts.max(1);
        let across = gauss_legendre(nu);
        let mut all = Vec::new();
        let mut line = |end: f64, v: f64, weight: f64| {
            let end = end.clamp(self.low[0], self.high[0]);
            let step = (end - self.low[0]) / parts as f64;
            for part in 0..parts {
                for (x, w) in across.0.iter().zip(&across.1) {
                    let u = self.low[0] + step * (part as f64 + x);
                    all.push(([u, v.clamp(self.low[1], self.high[1])], weight * w * step));
                }
            }
        };
        let along = gauss_legendre(nv);
        for &(from, to, times) in &self.boxes {
            let step = (to - from) / parts as f64;
            for part in 0..parts {
                for (y, w) in along.0.iter().zip(&along.1) {
                    line(self.high[0], from + step * (part as f64 + y), times * w * step);
                }
            }
        }
        for net in &self.borders {
            let degree = net.len().saturating_sub(1).max(1);
            let exact = degree * (nu + nv);
            let rational = net.iter().any(|p| p[2] != net[0][2]);
            let count = if rational { (nu + nv + 2 * degree).max(exact) } else { exact };
            let (nodes, weights) = gauss_legendre(count.min(MOST.max(nu + nv)));
            let step = 1.0 / parts as f64;
            for part in 0..parts {
                for (x, w) in nodes.iter().zip(&weights) {
                    let ([u, v], slope) = place(net, step * (part as f64 + x));
                    line(u, v, w * step * slope[1]);
                }
            }
        }
        all
    }
}

/// A point of a rational Bézier curve and its derivative.
pub(crate) fn place(net: &[[f64; 3]], t: f64) -> ([f64; 2], [f64; 2]) {
    let mut points: SmallVec<[[f64; 3]; 8]> = SmallVec::from_slice(net);
    let degree = net.len() - 1;
    let mix = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|k: usize| a[k] + (b[k] - a[k]) * t);
    for k in (1..degree).rev() {
        for i in 0..=k {
            points[i] = mix(points[i], points[i + 1]);
        }
    }
    if degree == 0 {
        return ([net[0][0] / net[0][2], net[0][1] / net[0][2]], [0.0; 2]);
    }
    let slope = [0, 1, 2].map(|k: usize| degree as f64 * (points[1][k] - points[0][k]));
    let h = mix(points[0], points[1]);
    let at = [h[0] / h[2], h[1] / h[2]];
    (at, [0, 1].map(|d: usize| (slope[d] - at[d] * slope[2]) / h[2]))
}

impl Share {
    /// Gauss–Legendre points of what counts of a cell: as [`CellPart::gauss_points`], or, of all of it,
    /// [`Cell::gauss_points`] of so many parts in each direction.
    pub fn gauss_points(&self, cell: &Cell, counts: [usize; 2], parts: usize) -> Vec<(Location, f64)> {
        match self {
            Self::Nothing => Vec::new(),
            Self::Part(part) => {
                let place = |[u, v]: [f64; 2]| {
                    cell.face.map_or(Location::Surface(u, v), |face| Location::Face(face, u, v))
                };
                part.gauss_points(counts, parts).into_iter().map(|(at, w)| (place(at), w)).collect()
            }
            Self::Whole => {
                let parts = parts.max(1);
                let mut points = Vec::new();
                let others = if cell.sides.len() > 1 { parts } else { 1 };
                for (i, j) in (0..parts).flat_map(|i| (0..others).map(move |j| (i, j))) {
                    let mut piece = cell.clone();
                    for (side, k) in piece.sides.iter_mut().zip([i, j]) {
                        let step = (side.end - side.start) / parts as f64;
                        side.start += step * k as f64;
                        side.end = side.start + step;
                    }
                    points.extend(piece.gauss_points(counts));
                }
                points
            }
        }
    }
}
