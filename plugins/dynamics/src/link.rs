//! A constraint while it is held: its rows, what it misses, and how that is drawn to nothing.

use std::sync::Arc;

use loftsman_kernel::Vector;
use loftsman_kernel::functional::{Equation, Functional, Linearity, Shapes, Store, rows_of};
use loftsman_kernel::shape::{Derivative, Location};
use loftsman_kernel::solve::RangeSpace;
use smallvec::SmallVec;

use crate::constraint::{Constraint, Looks, Place, Target};
use crate::error::{DynamicsError, Result};
use crate::place::Slide;

/// A parameter that turned round so often goes no slower: a millionth of its way.
const TURNS: usize = 20;

/// Whether a constraint holds.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Phase {
    /// Its time has not come.
    Waiting,
    /// It holds since then.
    Held,
    /// It holds no more, and why.
    Off { time: f64, why: &'static str },
}

/// Locations of a constraint's places.
pub(crate) type Places = SmallVec<[Location; 2]>;

#[derive(Debug)]
pub(crate) struct Link {
    pub(crate) name: String,
    pub(crate) places: Vec<Place>,
    parts: Vec<HeldPart>,
    pub(crate) from: f64,
    pub(crate) until: f64,
    axes: [bool; 3],
    pub(crate) phase: Phase,
    since: f64,
    draw: f64,
    /// What floats: of its places, one or two numbers each, and their rates, both in lengths along the shape for the rates.
    pub(crate) slides: Vec<Slide>,
    pub(crate) rates: Vec<f64>,
    pub(crate) accelerations: Vec<f64>,
    /// Of each parameter: its last change while Newton's iteration runs, and how often it turned round. Each time halves its way, so that it
    /// comes to rest where the shape turns sharply, and at a corner, where it would turn for ever.
    turns: Vec<(f64, usize)>,
    /// Its equations in the system of the present step, and their multipliers.
    pub(crate) first: usize,
    pub(crate) equations: usize,
    pub(crate) multipliers: Vec<f64>,
    /// What is missing when it starts, and the rate of that: of each equation.
    offset: Vec<[f64; 2]>,
    /// How much it misses now, without what it is let miss.
    pub(crate) error: f64,
}

#[derive(Debug)]
struct HeldPart {
    terms: Vec<HeldTerm>,
    target: Target,
    /// What it is to have, where that does not move.
    value: Vec<f64>,
}

#[derive(Debug)]
struct HeldTerm {
    sign: f64,
    functional: Arc<dyn Functional>,
    place: Option<usize>,
    /// Of a derivative at its place (the point itself: 0), its order.
    order: Option<usize>,
}

/// How what is held curves as places float, weighed by the multipliers: second derivatives of `λᵀg`.
#[derive(Debug, Default)]
pub(crate) struct Curving {
    /// `∂²(λᵀg)/∂q∂s`: vertex, parameter, a number for each axis.
    pub(crate) mixed: Vec<(usize, usize, Vector)>,
    /// `∂²(λᵀg)/∂s²`: a pair of parameters, the second no later than the first.
    pub(crate) twice: Vec<(usize, usize, f64)>,
}

/// What is written while rows are collected; kept from step to step.
#[derive(Debug, Clone, Default)]
pub(crate) struct Desk {
    store: Store,
    vertices: Vec<usize>,
    coefficients: Vec<f64>,
    /// What each equation is now, less its target, and the target's rate and acceleration.
    pub(crate) gap: Vec<f64>,
    pub(crate) target_rate: Vec<f64>,
    pub(crate) target_acceleration: Vec<f64>,
    /// What velocities add: `2 Σ q̇ b' ṡ + P'' ṡ²`.
    pub(crate) curving: Vec<f64>,
    /// `(equation, parameter, by)`, parameters numbered through all links.
    pub(crate) changes: Vec<(usize, usize, f64)>,
    /// `(parameter, factor)`: those that turned round, damped.
    pub(crate) damped: Vec<(usize, f64)>,
    pub(crate) parameters: usize,
    value: Vec<f64>,
    along: Vec<f64>,
}

impl Desk {
    pub(crate) fn clear(&mut self) {
        self.gap.clear();
        self.target_rate.clear();
        self.target_acceleration.clear();
        self.curving.clear();
        self.changes.clear();
        self.damped.clear();
        self.parameters = 0;
    }
}

