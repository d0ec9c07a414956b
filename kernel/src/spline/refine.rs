//! Splines refined through the interface that all shapes have: knots inserted.

use super::{Curve, Direction, Surface, Trimmed};
use crate::error::{Error, Result};
use crate::shape::{Refine, Shape};

impl Refine for Curve {
    fn refined(&self, direction: usize, parameters: &[f64]) -> Result<Box<dyn Shape>> {
        match direction {
            0 => Ok(Box::new(self.insert_knots(parameters)?)),
            _ => Err(no_direction(direction, 1)),
        }
    }
}

impl Surface {
    fn refined_surface(&self, direction: usize, parameters: &[f64]) -> Result<Self> {
        match direction {
            0 => self.insert_knots(Direction::U, parameters),
            1 => self.insert_knots(Direction::V, parameters),
            _ => Err(no_direction(direction, 2)),
        }
    }
}

impl Refine for Surface {
    fn refined(&self, direction: usize, parameters: &[f64]) -> Result<Box<dyn Shape>> {
        Ok(Box::new(self.refined_surface(direction, parameters)?))
    }
}

/// Its loops stay: knots change nothing in the parameter plane.
impl Refine for Trimmed {
    fn refined(&self, direction: usize, parameters: &[f64]) -> Result<Box<dyn Shape>> {
        Ok(Box::new(self.on(self.surface().refined_surface(direction, parameters)?)?))
    }
}

fn no_direction(direction: usize, count: usize) -> Error {
    Error::Invalid(format!("there is no direction {direction}: the shape has {count}, numbered from 0"))
}
