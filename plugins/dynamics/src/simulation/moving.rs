//! A body, and what is prepared of it.

use loftsman_kernel::Point;
use loftsman_kernel::shape::Shape;

use crate::body::Body;
use crate::elastic::Elastic;
use crate::error::{DynamicsError, Result};
use crate::load::Load;
use crate::mass::Mass;
use crate::stability::{highest, longest_step};

/// A body, and what is prepared of it.
#[derive(Debug, Clone)]
pub(crate) struct Moving {
    pub(crate) body: Body,
    /// A shape whose control vertices are velocities.
    pub(crate) velocity: Box<dyn Shape>,
    pub(crate) start: usize,
    /// Its control vertices at the start.
    pub(crate) first: Vec<Point>,
    pub(crate) elastic: Option<Elastic>,
    pub(crate) mass: Option<Mass>,
    pub(crate) highest: f64,
}

impl Moving {
    pub(crate) fn new(
        body: Body,
        start: usize,
        elastic: Option<Elastic>,
        mass: Option<Mass>,
        highest: f64,
    ) -> Result<Self> {
        let mut velocity = body.shape.boxed();
        let count = velocity.control_vertices().len();
        velocity.control_vertices_mut().fill(Point::origin());
        if let Some(given) = &body.velocities {
            let needed = "give one finite velocity for each control vertex";
            if given.len() != count {
                return Err(DynamicsError::Number {
                    what: "the number of velocities",
                    value: given.len() as f64,
                    needed,
                });
            }
            if let Some(bad) = given.iter().flat_map(|v| v.iter()).find(|v| !v.is_finite()) {
                return Err(DynamicsError::Number { what: "a velocity", value: *bad, needed });
            }
            for (vertex, v) in velocity.control_vertices_mut().iter_mut().zip(given) {
                vertex.coords = *v;
            }
        }
        let first = body.shape.control_vertices().to_vec();
        Ok(Self { body, velocity, start, first, elastic, mass, highest })
    }

    pub(crate) fn count(&self) -> usize {
        self.body.shape.control_vertices().len()
    }

    pub(crate) fn range(&self) -> std::ops::Range<usize> {
        3 * self.start..3 * (self.start + self.count())
    }

    /// Prepares anew what follows from its shape at the start.
    pub(super) fn prepare_again(&mut self) -> Result<()> {
        let mut first = self.body.shape.boxed();
        first.control_vertices_mut().copy_from_slice(&self.first);
        self.velocity = first.boxed();
        self.velocity.control_vertices_mut().fill(Point::origin());
        if self.mass.is_some() {
            let material = &self.body.material;
            let mut elastic = Elastic::new(first.as_ref(), material, self.body.kept)?;
            let mass = Mass::new(first.as_ref(), material)?;
            self.highest = highest(first.as_ref(), material, &elastic, &mass)?;
            if let Some(was) = &self.elastic {
                elastic.see(was.rule());
            }
            (self.elastic, self.mass) = (Some(elastic), Some(mass));
        }
        Ok(())
    }
}

/// The longest step that is stable, of bodies and what pulls them.
pub(crate) fn stable_step(bodies: &[Moving], loads: &[Load]) -> f64 {
    let stable = bodies
        .iter()
        .filter(|body| body.mass.is_some())
        .map(|body| longest_step(body.highest, &body.body.material))
        .fold(f64::INFINITY, f64::min);
    // A pull is a spring: its frequencies add to those of the body.
    let stiffest = loads.iter().map(Load::frequency).fold(0.0, f64::max);
    if stiffest > 0.0 { 1.0 / (1.0 / (stable * stable) + 4.0 * stiffest).sqrt() } else { stable }
}
