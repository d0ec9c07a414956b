//! Whether a solver is one: agreement with dense linear algebra, dependent rows, scales, multipliers, allocations.

use std::sync::Arc;

use nalgebra::DMatrix;

use super::{Lcg, Verdict};
use crate::solve::{Map, SolveError, Solver, SparseRows, Symmetric, System, SystemMetric, Through};

/// Checks a solver: the least adjustment to `1e-9` against a dense pseudo-inverse, for every metric, one and three
/// sides; ranks and dependencies of redundant and zero rows; rows scaled from 1e-9 to 1e9; rows that nearly depend on others, or
/// do by the hundred, with right-hand sides that agree and that contradict; multipliers. A solver may
/// refuse systems as too large or ill-conditioned, but not all of them. And its quadratic programs: small ones against all
/// sets of inequalities that could be active, large ones by the conditions of Karush, Kuhn and Tucker, contradictions named
/// with no row too many.
pub fn solver_conformance(solver: &dyn Solver) -> Verdict {
    solver_conformance_counting(solver, None)
}

/// The same with a counter of allocations (of this thread, since any start): solving must not raise it.
pub fn solver_conformance_counting(solver: &dyn Solver, allocations: Option<&dyn Fn() -> u64>) -> Verdict {
    let mut verdict = Verdict::default();
    let mut random = Lcg::new(1);
    let mut solved = 0;
    for round in 0..60 {
        let c = [1, 2, 3, 5, 8, 20][round % 6];
        let m = c + 3 + random.below(20);
        let sides = if round % 2 == 0 { 3 } else { 1 };
        let scale = [1.0, 1e-9, 1e9, 1e-3][round % 4];
        let (metric, half) = if round / 6 % 5 == 4 {
            through(m, &mut random)
        } else {
            let (metric, inverse) = metric(round / 6 % 5, m, &mut random);
            let half = inverse.cholesky().map_or_else(|| DMatrix::identity(m, m), |c| c.l());
            (metric, half)
        };
        let mut rows = SparseRows::new(m);
        for k in 0..c {
            // Stencils: runs of neighbours, some wrapped around, of very different sizes.
            let (first, size) = (random.below(m), scale * 10_f64.powi(2 * (k as i32 % 3) - 2));
            let run = 4.min(m);
            let terms: Vec<(usize, f64)> =
                (0..run).map(|j| ((first + j) % m, size * (random.next() + 1.5))).collect();
            rows.push(terms);
        }
        // Redundant rows: a copy, a multiple, a sum, and a row that nothing touches.
        let independent = c;
        if round % 5 == 4 {
            let copy: Vec<_> = rows.iter_row(0).map(|(j, v)| (j, v * -2.0)).collect();
            rows.push(copy);
            let sum: Vec<_> = rows.iter_row(0).chain(rows.iter_row(c - 1)).collect();
            rows.push(sum);
            rows.push([]);
        }
        solved += usize::from(one(
            &mut verdict,
            solver,
            rows,
            independent,
            sides,
            metric,
            &half,
            allocations,
            &mut random,
        ));
    }
    verdict.check(solved >= 10, || format!("only {solved} of 60 systems were solved, the others refused"));
    let empty = System::new(SparseRows::new(0), Vec::new(), 3, SystemMetric::Least);
    match solver.factor(&empty) {
        Ok(factored) => verdict.check(factored.rank() == 0, || "an empty system has a rank".into()),
        Err(error) => verdict.check(false, || format!("an empty system is refused: {error}")),
    }
    let bad = SystemMetric::Weights(Arc::new(vec![1.0, 0.0]));
    let mut rows = SparseRows::new(2);
    rows.push([(0, 1.0), (1, 1.0)]);
    let refused = solver.factor(&System::new(rows, vec![0, 1], 1, bad)).is_err();
    verdict.check(refused, || "a weight of zero is not refused".into());
    super::dependent::dependent(&mut verdict, solver);
    super::program::programs(&mut verdict, solver);
    verdict
}

