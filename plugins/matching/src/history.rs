//! What knots inserted along an edge have brought so far, and whether more of them will help.

use crate::deviation::Deviation;

/// Where twice as many knots, and twice again, have left more than this part of what is too much, more will not help.
const NEARER: f64 = 0.7;

/// A match that is not within its limits.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Attempt {
    /// Control vertices along the edge.
    pub(crate) count: usize,
    /// How many times what is allowed it is.
    pub(crate) excess: f64,
    pub(crate) worst: Deviation,
}

/// Knots that brought next to nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stuck {
    /// Some spans were halved.
    Somewhere,
    /// All were.
    Everywhere,
}

/// The attempts so far.
#[derive(Debug, Default)]
pub(crate) struct History {
    all: Vec<Attempt>,
    /// How many attempts there were when all spans were halved first; those before tell nothing of what that brings.
    everywhere: Option<usize>,
}

impl History {
    pub(crate) fn push(&mut self, attempt: Attempt) {
        self.all.push(attempt);
    }

    pub(crate) fn last(&self) -> Option<&Attempt> {
        self.all.last()
    }

    /// Notes that all spans are halved now.
    pub(crate) fn all_halved(&mut self) {
        self.everywhere.get_or_insert(self.all.len());
    }

    /// Whether the last two rounds of knots brought next to nothing.
    pub(crate) fn is_stuck(&self) -> Option<Stuck> {
        let since = &self.all[self.everywhere.unwrap_or(0)..];
        let [.., before, _, now] = since else { return None };
        let stuck = if self.everywhere.is_some() { Stuck::Everywhere } else { Stuck::Somewhere };
        (now.excess > NEARER * before.excess).then_some(stuck)
    }

    /// How many control vertices would be needed, by the rate at which more of them brought it nearer: the smallest of three
    /// estimates in a row; none before there are four attempts, or where one came no nearer (which [`is_stuck`](Self::is_stuck)
    /// judges).
    pub(crate) fn needed(&self) -> Option<usize> {
        let last = self.all.get(self.all.len().checked_sub(4)?..)?;
        let estimate = |pair: &[Attempt]| {
            let [from, to] = pair else { return None };
            let order = (from.excess / to.excess).ln() / (to.count as f64 / from.count as f64).ln();
            let needed = to.count as f64 * (to.excess.ln() / order).exp();
            (order > 0.0 && needed.is_finite()).then_some(needed.min(1e6) as usize)
        };
        last.windows(2).map(estimate).try_fold(usize::MAX, |least, one| Some(least.min(one?)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn history(all: &[(usize, f64)]) -> History {
        let mut history = History::default();
        for &(count, excess) in all {
            history.push(Attempt { count, excess, worst: Deviation::default() });
        }
        history
    }

    #[test]
    fn what_converges_with_a_power_tells_how_many_are_needed() {
        // Of fourth order: 16 times nearer with twice as many.
        let found = history(&[(5, 1_048_576.0), (10, 65536.0), (20, 4096.0), (40, 256.0)]).needed().unwrap();
        assert!((159..=160).contains(&found), "{found}");
        assert_eq!(history(&[(10, 100.0), (20, 50.0), (40, 25.0)]).needed(), None);
        assert_eq!(history(&[(5, 120.0), (10, 100.0), (20, 110.0), (40, 10.0)]).needed(), None);
    }

    #[test]
    fn what_comes_no_nearer_is_stuck_somewhere_then_everywhere() {
        let mut history = history(&[(10, 100.0), (12, 40.0), (14, 39.0)]);
        assert_eq!(history.is_stuck(), None);
        history.push(Attempt { count: 16, excess: 38.0, worst: Deviation::default() });
        assert_eq!(history.is_stuck(), Some(Stuck::Somewhere));
        history.all_halved();
        assert_eq!(history.is_stuck(), None);
        for count in [30, 60, 120] {
            assert_eq!(history.is_stuck(), None);
            history.push(Attempt { count, excess: 37.0, worst: Deviation::default() });
        }
        assert_eq!(history.is_stuck(), Some(Stuck::Everywhere));
    }
}
