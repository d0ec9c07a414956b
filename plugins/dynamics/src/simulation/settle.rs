//! The static answer: where everything rests.

use loftsman_kernel::shape::Location;

use super::descent::Start;
use super::equilibrium::{Found, Search};
use super::implicit::Implicit;
use super::{Moving, Simulation};
use crate::error::{DynamicsError, Result};
use crate::link::Link;
use crate::points::Rule;
use crate::scheme::Scheme;

/// How a simulation came to rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settled {
    /// What force is left on a control vertex that nothing balances, beyond what rounding of the vertices makes, or along the shape at a place that
    /// slides (on both sides of which within 1e-7 of the size it pulls the same way), relative to the largest that acts on one. 0 of what is slack: where
    /// nothing but tension acts, and that is below a millionth of the stiffness.
    pub residual: f64,
    /// The largest way of a control vertex in the last step.
    pub way: f64,
    /// How many steps it took.
    pub steps: usize,
    /// Whether it rests: the residual is below 1e-9.
    pub rests: bool,
    /// Whether the balance is stable: the energy falls in no direction that the constraints allow, places that slide among them, by its second
    /// derivatives, to 1e-10 of the square of the highest frequency (a direction that is neither here nor there counts as none; a place on a corner
    /// that holds it stays). `None` where these do not tell.
    pub stable: Option<bool>,
    /// What is farthest from rest, where it does not.
    pub unrest: Option<Unrest>,
    /// At how many places that slide a curve without bending turns within its spans, for no rest with corners there was found that is as low; 0 where corners were not looked for.
    pub turns: usize,
}

/// What does not rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unrest {
    /// A constraint is not met: by its number.
    Missed(usize),
    /// Something pulls a place of this constraint along its shape.
    Slides(usize),
    /// Forces on a control vertex do not balance: by the numbers of its body and of the vertex.
    Vertex(usize, usize),
}

/// It rests where this is left of the forces.
pub(super) const RESTS: f64 = 1e-9;
/// How far to both sides of a place that slides its forces are looked at, as a share of the size.
const ACROSS: f64 = 1e-7;
/// The share of what constraints miss that they are drawn nearer in a step, less where that cannot be.
const SHARE: f64 = 0.5;
/// What a constraint misses by less than this share of the size is met at once.
const NEAR: f64 = 1e-3;
/// What is slack pulls with no more than this share of the force that would stretch it to twice its length.
const SLACK: f64 = 1e-6;
/// More steps than this are not taken.
const MOST: usize = 250;
/// Of this share of the size constraints may be missed at rest.
pub(super) const MET: f64 = 1e-9;
/// So often Newton's steps and implicit ones follow each other, as long as energy falls by this share of what it is made of.
const ROUNDS: usize = 6;
const LOWER: f64 = 1e-10;
/// What is stretched by more than this on average that steps do not see, and has more than that share of energy more than they say, is not as they take it for.
pub(crate) const SLIGHT: f64 = 1e-3;
pub(crate) const UNSEEN: f64 = 0.01;

impl Simulation {
    /// Goes to where everything rests, all constraints held that hold now: to a least energy that these allow, by Newton's method for vertices,
    /// multipliers and places that slide (shortened and turned down where it would not lead there); from an unstable balance it goes on down.
    /// Where that does not arrive, by implicit steps from rest that grow while they do, and where these rest it is looked at again. A place rests on
    /// a corner of its shape where it is pulled there from both sides; one that slides along a curve that moves, in the span where the energy is lowest of those
    /// beside. Time stands still; how far from rest it ends is said. A step costs a Cholesky factor within the envelope of the stiffness.
    ///
    /// Where a curve without bending turns at a place that slides along it, by 3 degrees or more, it is given a corner there: knots of the multiplicity
    /// of its degree, so that it has more control vertices afterwards ([`corners`](Self::corners) tells). They are where both sides are stretched alike at the place, to 1e-8 (within 1e-5 of a span
    /// of a knot, on that knot), each as all of it says to the next place that is held or where something acts. A rope that bends turns along a length, `√(EI/T)` at a tension
    /// `T`, and has no corner, at which its energy would be infinite. Where no rest with corners is found that is as low (as in a loop that is drawn shut, or where somebody knows control vertices by number), all is as
    /// [`settle_without_corners`](Self::settle_without_corners) leaves it, and [`Settled::turns`] counts the places. Costs as many settlings more as the knots are moved, some five.
    ///
    /// # Errors
    /// When nothing holds it, or nothing any more, where its weight or a force draws it; when stiffness drowns the mass; when numbers grow beyond all
    /// bounds. Where rest is not found it ends in the best state that was, and [`Settled`] says how far from rest that is.
    pub fn settle(&mut self) -> Result<Settled> {
        self.settle_as(true)
    }

