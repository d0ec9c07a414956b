//! Corners where ropes turn at places that slide.
//!
//! A rope that does not bend turns at a ring at a point; a spline turns within its spans, so that a ring in it rests where its sides pull alike along the tangent
//! within a span, and not where they are stretched alike. A knot of the multiplicity of the degree lets the curve turn at a point, and the place rests on it
//! for a whole range of differences between its sides: between the pulls of both is zero. Where in that range the rope itself rests is a condition on the knot: that
//! moving it along the rope changes the energy of rest by nothing, which for what is stretched alone is the same strain on both sides (`dE/dℓ = -k ε - k ε²/2` of a
//! side of the length `ℓ` at rest). Strain at the place is what a whole side says it is, its weight taken off: at a point it varies with what spans can do. So the knot is moved until they are the same: by Newton's steps, the sides taken for straight ones at first, and
//! after that by what steps have shown (Broyden 1965), each time inserted into the curve as it was.

use loftsman_kernel::shape::{Derivative, Location, Shape, cells_of, refine_of};
use loftsman_kernel::solve::{RangeSpace, Weight};
use loftsman_kernel::spline::Space;
use nalgebra::{DMatrix, DVector};

use super::advance::Before;
use super::descent::Start;
use super::equilibrium::Search;
use super::implicit::Implicit;
use super::moving::stable_step;
use super::settle::Settled;
use super::{Moving, Simulation, shapes};
use crate::error::{DynamicsError, Result};
use crate::scheme::Scheme;

/// A rope turns at a place that pulls across it by this share of its tension, or more: by 3 degrees.
const TURNS: f64 = 0.05;
/// Knots are moved so often at most, and rest is looked for in so many steps each time.
const ROUNDS: usize = 30;
const PATIENCE: usize = 200;
/// Strains are the same on both sides to this; what comes no nearer than the second, as a share of strain, is given up.
const SAME: f64 = 1e-8;
const ALIKE: f64 = 2e-3;
/// A knot goes no farther in a step than this share of a side, and stays this share away from its ends.
const FAR: f64 = 0.3;
/// Nearer to a knot than this share of a span it is that knot: a span so short would be strained by rounding, and let no step be stable that is not as short.
const MEETS: f64 = 1e-5;
/// Or than this share of the largest parameter: of a short domain far from 0 they are rounded coarsely.
const ROUNDED: f64 = 1e-10;
/// The same place is what differs by this share of two sides.
const SAME_PLACE: f64 = 1e-9;
/// A rest with corners is no higher than that without, by this share of what energies are made of.
const HIGHER: f64 = 1e-9;
/// Ways of knots that change strains by less than this share of what others do are not gone.
const ALONG: f64 = 1e-3;
/// Sweeps of a singular value decomposition, which takes far fewer.
const SWEEPS: usize = 1000;
/// More places than this are not looked at together.
const MOST: usize = 100;

/// A corner that a curve was given where it turns at a place that slides along it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    /// The constraint whose place is there.
    pub constraint: usize,
    /// The body that turns there.
    pub body: usize,
    /// The knot.
    pub at: f64,
    /// How many were inserted there, so that it is as many as the degree.
    pub knots: usize,
}

/// A place at which a curve turns.
struct Kink {
    link: usize,
    place: usize,
    body: usize,
}

/// Where knots are and how many were inserted for each; and in how many steps rest was found with them.
type Knotted = (Vec<(f64, usize)>, usize);

/// What all was before it had corners.
struct Smooth {
    bodies: Vec<Moving>,
    start: Start,
}

impl Simulation {
    /// The constraints with a place that slides where a curve turns that could be given a corner there.
    pub(crate) fn turning(&self) -> Result<Vec<usize>> {
        let mut all: Vec<usize> = self.kinks()?.iter().map(|kink| kink.link).collect();
        all.dedup();
        Ok(all)
    }

    /// All corners that curves were given where they turn at places that slide, as [`settle`](Self::settle) gives them.
    pub fn corners(&self) -> &[Corner] {
        &self.corners
    }

