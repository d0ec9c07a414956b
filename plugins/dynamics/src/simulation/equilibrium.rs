//! Where everything rests, by Newton's method: the least energy that the constraints allow, of vertices and of where places slide.
//!
//! Forces at rest have a potential `E(q)`, so that rest is a least `E(q)` under `g(q, s) = 0`. A step is Newton's for its conditions
//! ([`Tangent`]), shortened by a shift of the mass metric where the second derivatives are not positive definite on what the constraints
//! allow (Levenberg's way), or where it leads up: it must lessen `E + ν Σ|g|`, an exact penalty for `ν` above all multipliers (Nocedal and Wright 2006,
//! chapter 18); what it misses of the constraints for their curvature is put right with the same factor, which keeps steps whole near the end. Where forces
//! balance and the second derivatives are not positive definite, it stands on a saddle, and goes on down along the direction in which the
//! energy falls most.

use loftsman_kernel::Point;

use super::Simulation;
use super::saddle::{CLEARLY, FALLS};
use super::tangent::{Tangent, dot};
use crate::error::Result;
use crate::link::{Phase, Places};
use crate::stiffness::Part;

/// More steps than this are not taken.
const MOST: usize = 300;
/// A step moves bodies by this share of the size (their root mean square), and places by the second along their shapes, no farther.
const FAR: f64 = 0.25;
const SLIDES: f64 = 0.1;
/// The shift at first, and the least that is one, in squares of the highest frequency.
const FIRST: f64 = 1e-4;
pub(super) const LEAST: f64 = 1e-10;
/// No step is so short that more than this would be needed.
pub(super) const LARGEST: f64 = 1e4;
/// What a step must lessen of what it promises.
const SOUND: f64 = 1e-4;
/// A step is halved as often as this before its direction is given up.
const HALVINGS: usize = 6;
/// So often is what a step misses put right.
pub(super) const MEET: usize = 2;
const PUT_RIGHT: usize = 4;
/// Energies differ by rounding where they differ by this share of what they are made of.
pub(super) const ROUNDING: f64 = 1e-14;
/// Where they differ by less than this share, forces are asked.
const BLIND: f64 = 1e-9;
/// Of this share of the size constraints may be missed at rest.
const MET: f64 = 1e-9;
/// Where this is left of the forces, rest is near.
const NEARLY: f64 = 1e-3;
/// A way of less than this share of the size is rounding.
const TINY: f64 = 1e-13;
/// Saddles are left as often as this.
const SADDLES: usize = 24;

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

    pub(super) fn back(&self, simulation: &mut Simulation) {
        for (kept, body) in self.vertices.iter().zip(&mut simulation.bodies) {
            body.body.shape.control_vertices_mut().copy_from_slice(kept);
        }
        for ((places, phase, multipliers), link) in self.places.iter().zip(&mut simulation.links) {
            link.put(places);
            link.phase.clone_from(phase);
            link.multipliers.clone_from(multipliers);
        }
    }
}

/// How it ended.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    pub(super) residual: f64,
    pub(super) way: f64,
    pub(super) steps: usize,
    /// Whether forces balance, whether nothing leads down from there, and whether there is nothing more to be found.
    pub(super) rests: bool,
    pub(super) stable: bool,
    pub(super) ends: bool,
}

/// A direction and how far it was gone.
#[derive(Debug, Default)]
struct Step {
    by: Vec<f64>,
    /// How much multipliers change, and what they become.
    changes: Vec<f64>,
    multipliers: Vec<f64>,
    /// What was left of the forces, what is left after a share of it, and `W` times it.
    left: Vec<f64>,
    now: Vec<f64>,
    weighed: Vec<f64>,
    shift: f64,
    part: Option<Part>,
}

/// The largest amount.
fn most(all: &[f64]) -> f64 {
    all.iter().fold(0.0, |most, v| most.max(v.abs()))
}

