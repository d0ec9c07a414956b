//! Time goes on: in as many steps as are stable, and short enough that constraints hold.

use loftsman_kernel::Point;
use loftsman_kernel::shape::Location;

use super::conflict::contradictions;
use super::explicit::FINEST;
use super::{MOST, Simulation};
use crate::error::{DynamicsError, Result};
use crate::link::Phase;
use crate::points::Rule;
use crate::scheme::Scheme;

/// No constraint that is drawn in misses more than this share of the size, where steps can be made short enough.
pub(super) const KEPT: f64 = 5e-7;
/// Steps are made shorter by this at least and at most where one does, so often at most.
const SHORTER: [f64; 2] = [0.1, 0.7];
const TIMES: usize = 10;
/// Explicit steps are no longer than this share of the time constant by which a constraint is being drawn in: they keep to how it is to within three thousandths of what it missed.
const DRAWN: f64 = 0.125;
/// Where implicit steps, halved as often as they are, end where nothing does what is asked, all of it is gone again by these shares of a step: a shorter one may have kept from where no way leads on.
const FINER: [f64; 2] = [0.25, 0.0625];
/// What sums of steps may miss of their time.
const ROUNDED: f64 = 1e-9;

/// Shorter steps are of use where constraints drift by no more than this share of what they did; where so many in turn are of none, they are in vain. They are
/// tried again where drift has grown so many times.
const USE: f64 = 0.9;
const USELESS: usize = 3;
const AGAIN: f64 = 2.0;

/// Where an advance started, to go back to; its rooms are kept.
#[derive(Debug, Default)]
pub(crate) struct Before {
    vertices: Vec<Point>,
    half: Vec<f64>,
    acceleration: Vec<f64>,
    last: f64,
    time: f64,
    sub_steps: usize,
    places: Vec<Location>,
    /// Rates, accelerations and multipliers of links, one after another.
    numbers: Vec<f64>,
    phases: Vec<Phase>,
    /// How many events there were.
    events: usize,
    /// Of each parameter, whether it stands on a corner.
    stands: Vec<bool>,
    /// How much constraints drifted where steps were made shorter in vain; nothing where they were not.
    in_vain: Option<f64>,
}

impl Before {
    pub(super) fn remember(&mut self, simulation: &Simulation) {
        let Self { vertices, half, acceleration, places, numbers, phases, stands, .. } = self;
        vertices.clear();
        for body in &simulation.bodies {
            vertices.extend_from_slice(body.body.shape.control_vertices());
        }
        half.clone_from(&simulation.half);
        acceleration.clone_from(&simulation.acceleration);
        places.clear();
        numbers.clear();
        stands.clear();
        phases.clear();
        for link in &simulation.links {
            places.extend(link.locations());
            for all in [&link.rates, &link.accelerations, &link.multipliers] {
                numbers.extend_from_slice(all);
            }
            phases.push(link.phase.clone());
            stands.extend_from_slice(&link.stands);
        }
        (self.last, self.time, self.sub_steps) = (simulation.last, simulation.time, simulation.sub_steps);
        self.events = simulation.events.len();
    }

    /// Whether it is of this time.
    pub(super) fn is_of(&self, time: f64) -> bool {
        self.time == time
    }

    /// Whether all constraints do as they did.
    pub(super) fn is_as_held(&self, simulation: &Simulation) -> bool {
        self.phases.iter().eq(simulation.links.iter().map(|link| &link.phase))
    }

    pub(super) fn back(&self, simulation: &mut Simulation) {
        let mut vertices = &self.vertices[..];
        for body in &mut simulation.bodies {
            let (own, others) = vertices.split_at(body.count());
            body.body.shape.control_vertices_mut().copy_from_slice(own);
            vertices = others;
        }
        simulation.half.clone_from(&self.half);
        simulation.acceleration.clone_from(&self.acceleration);
        let (mut places, mut numbers, mut stands) = (&self.places[..], &self.numbers[..], &self.stands[..]);
        for link in &mut simulation.links {
            let (own, others) = places.split_at(link.places.len());
            link.put(own);
            places = others;
            for all in [&mut link.rates, &mut link.accelerations, &mut link.multipliers] {
                let (own, others) = numbers.split_at(all.len());
                all.copy_from_slice(own);
                numbers = others;
            }
            let (own, others) = stands.split_at(link.stands.len());
            link.stands.copy_from_slice(own);
            stands = others;
        }
        // What let go on the way holds again.
        simulation.links.iter_mut().zip(&self.phases).for_each(|(link, phase)| link.phase.clone_from(phase));
        simulation.events.truncate(self.events);
        (simulation.last, simulation.time, simulation.sub_steps) = (self.last, self.time, self.sub_steps);
    }
}

