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
        let mut desk = std::mem::take(&mut self.desk);
        let collected = self.collect(&mut desk);
        self.desk = desk;
        collected?;
        // The small mass of scheme epsilon would hold rates back.
        self.space.float(self.desk.parameters, 0.0);
        for &(equation, parameter, by) in &self.desk.changes {
            self.space.change(equation, parameter, by);
        }
        let equations = self.space.equations();
        self.rates.fill(0.0);
        self.right.clear();
        self.right.resize(equations, 0.0);
        self.space.apply(&self.half, &self.rates, &mut self.right);
        self.right.iter_mut().zip(&self.desk.target_rate).for_each(|(now, target)| *now = target - *now);
        self.space.factor();
        let mut change = vec![0.0; self.half.len()];
        let mut multipliers = vec![0.0; equations];
        self.space.solve(&mut change, &self.right, &mut multipliers, &mut self.rates);
        self.half.iter_mut().zip(&change).for_each(|(v, change)| *v += change);
        let mut rates = self.rates.iter();
        for link in self.links.iter_mut().filter(|link| link.is_held()) {
            link.rates.iter_mut().zip(&mut rates).for_each(|(own, rate)| *own = *rate);
        }
        Ok(())
    }
}