    /// As [`settle`](Self::settle), with all shapes' knots as they are: a place in a curve that turns there rests where its sides pull alike along the tangent within a
    /// span, and lengths on both sides differ by what half a span is of them.
    ///
    /// # Errors
    /// As for [`settle`](Self::settle).
    pub fn settle_without_corners(&mut self) -> Result<Settled> {
        self.settle_as(false)
    }

    /// By few points a span first, of which those that rest in a turn are free to bend; where these miss how it is stretched, by as many as see that, from there.
    fn settle_as(&mut self, corners: bool) -> Result<Settled> {
        self.see(Rule::Few);
        let found = self.settle_once(corners)?;
        let misses = |body: &Moving| {
            let q = body.body.shape.control_vertices();
            body.elastic.as_ref().is_some_and(|elastic| elastic.misses(q, UNSEEN, SLIGHT))
        };
        if !self.bodies.iter().any(misses) {
            return Ok(found);
        }
        self.see(Rule::Full);
        let again = self.settle_once(corners)?;
        Ok(Settled { steps: found.steps + again.steps, ..again })
    }

    /// Energies are summed up by this rule from now on.
    pub(super) fn see(&mut self, rule: Rule) {
        self.bodies.iter_mut().filter_map(|body| body.elastic.as_mut()).for_each(|elastic| elastic.see(rule));
    }

    fn settle_once(&mut self, corners: bool) -> Result<Settled> {
        let (time, worst, told) = (self.time, self.worst, self.events.len());
        self.come_and_go()?;
        // Who looks for rest knows corners by himself.
        self.links.iter_mut().for_each(|link| link.stands.fill(false));
        (self.settling, self.held) = (true, None);
        let settled = self.go_to_rest().and_then(|settled| match settled.rests {
            true => self.rest_over_spans(settled),
            false => Ok(settled),
        });
        let settled = settled.and_then(|settled| match corners && settled.rests {
            true => self.rest_at_corners(settled),
            false => Ok(settled),
        });
        self.rest();
        self.note_events();
        self.take_back_events(told);
        self.let_all_go();
        let mut desk = std::mem::take(&mut self.desk);
        let collected = self.collect(&mut desk);
        self.desk = desk;
        let agreed = collected.and_then(|()| self.agree());
        let unrest = self.farthest_from_rest();
        self.settling = false;
        self.time = time;
        // What drifted on the way is not forgotten.
        self.worst = self.worst.max(worst);
        self.links.iter_mut().for_each(|link| link.begin_turns(false));
        let settled = settled?;
        agreed?;
        let vertices = self.bodies.iter().flat_map(|body| body.body.shape.control_vertices());
        if vertices.flat_map(|vertex| vertex.iter()).any(|v| !v.is_finite()) {
            return Err(DynamicsError::NoRest);
        }
        Ok(if settled.rests { settled } else { Settled { unrest, ..settled } })
    }

    /// Of the events from number `first` on, those are taken back that tell of what let go on the way only, and holds where it ends.
    fn take_back_events(&mut self, first: usize) {
        let mut number = 0;
        self.events.retain(|event| {
            number += 1;
            number <= first || !event.let_go || !self.links[event.constraint].is_held()
        });
    }

