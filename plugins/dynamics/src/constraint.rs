//! What is held while things move: the table of paper 3, and any linear functional.

use std::sync::Arc;

use loftsman_kernel::Vector;
use loftsman_kernel::functional::{At, Functional, derivative, near, position};
use loftsman_kernel::shape::{Derivative, Location};

use crate::error::{Result, check_vector};
use crate::path::Path;

/// A constraint of a simulation: sums of linear functionals that have values, some of their locations floating along their shapes. Points of
/// shapes are `P(s, t)`; what floats is written `s(t)`.
#[derive(Debug, Clone)]
pub struct Hold {
    pub(crate) name: String,
    pub(crate) places: Vec<Place>,
    pub(crate) parts: Vec<Part>,
    pub(crate) from: f64,
    pub(crate) until: f64,
    pub(crate) axes: [bool; 3],
}

/// A location that the terms of a constraint share.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    pub(crate) body: usize,
    pub(crate) location: Location,
    pub(crate) floats: bool,
}

/// `Σ ± f = target`.
#[derive(Debug, Clone)]
pub(crate) struct Part {
    pub(crate) terms: Vec<Term>,
    pub(crate) target: Target,
}

#[derive(Debug, Clone)]
pub(crate) struct Term {
    pub(crate) sign: f64,
    pub(crate) looks: Looks,
    /// Which of the constraint's places it looks at, if it looks at one.
    pub(crate) place: Option<usize>,
}

#[derive(Debug, Clone)]
pub(crate) enum Looks {
    /// A derivative of this order at its place; the point itself for order 0.
    At(usize),
    /// Something else.
    Functional(Arc<dyn Functional>),
}

#[derive(Debug, Clone)]
pub(crate) enum Target {
    /// What it is when it starts.
    Keep,
    /// These numbers.
    Value(Vec<f64>),
    /// A place that may move.
    Path(Path),
}

impl Target {
    /// Whether its numbers are finite, and no mistakes.
    pub(crate) fn check(&self) -> Result<()> {
        let what = "a coordinate of a constraint's target";
        match self {
            Self::Keep => Ok(()),
            Self::Value(numbers) => {
                numbers.iter().try_for_each(|number| check_vector(what, &Vector::repeat(*number)))
            }
            Self::Path(path) => path.points().iter().try_for_each(|p| check_vector(what, &p.coords)),
        }
    }
}

fn place(body: usize, location: impl Into<Location>, floats: bool) -> Place {
    Place { body, location: location.into(), floats }
}

fn looks(place: usize, sign: f64, order: usize) -> Term {
    Term { sign, looks: Looks::At(order), place: Some(place) }
}

impl Term {
    /// What it asks, of the places of its constraint.
    pub(crate) fn functional(&self, places: &[Place]) -> Arc<dyn Functional> {
        match (&self.looks, self.place.and_then(|index| places.get(index))) {
            (Looks::Functional(functional), _) => Arc::clone(functional),
            (Looks::At(order), Some(place)) => {
                let at = if place.floats { near(place.location) } else { At::from(place.location) };
                if *order == 0 {
                    Arc::new(position(at).on(place.body))
                } else {
                    Arc::new(derivative(at, Derivative { u: *order, v: 0 }).on(place.body))
                }
            }
            // Points are of places; none are made without.
            (Looks::At(_), None) => Arc::new(position(0.0)),
        }
    }
}

impl Hold {
    fn new(name: String, places: Vec<Place>, parts: Vec<Part>) -> Self {
        Self { name, places, parts, from: 0.0, until: f64::INFINITY, axes: [true; 3] }
    }

    fn of_point(name: String, place: Place, target: Target) -> Self {
        let terms = vec![looks(0, 1.0, 0)];
        Self::new(name, vec![place], vec![Part { terms, target }])
    }

    fn tied(name: String, one: Place, other: Place) -> Self {
        let terms = vec![looks(0, 1.0, 0), looks(1, -1.0, 0)];
        Self::new(name, vec![one, other], vec![Part { terms, target: Target::Value(vec![0.0; 3]) }])
    }

