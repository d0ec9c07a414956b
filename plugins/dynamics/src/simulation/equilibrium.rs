//! Where everything rests, by Newton's method: the least energy that the constraints allow, of vertices and of where places slide.
//!
//! Forces at rest have a potential `E(q)`, so that rest is a least `E(q)` under `g(q, s) = 0`. A step is Newton's for its conditions
//! ([`Tangent`]), shortened by a shift of the mass metric where the second derivatives are not positive definite on what the constraints
//! allow (Levenberg's way), or where it leads up: it must lessen `E + ν Σ|g|`, an exact penalty for `ν` above all multipliers (Nocedal and Wright 2006,
//! chapter 18); what it misses of the constraints for their curvature is put right with the same factor, which keeps steps whole near the end. Where forces
//! balance and the second derivatives are not positive definite, it stands on a saddle, and goes on down along the direction in which the
//! energy falls most.

use loftsman_kernel::solve::{RangeSpace, Weight};

use super::corners::Corners;
use super::descent::{Start, Step};
use super::hanging::Hanging;
use super::saddle::{CLEARLY, FALLS, Lowest};
use super::tangent::Tangent;
use super::{Moving, Simulation};
use crate::error::Result;
use crate::stiffness::Part;

/// More steps than this are not taken; than those where nothing pulls what does not bend, and it could crumple for long.
const MOST: usize = 1500;
const CRUMPLES: usize = 300;
/// The shift at first, and the least that is one, in squares of the highest frequency.
const FIRST: f64 = 1e-4;
pub(super) const LEAST: f64 = 1e-10;
/// No step is so short that more than this would be needed.
pub(super) const LARGEST: f64 = 1e4;
/// Shifts are measured by the highest frequency, or by one so many times (squared) that of a wave from end to end, where a short span swings faster.
const FASTER: f64 = 1e5;
/// Where this is left of the forces, rest is near.
const NEARLY: f64 = 1e-3;
/// And where this is left, forces tell to which side a place is pulled from a corner.
const FAIRLY: f64 = 1e-2;
/// A way of less than this share of the size is rounding.
const TINY: f64 = 1e-13;
/// Saddles are left as often as this.
const SADDLES: usize = 24;

/// From where rest is looked for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Search {
    /// What is left of the forces where something has come to rest by other steps: that is looked at first.
    pub(super) rested: Option<f64>,
    /// Places that slide stay until all else is fairly at rest.
    pub(super) still: bool,
    /// No more steps than this are taken.
    pub(super) most: usize,
}

/// How it ended.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    pub(super) residual: f64,
    pub(super) way: f64,
    pub(super) steps: usize,
    /// Whether forces balance, whether nothing leads down from there (`None` where that is not to be told), and whether there is nothing more to
    /// be found.
    pub(super) rests: bool,
    pub(super) stable: Option<bool>,
    pub(super) ends: bool,
    /// Whether constraints are met.
    pub(super) met: bool,
}

impl Simulation {
    /// Newton's steps until everything rests, stably, or none leads farther down. Where something has come to rest by other steps, to what is left of
    /// its forces, that is looked at first; else it is looked for from afar.
    ///
    /// # Errors
    /// When constraints cannot be asked.
    pub(super) fn find_rest(&mut self, search: Search) -> Result<Found> {
        // Rows alone: nothing is solved in the metric of a step.
        let still = self.bodies.iter().map(|body| (Weight::Still(body.count()), None));
        let own = std::mem::replace(&mut self.space, RangeSpace::new(still));
        let found = self.search(search);
        self.space = own;
        self.push_again();
        found
    }