    /// What does not rest, most of all: a constraint that is missed, else where forces do not balance. To be asked when rows are collected.
    fn farthest_from_rest(&mut self) -> Option<Unrest> {
        self.predict();
        self.gather_forces();
        let held = || self.links.iter().enumerate().filter(|(_, link)| link.is_held());
        let (mut missed, mut first) = ((0.0, 0), 0);
        for (index, link) in held() {
            let gaps = self.desk.gap.get(first..first + link.equations).unwrap_or_default();
            missed = gaps
                .iter()
                .fold(missed, |most, gap| if gap.abs() > most.0 { (gap.abs(), index) } else { most });
            first += link.equations;
        }
        if missed.0 > MET * self.size {
            return Some(Unrest::Missed(missed.1));
        }
        let mut left = self.forces.clone();
        let multipliers = self.present_multipliers();
        self.space.entries(|equation, coordinate, a| {
            left[coordinate] += a * multipliers.get(equation).copied().unwrap_or(0.0);
        });
        let (mut most, mut unrest) = (0.0, None);
        for (index, body) in self.bodies.iter().enumerate().filter(|(_, body)| body.mass.is_some()) {
            for (vertex, force) in left[body.range()].chunks_exact(3).enumerate() {
                let force = force.iter().fold(0.0_f64, |most, f| most.max(f.abs()));
                if force > most {
                    (most, unrest) = (force, Some(Unrest::Vertex(index, vertex)));
                }
            }
        }
        let mut along = vec![0.0; self.desk.parameters];
        for &(equation, parameter, by) in &self.desk.changes {
            along[parameter] += by * multipliers.get(equation).copied().unwrap_or(0.0);
        }
        let owners = held().flat_map(|(index, link)| std::iter::repeat_n(index, link.slides.len()));
        for (pull, index) in along.iter().zip(owners) {
            if pull.abs() > most {
                (most, unrest) = (pull.abs(), Some(Unrest::Slides(index)));
            }
        }
        unrest
    }

    /// By Newton's steps, and where these end by implicit ones; where those come to rest it is Newton's matrix again that tells whether it is one, and
    /// that leads on where it is not.
    fn go_to_rest(&mut self) -> Result<Settled> {
        let (mut steps, mut kept) = (0, Start::default());
        let mut rested: Option<(Settled, f64)> = None;
        for round in 0..ROUNDS {
            let rested_to = rested.map(|(settled, _)| settled.residual);
            let found = self.find_rest(Search { rested: rested_to, still: false, most: usize::MAX })?;
            steps += found.steps;
            if found.ends {
                let Found { residual, way, rests, stable, .. } = found;
                let way = rested.filter(|_| found.steps == 0).map_or(way, |(settled, _)| settled.way);
                return Ok(Settled { residual, way, steps, rests, stable, unrest: None, turns: 0 });
            }
            let Found { residual, way, met, .. } = found;
            let newton = Settled { residual, way, steps, rests: false, stable: None, unrest: None, turns: 0 };
            let mut there = Start::default();
            there.remember(self);
            let (energy, sizes) = self.potential();
            if let Some((settled, least)) = rested
                && (round + 1 == ROUNDS || energy > least - LOWER * sizes)
            {
                // It rested as far as forces tell, and nothing leads on.
                kept.back(self);
                return Ok(settled);
            }
            let settled = match (self.march_to_rest(steps), rested) {
                (Err(_), Some((settled, _))) => {
                    kept.back(self);
                    return Ok(settled);
                }
                (settled, _) => settled?,
            };
            if !settled.rests {
                // The better of both ends.
                let drawn =
                    self.links.iter().filter(|link| link.is_held()).all(|link| link.error <= MET * self.size);
                if met && !(drawn && settled.residual <= newton.residual) {
                    there.back(self);
                    return Ok(Settled { steps: settled.steps, ..newton });
                }
                return Ok(settled);
            }
            steps = settled.steps;
            kept.remember(self);
            rested = Some((settled, self.potential().0));
        }
        rested.map_or_else(|| self.march_to_rest(steps), |(settled, _)| Ok(settled))
    }

    /// By implicit steps from rest that grow while they arrive: where Newton's steps do not lead on. `before` steps were taken.
    fn march_to_rest(&mut self, before: usize) -> Result<Settled> {
        let scheme = self.scheme;
        let given = (scheme != Scheme::Implicit).then(|| {
            let (implicit, space) = Implicit::new(&self.bodies);
            let own = std::mem::replace(&mut self.space, space);
            self.scheme = Scheme::Implicit;
            self.implicit = Some(Box::new(implicit));
            own
        });
        let settled = self.march(before);
        if let Some(space) = given {
            self.space = space;
            self.implicit = None;
            self.scheme = scheme;
        }
        settled
    }

