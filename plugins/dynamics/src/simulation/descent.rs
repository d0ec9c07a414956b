//! A step towards rest: how far a direction can be gone, and what it misses put right.

use loftsman_kernel::Point;
use smallvec::SmallVec;

use super::Simulation;
use super::tangent::{Tangent, dot};
use crate::error::Result;
use crate::link::{Phase, Places};
use crate::stiffness::Part;

/// A step moves bodies by this share of the size (their root mean square), and places by the second along their shapes, no farther.
const FAR: f64 = 0.25;
const SLIDES: f64 = 0.1;
/// Both places of a loop come nearer by this share of the way between them in a step at most: none goes through the other, a loop that is drawn shut is seen to be.
const CLOSER: f64 = 0.9;
/// What a step must lessen of what it promises.
const SOUND: f64 = 1e-4;
/// A step is halved as often as this before its direction is given up.
const HALVINGS: usize = 6;
/// The penalty is at most so many times the largest multiplier: those of rows that hardly differed on the way say nothing of where it is now.
const FALLS: f64 = 30.0;
/// So often is what a step misses put right.
pub(super) const MEET: usize = 2;
const PUT_RIGHT: usize = 4;
/// Energies differ by rounding where they differ by this share of what they are made of.
pub(super) const ROUNDING: f64 = 1e-14;
/// Where they differ by less than this share, forces are asked.
const BLIND: f64 = 1e-9;

/// Where a step starts, to go back to.
#[derive(Debug, Default)]
pub(super) struct Start {
    vertices: Vec<Vec<Point>>,
    places: Vec<(Places, Phase, Vec<f64>)>,
}

impl Start {
    pub(super) fn remember(&mut self, simulation: &Simulation) {
        self.vertices.resize_with(simulation.bodies.len(), Vec::new);
        for (kept, body) in self.vertices.iter_mut().zip(&simulation.bodies) {
            kept.clear();
            kept.extend_from_slice(body.body.shape.control_vertices());
        }
        self.places.clear();
        self.places.extend(
            simulation
                .links
                .iter()
                .map(|link| (link.locations().collect(), link.phase.clone(), link.multipliers.clone())),
        );
    }

    /// Whether all constraints hold that did, and no others.
    pub(super) fn is_as_held(&self, simulation: &Simulation) -> bool {
        self.places.iter().map(|(_, phase, _)| phase).eq(simulation.links.iter().map(|link| &link.phase))
    }

    pub(super) fn back(&self, simulation: &mut Simulation) {
        for (kept, body) in self.vertices.iter().zip(&mut simulation.bodies) {
            body.body.shape.control_vertices_mut().copy_from_slice(kept);
        }
        self.back_to_places(simulation);
    }

    /// The same of constraints alone: bodies may have other vertices now.
    pub(super) fn back_to_places(&self, simulation: &mut Simulation) {
        for ((places, phase, multipliers), link) in self.places.iter().zip(&mut simulation.links) {
            link.put(places);
            link.phase.clone_from(phase);
            link.multipliers.clone_from(multipliers);
        }
    }
}

/// A direction and how far it was gone.
#[derive(Debug, Default)]
pub(super) struct Step {
    pub(super) by: Vec<f64>,
    /// How much multipliers change, and what they become.
    pub(super) changes: Vec<f64>,
    pub(super) multipliers: Vec<f64>,
    /// What was left of the forces, what is left after a share of it, and `W` times it.
    pub(super) left: Vec<f64>,
    pub(super) now: Vec<f64>,
    pub(super) weighed: Vec<f64>,
    pub(super) shift: f64,
    pub(super) part: Option<Part>,
}

/// The largest amount.
fn most(all: &[f64]) -> f64 {
    all.iter().fold(0.0, |most, v| most.max(v.abs()))
}

impl Simulation {
    /// Which share of a step can be gone: bodies not too far, places to the ends of their shapes. Those that would leave from there let go.
    pub(super) fn reach(&mut self, tangent: &Tangent, step: &mut Step) -> f64 {
        let Step { by, weighed, .. } = step;
        tangent.weigh(&self.bodies, by, weighed);
        let vertices = by.len() - self.desk.parameters;
        let mass: f64 =
            self.bodies.iter().filter_map(|body| body.mass.as_ref()).flat_map(|m| &m.lumped).sum();
        let way = (dot(&by[..vertices], &weighed[..vertices]).max(0.0) / mass).sqrt();
        let mut share = if way > FAR * self.size { FAR * self.size / way } else { 1.0 };
        let mut parameter = vertices;
        let time = self.time;
        for (index, link) in self.links.iter_mut().enumerate().filter(|(_, link)| link.is_held()) {
            let mut leaves = false;
            if let Some(meets) = link.meets(&by[parameter..]) {
                share = share.min(CLOSER * meets);
            }
            let ats = link.parameters();
            for (own, (slide, at)) in link.slides.iter().zip(ats).enumerate() {
                let way = by[parameter];
                let (room, length) = (slide.room(at, way > 0.0), slide.length());
                if way.abs() > SLIDES * length {
                    share = share.min(SLIDES * length / way.abs());
                }
                let stop = tangent.corners.stop(index, own, slide, at, way);
                if stop.abs() < way.abs() {
                    share = share.min(stop.abs() / way.abs());
                }
                if way.abs() > room {
                    if room <= 1e-9 * length {
                        leaves |= way.abs() > 1e-6 * length;
                        by[parameter] = 0.0;
                    } else {
                        share = share.min(room / way.abs());
                    }
                }
                parameter += 1;
            }
            if leaves {
                link.leave(time);
            }
        }
        share
    }

