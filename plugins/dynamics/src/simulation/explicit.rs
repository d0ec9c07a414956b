//! Leapfrog steps: velocities half a step behind places, so that both are of second order; constraints stabilised after Baumgarte.

use super::{Simulation, shapes};
use crate::error::{DynamicsError, Result};
use crate::scheme::Scheme;

/// The time constant of Baumgarte's terms, in steps: they are stable up to 1.2 and drift no more.
const STEADY: f64 = 2.0;
/// Constraints may drift by this share of the size before steps are made shorter, down to that share of what is stable, or of the whole way where that is shorter.
const DRIFT: f64 = 3e-7;
pub(super) const FINEST: f64 = 3e-3;
/// Steps between changes of their length.
const PATIENCE: usize = 20;

impl Simulation {
    /// A leapfrog step: forces where things are, velocities between. It stops where a place comes to a corner of its shape, and goes on from there.
    pub(super) fn step_explicitly(&mut self, step: f64) -> Result<()> {
        self.stand_on_corners();
        let (start, mut left) = (self.time, step);
        for stops in 0.. {
            self.accelerate(step)?;
            let stays = Self::too_many(stops);
            if !stays && self.leave_corners_in_motion()? {
                self.accelerate(step)?;
            }
            let Some(way) = self.next_stop(left) else { break };
            let kick = 0.5 * (self.last + way);
            self.kick(kick);
            self.drift(way, kick);
            (self.last, self.time) = (way, self.time + way);
            self.put_on_stops();
            self.pauses += 1;
            // By the tangent on which it came.
            self.catch_up_in(step)?;
            self.strike(stays)?;
            left -= way;
        }
        let kick = 0.5 * (self.last + left);
        self.kick(kick);
        self.drift(left, kick);
        (self.last, self.time) = (left, start);
        Ok(())
    }

    /// Brings velocities, which are half a step behind, to where things are, by the forces that have acted until now: before others do.
    pub(super) fn catch_up(&mut self) -> Result<()> {
        self.catch_up_in(self.last)
    }

    /// The same, constraints stabilised as in steps of this length.
    fn catch_up_in(&mut self, step: f64) -> Result<()> {
        if self.last == 0.0 {
            return Ok(());
        }
        let kick = 0.5 * self.last;
        self.late = kick;
        let done = self.accelerate(step);
        self.late = 0.0;
        done?;
        self.kick(kick);
        for link in self.links.iter_mut().filter(|link| link.is_held()) {
            link.rates.iter_mut().zip(&link.accelerations).for_each(|(rate, a)| *rate += kick * a);
        }
        self.last = 0.0;
        Ok(())
    }

    /// The accelerations where things are, of all and of what slides; for a step of this length.
    pub(super) fn accelerate(&mut self, step: f64) -> Result<()> {
        self.predict();
        for link in self.links.iter_mut().filter(|link| link.is_held()) {
            let ahead = 0.5 * self.last;
            // For what is quadratic in velocities, these are now; Baumgarte's terms look at those half a step behind.
            link.rates.iter_mut().zip(&link.accelerations).for_each(|(rate, a)| *rate += ahead * a);
        }
        let mut desk = std::mem::take(&mut self.desk);
        let collected = self.collect(&mut desk);
        for link in self.links.iter_mut().filter(|link| link.is_held()) {
            let ahead = 0.5 * self.last;
            link.rates.iter_mut().zip(&link.accelerations).for_each(|(rate, a)| *rate -= ahead * a);
        }
        let held = self.links.iter().filter(|link| link.is_held());
        self.rates.clear();
        self.rates.extend(held.flat_map(|link| &link.rates));
        self.desk = desk;
        collected?;
        self.look_for_vanished()?;
        self.gather_forces();
        self.gap_rates.clear();
        self.gap_rates.resize(self.space.equations(), 0.0);
        self.space.apply(&self.half, &self.rates, &mut self.gap_rates);
        // What velocities miss half a long step behind is not for a short one to put right at once.
        self.ask(step.max(0.5 * (self.last + step)));
        self.rank = self.space.factor();
        let equations = self.space.equations();
        self.multipliers.resize(equations, 0.0);
        self.acceleration.copy_from_slice(&self.forces);
        self.space.solve(&mut self.acceleration, &self.right, &mut self.multipliers, &mut self.rates);
        let mut parameter = 0;
        for link in self.links.iter_mut().filter(|link| link.is_held()) {
            link.multipliers.copy_from_slice(&self.multipliers[link.first..link.first + link.equations]);
            let count = link.rates.len();
            link.accelerations.copy_from_slice(&self.rates[parameter..parameter + count]);
            parameter += count;
        }
        Ok(())
    }