    fn search(&mut self, Search { rested, mut still, most }: Search) -> Result<Found> {
        self.rest();
        self.predict();
        let mut tangent = Tangent::new(&self.bodies);
        tangent.corners = Corners::new(self);
        let highest = self.highest();
        // What bends has frequencies over more decades than what is stretched: its highest one, which is known closely, is not what shifts are measured by.
        let bends =
            self.bodies.iter().filter_map(|body| body.elastic.as_ref()).any(|elastic| elastic.bend.is_some());
        let scale = match self.slowest() {
            Some(slow) if bends => FASTER * slow,
            Some(slow) => highest.min(FASTER * slow),
            None => highest,
        };
        let mut shift = FIRST * scale;
        let mut found = Found {
            residual: f64::INFINITY,
            way: f64::INFINITY,
            steps: 0,
            rests: false,
            stable: None,
            ends: false,
            met: false,
        };
        let (mut start, mut step) = (Start::default(), Step::default());
        // A balance that leans to a side so little that it may be left in vain: it is kept to come back to, and told to be unstable then.
        let mut ledge: Option<(Found, Start)> = None;
        let (mut penalty, mut saddles, mut tiny) = (0.0_f64, 0, 0);
        let mut hanging = if rested.is_none() && self.buckles() { Hanging::NotYet } else { Hanging::Done };
        let most = most.min(if self.buckles() { MOST } else { CRUMPLES });
        while found.steps < most {
            let hangs = matches!(hanging, Hanging::Since(..));
            still &= !(found.met && found.residual <= FAIRLY);
            self.look(&mut tangent, hangs || still, found.residual <= FAIRLY)?;
            self.left(&tangent, &self.present_multipliers(), &mut step.left);
            let (residual, met) = self.balance(&tangent, &step.left)?;
            let residual = if found.steps == 0 { rested.unwrap_or(residual) } else { residual };
            (found.residual, found.met) = (residual, met);
            if self.hang_on(&mut hanging, found.steps, met, residual) {
                (shift, penalty) = (FIRST * scale, 0.0);
                continue;
            }
            if met && !hangs && !still && residual <= super::settle::RESTS {
                let mut lowest = self.lowest(&mut tangent, FALLS)?;
                if let Lowest::Leans(way) = &lowest
                    && !(self.buckles() && self.falls_both_ways(&mut tangent, way, &mut start)?)
                {
                    lowest = Lowest::Rises;
                }
                if matches!(lowest, Lowest::Leans(_)) && ledge.is_none() {
                    let mut kept = Start::default();
                    kept.remember(self);
                    ledge = Some((found, kept));
                }
                if self.buckles()
                    && saddles < SADDLES
                    && let Lowest::Falls(_, way) | Lowest::Leans(way) = &lowest
                    && self.leave_saddle(&mut tangent, way, &step.left, &mut start)?
                {
                    saddles += 1;
                    found.steps += 1;
                    shift = shift.max(FIRST * scale);
                    continue;
                }
                found.stable = match lowest {
                    Lowest::Rises => Some(true),
                    Lowest::Leans(_) => Some(false),
                    // It does not fall by what energies show.
                    Lowest::Falls(by, _) if by > CLEARLY => None,
                    Lowest::Falls(..) => Some(false),
                    Lowest::Unknown => None,
                };
                // Where nothing but tension acts a balance is kept, stable or not.
                found.rests = found.stable != Some(false) || !self.buckles() || ledge.is_some();
                found.ends = true;
                self.rank = tangent.rank();
                return Ok(found);
            }
            if met
                && !hangs
                && !still
                && residual < NEARLY
                && saddles < SADDLES
                && self.buckles()
                && !tangent.factor(self, Part::Whole, LEAST * scale)?
                && let Lowest::Falls(_, way) = self.lowest(&mut tangent, CLEARLY)?
                && self.leave_saddle(&mut tangent, &way, &step.left, &mut start)?
            {
                saddles += 1;
                found.steps += 1;
                continue;
            }
            // The whole of it where that leads down, its convex part where it does not.
            let mut stuck = !self.direct(&mut tangent, &mut shift, residual, [scale, highest], &mut step)?;
            if !stuck && self.come_to_corners(&tangent, &step.by) {
                found.steps += 1;
                continue;
            }
            if !stuck {
                start.remember(self);
                let share = self.reach(&tangent, &mut step);
                match self.descend(&tangent, &mut step, share, &mut penalty, &start)? {
                    Some((taken, way)) => {
                        found.way = way;
                        found.steps += 1;
                        tangent.tried.clone_from(&tangent.stays);
                        self.rank = tangent.rank();
                        // A whole step of the whole system promises the next.
                        shift *= match taken {
                            t if t >= 0.5 => 0.1,
                            t if t >= 0.1 => 1.0,
                            _ => 4.0,
                        };
                        if taken < 0.1 {
                            shift = shift.max(LEAST * scale);
                        }
                        if shift < LEAST * scale {
                            shift = 0.0;
                        }
                        self.note_events();
                        // Nothing goes any farther: rounding is left.
                        tiny = if found.way <= TINY * self.size { tiny + 1 } else { 0 };
                        stuck = tiny > 3;
                    }
                    None if tangent.corners.come_back() => {
                        start.back(self);
                        tangent.tried.clear();
                        found.steps += 1;
                    }
                    None => {
                        start.back(self);
                        shift = (16.0 * shift).max(LEAST * 100.0 * scale);
                        stuck = shift > LARGEST * highest;
                    }
                }
            }
            if stuck && !hangs {
                break;
            }
            if stuck {
                (shift, tiny) = (FIRST * scale, 0);
                self.stop_hanging(&mut hanging);
            }
        }
        if let Some((on_it, kept)) = ledge {
            kept.back(self);
            self.look(&mut tangent, false, true)?;
            return Ok(Found { rests: true, stable: Some(false), ends: true, ..on_it });
        }
        Ok(found)
    }

