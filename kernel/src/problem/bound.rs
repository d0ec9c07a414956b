//! Constraints with numbers for targets.

use super::assembly::Assembly;
use super::constraint::{Axis, Constraint, Value, Wanted};
use super::known::Known;
use super::{ConstraintId, EditError, Numbers};
use crate::error::{Error, Result};
use crate::functional::{Curvature, Functional, Linearity, Shapes, equations_of, value_of};
use crate::measure::error_of;
use crate::solve::Sense;
use crate::text::counted;
use smallvec::SmallVec;
use std::any::Any;
use std::sync::Arc;

/// A constraint whose functional is bound and whose target is a number.
#[derive(Debug, Clone)]
pub(crate) struct BoundConstraint {
    pub(crate) id: ConstraintId,
    pub(crate) constraint: Constraint,
    /// The wanted value: all of the functional's numbers, asked or not.
    pub(crate) target: Numbers,
}

/// Something that is asked: the functional, of which axis, and whether it changes rather than stays as it is.
#[derive(Clone, Copy)]
struct Asked<'a> {
    functional: &'a dyn Functional,
    axis: Option<Axis>,
    changes: bool,
}

impl<'a> Asked<'a> {
    fn of(constraint: &'a Constraint) -> Self {
        let changes = constraint.wanted != Wanted::Keep;
        Self { functional: constraint.functional.as_ref(), axis: constraint.axis, changes }
    }

    /// What is dragged anywhere.
    fn dragged(functional: &'a Arc<dyn Functional>) -> Self {
        Self { functional: functional.as_ref(), axis: None, changes: true }
    }

    /// Whether it is of an axis of this.
    fn is_of(&self, functional: &dyn Functional, axis: Axis) -> bool {
        self.axis.is_none_or(|own| own == axis) && self.functional.same_as(functional)
    }
}

const AXES: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];

/// Functionals that should stand still beside others join them, unless they are asked for themselves or something that is
/// asked supersedes them; functionals that mean something else then become what they are beside that. `known` is asked
/// already, the one at `dragged` being the handle.
pub(crate) fn add_companions(
    constraints: &mut Vec<Constraint>,
    handle: Option<&mut Arc<dyn Functional>>,
    known: &[BoundConstraint],
    dragged: Option<usize>,
) {
    // All is judged by what was asked, and changed afterwards: mostly there is nothing to change.
    let mut changed: Vec<(usize, Arc<dyn Functional>)> = Vec::new();
    let mut fresh: Vec<(Arc<dyn Functional>, String)> = Vec::new();
    let asked = || {
        let known = known.iter().enumerate().map(|(k, b)| match dragged == Some(k) {
            true => Asked::dragged(&b.constraint.functional),
            false => Asked::of(&b.constraint),
        });
        constraints
            .iter()
            .map(Asked::of)
            .chain(known)
            .chain(handle.iter().map(|handle| Asked::dragged(handle)))
    };
    let gives_way = |companion: &dyn Functional, axis: Axis| {
        asked().any(|a| a.is_of(companion, axis) || a.changes && a.functional.supersedes(companion))
    };
    let mut consider = |at: usize, functional: &Arc<dyn Functional>, with_companions: bool| {
        let stands_still = |f: &dyn Functional| {
            let kept = |axis| asked().any(|a| !a.changes && a.is_of(f, axis));
            AXES.into_iter().all(|axis| kept(axis) || with_companions && !gives_way(f, axis))
        };
        let other = functional.beside(&stands_still);
        let functional = other.as_ref().unwrap_or(functional);
        let companions = if with_companions { functional.companions() } else { Vec::new() };
        for companion in companions {
            if !fresh.iter().any(|(known, _)| known.same_as(companion.as_ref())) {
                fresh.push((companion, functional.describe()));
            }
        }
        changed.extend(other.map(|other| (at, other)));
    };
    for (at, constraint) in constraints.iter().enumerate() {
        consider(at, &constraint.functional, constraint.sense() == Sense::Equal && !constraint.by_itself);
    }
    if let Some(handle) = &handle {
        consider(constraints.len(), handle, true);
    }
    let mut added = Vec::new();
    for (companion, beside) in fresh {
        let free: SmallVec<[Axis; 3]> =
            AXES.into_iter().filter(|axis| !gives_way(companion.as_ref(), *axis)).collect();
        let kept = Constraint { companion: Some(beside), ..Constraint::new(companion, Wanted::Keep) };
        match free[..] {
            [_, _, _] => added.push(kept),
            _ if !kept.functional.is_vector() => {}
            _ => added.extend(free.into_iter().map(|axis| kept.clone().axis(axis))),
        }
    }
    let (count, mut handle) = (constraints.len(), handle);
    for (at, other) in changed {
        match &mut handle {
            Some(handle) if at == count => **handle = other,
            _ => constraints[at].functional = other,
        }
    }
    constraints.append(&mut added);
}

