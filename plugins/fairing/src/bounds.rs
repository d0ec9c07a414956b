//! Inequalities: numbers of functionals that must stay on one side of a value.

use std::sync::Arc;

use loftsman_kernel::Vector;
use loftsman_kernel::edit::{Axis, Constraint, EditError, Value, Wanted};
use loftsman_kernel::error::Error;
use loftsman_kernel::functional::{Equation, Functional, Linearity, Shapes, Store, rows_of, value_of};
use loftsman_kernel::measure::{Measured, ROUNDING, measure};
use loftsman_kernel::plugin::ConstraintReport;
use loftsman_kernel::solve::{Sense, SolveError};

use crate::active::Row;
use loftsman_kernel::text::counted;

/// One number of a functional that must stay on one side of a value.
#[derive(Debug, Clone)]
pub(crate) struct Bound {
    functional: Arc<dyn Functional>,
    equation: usize,
    value: f64,
    /// 1 for "at least", -1 for "at most".
    sign: f64,
    label: String,
}

/// The constraints that are equations, and the numbers that are bounded.
pub(crate) fn split(
    constraints: Vec<Constraint>,
    shapes: &Shapes<'_>,
) -> Result<(Vec<Constraint>, Vec<Bound>), EditError> {
    let (mut equations, mut bounds) = (Vec::new(), Vec::new());
    for constraint in constraints {
        let (sign, value) = match constraint.wanted() {
            Wanted::AtLeast(Value(value)) => (1.0, value.clone()),
            Wanted::AtMost(Value(value)) => (-1.0, value.clone()),
            _ => {
                equations.push(constraint);
                continue;
            }
        };
        // What it takes from the shape's present state is that of the start.
        let bound = constraint.functional().bind(shapes)?;
        let functional = bound.unwrap_or_else(|| Arc::clone(constraint.functional()));
        let count = functional.equations();
        let name = constraint.describe();
        if functional.linearity() != Linearity::Linear {
            return Err(not_linear(&functional.describe()).into());
        }
        if !(functional.is_vector() || count == 1) {
            return Err(Error::Invalid(format!(
                "{name} is {count} numbers and no vector: it cannot be bounded"
            ))
            .into());
        }
        let asked: Vec<usize> = match constraint.narrowed() {
            Some(axis) => vec![axis as usize],
            None => (0..count).collect(),
        };
        if value.len() != asked.len() && value.len() != count {
            let found = counted(value.len(), "number[|s] [was|were] given");
            let needed = counted(asked.len(), "[is|are] needed");
            return Err(Error::Invalid(format!("{name}: {found} where {needed}")).into());
        }
        let than = if sign > 0.0 { "≥" } else { "≤" };
        for (k, &equation) in asked.iter().enumerate() {
            let value = value[if value.len() == asked.len() { k } else { equation }];
            if !value.is_finite() {
                return Err(Error::Invalid(format!("{name}: {value} is not a finite number")).into());
            }
            let axis = match constraint.narrowed() {
                None if functional.is_vector() => format!("{} of ", ["x", "y", "z"][equation.min(2)]),
                _ => String::new(),
            };
            let label = format!("{axis}{name} {than} {value}");
            bounds.push(Bound { functional: Arc::clone(&functional), equation, value, sign, label });
        }
    }
    Ok((equations, bounds))
}

impl Bound {
    /// What it is: `y of position at 3 ≥ 2`.
    pub(crate) fn name(&self) -> String {
        self.label.clone()
    }

    /// 1 for "at least", -1 for "at most".
    pub(crate) fn sign(&self) -> f64 {
        self.sign
    }

    /// The equation that holds where the bound is reached.
    pub(crate) fn reached(&self) -> Constraint {
        let constraint = Constraint::new(Arc::clone(&self.functional), Wanted::To(self.value.into()));
        if self.functional.is_vector() {
            constraint.axis([Axis::X, Axis::Y, Axis::Z][self.equation.min(2)])
        } else {
            constraint
        }
    }

