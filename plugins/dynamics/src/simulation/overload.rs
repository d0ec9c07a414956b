//! Why something goes beyond all numbers, of what is known of it without steps.

use super::Simulation;
use crate::body::extent;

impl Simulation {
    /// Whether a place that is held slides.
    pub(super) fn any_slides(&self) -> bool {
        self.links.iter().any(|link| link.is_held() && !link.slides.is_empty())
    }

    /// By how many times its length what acts now would stretch a body, the most of all: forces, pulls (as far as their targets are from where it was at the start) and weight by
    /// the force for twice its length, of a surface across its extent. `O(n)`.
    pub(super) fn overload(&self) -> f64 {
        let mut most = 0.0_f64;
        for body in &self.bodies {
            let (Some(elastic), Some(mass)) = (&body.elastic, &body.mass) else { continue };
            let width = if elastic.points.directions == 2 { extent(&body.first) } else { 1.0 };
            let weight = mass.lumped.iter().sum::<f64>() * self.gravity.norm();
            let acts = self.loads.iter().filter(|load| load.acts(self.time) && load.offset() == body.start);
            let pulls: f64 = acts.map(|load| load.strength(&body.first, self.time)).sum();
            // What has no stiffness is not stretched by what is too strong for it.
            let strain = (weight + pulls) / (elastic.given * width);
            most = if elastic.given > 0.0 { most.max(strain) } else { most };
        }
        most
    }
}