    /// What is only followed and has no mass must be somewhere.
    fn look_for_vanished(&mut self) -> Result<()> {
        if self.scheme == Scheme::Epsilon {
            return Ok(());
        }
        let shapes = shapes(&self.bodies);
        for link in self.links.iter_mut().filter(|link| link.is_held() && !link.slides.is_empty()) {
            if link.vanishes(&shapes)? {
                return Err(DynamicsError::Vanishes { constraint: link.name.clone(), time: self.time });
            }
        }
        Ok(())
    }

    fn kick(&mut self, kick: f64) {
        for (v, a) in self.half.iter_mut().zip(&self.acceleration) {
            *v += kick * a;
        }
    }

    /// `E`: what the constraints' accelerations are to be, with Baumgarte's terms; how much they miss now.
    fn ask(&mut self, step: f64) {
        let pull = 1.0 / (STEADY * step);
        let Self { desk, right, gap_rates, links, time, worst, .. } = self;
        let mut drift = 0.0_f64;
        right.clear();
        for link in links.iter_mut().filter(|link| link.is_held()) {
            link.error = 0.0;
            let drawn = link.is_drawn_in(*time);
            for equation in link.first..link.first + link.equations {
                let [let_go, rate, acceleration] = link.offset(equation - link.first, *time);
                let gap = desk.gap[equation] - let_go;
                let gap_rate = gap_rates[equation] - desk.target_rate[equation] - rate;
                right.push(
                    desk.target_acceleration[equation] + acceleration
                        - desk.curving[equation]
                        - 2.0 * pull * gap_rate
                        - pull * pull * gap,
                );
                link.error = link.error.max(desk.gap[equation].abs());
                drift = drift.max(gap.abs());
                if drawn && *time > 0.0 {
                    *worst = worst.max(gap.abs());
                }
            }
        }
        // Drift is of fourth order in the step: a little shorter is a lot less.
        // What there is dies away first.
        self.patience = self.patience.saturating_sub(1);
        if self.patience == 0 && drift > DRIFT * self.size && self.fineness > self.finest {
            (self.fineness, self.patience) = (0.7 * self.fineness, PATIENCE);
        } else if self.patience == 0 && drift < 0.03 * DRIFT * self.size && self.fineness < 1.0 {
            (self.fineness, self.patience) = ((1.2 * self.fineness).min(1.0), PATIENCE);
        }
    }

    /// Steps are no longer than this for some time; whether they become shorter by that.
    pub(super) fn shorten(&mut self, to: f64) -> bool {
        let fineness = (to / self.reach).max(self.finest);
        let shorter = fineness < self.fineness;
        if shorter {
            (self.fineness, self.patience) = (fineness, PATIENCE);
        }
        shorter
    }

    /// Moves all by their velocities, and parameters by theirs.
    pub(crate) fn drift(&mut self, step: f64, kick: f64) {
        for body in self.bodies.iter_mut().filter(|body| body.mass.is_some()) {
            let velocities = &self.half[body.range()];
            let vertices = body.body.shape.control_vertices_mut().iter_mut();
            for (vertex, v) in vertices.zip(velocities.chunks_exact(3)) {
                (0..3).for_each(|axis| vertex[axis] += step * v[axis]);
            }
        }
        let time = self.time + step;
        for link in self.links.iter_mut().filter(|link| link.is_held()) {
            let mut by = [0.0; 4];
            for ((by, rate), a) in by.iter_mut().zip(&mut link.rates).zip(&link.accelerations) {
                *rate += kick * a;
                *by = step * *rate;
            }
            link.slide(&by, time);
        }
    }
}
