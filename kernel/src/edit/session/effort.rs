//! What cannot all hold, where a best effort is asked for: the least squares of what is missed.
//!
//! With `m_k` what row `k` misses and `w_k = 1/‖f_k‖`, `f_k` its gradient where the edit began (so that `w_k m_k` is a length: how
//! far vertices would have to go for it), `½ Σ (w_k m_k)²` is made least, and then the adjustment among those for which it is:
//! the limit for `ε → 0` of the least of `½ Σ (w_k m_k)² + ½ ε λ dᵀWd`, whose minimisers lead from the shapes as they were to it,
//! `λ` the largest eigenvalue of `W⁻¹ Σ w_k² f_k f_kᵀ`. What is left of `ε` is taken out by measuring `d` from the last minimiser
//! (Martinet 1970; Rockafellar 1976). Where the constraints contradict one another at the end only (two ends, and a curve
//! between them that should be shorter than straight) their gradients become dependent there, the second derivatives decide, and
//! Gauss and Newton's way, which has none, does not arrive: `Σ w_k² m_k ∇²F_k` is taken by differences of gradients, in Newton's
//! method by conjugate gradients within a trust region (Steihaug 1983), preconditioned by `W⁻¹`, so that no matrix is made.
//!
//! *Bounds* hold, as equations would not: by multipliers (Powell 1969, Hestenes 1969). Where they contradict one another, they are
//! first given way by the least squares of what they miss themselves.

use super::sequential::Linearized;
use super::strategy::Strategy;
use super::{Session, put, snapshot};
use crate::edit::report::Convergence;
use crate::functional::Linearity;
use crate::problem::bound::right_hand_side;
use crate::problem::conflict::quoted;
use crate::problem::constraint::Constraint;
use crate::problem::program::{Bounds, senses};
use crate::problem::{EditError, Numbers, view};
use crate::shape::Shape;
use crate::solve::{InverseMetric, Sense, SolveError, SparseRows};

/// The shares `ε` of the adjustment, from a path that is easily followed to one that leaves the misses alone.
const SHARES: [f64; 4] = [1e-2, 1e-4, 1e-6, 1e-8];
/// Newton's steps at each share, and the products of each; the slower steps that follow where these do not arrive, of which so many are remembered.
const STEPS: usize = 60;
const PRODUCTS: usize = 400;
const CREEPS: usize = 2000;
const PAIRS: usize = 40;
/// Where looks are spent, a slope of this is taken: the report says that less may be missed.
const ROUGH: f64 = 1e-3;
/// The sum gets no less where so many steps have brought no more than this share of it.
const PATIENCE: usize = 20;
const STALLED: f64 = 1e-8;
/// The slope is none at this share of what the misses' gradients would be if they all pointed one way: on the path, and at its end.
const FOLLOWED: f64 = 1e-3;
const LEAST: f64 = 1e-10;
/// Where rounding leaves more than that, it is taken up to here.
const TAKEN: f64 = 1e-6;
/// Differences of gradients are taken over this share of the shapes' size: central ones, whose error is its square and the rounding of one over it.
const DIFFERENCE: f64 = 1e-5;
/// How many times as stiff as an equation a bound is.
const STIFF: f64 = 100.0;
/// So many times bounds' multipliers are corrected, and adjustments measured from the last.
const ROUNDS: usize = 20;
/// What a row misses is none at this share of the largest miss, or of the adjustment: what is left of `ε` and of the slope.
const MET: [f64; 2] = [1e-6, 1e-9];

/// The sum of squares, and what it is preconditioned by.
struct Squares {
    /// `1/‖f_k‖` of each row.
    weights: Vec<f64>,
    senses: Vec<Sense>,
    curved: Vec<bool>,
    sides: usize,
    /// Whether equations count.
    equations: bool,
    stiffness: f64,
    /// By how much bounds are given way, and their multipliers, an entry for each row and side.
    given: Vec<f64>,
    forces: Vec<f64>,
    /// `λ`, and the share `ε`.
    largest: f64,
    share: f64,
    inverse: InverseMetric,
    work: Vec<f64>,
}

/// An adjustment `d` and `W d`.
#[derive(Debug, Clone)]
struct Place {
    d: Vec<f64>,
    dual: Vec<f64>,
}

impl Place {
    fn zero(width: usize) -> Self {
        Self { d: vec![0.0; width], dual: vec![0.0; width] }
    }