    /// Goes along a direction as far as it lessens energy and what constraints miss: which share of it, and the largest way.
    pub(super) fn descend(
        &mut self,
        tangent: &Tangent,
        step: &mut Step,
        share: f64,
        penalty: &mut f64,
        start: &Start,
    ) -> Result<Option<(f64, f64)>> {
        if !start.is_as_held(self) {
            // One let go: everything is looked at anew.
            return Ok(Some((0.2, f64::INFINITY)));
        }
        let multipliers = self.present_multipliers();
        let largest =
            multipliers.iter().zip(&step.changes).fold(0.0_f64, |most, (l, d)| most.max((l + d).abs()));
        *penalty = penalty.min(FALLS * largest).max(1.5 * largest);
        let gaps = self.desk.gap.clone();
        let missed: f64 = gaps.iter().map(|gap| gap.abs()).sum();
        let (energy, made_of) = self.potential();
        let work: f64 = (0..self.forces.len())
            .filter_map(|at| tangent.place(at).map(|own| self.forces[at] * step.by[own]))
            .sum();
        let slope = -work - *penalty * missed;
        let before = energy + *penalty * missed;
        let promise = |alpha: f64| before + SOUND * alpha * slope.min(0.0);
        let mut alpha = share;
        for _ in 0..=HALVINGS {
            step.multipliers.clear();
            step.multipliers.extend(step.changes.iter().zip(&multipliers).map(|(d, l)| l + alpha * d));
            self.go(tangent, &step.by, alpha);
            let mut falls = false;
            for round in 0..=PUT_RIGHT {
                self.recollect()?;
                if round < MEET && (round == 0 || most(&self.desk.gap) > 1e-13 * self.size) {
                    self.put_right(tangent, step, alpha, &gaps, false);
                    continue;
                }
                self.gather_forces();
                self.left(tangent, &step.multipliers, &mut step.now);
                let (energy, sizes) = self.potential();
                let still: f64 = self.desk.gap.iter().map(|gap| gap.abs()).sum();
                let now = energy + *penalty * still;
                falls = now <= promise(alpha) - ROUNDING * (made_of + sizes);
                if !falls && alpha == 1.0 && now <= before + BLIND * (made_of + sizes) {
                    // Energies do not show so little; forces do.
                    falls = most(&step.now) < 0.9 * most(&step.left);
                }
                if falls || round == PUT_RIGHT {
                    break;
                }
                self.put_right(tangent, step, alpha, &gaps, true);
            }
            if falls {
                let mut at = 0;
                for link in self.links.iter_mut().filter(|link| link.is_held()) {
                    let count = link.multipliers.len();
                    link.multipliers.copy_from_slice(&step.multipliers[at..at + count]);
                    at += count;
                }
                let way = step.by.iter().fold(0.0_f64, |most, v| most.max((alpha * v).abs()));
                return Ok(Some((alpha / share.min(1.0), way)));
            }
            start.back(self);
            alpha *= 0.5;
        }
        Ok(None)
    }

    /// Moves everything along a direction.
    pub(super) fn go(&mut self, tangent: &Tangent, by: &[f64], alpha: f64) {
        let first = by.len() - self.desk.parameters;
        for body in self.bodies.iter_mut().filter(|body| body.mass.is_some()) {
            let start = 3 * body.start;
            for (i, vertex) in body.body.shape.control_vertices_mut().iter_mut().enumerate() {
                for axis in 0..3 {
                    if let Some(at) = tangent.place(start + 3 * i + axis) {
                        vertex[axis] += alpha * by[at];
                    }
                }
            }
        }
        let mut parameter = first;
        for (index, link) in self.links.iter_mut().enumerate().filter(|(_, link)| link.is_held()) {
            let own = &by[parameter..parameter + link.slides.len()];
            parameter += own.len();
            let ats = link.parameters();
            let stop = |k: usize| tangent.corners.stop(index, k, &link.slides[k], ats[k], alpha * own[k]);
            let ways: SmallVec<[f64; 4]> = (0..own.len()).map(stop).collect();
            let short = link.meets(&ways).map_or(1.0, |meets| CLOSER * meets);
            let (places, _) = link.moved(|k| short * ways[k]);
            link.put(&places);
        }
    }

    /// What forces and constraints are beside what a share of the step promised, for they curve, is put right with the same factor: stiff
    /// directions follow, while others go their whole way.
    fn put_right(&mut self, tangent: &Tangent, step: &mut Step, alpha: f64, gaps: &[f64], forces: bool) {
        let Step { now, left, weighed, multipliers, shift, .. } = step;
        if !forces {
            now.clear();
            now.resize(left.len(), 0.0);
        }
        for ((now, left), weighed) in now.iter_mut().zip(&*left).zip(&*weighed).filter(|_| forces) {
            *now -= (1.0 - alpha) * left + alpha * *shift * weighed;
        }
        let beside: Vec<f64> =
            self.desk.gap.iter().zip(gaps).map(|(now, before)| now - (1.0 - alpha) * before).collect();
        let mut changes: Vec<f64> = beside.iter().map(|gap| -gap).collect();
        tangent.solve(now, &mut changes);
        tangent.multipliers(&mut changes, &beside);
        self.go(tangent, now, 1.0);
        if forces {
            multipliers.iter_mut().zip(&changes).for_each(|(l, d)| *l += d);
        }
    }
}