impl Simulation {
    /// Newton's steps until everything rests, stably, or none leads farther down.
    ///
    /// # Errors
    /// When constraints cannot be asked.
    pub(super) fn find_rest(&mut self) -> Result<Found> {
        self.rest();
        self.predict();
        let mut tangent = Tangent::new(&self.bodies);
        let highest = self.highest();
        let mut shift = FIRST * highest;
        let mut found = Found {
            residual: f64::INFINITY,
            way: f64::INFINITY,
            steps: 0,
            rests: false,
            stable: false,
            ends: false,
        };
        let (mut start, mut step) = (Start::default(), Step::default());
        let (mut penalty, mut saddles, mut tiny) = (0.0_f64, 0, 0);
        while found.steps < MOST {
            self.look(&mut tangent)?;
            self.left(&tangent, &self.present_multipliers(), &mut step.left);
            let (residual, met) = self.balance(&step.left)?;
            found.residual = residual;
            if met && residual <= super::settle::RESTS {
                let stable = tangent.factor(self, Part::Whole, 0.0)?;
                let falls = !stable
                    && saddles < SADDLES
                    && self.buckles()
                    && self.leave_saddle(&mut tangent, &step.left, &mut start, FALLS)?;
                if !falls {
                    let tangent = &mut tangent;
                    found.stable =
                        stable || (saddles < SADDLES && (self.buckles() || !self.falls(tangent)?));
                    found.rests = found.stable || !self.buckles();
                    found.ends = true;
                    self.rank = tangent.rank();
                    return Ok(found);
                }
                saddles += 1;
                found.steps += 1;
                shift = shift.max(FIRST * highest);
                continue;
            }
            if met
                && residual < NEARLY
                && saddles < SADDLES
                && self.buckles()
                && !tangent.factor(self, Part::Whole, LEAST * highest)?
                && self.leave_saddle(&mut tangent, &step.left, &mut start, CLEARLY)?
            {
                saddles += 1;
                found.steps += 1;
                continue;
            }
            // The whole of it where that leads down, its convex part where it does not.
            if !self.direct(&mut tangent, &mut shift, residual, highest, &mut step)? {
                break;
            }
            start.remember(self);
            let share = self.reach(&tangent, &mut step);
            match self.descend(&tangent, &mut step, share, &mut penalty, &start)? {
                Some((taken, way)) => {
                    found.way = way;
                    found.steps += 1;
                    self.rank = tangent.rank();
                    // A whole step of the whole system promises the next.
                    shift *= match taken {
                        t if t >= 0.5 => 0.1,
                        t if t >= 0.1 => 1.0,
                        _ => 4.0,
                    };
                    if shift < LEAST * highest {
                        shift = 0.0;
                    }
                    self.note_events();
                    // Nothing goes any farther: rounding is left.
                    tiny = if found.way <= TINY * self.size { tiny + 1 } else { 0 };
                    if tiny > 3 {
                        break;
                    }
                }
                None => {
                    start.back(self);
                    shift = (16.0 * shift).max(LEAST * 100.0 * highest);
                    if shift > LARGEST * highest {
                        break;
                    }
                }
            }
        }
        Ok(found)
    }

    /// `1/h²` of the longest stable step: the square of the highest frequency, nearly.
    pub(super) fn highest(&self) -> f64 {
        let stable = self.stable_step();
        if stable.is_finite() && stable > 0.0 { 1.0 / (stable * stable) } else { 1.0 }
    }

    /// Rows and forces where things are.
    fn look(&mut self, tangent: &mut Tangent) -> Result<()> {
        self.recollect()?;
        self.gather_forces();
        tangent.take_rows(self);
        Ok(())
    }

    pub(super) fn recollect(&mut self) -> Result<()> {
        let mut desk = std::mem::take(&mut self.desk);
        let collected = self.collect(&mut desk);
        self.desk = desk;
        collected
    }

    /// What is left of the forces, as for [`Settled`](super::Settled); and whether constraints are met.
    fn balance(&mut self, left: &[f64]) -> Result<(f64, bool)> {
        let vertices = left.len() - self.desk.parameters;
        let most = left[..vertices].iter().fold(0.0_f64, |most, f| most.max(f.abs()));
        let met = self.desk.gap.iter().all(|gap| gap.abs() <= MET * self.size);
        for link in self.links.iter_mut().filter(|link| link.is_held()) {
            let own = link.first..link.first + link.equations;
            link.error = self.desk.gap[own].iter().fold(0.0, |most, gap| most.max(gap.abs()));
        }
        let mut residual = self.share_of_forces(most, 0.0);
        if met && residual <= super::settle::RESTS {
            let along = self.pull_along()?;
            residual = self.share_of_forces(most, along);
            // Rows were asked for beside their places.
            self.recollect()?;
        }
        Ok((residual, met))
    }

    /// A direction that leads down, with the shift that it takes. Whether there is one.
    fn direct(
        &mut self,
        tangent: &mut Tangent,
        shift: &mut f64,
        residual: f64,
        highest: f64,
        step: &mut Step,
    ) -> Result<bool> {
        let mut part = Part::Whole;
        let given = *shift;
        // Near rest, and by turns where the convex part alone was of use before, the whole of it with more of a shift.
        let shifts =
            if residual < NEARLY || step.part == Some(Part::Absolute) { 1e-4 } else { 100.0 * LEAST };
        while !tangent.factor(self, part, *shift)? {
            if part == Part::Whole && *shift < shifts * highest {
                // Where something may turn freely, a little is enough.
                *shift = (30.0 * *shift).max(LEAST * highest);
            } else if part == Part::Whole {
                part = Part::Absolute;
                *shift = given.max(100.0 * LEAST * highest);
            } else {
                *shift *= 16.0;
            }
            if *shift > LARGEST * highest {
                return Ok(false);
            }
        }
        step.part = Some(part);
        step.shift = *shift;
        step.by.clear();
        step.by.extend_from_slice(&step.left);
        step.changes.clear();
        step.changes.extend(self.desk.gap.iter().map(|gap| -gap));
        tangent.solve(&mut step.by, &mut step.changes);
        tangent.multipliers(&mut step.changes, &self.desk.gap);
        Ok(step.by.iter().all(|v| v.is_finite()))
    }

