//! Gaussian elimination: rank, and which rows the others imply, by other means than reflections.

use super::rank::Dependency;
use super::system::System;

/// The independent rows of a system, ascending, and how the others are made of them. Rows are scaled to unit length; at each step
/// the row of which most is left comes next, its largest number the pivot, so that factors are at most the root of the number of
/// columns; and where no more is left of any than the system's [tolerance](System::tolerance), the others depend on those
/// before. `O(r c n)` for `c` rows of rank `r` over `n` columns, densely.
pub(super) fn reduce(system: &System) -> (Vec<usize>, Vec<Dependency>) {
    let (rows, n) = (system.rows(), system.rows().width());
    let count = rows.len();
    let norms: Vec<f64> = (0..count).map(|row| rows.norm(row)).collect();
    let mut a = vec![0.0; count * n];
    for (row, norm) in norms.iter().enumerate().filter(|(_, norm)| **norm > 0.0) {
        // Divide rather than multiply: the reciprocal of a subnormal overflows.
        rows.iter_row(row).for_each(|(column, value)| a[row * n + column] += value / norm);
    }
    // Factors of the rows before, in the order of pivots.
    let mut factors: Vec<Vec<f64>> = vec![Vec::new(); count];
    let mut order: Vec<usize> = (0..count).collect();
    let mut pivots = Vec::new();
    while pivots.len() < count.min(n) {
        let k = pivots.len();
        let numbers = |at: usize| &a[order[at] * n..(order[at] + 1) * n];
        let left = |at: usize| (at, numbers(at).iter().map(|v| v * v).sum::<f64>().sqrt());
        let more = |best: (usize, f64), own: (usize, f64)| if own.1 > best.1 { own } else { best };
        // The first of equals: of two that say the same the later one is implied.
        let (at, size) = (k..count).map(left).fold((k, 0.0), more);
        if size <= system.tolerance() {
            break;
        }
        let (column, _) = numbers(at).iter().map(|v| v.abs()).enumerate().fold((0, 0.0), more);
        order[k..=at].rotate_right(1);
        let pivot_row: Vec<f64> = a[order[k] * n..(order[k] + 1) * n].to_vec();
        for &row in &order[k + 1..] {
            let own = &mut a[row * n..(row + 1) * n];
            let factor = own[column] / pivot_row[column];
            if factor != 0.0 {
                own.iter_mut().zip(&pivot_row).for_each(|(a, p)| *a -= factor * p);
                own[column] = 0.0;
            }
            factors[row].push(factor);
        }
        pivots.push(size);
    }
    let rank = pivots.len();
    let implied = order[rank..].iter().map(|&row| {
        // row = Σ f_k · (what was left of row k) = Σ c_k · row k: the factors, back through those of the rows before.
        let mut c = factors[row].clone();
        for k in (0..rank).rev() {
            let own = c[k];
            let before = &factors[order[k]];
            c.iter_mut().zip(before).for_each(|(c, f)| *c -= own * f);
        }
        let most = c.iter().fold(1.0_f64, |most, c| most.max(c.abs()));
        let each = c.iter().zip(&pivots).enumerate();
        let mut combination: Vec<(usize, f64)> = each
            .filter(|(_, (c, pivot))| (*c * *pivot).abs() > System::FINE * most)
            .map(|(k, (c, _))| (order[k], c * (norms[row] / norms[order[k]])))
            .collect();
        combination.sort_by_key(|&(row, _)| row);
        Dependency { row, combination: if norms[row] > 0.0 { combination } else { Vec::new() } }
    });
    let mut dependencies: Vec<Dependency> = implied.collect();
    dependencies.sort_by_key(|dependency| dependency.row);
    let mut kept = order[..rank].to_vec();
    kept.sort_unstable();
    (kept, dependencies)
}
