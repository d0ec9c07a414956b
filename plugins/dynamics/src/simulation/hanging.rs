//! Rest from afar: of ropes that do not bend, with tension alone at first.
//!
//! What does not bend carries no compression at rest, where there is room to give way; but on its way it can crumple in many. The energy of tension
//! alone is convex in the vertices of a rope (`½ k max(ε, 0)²`: a convex function of `|P'|`, not falling), so that while places stay where they are it has one least
//! value, that of what hangs. Stiff ropes bend the way there; one that is soft enough to carry its weight by stretching twofold goes there in a few
//! steps, and one a little stiffer from where that hangs.

use loftsman_kernel::Vector;

use super::Simulation;

/// So many steps are tried as things are, and so many with tension alone.
const PATIENCE: usize = 40;
const MOST: usize = 120;
/// The softest is so many times as stiff as what pulls it; the next this much stiffer.
const SOFT: f64 = 2.0;
const STIFFER: f64 = 8.0;
/// The next comes where this is left of the forces, and compression comes back where that is.
const FAIRLY: f64 = 3e-2;
const NEARLY: f64 = 1e-3;

/// How far it has come.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) enum Hanging {
    #[default]
    NotYet,
    /// Since which step, and how stiff at most.
    Since(usize, f64),
    Done,
}

impl Simulation {
    /// What comes next after some steps: whether everything is to be looked at anew.
    pub(super) fn hang_on(&mut self, hanging: &mut Hanging, steps: usize, met: bool, residual: f64) -> bool {
        match *hanging {
            Hanging::NotYet if steps >= PATIENCE && residual > NEARLY => {
                let stiffness = SOFT * self.driving_force();
                *hanging =
                    if self.hang(stiffness) { Hanging::Since(steps, stiffness) } else { Hanging::Done };
                *hanging != Hanging::Done
            }
            Hanging::Since(since, stiffness) => {
                let softer = self
                    .bodies
                    .iter()
                    .filter_map(|body| body.elastic.as_ref())
                    .any(|e| e.stiffness < e.given);
                if steps >= since + MOST || met && !softer && residual <= NEARLY {
                    self.stop_hanging(hanging);
                    true
                } else if met && softer && residual <= FAIRLY {
                    *hanging = Hanging::Since(since, STIFFER * stiffness);
                    self.hang(STIFFER * stiffness);
                    true
                } else {
                    false
                }
            }
            _ => false,
        }
    }

    pub(super) fn stop_hanging(&mut self, hanging: &mut Hanging) {
        *hanging = Hanging::Done;
        self.push_again();
    }

    /// From now on what is slack of ropes that do not bend does not push, and they are no stiffer than that. Whether there are such.
    fn hang(&mut self, stiffness: f64) -> bool {
        let mut any = false;
        if stiffness > 0.0 && stiffness.is_finite() {
            for elastic in self.bodies.iter_mut().filter_map(|body| body.elastic.as_mut()) {
                if elastic.bend.is_none() && elastic.points.directions == 1 {
                    elastic.stiffness = elastic.given.min(stiffness);
                    elastic.pushes = false;
                    any = true;
                }
            }
        }
        any
    }

    /// Everything is as stiff as it is, and pushes.
    pub(super) fn push_again(&mut self) {
        for elastic in self.bodies.iter_mut().filter_map(|body| body.elastic.as_mut()) {
            (elastic.stiffness, elastic.pushes) = (elastic.given, true);
        }
    }

    /// What all weighs, and what it is pulled and pushed with, in amounts.
    fn driving_force(&self) -> f64 {
        let mass: f64 =
            self.bodies.iter().filter_map(|body| body.mass.as_ref()).flat_map(|m| &m.lumped).sum();
        let (time, none) = (self.time, Vector::zeros());
        let mut all = mass * self.gravity.norm();
        for load in self.loads.iter().filter(|load| load.acts(time)) {
            let Some(body) = self.bodies.iter().find(|body| body.start == load.offset()) else { continue };
            let q = body.body.shape.control_vertices();
            let mut forces = vec![0.0; 3 * (load.offset() + q.len())];
            load.add(q, &vec![none.into(); q.len()], time, true, &mut forces);
            let sum = forces.chunks_exact(3).fold(none, |sum, f| sum + Vector::from_column_slice(f));
            all += sum.norm();
        }
        all + self.applied.chunks_exact(3).map(|f| Vector::from_column_slice(f).norm()).sum::<f64>()
    }
}