impl Link {
    /// Of a constraint of these shapes; `slide` tells of each parameter of a body.
    pub(crate) fn new(
        constraint: Constraint,
        shapes: &Shapes<'_>,
        slide: &dyn Fn(usize, usize) -> Result<Slide>,
        draw: f64,
    ) -> Result<Self> {
        let Constraint { name, places, parts, from, until, axes } = constraint;
        let mut slides = Vec::new();
        for place in &places {
            shapes.get(place.body)?;
            if place.floats {
                if place.location.is_on_face() {
                    return Err(DynamicsError::Geometry(loftsman_kernel::Error::Invalid(format!(
                        "{name}: a location on a surface of many faces does not slide yet: give one that stays (at)"
                    ))));
                }
                for axis in 0..place.location.parameters() {
                    slides.push(slide(place.body, axis)?);
                }
            }
        }
        let mut held = Vec::with_capacity(parts.len());
        for part in parts {
            let mut terms = Vec::with_capacity(part.terms.len());
            for term in part.terms {
                let functional = term.functional(&places);
                if !functional.floats() && functional.linearity() != Linearity::Linear {
                    return Err(DynamicsError::NotLinear { what: functional.describe() });
                }
                // One of its own, which slides.
                let own =
                    term.place.filter(|&index| places[index].floats).map(|index| places[index].location);
                let functional = own.and_then(|at| functional.moved(at)).unwrap_or(functional);
                // Of the shapes at the start: which ends meet, what is opposite what.
                let bound = if functional.floats() { None } else { functional.bind(shapes)? };
                let functional = bound.unwrap_or(functional);
                let order = match term.looks {
                    Looks::At(order) => Some(order),
                    Looks::Functional(_) => None,
                };
                terms.push(HeldTerm { sign: term.sign, functional, place: term.place, order });
            }
            held.push(HeldPart { terms, target: part.target, value: Vec::new() });
        }
        let count = slides.len();
        let mut link = Self {
            name,
            places,
            parts: held,
            from,
            until,
            axes,
            phase: Phase::Waiting,
            since: 0.0,
            draw,
            slides,
            rates: vec![0.0; count],
            accelerations: vec![0.0; count],
            turns: vec![(0.0, 0); count],
            first: 0,
            equations: 0,
            multipliers: Vec::new(),
            offset: Vec::new(),
            error: 0.0,
        };
        link.settle_targets(shapes)?;
        Ok(link)
    }

    /// What is kept gets the value that it has; what is given must be as many numbers as there are.
    fn settle_targets(&mut self, shapes: &Shapes<'_>) -> Result<()> {
        let mut desk = Desk::default();
        for part in &mut self.parts {
            let mut whole = Vec::new();
            for term in &part.terms {
                let value = term.value(shapes, &mut desk)?;
                whole.resize(value.len(), 0.0);
                whole.iter_mut().zip(value).for_each(|(whole, v)| *whole += term.sign * v);
            }
            if self.axes != [true; 3] && whole.len() != 3 {
                return Err(DynamicsError::Geometry(loftsman_kernel::Error::Invalid(format!(
                    "{}: only what is one point or vector has axes, this is {} numbers",
                    self.name,
                    whole.len()
                ))));
            }
            match &part.target {
                Target::Keep => part.value = whole,
                Target::Value(value) if value.len() == whole.len() && value.iter().all(|v| v.is_finite()) => {
                    part.value.clone_from(value);
                }
                Target::Path(path) if whole.len() == 3 && path.is_finite() => {
                    part.value = path.at(0.0)[0].as_slice().to_vec();
                }
                Target::Value(_) | Target::Path(_) => {
                    return Err(DynamicsError::Geometry(loftsman_kernel::Error::Invalid(format!(
                        "{}: {} finite numbers are needed for what it is to have",
                        self.name,
                        whole.len()
                    ))));
                }
            }
        }
        Ok(())
    }

    /// Another target for what it holds first.
    pub(crate) fn retarget(&mut self, target: Target) -> bool {
        let Some(part) = self.parts.first_mut() else { return false };
        let fits = match &target {
            Target::Keep => true,
            Target::Value(value) => value.len() == part.value.len() && value.iter().all(|v| v.is_finite()),
            Target::Path(path) => part.value.len() == 3 && path.is_finite(),
        };
        if !fits {
            return false;
        }
        if let Target::Value(value) = &target {
            part.value.copy_from_slice(value);
        }
        part.target = target;
        true
    }

    /// Whether it holds at a time; where it comes, what is missing then is let go slowly.
    pub(crate) fn is_held(&self) -> bool {
        self.phase == Phase::Held
    }

    /// Comes and goes with its times. Whether it has come just now.
    pub(crate) fn at_time(&mut self, time: f64) -> bool {
        match self.phase {
            Phase::Waiting if time >= self.from && time < self.until => {
                self.phase = Phase::Held;
                self.since = time;
                self.offset.clear();
                true
            }
            Phase::Held if time >= self.until => {
                self.phase = Phase::Off { time, why: "its time is over" };
                false
            }
            _ => false,
        }
    }