    /// What a functional is that keeps its value, and has no place of its own to be shown.
    pub(crate) fn of_all(functional: Arc<dyn Functional>) -> Self {
        let name = functional.describe();
        let term = Term { sign: 1.0, looks: Looks::Functional(functional), place: None };
        Self::new(name, Vec::new(), vec![Part { terms: vec![term], target: Target::Keep }])
    }

    /// Whether it holds the point at this place of a curve, wherever that is led.
    pub(crate) fn fixes(&self, body: usize, at: f64) -> bool {
        let own = |term: &Term| {
            let place = term.place.and_then(|index| self.places.get(index));
            matches!(term.looks, Looks::At(0))
                && place.is_some_and(|p| p.body == body && !p.floats && p.location == Location::Curve(at))
        };
        self.parts.iter().any(|part| matches!(&part.terms[..], [term] if own(term)))
    }

    /// On another body than the first: all that it looks at.
    #[must_use]
    pub fn on(mut self, body: usize) -> Self {
        for place in &mut self.places {
            place.body = body;
        }
        self
    }

    /// What it is called in reports and messages.
    #[must_use]
    pub fn called(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// Its target: a point, or a [`Path`]. Where none is given, it stays where it is at the start.
    #[must_use]
    pub fn to(mut self, target: impl Into<Path>) -> Self {
        if let Some(part) = self.parts.first_mut() {
            part.target = Target::Path(target.into());
        }
        self
    }

    /// The times between which it holds, in seconds. What it misses when it comes is drawn in smoothly.
    #[must_use]
    pub fn during(mut self, from: f64, until: f64) -> Self {
        (self.from, self.until) = (from, until);
        self
    }

    /// Only these coordinates of what it holds.
    #[must_use]
    pub fn axes(mut self, axes: [bool; 3]) -> Self {
        self.axes = axes;
        self
    }

    /// The first derivative there as well, in the same (floating) location.
    #[must_use]
    pub fn tangent(mut self, derivative: impl Into<Vector>) -> Self {
        self.add(1, derivative.into());
        self
    }

    /// The second derivative there as well, in the same (floating) location.
    #[must_use]
    pub fn curvature(mut self, derivative: impl Into<Vector>) -> Self {
        self.add(2, derivative.into());
        self
    }

    fn add(&mut self, times: usize, value: Vector) {
        let terms = vec![looks(0, 1.0, times)];
        self.parts.push(Part { terms, target: Target::Value(value.as_slice().to_vec()) });
    }
}

/// `P(s₀, t) = A`: a point of the shape stays at a place (by default where it is).
pub fn fixed(at: impl Into<Location>) -> Hold {
    let place = place(0, at, false);
    Hold::of_point(format!("fixed at {}", place.location), place, Target::Keep)
}

/// `P(s(t), t) = A`: the shape passes a place, wherever along itself; it slides through. Of a surface both parameters float.
pub fn sliding(near: impl Into<Location>) -> Hold {
    let place = place(0, near, true);
    Hold::of_point(format!("sliding near {}", place.location), place, Target::Keep)
}

/// `P(s(t), t) = P(s₀, t)`: a running knot; the curve slides through its own point.
pub fn knot(near: impl Into<Location>, at: impl Into<Location>) -> Hold {
    let (one, other) = (place(0, near, true), place(0, at, false));
    Hold::tied(format!("knot near {} at {}", one.location, other.location), one, other)
}

/// `P(s₁(t), t) = P(s₂(t), t)`: the curve slides through itself both ways.
pub fn double_sliding(near: [impl Into<Location>; 2]) -> Hold {
    let [a, b] = near.map(|near| place(0, near, true));
    Hold::tied(format!("double sliding near {} and {}", a.location, b.location), a, b)
}

/// `P'(s(t), t) = T`: somewhere the curve has this first derivative.
pub fn sliding_tangent(near: impl Into<Location>, derivative: impl Into<Vector>) -> Hold {
    sliding_derivative("tangent", 1, near, derivative.into())
}

/// `P''(s(t), t) = C`: somewhere the curve has this second derivative.
pub fn sliding_curvature(near: impl Into<Location>, derivative: impl Into<Vector>) -> Hold {
    sliding_derivative("curvature", 2, near, derivative.into())
}

fn sliding_derivative(what: &str, times: usize, near: impl Into<Location>, value: Vector) -> Hold {
    let place = place(0, near, true);
    let mut all = Hold::new(format!("sliding {what} near {}", place.location), vec![place], Vec::new());
    all.add(times, value);
    all
}

/// A point of a body: at a location that stays, or [near](Spot::near) one that floats.
#[derive(Debug, Clone, Copy)]
pub struct Spot(Place);

impl Spot {
    /// A location of a body that stays.
    pub fn at(body: usize, location: impl Into<Location>) -> Self {
        Self(place(body, location, false))
    }

