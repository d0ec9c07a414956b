//! The sum of the squares of what is missed, and what it is preconditioned by.

use super::super::sequential::Linearized;
use crate::solve::{InverseMetric, Sense, SolveError, SparseRows};

/// The sum of squares, and what it is preconditioned by.
pub(super) struct Squares {
    /// `1/‖f_k‖` of each row.
    pub(super) weights: Vec<f64>,
    pub(super) senses: Vec<Sense>,
    pub(super) curved: Vec<bool>,
    pub(super) sides: usize,
    /// Whether equations count.
    pub(super) equations: bool,
    pub(super) stiffness: f64,
    /// By how much bounds are given way, and their multipliers, an entry for each row and side.
    pub(super) given: Vec<f64>,
    pub(super) forces: Vec<f64>,
    /// `λ`, and the share `ε`.
    pub(super) largest: f64,
    pub(super) share: f64,
    pub(super) inverse: InverseMetric,
    pub(super) work: Vec<f64>,
}

/// An adjustment `d` and `W d`.
#[derive(Debug, Clone)]
pub(super) struct Place {
    pub(super) d: Vec<f64>,
    pub(super) dual: Vec<f64>,
}

impl Place {
    pub(super) fn zero(width: usize) -> Self {
        Self { d: vec![0.0; width], dual: vec![0.0; width] }
    }

    pub(super) fn plus(&self, by: f64, other: &Self) -> Self {
        let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a + by * b).collect();
        Self { d: sum(&self.d, &other.d), dual: sum(&self.dual, &other.dual) }
    }

    pub(super) fn times(&self, by: f64) -> Self {
        let each = |a: &[f64]| a.iter().map(|a| by * a).collect();
        Self { d: each(&self.d), dual: each(&self.dual) }
    }

    /// `dᵀWd`
    pub(super) fn square(&self) -> f64 {
        dot(&self.d, &self.dual).max(0.0)
    }

    pub(super) fn with(&self, other: &Self) -> f64 {
        dot(&self.d, &other.dual)
    }
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

pub(super) fn amax(v: &[f64]) -> f64 {
    v.iter().fold(0.0, |m, v| m.max(v.abs()))
}

/// `out += Σ c_k f_k`
pub(super) fn add_rows(rows: &SparseRows, sides: usize, factors: &[f64], out: &mut [f64]) {
    for (row, factors) in factors.chunks_exact(sides).enumerate() {
        for (side, factor) in factors.iter().enumerate().filter(|(_, factor)| **factor != 0.0) {
            rows.iter_row(row).for_each(|(column, value)| out[column * sides + side] += factor * value);
        }
    }
}

impl Squares {
    pub(super) fn new(here: &Linearized, senses: Vec<Sense>, curved: Vec<bool>) -> Result<Self, SolveError> {
        let system = &here.assembly.system;
        let (rows, sides) = (system.rows(), system.sides());
        let entries = rows.len() * sides;
        let mut squares = Self {
            weights: vec![0.0; rows.len()],
            senses,
            curved,
            sides,
            equations: true,
            stiffness: 1.0,
            given: vec![0.0; entries],
            forces: vec![0.0; entries],
            largest: 0.0,
            share: 0.0,
            inverse: system.select(&[]).inverse_metric()?,
            work: vec![0.0; rows.width() * sides],
        };
        squares.weigh(rows);
        squares.largest = squares.eigenvalue(rows);
        Ok(squares)
    }

    /// Weights of the rows that have none yet: whose gradients vanished where the edit began.
    pub(super) fn weigh(&mut self, rows: &SparseRows) {
        for (row, weight) in self.weights.iter_mut().enumerate().filter(|(_, weight)| **weight == 0.0) {
            let norm = rows.norm(row);
            if norm > 0.0 && norm.is_finite() {
                *weight = (1.0 / norm).min(f64::MAX);
            }
        }
    }

    /// `λ`, by its powers.
    pub(super) fn eigenvalue(&mut self, rows: &SparseRows) -> f64 {
        let mut factors: Vec<f64> = (0..self.given.len())
            .map(|k| self.weights[k / self.sides] * (1.0 + 0.1 * (k as f64).sin()))
            .collect();
        let mut found = 0.0;
        for _ in 0..12 {
            let mut dual = vec![0.0; rows.width() * self.sides];
            add_rows(rows, self.sides, &factors, &mut dual);
            let d = self.raise(&dual);
            let length = factors.iter().enumerate().map(|(k, f)| {
                let w = self.weights[k / self.sides];
                if w > 0.0 { (f / w) * (f / w) } else { 0.0 }
            });
            let length = length.sum::<f64>();
            let own = dot(&d, &dual);
            if !(own > 0.0 && length > 0.0) {
                return found;
            }
            found = own / length;
            rows.multiply(&d, self.sides, &mut factors);
            let most = factors.iter().enumerate().map(|(k, f)| (f * self.weights[k / self.sides]).abs());
            let most = most.fold(0.0, f64::max);
            for (k, factor) in factors.iter_mut().enumerate() {
                let w = self.weights[k / self.sides];
                *factor *= w * w / most.max(f64::MIN_POSITIVE);
            }
        }
        found
    }

    /// `W⁻¹ g`
    pub(super) fn raise(&mut self, dual: &[f64]) -> Vec<f64> {
        let mut d = vec![0.0; dual.len()];
        self.inverse.apply(dual, self.sides, &mut d, &mut self.work);
        d
    }

    /// What an entry misses beyond what it is given way, on the side of its bound that is wrong, as a length; an equation with its sign.
    pub(super) fn length(&self, entry: usize, rhs: f64) -> f64 {
        let weight = self.weights[entry / self.sides];
        match self.senses[entry / self.sides] {
            Sense::Equal => weight * rhs,
            Sense::AtLeast => weight * (rhs - self.given[entry]),
            Sense::AtMost => weight * (-rhs - self.given[entry]),
        }
    }

    /// How stiff an entry is, and its length with the part of its multiplier, signed like `rhs`; nothing where it does not count.
    pub(super) fn pull(&self, entry: usize, rhs: f64) -> Option<(f64, f64)> {
        let length = self.length(entry, rhs);
        let sense = self.senses[entry / self.sides];
        if sense == Sense::Equal {
            return self.equations.then_some((1.0, length));
        }
        let pulled = length + self.forces[entry] / self.stiffness;
        let sign = if sense == Sense::AtLeast { 1.0 } else { -1.0 };
        (pulled > 0.0).then_some((self.stiffness, sign * pulled))
    }

    /// `½ Σ`, without the part of the adjustment.
    pub(super) fn half(&self, rhs: &[f64]) -> f64 {
        let each = rhs.iter().enumerate().filter_map(|(entry, rhs)| self.pull(entry, *rhs));
        each.map(|(stiff, pull)| 0.5 * stiff * pull * pull).sum()
    }

    /// `-stiffness · pull · weight` of each entry: the factors of the rows in the gradient.
    pub(super) fn factors(&self, rhs: &[f64]) -> Vec<f64> {
        let of = |(entry, rhs): (usize, &f64)| {
            let (stiff, pull) = self.pull(entry, *rhs)?;
            Some(-stiff * pull * self.weights[entry / self.sides])
        };
        rhs.iter().enumerate().map(|each| of(each).unwrap_or(0.0)).collect()
    }
}