    /// Of something at rest: the corners that it is given where it turns at places that slide, and how it rests then.
    pub(super) fn rest_at_corners(&mut self, settled: Settled) -> Result<Settled> {
        let kinks = self.kinks()?;
        // What it was given a corner for before turns there, if no better one is found.
        let has_corner = |kink: &&Kink| {
            let at = self.links[kink.link].places[kink.place].location;
            self.corners
                .iter()
                .any(|c| (c.constraint, c.body) == (kink.link, kink.body) && at == Location::Curve(c.at))
        };
        let corners = kinks.iter().filter(has_corner).count();
        let settled = Settled { turns: kinks.len() - corners, ..settled };
        if kinks.is_empty() || kinks.len() > MOST {
            return Ok(settled);
        }
        let (before, sizes) = self.whole_potential()?;
        let mut start = Start::default();
        start.remember(self);
        let smooth = Smooth { bodies: self.bodies.clone(), start };
        let found = self.move_corners(&kinks, &smooth);
        self.links.iter_mut().for_each(|link| link.pinned.fill(false));
        let again = match found {
            // Nothing holds it to its corners any more; and there it rests.
            Ok(Some((knots, steps))) => self.rest_there(&kinks, &knots).and_then(|rest| {
                // What turns within its spans has more energy than it would have at a corner: a rest that has more is another one, higher up.
                let lower = self.whole_potential()?.0 <= before + HIGHER * sizes;
                let as_stable = |rest: &Settled| rest.stable == settled.stable || rest.stable == Some(true);
                Ok(rest.filter(|rest| lower && as_stable(rest)).map(|rest| (knots, steps, rest)))
            }),
            Ok(None) => Ok(None),
            Err(error) => Err(error),
        };
        let (knots, steps, rest) = match again {
            Ok(Some(found)) => found,
            other => {
                self.replace(smooth.bodies)?;
                smooth.start.back(self);
                self.recollect()?;
                return match other {
                    // There it goes beyond all numbers, what is held contradicts itself, or spans are too short to be told apart: no rest with corners.
                    Ok(_)
                    | Err(
                        DynamicsError::NoRest
                        | DynamicsError::Torn { .. }
                        | DynamicsError::Conflict { .. }
                        | DynamicsError::Collapsed { .. }
                        | DynamicsError::Massless { .. }
                        | DynamicsError::Geometry(_),
                    ) => Ok(settled),
                    Err(error) => Err(error),
                };
            }
        };
        self.corners.extend(kinks.iter().zip(&knots).map(|(kink, (at, knots))| Corner {
            constraint: kink.link,
            body: kink.body,
            at: *at,
            knots: *knots,
        }));
        let steps = settled.steps + steps + rest.steps;
        Ok(Settled { steps, turns: 0, ..rest })
    }

    /// Where it rests from here, if each place stays on its corner.
    fn rest_there(&mut self, kinks: &[Kink], knots: &[(f64, usize)]) -> Result<Option<Settled>> {
        let found = self.find_rest(Search { rested: None, still: false, most: PATIENCE })?;
        let stays = kinks.iter().zip(knots).all(|(kink, (at, _))| {
            let link = &self.links[kink.link];
            link.is_held() && link.places[kink.place].location == Location::Curve(*at)
        });
        let settled = Settled {
            residual: found.residual,
            // Where it rested already it went nowhere.
            way: if found.steps == 0 { 0.0 } else { found.way },
            steps: found.steps,
            rests: found.rests,
            stable: found.stable,
            unrest: None,
            turns: 0,
        };
        Ok((stays && found.ends && found.rests).then_some(settled))
    }

    /// The places at which curves turn that do not bend, and can be given knots.
    fn kinks(&self) -> Result<Vec<Kink>> {
        let mut all = Vec::new();
        for (link, own) in self.links.iter().enumerate().filter(|(_, own)| own.is_held()) {
            let force = own.multipliers.iter().map(|f| f * f).sum::<f64>().sqrt();
            for (place, at) in own.places.iter().enumerate().filter(|(_, place)| place.floats) {
                let (Location::Curve(u), moving) = (at.location, &self.bodies[at.body]) else { continue };
                let Some(elastic) = &moving.elastic else { continue };
                let shape = moving.body.shape.as_ref();
                let known = shape.refine().is_some()
                    && cells_of(shape, "a corner").is_ok_and(|cells| cells.splines().is_some())
                    && !self.links.iter().any(|link| link.is_held() && link.knows_vertices())
                    && self.applied.iter().all(|force| *force == 0.0);
                let inside = shape
                    .domain()
                    .first()
                    .is_some_and(|side| side.periodic || u > side.start && u < side.end);
                if elastic.bend.is_some() || own.order_at(place) > 0 || !known || !inside {
                    continue;
                }
                // Of the sides, for where it turns within a span it may be pushed together.
                let [behind, ahead] = self.ways(at.body, u)?;
                let strain = self.stretch_between(at.body, u - behind, u)?;
                let strain = strain.max(self.stretch_between(at.body, u, u + ahead)?);
                if strain > 0.0 && force > TURNS * strain * elastic.given {
                    all.push(Kink { link, place, body: at.body });
                }
            }
        }
        Ok(all)
    }

