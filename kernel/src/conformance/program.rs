//! Whether a solver finds out which inequalities are active: against all sets that could be, and by the conditions of the least.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::solver::metric;
use super::{Lcg, Verdict};
use crate::solve::{Outcome, Program, Sense, Solver, SparseRows, System, SystemMetric};

/// The entries of a row, the side of its right-hand side, and that.
type Row = (Vec<(usize, f64)>, Sense, f64);

/// A program with its numbers spelled out densely: rows of unit length, every inequality turned to `≥`.
struct Dense {
    system: System,
    rhs: Vec<f64>,
    senses: Vec<Sense>,
    size: Vec<f64>,
    rows: DMatrix<f64>,
    wanted: Vec<f64>,
    inverse: DMatrix<f64>,
}

/// The least adjustment under some rows as equations.
struct Answer {
    d: DVector<f64>,
    /// Of the rows that were kept, in their order.
    multipliers: DVector<f64>,
}

pub(super) fn programs(verdict: &mut Verdict, solver: &dyn Solver) {
    let mut random = Lcg::new(11);
    let (mut solved, mut contradicting) = (0, 0);
    for round in 0..80 {
        let scale = [1.0, 1e-9, 1e9, 1e-3][round % 4];
        let program = small(round, scale, &mut random);
        let name = format!("program {round}");
        match program.by_trial(&program.all()) {
            Some(least) => {
                solved += usize::from(program.is_found(verdict, solver, Some(&least), &name));
            }
            None => contradicting += usize::from(program.is_named(verdict, solver, &name)),
        }
    }
    verdict.check(solved >= 30 && contradicting >= 5, || {
        format!("of 80 small programs {solved} were solved and {contradicting} contradictions named")
    });
    for round in 0..8 {
        let scale = [1.0, 1e-9, 1e9, 1e-3][round % 4];
        large(round, scale, &mut random).is_found(verdict, solver, None, &format!("large program {round}"));
    }
    let empty = System::new(SparseRows::new(2), vec![0, 1], 1, SystemMetric::Least);
    let none = Program { system: &empty, rhs: &[], senses: &[], size: &[] };
    let nothing = matches!(solver.program(&none), Ok(Outcome::Active { rows, .. }) if rows.is_empty());
    verdict.check(nothing, || "a program without rows is not solved".into());
    let mut rows = SparseRows::new(1);
    rows.push([(0, 1.0)]);
    let bad = System::new(rows, vec![0], 1, SystemMetric::Weights(Arc::new(vec![-1.0])));
    let refused =
        solver.program(&Program { system: &bad, rhs: &[1.0], senses: &[Sense::AtLeast], size: &[1.0] });
    verdict.check(refused.is_err(), || "a program with a negative weight is not refused".into());
}

/// Up to seven rows over some columns; now and then with rows that say the same, or the opposite, as others.
fn small(round: usize, scale: f64, random: &mut Lcg) -> Dense {
    let m = 2 + random.below(7);
    let (metric, inverse) = metric(round / 4 % 4, m, random);
    let count = 2 + random.below(4);
    let mut rows: Vec<Row> = Vec::new();
    for k in 0..count {
        let (first, run) = (random.below(m), 1 + random.below(m.min(3)));
        let size = 10_f64.powi(2 * (k as i32 % 3) - 2);
        let row = (0..run).map(|j| ((first + j) % m, size * (random.next() + 1.5))).collect();
        let sense = match random.below(5) {
            0 => Sense::Equal,
            1 | 2 => Sense::AtLeast,
            _ => Sense::AtMost,
        };
        rows.push((row, sense, scale * size * (random.next() + 0.2)));
    }
    let (row, sense, b) = rows[count - 1].clone();
    let opposite = if sense == Sense::AtLeast { Sense::AtMost } else { Sense::AtLeast };
    let times = |factor: f64| row.iter().map(|&(c, v)| (c, factor * v)).collect::<Vec<_>>();
    match round % 7 {
        // Twice the same; the same in other units; less of the same.
        0 => rows.push((row, sense, b)),
        1 => rows.push((times(-3.0), if sense == Sense::Equal { sense } else { opposite }, -3.0 * b)),
        2 => rows.push((row.clone(), sense, if sense == Sense::Equal { b } else { 0.5 * b })),
        // From both sides: what is left between is nothing, or less than nothing.
        3 => rows.push((row, opposite, b)),
        4 => rows.push((row, opposite, if opposite == Sense::AtMost { b - scale } else { b + scale })),
        // Nothing is touched, and nothing asked.
        5 => rows.push((Vec::new(), Sense::AtLeast, -scale)),
        _ => {}
    }
    Dense::new(m, rows, metric, inverse, scale)
}

