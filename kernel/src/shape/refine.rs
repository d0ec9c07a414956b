//! Shapes that can be given more control vertices without being changed.

use super::Shape;
use crate::error::{Error, Result};

/// What a shape can do that can be refined: hold, after it, more than it could before.
pub trait Refine {
    /// The same shape with places where its pieces end (of a spline: knots) at these parameters of a direction (0 for `u`):
    /// one more at each, repeated ones oftener. What is there already is met once more.
    ///
    /// # Errors
    /// When there is no such direction, or a parameter is outside the domain or cannot be divided any more.
    fn refined(&self, direction: usize, parameters: &[f64]) -> Result<Box<dyn Shape>>;
}

/// What refines a shape; `what` needs it.
///
/// # Errors
/// When it cannot be refined, in words that name `what` and the shape's type.
pub fn refine_of<'a>(shape: &'a dyn Shape, what: &str) -> Result<&'a dyn Refine> {
    shape.refine().ok_or_else(|| {
        Error::Invalid(format!(
            "{what} refines a shape where it is asked, and a shape ({}) cannot be refined: convert it to a B-spline first",
            shape.type_name()
        ))
    })
}
