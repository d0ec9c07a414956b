//! Answers corrected by their own residuals, and what is left of these measured.

use std::sync::Arc;

use super::system::{SparseRows, System};

/// A residual of so many roundings is rounding: sums of a few dozen products leave about as much.
const ENOUGH: f64 = 8.0;
/// A residual of more roundings than this is an error.
const ACCEPTED: f64 = 64.0;
/// Terms count as no smaller than this share of a row's coefficient times the largest adjustment anywhere.
const UNNOTICED: f64 = 1e-3;
/// The most corrections. Each takes away what is left but for the share `κ ε` or `κ² ε`; with that at a half, forty would not
/// do, and where eight do not, the factors are worth nothing.
const ROUNDS: usize = 8;

/// Iterative refinement: `d ← d + C (b - F d)`, with the rows as they were given, until each `|b - F d|` is within rounding of
/// the terms that it is the difference of, `|b| + |F||d|` (Skeel 1980). That takes away what solving left, and what was lost
/// by taking the metric out beforehand: a metric's condition (that of bending grows with the fourth power of the vertices'
/// number) disturbs rows by far more than rounding.
#[derive(Debug)]
pub(super) struct Refinement {
    rows: Arc<SparseRows>,
    sides: usize,
    kept: Vec<u32>,
    missed: Vec<f64>,
    more: Vec<f64>,
}

impl Refinement {
    /// For the rows of a system that are kept, and answers that `solve` gives; `None` where they are not met to rounding.
    #[cold]
    pub(super) fn new(
        system: &System,
        kept: impl Iterator<Item = u32>,
        solve: impl FnMut(&[f64], &mut [f64]),
    ) -> Option<Box<Self>> {
        let (rows, sides) = (Arc::clone(system.rows()), system.sides());
        let (missed, more) = (vec![0.0; rows.len() * sides], vec![0.0; rows.width() * sides]);
        let mut refinement = Box::new(Self { rows, sides, kept: kept.collect(), missed, more });
        refinement.is_accurate(solve).then_some(refinement)
    }

    /// Corrects `d` by what `solve` says to its residuals, while that helps. What is left, in roundings: the largest over all
    /// rows.
    pub(super) fn refine(
        &mut self,
        rhs: &[f64],
        d: &mut [f64],
        mut solve: impl FnMut(&[f64], &mut [f64]),
    ) -> f64 {
        let mut before = f64::INFINITY;
        for _ in 0..ROUNDS {
            let left = self.measure(rhs, d);
            if left <= ENOUGH {
                return left;
            }
            if left >= before || left.is_nan() {
                if before.is_finite() {
                    d.iter_mut().zip(&self.more).for_each(|(d, more)| *d -= more);
                }
                return before.min(left);
            }
            before = left;
            solve(&self.missed, &mut self.more);
            d.iter_mut().zip(&self.more).for_each(|(d, more)| *d += more);
        }
        self.measure(rhs, d)
    }

    /// Whether right-hand sides with a solution of ordinary size, and others, are met within rounding; both have all
    /// frequencies, and are the same on every machine.
    fn is_accurate(&mut self, mut solve: impl FnMut(&[f64], &mut [f64])) -> bool {
        let wave = |i: usize| (1.0 + ((i * 7 + 3) % 11) as f64 / 11.0) * (1.0 - 2.0 * (i / 3 % 2) as f64);
        let (mut rhs, mut d) = (self.missed.clone(), self.more.clone());
        d.iter_mut().enumerate().for_each(|(i, d)| *d = wave(i / self.sides));
        self.rows.multiply(&d, self.sides, &mut rhs);
        let mut one = |this: &mut Self, rhs: &[f64]| {
            solve(rhs, &mut d);
            this.refine(rhs, &mut d, &mut solve) <= ACCEPTED
        };
        one(self, &rhs) && {
            rhs.iter_mut().enumerate().for_each(|(i, b)| *b = wave(i / self.sides));
            let norms: Vec<f64> = (0..self.rows.len()).map(|row| self.rows.norm(row)).collect();
            rhs.chunks_exact_mut(self.sides).zip(norms).for_each(|(b, n)| b.iter_mut().for_each(|b| *b *= n));
            one(self, &rhs)
        }
    }

    /// `b - F d` of the kept rows into `missed` (zero for the others); the largest, in roundings of its terms.
    fn measure(&mut self, rhs: &[f64], d: &[f64]) -> f64 {
        let mut worst = 0.0_f64;
        let longest = d.iter().fold(0.0_f64, |m, d| m.max(d.abs()));
        for &row in &self.kept {
            let (columns, values) = self.rows.row(row as usize);
            // A row whose terms should all vanish is measured by what vanishes beside larger ones: by itself it would never do.
            let floor = UNNOTICED * longest * values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            for side in 0..self.sides {
                let at = row as usize * self.sides + side;
                let (mut reached, mut size) = (0.0, floor + rhs[at].abs());
                for (&column, value) in columns.iter().zip(values) {
                    let term = value * d[column as usize * self.sides + side];
                    reached += term;
                    size += term.abs();
                }
                self.missed[at] = rhs[at] - reached;
                let left = self.missed[at].abs() / (f64::EPSILON * size).max(f64::MIN_POSITIVE);
                // NaN must not pass as small.
                worst = if left > worst || left.is_nan() { left } else { worst };
            }
        }
        worst
    }
}