    fn march(&mut self, before: usize) -> Result<Settled> {
        let natural = self.natural_time();
        let (mut step, mut share) = (natural, SHARE);
        let mut settled = Settled {
            residual: f64::INFINITY,
            way: f64::INFINITY,
            steps: before,
            rests: false,
            stable: None,
            unrest: None,
            turns: 0,
        };
        let time = self.time;
        while settled.steps < before + MOST && !settled.rests {
            self.rest();
            self.approach(share)?;
            match self.step_implicitly(step) {
                Ok(()) => {}
                // However short the way: it stays where it is.
                Err(DynamicsError::NoRest) if step < 1e-9 * natural => break,
                Err(error) if step < 1e-9 * natural => return Err(error),
                Err(_) => {
                    (step, share) = (0.125 * step, 0.5 * share);
                    continue;
                }
            }
            self.time = time;
            settled.steps += 1;
            settled.way = self.half.iter().fold(0.0_f64, |most, v| most.max((step * v).abs()));
            settled.residual = self.unbalanced(step)?;
            // Where what it lets constraints miss has been let go, and forces balance.
            let drawn =
                self.links.iter().filter(|link| link.is_held()).all(|link| link.error <= MET * self.size);
            settled.rests = settled.residual <= RESTS && drawn;
            step = (2.0 * step).min(1e6 * natural);
            share = (2.0 * share).min(SHARE);
            if settled.way <= 1e-15 * self.size && step >= 1e6 * natural {
                break;
            }
        }
        Ok(settled)
    }

    /// Constraints come nearer by a share of what they miss now, so that nothing is torn to its place at once.
    fn approach(&mut self, share: f64) -> Result<()> {
        let mut desk = std::mem::take(&mut self.desk);
        let collected = self.collect(&mut desk);
        desk.gap
            .iter_mut()
            .for_each(|gap| *gap *= if gap.abs() > NEAR * self.size { 1.0 - share } else { 0.0 });
        let none = vec![0.0; desk.gap.len()];
        let time = self.time;
        for link in self.links.iter_mut().filter(|link| link.is_held()) {
            let own = link.first..link.first + link.equations;
            link.begin(time);
            link.start(&desk.gap[own.clone()], &none[own], 0.0);
        }
        self.desk = desk;
        collected
    }

    /// A time in which things move by their own size: of a fall, or of a wave.
    fn natural_time(&self) -> f64 {
        let fall = (self.size / self.gravity.norm()).sqrt();
        let wave = 100.0 * self.stable_step();
        [fall, wave].into_iter().filter(|t| t.is_finite() && *t > 0.0).fold(f64::INFINITY, f64::min).min(1e6)
    }

    /// What accelerated it from rest, `M v / h`, beyond rounding, relative to the largest force on a vertex.
    fn unbalanced(&mut self, step: f64) -> Result<f64> {
        let along = self.pull_along()?;
        let rounding = self.rounding();
        let mut left = 0.0_f64;
        for body in &self.bodies {
            let Some(mass) = &body.mass else { continue };
            let own = &self.half[body.range()];
            for i in 0..mass.matrix.size() {
                for axis in 0..3 {
                    let momentum: f64 = mass.matrix.row(i).map(|(j, m)| m * own[3 * j + axis]).sum();
                    left = left.max((momentum / step).abs() - rounding[body.start + i]);
                }
            }
        }
        Ok(self.share_of_forces(left, along))
    }

    /// What rounding of its vertices makes of the forces on each, at most.
    pub(super) fn rounding(&self) -> Vec<f64> {
        let mut all = vec![0.0; self.space.vertices()];
        for body in &self.bodies {
            if let Some(elastic) = &body.elastic {
                let own = &mut all[body.start..body.start + body.count()];
                elastic.add_rounding(body.body.shape.control_vertices(), own);
            }
        }
        all
    }

