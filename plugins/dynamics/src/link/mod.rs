//! A constraint while it is held: its rows, what it misses, and how that is drawn to nothing.

mod curving;
mod followed;
mod rows;
mod slides;

use std::sync::Arc;

use loftsman_kernel::functional::{Functional, Linearity, Shapes};
use loftsman_kernel::shape::{Location, Splines, cells_of};

pub(crate) use self::curving::Curving;
pub(crate) use self::rows::Desk;
pub(crate) use self::slides::{BESIDE, Places};
use crate::constraint::{Hold, Looks, Place, Target};
use crate::error::{DynamicsError, Result};
use crate::place::Slide;

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

impl Phase {
    /// Why it let go by itself, if it did.
    pub(crate) fn gone(&self) -> Option<&'static str> {
        match self {
            Self::Off { why, .. } if [LEFT, SHUT].contains(why) => Some(why),
            _ => None,
        }
    }
}

/// Why constraints let go by themselves.
pub(crate) const LEFT: &str = "it left the shape";
pub(crate) const SHUT: &str = "its loop is drawn shut";

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
    /// Of a loop of a curve of degree 1 or 2: where its spans end.
    spans: Vec<f64>,
    /// Which of its parameters stay where they are while rest is looked for.
    pub(crate) pinned: Vec<bool>,
    /// Of each of its parameters, the knots where what it holds has corners, ascending; and whether it stands on one while things move, as a parameter that does
    /// not float.
    corners: Vec<Vec<f64>>,
    pub(crate) stands: Vec<bool>,
    /// Its equations in the system of the present step, and their multipliers.
    pub(crate) first: usize,
    pub(crate) equations: usize,
    pub(crate) multipliers: Vec<f64>,
    /// What is missing when it starts, and the rate of that: of each equation.
    offset: Vec<[f64; 2]>,
    /// How much it misses now, without what it is let miss.
    pub(crate) error: f64,
    /// Of what is only followed: what it asks for changes so much along the shape where that is steepest; and where it was last, with its sign.
    steep: Option<f64>,
    last_steep: f64,
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
    /// The highest derivative that it takes at its place (the point itself: 0).
    order: usize,
}

impl Link {
    /// Of a constraint of these shapes; `slide` tells of each parameter of a body.
    pub(crate) fn new(
        constraint: Hold,
        shapes: &Shapes<'_>,
        slide: &dyn Fn(usize, usize) -> Result<Slide>,
        draw: f64,
    ) -> Result<Self> {
        let Hold { name, places, parts, from, until, axes } = constraint;
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
                // One of its own, which slides.
                let own =
                    term.place.filter(|&index| places[index].floats).map(|index| places[index].location);
                let functional = own.and_then(|at| functional.moved(at)).unwrap_or(functional);
                // In an edit it may be linear beside what stands still with it; in a motion nothing does.
                let alone = functional.beside(&|_| false);
                if alone.as_ref().unwrap_or(&functional).linearity() != Linearity::Linear {
                    return Err(DynamicsError::NotLinear { what: functional.describe() });
                }
                // Of the shapes at the start: which ends meet, what is opposite what.
                let bound = if functional.floats() { None } else { functional.bind(shapes)? };
                let functional = bound.unwrap_or(functional);
                let order = match term.looks {
                    Looks::At(order) => order,
                    Looks::Functional(_) => functional.takes_derivatives(),
                };
                terms.push(HeldTerm { sign: term.sign, functional, place: term.place, order });
            }
            held.push(HeldPart { terms, target: part.target, value: Vec::new() });
        }
        let count = slides.len();
        let spans = spans_of_a_loop(&places, shapes)?;
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
            pinned: vec![false; count],
            spans,
            corners: Vec::new(),
            stands: Vec::new(),
            first: 0,
            equations: 0,
            multipliers: Vec::new(),
            offset: Vec::new(),
            error: 0.0,
            steep: None,
            last_steep: 0.0,
        };
        link.settle_targets(shapes)?;
        link.look_for_corners(shapes)?;
        link.steep = link.steepest(shapes)?;
        Ok(link)
    }

    /// Whether it may know control vertices by their numbers: then it means others once knots are inserted.
    pub(crate) fn knows_vertices(&self) -> bool {
        let all = || self.parts.iter().flat_map(|part| &part.terms);
        self.places.iter().any(|place| matches!(place.location, Location::Vertex(_)))
            || all().any(|term| term.functional.location().is_none())
            || self.places.iter().any(|place| all().any(|term| term.functional.by_number(place.body)))
    }

    /// One of its places stays where it is.
    pub(crate) fn pin(&mut self, place: usize) {
        let before = self.places.iter().take(place).filter(|place| place.floats);
        let first: usize = before.map(|place| place.location.parameters()).sum();
        let count = self.places.get(place).map_or(0, |place| place.location.parameters());
        self.pinned.iter_mut().skip(first).take(count).for_each(|pinned| *pinned = true);
    }

    /// What it knows of shapes, where these have other knots now.
    pub(crate) fn refit(&mut self, shapes: &Shapes<'_>) -> Result<()> {
        self.spans = spans_of_a_loop(&self.places, shapes)?;
        self.look_for_corners(shapes)
    }

    /// Of each of its parameters, the knots where what it holds has corners, ascending.
    pub(crate) fn corners(&self) -> &[Vec<f64>] {
        &self.corners
    }

    /// Whether its shapes have corners where it slides.
    pub(crate) fn has_corners(&self) -> bool {
        self.corners.iter().any(|corners| !corners.is_empty())
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
                // A condition holds where it is zero.
                Target::Keep if part.terms.iter().any(|term| term.functional.is_condition()) => {
                    part.value = vec![0.0; whole.len()];
                }
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

    /// What is kept is what there is as it comes.
    pub(crate) fn keep_what_is(&mut self, shapes: &Shapes<'_>) -> Result<()> {
        if self.from > 0.0 && self.parts.iter().any(|part| matches!(part.target, Target::Keep)) {
            self.settle_targets(shapes)?;
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

    /// The time constant by which it is drawn in, while what it lets itself miss is more than a millionth of what it missed.
    pub(crate) fn drawing(&self, time: f64) -> Option<f64> {
        let fades = self.offset.iter().any(|o| *o != [0.0; 2]) && time - self.since < 17.0 * self.draw;
        (self.phase == Phase::Held && fades).then_some(self.draw)
    }

    /// Whether it has come near to what it asks: what it misses beside what it lets itself miss is drift from then on.
    pub(crate) fn is_near(&self, time: f64) -> bool {
        self.is_drawn_in(time) || time - self.since > 10.0 * self.draw
    }

    /// Whether it does work from outside: its target moves, it comes or goes, or draws something in.
    pub(crate) fn feeds(&self, time: f64) -> bool {
        let moves = |part: &HeldPart| matches!(&part.target, Target::Path(path) if path.points().len() > 1);
        let held = self.phase == Phase::Held;
        self.phase == Phase::Waiting
            || held && (self.until.is_finite() || !self.is_drawn_in(time) || self.parts.iter().any(moves))
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
}

/// Where the spans end of the curve of degree 1 or 2 of which two places are one.
fn spans_of_a_loop(places: &[Place], shapes: &Shapes<'_>) -> Result<Vec<f64>> {
    let [Place { body: a, .. }, Place { body: b, .. }] = places else { return Ok(Vec::new()) };
    let splines = cells_of(shapes.get(*a)?, "a loop").ok().and_then(|cells| cells.splines());
    Ok(match splines {
        Some(Splines { u, v: None, .. }) if a == b && u.degree() <= 2 => u.breakpoints(),
        _ => Vec::new(),
    })
}
