//! What a simulation is made of, before it is prepared.

use loftsman_kernel::Vector;
use loftsman_kernel::functional::Shapes;
use loftsman_kernel::solve::{RangeSpace, Weight};

use crate::body::{Body, extent};
use crate::constraint::{Force, Hold, Pull};
use crate::elastic::{Elastic, unbending};
use crate::error::{DynamicsError, Result, check, check_time, check_vector};
use crate::link::Link;
use crate::load::Load;
use crate::mass::Mass;
use crate::place::{check_constraint, on_shape, slide_of};
use crate::scheme::Scheme;
use crate::simulation::{Moving, Simulation, stable_step};
use crate::stability::highest;

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
    constraints: Vec<Hold>,
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
    pub fn hold(mut self, constraint: Hold) -> Self {
        self.constraints.push(constraint);
        self
    }

    /// Keeps the curves that there are so far as they are closed and smooth by where their control vertices are and not by their knots: ends that meet stay together,
    /// and so do pieces; where a curve of degree 2 or more runs smoothly over its ends or a knot of full multiplicity, it goes on doing so (`C'₊ = r C'₋` with the `r` of the start; knots of
    /// curves of up to 64 such). Ends that other constraints of this setup [fix](crate::fixed) both stay theirs. These are constraints like others, numbered behind those that
    /// there are. Places slide round over ends that are kept together.
    #[must_use]
    pub fn keep_seams(mut self) -> Self {
        let mut all = Vec::new();
        for (index, body) in self.bodies.iter_mut().enumerate() {
            let (closed, kept) = crate::seam::kept(body, index, &self.constraints);
            body.closed |= closed;
            body.kept += kept.len();
            all.extend(kept);
        }
        self.constraints.extend(all);
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
    /// Parameters are measured in lengths for this, by the mean pace along the shape: the number means the same for any knots.
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
        let Self { bodies, gravity, mut constraints, forces, pulls, scheme, epsilon, step, draw } = self;
        check_vector("gravity", &gravity)?;
        check("epsilon", epsilon, false)?;
        check_time("the time in which constraints are drawn in", draw)?;
        if let Some(step) = step {
            check_time("the step", step)?;
        }
        constraints
            .iter()
            .flat_map(|constraint| &constraint.parts)
            .try_for_each(|part| part.target.check())?;
        // Those that are called the same are numbered.
        let names: Vec<String> = constraints.iter().map(|constraint| constraint.name.clone()).collect();
        for (index, constraint) in constraints.iter_mut().enumerate() {
            if names.iter().filter(|name| **name == constraint.name).count() > 1 {
                constraint.name = format!("{} (constraints[{index}])", names[index]);
            }
        }
        let size = bodies.iter().map(Body::size).fold(0.0, f64::max);
        let mut moving = Vec::with_capacity(bodies.len());
        let (mut weights, mut start, mut lightest) = (Vec::new(), 0, f64::INFINITY);
        for body in bodies {
            body.material.check()?;
            let count = body.shape.control_vertices().len();
            if !body.still && extent(body.shape.control_vertices()) == 0.0 {
                return Err(DynamicsError::Point { body: body.name.clone() });
            }
            if !body.still
                && body.material.bending > 0.0
                && let Some(direction) = unbending(body.shape.as_ref())?
            {
                let along = match (body.shape.domain().len(), direction) {
                    (1, _) => "",
                    (_, 0) => " along u",
                    _ => " along v",
                };
                let own = if moving.is_empty() { "" } else { " (`bending = 0` for this body)" };
                return Err(DynamicsError::Unbending { body: body.name.clone(), along, own });
            }
            let (elastic, mass, highest) = if body.still {
                weights.push((Weight::Still(count), None));
                (None, None, 0.0)
            } else {
                let elastic = Elastic::new(body.shape.as_ref(), &body.material, body.kept)?;
                let faced = elastic.points.cells.iter().any(|cell| cell.face.is_some());
                let mass = Mass::new(body.shape.as_ref(), &body.material).map_err(|error| match error {
                    DynamicsError::Massless { vertex, .. } => DynamicsError::Massless { vertex, cage: faced },
                    other => other,
                })?;
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
        let (links, loads) = {
            let shapes = Shapes::new(moving.iter().map(|body| body.body.shape.as_ref()));
            let links = constraints
                .into_iter()
                .map(|constraint| {
                    check_constraint(&constraint, &shapes)?;
                    Link::new(
                        constraint,
                        &shapes,
                        &|body, axis| slide_of(moving.get(body).map(|moving| &moving.body), axis),
                        draw,
                    )
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
        let stable = stable_step(&moving, &loads);
        let mut simulation = Simulation::new(moving, gravity, links, loads, space, scheme, size);
        simulation.limits(step, stable, epsilon * lightest);
        simulation.begin()?;
        Ok(simulation)
    }
}