    /// `1/h²` of the longest stable step: the square of the highest frequency, nearly.
    pub(super) fn highest(&self) -> f64 {
        let stable = self.stable_step();
        if stable.is_finite() && stable > 0.0 { 1.0 / (stable * stable) } else { 1.0 }
    }

    /// The square of the frequency with which a wave of tension or bending goes from end to end, or what hangs swings: the largest of the bodies.
    fn slowest(&self) -> Option<f64> {
        let of = |body: &Moving| {
            let material = &body.body.material;
            let square = body.body.size().powi(2);
            (material.stiffness + material.bending / square) / (material.mass * square)
        };
        let moving = self.bodies.iter().filter(|body| body.mass.is_some());
        let slow = moving.map(of).fold(self.gravity.norm() / self.size, f64::max);
        (slow > 0.0 && slow.is_finite()).then_some(slow)
    }

    /// Rows and forces where things are.
    fn look(&mut self, tangent: &mut Tangent, still: bool, fairly: bool) -> Result<()> {
        self.recollect()?;
        self.stay_on_corners(tangent, still, fairly)?;
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
    fn balance(&mut self, tangent: &Tangent, left: &[f64]) -> Result<(f64, bool)> {
        let rounding = self.rounding();
        let beyond = (0..3 * rounding.len())
            .filter_map(|coordinate| Some(left[tangent.place(coordinate)?].abs() - rounding[coordinate / 3]));
        let most = beyond.fold(0.0, f64::max);
        let met = self.desk.gap.iter().all(|gap| gap.abs() <= super::settle::MET * self.size);
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
        [scale, highest]: [f64; 2],
        step: &mut Step,
    ) -> Result<bool> {
        let mut part = Part::Whole;
        let given = *shift;
        // Near rest, and by turns where the convex part alone was of use before, the whole of it with more of a shift.
        let shifts =
            if residual < NEARLY || step.part == Some(Part::Absolute) { 1e-4 } else { 100.0 * LEAST };
        while !tangent.factor(self, part, *shift)? {
            if part == Part::Whole && *shift < shifts * scale {
                // Where something may turn freely, a little is enough.
                *shift = (30.0 * *shift).max(LEAST * scale);
            } else if part == Part::Whole {
                part = Part::Absolute;
                *shift = given.max(100.0 * LEAST * scale);
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

    /// `Q + Aᵀλ` where things are, over the unknowns.
    pub(super) fn left(&self, tangent: &Tangent, multipliers: &[f64], out: &mut Vec<f64>) {
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
            out[first + parameter] += if tangent.stays(parameter) { 0.0 } else { by * multipliers[equation] };
        }
    }

    /// The multipliers of all equations.
    pub(super) fn present_multipliers(&self) -> Vec<f64> {
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