    /// A location of a body that floats.
    pub fn near(body: usize, location: impl Into<Location>) -> Self {
        Self(place(body, location, true))
    }
}

/// `P_a(s_a) = P_b(s_b)`: points of two bodies are one; a ring on a rope slides along it.
pub fn tied(one: Spot, other: Spot) -> Hold {
    let (a, b) = (one.0, other.0);
    let way = |place: &Place| if place.floats { "near" } else { "at" };
    let name = format!("tied {} {} and {} {}", way(&a), a.location, way(&b), b.location);
    Hold::tied(name, a, b)
}

/// Any linear functional of the kernel or a plug-in, its location fixed or floating; it keeps the value that it has at the start, or gets
/// [another](Hold::value).
pub fn holds(functional: Arc<dyn Functional>) -> Hold {
    let name = functional.describe();
    let floats = functional.floats();
    let place = functional.location().map(|(body, location)| Place { body, location, floats });
    let term = Term { sign: 1.0, looks: Looks::Functional(functional), place: place.map(|_| 0) };
    Hold::new(name, place.into_iter().collect(), vec![Part { terms: vec![term], target: Target::Keep }])
}

impl Hold {
    /// The numbers that it is to have: as many as its functional has equations.
    #[must_use]
    pub fn value(mut self, value: Vec<f64>) -> Self {
        if let Some(part) = self.parts.first_mut() {
            part.target = Target::Value(value);
        }
        self
    }
}

/// A force at a place of a body.
#[derive(Debug, Clone)]
pub struct Force {
    pub(crate) name: String,
    pub(crate) body: usize,
    pub(crate) at: Location,
    pub(crate) force: Vector,
    pub(crate) from: f64,
    pub(crate) until: f64,
}

/// A force at a location of the first body.
pub fn force(at: impl Into<Location>, force: impl Into<Vector>) -> Force {
    let at = at.into();
    let name = format!("force at {at}");
    Force { name, body: 0, at, force: force.into(), from: 0.0, until: f64::INFINITY }
}

impl Force {
    /// On another body.
    #[must_use]
    pub fn on(mut self, body: usize) -> Self {
        self.body = body;
        self
    }

    /// The times between which it acts, in seconds.
    #[must_use]
    pub fn during(mut self, from: f64, until: f64) -> Self {
        (self.from, self.until) = (from, until);
        self
    }
}

/// A damped spring from a point of a body to a target: the mouse.
#[derive(Debug, Clone)]
pub struct Pull {
    pub(crate) name: String,
    pub(crate) body: usize,
    pub(crate) at: Location,
    pub(crate) to: Path,
    pub(crate) stiffness: f64,
    pub(crate) from: f64,
    pub(crate) until: f64,
}

/// A pull at a location of the first body towards a place that may move, with a stiffness in force a length; damped critically.
pub fn pull(at: impl Into<Location>, to: impl Into<Path>, stiffness: f64) -> Pull {
    let at = at.into();
    let name = format!("pull at {at}");
    Pull { name, body: 0, at, to: to.into(), stiffness, from: 0.0, until: f64::INFINITY }
}

impl Pull {
    /// On another body.
    #[must_use]
    pub fn on(mut self, body: usize) -> Self {
        self.body = body;
        self
    }

    /// The times between which it acts, in seconds.
    #[must_use]
    pub fn during(mut self, from: f64, until: f64) -> Self {
        (self.from, self.until) = (from, until);
        self
    }
}