    /// Which share of a step can be gone: bodies not too far, places to the ends of their shapes. Those that would leave from there let go.
    fn reach(&mut self, tangent: &Tangent, step: &mut Step) -> f64 {
        let Step { by, weighed, .. } = step;
        tangent.weigh(&self.bodies, by, weighed);
        let vertices = by.len() - self.desk.parameters;
        let mass: f64 =
            self.bodies.iter().filter_map(|body| body.mass.as_ref()).flat_map(|m| &m.lumped).sum();
        let way = (dot(&by[..vertices], &weighed[..vertices]).max(0.0) / mass).sqrt();
        let mut share = if way > FAR * self.size { FAR * self.size / way } else { 1.0 };
        let mut parameter = vertices;
        let time = self.time;
        for link in self.links.iter_mut().filter(|link| link.is_held()) {
            let mut leaves = false;
            let ats: Places = link.locations().collect();
            let floats: Vec<f64> = ats
                .iter()
                .zip(&link.places)
                .filter(|(_, place)| place.floats)
                .flat_map(|(at, _)| match at {
                    loftsman_kernel::shape::Location::Curve(u) => vec![*u],
                    loftsman_kernel::shape::Location::Surface(u, v)
                    | loftsman_kernel::shape::Location::Face(_, u, v) => vec![*u, *v],
                    loftsman_kernel::shape::Location::Vertex(_) => Vec::new(),
                })
                .collect();
            for (slide, at) in link.slides.iter().zip(floats) {
                let way = by[parameter];
                let (room, length) = (slide.room(at, way > 0.0), slide.length());
                if way.abs() > SLIDES * length {
                    share = share.min(SLIDES * length / way.abs());
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
    fn descend(
        &mut self,
        tangent: &Tangent,
        step: &mut Step,
        share: f64,
        penalty: &mut f64,
        start: &Start,
    ) -> Result<Option<(f64, f64)>> {
        if self.links.iter().zip(&start.places).any(|(link, (_, phase, _))| link.phase != *phase) {
            // One let go: everything is looked at anew.
            return Ok(Some((0.2, f64::INFINITY)));
        }
        let multipliers = self.present_multipliers();
        let largest =
            multipliers.iter().zip(&step.changes).fold(0.0_f64, |most, (l, d)| most.max((l + d).abs()));
        *penalty = penalty.max(1.5 * largest);
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
        for link in self.links.iter_mut().filter(|link| link.is_held()) {
            let own = &by[parameter..parameter + link.slides.len()];
            parameter += own.len();
            let (places, _) = link.moved(|k| alpha * own[k]);
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

    /// `Q + Aᵀλ` where things are, over the unknowns.
    fn left(&self, tangent: &Tangent, multipliers: &[f64], out: &mut Vec<f64>) {
        out.clear();
        out.resize(tangent.unknowns(), 0.0);
        for (coordinate, force) in self.forces.iter().enumerate() {
            if let Some(at) = tangent.place(coordinate) {
                out[at] = *force;
            }
        }
        self.space.entries(|equation, coordinate, a| {
            if let Some(at) = tangent.place(coordinate) {
                out[at] += a * multipliers[equation];
            }
        });
        let first = out.len() - self.desk.parameters;
        for &(equation, parameter, by) in &self.desk.changes {
            out[first + parameter] += by * multipliers[equation];
        }
    }

    /// The multipliers of all equations.
    fn present_multipliers(&self) -> Vec<f64> {
        self.links.iter().filter(|link| link.is_held()).flat_map(|link| &link.multipliers).copied().collect()
    }

    /// The potential of all forces but those of constraints; and the sum of its parts' amounts, for what rounding does to it.
    pub(super) fn potential(&self) -> (f64, f64) {
        let (mut whole, mut sizes) = (0.0, 0.0);
        let mut count = |part: f64| {
            whole += part;
            sizes += part.abs();
        };
        for body in &self.bodies {
            let (Some(elastic), Some(mass)) = (&body.elastic, &body.mass) else { continue };
            let q = body.body.shape.control_vertices();
            count(elastic.energy(q).0);
            for (q, m) in q.iter().zip(&mass.lumped) {
                count(-m * q.coords.dot(&self.gravity));
            }
            for (q, f) in q.iter().zip(self.applied[body.range()].chunks_exact(3)) {
                count(-(0..3).map(|axis| f[axis] * q[axis]).sum::<f64>());
            }
            let own = |load: &&crate::load::Load| load.acts(self.time) && load.offset() == body.start;
            self.loads.iter().filter(own).for_each(|load| count(load.potential(q, self.time)));
        }
        (whole, sizes)
    }
}
