//! Gram matrices of B-spline basis functions: `∫ N_i^(k) N_j^(k) du`, banded and exact.

use super::space::{MAX_ORDER, Space};
pub use crate::quadrature::{gauss_legendre, gauss_lobatto};
use crate::solve::Symmetric;

impl Space {
    /// The matrix `∫ N_i^(k) N_j^(k) du` over the domain, `k = order`, as its non-zero entries `(i, j, value)`,
    /// `i, j` vertices, each pair of places once or more (repeated ones add up). Exact: Gauss–Legendre quadrature
    /// with `p + 1 - k` points a span, for an integrand of degree `2(p - k)`. `O(n p²)`.
    pub fn gram(&self, order: usize) -> Vec<(usize, usize, f64)> {
        let p = self.degree();
        if order > p {
            return Vec::new();
        }
        let (nodes, weights) = gauss_legendre(p + 1 - order);
        let mut entries = Vec::with_capacity(self.len() * (p + 1) * (p + 2) / 2);
        let mut row = [0.0; MAX_ORDER];
        let mut block = [[0.0; MAX_ORDER]; MAX_ORDER];
        for span in self.spans() {
            let (a, b) = (self.flat()[span], self.flat()[span + 1]);
            block[..=p].iter_mut().for_each(|row| row[..=p].fill(0.0));
            for (x, w) in nodes.iter().zip(&weights) {
                self.basis_into(span, a + (b - a) * x, order, &mut row);
                for i in 0..=p {
                    for j in 0..=i {
                        block[i][j] += w * (b - a) * row[i] * row[j];
                    }
                }
            }
            for i in 0..=p {
                for j in 0..=i {
                    let (vi, vj) = (self.vertex(span - p + i), self.vertex(span - p + j));
                    // A function that meets itself around a short period counts from both sides.
                    let value = if vi == vj && i != j { 2.0 * block[i][j] } else { block[i][j] };
                    entries.push((vi, vj, value));
                }
            }
        }
        entries
    }
}

/// The smoothness matrix of one direction: see [`Shape::smoothness`](crate::shape::Shape::smoothness).
pub(super) fn smoothness(space: &Space, order: usize) -> Symmetric {
    let length = space.length();
    let scale = length.powi(2 * order as i32 - 1);
    let entries = space
        .gram(0)
        .into_iter()
        .map(|(i, j, v)| (i, j, v / length))
        .chain(space.gram(order).into_iter().map(|(i, j, v)| (i, j, v * scale)));
    Symmetric::from_entries(space.len(), entries)
}

/// The smoothness matrix of a tensor product: for `order` 1, `L_u²|S_u|² + L_v²|S_v|²`; for 2 the thin plate
/// `L_u⁴|S_uu|² + 2 L_u²L_v²|S_uv|² + L_v⁴|S_vv|²`; each over `L_u L_v` and with `|S|²` added.
pub(crate) fn smoothness_of_product(u: &Space, v: &Space, order: usize) -> Symmetric {
    let unit = |space: &Space, k: usize| {
        let scale = space.length().powi(2 * k as i32 - 1);
        Symmetric::from_entries(space.len(), space.gram(k).into_iter().map(|(i, j, x)| (i, j, x * scale)))
    };
    let (us, vs): (Vec<_>, Vec<_>) = (0..=order).map(|k| (unit(u, k), unit(v, k))).unzip();
    let mut entries = Vec::new();
    let mut add = |a: &Symmetric, b: &Symmetric, factor: f64| {
        let n = b.size();
        for i in 0..a.size() {
            for (j, x) in a.row(i) {
                for k in 0..n {
                    for (l, y) in b.row(k) {
                        let (row, column) = (i * n + k, j * n + l);
                        if column <= row {
                            entries.push((row, column, factor * x * y));
                        }
                    }
                }
            }
        }
    };
    add(&us[0], &vs[0], 1.0);
    for k in 0..=order {
        let factor = super::binomial(order, k);
        add(&us[order - k], &vs[k], factor);
    }
    Symmetric::from_entries(u.len() * v.len(), entries)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_is_exact_to_degree_2n_minus_1() {
        for n in 1..=26 {
            let (x, w) = gauss_legendre(n);
            for degree in 0..2 * n {
                let sum: f64 = x.iter().zip(&w).map(|(x, w)| w * x.powi(degree as i32)).sum();
                assert!((sum * (degree + 1) as f64 - 1.0).abs() < 1e-13, "{n} points, degree {degree}");
            }
        }
    }

    #[test]
    fn uniform_cubic_mass_row_is_the_theory_s() {
        let space = Space::periodic_uniform(3, 12).unwrap();
        let mass = Symmetric::from_entries(12, space.gram(0));
        for (j, expected) in [151.0 / 315.0, 397.0 / 1680.0, 1.0 / 42.0, 1.0 / 5040.0].into_iter().enumerate()
        {
            assert!((mass.entry(5, 5 + j) - expected).abs() < 1e-15);
        }
    }
}
