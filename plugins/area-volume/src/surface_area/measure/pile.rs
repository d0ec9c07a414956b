//! The parts of a surface, by what they may be wrong by.

use std::collections::BinaryHeap;

use super::AGREE;
use super::part::Judged;
use crate::nets::Total;

/// All parts: those that may have to be halved, the one with most first, and the others, which are most as a rule.
#[derive(Clone)]
pub(super) struct Pile {
    open: BinaryHeap<Judged>,
    calm: Vec<Judged>,
    /// A cell's share of the whole.
    pub(super) share: f64,
    /// The largest area of a part.
    pub(super) largest: f64,
    made: usize,
}

impl Pile {
    /// Of all cells.
    pub(super) fn new(cells: Vec<Judged>) -> Self {
        let mut total = Total::default();
        cells.iter().for_each(|cell| total.add(cell.fine));
        let share = total.value() / cells.len().max(1) as f64;
        let mut pile =
            Self { open: BinaryHeap::new(), calm: Vec::new(), share, largest: 0.0, made: cells.len() };
        cells.into_iter().for_each(|cell| pile.push(cell));
        pile
    }

    fn push(&mut self, part: Judged) {
        self.largest = self.largest.max(part.fine);
        // Also what is no number is looked at.
        if part.error <= AGREE * self.share { self.calm.push(part) } else { self.open.push(part) }
    }

    /// Takes all out that may be wrong by more than this and can be halved.
    pub(super) fn above(&mut self, limit: f64) -> Vec<Judged> {
        let mut all = Vec::new();
        while self.open.peek().is_some_and(|p| !p.settled && p.error.is_finite() && p.error > limit) {
            all.extend(self.open.pop());
        }
        all
    }

    /// Takes that with most out, where it is more than it may be.
    pub(super) fn worst(&mut self) -> Option<Judged> {
        let worst = self.open.peek()?;
        let well = worst.settled || worst.error <= AGREE * self.share.max(worst.fine);
        if well || !worst.error.is_finite() { None } else { self.open.pop() }
    }

    /// The halves of a part that was taken out; where there are none it is too short to be halved, and what it may be wrong by stays counted.
    pub(super) fn put(&mut self, halves: Option<Vec<Judged>>, whole: Judged) {
        let Some(halves) = halves else {
            self.push(Judged { settled: true, ..whole });
            return;
        };
        for half in halves {
            self.push(Judged { order: self.made, ..half });
            self.made += 1;
        }
    }

    /// The area of all, and what it may be wrong by.
    pub(super) fn sums(&self) -> [f64; 2] {
        let all = || self.calm.iter().chain(&self.open);
        let sum = |of: fn(&Judged) -> f64| {
            let mut total = Total::default();
            all().for_each(|part| total.add(of(part)));
            total.value()
        };
        [sum(|part| part.fine), sum(|part| part.error)]
    }

    /// All parts, in the order in which they were made: the same sums every time.
    pub(super) fn take(&mut self) -> Vec<Judged> {
        let mut all = std::mem::take(&mut self.calm);
        all.extend(self.open.drain());
        all.sort_by_key(|part| part.order);
        all
    }
}
