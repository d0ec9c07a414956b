//! How long an iteration goes on that does not arrive.

use crate::problem::bound::BoundConstraint;

/// The work that an event may take, in evaluations of shapes, where its constraints say what a look at them
/// [takes](crate::functional::Functional::effort).
const WORK: usize = 30_000_000;
/// So many looks are allowed in any case.
const LEAST: usize = 60;
/// An error below this share of what is asked is small: the constraints nearly hold, and what goes on is the search for the
/// least adjustment, which may linger.
const SMALL: f64 = 1e-3;
/// The share of all looks that may bring nothing, in a row, while the error is large.
const PATIENCE: f64 = 0.25;

/// How many looks at its constraints an event may take: no number of them is too much where they are cheap.
pub(super) fn looks(bound: &[BoundConstraint]) -> usize {
    let effort = bound.iter().map(|b| b.constraint.functional.effort()).fold(0, usize::saturating_add);
    WORK.checked_div(effort).map_or(usize::MAX, |looks| looks.max(LEAST))
}

/// Counts an iteration's looks, and those since the error or the step was last halved. So a problem that takes much work and
/// cannot be solved is given up after work that is counted, not timed: the same input gives the same answer everywhere.
#[derive(Debug, Clone, Copy)]
pub(super) struct Progress {
    most: usize,
    looks: usize,
    error: f64,
    change: f64,
    /// The looks when one of these was halved.
    halved: usize,
}

impl Progress {
    /// Before the first of at most so many looks.
    pub(super) fn new(most: usize) -> Self {
        Self { most, looks: 0, error: f64::INFINITY, change: f64::INFINITY, halved: 0 }
    }

    /// Whether to go on after an iteration that took so many `looks`, found the constraints missed by `error` of what is
    /// asked, and would change the adjustment by `change` of itself.
    pub(super) fn goes_on(&mut self, looks: usize, error: f64, change: f64) -> bool {
        self.looks += looks;
        if error < 0.5 * self.error || change < 0.5 * self.change {
            self.error = self.error.min(error);
            self.change = self.change.min(change);
            self.halved = self.looks;
        }
        let idle = (self.looks - self.halved) as f64;
        self.looks < self.most && (error <= SMALL || idle < PATIENCE * self.most as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn iterations(most: usize, error: impl Fn(usize) -> f64, change: impl Fn(usize) -> f64) -> usize {
        let mut progress = Progress::new(most);
        (1..1000).take_while(|&k| progress.goes_on(1, error(k), change(k))).count()
    }

    #[test]
    fn what_is_cheap_goes_on() {
        assert_eq!(iterations(usize::MAX, |_| 0.9, |_| 1.0), 999);
    }

    #[test]
    fn slow_is_not_stuck() {
        // A twentieth less in each iteration, of either.
        assert_eq!(iterations(160, |k| 0.95_f64.powi(k as i32), |_| 1.0), 159);
        assert_eq!(iterations(160, |_| 1e-9, |k| 0.95_f64.powi(k as i32)), 159);
    }

    #[test]
    fn stuck_is_seen_sooner_where_the_constraints_are_far_from_holding() {
        assert_eq!(iterations(160, |_| 0.9, |_| 1.0), 40);
        let (error, change) = (|k| 0.9 + 0.05 * (k as f64).sin(), |k| 1.0 + 0.3 * (k as f64).cos());
        assert_eq!(iterations(160, error, change), 40);
        assert_eq!(iterations(160, |_| 1e-6, |_| 1e-2), 159);
        assert_eq!(iterations(160, |_| f64::NAN, |_| f64::NAN), 39);
    }
}