#[allow(clippy::too_many_arguments, reason = "one case of the suite, spelled out")]
fn one(
    verdict: &mut Verdict,
    solver: &dyn Solver,
    rows: SparseRows,
    independent: usize,
    sides: usize,
    metric: SystemMetric,
    half: &DMatrix<f64>,
    allocations: Option<&dyn Fn() -> u64>,
    random: &mut Lcg,
) -> bool {
    let (c, m) = (rows.len(), rows.width());
    let f =
        DMatrix::from_fn(c, m, |i, j| rows.iter_row(i).filter(|(k, _)| *k == j).map(|(_, v)| v).sum::<f64>());
    let inverse = half * half.transpose();
    let system = System::new(rows, (0..m).collect(), sides, metric);
    let name = format!("{c} rows, {m} columns, {sides} sides");
    let mut factored = match solver.factor(&system) {
        Ok(factored) => factored,
        Err(SolveError::TooLarge { .. } | SolveError::IllConditioned { .. }) => return false,
        Err(error) => {
            verdict.check(false, || format!("{name}: {error}"));
            return false;
        }
    };
    // A right-hand side that a solution exists for.
    let wish = half * DMatrix::from_fn(half.ncols(), sides, |_, _| random.next());
    let b = &f * &wish;
    let rhs: Vec<f64> = (0..c * sides).map(|k| b[(k / sides, k % sides)]).collect();
    // Unit rows, so that the reference does not lose the small ones.
    let norm = |i: usize| f.row(i).norm().max(f64::MIN_POSITIVE);
    let unit = DMatrix::from_fn(c, m, |i, j| f[(i, j)] / norm(i));
    let unit_b = DMatrix::from_fn(c, sides, |i, s| b[(i, s)] / norm(i));
    let a = &unit * half;
    let values = a.clone().singular_values();
    let high = values.max();
    let rank = values.iter().filter(|s| **s > 1e-11 * high).count();
    let low = values.iter().copied().filter(|s| *s > 1e-11 * high).fold(high, f64::min);
    let condition = high / low;
    // The reference: QR of the independent rows, where those are the first ones.
    let expected = (rank == independent).then(|| {
        let qr = a.rows(0, independent).transpose().qr();
        let y = qr.r().transpose().solve_lower_triangular(&unit_b.rows(0, independent).into_owned());
        y.map(|y| half * (qr.q() * y))
    });
    let diagnosis = factored.diagnosis();
    verdict.check(rank <= independent && factored.rank() == rank && diagnosis.rank == rank, || {
        format!("{name}: rank {} (diagnosis {}), not {rank}", factored.rank(), diagnosis.rank)
    });
    verdict.check(diagnosis.dependencies.len() == c - rank, || {
        format!("{name}: {} dependencies reported, not {}", diagnosis.dependencies.len(), c - rank)
    });
    for dependency in &diagnosis.dependencies {
        let implied = dependency
            .combination
            .iter()
            .fold(f.row(dependency.row) * -1.0, |sum, &(row, factor)| sum + f.row(row) * factor);
        // What unknowns cannot tell apart need not be the same over the columns.
        let implied = if half.ncols() < m { implied * half } else { implied };
        let size: f64 =
            dependency.combination.iter().map(|&(row, factor)| f.row(row).norm() * factor.abs()).sum();
        verdict.check(implied.norm() <= 1e-9 * size.max(f.row(dependency.row).norm()), || {
            format!(
                "{name}: row {} is not what its dependency says, off by {:e}",
                dependency.row,
                implied.norm()
            )
        });
    }
    let mut d = vec![f64::NAN; m * sides];
    let mut multipliers = vec![f64::NAN; c * sides];
    let before = allocations.map(|count| count());
    factored.solve_into(&rhs, &mut d);
    if let (Some(count), Some(before)) = (allocations, before) {
        let made = count() - before;
        verdict.check(made == 0, || format!("{name}: an event allocated {made} times"));
    }
    factored.multipliers_into(&rhs, &mut multipliers);
    if let Some(expected) = expected.flatten() {
        let size = expected.amax().max(f64::MIN_POSITIVE);
        let worst =
            (0..m * sides).map(|k| (d[k] - expected[(k / sides, k % sides)]).abs()).fold(0.0, f64::max);
        verdict.check(worst <= 1e-12 * condition.max(1e3) * size && !worst.is_nan(), || {
            format!("{name}: off the least adjustment by {worst:e} of {size:e} (condition {condition:.1e})")
        });
    }
    let reached = |i: usize, s: usize| (0..m).map(|j| f[(i, j)] * d[j * sides + s]).sum::<f64>();
    let size = d.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    for i in 0..c {
        for s in 0..sides {
            let error = (reached(i, s) - b[(i, s)]).abs();
            verdict.check(error <= 1e-11 * norm(i) * size.max(1.0) * condition.max(1.0).sqrt(), || {
                format!("{name}: equation {i} is missed by {error:e}")
            });
        }
    }
    // d = W⁻¹ Fᵀ λ.
    for s in 0..sides {
        let lambda = nalgebra::DVector::from_fn(c, |i, _| multipliers[i * sides + s]);
        let implied = &inverse * f.transpose() * lambda;
        let worst = (0..m).map(|j| (implied[j] - d[j * sides + s]).abs()).fold(0.0, f64::max);
        verdict.check(worst <= 1e-11 * condition * condition.max(1e2) * size && !worst.is_nan(), || {
            format!("{name}: the multipliers miss the adjustment by {worst:e} of {size:e}")
        });
    }
    let mut again = vec![0.0; m * sides];
    factored.solve_into(&rhs, &mut again);
    verdict.check(again == d, || format!("{name}: solving again gives other numbers"));
    true
}

