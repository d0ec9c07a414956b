//! A body, and what is prepared of it.

use loftsman_kernel::Point;
use loftsman_kernel::shape::Shape;

use crate::body::Body;
use crate::elastic::Elastic;
use crate::error::{DynamicsError, Result};
use crate::mass::Mass;

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
}