/// After something is no longer asked: functionals whose companions no longer stand still become what they are beside that.
pub(crate) fn loosen(bound: &mut [BoundConstraint], dragged: Option<usize>) {
    let kept: Vec<(Arc<dyn Functional>, Option<Axis>)> = bound
        .iter()
        .enumerate()
        .filter(|(k, b)| dragged != Some(*k) && b.constraint.wanted == Wanted::Keep)
        .map(|(_, b)| (Arc::clone(&b.constraint.functional), b.constraint.axis))
        .collect();
    let stands_still = |f: &dyn Functional| {
        let kept_along =
            |axis: Axis| kept.iter().any(|(k, own)| own.is_none_or(|own| own == axis) && k.same_as(f));
        AXES.into_iter().all(kept_along)
    };
    for b in bound {
        if let Some(other) = b.constraint.functional.beside(&stands_still) {
            b.constraint.functional = other;
        }
    }
}

/// What to bound where several numbers have no bound together.
fn instead_of_bounds(functional: &dyn Functional) -> &'static str {
    let any: &dyn Any = functional;
    if any.is::<Curvature>() {
        "; it is a vector in the plane across the curve, which has no bound: ask for the signed-curvature, which takes \
         bounds and says in which plane"
    } else if functional.is_vector() {
        "; to bound one of them, narrow it to an axis"
    } else {
        ""
    }
}

/// A constraint with its target; what is found of it where the shapes are goes behind what is `known` of others.
pub(crate) fn bind(
    shapes: &Shapes<'_>,
    mut constraint: Constraint,
    id: ConstraintId,
    known: &mut Known,
) -> Result<BoundConstraint, EditError> {
    if let Some(bound) = constraint.functional.bind(shapes)? {
        constraint.functional = bound;
    }
    // Names are for messages: most constraints are bound without one.
    let wrong =
        |what: &str| -> EditError { Error::Invalid(format!("{}{what}", constraint.describe())).into() };
    if constraint.axis.is_some() && !constraint.functional.is_vector() {
        return Err(wrong(" cannot be narrowed to an axis: it is not a vector"));
    }
    let wish = match &constraint.wanted {
        Wanted::Keep | Wanted::Hold => None,
        Wanted::To(_) => Some("to"),
        Wanted::By(_) => Some("by"),
        Wanted::Scale(_) => Some("scale"),
        Wanted::AtLeast(_) => Some("at_least"),
        Wanted::AtMost(_) => Some("at_most"),
    };
    if let (Some(wish), Some(instead)) = (wish, constraint.functional.only_holds()) {
        return Err(wrong(&format!(
            " holds or does not hold, so that \"{wish}\" says nothing: leave it out; {instead}"
        )));
    }
    if let Some(why) = constraint.functional.powerless(shapes) {
        return Err(wrong(&format!(": {why}")));
    }
    let count = equations_of(constraint.functional.as_ref())?;
    if count == 0 && constraint.functional.linearity() != Linearity::Linear {
        return Err(wrong(" has no equations, so that it asks nothing; leave it out"));
    }
    let present = known.ask(constraint.functional.as_ref(), shapes, count)?;
    if let Some(bad) = present.iter().find(|v| !v.is_finite()) {
        return Err(wrong(&format!(
            ": its value is {bad}; the numbers of the shape, or of what is asked, are too large to compute with"
        )));
    }
    let check = |value: &Value| -> Result<Numbers, EditError> {
        if let Some(bad) = value.0.iter().find(|v| !v.is_finite()) {
            return Err(wrong(&format!(": {bad} is not a finite number")));
        }
        match (value.0.len(), constraint.axis) {
            (found, _) if found == count => Ok(value.0.as_slice().into()),
            // One number for the one axis that is asked.
            (1, Some(_)) => Ok(Numbers::from_elem(value.0[0], count)),
            (found, _) if constraint.functional.is_condition() => Err(wrong(&format!(
                " is a condition that holds or not, and {} given: keep it, or say what it should be like in its own \
                 fields (\"direction\" for a tangent)",
                counted(found, "number[|s] [was|were]")
            ))),
            (found, _) => {
                let short = matches!(constraint.wanted, Wanted::To(_) | Wanted::By(_));
                let whole =
                    constraint.functional.complete(&value.0).filter(|all| short && all.len() == count);
                whole.map(Numbers::from_vec).ok_or_else(|| {
                    let wish = wish.unwrap_or_default();
                    let instead = match constraint.sense() {
                        Sense::Equal => "",
                        _ => instead_of_bounds(constraint.functional.as_ref()),
                    };
                    let (found, needed) = (counted(found, "number[|s]"), counted(count, "[is|are] needed"));
                    wrong(&format!(": \"{wish}\" gives {found} where {needed}{instead}"))
                })
            }
        }
    };
    let mut target = Numbers::from_slice(present);
    match &constraint.wanted {
        Wanted::Keep => {}
        Wanted::Hold => target.fill(0.0),
        Wanted::To(value) | Wanted::AtLeast(value) | Wanted::AtMost(value) => target = check(value)?,
        Wanted::By(value) => target.iter_mut().zip(check(value)?).for_each(|(t, by)| *t += by),
        Wanted::Scale(factor) if factor.is_finite() => target.iter_mut().for_each(|t| *t *= factor),
        Wanted::Scale(factor) => {
            return Err(wrong(&format!(": {factor} is not a factor; give a finite number")));
        }
    }
    if let Some(bad) = target.iter().find(|t| !t.is_finite()) {
        return Err(wrong(&format!(": its value would be {bad}; ask for less")));
    }
    constraint.functional.check_target(present, &target)?;
    known.check(constraint.functional.as_ref())?;
    Ok(BoundConstraint { id, constraint, target })
}