/// Fewer unknowns than columns, each of which moves some of these: `W⁻¹ = half halfᵀ`.
fn through(m: usize, random: &mut Lcg) -> (SystemMetric, DMatrix<f64>) {
    let unknowns = m - m / 8;
    let mut map = SparseRows::new(unknowns);
    for i in 0..m {
        let own = [(i % unknowns, 1.0 + random.next().abs()), ((i + 1) % unknowns, 0.5 * random.next())];
        map.push(own);
    }
    let (measure, inverse) = metric(2, unknowns, random);
    let dense = DMatrix::from_fn(m, unknowns, |i, j| {
        map.iter_row(i).filter(|(k, _)| *k == j).map(|(_, v)| v).sum::<f64>()
    });
    let half = inverse.cholesky().map_or_else(|| DMatrix::identity(unknowns, unknowns), |c| c.l());
    let measure = match measure {
        SystemMetric::Matrix(matrix) => Some(matrix),
        _ => None,
    };
    let map = Map::Sparse(Arc::new(map));
    (SystemMetric::Through(Arc::new(Through { map, measure, is_own: true })), dense * half)
}

/// A metric of a kind, and its inverse densely.
pub(super) fn metric(kind: usize, m: usize, random: &mut Lcg) -> (SystemMetric, DMatrix<f64>) {
    let band = |random: &mut Lcg| -> Vec<(usize, usize, f64)> {
        (0..m)
            .flat_map(|i| {
                let off = 0.4 * random.next();
                [(i, i, 1.5), ((i + 1) % m, i, if m > 2 { off } else { 0.0 })]
            })
            .collect()
    };
    match kind {
        0 => (SystemMetric::Least, DMatrix::identity(m, m)),
        1 => {
            let weights: Vec<f64> = (0..m).map(|_| random.next() + 1.2).collect();
            let inverse = DMatrix::from_fn(m, m, |i, j| if i == j { 1.0 / weights[i] } else { 0.0 });
            (SystemMetric::Weights(Arc::new(weights)), inverse)
        }
        2 => {
            let matrix = Symmetric::from_entries(m, band(random));
            let dense = DMatrix::from_fn(m, m, |i, j| matrix.entry(i, j));
            let inverse = dense.try_inverse().unwrap_or_else(|| DMatrix::identity(m, m));
            (SystemMetric::Matrix(Arc::new(matrix)), inverse)
        }
        _ => {
            let matrix = Symmetric::from_entries(m, band(random));
            let dense = DMatrix::from_fn(m, m, |i, j| matrix.entry(i, j));
            (SystemMetric::Inverse(Arc::new(matrix)), dense)
        }
    }
}