    /// Moves knots until strains on both sides of each are the same: where they are then, how many were inserted, and in how many steps.
    fn move_corners(&mut self, kinks: &[Kink], smooth: &Smooth) -> Result<Option<Knotted>> {
        let count = kinks.len();
        let start = |kink: &Kink| self.links[kink.link].places[kink.place].location.on_curve();
        let start: Vec<f64> = kinks.iter().map(start).collect::<loftsman_kernel::Result<_>>()?;
        let mut at = DVector::from_vec(start);
        let mut steps = 0;
        // The last that was found: knots, differences of strain, and how these change.
        let mut last: Option<(DVector<f64>, DVector<f64>, DMatrix<f64>)> = None;
        let mut best: Option<(f64, DVector<f64>)> = None;
        let mut done = false;
        for _ in 0..ROUNDS {
            let Some((knots, taken)) = self.rest_with_knots(kinks, smooth, at.as_slice())? else {
                // Half as far.
                let Some((before, ..)) = &last else { return Ok(None) };
                at = (&at + before) * 0.5;
                continue;
            };
            steps += taken;
            // Where knots are: on those that they meet.
            let strains: Vec<[f64; 2]> = (kinks.iter().zip(&knots))
                .map(|(kink, (at, _))| self.strains_of_sides(kink.body, *at))
                .collect::<Result<_>>()?;
            let apart = DVector::from_iterator(count, strains.iter().map(|[behind, ahead]| ahead - behind));
            let largest = strains.iter().flatten().fold(0.0_f64, |most, strain| most.max(strain.abs()));
            let off = apart.amax();
            if off <= SAME * (1.0 + largest) || done {
                return Ok((off <= ALIKE * largest).then_some((knots, steps)));
            }
            if best.as_ref().is_none_or(|(least, _)| off < *least) {
                best = Some((off, at.clone()));
            }
            let sides = self.sides_of(kinks, at.as_slice())?;
            let mut changes = match last.take() {
                None => changes(kinks, &strains, &sides),
                Some((before, was, mut changes)) => {
                    // What the step has shown.
                    let way = &at - before;
                    let missed = &apart - was - &changes * &way;
                    let square = way.norm_squared();
                    if square > 0.0 {
                        changes += missed * way.transpose() / square;
                    }
                    changes
                }
            };
            let solved = least(changes.clone(), &apart);
            // What is apart is the slope of the energy of rest, times the stiffness: downhill only, or it comes to a place where a side that is longer pulls harder, as of a chain
            // over two pulleys that hangs evenly. One that leads nowhere, or up, is that of straight sides again, whose energy is convex.
            let downhill = |step: &DVector<f64>| step.iter().all(|v| v.is_finite()) && step.dot(&apart) < 0.0;
            let step = match solved.filter(downhill) {
                Some(step) => step,
                None => {
                    changes = self::changes(kinks, &strains, &sides);
                    let Some(step) = least(changes.clone(), &apart).filter(downhill) else { return Ok(None) };
                    step
                }
            };
            let mut share = 1.0_f64;
            for (step, side) in step.iter().zip(&sides) {
                let room = FAR * side.ways[usize::from(*step > 0.0)];
                if step.abs() > room {
                    share = share.min(room / step.abs());
                }
            }
            let next = &at + step * share;
            let next = DVector::from_iterator(
                count,
                next.iter().zip(kinks).map(|(at, kink)| self.wrapped(kink.body, *at)),
            );
            // No nearer than rounding, or at knots that it meets.
            let same = |(kink, (a, b)): (&Kink, (&f64, &f64))| {
                self.snapped(kink.body, *a) == self.snapped(kink.body, *b)
            };
            done = (&next - &at).amax() <= f64::EPSILON * at.amax()
                || kinks.iter().zip(next.iter().zip(at.iter())).all(same);
            last = Some((at, apart, changes));
            at = next;
        }
        // Where it came nearest.
        let Some((_, at)) = best else { return Ok(None) };
        let Some((knots, taken)) = self.rest_with_knots(kinks, smooth, at.as_slice())? else {
            return Ok(None);
        };
        let mut alike = true;
        for (kink, (at, _)) in kinks.iter().zip(&knots) {
            let [behind, ahead] = self.strains_of_sides(kink.body, *at)?;
            alike &= (ahead - behind).abs() <= ALIKE * ahead.abs().max(behind.abs());
        }
        Ok(alike.then_some((knots, steps + taken)))
    }