impl Simulation {
    /// Goes on by so many seconds: in one step, or as many as are stable and keep constraints within 1e-6 of the size; a step ends where a constraint, force or
    /// pull comes or goes. Within a step it stops where a place slides over a corner of its shape, and what velocities there have against the new tangent is taken out by an impulse. Explicit steps that let a constraint drift farther are taken again, shorter, down to 0.003 of what is stable; where that is of no use they stay as they
    /// were, and [`worst_error`](Self::worst_error) tells.
    ///
    /// # Errors
    /// When it blows up, constraints that come contradict others, or very many steps would be needed.
    pub fn advance(&mut self, seconds: f64) -> Result<()> {
        crate::error::check("the time to go on", seconds, false)?;
        self.see(Rule::Full);
        let end = self.time + seconds;
        // Sums of steps are rounded: what comes this near to the end comes there.
        let near = ROUNDED * seconds;
        let end = self.changes().find(|at| (at - end).abs() <= near).unwrap_or(end);
        while end - self.time > near {
            if self.changes().any(|at| at == self.time) {
                self.catch_up()?;
            }
            let next = self.changes().filter(|at| *at > self.time).fold(end, f64::min);
            if next - self.time > near {
                self.advance_evenly(next - self.time)?;
            }
            self.time = next;
        }
        self.time = end;
        Ok(())
    }

