//! Velocities at the start that constraints allow, rates of what slides among them.

use super::Simulation;
use crate::error::Result;

impl Simulation {
    /// Changes the velocities at the start by as little as there is, in the mass metric, so that what is held keeps to what it asks: `½ δvᵀ M δv` least under
    /// `L (v + δv) + L_s ṡ = ` the targets' rates. Rates of what slides are what they come to, and cost nothing; what is on its way slides with it from
    /// the start. To be asked while the space's metric is the mass.
    pub(super) fn project_velocities(&mut self) -> Result<()> {
        for link in &mut self.links {
            link.at_time(self.time);
        }
        // The small mass of scheme epsilon would hold rates back.
        self.links.iter_mut().for_each(|link| link.rates.fill(0.0));
        self.keep_to_rates_with(0.0)
    }

    /// Changes velocities, and rates of what slides, by as little as there is in the metric of their masses, so that what is held keeps to what it asks where things are. To be
    /// asked while velocities are not behind.
    pub(super) fn keep_to_rates(&mut self) -> Result<()> {
        self.keep_to_rates_with(self.weight_of_parameters())
    }

    fn keep_to_rates_with(&mut self, weight: f64) -> Result<()> {
        let mut desk = std::mem::take(&mut self.desk);
        let collected = self.collect(&mut desk);
        self.desk = desk;
        collected?;
        self.space.float(self.desk.parameters, weight);
        for &(equation, parameter, by) in &self.desk.changes {
            self.space.change(equation, parameter, by);
        }
        let equations = self.space.equations();
        self.right.clear();
        self.right.resize(equations, 0.0);
        self.space.apply(&self.half, &self.rates, &mut self.right);
        for link in self.links.iter().filter(|link| link.is_held()) {
            for equation in link.first..link.first + link.equations {
                let [_, let_go, _] = link.offset(equation - link.first, self.time);
                self.right[equation] = self.desk.target_rate[equation] + let_go - self.right[equation];
            }
        }
        self.space.factor();
        self.multipliers.clear();
        self.multipliers.resize(equations, 0.0);
        // Nothing is ahead or behind: accelerations are not needed until they are known anew.
        self.acceleration.fill(0.0);
        self.space.solve(&mut self.acceleration, &self.right, &mut self.multipliers, &mut self.rates);
        self.half.iter_mut().zip(&self.acceleration).for_each(|(v, change)| *v += change);
        self.acceleration.fill(0.0);
        let mut rates = self.rates.iter();
        for link in self.links.iter_mut().filter(|link| link.is_held()) {
            link.rates.iter_mut().zip(&mut rates).for_each(|(own, rate)| *own += *rate);
            link.accelerations.fill(0.0);
        }
        Ok(())
    }
}
