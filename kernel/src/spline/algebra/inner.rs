//! Integrals and inner products of B-splines.

use super::bernstein::{Pieces, mixed, partition};
use crate::error::Result;
use crate::solve::SparseRows;
use crate::space::Space;

impl Space {
    /// `∫ N_i(u) du` over the domain for each B-spline; `(t_{i+p+1} - t_i) / (p + 1)` for one whose support is within it.
    /// `O(n p³)`.
    pub fn integrals(&self) -> Vec<f64> {
        let partition = self.breakpoints();
        let pieces = Pieces::new(self, &partition);
        let mut all = vec![0.0; self.len()];
        for (piece, ends) in partition.windows(2).enumerate() {
            let share = (ends[1] - ends[0]) / pieces.order() as f64;
            for (i, vertex) in pieces.vertices(piece).iter().enumerate() {
                all[*vertex as usize] += share * pieces.row(piece, i).iter().sum::<f64>();
            }
        }
        all
    }

    /// `∫ M_i(u) R_k(u) du` over the domain for the B-splines of this space (rows) and of another over the same domain
    /// (columns), exactly; of a space with itself its Gram matrix. `O(n (p+1)(q+1)(p+q+2))`.
    ///
    /// # Errors
    /// When the domains differ.
    pub fn inner_products(&self, other: &Self) -> Result<SparseRows> {
        let (p, q) = (self.degree(), other.degree());
        let partition = partition(self, other)?;
        let (first, second) = (Pieces::new(self, &partition), Pieces::new(other, &partition));
        let mixed = mixed(p, q);
        let mut rows: Vec<Vec<(usize, f64)>> = vec![Vec::new(); self.len()];
        for (piece, ends) in partition.windows(2).enumerate() {
            let share = (ends[1] - ends[0]) / (p + q + 1) as f64;
            for (i, row) in first.vertices(piece).iter().enumerate() {
                for (k, column) in second.vertices(piece).iter().enumerate() {
                    let (a, b) = (first.row(piece, i), second.row(piece, k));
                    let each = a.iter().enumerate().map(|(s, a)| {
                        a * b.iter().zip(&mixed[s * (q + 1)..]).map(|(b, c)| b * c).sum::<f64>()
                    });
                    rows[*row as usize].push((*column as usize, share * each.sum::<f64>()));
                }
            }
        }
        let mut all = SparseRows::with_capacity(other.len(), self.len(), self.len() * (p + q + 1));
        rows.into_iter().for_each(|row| all.push(row));
        Ok(all)
    }
}