/// A box around every coordinate, some of which are pulled out of it; equations among them.
fn large(round: usize, scale: f64, random: &mut Lcg) -> Dense {
    let m = 60;
    let (metric, inverse) = metric(round % 4, m, random);
    let mut rows = Vec::new();
    let middles: Vec<f64> = (0..m).map(|_| 0.6 * random.next()).collect();
    for (i, middle) in middles.iter().enumerate() {
        rows.push((vec![(i, 1.0)], Sense::AtLeast, scale * (middle - 0.25)));
        rows.push((vec![(i, 1.0)], Sense::AtMost, scale * (middle + 0.25)));
        if i % 9 == 4 {
            let mean: f64 = (0..4).map(|j| 0.25 * middles[(i + j) % m]).sum();
            rows.push(((0..4).map(|j| ((i + j) % m, 0.25)).collect(), Sense::Equal, scale * (mean - 0.1)));
        }
    }
    Dense::new(m, rows, metric, inverse, scale)
}

impl Dense {
    fn new(m: usize, rows: Vec<Row>, metric: SystemMetric, inverse: DMatrix<f64>, scale: f64) -> Self {
        let mut sparse = SparseRows::new(m);
        let mut dense = DMatrix::zeros(rows.len(), m);
        let (mut rhs, mut senses, mut size, mut wanted) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for (k, (row, sense, b)) in rows.into_iter().enumerate() {
            let length = row.iter().map(|(_, v)| v * v).sum::<f64>().sqrt();
            let turned = if sense == Sense::AtMost { -1.0 } else { 1.0 };
            let unit = if length > 0.0 { turned / length } else { turned };
            row.iter().for_each(|&(c, v)| dense[(k, c)] += v * unit);
            sparse.push(row);
            rhs.push(b);
            wanted.push(b * unit);
            senses.push(sense);
            size.push(scale * length);
        }
        let system = System::new(sparse, (0..m).collect(), 1, metric);
        Self { system, rhs, senses, size, rows: dense, wanted, inverse }
    }

