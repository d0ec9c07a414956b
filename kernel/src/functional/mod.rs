//! What may be asked of shapes: functionals.
//!
//! A functional is a number, or several, that a shape has: where it passes, how it is directed, how much area
//! it encloses. It is written once and works on every [`Shape`](crate::shape::Shape).

mod rows;
mod shapes;

use std::fmt::Debug;

pub use rows::{Equation, Rows};
pub use shapes::Shapes;

use crate::error::Result;
use crate::plugin::{Declaration, ParameterError, Parameters};

/// How a functional depends on the control vertices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Linearity {
    /// `f(P) = Σ a_i·P_i + c`.
    Linear,
    /// Linear in each axis while the other axes are held (area, volume).
    Multilinear,
    /// Anything else with a gradient.
    Nonlinear,
}

/// Something that may be asked of shapes: `f(P)`, one number or several.
pub trait Functional: Debug + Send + Sync {
    /// How many numbers it is.
    fn equations(&self) -> usize;

    /// How it depends on the control vertices.
    fn linearity(&self) -> Linearity;

    /// Appends its linearization at the shapes' present state: [`equations`](Self::equations) rows of partial
    /// derivatives with respect to control vertices, and for linear functionals the constant as well.
    ///
    /// # Errors
    /// When the functional cannot be asked of these shapes (a location outside the domain, a tangent that
    /// vanishes, …).
    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()>;

    /// Its present value, [`equations`](Self::equations) numbers. For a linear functional the default, rows
    /// times vertices plus constants, is right.
    ///
    /// # Errors
    /// As for [`rows`](Self::rows).
    fn value(&self, shapes: &Shapes<'_>, out: &mut [f64]) -> Result<()> {
        let mut store = rows::Store::default();
        self.rows(shapes, &mut store.rows(shapes))?;
        store.evaluate(shapes, out);
        Ok(())
    }

    /// What it is, for people and reports: `position at 0.25`.
    fn describe(&self) -> String;

    /// Functionals that must stand still for this one to mean what it says; each is kept unless the edit asks
    /// for the same thing (equal [`describe`](Self::describe)) itself. None by default.
    fn companions(&self) -> Vec<std::sync::Arc<dyn Functional>> {
        Vec::new()
    }

    /// Whether its equations are one vector's x, y and z, so that it can be narrowed to an axis and be given a
    /// vector as target.
    fn is_vector(&self) -> bool {
        false
    }
}

/// Resolves names of objects in a recipe to shapes of the problem.
pub trait ShapeNames {
    /// The number of the shape in the problem ([`Shapes`]); it is added to the problem where needed.
    ///
    /// # Errors
    /// When there is no such object or it is not an editable shape.
    fn shape(&mut self, object: &str) -> Result<usize>;
}

/// A functional that recipes can ask for by name.
pub trait DeclaredFunctional: Functional + Sized + 'static {
    /// Its name, help and fields.
    const DECLARATION: Declaration;

    /// The functional that the fields describe. The fields have been checked against the declaration.
    ///
    /// # Errors
    /// When a field's value is wrong.
    fn from_parameters(parameters: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError>;
}