    /// Its value measured on shapes: `reach` is the size of what went in.
    pub(crate) fn measured(&self, shapes: &Shapes<'_>, reach: f64) -> Result<Measured, Error> {
        let mut target = vec![0.0; self.functional.equations()];
        target[self.equation] = self.value;
        let sense = if self.sign > 0.0 { Sense::AtLeast } else { Sense::AtMost };
        let asked = |equation| equation == self.equation;
        measure(shapes, self.functional.as_ref(), sense, &target, &asked, reach)
    }

    /// How far on the right side of its bound the value is.
    pub(crate) fn slack(&self, shapes: &Shapes<'_>) -> Result<f64, Error> {
        let mut values = vec![0.0; self.functional.equations()];
        value_of(self.functional.as_ref(), shapes, &mut values)?;
        Ok(self.sign * (values[self.equation] - self.value))
    }

    /// Whether it holds with equality, to rounding.
    pub(crate) fn touched(&self, shapes: &Shapes<'_>, reach: f64) -> Result<bool, Error> {
        let mut all = 0.0;
        self.terms(shapes, &mut |_, _, c| all += c.abs())?;
        Ok(self.slack(shapes)? <= ROUNDING * (all * reach + self.value.abs()))
    }

    /// The report of a bound that misses its value by so much, with its multiplier.
    pub(crate) fn account(&self, residual: f64, push: f64) -> ConstraintReport {
        ConstraintReport {
            name: self.label.clone().into(),
            residual,
            dimension: self.functional.dimension(),
            location: None,
            between: None,
            multipliers: vec![self.sign * push],
        }
    }

    /// Its row, `Σ c x ≥ b` over the coordinates that may move, for points relative to an origin; `rest` is where they are.
    pub(crate) fn row(&self, shapes: &Shapes<'_>, rest: &[Vector], free: &[bool]) -> Result<Row, Error> {
        let mut row = Row::default();
        let (mut present, mut all) = (0.0, 0.0);
        self.terms(shapes, &mut |vertex, axis, c| {
            all += c.abs();
            if free.get(vertex) == Some(&true) && c != 0.0 {
                present += self.sign * c * rest[vertex][axis];
                row.terms.push((3 * vertex + axis, self.sign * c));
            }
        })?;
        row.value = present - self.slack(shapes)?;
        row.size = all * reach(shapes) + self.value.abs();
        Ok(row)
    }

    /// Every vertex, axis and coefficient of the number that is bounded.
    fn terms(&self, shapes: &Shapes<'_>, put: &mut dyn FnMut(usize, usize, f64)) -> Result<(), Error> {
        let mut store = Store::default();
        rows_of(self.functional.as_ref(), shapes, &mut store.rows(shapes))?;
        let mut next = 0;
        for equation in store.equations() {
            match equation {
                Equation::Alike { vertices, coefficients, .. } => {
                    if (next..next + 3).contains(&self.equation) {
                        let axis = self.equation - next;
                        vertices.iter().zip(coefficients).for_each(|(&v, &c)| put(v, axis, c));
                    }
                    next += 3;
                }
                Equation::Coupled { vertices, vectors, .. } => {
                    if next == self.equation {
                        for (&v, a) in vertices.iter().zip(vectors) {
                            (0..3).for_each(|axis| put(v, axis, a[axis]));
                        }
                    }
                    next += 1;
                }
            }
        }
        Ok(())
    }
}

/// The largest coordinate of some shapes.
pub(crate) fn reach(shapes: &Shapes<'_>) -> f64 {
    (0..shapes.vertex_count()).map(|v| shapes.vertex(v).coords.amax()).fold(0.0, f64::max)
}

/// That a functional is not linear.
pub(crate) fn not_linear(name: &str) -> SolveError {
    SolveError::Unsupported(format!(
        "{name} is not linear in the control vertices, and a fair shape is sought under linear constraints only: leave \
         it out, or use \"edit\" with the metric \"bend\""
    ))
}
