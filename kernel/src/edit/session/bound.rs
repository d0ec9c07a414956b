//! Constraints with numbers for targets.

use super::ConstraintId;
use crate::edit::EditError;
use crate::edit::ask::{Constraint, Value, Wanted};
use crate::edit::assembly::Assembly;
use crate::error::{Error, Result};
use crate::functional::{Functional, Shapes};
use crate::solve::Sense;
use std::sync::Arc;

/// A constraint whose functional is bound and whose target is a number.
#[derive(Debug, Clone)]
pub(super) struct Bound {
    pub(super) id: ConstraintId,
    pub(super) constraint: Constraint,
    /// The wanted value: all of the functional's numbers, asked or not.
    pub(super) target: Vec<f64>,
}

/// Functionals that must stand still for others, unless they are asked for themselves.
pub(super) fn add_companions(constraints: &mut Vec<Constraint>, handle: Option<&dyn Functional>) {
    let mut asked: Vec<String> = constraints.iter().map(|c| c.functional.describe()).collect();
    asked.extend(handle.map(Functional::describe));
    let mut wanted: Vec<Arc<dyn Functional>> = constraints
        .iter()
        .filter(|c| c.sense() == Sense::Equal)
        .flat_map(|c| c.functional.companions())
        .collect();
    wanted.extend(handle.into_iter().flat_map(Functional::companions));
    for companion in wanted {
        let name = companion.describe();
        if !asked.contains(&name) {
            asked.push(name);
            constraints.push(Constraint::new(companion, Wanted::Keep));
        }
    }
}

pub(super) fn bind(
    shapes: &Shapes<'_>,
    mut constraint: Constraint,
    id: ConstraintId,
) -> Result<Bound, EditError> {
    if let Some(bound) = constraint.functional.bind(shapes)? {
        constraint.functional = bound;
    }
    let name = constraint.describe();
    if constraint.axis.is_some() && !constraint.functional.is_vector() {
        return Err(
            Error::Invalid(format!("{name} cannot be narrowed to an axis: it is not a vector")).into()
        );
    }
    let count = constraint.functional.equations();
    let mut target = vec![0.0; count];
    constraint.functional.value(shapes, &mut target)?;
    let present = target.clone();
    let check = |value: &Value| -> Result<Vec<f64>, EditError> {
        if let Some(bad) = value.0.iter().find(|v| !v.is_finite()) {
            return Err(Error::Invalid(format!("{name}: {bad} is not a finite number")).into());
        }
        match (value.0.len(), constraint.axis) {
            (found, _) if found == count => Ok(value.0.clone()),
            // One number for the one axis that is asked.
            (1, Some(_)) => Ok(vec![value.0[0]; count]),
            (found, _) if constraint.functional.is_condition() => Err(Error::Invalid(format!(
                "{name} is a condition that holds or not, and {found} number(s) were given: keep it, or say what it should \
                 be like in its own fields (\"direction\" for a tangent)"
            ))
            .into()),
            (found, _) => {
                Err(Error::Invalid(format!("{name}: {found} number(s) were given where {count} are needed"))
                    .into())
            }
        }
    };
    match &constraint.wanted {
        Wanted::Keep => {}
        Wanted::Hold => target.fill(0.0),
        Wanted::To(value) | Wanted::AtLeast(value) | Wanted::AtMost(value) => target = check(value)?,
        Wanted::By(value) => target.iter_mut().zip(check(value)?).for_each(|(t, by)| *t += by),
        Wanted::Scale(factor) if factor.is_finite() => target.iter_mut().for_each(|t| *t *= factor),
        Wanted::Scale(factor) => {
            return Err(
                Error::Invalid(format!("{name}: {factor} is not a factor; give a finite number")).into()
            );
        }
    }
    if let Some(bad) = target.iter().find(|t| !t.is_finite()) {
        return Err(Error::Invalid(format!("{name}: its value would be {bad}; ask for less")).into());
    }
    constraint.functional.check_target(&present, &target)?;
    Ok(Bound { id, constraint, target })
}

/// Wanted minus present values into `rhs`, the sizes of the numbers they come from into `size`; and for each
/// constraint its largest error and the size to measure it by.
pub(super) fn right_hand_side(
    shapes: &Shapes<'_>,
    bound: &[Bound],
    assembly: &Assembly,
    rhs: &mut Vec<f64>,
    size: &mut Vec<f64>,
) -> Result<Vec<(f64, f64)>> {
    let entries = assembly.system.rows().len() * assembly.system.sides();
    rhs.clear();
    rhs.resize(entries, 0.0);
    size.clear();
    size.resize(entries, 0.0);
    let mut errors = Vec::with_capacity(bound.len());
    let mut value = Vec::new();
    for (k, b) in bound.iter().enumerate() {
        value.clear();
        value.resize(b.constraint.functional.equations(), 0.0);
        b.constraint.functional.value(shapes, &mut value)?;
        let mut worst = (0.0_f64, 0.0_f64);
        for slot in assembly.slots(k) {
            let (at, equation) = (assembly.entry(slot), slot.equation as usize);
            rhs[at] = b.target[equation] - value[equation];
            size[at] = slot.magnitude + b.target[equation].abs() + value[equation].abs();
            worst = (worst.0.max(error_of(b.constraint.sense(), rhs[at])), worst.1.max(size[at]));
        }
        errors.push(worst);
    }
    Ok(errors)
}

/// By how much a value misses its target that is `wanted` above it (below it, where negative).
pub(super) fn error_of(sense: Sense, wanted: f64) -> f64 {
    match sense {
        Sense::Equal => wanted.abs(),
        Sense::AtLeast => wanted.max(0.0),
        Sense::AtMost => (-wanted).max(0.0),
    }
}
