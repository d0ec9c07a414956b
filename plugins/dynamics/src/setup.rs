//! What a simulation is made of, before it is prepared.

use loftsman_kernel::functional::Shapes;
use loftsman_kernel::shape::Shape;
use loftsman_kernel::solve::{RangeSpace, Weight};
use loftsman_kernel::{Point, Vector};

use crate::body::{Body, extent};
use crate::conflict::contradictions;
use crate::constraint::{Constraint, Force, Pull};
use crate::elastic::Elastic;
use crate::error::{DynamicsError, Result, check};
use crate::implicit::Implicit;
use crate::link::{Desk, Link, Slide};
use crate::load::Load;
use crate::mass::Mass;
use crate::simulation::{Moving, Simulation};
use crate::stability::{highest, longest_step};

/// How steps are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Scheme {
    /// Paper 3's (13): a parameter that floats has a small mass `ε`.
    #[default]
    Epsilon,
    /// Paper 3's (11): it has none.
    Exact,
    /// Backward Euler: for what is stiff. It takes energy out; parameters have no mass.
    Implicit,
}

/// A simulation to be: bodies, what holds them, what moves them.
///
/// ```
/// use loftsman_dynamics::{Body, Scheme, Setup, fixed, sliding};
/// use loftsman_kernel::Point;
/// use loftsman_kernel::spline::{Curve, Space};
///
/// let points = (0..12).map(|i| Point::new(f64::from(i), 0.0, 0.0)).collect();
/// let rope = Curve::new(Space::clamped_uniform(3, 12)?, points)?;
/// // Hung up at its start, led through a ring in the middle.
/// let mut simulation = Setup::new(Body::new(&rope).mass(0.1).stiffness(50.0))
///     .gravity([0.0, 0.0, -9.81])
///     .hold(fixed(0.0))
///     .hold(sliding(4.5))
///     .scheme(Scheme::Exact)
///     .prepare()?;
/// for _ in 0..24 {
///     simulation.advance(1.0 / 24.0)?;
/// }
/// let ring = simulation.locations(1)?[0];
/// let through = simulation.shape(0)?.value(ring, 0.into())?;
/// assert!((through - rope.point(4.5)?.coords).norm() < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Setup {
    bodies: Vec<Body>,
    gravity: Vector,
    constraints: Vec<Constraint>,
    forces: Vec<Force>,
    pulls: Vec<Pull>,
    scheme: Scheme,
    epsilon: f64,
    step: Option<f64>,
    draw: f64,
}

/// What is missing when a constraint comes is drawn in by this time constant, in seconds.
const DRAW: f64 = 0.05;
/// The mass of a floating parameter, as a share of that of its body between two control vertices.
const EPSILON: f64 = 1e-3;

impl Setup {
    /// Of one body.
    pub fn new(body: Body) -> Self {
        Self {
            bodies: vec![body],
            gravity: Vector::zeros(),
            constraints: Vec::new(),
            forces: Vec::new(),
            pulls: Vec::new(),
            scheme: Scheme::default(),
            epsilon: EPSILON,
            step: None,
            draw: DRAW,
        }
    }

    /// One more body, numbered from 1.
    #[must_use]
    pub fn and(mut self, body: Body) -> Self {
        self.bodies.push(body);
        self
    }

    /// The acceleration of all that falls.
    #[must_use]
    pub fn gravity(mut self, gravity: impl Into<Vector>) -> Self {
        self.gravity = gravity.into();
        self
    }

    /// One more constraint, numbered from 0.
    #[must_use]
    pub fn hold(mut self, constraint: Constraint) -> Self {
        self.constraints.push(constraint);
        self
    }

    /// One more force, numbered from 0.
    #[must_use]
    pub fn push(mut self, force: Force) -> Self {
        self.forces.push(force);
        self
    }

    /// One more pull, numbered from 0.
    #[must_use]
    pub fn pull(mut self, pull: Pull) -> Self {
        self.pulls.push(pull);
        self
    }

