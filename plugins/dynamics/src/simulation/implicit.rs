//! Backward Euler: velocities at the end of the step, from the forces there.
//!
//! `M (v⁺ - v) = h Q(q + h v⁺, v⁺) + Lᵀλ`, `g(q + h v⁺, s + h ṡ⁺) = 0`, by Newton's iteration in the metric `M + h D + h² K`: each of its steps is a
//! least change again. Constraints are met in their places, not in their accelerations; parameters that float have no mass. What pushes
//! (a slack rope's negative stiffness) is left out of `K`, not out of `Q`. A step that does not arrive is taken in halves.

use loftsman_kernel::Point;
use loftsman_kernel::solve::{EnvelopeCholesky, RangeSpace, Weight};

use super::{Moving, Simulation, shapes};
use crate::error::{DynamicsError, Result};
use crate::link::{Link, Phase};
use crate::stiffness::{Part, Room};
use loftsman_kernel::shape::Location;

/// Newton's steps before a step is taken in halves; three times as many where locations turn round.
const ITERATIONS: usize = 16;
/// It has arrived where the next change is below this share of the size.
const ARRIVED: f64 = 1e-11;
/// It will do where it is below this.
const GOOD: f64 = 1e-7;
/// A place slides by this share of its shape in a step, no farther.
const SLIDES: f64 = 0.1;
/// A step is halved as often as this.
const HALVINGS: usize = 12;

/// Of a constraint as a step starts: rates, places, whether it holds, which of its parameters stand on corners.
type Sliding = (Vec<f64>, Vec<Location>, Phase, Vec<bool>);

/// What implicit steps need beside the simulation.
#[derive(Debug)]
pub(crate) struct Implicit {
    /// Where each vertex of each body stands in its factor.
    places: Vec<Vec<usize>>,
    before: Vec<f64>,
    vertices: Vec<Vec<Point>>,
    sliding: Vec<Sliding>,
    change: Vec<f64>,
    room: Room,
}

impl Implicit {
    /// Puts a metric of coordinates in the place of the masses.
    pub(crate) fn new(bodies: &[Moving]) -> (Self, RangeSpace) {
        let (mut weights, mut places, mut vertices) = (Vec::new(), Vec::new(), Vec::new());
        for body in bodies {
            let n = body.body.shape.control_vertices().len();
            vertices.push(body.body.shape.control_vertices().to_vec());
            let Some(mass) = &body.mass else {
                weights.push((Weight::Still(n), None));
                places.push(Vec::new());
                continue;
            };
            let mut place: Vec<usize> = (0..n).collect();
            if let Some(order) = &mass.order {
                order.iter().enumerate().for_each(|(at, &vertex)| place[vertex] = at);
            }
            let row_at = |i: usize| mass.order.as_ref().map_or(i, |order| order[i]);
            let first = (0..3 * n).map(|row| {
                let least = mass.matrix.row(row_at(row / 3)).map(|(j, _)| place[j]).min();
                3 * least.unwrap_or(row / 3).min(row / 3) as u32
            });
            weights
                .push((Weight::Coordinates(EnvelopeCholesky::envelope(first.collect())), mass.order.clone()));
            places.push(place);
        }
        let space = RangeSpace::new(weights);
        let numbers = 3 * space.vertices();
        let implicit = Self {
            places,
            before: vec![0.0; numbers],
            vertices,
            sliding: Vec::new(),
            change: vec![0.0; numbers],
            room: Room::default(),
        };
        (implicit, space)
    }

    fn remember(&mut self, bodies: &[Moving], links: &[Link], velocities: &[f64]) {
        self.before.copy_from_slice(velocities);
        for (kept, body) in self.vertices.iter_mut().zip(bodies) {
            kept.copy_from_slice(body.body.shape.control_vertices());
        }
        self.sliding.resize_with(links.len(), || (Vec::new(), Vec::new(), Phase::Waiting, Vec::new()));
        for ((rates, locations, phase, stands), link) in self.sliding.iter_mut().zip(links) {
            rates.clear();
            rates.extend_from_slice(&link.rates);
            locations.clear();
            locations.extend(link.locations());
            phase.clone_from(&link.phase);
            stands.clone_from(&link.stands);
        }
    }
}