    fn plus(&self, by: f64, other: &Self) -> Self {
        let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a + by * b).collect();
        Self { d: sum(&self.d, &other.d), dual: sum(&self.dual, &other.dual) }
    }

    /// `dᵀWd`
    fn square(&self) -> f64 {
        dot(&self.d, &self.dual).max(0.0)
    }

    fn with(&self, other: &Self) -> f64 {
        dot(&self.d, &other.dual)
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn amax(v: &[f64]) -> f64 {
    v.iter().fold(0.0, |m, v| m.max(v.abs()))
}

/// `out += Σ c_k f_k`
fn add_rows(rows: &SparseRows, sides: usize, factors: &[f64], out: &mut [f64]) {
    for (row, factors) in factors.chunks_exact(sides).enumerate() {
        for (side, factor) in factors.iter().enumerate().filter(|(_, factor)| **factor != 0.0) {
            rows.iter_row(row).for_each(|(column, value)| out[column * sides + side] += factor * value);
        }
    }
}

impl Squares {
    fn new(here: &Linearized, senses: Vec<Sense>, curved: Vec<bool>) -> Result<Self, SolveError> {
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
    fn weigh(&mut self, rows: &SparseRows) {
        for (row, weight) in self.weights.iter_mut().enumerate().filter(|(_, weight)| **weight == 0.0) {
            let norm = rows.norm(row);
            if norm > 0.0 && norm.is_finite() {
                *weight = (1.0 / norm).min(f64::MAX);
            }
        }
    }

    /// `λ`, by its powers.
    fn eigenvalue(&mut self, rows: &SparseRows) -> f64 {
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
    fn raise(&mut self, dual: &[f64]) -> Vec<f64> {
        let mut d = vec![0.0; dual.len()];
        self.inverse.apply(dual, self.sides, &mut d, &mut self.work);
        d
    }

    /// What an entry misses beyond what it is given way, on the side of its bound that is wrong, as a length; an equation with its sign.
    fn length(&self, entry: usize, rhs: f64) -> f64 {
        let weight = self.weights[entry / self.sides];
        match self.senses[entry / self.sides] {
            Sense::Equal => weight * rhs,
            Sense::AtLeast => weight * (rhs - self.given[entry]),
            Sense::AtMost => weight * (-rhs - self.given[entry]),
        }
    }

    /// How stiff an entry is, and its length with the part of its multiplier, signed like `rhs`; nothing where it does not count.
    fn pull(&self, entry: usize, rhs: f64) -> Option<(f64, f64)> {
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
    fn half(&self, rhs: &[f64]) -> f64 {
        let each = rhs.iter().enumerate().filter_map(|(entry, rhs)| self.pull(entry, *rhs));
        each.map(|(stiff, pull)| 0.5 * stiff * pull * pull).sum()
    }

    /// `-stiffness · pull · weight` of each entry: the factors of the rows in the gradient.
    fn factors(&self, rhs: &[f64]) -> Vec<f64> {
        let of = |(entry, rhs): (usize, &f64)| {
            let (stiff, pull) = self.pull(entry, *rhs)?;
            Some(-stiff * pull * self.weights[entry / self.sides])
        };
        rhs.iter().enumerate().map(|each| of(each).unwrap_or(0.0)).collect()
    }
}

/// Where a search has come to, and from where it is measured.
struct Search {
    squares: Squares,
    at: Place,
    from: Place,
    steps: usize,
    looks: usize,
    most: usize,
    shortened: usize,
    /// The slope that was left, as a share; whether the sum gets no less all the same.
    slope: f64,
    settled: bool,
}

/// The sum and its slope at a place.
struct Downhill {
    value: f64,
    down: Place,
    /// Of the rows in it.
    factors: Vec<f64>,
    noise: f64,
}

impl<S: Shape> Session<S> {
    /// The least squares of what is missed, where what is asked cannot all hold for the reason given. The shapes are as they were
    /// where it fails.
    #[cold]
    pub(super) fn least_squares(&mut self, why: EditError) -> Result<(), EditError> {
        let conflict = matches!(
            why,
            EditError::Solve(
                SolveError::Conflict { .. }
                    | SolveError::NotConverged { .. }
                    | SolveError::StillMoving { .. }
                    | SolveError::IllConditioned { .. }
                    | SolveError::NearConflict { .. }
            )
        );
        if !(conflict && self.problem.best_effort) || self.alternating.is_some() {
            return Err(why);
        }
        let state = snapshot(&self.problem.shapes, &self.prepared);
        let d = self.prepared.d.clone();
        let result = self.least_squares_from_start();
        if result.is_err() {
            put(&mut self.problem.shapes, &state);
            self.prepared.d = d;
        }
        result
    }

    fn least_squares_from_start(&mut self) -> Result<(), EditError> {
        self.restore();
        let here = self.linearize()?;
        let sides = here.assembly.system.sides();
        let constraints: Vec<&Constraint> = self.problem.constraints().collect();
        let senses = senses(&here.assembly, &constraints);
        let curved =
            |row| constraints[here.assembly.constraint_of(row)].functional.linearity() != Linearity::Linear;
        let curved: Vec<bool> = (0..senses.len()).map(curved).collect();
        let bounded = senses.iter().any(|sense| *sense != Sense::Equal);
        let squares = Squares::new(&here, senses, curved)?;
        let width = here.assembly.system.rows().width() * sides;
        let most = super::progress::looks(&self.problem.bound).saturating_mul(4);
        let mut search = Search {
            squares,
            at: Place::zero(width),
            from: Place::zero(width),
            steps: 0,
            looks: 0,
            most,
            shortened: 0,
            slope: 0.0,
            settled: false,
        };
        if bounded {
            self.give_bounds_way(&mut search)?;
        }
        self.follow(&mut search)?;
        // Bounds first, from where the edit began; then what is left of the share.
        for round in 0..if bounded { ROUNDS } else { 0 } {
            let here = self.linearize_at(&search.at)?;
            let moved = search.pull_bounds(&here.rhs);
            if round > 0 && moved <= MET[1] * amax(&search.at.d) {
                break;
            }
            self.descend_squares(&mut search, LEAST)?;
        }
        for _ in 0..3 {
            if search.settled {
                break;
            }
            search.from = search.at.clone();
            if bounded {
                let here = self.linearize_at(&search.at)?;
                search.pull_bounds(&here.rhs);
            }
            self.descend_squares(&mut search, LEAST)?;
        }
        if !(search.is_enough() || search.settled) {
            return Err(self.not_least(&search).into());
        }
        self.hand_out(search)
    }

    /// By how much bounds must be given way: the least squares of what they miss by themselves.
    fn give_bounds_way(&mut self, search: &mut Search) -> Result<(), EditError> {
        search.squares.equations = false;
        self.follow(search)?;
        for _ in 0..3 {
            search.from = search.at.clone();
            self.descend_squares(search, LEAST)?;
        }
        let here = self.linearize_at(&search.at)?;
        let squares = &search.squares;
        let lengths: Vec<f64> = (here.rhs.iter().enumerate())
            .map(|(entry, rhs)| match squares.senses[entry / squares.sides] {
                Sense::Equal => 0.0,
                _ => squares.length(entry, *rhs).max(0.0),
            })
            .collect();
        // What is less than that is met where the search goes on.
        let rounding = 1e3 * MET[1] * amax(&search.at.d);
        let weights = search.squares.weights.clone();
        for (entry, length) in lengths.iter().enumerate().filter(|(_, length)| **length > rounding) {
            search.squares.given[entry] = length / weights[entry / search.squares.sides];
        }
        search.squares.equations = true;
        search.settled = false;
        search.squares.stiffness = STIFF;
        let width = search.at.d.len();
        (search.at, search.from) = (Place::zero(width), Place::zero(width));
        Ok(())
    }

    /// From the shapes as they were along shares that get smaller.
    fn follow(&mut self, search: &mut Search) -> Result<(), EditError> {
        for (step, share) in SHARES.into_iter().enumerate() {
            search.squares.share = share;
            self.descend_squares(search, if step + 1 < SHARES.len() { FOLLOWED } else { LEAST })?;
        }
        Ok(())
    }

    /// The constraints where an adjustment leads.
    fn linearize_at(&mut self, at: &Place) -> Result<Linearized, EditError> {
        self.prepared.d.copy_from_slice(&at.d);
        self.place();
        self.linearize()
    }

    /// The sum and its slope `∇/‖·‖` where the search is: `W⁻¹∇` and `∇`.
    fn slope(search: &mut Search, here: &Linearized) -> Result<Downhill, EditError> {
        let pull = search.squares.share * search.squares.largest;
        let way = search.at.plus(-1.0, &search.from);
        let factors = search.squares.factors(&here.rhs);
        let mut slope: Vec<f64> = way.dual.iter().map(|w| pull * w).collect();
        add_rows(here.assembly.system.rows(), search.squares.sides, &factors, &mut slope);
        let down = Place { d: search.squares.raise(&slope), dual: slope };
        let half = search.squares.half(&here.rhs);
        let value = half + 0.5 * pull * way.square();
        let sides = search.squares.sides;
        let sizes =
            here.size.iter().enumerate().map(|(entry, size)| search.squares.weights[entry / sides] * size);
        let rounding = sizes.fold(0.0, f64::max);
        // `‖Jᵀm‖ ≤ √λ ‖m‖`; what a miss of rounding would pull is none.
        let root = search.squares.largest.sqrt();
        let most = root * (2.0 * half).sqrt() + pull * way.square().sqrt() + 1e-4 * root * rounding;
        search.slope = if most > 0.0 { down.square().sqrt() / most } else { 0.0 };
        if !(search.slope.is_finite() && value.is_finite()) {
            return Err(crate::problem::solution::overflow());
        }
        // Less than the sum's own rounding is neither gained nor lost.
        let noise = 1e-12 * value + 1e-16 * rounding * rounding;
        Ok(Downhill { value, down, factors, noise })
    }

    /// Newton's method with a trust region, until the slope is `slight`; at the end of the path, where that does not arrive, slower.
    fn descend_squares(&mut self, search: &mut Search, slight: f64) -> Result<(), EditError> {
        let mut here = self.linearize_at(&search.at)?;
        search.looks += 2;
        search.squares.weigh(here.assembly.system.rows());
        let mut downhill = Self::slope(search, &here)?;
        // Ten times as far as the stiffest row would send it, or a part of the way that it has come.
        let mut radius =
            10.0 * downhill.down.square().sqrt() / search.squares.largest + 0.1 * search.at.square().sqrt();
        for _ in 0..STEPS {
            if search.slope <= slight || search.squares.largest == 0.0 {
                return Ok(());
            }
            if search.looks >= search.most {
                return if search.is_enough() { Ok(()) } else { Err(self.not_least(search).into()) };
            }
            let (step, promised) = self.newton(search, &here, &downhill.factors, &downhill.down, radius)?;
            search.steps += 1;
            let (before, length) = (search.at.clone(), step.square().sqrt());
            search.at = before.plus(1.0, &step);
            let near = promised <= 1e3 * downhill.noise;
            let reached =
                if near { Some(downhill.value) } else { self.squares_at(search, &here, &search.at.clone()) };
            search.looks += 1;
            let gained = reached.map_or(f64::NEG_INFINITY, |reached| downhill.value - reached);
            if !near && gained < 0.1 * promised {
                search.at = before;
                search.shortened += 1;
                radius = 0.25 * length.min(radius);
                if radius <= 1e-12 * (search.at.square().sqrt() + length) {
                    break;
                }
                continue;
            }
            if gained >= 0.75 * promised && length >= 0.9 * radius {
                radius *= 4.0;
            }
            let sloped = search.slope;
            let there = self.linearize_at(&search.at)?;
            search.looks += 2;
            search.squares.weigh(there.assembly.system.rows());
            let next = Self::slope(search, &there)?;
            // Where the sum is rounding, the slope tells.
            if near && search.slope > 0.5 * sloped {
                search.at = before;
                search.slope = sloped;
                break;
            }
            (here, downhill) = (there, next);
        }
        if slight > LEAST || search.slope <= TAKEN {
            return Ok(());
        }
        self.creep(search)?;
        if search.slope <= LEAST {
            return Ok(());
        }
        if search.looks >= search.most && !search.is_enough() {
            return Err(self.not_least(search).into());
        }
        search.settled = true;
        Ok(())
    }

    /// The same where the sum has no second derivatives (where a piece of a curve has shrunk to a point, its length has none), by the
    /// limited-memory method of Broyden, Fletcher, Goldfarb and Shanno with weak Wolfe steps, which arrives there all the same (Lewis and
    /// Overton 2013): until the slope is none or the sum gets no less.
    fn creep(&mut self, search: &mut Search) -> Result<(), EditError> {
        let here = self.linearize_at(&search.at)?;
        let mut downhill = Self::slope(search, &here)?;
        let mut memory: Vec<(Place, Vec<f64>, f64)> = Vec::new();
        let mut values = vec![downhill.value];
        for _ in 0..CREEPS {
            if search.slope <= LEAST || search.looks >= search.most {
                return Ok(());
            }
            // H ∇ by two loops (Nocedal 1980), with γ W⁻¹ in the middle.
            let mut dual = downhill.down.dual.clone();
            let mut shares = Vec::with_capacity(memory.len());
            for (step, bend, product) in memory.iter().rev() {
                let share = dot(&step.d, &dual) / product;
                dual.iter_mut().zip(bend).for_each(|(q, y)| *q -= share * y);
                shares.push(share);
            }
            let mut way = Place { d: search.squares.raise(&dual), dual };
            if let Some((_, bend, product)) = memory.last() {
                let gamma = product / dot(&search.squares.raise(bend), bend);
                way = Place::zero(way.d.len()).plus(gamma, &way);
            } else {
                way = Place::zero(way.d.len()).plus(1.0 / search.squares.largest, &way);
            }
            for ((step, bend, product), share) in memory.iter().zip(shares.iter().rev()) {
                let back = dot(bend, &way.d) / product;
                way = way.plus(share - back, step);
            }
            let slope = -dot(&way.d, &downhill.down.dual);
            if slope >= 0.0 || slope.is_nan() {
                if memory.is_empty() {
                    break;
                }
                memory.clear();
                continue;
            }
            let (from, sloped) = (search.at.clone(), search.slope);
            let (mut low, mut high, mut share) = (0.0, f64::INFINITY, 1.0);
            let mut found = None;
            for _ in 0..50 {
                search.at = from.plus(-share, &way);
                search.looks += 2;
                let there = self.linearize_at(&search.at).and_then(|there| Self::slope(search, &there));
                match there {
                    Ok(next) if next.value <= downhill.value + 1e-4 * share * slope => {
                        if -dot(&way.d, &next.down.dual) < 0.9 * slope {
                            low = share;
                            found = Some((next, search.at.clone(), search.slope));
                        } else {
                            found = Some((next, search.at.clone(), search.slope));
                            break;
                        }
                    }
                    _ => high = share,
                }
                share = if high.is_finite() { 0.5 * (low + high) } else { 2.0 * share };
                if high.is_finite() && high - low <= 1e-10 * high {
                    break;
                }
            }
            search.steps += 1;
            let Some((next, at, slope)) = found else {
                // Nothing less along this way: nor along the steepest one, or from there again.
                (search.at, search.slope) = (from, sloped);
                if memory.is_empty() {
                    break;
                }
                memory.clear();
                continue;
            };
            (search.at, search.slope) = (at, slope);
            let step = search.at.plus(-1.0, &from);
            let bend: Vec<f64> = next.down.dual.iter().zip(&downhill.down.dual).map(|(a, b)| a - b).collect();
            let product = dot(&step.d, &bend);
            if product > 0.0 {
                if memory.len() == PAIRS {
                    memory.remove(0);
                }
                memory.push((step, bend, product));
            }
            downhill = next;
            values.push(downhill.value);
            if let Some(earlier) = values.len().checked_sub(PATIENCE + 1).map(|k| values[k])
                && earlier - downhill.value <= STALLED * downhill.value
            {
                break;
            }
        }
        Ok(())
    }

    /// The sum where an adjustment leads; nothing where something cannot be asked there.
    fn squares_at(&mut self, search: &Search, here: &Linearized, at: &Place) -> Option<f64> {
        self.prepared.d.copy_from_slice(&at.d);
        if !self.place() {
            return None;
        }
        let (mut rhs, mut size) = (Numbers::new(), Numbers::new());
        let shapes = view(&self.problem.shapes);
        right_hand_side(&shapes, &self.problem.bound, &here.assembly, &mut rhs, &mut size).ok()?;
        let way = at.plus(-1.0, &search.from);
        let value =
            search.squares.half(&rhs) + 0.5 * search.squares.share * search.squares.largest * way.square();
        value.is_finite().then_some(value)
    }

    /// A step of Newton's method within a radius, by conjugate gradients, and what it promises.
    fn newton(
        &mut self,
        search: &mut Search,
        here: &Linearized,
        factors: &[f64],
        down: &Place,
        radius: f64,
    ) -> Result<(Place, f64), EditError> {
        let mut step = Place::zero(down.d.len());
        let (mut promised, mut left) = (0.0, Place::zero(down.d.len()).plus(-1.0, down));
        let mut way = left.clone();
        let first = left.square();
        let slight = search.slope.sqrt().clamp(1e-6, 0.1);
        let mut square = first;
        for _ in 0..PRODUCTS {
            let bent = self.product(search, here, factors, &way);
            let curvature = dot(&way.d, &bent);
            let whole = square / curvature;
            // How far it is along the way to the edge: |s + t p|² = r².
            let (a, b, c) = (way.square(), step.with(&way), step.square() - radius * radius);
            let edge = (-b + (b * b - a * c).max(0.0).sqrt()) / a.max(f64::MIN_POSITIVE);
            let share = if curvature > 0.0 && whole < edge { whole } else { edge };
            let along = dot(&left.dual, &way.d);
            promised += share * along - 0.5 * share * share * curvature;
            step = step.plus(share, &way);
            if share == edge {
                break;
            }
            left.dual.iter_mut().zip(&bent).for_each(|(l, b)| *l -= share * b);
            left.d = search.squares.raise(&left.dual);
            let next = left.square();
            if next <= slight * slight * first || next.is_nan() || search.looks >= search.most {
                break;
            }
            way = left.plus(next / square, &way);
            square = next;
        }
        Ok((step, promised))
    }

    /// The Hessian times a way.
    fn product(&mut self, search: &mut Search, here: &Linearized, factors: &[f64], way: &Place) -> Vec<f64> {
        let squares = &search.squares;
        let (rows, sides) = (here.assembly.system.rows(), squares.sides);
        let mut bent: Vec<f64> = way.dual.iter().map(|w| squares.share * squares.largest * w).collect();
        let mut along = vec![0.0; here.rhs.len()];
        rows.multiply(&way.d, sides, &mut along);
        for (entry, along) in along.iter_mut().enumerate() {
            let weight = squares.weights[entry / sides];
            let stiff = squares.pull(entry, here.rhs[entry]).map_or(0.0, |(stiff, _)| stiff);
            *along *= stiff * weight * weight;
        }
        add_rows(rows, sides, &along, &mut bent);
        let curved: Vec<f64> = (factors.iter().enumerate())
            .map(|(entry, factor)| if squares.curved[entry / sides] { *factor } else { 0.0 })
            .collect();
        if curved.iter().all(|factor| *factor == 0.0) {
            return bent;
        }
        let far = amax(&way.d);
        let by = DIFFERENCE * (self.prepared.check.reach + amax(&search.at.d)) / far;
        if !(by.is_finite() && by > 0.0) {
            return bent;
        }
        let mut bow = vec![0.0; bent.len()];
        for sign in [1.0, -1.0] {
            search.looks += 2;
            self.prepared.d.copy_from_slice(&search.at.plus(sign * by, way).d);
            self.place();
            // Where something cannot be asked there, its bend is not known.
            let Ok(there) = self.problem.assemble(false) else { return bent };
            if there.system.rows().len() != rows.len() || there.system.rows().width() != rows.width() {
                return bent;
            }
            let factors: Vec<f64> = curved.iter().map(|factor| 0.5 * sign * factor / by).collect();
            add_rows(there.system.rows(), sides, &factors, &mut bow);
        }
        if bow.iter().all(|b| b.is_finite()) {
            bent.iter_mut().zip(bow).for_each(|(b, bow)| *b += bow);
        }
        bent
    }

    /// What was found, with the rows that nothing contradicts met to rounding, for reports and for the next event.
    fn hand_out(&mut self, search: Search) -> Result<(), EditError> {
        let Search { squares, at, steps, shortened, slope, .. } = search;
        let mut here = self.linearize_at(&at)?;
        let lengths = |rhs: &[f64]| -> Vec<f64> {
            rhs.iter().enumerate().map(|(entry, rhs)| squares.length(entry, *rhs)).collect()
        };
        let missed = lengths(&here.rhs);
        let equal = |row: usize| squares.senses[row] == Sense::Equal;
        let pulls = squares.forces.iter().any(|force| *force > 0.0);
        let largest = missed.iter().enumerate().map(|(entry, miss)| {
            if equal(entry / squares.sides) {
                miss.abs()
            } else {
                squares.given[entry] * squares.weights[entry / squares.sides]
            }
        });
        let slight = MET[0] * largest.fold(0.0, f64::max) + MET[1] * amax(&at.d);
        let of = |row: usize| row * squares.sides..(row + 1) * squares.sides;
        let active: Vec<usize> = (0..squares.senses.len())
            .filter(|&row| !equal(row) && of(row).any(|entry| missed[entry] >= -slight))
            .collect();
        // Bounds that are touched hold to rounding, on whichever side of them the search has stopped; one that pulls does, whatever the search has left.
        let met: Vec<usize> = (0..squares.senses.len())
            .filter(|&row| {
                let pulled = of(row).any(|entry| squares.forces[entry] > 0.0);
                of(row).all(|entry| (pulled || missed[entry].abs() <= slight) && squares.given[entry] == 0.0)
            })
            .collect();
        for _ in 0..4 {
            let part = here.assembly.select(&met);
            let mut factored = self.solver.factor(&part.system)?;
            let rhs: Numbers = met.iter().flat_map(|&row| of(row)).map(|entry| here.rhs[entry]).collect();
            let mut d = vec![0.0; at.d.len()];
            factored.solve_into(&rhs, &mut d);
            // More than what the search left is not rounding: what it would meet depends on what cannot hold.
            if !(pulls || amax(&d) <= 1e3 * (slight + MET[1] * self.prepared.check.reach)) {
                break;
            }
            self.prepared.d.iter_mut().zip(&d).for_each(|(to, d)| *to += d);
            self.place();
            here = self.linearize()?;
            if amax(&d) <= f64::EPSILON * self.prepared.check.reach {
                break;
            }
        }
        let mut wanted = Numbers::from_elem(0.0, here.rhs.len());
        here.assembly.system.rows().multiply(&self.prepared.d, squares.sides, &mut wanted);
        wanted.iter_mut().zip(&here.rhs).for_each(|(w, b)| *w += b);
        let kept: Vec<usize> = (0..squares.senses.len())
            .filter(|row| equal(*row) || active.binary_search(row).is_ok())
            .collect();
        let part = here.assembly.select(&kept);
        let factored = self.solver.factor(&part.system)?;
        let dependencies = factored.diagnosis().dependencies;
        let gather = |all: &[f64]| -> Numbers {
            kept.iter().flat_map(|&row| of(row)).map(|entry| all[entry]).collect()
        };
        let prepared = self.prepared.as_mut();
        (prepared.rhs, prepared.size) = (gather(&wanted), gather(&here.size));
        (prepared.factored, prepared.dependencies, prepared.assembly) = (factored, dependencies, part);
        let bounds = Bounds { full: here.assembly, rhs: wanted, size: here.size, active };
        match &mut prepared.strategy {
            Strategy::Bounded(own) => own.active = bounds.active,
            strategy => {
                let bounded = squares.senses.iter().any(|sense| *sense != Sense::Equal);
                *strategy = Strategy::Sequential(bounded.then_some(bounds));
            }
        }
        prepared.iterations = steps.max(1);
        prepared.convergence = Some(Convergence { iterations: steps, shortened, change: slope });
        prepared.gave_way = true;
        Ok(())
    }

    fn not_least(&self, search: &Search) -> SolveError {
        let curved =
            self.problem.bound.iter().filter(|b| b.constraint.functional.linearity() != Linearity::Linear);
        let named: Vec<String> = curved.map(|b| quoted(&b.constraint.label())).collect();
        SolveError::NotLeast { iterations: search.steps, slope: search.slope, beside: named.join(", ") }
    }
}

impl Search {
    /// Whether the slope that is left is little enough, or as little as looks allowed.
    fn is_enough(&self) -> bool {
        self.slope <= if self.looks >= self.most { ROUGH } else { TAKEN }
    }

    /// Corrects the multipliers of bounds by what these miss, and says by how much they do (touched ones, on either side).
    fn pull_bounds(&mut self, rhs: &[f64]) -> f64 {
        let mut moved = 0.0_f64;
        for (entry, rhs) in rhs.iter().enumerate() {
            if self.squares.senses[entry / self.squares.sides] != Sense::Equal {
                let before = self.squares.forces[entry];
                let after = (before + self.squares.stiffness * self.squares.length(entry, *rhs)).max(0.0);
                self.squares.forces[entry] = after;
                moved = moved.max((after - before).abs() / self.squares.stiffness);
            }
        }
        moved
    }
}
