//! Whether all numbers are numbers, and nothing goes farther than it may.

use super::Simulation;
use crate::error::{DynamicsError, Result};
use crate::link::Link;
use crate::place::Slide;
use crate::scheme::Scheme;

/// In an implicit step nothing goes farther than so many times the size.
const FAR: f64 = 100.0;
/// A place that goes over such a share of its shape in one explicit step is lost.
const AWAY: f64 = 0.01;

impl Simulation {
    /// Whether all numbers are numbers and, where it `looks`, nothing goes farther than it may in a step: on average, which costs as much as
    /// a part of a step.
    pub(super) fn bounded(&self, step: f64, looks: bool) -> Result<()> {
        let implicit = self.scheme == Scheme::Implicit;
        let reach = if implicit { FAR } else { 1.0 } * self.size;
        let sum: f64 = self.half.iter().sum();
        if sum.is_finite() && !(looks && self.mean_speed(&self.half) * step > reach) {
            return Ok(());
        }
        Err(DynamicsError::BlowsUp {
            time: self.time,
            step,
            stable: self.stable,
            scheme: self.scheme,
            fed: self.is_fed(),
            slides: self.any_slides(),
            strain: self.overload(),
            lost: self.runaway(step),
        })
    }

    /// A constraint whose place goes over a part of its shape in one explicit step: what it asks for tells no more where it is.
    fn runaway(&self, step: f64) -> Option<String> {
        let far = |link: &&Link| {
            let mut all = link.slides.iter().zip(&link.rates);
            let near = |(slide, rate): (&Slide, &f64)| {
                (rate * step).abs() <= AWAY * (slide.interval.end - slide.interval.start) / slide.pace
            };
            !all.all(near)
        };
        self.links.iter().find(far).map(|link| link.name.clone())
    }

    /// The largest root mean square speed of a body, by its mass: of the shape itself, whose control vertices may go fast for nothing.
    pub(crate) fn mean_speed(&self, velocities: &[f64]) -> f64 {
        let mut most = 0.0_f64;
        for body in &self.bodies {
            let Some(mass) = &body.mass else { continue };
            let own = &velocities[body.range()];
            let mut whole = 0.0;
            for (i, v) in own.chunks_exact(3).enumerate() {
                let momentum = mass.matrix.row(i).fold([0.0; 3], |mut sum, (j, m)| {
                    (0..3).for_each(|axis| sum[axis] += m * own[3 * j + axis]);
                    sum
                });
                whole += (0..3).map(|axis| v[axis] * momentum[axis]).sum::<f64>();
            }
            let speed = (whole.max(0.0) / mass.lumped.iter().sum::<f64>()).sqrt();
            most = if whole.is_finite() { most.max(speed) } else { f64::INFINITY };
        }
        most
    }
}
