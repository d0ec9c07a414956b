//! Velocities where things are: steps know them half a step behind.

use loftsman_kernel::Vector;

use super::Simulation;
use crate::scheme::Scheme;

/// What looking changes, and is put back; its room is kept.
#[derive(Debug, Default)]
pub(crate) struct Aside {
    acceleration: Vec<f64>,
    /// Accelerations and multipliers of links, one after another.
    numbers: Vec<f64>,
}

impl Simulation {
    /// Puts velocities into the shapes of velocities as leapfrogs have them where things are, `v_n = v_{n-1/2} + ½ h M⁻¹Q(q_n)`: by the forces there and not by those of
    /// the step before, whose energy would be told as rising by three times as much as it does. What acts there is what has acted until now. Nothing else changes. Gives `aᵀMa`, `a` being the accelerations
    /// there; 0 of implicit steps, whose velocities are where things are. `O(n)`, as much as a step.
    pub(super) fn velocities_here(&mut self) -> f64 {
        if self.scheme == Scheme::Implicit || self.settling {
            self.predict();
            return 0.0;
        }
        let mut aside = std::mem::take(&mut self.aside);
        aside.acceleration.clone_from(&self.acceleration);
        aside.numbers.clear();
        for link in &self.links {
            aside.numbers.extend_from_slice(&link.accelerations);
            aside.numbers.extend_from_slice(&link.multipliers);
            aside.numbers.push(link.error);
        }
        let kept = (self.worst, self.fineness, self.patience, self.rank, self.late);
        let step = if self.last > 0.0 { self.last } else { self.limit() };
        self.late = 0.5 * self.last;
        // Where forces of constraints cannot be found, those of the step before are the best there are.
        let square = match self.accelerate(step) {
            Ok(()) => self.square_of_acceleration(),
            Err(_) => {
                self.acceleration.copy_from_slice(&aside.acceleration);
                0.0
            }
        };
        self.predict();
        self.acceleration.copy_from_slice(&aside.acceleration);
        let mut numbers = &aside.numbers[..];
        for link in &mut self.links {
            for all in [
                &mut link.accelerations[..],
                &mut link.multipliers[..],
                std::slice::from_mut(&mut link.error),
            ] {
                let (own, others) = numbers.split_at(all.len());
                all.copy_from_slice(own);
                numbers = others;
            }
        }
        (self.worst, self.fineness, self.patience, self.rank, self.late) = kept;
        self.aside = aside;
        square
    }

    fn square_of_acceleration(&self) -> f64 {
        let mut all = 0.0;
        for body in &self.bodies {
            let Some(mass) = &body.mass else { continue };
            let a = &self.acceleration[body.range()];
            for (i, own) in a.chunks_exact(3).enumerate() {
                let force = mass.matrix.row(i).fold(Vector::zeros(), |sum, (j, m)| {
                    sum + Vector::new(a[3 * j], a[3 * j + 1], a[3 * j + 2]) * m
                });
                all += (0..3).map(|axis| own[axis] * force[axis]).sum::<f64>();
            }
        }
        all
    }
}
