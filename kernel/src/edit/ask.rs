//! What is wanted of a functional.

use std::sync::Arc;

use crate::functional::Functional;
use crate::{Point, Vector};

/// An axis of space.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// The x axis.
    X,
    /// The y axis.
    Y,
    /// The z axis.
    Z,
}

/// Numbers that a functional should have or change by: one, a vector, or as many as it has equations.
#[derive(Debug, Clone, PartialEq)]
pub struct Value(pub Vec<f64>);

impl From<f64> for Value {
    fn from(value: f64) -> Self {
        Self(vec![value])
    }
}

impl From<[f64; 3]> for Value {
    fn from(value: [f64; 3]) -> Self {
        Self(value.to_vec())
    }
}

impl From<Vector> for Value {
    fn from(value: Vector) -> Self {
        Self(value.as_slice().to_vec())
    }
}

impl From<Point> for Value {
    fn from(value: Point) -> Self {
        value.coords.into()
    }
}

impl From<Vec<f64>> for Value {
    fn from(value: Vec<f64>) -> Self {
        Self(value)
    }
}

/// What a functional's value should become.
#[derive(Debug, Clone, PartialEq)]
pub enum Wanted {
    /// This value.
    To(Value),
    /// The present value plus this.
    By(Value),
    /// The present value times this.
    Scale(f64),
    /// The present value.
    Keep,
    /// Zero: a condition holds.
    Hold,
    /// This value or more (solvers of inequalities only).
    AtLeast(Value),
    /// This value or less (solvers of inequalities only).
    AtMost(Value),
}

/// A functional and what is wanted of it.
#[derive(Debug, Clone)]
pub struct Constraint {
    pub(crate) functional: Arc<dyn Functional>,
    pub(crate) wanted: Wanted,
    pub(crate) axis: Option<Axis>,
}

impl Constraint {
    /// A functional and what is wanted of it.
    pub fn new(functional: Arc<dyn Functional>, wanted: Wanted) -> Self {
        Self { functional, wanted, axis: None }
    }

    /// Narrows a vector's constraint to one axis: the others stay free.
    #[must_use]
    pub fn axis(mut self, axis: Axis) -> Self {
        self.axis = Some(axis);
        self
    }

    /// The functional.
    pub fn functional(&self) -> &Arc<dyn Functional> {
        &self.functional
    }

    /// What is wanted of it.
    pub fn wanted(&self) -> &Wanted {
        &self.wanted
    }

    /// What it is, for people: `position at 0.25`, `x of position at 0.25`.
    pub fn describe(&self) -> String {
        let name = self.functional.describe();
        match self.axis {
            None => name,
            Some(axis) => format!("{} of {name}", ["x", "y", "z"][axis as usize]),
        }
    }

    /// Which of the functional's equations are asked.
    pub(crate) fn asks(&self, equation: usize) -> bool {
        self.axis.is_none_or(|axis| axis as usize == equation)
    }
}

/// Says what is wanted of a functional; every functional has it.
pub trait Ask: Functional + Sized + 'static {
    /// The value should become this.
    fn to(self, value: impl Into<Value>) -> Constraint {
        Constraint::new(Arc::new(self), Wanted::To(value.into()))
    }

    /// The value should change by this.
    fn by(self, change: impl Into<Value>) -> Constraint {
        Constraint::new(Arc::new(self), Wanted::By(change.into()))
    }

    /// The value should be multiplied by this.
    fn scale(self, factor: f64) -> Constraint {
        Constraint::new(Arc::new(self), Wanted::Scale(factor))
    }

    /// The value should stay.
    fn keep(self) -> Constraint {
        Constraint::new(Arc::new(self), Wanted::Keep)
    }

    /// The value should become zero; what conditions (symmetric, joined, parallel to a direction) are for.
    fn hold(self) -> Constraint {
        Constraint::new(Arc::new(self), Wanted::Hold)
    }

    /// The value should be this or more. Only solvers of inequalities take it.
    fn at_least(self, value: impl Into<Value>) -> Constraint {
        Constraint::new(Arc::new(self), Wanted::AtLeast(value.into()))
    }

    /// The value should be this or less. Only solvers of inequalities take it.
    fn at_most(self, value: impl Into<Value>) -> Constraint {
        Constraint::new(Arc::new(self), Wanted::AtMost(value.into()))
    }
}

impl<F: Functional + 'static> Ask for F {}
