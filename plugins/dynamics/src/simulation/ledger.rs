//! Energy that comes from nowhere is put right as it comes, in shorter steps.
//!
//! Leapfrogs of a linear motion keep `T + V - h²/8 aᵀMa` to rounding (with `(hω)²/4 = x` that is `T + (1 - x) V`), and what stretches and turns nearly: `T + V` swings by
//! up to a quarter of what there is at the highest frequency, and comes back. What does not come back is what this energy gains. It does where a
//! constraint drifts and is drawn back or lets go, and where something folds: a rope that is shorter than half of its rest length, `|P'| < ℓ/2`, has a stiffness
//! across, `k/ℓ (1 - ℓ/|P'|)`, beyond all that bounds the stable step, and through `P' = 0` its force jumps. Frames in which there is such are looked at; where
//! the energy gains more than half of what is left of [`GAINS`], they are taken again by halves, and what cannot be halved in shorter steps.
//!
//! Backward Euler takes energy out where it is convex and what is held is linear. A place that slides makes it curved: the constraint's force at the end of a step does the
//! work `½ λ·g''Δ²` of its way `Δ`, of either sign. So all implicit frames are looked at; they may gain less.

use super::Simulation;
use super::advance::{Before, KEPT};
use super::audit::BOUND;
use crate::error::{DynamicsError, Result};
use crate::scheme::Scheme;

/// Of all that moves and is stretched this may be gained in all: a quarter swings at the highest frequency, a third is the bound.
const GAINS: f64 = BOUND - 0.25;
/// Of implicit steps, which take energy out but where a place slides or turns far in one of them.
const GAINS_IMPLICIT: f64 = 0.01;
/// Pieces of so many steps are not halved, but taken in shorter ones.
const FEW: usize = 8;
/// Each time by this, down to that share of what is stable.
const EACH: f64 = 0.3;
const LEAST: f64 = 3e-3;
/// What is as short, as a share of its length at rest, folds.
const FOLDS: f64 = 0.5;

/// How much energy there is where things are.
#[derive(Debug, Clone, Copy, Default)]
struct Stock {
    time: f64,
    /// Of motion, and of all that has a potential.
    all: f64,
    /// `aᵀMa / 8`.
    square: f64,
    /// Of motion, stretch and pulls.
    moved: f64,
}

/// What energy has gained since nothing is put in.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Ledger {
    /// What it gained that does not come back, and the least of that.
    gained: f64,
    lowest_gain: f64,
    lowest: Option<f64>,
    most: f64,
    /// When it was looked at last.
    seen: Option<Stock>,
}

impl Ledger {
    /// The ledger after such a piece of steps of the length `step`, and whether that is let pass.
    fn with(mut self, start: Stock, now: Stock, (step, gains): (f64, f64), noise: f64) -> (Self, bool) {
        let gain = now.all - start.all - step * step * (now.square - start.square);
        let lowest = self.lowest.unwrap_or(start.all).min(start.all);
        self.most = self.most.max(start.moved).max(now.moved);
        let left = gains * self.most - (self.gained - self.lowest_gain);
        let small = gain <= 0.5 * left.max(0.0) + noise;
        let bounded = now.all - lowest <= BOUND * self.most + noise;
        self.gained += gain;
        self.lowest_gain = self.lowest_gain.min(self.gained);
        self.lowest = Some(lowest.min(now.all));
        self.seen = Some(now);
        (self, small && bounded)
    }

    /// By which share of what moved and was stretched energy rose.
    fn rise(&self, now: Stock) -> f64 {
        let rise = now.all - self.lowest.unwrap_or(now.all);
        if self.most > 0.0 { rise / self.most } else { 0.0 }
    }
}

impl Simulation {
    /// How much energy there is now. `O(n)`.
    fn stock(&mut self) -> Stock {
        let square = self.velocities_here() / 8.0;
        let energy = self.energy_seen();
        Stock {
            time: self.time,
            all: energy.kinetic + self.potential().0,
            square,
            moved: energy.kinetic + energy.elastic + energy.pulls,
        }
    }