impl Simulation {
    pub(crate) fn step_implicitly(&mut self, step: f64) -> Result<()> {
        let Some(mut implicit) = self.implicit.take() else { return Ok(()) };
        let end = self.time + step;
        let mut done = Ok(());
        let start = self.time;
        let mut length = step;
        let mut halvings = 0;
        // Who looks for rest takes another step instead.
        let most = if self.settling { 0 } else { HALVINGS };
        while done.is_ok() && end - self.time > 1e-9 * step {
            let own = length.min(end - self.time);
            match self.newton(&mut implicit, own) {
                Ok(true) => {
                    self.pauses += usize::from(own < step);
                    self.time += own;
                    self.worst = self.worst.max(self.missed);
                }
                Ok(false) if halvings < most => {
                    halvings += 1;
                    length *= 0.5;
                    self.pauses += 1;
                }
                Ok(false) if self.settling => done = Err(DynamicsError::NoRest),
                Ok(false) => {
                    let stable = self.stable_step();
                    let shapes = shapes(&self.bodies);
                    let mut held = self.links.iter().filter(|link| link.is_held() && !link.slides.is_empty());
                    let vanished = held.find(|link| link.is_vanishing(&shapes).unwrap_or(false));
                    if let Some(link) = vanished {
                        done =
                            Err(DynamicsError::Vanishes { constraint: link.name.clone(), time: self.time });
                        continue;
                    }
                    done = Err(DynamicsError::BlowsUp {
                        time: self.time,
                        step: own,
                        stable,
                        scheme: self.scheme,
                        fed: self.is_fed(),
                        slides: self.any_slides(),
                        strain: self.overload(),
                        lost: None,
                    });
                }
                Err(error) => done = Err(error),
            }
        }
        // Whoever steps counts the time.
        self.time = start;
        self.implicit = Some(implicit);
        done
    }

    /// One step of Newton's iteration after another; whether it arrives. Where it does not, all is as it was.
    fn newton(&mut self, implicit: &mut Implicit, step: f64) -> Result<bool> {
        if !self.settling {
            self.leave_corners_in_motion()?;
        }
        implicit.remember(&self.bodies, &self.links, &self.half);
        let (before, time) = (self.time, self.time + step);
        self.last = 0.0;
        // Who looks for rest stands still in time: targets stay where they are.
        (self.time, self.late) = if self.settling { (before, 0.0) } else { (time, 0.5 * step) };
        self.drift(step, 0.0);
        let settling = self.settling;
        self.links.iter_mut().for_each(|link| link.begin_turns(settling));
        let mut arrived = Ok(false);
        let mut last = f64::INFINITY;
        for iteration in 0..3 * ITERATIONS {
            // What is damped comes nearer by a part at a time.
            if iteration >= ITERATIONS && !self.links.iter().any(Link::has_turned) {
                break;
            }
            match self.correct(implicit, step) {
                Ok(change) if change <= ARRIVED * self.size => {
                    arrived = Ok(true);
                    break;
                }
                Ok(change) if change.is_finite() => {
                    last = change;
                    if !settling && self.stand_where_it_turns() {
                        last = f64::INFINITY;
                    }
                }
                Ok(_) => {
                    last = f64::INFINITY;
                    break;
                }
                Err(error) => {
                    arrived = Err(error);
                    break;
                }
            }
        }
        if let Ok(arrived) = &mut arrived {
            *arrived |= last <= GOOD * self.size;
            // Another answer of the same equations, far away, is none.
            *arrived &= self.is_near(implicit, step);
        }
        (self.time, self.late) = (before, 0.0);
        let arrives = matches!(arrived, Ok(true));
        if !settling || !arrives {
            // Explicit steps, and reports, know nothing of it.
            self.links.iter_mut().for_each(|link| link.begin_turns(false));
        }
        if !arrives {
            self.half.copy_from_slice(&implicit.before);
            for (body, kept) in self.bodies.iter_mut().zip(&implicit.vertices) {
                body.body.shape.control_vertices_mut().copy_from_slice(kept);
            }
            for (link, (rates, locations, phase, stands)) in self.links.iter_mut().zip(&implicit.sliding) {
                link.rates.copy_from_slice(rates);
                link.put(locations);
                link.phase.clone_from(phase);
                link.stands.copy_from_slice(stands);
            }
        }
        arrived
    }

    /// A place that turns round and round across a corner of its shape stands on it: where it is drawn to it from both sides no place beside has an answer. Whether there was such.
    fn stand_where_it_turns(&mut self) -> bool {
        let mut any = false;
        for link in self.links.iter_mut().filter(|link| link.is_held() && link.has_corners()) {
            for own in 0..link.stands.len() {
                any |= link.stand_where_it_turns(own);
            }
        }
        any
    }

    /// Whether everything is where it may have come to within one step: places that slide within a tenth of their shape, beyond the way that
    /// they were going, and vertices within the size of all, likewise.
    fn is_near(&self, implicit: &Implicit, step: f64) -> bool {
        let [before, now] = [&implicit.before, &self.half].map(|all| self.mean_speed(all));
        let sliding = self.links.iter().zip(&implicit.sliding).all(|(link, (rates, ..))| {
            link.slides.iter().zip(&link.rates).zip(rates).all(|((slide, now), before)| {
                let length = (slide.interval.end - slide.interval.start) / slide.pace;
                (now * step).abs() <= SLIDES * length + 2.0 * (before * step).abs()
            })
        });
        sliding && now * step <= self.size + 2.0 * before * step
    }

