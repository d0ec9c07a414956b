//! The nearest thing to a solution where constraints conflict.

use super::assembly::Assembly;
use crate::solve::Dependency;

/// The right-hand side on the independent rows that misses all rows least (each scaled as it stands): least squares
/// over `[I; C]`, `C` the combinations of the dependent ones, by the normal equations of the few that are dependent:
/// `y = b + Cᵀ (I + C Cᵀ)⁻¹ (b_dep - C b)`.
pub(crate) fn soften(assembly: &Assembly, dependencies: &[Dependency], rhs: &[f64]) -> Vec<f64> {
    let sides = assembly.system.sides();
    let rows = assembly.system.rows();
    let norm = |row: usize| rows.norm(row).max(f64::MIN_POSITIVE);
    // In unit rows: c' = c · |other| / |row|, b' = b / |row|.
    let live: Vec<&Dependency> = dependencies.iter().filter(|d| !d.combination.is_empty()).collect();
    let m = live.len();
    let factor = |d: &Dependency, i: usize| d.combination[i].1 * norm(d.combination[i].0) / norm(d.row);
    let mut gram = vec![0.0; m * m];
    for (i, a) in live.iter().enumerate() {
        for (j, b) in live.iter().enumerate().take(i + 1) {
            let mut sum = f64::from(u8::from(i == j));
            for (x, &(row, _)) in a.combination.iter().enumerate() {
                if let Ok(y) = b.combination.binary_search_by_key(&row, |&(r, _)| r) {
                    sum += factor(a, x) * factor(b, y);
                }
            }
            gram[i * m + j] = sum;
        }
    }
    let mut softened = rhs.to_vec();
    let first = vec![0; m];
    let Ok(cholesky) = crate::solve::EnvelopeCholesky::factor(first, 0.0, |i, j| gram[i * m + j]) else {
        return softened;
    };
    let mut missing = vec![0.0; m * sides];
    for (i, d) in live.iter().enumerate() {
        for side in 0..sides {
            let implied: f64 = d.combination.iter().map(|&(row, c)| c * rhs[row * sides + side]).sum();
            missing[i * sides + side] = (rhs[d.row * sides + side] - implied) / norm(d.row);
        }
    }
    cholesky.solve(&mut missing, sides);
    for (i, d) in live.iter().enumerate() {
        for (x, &(row, _)) in d.combination.iter().enumerate() {
            for side in 0..sides {
                softened[row * sides + side] += factor(d, x) * missing[i * sides + side] * norm(row);
            }
        }
    }
    softened
}
