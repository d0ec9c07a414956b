//! Whether energy comes from nowhere.

use super::Simulation;

/// How much energy rises where nothing is put in, looked at from time to time: of motion, stretching, shearing, bending, weight, forces and pulls together.
///
/// Explicit steps are leapfrogs with `h ω ≤ 1`. Of a linear motion of frequency `ω` they keep `T + (1 - (hω)²/4) V` (Hairer, Lubich and Wanner 2006, I.5), so that what is
/// measured, `T + V`, rises by no more than `1/(1 - (hω)²/4) - 1 ≤ 1/3` of it, and that only of what swings at the highest frequency there is; of what is
/// stretched and turns they stay near to an energy of this kind. Baumgarte's terms put in what constraints drift by, times their forces. Implicit steps take
/// energy out where the energy is convex, and put in no more than that where slack pushes. The bound that is tested, for all of them: a third of [`most`](Self::most).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Audit {
    lowest: Option<f64>,
    rise: f64,
    most: f64,
}

impl Audit {
    /// Looks at the energy now. `O(n)`.
    pub fn look(&mut self, simulation: &mut Simulation) {
        let energy = simulation.energy();
        let now = energy.kinetic + simulation.potential().0;
        let lowest = self.lowest.get_or_insert(now);
        *lowest = lowest.min(now);
        self.rise = self.rise.max(now - *lowest);
        self.most = self.most.max(energy.kinetic + energy.elastic + energy.pulls);
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
    /// Whether energy is put in or taken out from outside, now or later: targets that move, constraints and loads that come or go, what constraints still draw in.
    pub fn is_fed(&self) -> bool {
        self.links.iter().any(|link| link.feeds(self.time)) || self.loads.iter().any(crate::load::Load::feeds)
    }
}