    /// How steps are taken.
    #[must_use]
    pub fn scheme(mut self, scheme: Scheme) -> Self {
        self.scheme = scheme;
        self
    }

    /// The mass of a floating parameter (scheme `Epsilon`), as a share of the body's mass between two control vertices: 0.001 by default.
    #[must_use]
    pub fn epsilon(mut self, share: f64) -> Self {
        self.epsilon = share;
        self
    }

    /// The longest step, in seconds. Without one, explicit steps are as long as is stable and implicit ones as long as
    /// [`advance`](Simulation::advance) is told.
    #[must_use]
    pub fn step(mut self, step: f64) -> Self {
        self.step = Some(step);
        self
    }

    /// How fast a constraint draws in what it misses when it comes: the time constant in seconds, 0.05 by default.
    #[must_use]
    pub fn draw(mut self, seconds: f64) -> Self {
        self.draw = seconds;
        self
    }

    /// Prepares it: matrices are made and factored, constraints that contradict one another at the start are named.
    ///
    /// # Errors
    /// When a number cannot be, a shape is not one that can move, a location is not on its shape, or constraints that hold from the start
    /// ask different things of the same.
    pub fn prepare(self) -> Result<Simulation> {
        let Self { bodies, gravity, constraints, forces, pulls, scheme, epsilon, step, draw } = self;
        if let Some(bad) = gravity.iter().find(|v| !v.is_finite()) {
            return Err(DynamicsError::Number {
                what: "gravity",
                value: *bad,
                needed: "give finite numbers",
            });
        }
        check("epsilon", epsilon, false)?;
        check("the time in which constraints are drawn in", draw, false)?;
        if let Some(step) = step {
            check("the step", step, false)?;
        }
        let size = bodies.iter().map(Body::size).fold(0.0, f64::max);
        let mut moving = Vec::with_capacity(bodies.len());
        let (mut weights, mut start, mut lightest) = (Vec::new(), 0, f64::INFINITY);
        for body in bodies {
            body.material.check()?;
            let count = body.shape.control_vertices().len();
            let (elastic, mass, highest) = if body.still {
                weights.push((Weight::Still(count), None));
                (None, None, 0.0)
            } else {
                let elastic = Elastic::new(body.shape.as_ref(), &body.material)?;
                let mass = Mass::new(body.shape.as_ref(), &body.material)?;
                let highest = highest(body.shape.as_ref(), &body.material, &elastic, &mass)?;
                weights.push((mass.weight.clone(), mass.order.clone()));
                let between = mass.lumped.iter().sum::<f64>() / count.max(2) as f64;
                lightest = lightest.min(between);
                (Some(elastic), Some(mass), highest)
            };
            moving.push(Moving::new(body, start, elastic, mass, highest)?);
            start += count;
        }
        if !moving.iter().any(|body| body.mass.is_some()) {
            return Err(DynamicsError::Number {
                what: "the number of bodies that move",
                value: 0.0,
                needed: "let one move",
            });
        }
        let mut space = RangeSpace::new(weights.iter().cloned());
        let stable = moving
            .iter()
            .filter(|body| body.mass.is_some())
            .map(|body| longest_step(body.highest, &body.body.material))
            .fold(f64::INFINITY, f64::min);
        let (links, loads) = {
            let shapes = Shapes::new(moving.iter().map(|body| body.body.shape.as_ref()));
            let links = constraints
                .into_iter()
                .map(|constraint| {
                    check_constraint(&constraint, &shapes)?;
                    Link::new(constraint, &shapes, &|body, axis| slide_of(&moving, body, axis), draw)
                })
                .collect::<Result<Vec<_>>>()?;
            let mut loads = Vec::new();
            for force in forces {
                on_shape(&shapes, &force.name, force.body, force.at)?;
                loads.push(Load::force(force, &shapes)?);
            }
            for pull in pulls {
                on_shape(&shapes, &pull.name, pull.body, pull.at)?;
                loads.push(Load::pull(pull, &shapes, &mut space)?);
            }
            (links, loads)
        };
        // A pull is a spring: its frequencies add to those of the body.
        let stiffest = loads.iter().map(Load::frequency).fold(0.0, f64::max);
        let stable =
            if stiffest > 0.0 { 1.0 / (1.0 / (stable * stable) + 4.0 * stiffest).sqrt() } else { stable };
        let mut simulation = Simulation::new(moving, gravity, links, loads, space, scheme, size);
        simulation.limits(step, stable, epsilon * lightest);
        if scheme == Scheme::Implicit {
            let (implicit, space) = Implicit::new(&simulation.bodies);
            simulation.make_implicit(implicit, space);
        }
        simulation.come_and_go()?;
        contradictions(&mut simulation, &mut Desk::default())?;
        Ok(simulation)
    }
}