    /// Pushes its rows, and what they miss. `velocities` are shapes whose control vertices are velocities.
    pub(crate) fn push(
        &mut self,
        shapes: &Shapes<'_>,
        velocities: &Shapes<'_>,
        time: f64,
        space: &mut RangeSpace,
        desk: &mut Desk,
    ) -> Result<()> {
        let first = space.equations();
        let first_parameter = desk.parameters;
        for part in &self.parts {
            let start = desk.gap.len();
            let (mut value, mut rate, mut acceleration) = ([0.0; 3], [0.0; 3], [0.0; 3]);
            if let Target::Path(path) = &part.target {
                let [place, velocity, change] = path.at(time);
                value.copy_from_slice(place.as_slice());
                rate.copy_from_slice(velocity.as_slice());
                acceleration.copy_from_slice(change.as_slice());
            }
            let moving = matches!(part.target, Target::Path(_));
            let count = part.value.len();
            let asked = |k: usize| count != 3 || self.axes[k];
            // Rows, all terms' together.
            let mut alike = count == 3;
            desk.store.clear();
            {
                let mut rows = desk.store.rows(shapes);
                for term in &part.terms {
                    rows_of(term.functional.as_ref(), shapes, &mut rows)?;
                }
            }
            desk.value.clear();
            desk.value.resize(count * part.terms.len(), 0.0);
            desk.store.evaluate(shapes, &mut desk.value);
            alike &= desk.store.equations().all(|e| matches!(e, Equation::Alike { .. }));
            if alike {
                desk.vertices.clear();
                desk.coefficients.clear();
                for (equation, term) in desk.store.equations().zip(&part.terms) {
                    if let Equation::Alike { vertices, coefficients, .. } = equation {
                        desk.vertices.extend_from_slice(vertices);
                        desk.coefficients.extend(coefficients.iter().map(|c| c * term.sign));
                    }
                }
                let entries = desk.vertices.iter().copied().zip(desk.coefficients.iter().copied());
                if self.axes == [true; 3] {
                    space.push_alike(entries);
                } else {
                    for axis in (0..3).filter(|&k| asked(k)) {
                        let unit = move |c: f64| std::array::from_fn(|k| if k == axis { c } else { 0.0 });
                        space.push_coupled(entries.clone().map(|(v, c)| (v, unit(c))));
                    }
                }
            } else {
                push_any(&desk.store, part, if count == 3 { self.axes } else { [true; 3] }, space);
            }
            for k in (0..count).filter(|&k| asked(k)) {
                let now: f64 = part
                    .terms
                    .iter()
                    .enumerate()
                    .map(|(t, term)| term.sign * desk.value[t * count + k])
                    .sum();
                let wanted = if moving { value[k] } else { part.value[k] };
                desk.gap.push(now - wanted);
                desk.target_rate.push(if moving { rate[k] } else { 0.0 });
                desk.target_acceleration.push(if moving { acceleration[k] } else { 0.0 });
                desk.curving.push(0.0);
            }
            // What its parameters do.
            for term in &part.terms {
                let Some(index) = term.place.filter(|index| self.places[*index].floats) else { continue };
                let own: usize =
                    self.places[..index].iter().filter(|p| p.floats).map(|p| p.location.parameters()).sum();
                let directions = self.places[index].location.parameters();
                let look = |shapes: &Shapes<'_>, u: usize, v: usize, along: &mut Vec<f64>| -> Result<()> {
                    along.clear();
                    along.resize(count, 0.0);
                    Ok(term.functional.along(shapes, Derivative { u, v }, along)?)
                };
                for axis in 0..directions {
                    let turns = self.turns[own + axis].1.min(TURNS) as i32;
                    if turns > 0 {
                        desk.damped.push((first_parameter + own + axis, 2.0_f64.powi(turns) - 1.0));
                    }
                    let pace = self.slides[own + axis].pace;
                    let speed = self.rates[own + axis] * pace;
                    let (u, v) = if axis == 0 { (1, 0) } else { (0, 1) };
                    look(shapes, u, v, &mut desk.along)?;
                    for (equation, k) in (start..).zip((0..count).filter(|&k| asked(k))) {
                        let by = term.sign * desk.along[k] * pace;
                        desk.changes.push((equation, first_parameter + own + axis, by));
                    }
                    if speed == 0.0 {
                        continue;
                    }
                    look(velocities, u, v, &mut desk.along)?;
                    for (equation, k) in (start..).zip((0..count).filter(|&k| asked(k))) {
                        desk.curving[equation] += term.sign * 2.0 * speed * desk.along[k];
                    }
                    for other in 0..directions {
                        let product = speed * self.rates[own + other] * self.slides[own + other].pace;
                        let (u2, v2) = if other == 0 { (u + 1, v) } else { (u, v + 1) };
                        look(shapes, u2, v2, &mut desk.along)?;
                        for (equation, k) in (start..).zip((0..count).filter(|&k| asked(k))) {
                            desk.curving[equation] += term.sign * product * desk.along[k];
                        }
                    }
                }
            }
        }
        desk.parameters += self.slides.len();
        self.first = first;
        self.equations = space.equations() - first;
        self.multipliers.resize(self.equations, 0.0);
        Ok(())
    }

    /// Adds how what it holds curves along its shapes; its parameters are numbered from `first` on. What is no derivative at a place counts as
    /// straight.
    pub(crate) fn curve(&self, shapes: &Shapes<'_>, first: usize, out: &mut Curving) -> Result<()> {
        let mut equations = self.multipliers.iter();
        for part in &self.parts {
            let count = part.value.len();
            let mut lambda = Vector::zeros();
            for k in (0..count).filter(|&k| count != 3 || self.axes[k]) {
                let multiplier = equations.next().copied().unwrap_or(0.0);
                if count == 3 {
                    lambda[k] = multiplier;
                }
            }
            for term in &part.terms {
                let Some((order, index)) = term.order.zip(term.place).filter(|(_, i)| self.places[*i].floats)
                else {
                    continue;
                };
                let Place { body, location, .. } = self.places[index];
                let own: usize =
                    self.places[..index].iter().filter(|p| p.floats).map(|p| p.location.parameters()).sum();
                let shape = shapes.get(body)?;
                for axis in 0..location.parameters() {
                    let pace = self.slides[own + axis].pace;
                    let (u, v) = if axis == 0 { (order + 1, 0) } else { (order, 1) };
                    let pull = lambda * (term.sign * pace);
                    let stencil = shape.stencil(location, Derivative { u, v })?;
                    let start = shapes.offset(body);
                    let entries = stencil.iter().map(|(i, c)| (start + i, first + own + axis, pull * c));
                    out.mixed.extend(entries);
                    for other in 0..=axis {
                        let (u, v) = if other == 0 { (u + 1, v) } else { (u, v + 1) };
                        let change = shape.value(location, Derivative { u, v })?;
                        let by = pull.dot(&change) * self.slides[own + other].pace;
                        out.twice.push((first + own + axis, first + own + other, by));
                    }
                }
            }
        }
        Ok(())
    }

    /// What it is let miss at a time, with rate and acceleration: what was missing when it came dies away as
    /// `(g₀ + (ġ₀ + g₀/τ) t) e^(-t/τ)`, critically damped.
    pub(crate) fn offset(&self, equation: usize, time: f64) -> [f64; 3] {
        let Some(&[gap, rate]) = self.offset.get(equation) else { return [0.0; 3] };
        if gap == 0.0 && rate == 0.0 {
            return [0.0; 3];
        }
        let (t, k) = (time - self.since, 1.0 / self.draw);
        let slope = rate + gap * k;
        let fade = (-t * k).exp();
        let value = gap + slope * t;
        [value * fade, (slope - k * value) * fade, (k * k * value - 2.0 * k * slope) * fade]
    }

    /// Whether it has come just now.
    pub(crate) fn is_new(&self) -> bool {
        self.offset.is_empty() && self.equations > 0
    }

    /// Remembers what is missing as it comes.
    pub(crate) fn start(&mut self, gaps: &[f64], rates: &[f64], negligible: f64) {
        self.offset.clear();
        self.offset.extend(gaps.iter().zip(rates).map(|(&gap, &rate)| {
            if gap.abs() <= negligible && rate.abs() <= negligible { [0.0; 2] } else { [gap, rate] }
        }));
    }

    /// Whether what was missing when it came has died away to this share of it.
    pub(crate) fn is_drawn_in(&self, time: f64) -> bool {
        self.offset.iter().all(|o| *o == [0.0; 2]) || time - self.since > 25.0 * self.draw
    }

    /// Whether a parameter has turned round.
    pub(crate) fn has_turned(&self) -> bool {
        self.turns.iter().any(|(_, turns)| *turns > 0)
    }

    /// Its places, those that float moved by lengths along their shapes as far as these go, one for each of its parameters in turn; and whether
    /// one would leave its shape.
    pub(crate) fn moved(&self, by: impl Fn(usize) -> f64) -> (Places, bool) {
        let (mut own, mut left) = (0, false);
        let mut along = |at: f64| {
            let Some(slide) = self.slides.get(own) else { return at };
            let (to, leaves) = slide.moved(at, by(own));
            (own, left) = (own + 1, left | leaves);
            to
        };
        let places = self.places.iter().map(|place| match place.location {
            location if !place.floats => location,
            Location::Curve(u) => Location::Curve(along(u)),
            Location::Surface(u, v) => Location::Surface(along(u), along(v)),
            Location::Face(face, u, v) => Location::Face(face, along(u), along(v)),
            Location::Vertex(vertex) => Location::Vertex(vertex),
        });
        let places = places.collect();
        (places, left)
    }

    /// A step of Newton's iteration begins. Where it `remembers`, with what it learnt in the step before but the last turn.
    pub(crate) fn begin_turns(&mut self, remembers: bool) {
        let kept = |turns: usize| if remembers { turns.saturating_sub(1) } else { 0 };
        self.turns.iter_mut().for_each(|(last, turns)| (*last, *turns) = (0.0, kept(*turns)));
    }

    /// Remembers which way its parameters went.
    pub(crate) fn turn(&mut self, by: &[f64]) {
        for ((last, turns), by) in self.turns.iter_mut().zip(by) {
            *turns += usize::from(*last * by < 0.0 && by.abs() > 0.2 * last.abs());
            *last = *by;
        }
    }

    /// Moves its parameters by lengths along the shape; switches it off where one leaves its shape.
    pub(crate) fn slide(&mut self, by: &[f64], time: f64) {
        let (places, left) = self.moved(|own| by[own]);
        if left {
            self.leave(time);
        }
        self.put(&places);
    }

    /// It has left its shape, and holds no more.
    pub(crate) fn leave(&mut self, time: f64) {
        self.phase = Phase::Off { time, why: "it left the shape" };
    }

    /// Two places of one curve that have come together: a loop drawn shut.
    pub(crate) fn is_shut(&self, length: f64) -> bool {
        match &self.places[..] {
            [
                Place { body: a, location: Location::Curve(u), floats },
                Place { body: b, location: Location::Curve(w), floats: other },
            ] if a == b && (*floats || *other) => {
                let pace = self.slides.first().map_or(1.0, |slide| slide.pace);
                (u - w).abs() < length * pace
            }
            _ => false,
        }
    }

    /// Puts its places back.
    pub(crate) fn put(&mut self, locations: &[Location]) {
        for (index, location) in locations.iter().enumerate() {
            if !self.places[index].floats {
                continue;
            }
            self.places[index].location = *location;
            for term in self.parts.iter_mut().flat_map(|part| &mut part.terms) {
                if term.place == Some(index)
                    && let Some(functional) = Arc::get_mut(&mut term.functional)
                {
                    functional.slide(*location);
                }
            }
        }
    }

    /// What it still lets itself miss is nothing from now on.
    pub(crate) fn let_go(&mut self) {
        self.offset.iter_mut().for_each(|offset| *offset = [0.0; 2]);
    }

    /// Looks for what it misses anew, as if it came now.
    pub(crate) fn begin(&mut self, time: f64) {
        self.offset.clear();
        self.since = time;
    }

    /// Where it is.
    pub(crate) fn locations(&self) -> impl Iterator<Item = Location> + '_ {
        self.places.iter().map(|place| place.location)
    }
}

fn push_any(store: &Store, part: &HeldPart, asked: [bool; 3], space: &mut RangeSpace) {
    // Several terms are all points; only a functional that stands alone is of any kind.
    let sign = part.terms.first().map_or(1.0, |term| term.sign);
    let mut number = 0;
    for equation in store.equations() {
        match equation {
            Equation::Alike { vertices, coefficients, .. } => {
                space.push_alike(vertices.iter().copied().zip(coefficients.iter().map(|c| c * sign)));
                number += 3;
            }
            Equation::Coupled { vertices, vectors, .. } => {
                if number >= 3 || asked[number] {
                    let turned = |v: &Vector| [v.x * sign, v.y * sign, v.z * sign];
                    space.push_coupled(vertices.iter().copied().zip(vectors.iter().map(turned)));
                }
                number += 1;
            }
        }
    }
}

impl HeldTerm {
    fn value(&self, shapes: &Shapes<'_>, desk: &mut Desk) -> Result<Vec<f64>> {
        desk.store.clear();
        rows_of(self.functional.as_ref(), shapes, &mut desk.store.rows(shapes))?;
        let mut value = vec![0.0; self.functional.equations()];
        desk.store.evaluate(shapes, &mut value);
        Ok(value)
    }
}