    /// One correction of the velocities at the end of the step; how far it moves a shape (its root mean square), or a parameter.
    fn correct(&mut self, implicit: &mut Implicit, step: f64) -> Result<f64> {
        self.predict();
        let mut desk = std::mem::take(&mut self.desk);
        let weighed = self.weigh(implicit, step);
        let collected = weighed.and_then(|()| self.collect(&mut desk));
        self.desk = desk;
        collected?;
        self.gather_forces();
        // h Q - M (v⁺ - v)
        for body in &self.bodies {
            let Some(mass) = &body.mass else { continue };
            let range = body.range();
            let (v, before) = (&self.half[range.clone()], &implicit.before[range.clone()]);
            let out = &mut self.forces[range];
            for (i, out) in out.chunks_exact_mut(3).enumerate() {
                let mut sum = [0.0; 3];
                for (j, m) in mass.matrix.row(i) {
                    (0..3).for_each(|axis| sum[axis] += m * (v[3 * j + axis] - before[3 * j + axis]));
                }
                (0..3).for_each(|axis| out[axis] = step * out[axis] - sum[axis]);
            }
        }
        self.right.clear();
        let mut missed = 0.0_f64;
        for link in self.links.iter_mut().filter(|link| link.is_held()) {
            link.error = 0.0;
            for equation in link.first..link.first + link.equations {
                let [let_go, ..] = link.offset(equation - link.first, self.time);
                let gap = self.desk.gap[equation];
                self.right.push((let_go - gap) / step);
                link.error = link.error.max(gap.abs());
                missed = missed.max(if link.is_drawn_in(self.time) { (gap - let_go).abs() } else { 0.0 });
            }
        }
        self.missed = missed;
        self.rank = self.space.factor();
        self.multipliers.resize(self.space.equations(), 0.0);
        implicit.change.copy_from_slice(&self.forces);
        self.space.solve(&mut implicit.change, &self.right, &mut self.multipliers, &mut self.rates);
        self.half.iter_mut().zip(&implicit.change).for_each(|(v, change)| *v += change);
        let mut largest = step * self.mean_speed(&implicit.change);
        let mut parameter = 0;
        for link in self.links.iter_mut().filter(|link| link.is_held()) {
            let mut by = [0.0; 4];
            for (k, by) in by.iter_mut().enumerate().take(link.rates.len()) {
                link.rates[k] += self.rates[parameter + k];
                *by = step * self.rates[parameter + k];
                largest = if by.abs() <= largest { largest } else { by.abs() };
            }
            parameter += link.rates.len();
            for (kept, new) in link.multipliers.iter_mut().zip(&self.multipliers[link.first..]) {
                *kept = new / step;
            }
            link.turn(&by);
            link.slide(&by, self.time);
        }
        for body in self.bodies.iter_mut().filter(|body| body.mass.is_some()) {
            let changes = &implicit.change[body.range()];
            let vertices = body.body.shape.control_vertices_mut().iter_mut();
            for (vertex, change) in vertices.zip(changes.chunks_exact(3)) {
                (0..3).for_each(|axis| vertex[axis] += step * change[axis]);
            }
        }
        Ok(largest)
    }

    /// `M + h D + h² K`, factored.
    fn weigh(&mut self, implicit: &mut Implicit, step: f64) -> Result<()> {
        let Self { bodies, space, loads, time, late, .. } = self;
        for (index, body) in bodies.iter().enumerate() {
            let (Some(mass), Some(elastic)) = (&body.mass, &body.elastic) else { continue };
            let Some(Weight::Coordinates(factor)) = space.weight_mut(index) else { continue };
            let places = &implicit.places[index];
            factor.entries_mut().fill(0.0);
            let mut add = |row: usize, column: usize, value: f64| {
                let (a, b) = (3 * places[row / 3] + row % 3, 3 * places[column / 3] + column % 3);
                let at = factor.place(a.max(b), a.min(b));
                factor.entries_mut()[at] += value;
            };
            let damped = 1.0 + step * body.body.material.damping;
            for i in 0..mass.matrix.size() {
                for (j, m) in mass.matrix.row(i).filter(|(j, _)| *j <= i) {
                    (0..3).for_each(|axis| add(3 * i + axis, 3 * j + axis, damped * m));
                }
            }
            let q = body.body.shape.control_vertices();
            elastic.add_stiffness(q, Part::Convex, step * step, step, &mut implicit.room, &mut add);
            let first = 3 * body.start;
            for load in loads.iter().filter(|load| load.acts(*time - *late) && load.offset() == body.start) {
                load.add_stiffness(step * step, step, |i, j, value| add(i - first, j - first, value));
            }
            // Of the mass alone it was one; stiffness has drowned it.
            let drowned = |_| DynamicsError::Drowned {
                body: body.body.name.clone(),
                step,
                by_weight: body.body.by_weight,
            };
            factor.factor_in_place(0.0).map_err(drowned)?;
        }
        Ok(())
    }
}