/// Wanted minus present values into `rhs`, the sizes of the numbers they come from into `size`; and for each
/// constraint its largest error and the size to measure it by.
pub(crate) fn right_hand_side(
    shapes: &Shapes<'_>,
    bound: &[BoundConstraint],
    assembly: &Assembly,
    rhs: &mut Numbers,
    size: &mut Numbers,
) -> Result<Vec<(f64, f64)>> {
    let mut errors = Vec::with_capacity(bound.len());
    difference(shapes, bound, assembly, &[], (rhs, size), |error| errors.push(error))?;
    Ok(errors)
}

/// The same, `each` being told of every constraint in turn, where the present values of the first ones are `known`.
pub(crate) fn difference(
    shapes: &Shapes<'_>,
    bound: &[BoundConstraint],
    assembly: &Assembly,
    mut known: &[f64],
    (rhs, size): (&mut Numbers, &mut Numbers),
    mut each: impl FnMut((f64, f64)),
) -> Result<()> {
    let (rows, sides) = (assembly.system.rows().len(), assembly.system.sides());
    for numbers in [&mut *rhs, &mut *size] {
        numbers.clear();
        numbers.resize(rows * sides, 0.0);
    }
    let mut own = Numbers::new();
    for (k, b) in bound.iter().enumerate() {
        let value = match known.split_at_checked(b.target.len()) {
            Some((value, rest)) if !value.is_empty() => {
                known = rest;
                value
            }
            _ => {
                known = &[];
                own.clear();
                own.resize(b.constraint.functional.equations(), 0.0);
                value_of(b.constraint.functional.as_ref(), shapes, &mut own)?;
                &own
            }
        };
        let mut worst = (0.0_f64, 0.0_f64);
        for slot in assembly.slots(k) {
            let (at, equation) = (assembly.entry(slot), slot.equation as usize);
            rhs[at] = b.target[equation] - value[equation];
            size[at] = slot.magnitude + b.target[equation].abs() + value[equation].abs();
            worst = (worst.0.max(error_of(b.constraint.sense(), rhs[at])), worst.1.max(size[at]));
        }
        each(worst);
    }
    Ok(())
}