/// Whether a constraint's places are on their shapes, and its times ascend.
pub(crate) fn check_constraint(constraint: &Constraint, shapes: &Shapes<'_>) -> Result<()> {
    for place in &constraint.places {
        on_shape(shapes, &constraint.name, place.body, place.location)?;
    }
    if constraint.from >= 0.0 && constraint.until > constraint.from {
        return Ok(());
    }
    Err(DynamicsError::Number {
        what: "the end of a constraint's time",
        value: constraint.until,
        needed: "give times of 0 or more, the end after the start",
    })
}

/// How a parameter of a body runs.
pub(crate) fn slide_of(bodies: &[Moving], body: usize, axis: usize) -> Result<Slide> {
    let shape = bodies.get(body).map(|b| &b.body.shape);
    let shape = shape.ok_or(DynamicsError::Missing { what: "body", index: body, count: bodies.len() })?;
    let interval = *shape.domain().get(axis).ok_or_else(|| {
        loftsman_kernel::Error::Invalid("a location with more parameters than the shape has".into())
    })?;
    let extent = extent(shape.control_vertices()).max(f64::MIN_POSITIVE);
    let length = length_along(shape.as_ref(), axis).unwrap_or(extent).max(1e-9 * extent);
    Ok(Slide { interval, pace: (interval.end - interval.start) / length })
}

/// The mean length of a shape along a parameter.
fn length_along(shape: &dyn Shape, axis: usize) -> Option<f64> {
    let domain = shape.domain();
    let between = |k: usize, share: f64| domain.get(k).map(|i| i.start + (i.end - i.start) * share);
    const STEPS: usize = 64;
    let mut length = 0.0;
    let mut last: Option<Point> = None;
    for i in 0..=STEPS {
        let own = between(axis, i as f64 / STEPS as f64)?;
        let at = if domain.len() == 2 {
            let other = between(1 - axis, 0.5)?;
            if axis == 0 { [own, other].into() } else { [other, own].into() }
        } else {
            own.into()
        };
        let point = Point::from(shape.value(at, loftsman_kernel::shape::Derivative::POSITION).ok()?);
        length += last.map_or(0.0, |last| (point - last).norm());
        last = Some(point);
    }
    Some(length).filter(|length| length.is_finite() && *length > 0.0)
}

fn on_shape(
    shapes: &Shapes<'_>,
    name: &str,
    body: usize,
    at: loftsman_kernel::shape::Location,
) -> Result<()> {
    use loftsman_kernel::shape::Location;
    let shape = shapes.get(body)?;
    let parameters = match at {
        Location::Curve(u) => vec![u],
        Location::Surface(u, v) | Location::Face(_, u, v) => vec![u, v],
        Location::Vertex(_) => Vec::new(),
    };
    for (at, interval) in parameters.into_iter().zip(shape.domain()) {
        if !(at >= interval.start && at <= interval.end) {
            let (constraint, start, end) = (name.to_owned(), interval.start, interval.end);
            return Err(DynamicsError::Outside { constraint, at, start, end });
        }
    }
    shape.stencil(at, loftsman_kernel::shape::Derivative::POSITION)?;
    Ok(())
}