    /// A parameter of a body, or the knot that it meets.
    fn snapped(&self, body: usize, at: f64) -> f64 {
        let shape = self.bodies[body].body.shape.as_ref();
        match cells_of(shape, "a corner").ok().and_then(|cells| cells.splines()) {
            Some(splines) => nearest_knot(splines.u, at),
            None => at,
        }
    }

    /// The potential of all forces, with what steps do not see of stretching; and the sum of its parts' amounts.
    fn whole_potential(&self) -> Result<(f64, f64)> {
        let (energy, sizes) = self.potential();
        let unseen = self.unseen_energy()?;
        Ok((energy + unseen, sizes + unseen.abs()))
    }

    /// A parameter of a body within its domain: round where that is closed.
    pub(super) fn wrapped(&self, body: usize, at: f64) -> f64 {
        match self.bodies[body].body.interval(0) {
            Some(side) if side.periodic => side.start + (at - side.start).rem_euclid(side.end - side.start),
            _ => at,
        }
    }

    /// All as it was, with knots at these places, which stay on them, at rest: the knots as they are, how many were inserted for each, and in how many steps.
    fn rest_with_knots(&mut self, kinks: &[Kink], smooth: &Smooth, at: &[f64]) -> Result<Option<Knotted>> {
        let mut bodies = smooth.bodies.clone();
        let mut knots = Vec::with_capacity(kinks.len());
        for (kink, &at) in kinks.iter().zip(at) {
            let moving = &mut bodies[kink.body];
            let cells = cells_of(moving.body.shape.as_ref(), "a corner")?;
            let Some(splines) = cells.splines() else { return Ok(None) };
            let at = nearest_knot(splines.u, at);
            let more = splines.u.degree().saturating_sub(splines.u.multiplicity(at));
            let inserted = vec![at; more];
            let refined = |shape: &dyn Shape| refine_of(shape, "a corner")?.refined(0, &inserted);
            let mut first = moving.body.shape.boxed();
            first.control_vertices_mut().copy_from_slice(&moving.first);
            moving.first = refined(first.as_ref())?.control_vertices().to_vec();
            moving.body.shape = refined(moving.body.shape.as_ref())?;
            knots.push((at, more));
        }
        for (index, moving) in bodies.iter_mut().enumerate() {
            if kinks.iter().any(|kink| kink.body == index) {
                moving.prepare_again()?;
            }
        }
        self.replace(bodies)?;
        smooth.start.back_to_places(self);
        for (kink, (at, _)) in kinks.iter().zip(&knots) {
            let link = &mut self.links[kink.link];
            let mut places: crate::link::Places = link.locations().collect();
            places[kink.place] = Location::Curve(*at);
            link.put(&places);
            link.pin(kink.place);
        }
        self.recollect()?;
        let found = self.find_rest(Search { rested: None, still: false, most: PATIENCE })?;
        let held = smooth.start.is_as_held(self);
        Ok((held && found.rests && found.met).then_some((knots, found.steps)))
    }

    /// Puts these bodies in the place of those that are there, at rest.
    fn replace(&mut self, mut bodies: Vec<Moving>) -> Result<()> {
        let mut start = 0;
        for body in &mut bodies {
            body.start = start;
            start += body.count();
        }
        self.bodies = bodies;
        let weights = self.bodies.iter().map(|body| match &body.mass {
            Some(mass) => (mass.weight.clone(), mass.order.clone()),
            None => (Weight::Still(body.count()), None),
        });
        let mut space = RangeSpace::new(weights.collect::<Vec<_>>());
        let all = shapes(&self.bodies);
        for load in &mut self.loads {
            load.refit(&all, &mut space)?;
        }
        for link in &mut self.links {
            link.refit(&all)?;
        }
        let numbers = 3 * start;
        // Nobody's own forces are where knots come.
        let whole = self.applied.len() == numbers;
        for all in [&mut self.half, &mut self.acceleration, &mut self.forces] {
            all.clear();
            all.resize(numbers, 0.0);
        }
        if !whole {
            self.applied = vec![0.0; numbers];
        }
        (self.last, self.before) = (0.0, Before::default());
        self.stable = stable_step(&self.bodies, &self.loads);
        self.space = space;
        if self.scheme == Scheme::Implicit {
            let (implicit, space) = Implicit::new(&self.bodies);
            self.space = space;
            self.implicit = Some(Box::new(implicit));
        }
        Ok(())
    }