    /// A frame begins. Whether its energy is its own.
    pub(super) fn begin_to_look(&mut self) -> bool {
        self.slackest = f64::INFINITY;
        let alone = !self.is_fed();
        if !alone {
            self.ledger = Ledger::default();
        }
        alone
    }

    /// The length of the last step, and what may be gained in such.
    fn gains(&self) -> (f64, f64) {
        if self.scheme == Scheme::Implicit { (self.length, GAINS_IMPLICIT) } else { (self.last, GAINS) }
    }

    /// Takes the steps since `before` again, shorter, where energy has gained though nothing was put in. They started as fine as `tried`.
    pub(super) fn without_rise(&mut self, seconds: f64, before: &Before, tried: (f64, usize)) -> Result<()> {
        let even = self.worst <= KEPT * self.size && before.is_as_held(self) && self.slackest >= FOLDS;
        if even && self.scheme != Scheme::Implicit {
            return Ok(());
        }
        let start = match self.ledger.seen {
            Some(seen) if before.is_of(seen.time) => seen,
            _ => {
                let mut here = std::mem::take(&mut self.here);
                here.remember(self);
                let (worst, events) = (self.worst, std::mem::take(&mut self.events));
                before.back(self);
                let start = self.stock();
                here.back(self);
                (self.worst, self.events, self.here) = (worst, events, here);
                start
            }
        };
        let now = self.stock();
        let gains = self.gains();
        let mut noise = 0.0;
        let mut looked = self.ledger.with(start, now, gains, noise);
        if !looked.1 {
            noise = self.rounding_of_energy();
            looked = self.ledger.with(start, now, gains, noise);
        }
        if let (ledger, true) = looked {
            self.ledger = ledger;
            return Ok(());
        }
        before.back(self);
        self.worst = 0.0;
        (self.fineness, self.patience) = tried;
        self.piece(seconds, start, noise, true)
    }

    /// Goes on by so many seconds by halves, each of which gains no more than it may; `again` says that they have been tried as they are, in vain.
    fn piece(&mut self, seconds: f64, start: Stock, noise: f64, again: bool) -> Result<()> {
        let mut before = Before::default();
        before.remember(self);
        let end = self.time + seconds;
        let mut length = f64::INFINITY;
        let given = (self.fineness, self.patience);
        let worst = self.worst;
        let mut steps = (seconds / self.limit()).ceil() as usize;
        if !again {
            let taken = self.sub_steps;
            self.go_on(seconds).and_then(|()| self.drifted())?;
            let now = self.stock();
            let (ledger, passes) = self.ledger.with(start, now, self.gains(), noise);
            if passes {
                self.ledger = ledger;
                return Ok(());
            }
            (steps, length) = (self.sub_steps - taken, self.gains().0);
            before.back(self);
            (self.worst, self.fineness, self.patience) = (worst, given.0, given.1);
        }
        if steps > FEW {
            self.piece(0.5 * seconds, start, noise, false)?;
            let middle = self.ledger.seen.filter(|seen| seen.time == self.time);
            let middle = middle.unwrap_or_else(|| self.stock());
            return self.piece(end - self.time, middle, noise, false);
        }
        length = length.min(self.limit()).min(seconds);
        loop {
            length *= EACH;
            let shortest = length < LEAST * self.reach || !self.shorten(length);
            if shortest {
                self.shorten(LEAST * self.reach);
            }
            self.catch_up()?;
            self.go_on(seconds).and_then(|()| self.drifted())?;
            let now = self.stock();
            let (ledger, passes) = self.ledger.with(start, now, self.gains(), noise);
            let rise = ledger.rise(now);
            if passes || shortest && rise <= BOUND {
                self.ledger = ledger;
                (self.fineness, self.patience) = given;
                return Ok(());
            }
            if shortest {
                return Err(self.risen(rise));
            }
            before.back(self);
            self.worst = worst;
        }
    }

    /// The error of energy that comes from nowhere.
    pub(crate) fn risen(&self, rise: f64) -> DynamicsError {
        DynamicsError::Rises {
            time: self.time,
            step: if self.scheme == Scheme::Implicit { self.length } else { self.last },
            stable: self.stable,
            rise,
            implicit: self.scheme == Scheme::Implicit,
            held: self.links.iter().any(crate::link::Link::is_held),
        }
    }
}
