//! Weights where intervals vanish: what they come to when all zeros are the same small number.

use std::ops::{Add, Mul};

/// `value · ε^order` and what is smaller, as ε goes to zero: an interval that is zero counts as `ε`.
///
/// Where a weight is a quotient `0/0` of sums of products of intervals, the leading terms of both say what it comes to. On grids this
/// is the tensor-product spline with its multiple knots, in whatever direction these are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Leading {
    order: u32,
    value: f64,
}

impl Leading {
    /// A sum of `count` intervals.
    pub(crate) fn new(sum: f64, count: f64) -> Self {
        if sum > 0.0 { Self { order: 0, value: sum } } else { Self { order: 1, value: count } }
    }

    /// Others over the sum of some weights, of which one that is greater beyond measure makes the whole nothing.
    pub(crate) fn over(others: &[Self], weights: &[Self]) -> Option<Vec<f64>> {
        let (first, rest) = weights.split_first()?;
        let total = rest.iter().fold(*first, |sum, w| sum + *w);
        let share = |w: &Self| match w.order.cmp(&total.order) {
            std::cmp::Ordering::Less => None,
            std::cmp::Ordering::Equal => Some(w.value / total.value),
            std::cmp::Ordering::Greater => Some(0.0),
        };
        others.iter().map(share).collect()
    }

    /// Each of some weights over their sum.
    pub(crate) fn shares(weights: &[Self]) -> Vec<f64> {
        let order = weights.iter().map(|w| w.order).min().unwrap_or(0);
        let leads = |w: &Self| if w.order == order { w.value } else { 0.0 };
        let total: f64 = weights.iter().map(leads).sum();
        weights.iter().map(|w| leads(w) / total).collect()
    }
}

impl Add for Leading {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        match self.order.cmp(&other.order) {
            std::cmp::Ordering::Less => self,
            std::cmp::Ordering::Greater => other,
            std::cmp::Ordering::Equal => Self { order: self.order, value: self.value + other.value },
        }
    }
}

impl Mul for Leading {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self { order: self.order + other.order, value: self.value * other.value }
    }
}

impl Mul<f64> for Leading {
    type Output = Self;

    fn mul(self, by: f64) -> Self {
        Self { value: self.value * by, ..self }
    }
}
