//! Whether energy comes from nowhere.

use super::{Moving, Simulation};

/// How much energy rises where nothing is put in, looked at from time to time: of motion, stretching, shearing, bending, weight, forces and pulls together.
///
/// Explicit steps are leapfrogs with `h ω ≤ 1`. Of a linear motion of frequency `ω` they keep `T + (1 - (hω)²/4) V` (Hairer, Lubich and Wanner 2006, I.5), so that what is
/// measured, `T + V`, rises by no more than `1/(1 - (hω)²/4) - 1 ≤ 1/3` of it, and that only of what swings at the highest frequency there is; of what is
/// stretched and turns they stay near to an energy of this kind; where something folds, which turns within a step, what rises is put right by [`advance`](Simulation::advance) in shorter
/// steps. Baumgarte's terms put in what constraints drift by, times their forces. Implicit steps take
/// energy out where the energy is convex, and put in no more than that where slack pushes. The bound that is tested, for all of them: a third of [`most`](Self::most).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Audit {
    lowest: Option<f64>,
    rise: f64,
    most: f64,
    /// Energies of less than this are what rounding makes.
    noise: f64,
}

/// Without input energy rises by no more than this share of what moves and is stretched.
pub(crate) const BOUND: f64 = 1.0 / 3.0;
/// Sums of energies are rounded by this share of their parts.
const ROUNDED: f64 = 1e-13;

impl Audit {
    /// Looks at the energy now. `O(n)`.
    pub fn look(&mut self, simulation: &mut Simulation) {
        let energy = simulation.energy();
        let (potential, parts) = simulation.potential();
        let now = energy.kinetic + potential;
        let lowest = self.lowest.get_or_insert(now);
        *lowest = lowest.min(now);
        self.rise = self.rise.max(now - *lowest);
        self.most = self.most.max(energy.kinetic + energy.elastic + energy.pulls);
        self.noise = self.noise.max(ROUNDED * (energy.kinetic + parts)).max(simulation.rounding_of_energy());
    }

    /// Whether nothing has moved or been stretched by more than what rounding makes, so that there is nothing to say of how energy rose.
    pub fn is_noise(&self) -> bool {
        self.most <= self.noise
    }

    /// Whether energy rose by more than the bound that is stated: then what moved is worth nothing.
    pub fn is_broken(&self) -> bool {
        !self.is_noise() && self.rise > BOUND * self.most + self.noise
    }

    /// The most that was in motion, stretch and pulls together.
    pub fn most(&self) -> f64 {
        self.most
    }

    /// How far it rose above the lowest that it had been before, as a share of [`most`](Self::most); 0 where nothing moves and nothing is stretched.
    pub fn rise(&self) -> f64 {
        if self.most > 0.0 { self.rise / self.most } else { 0.0 }
    }
}

impl Simulation {
    /// By how much elastic energy may differ for the rounding of vertices and sums, at most: what forces may, along the whole size. `O(n)`, and it allocates.
    pub(crate) fn rounding_of_energy(&self) -> f64 {
        self.bodies.iter().map(|body| self.rounding_of(body)).sum()
    }

    /// The same of one body.
    pub(super) fn rounding_of(&self, body: &Moving) -> f64 {
        let Some(elastic) = &body.elastic else { return 0.0 };
        let mut rounding = vec![0.0; body.count()];
        elastic.add_rounding(body.body.shape.control_vertices(), &mut rounding);
        rounding.iter().sum::<f64>() * self.size
    }

    /// Whether energy is put in or taken out from outside, now or later: targets that move, constraints and loads that come or go, what constraints still draw in.
    pub fn is_fed(&self) -> bool {
        self.links.iter().any(|link| link.feeds(self.time)) || self.loads.iter().any(crate::load::Load::feeds)
    }
}
