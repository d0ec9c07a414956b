//! Rows that depend on one another, or nearly: what agrees is met to rounding, what contradicts is not called solved.

use super::solver::metric;
use super::{Lcg, Verdict};
use crate::solve::{Factored, SolveError, Solver, SparseRows, System};

/// An equation is met where it is missed by no more than this, of the numbers that it is the sum of.
const MET: f64 = 1e-12;

/// Systems of four kinds: every column kept beside a row that falls off along them (whose pivots are all harmless while the
/// factors grow), hundreds of rows on few columns, copies and sums, and rows that nearly coincide.
pub(super) fn dependent(verdict: &mut Verdict, solver: &dyn Solver) {
    let mut random = Lcg::new(23);
    for round in 0..64 {
        let rows = family(round % 4, &mut random);
        let (count, width) = (rows.len(), rows.width());
        let (metric, _) = metric(round / 4 % 4, width, &mut random);
        let system = System::new(rows, (0..width).collect(), 1, metric);
        let wish: Vec<f64> = (0..width).map(|_| random.next()).collect();
        let mut rhs = vec![0.0; count];
        system.rows().multiply(&wish, 1, &mut rhs);
        let name = format!("dependent system {round}, {count} rows, {width} columns");
        match meets(verdict, solver, &system, &rhs, &name) {
            Some(answer) => {
                verdict.check(answer.is_some(), || format!("{name}: what agrees is called a contradiction"));
            }
            None => continue,
        }
        // The last row is a sum of others.
        rhs[count - 1] += system.rows().norm(count - 1) * (1.5 + random.next());
        if let Some(answer) = meets(verdict, solver, &system, &rhs, &name) {
            // Only where rounding of the rows could be taken for independence, and then at its price.
            let far = |d: &Vec<f64>| d.iter().any(|v| v.abs() > 1e9);
            verdict.check(answer.as_ref().is_none_or(far), || format!("{name}: a contradiction is solved"));
        }
    }
}

fn family(kind: usize, random: &mut Lcg) -> SparseRows {
    let width = 4 + random.below(9);
    let mut list: Vec<Vec<(usize, f64)>> = Vec::new();
    match kind {
        0 => {
            let fall = 10_f64.powf(-2.0 + 1.5 * random.next());
            list.push((0..width).map(|j| (j, fall.powi(j as i32))).collect());
            list.extend((1..width).map(|j| vec![(j, 1.0)]));
            list.push(vec![(0, 1.0)]);
        }
        1 => {
            // Moments of points by the hundred.
            let count = 100 + random.below(100);
            let t = |k: usize| (k as f64 + 0.5) / count as f64;
            list.extend((0..count).map(|k| (0..width).map(|j| (j, t(k).powi(j as i32))).collect()));
        }
        2 => {
            for _ in 0..3 {
                let first = random.below(width - 3);
                let row: Vec<(usize, f64)> = (0..4).map(|j| (first + j, random.next())).collect();
                list.push(row.iter().map(|&(c, v)| (c, -3.0 * v)).collect());
                list.push(row);
            }
            list.push(list[0].iter().chain(&list[3]).copied().collect());
        }
        _ => {
            let apart = 10_f64.powf(-8.0 + 7.0 * random.next());
            let row: Vec<(usize, f64)> = (0..4).map(|j| (j, 0.3 + random.next().abs())).collect();
            list.push(row.iter().map(|&(c, v)| (c, v + apart * (c as f64 - 1.3))).collect());
            list.push(row.clone());
            list.push(row.iter().map(|&(c, v)| (c, 2.0 * v)).collect());
        }
    }
    let mut rows = SparseRows::new(width);
    list.into_iter().for_each(|row| rows.push(row));
    rows
}

/// The answer that meets all rows; within, `None` where the rows that are left out deny it, coarsely and finely. `None` where
/// the system is refused.
fn meets(
    verdict: &mut Verdict,
    solver: &dyn Solver,
    system: &System,
    rhs: &[f64],
    name: &str,
) -> Option<Option<Vec<f64>>> {
    for system in [system.clone(), system.finely()] {
        let mut factored = match solver.factor(&system) {
            Ok(factored) => factored,
            Err(
                SolveError::TooLarge { .. } | SolveError::IllConditioned { .. } | SolveError::Unsupported(_),
            ) => return None,
            Err(error) => {
                verdict.check(false, || format!("{name}: {error}"));
                return None;
            }
        };
        if let Some(d) = answer(verdict, factored.as_mut(), &system, rhs, name) {
            return Some(Some(d));
        }
    }
    Some(None)
}

fn answer(
    verdict: &mut Verdict,
    factored: &mut dyn Factored,
    system: &System,
    rhs: &[f64],
    name: &str,
) -> Option<Vec<f64>> {
    let (rows, diagnosis) = (system.rows(), factored.diagnosis());
    let (rank, left_out) = (factored.rank(), diagnosis.dependencies.len());
    verdict.check(rank <= rows.width() && rank + left_out == rows.len(), || {
        format!("{name}: rank {rank} and {left_out} dependencies")
    });
    let mut d = vec![f64::NAN; rows.width()];
    factored.solve_into(rhs, &mut d);
    for row in (0..rows.len()).filter(|row| diagnosis.dependencies.iter().all(|d| d.row != *row)) {
        let terms = rows.iter_row(row).map(|(column, value)| value * d[column]);
        let (sum, size) = terms.fold((0.0, rhs[row].abs()), |(sum, size), t| (sum + t, size + t.abs()));
        verdict.check((rhs[row] - sum).abs() <= MET * size, || {
            format!("{name}: equation {row} is missed by {:e} of {size:e}", rhs[row] - sum)
        });
    }
    diagnosis.dependencies.iter().all(|row| row.agrees(system, rhs, &vec![0.0; rhs.len()], &d)).then_some(d)
}