    fn program(&self) -> Program<'_> {
        Program { system: &self.system, rhs: &self.rhs, senses: &self.senses, size: &self.size }
    }

    fn all(&self) -> Vec<usize> {
        (0..self.rhs.len()).collect()
    }

    /// The size of an adjustment: what rounding is measured by.
    fn size(&self) -> f64 {
        self.wanted.iter().fold(f64::MIN_POSITIVE, |m, v| m.max(v.abs()))
    }

    /// The least adjustment under `kept` rows as equations; `None` where they depend on one another.
    fn under(&self, kept: &[usize]) -> Option<Answer> {
        if kept.is_empty() {
            let (d, multipliers) = (DVector::zeros(self.inverse.nrows()), DVector::zeros(0));
            return Some(Answer { d, multipliers });
        }
        let n = self.rows.select_rows(kept);
        let gram = &n * &self.inverse * n.transpose();
        let spectrum = gram.clone().symmetric_eigenvalues();
        if spectrum.iter().any(|v| *v < 1e-9 * spectrum.max()) {
            return None;
        }
        let wanted = DVector::from_iterator(kept.len(), kept.iter().map(|&r| self.wanted[r]));
        let multipliers = gram.lu().solve(&wanted)?;
        Some(Answer { d: &self.inverse * n.transpose() * &multipliers, multipliers })
    }

    /// What the conditions of the least are missed by, of some rows: violations, and multipliers that pull the wrong way,
    /// relative to the largest.
    fn missed(&self, among: &[usize], kept: &[usize], answer: &Answer) -> f64 {
        let strongest = answer.multipliers.amax().max(f64::MIN_POSITIVE);
        let pulls =
            kept.iter().zip(answer.multipliers.iter()).filter(|(r, _)| self.senses[**r] != Sense::Equal);
        let wrong = pulls.map(|(_, m)| -m / strongest).fold(0.0, f64::max);
        let violation = |&row: &usize| {
            let short = self.wanted[row] - self.rows.row(row).transpose().dot(&answer.d);
            if self.senses[row] == Sense::Equal { short.abs() } else { short }
        };
        among.iter().map(violation).fold(0.0, f64::max) / self.size().max(answer.d.amax()) + wrong
    }

    /// The least adjustment under some rows, by trying every set of them; `None` where there is none.
    fn by_trial(&self, among: &[usize]) -> Option<Answer> {
        (0..1_u32 << among.len()).find_map(|set| {
            let kept: Vec<usize> =
                among.iter().enumerate().filter(|(k, _)| set >> k & 1 == 1).map(|(_, r)| *r).collect();
            let answer = self.under(&kept)?;
            (self.missed(among, &kept, &answer) <= 1e-9).then_some(answer)
        })
    }

    /// Whether the solver's active rows give the least adjustment.
    fn is_found(
        &self,
        verdict: &mut Verdict,
        solver: &dyn Solver,
        least: Option<&Answer>,
        name: &str,
    ) -> bool {
        let name = format!("{name} ({})", solver.name());
        let rows = match solver.program(&self.program()) {
            Ok(Outcome::Active { rows, .. }) => rows,
            other => {
                verdict.check(false, || format!("{name}: {other:?}, and it has a solution"));
                return false;
            }
        };
        let ascending = rows.windows(2).all(|w| w[0] < w[1]);
        verdict.check(
            ascending && rows.iter().all(|&r| self.senses.get(r).is_some_and(|s| *s != Sense::Equal)),
            || format!("{name}: {rows:?} are not ascending inequalities"),
        );
        // Equations that others imply may be among the rows.
        let mut kept: Vec<usize> = Vec::new();
        for row in self.all().into_iter().filter(|&r| self.senses[r] == Sense::Equal).chain(rows) {
            kept.push(row);
            if self.senses[row] == Sense::Equal && self.under(&kept).is_none() {
                kept.pop();
            }
        }
        let Some(answer) = self.under(&kept) else {
            verdict.check(false, || format!("{name}: active rows {kept:?} depend on one another"));
            return false;
        };
        let missed = self.missed(&self.all(), &kept, &answer);
        verdict.check(missed <= 1e-9, || {
            format!("{name}: with {kept:?} active, the conditions are missed by {missed:e}")
        });
        if let Some(least) = least {
            let off = (&least.d - &answer.d).amax();
            verdict.check(off <= 1e-8 * self.size().max(least.d.amax()), || {
                format!("{name}: with {kept:?} active it is off the least adjustment by {off:e}")
            });
        }
        true
    }

    /// Whether the solver names rows that contradict each other, and none too many.
    fn is_named(&self, verdict: &mut Verdict, solver: &dyn Solver, name: &str) -> bool {
        let name = format!("{name} ({})", solver.name());
        // Equations that contradict each other are found by factoring, before there are inequalities.
        let equations: Vec<usize> =
            self.all().into_iter().filter(|&r| self.senses[r] == Sense::Equal).collect();
        if self.by_trial(&equations).is_none() {
            return false;
        }
        let outcome = solver.program(&self.program());
        let Ok(Outcome::Infeasible { rows }) = outcome else {
            verdict.check(false, || format!("{name}: {outcome:?}, and it has no solution"));
            return false;
        };
        verdict.check(self.by_trial(&rows).is_none(), || format!("{name}: {rows:?} can all hold"));
        for leave in 0..rows.len() {
            let others: Vec<usize> =
                rows.iter().enumerate().filter(|(k, _)| *k != leave).map(|(_, r)| *r).collect();
            verdict.check(self.by_trial(&others).is_some(), || {
                format!("{name}: of {rows:?}, {} can be spared", rows[leave])
            });
        }
        true
    }
}