    /// When things come or go by their times, from now on.
    fn changes(&self) -> impl Iterator<Item = f64> + '_ {
        let links = self.links.iter().map(|link| match link.phase {
            Phase::Waiting => link.from,
            Phase::Held => link.until,
            Phase::Off { .. } => f64::INFINITY,
        });
        links.chain(self.loads.iter().flat_map(|load| load.times()))
    }

    /// Goes on by so many seconds in which nothing comes or goes by its time.
    fn advance_evenly(&mut self, seconds: f64) -> Result<()> {
        if self.scheme == Scheme::Implicit {
            return self.advance_implicitly(seconds);
        }
        self.reach = self.stable.min(seconds);
        // Of no more steps than are taken, with some to spare.
        self.finest = FINEST.max(2.0 * seconds / (MOST * self.reach)).min(1.0);
        self.fineness = self.fineness.max(self.finest);
        // What comes comes before.
        if self.come_and_go()? {
            let mut desk = std::mem::take(&mut self.desk);
            let checked = contradictions(self, &mut desk);
            self.desk = desk;
            checked?;
        }
        let mut before = std::mem::take(&mut self.before);
        before.remember(self);
        let alone = self.begin_to_look();
        let worst = std::mem::take(&mut self.worst);
        let given = (self.fineness, self.patience);
        let (mut first, mut best, mut useless) = (None, (f64::INFINITY, given), 0);
        let mut tried = given;
        let mut done = self.go_on(seconds).and_then(|()| self.drifted());
        for time in 0.. {
            let drift = self.worst;
            if done.is_err() || drift <= KEPT * self.size {
                before.in_vain = None;
                break;
            }
            if before.in_vain.is_some_and(|before| drift <= AGAIN * before) {
                break;
            }
            let first = *first.get_or_insert(drift);
            useless = if drift > USE * best.0 { useless + 1 } else { 0 };
            if drift < best.0 {
                best = (drift, tried);
            }
            // Of second order, cautiously: drift is of fourth.
            let shorter = (0.5 * KEPT * self.size / drift).sqrt().clamp(SHORTER[0], SHORTER[1]);
            // Where something let go steps have grown since.
            let length = self.length.min(tried.0 * self.reach);
            self.fineness = self.fineness.min(tried.0);
            // Where shorter steps are of no use they are as long as they were, or as those that were of some.
            let in_vain = time >= TIMES || useless == USELESS || !self.shorten(shorter * length);
            before.in_vain = None;
            if in_vain {
                let (drift, (fineness, patience)) =
                    if AGAIN * best.0 < first { best } else { (first, given) };
                before.in_vain = Some(drift);
                if tried == (fineness, patience) {
                    // So it was done.
                    break;
                }
                (self.fineness, self.patience) = (fineness, patience);
            }
            tried = (self.fineness, self.patience);
            before.back(self);
            self.worst = 0.0;
            // Velocities half a long step behind are of no use to short ones.
            self.catch_up()?;
            self.keep_to_rates()?;
            done = self.go_on(seconds).and_then(|()| self.drifted());
        }
        if done.is_ok() && alone {
            done = self.without_rise(seconds, &before, tried);
        }
        self.worst = self.worst.max(worst);
        self.before = before;
        done
    }

    /// The same by implicit steps, which let no constraint drift.
    fn advance_implicitly(&mut self, seconds: f64) -> Result<()> {
        self.reach = self.step.unwrap_or(f64::INFINITY).min(seconds);
        let whole = (1.0, 0);
        (self.fineness, self.patience) = whole;
        self.finest = 0.0;
        self.come_and_go()?;
        let mut before = std::mem::take(&mut self.before);
        before.remember(self);
        let alone = self.begin_to_look();
        let mut done = self.go_on(seconds);
        for finer in FINER {
            if !matches!(done, Err(DynamicsError::BlowsUp { .. } | DynamicsError::Vanishes { .. })) {
                break;
            }
            before.back(self);
            self.fineness = finer;
            done = self.go_on(seconds);
        }
        if done.is_ok() && alone {
            done = self.without_rise(seconds, &before, whole);
        }
        (self.fineness, self.before) = (1.0, before);
        done
    }

    /// How much constraints miss at the end of steps, which only the next would see.
    pub(super) fn drifted(&mut self) -> Result<()> {
        let mut desk = std::mem::take(&mut self.desk);
        let collected = self.collect(&mut desk);
        let time = self.time;
        // Where they could not be gathered there is nothing to look at.
        let gathered = self.links.iter().filter(|_| collected.is_ok());
        for link in gathered.filter(|link| link.is_held() && link.is_near(time)) {
            for equation in link.first..link.first + link.equations {
                let [let_go, ..] = link.offset(equation - link.first, time);
                self.worst = self.worst.max((desk.gap[equation] - let_go).abs());
            }
        }
        self.desk = desk;
        collected
    }

    pub(super) fn go_on(&mut self, seconds: f64) -> Result<()> {
        let end = self.time + seconds;
        loop {
            let left = end - self.time;
            if left.is_nan() || left <= ROUNDED * seconds {
                break;
            }
            let limit = self.limit();
            let needed = (left / limit * (1.0 - 1e-9)).ceil().max(1.0);
            if needed > MOST && self.step == Some(limit) {
                return Err(DynamicsError::TooShort { step: limit, whole: seconds, least: seconds / MOST });
            }
            if needed > MOST {
                return Err(DynamicsError::TooStiff { needed, step: seconds, stable: limit });
            }
            self.step(left / needed.max(self.resolving(left)))?;
        }
        // Sums of steps are rounded; their end is not.
        self.time = end;
        self.agree()?;
        self.bounded(self.length, true)
    }

    /// In how many explicit steps a time has to be gone so that they follow how constraints are drawn in now.
    fn resolving(&self, seconds: f64) -> f64 {
        if self.scheme == Scheme::Implicit {
            return 1.0;
        }
        let draws = self.links.iter().filter_map(|link| link.drawing(self.time));
        draws.fold(1.0, |most, draw| most.max((seconds / (DRAWN * draw)).ceil()))
    }

    /// The longest step that is taken now.
    pub(super) fn limit(&self) -> f64 {
        self.step.unwrap_or(f64::INFINITY).min(self.reach * self.fineness)
    }
}
