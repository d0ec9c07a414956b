//! Inequalities: which of them hold with equality at the least energy.
//!
//! A dual method in the manner of Goldfarb and Idnani (1983): it starts from the least energy under the equations alone,
//! takes the most violated inequality as an equation, and lets go of those whose multiplier pushes the wrong way. What it
//! ends with meets all of them, and no inequality that holds with equality would let go: the conditions of Karush, Kuhn and Tucker,
//! which for a convex energy are those of the least.

use std::sync::Arc;

use loftsman_kernel::edit::{Axis, Constraint, EditError, Value, Wanted};
use loftsman_kernel::error::Error;
use loftsman_kernel::functional::{Functional, Shapes};
use loftsman_kernel::plugin::ConstraintReport;
use loftsman_kernel::solve::SolveError;

/// A violation below this, relative to the numbers at hand, is rounding.
const MET: f64 = 1e-11;
/// A multiplier below this part of the largest is none.
const IDLE: f64 = 1e-9;

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
            let (found, needed) = (value.len(), asked.len());
            return Err(Error::Invalid(format!(
                "{name}: {found} number(s) were given where {needed} are needed"
            ))
            .into());
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
    /// The equation that holds where the bound is reached.
    fn reached(&self) -> Constraint {
        let constraint = Constraint::new(Arc::clone(&self.functional), Wanted::To(self.value.into()));
        if self.functional.is_vector() {
            constraint.axis([Axis::X, Axis::Y, Axis::Z][self.equation.min(2)])
        } else {
            constraint
        }
    }

    /// By how much the value is on the wrong side of its bound.
    pub(crate) fn violation(&self, shapes: &Shapes<'_>) -> Result<f64, Error> {
        Ok((-self.slack(shapes, &mut Vec::new())?.0).max(0.0))
    }

    /// How far on the right side of its bound the value is, and the size of the numbers that says.
    fn slack(&self, shapes: &Shapes<'_>, values: &mut Vec<f64>) -> Result<(f64, f64), Error> {
        values.clear();
        values.resize(self.functional.equations(), 0.0);
        self.functional.value(shapes, values)?;
        let value = values[self.equation];
        Ok((self.sign * (value - self.value), value.abs() + self.value.abs()))
    }
}

/// What is known of a shape that is the fairest under some equations.
pub(crate) trait Candidate {
    /// The shapes of the problem.
    fn shapes(&self) -> Shapes<'_>;
    /// The reports of the equations, in the order in which they were asked.
    fn constraints(&self) -> &[ConstraintReport];
}

/// The candidate under the equations and those bounds that hold with equality, with an account of every bound and the
/// names of those that do. `solve` gives the candidate of some equations; `active` is where the search begins and what it
/// ends with.
pub(crate) fn bounded<C: Candidate>(
    equations: &[Constraint],
    bounds: &[Bound],
    active: &mut Vec<usize>,
    solve: &dyn Fn(Vec<Constraint>) -> Result<C, EditError>,
) -> Result<(C, Vec<ConstraintReport>, Vec<String>), EditError> {
    let limit = 50 + 20 * bounds.len();
    let mut values = Vec::new();
    for _ in 0..limit {
        let all = equations.iter().cloned().chain(active.iter().map(|&b| bounds[b].reached()));
        let candidate = solve(all.collect())?;
        // The rate of the least energy with each bound's value: what pushes the wrong way is let go, the strongest first.
        let pushes: Vec<f64> = active
            .iter()
            .enumerate()
            .map(|(k, &b)| {
                let told = candidate.constraints().get(equations.len() + k);
                bounds[b].sign * told.and_then(|t| t.multipliers.first().copied()).unwrap_or(0.0)
            })
            .collect();
        let strongest = pushes.iter().fold(0.0_f64, |m, p| m.max(p.abs()));
        let wrong = pushes.iter().enumerate().filter(|(_, p)| **p < -IDLE * strongest);
        if let Some((k, _)) = wrong.min_by(|a, b| a.1.total_cmp(b.1)) {
            active.remove(k);
            continue;
        }
        let mut worst: Option<(usize, f64)> = None;
        let mut account = Vec::with_capacity(bounds.len());
        // Rounding is that of the whole shape's coordinates.
        let shapes = candidate.shapes();
        let size = (0..shapes.vertex_count()).map(|v| shapes.vertex(v).coords.amax()).fold(0.0, f64::max);
        for (b, bound) in bounds.iter().enumerate() {
            let (slack, own) = bound.slack(&shapes, &mut values)?;
            let position = active.iter().position(|&a| a == b);
            if position.is_none() && slack < -MET * own.max(size) && worst.is_none_or(|(_, w)| slack < w) {
                worst = Some((b, slack));
            }
            account.push(ConstraintReport {
                between: None,
                name: bound.label.clone(),
                residual: (-slack).max(0.0),
                multipliers: vec![position.map_or(0.0, |k| bound.sign * pushes[k])],
            });
        }
        match worst {
            Some((b, _)) => active.push(b),
            None => {
                active.sort_unstable();
                let names = active.iter().map(|&b| bounds[b].label.clone()).collect();
                return Ok((candidate, account, names));
            }
        }
    }
    Err(SolveError::Unsupported(format!(
        "after {limit} attempts it is still open which of {} inequalities hold with equality: ask for fewer, or less at once",
        bounds.len()
    ))
    .into())
}
