//! What is wanted of a functional.

use std::sync::Arc;

use crate::functional::Functional;
use crate::problem::Name;
use crate::solve::Sense;
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

impl Axis {
    /// Its letter.
    fn letter(self) -> &'static str {
        ["x", "y", "z"][self as usize]
    }
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

impl From<[f64; 2]> for Value {
    fn from(value: [f64; 2]) -> Self {
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
    /// This value or more.
    AtLeast(Value),
    /// This value or less.
    AtMost(Value),
}

/// A functional and what is wanted of it.
#[derive(Debug, Clone)]
pub struct Constraint {
    pub(crate) functional: Arc<dyn Functional>,
    pub(crate) wanted: Wanted,
    pub(crate) axis: Option<Axis>,
    /// Beside what it stands still, where nobody asked for it.
    pub(crate) companion: Option<String>,
    /// What whoever asked calls it, where that is not what the functional is.
    pub(crate) called: Option<Arc<str>>,
    /// Whether nothing stands still beside it.
    pub(crate) by_itself: bool,
}

impl Constraint {
    /// A functional and what is wanted of it.
    pub fn new(functional: Arc<dyn Functional>, wanted: Wanted) -> Self {
        Self { functional, wanted, axis: None, companion: None, called: None, by_itself: false }
    }

    /// Narrows a vector's constraint to one axis: the others stay free.
    #[must_use]
    pub fn axis(mut self, axis: Axis) -> Self {
        self.axis = Some(axis);
        self
    }

    /// Asks it by itself: its [companions](Functional::companions) need not stand still, for whoever says what does.
    #[must_use]
    pub fn by_itself(mut self) -> Self {
        self.by_itself = true;
        self
    }

    /// The same of another functional.
    #[must_use]
    pub fn of(mut self, functional: Arc<dyn Functional>) -> Self {
        self.functional = functional;
        self
    }

    /// The same functional with something else wanted of it.
    #[must_use]
    pub fn wanting(mut self, wanted: Wanted) -> Self {
        self.wanted = wanted;
        self
    }

    /// Gives it a name of its own in reports and messages, for whoever asks for something else than it says: `"the end"`.
    #[must_use]
    pub fn called(mut self, name: &str) -> Self {
        self.called = Some(name.into());
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

    /// The axis that it is narrowed to.
    pub fn narrowed(&self) -> Option<Axis> {
        self.axis
    }

    /// What it is, for people: `position at 0.25`, `x of position at 0.25`, or what it is [called](Self::called).
    pub fn describe(&self) -> String {
        if let Some(called) = &self.called {
            return called.to_string();
        }
        let name = self.functional.describe();
        match self.axis {
            None => name,
            Some(axis) => format!("{} of {name}", axis.letter()),
        }
    }

    /// What it is, and for an inequality its bound: `y of position at 0.25 ≥ 1`.
    pub fn label(&self) -> String {
        let (sign, value) = match &self.wanted {
            Wanted::AtLeast(value) => ("≥", value),
            Wanted::AtMost(value) => ("≤", value),
            _ => return self.describe(),
        };
        // Of a vector that is narrowed to an axis the other numbers bind nothing.
        let binding = self.axis.and_then(|axis| value.0.get(axis as usize..=axis as usize));
        let numbers: Vec<String> = binding.unwrap_or(&value.0).iter().map(f64::to_string).collect();
        let all = numbers.join(", ");
        let bound = if numbers.len() == 1 { all } else { format!("({all})") };
        format!("{} {sign} {bound}", self.describe())
    }

    /// What [`describe`](Self::describe) says, made when it is read.
    pub(crate) fn name(&self) -> Name {
        if let Some(called) = &self.called {
            return String::from(&**called).into();
        }
        Name::of(&self.functional, self.axis.map(Axis::letter))
    }

    /// What [`label`](Self::label) says, made when it is read where it is that of the functional.
    pub(crate) fn title(&self) -> Name {
        match self.sense() {
            Sense::Equal => self.name(),
            Sense::AtLeast | Sense::AtMost => self.label().into(),
        }
    }

    /// Which side of its target its value must be on.
    pub(crate) fn sense(&self) -> Sense {
        match self.wanted {
            Wanted::AtLeast(_) => Sense::AtLeast,
            Wanted::AtMost(_) => Sense::AtMost,
            _ => Sense::Equal,
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

    /// The value should stay; a condition (parallel to a direction, symmetric, joined) should hold.
    fn keep(self) -> Constraint {
        let wanted = if self.is_condition() { Wanted::Hold } else { Wanted::Keep };
        Constraint::new(Arc::new(self), wanted)
    }

    /// The value should become zero; what conditions (symmetric, joined, parallel to a direction) are for.
    fn hold(self) -> Constraint {
        Constraint::new(Arc::new(self), Wanted::Hold)
    }

    /// One axis of a vector, to be asked alone: `position(0.5).axis(Axis::Y).at_least(1.0)`. The others stay free.
    fn axis(self, axis: Axis) -> AxisOf<Self> {
        AxisOf { functional: self, axis }
    }

    /// The value should be this or more; of a vector, each of its numbers.
    fn at_least(self, value: impl Into<Value>) -> Constraint {
        Constraint::new(Arc::new(self), Wanted::AtLeast(value.into()))
    }

    /// The value should be this or less; of a vector, each of its numbers.
    fn at_most(self, value: impl Into<Value>) -> Constraint {
        Constraint::new(Arc::new(self), Wanted::AtMost(value.into()))
    }
}

impl<F: Functional + 'static> Ask for F {}

/// One axis of a vector, to be asked for something.
#[derive(Debug, Clone)]
pub struct AxisOf<F> {
    functional: F,
    axis: Axis,
}

impl<F: Ask> AxisOf<F> {
    /// The coordinate should become this.
    pub fn to(self, value: f64) -> Constraint {
        self.functional.to(value).axis(self.axis)
    }

    /// The coordinate should change by this.
    pub fn by(self, change: f64) -> Constraint {
        self.functional.by(change).axis(self.axis)
    }

    /// The coordinate should be multiplied by this.
    pub fn scale(self, factor: f64) -> Constraint {
        self.functional.scale(factor).axis(self.axis)
    }

    /// The coordinate should stay.
    pub fn keep(self) -> Constraint {
        self.functional.keep().axis(self.axis)
    }

    /// The coordinate should be this or more.
    pub fn at_least(self, value: f64) -> Constraint {
        self.functional.at_least(value).axis(self.axis)
    }

    /// The coordinate should be this or less.
    pub fn at_most(self, value: f64) -> Constraint {
        self.functional.at_most(value).axis(self.axis)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::functional::position;

    /// Of a bound on one axis the number of that axis is told, whichever way it is given.
    #[test]
    fn a_bound_of_one_axis_is_one_number() {
        let label = |constraint: Constraint| constraint.label();
        assert_eq!(label(position(0.5).at_least([0.0, 3.2, 0.0])), "position at 0.5 ≥ (0, 3.2, 0)");
        let of_vector = position(0.5).at_least([0.0, 3.2, 0.0]).axis(Axis::Y);
        assert_eq!(label(of_vector), "y of position at 0.5 ≥ 3.2");
        assert_eq!(label(position(0.5).axis(Axis::Y).at_most(3.2)), "y of position at 0.5 ≤ 3.2");
    }
}