    /// The strains on both sides of a place of a curve, behind and ahead, each as its whole side says.
    fn strains_of_sides(&self, body: usize, at: f64) -> Result<[f64; 2]> {
        let [behind, ahead] = self.ways(body, at)?;
        Ok([self.strain_at_end(body, at, at - behind)?, self.strain_at_end(body, at, at + ahead)?])
    }

    /// The sides of all kinks.
    fn sides_of(&self, kinks: &[Kink], at: &[f64]) -> Result<Vec<Sides>> {
        let mut all = Vec::with_capacity(kinks.len());
        for (kink, &own) in kinks.iter().zip(at) {
            let ways = self.ways(kink.body, own)?;
            let moving = &self.bodies[kink.body];
            let mut first = moving.body.shape.boxed();
            first.control_vertices_mut().copy_from_slice(&moving.first);
            let speed =
                first.value(Location::Curve(own), Derivative::from(1))?.norm() * moving.body.material.rest;
            // Who is at the other end of a side, if it is another kink.
            let mut neighbours = [None; 2];
            for (other, (_, &there)) in
                kinks.iter().zip(at).enumerate().filter(|(_, (other, _))| other.body == kink.body)
            {
                for (neighbour, to) in neighbours.iter_mut().zip([own - ways[0], own + ways[1]]) {
                    let apart = self.wrapped(kink.body, to) - there;
                    if there != own && apart.abs() <= SAME_PLACE * (ways[0] + ways[1]) {
                        *neighbour = Some(other);
                    }
                }
            }
            all.push(Sides { ways, speed, neighbours });
        }
        Ok(all)
    }
}

/// A parameter, or the knot that is close to it: within a small share of the spans beside that knot.
fn nearest_knot(space: &Space, at: f64) -> f64 {
    let (knots, (start, end)) = (space.breakpoints(), space.domain());
    let after = knots.partition_point(|knot| *knot <= at).clamp(1, knots.len().saturating_sub(1).max(1));
    let (Some(&low), Some(&high)) = (knots.get(after - 1), knots.get(after)) else { return at };
    let near = (MEETS * (high - low)).max(ROUNDED * start.abs().max(end.abs()));
    let knot = if (at - low).abs() <= near {
        low
    } else if (high - at).abs() <= near {
        high
    } else {
        at
    };
    // The end of what is closed is its start.
    if space.is_periodic() && knot == end { start } else { knot }
}

/// What is on both sides of a kink: how far it goes in parameters, and which kink is there.
struct Sides {
    ways: [f64; 2],
    /// Lengths at rest by parameters.
    speed: f64,
    neighbours: [Option<usize>; 2],
}

/// The least step that takes away what is apart: where all knots of a closed rope go on alike, sides stay as long as they are.
fn least(changes: DMatrix<f64>, apart: &DVector<f64>) -> Option<DVector<f64>> {
    if !changes.iter().all(|v| v.is_finite()) {
        return None;
    }
    let svd = changes.try_svd(true, true, f64::EPSILON, SWEEPS)?;
    let largest = svd.singular_values.amax();
    svd.solve(&-apart, ALONG * largest).ok()
}

/// How differences of strain change with knots, of straight sides: `(1 + ε) / ℓ` on each.
fn changes(kinks: &[Kink], strains: &[[f64; 2]], sides: &[Sides]) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(kinks.len(), kinks.len());
    for (row, (strains, side)) in strains.iter().zip(sides).enumerate() {
        for k in 0..2 {
            let length = side.ways[k].max(f64::MIN_POSITIVE) * side.speed;
            let by = (1.0 + strains[k]) / length * side.speed;
            all[(row, row)] += by;
            if let Some(other) = side.neighbours[k] {
                all[(row, other)] -= by;
            }
        }
    }
    all
}