    /// What is `left` of forces on a vertex and `along` shapes, relative to the largest that act on one.
    pub(super) fn share_of_forces(&self, left: f64, along: f64) -> f64 {
        let mut largest = 0.0_f64;
        for body in &self.bodies {
            let (Some(mass), Some(elastic)) = (&body.mass, &body.elastic) else { continue };
            largest = mass.lumped.iter().fold(largest, |most, m| most.max((m * self.gravity.amax()).abs()));
            let q = body.body.shape.control_vertices();
            let mut forces = vec![0.0; 3 * q.len()];
            elastic.add_forces(q, body.velocity.control_vertices(), &mut forces);
            largest = forces.iter().fold(largest, |most, f| most.max(f.abs()));
        }
        if self.is_slack(largest) {
            return 0.0;
        }
        let held = self.links.iter().filter(|link| link.is_held()).flat_map(|link| &link.multipliers);
        let holding = held.fold(largest, |most, f| most.max(f.abs()));
        let share = |left: f64, of: f64| if of > 0.0 { left / of } else { left };
        share(left, largest).max(share(along, holding))
    }

    /// Whether nothing but tension acts, and none of it that would stretch anything by more than a millionth, `largest` being the largest force on a
    /// vertex. What is slack folds at the scale of its vertices where ever smaller forces draw it, and never ends.
    fn is_slack(&self, largest: f64) -> bool {
        let of = |body: &Moving| {
            let elastic = body.elastic.as_ref()?;
            let width = if elastic.points.directions == 2 { body.body.size() } else { 1.0 };
            Some(elastic.given * width)
        };
        let least = self.bodies.iter().filter_map(of).fold(f64::INFINITY, f64::min);
        !self.buckles() && largest <= SLACK * least
    }

    /// The largest force along a shape at a place that slides: nothing where it pulls it forth from behind and back from ahead, as at a
    /// corner that holds it.
    pub(super) fn pull_along(&mut self) -> Result<f64> {
        let [behind, ahead, here] = self.pulls_beside()?;
        let left = |((a, b), own): ((&f64, &f64), &f64)| match (*a, *b) {
            (a, b) if a >= 0.0 && b <= 0.0 => 0.0,
            // It pulls away to both sides: from a corner, or from a place where nothing pulls.
            (a, b) if a * b <= 0.0 => a.abs().min(b.abs()).min(own.abs()),
            (a, b) => a.abs().min(b.abs()),
        };
        let held = self.links.iter().filter(|link| link.is_held());
        let pinned = held.flat_map(|link| link.pinned.iter().copied());
        let moves = behind.iter().zip(&ahead).zip(&here).zip(pinned).filter(|(_, pinned)| !pinned);
        Ok(moves.map(|(pulls, _)| left(pulls)).fold(0.0, f64::max))
    }

    /// The forces along shapes at places that slide, forth of which is positive: close behind them, close ahead of them, and there, by parameters.
    pub(super) fn pulls_beside(&mut self) -> Result<[Vec<f64>; 3]> {
        let links = || 0..self.links.len();
        let here: Vec<Vec<Location>> = links().map(|k| self.links[k].locations().collect()).collect();
        let near = ACROSS * self.size;
        let sides: [Vec<Vec<Location>>; 3] =
            [-near, near, 0.0].map(|by| links().map(|k| self.links[k].moved(|_| by).0.to_vec()).collect());
        let mut desk = std::mem::take(&mut self.desk);
        let mut pulls: [Vec<f64>; 3] = Default::default();
        let mut collected = Ok(());
        for (pulls, places) in pulls.iter_mut().zip(&sides) {
            self.links.iter_mut().zip(places).for_each(|(link, places)| link.put(places));
            collected = collected.and_then(|()| self.collect(&mut desk));
            pulls.resize(desk.parameters, 0.0);
            for &(equation, parameter, by) in &desk.changes {
                let holds = |link: &&Link| (link.first..link.first + link.equations).contains(&equation);
                let link = self.links.iter().filter(|link| link.is_held()).find(holds);
                let force = link.and_then(|link| link.multipliers.get(equation - link.first));
                pulls[parameter] += by * force.copied().unwrap_or(0.0);
            }
        }
        self.links.iter_mut().zip(&here).for_each(|(link, places)| link.put(places));
        self.desk = desk;
        collected?;
        Ok(pulls)
    }
}
