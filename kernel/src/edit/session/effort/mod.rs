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

mod creep;
mod handed_out;
mod newton;
mod squares;

use self::squares::{Place, Squares, amax};
use super::sequential::Linearized;
use super::{Session, put, snapshot};
use crate::functional::Linearity;
use crate::problem::EditError;
use crate::problem::conflict::quoted;
use crate::problem::constraint::Constraint;
use crate::problem::program::senses;
use crate::shape::Shape;
use crate::solve::{Sense, SolveError};

/// The shares `ε` of the adjustment, from a path that is easily followed to one that leaves the misses alone.
const SHARES: [f64; 4] = [1e-2, 1e-4, 1e-6, 1e-8];
/// Where looks are spent, a slope of this is taken: the report says that less may be missed.
const ROUGH: f64 = 1e-3;
/// The slope is none at this share of what the misses' gradients would be if they all pointed one way: on the path, and at its end.
const FOLLOWED: f64 = 1e-3;
const LEAST: f64 = 1e-10;
/// Where rounding leaves more than that, it is taken up to here.
const TAKEN: f64 = 1e-6;
/// How many times as stiff as an equation a bound is.
const STIFF: f64 = 100.0;
/// So many times bounds' multipliers are corrected, and adjustments measured from the last.
const ROUNDS: usize = 20;
/// What a row misses is none at this share of the largest miss, or of the adjustment: what is left of `ε` and of the slope.
const MET: [f64; 2] = [1e-6, 1e-9];

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
