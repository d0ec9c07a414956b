//! Constraints as recipes write them: a kind with its fields, one wish, perhaps an axis.

use std::sync::Arc;

use super::{Field, ParameterError, Parameters, Registry};
use crate::edit::{Axis, Constraint, Value, Wanted};
use crate::functional::{Functional, ShapeNames};

/// The words that say what is wanted. A kind may have a field of its own by such a name (`orthogonal` … `to`); then
/// the word is the kind's.
pub(crate) const WISHES: [&str; 6] = ["to", "by", "scale", "keep", "at_least", "at_most"];
/// The fields that every constraint has, beside what is wanted: no kind may have one of its own by such a name.
pub(crate) const EVERYWHERE: [&str; 2] = ["kind", "axis"];

/// The functional of a table `{ kind = …, its own fields }` and nothing else: a handle.
///
/// # Errors
/// When the kind or a field is unknown, missing or wrong.
pub fn functional_from(
    registry: &Registry,
    parameters: &Parameters,
    names: &mut dyn ShapeNames,
) -> Result<Arc<dyn Functional>, ParameterError> {
    let kind = parameters.text("kind")?;
    registry.build_functional(kind, &parameters.without(&["kind"]), names)
}

/// The constraint of a table `{ kind = …, its own fields, one of to/by/scale/keep/at_least/at_most, axis }`.
///
/// # Errors
/// When a field is unknown, missing or wrong, when several wishes are there or none (and the kind is not a condition,
/// which needs none; `keep = true` says the same of it: it holds).
pub fn constraint_from(
    registry: &Registry,
    parameters: &Parameters,
    names: &mut dyn ShapeNames,
) -> Result<Constraint, ParameterError> {
    let kind = parameters.text("kind")?.to_owned();
    let declaration = registry.find_functional(&kind, parameters.path())?;
    let own = |name: &str| declaration.fields.iter().any(|f| f.name == name);
    if let Some(taken) = EVERYWHERE.into_iter().find(|name| own(name)) {
        return Err(parameters.error(
            "",
            format!("the kind \"{kind}\" declares a field \"{taken}\", which every constraint has: its plug-in must rename it"),
        ));
    }
    let given: Vec<&str> = WISHES.into_iter().filter(|w| parameters.has(w) && !own(w)).collect();
    let known: Vec<Field> = declaration
        .fields
        .iter()
        .copied()
        .chain(EVERYWHERE.into_iter().chain(WISHES).map(|name| Field::optional(name, "", "", "")))
        .collect();
    parameters.check(&known)?;
    let mut rest = EVERYWHERE.to_vec();
    rest.extend(WISHES.into_iter().filter(|w| !own(w)));
    let functional = registry.build_functional(&kind, &parameters.without(&rest), names)?;
    let wanted = match given[..] {
        [] if functional.is_condition() => Wanted::Hold,
        [] => {
            return Err(parameters.error(
                "",
                format!(
                    "\"{kind}\" says nothing: give one of to, by, scale, keep = true, at_least or at_most"
                ),
            ));
        }
        [wish] => match wanted(parameters, wish)? {
            // To keep a condition is to have it hold: a tangent along a direction, a normal along another.
            Wanted::Keep if functional.is_condition() => Wanted::Hold,
            wanted => wanted,
        },
        _ => {
            let all = given.iter().map(|w| format!("\"{w}\"")).collect::<Vec<_>>().join(" and ");
            return Err(parameters.error("", format!("{all} together say too much: give one of them")));
        }
    };
    let constraint = Constraint::new(functional, wanted);
    if !parameters.has("axis") {
        return Ok(constraint);
    }
    let axis = parameters.choice("axis", &[("x", Axis::X), ("y", Axis::Y), ("z", Axis::Z)])?;
    if !constraint.functional().is_vector() {
        return Err(parameters.error("axis", format!("\"{kind}\" is not a vector and has no axes")));
    }
    Ok(constraint.axis(axis))
}

fn wanted(parameters: &Parameters, wish: &str) -> Result<Wanted, ParameterError> {
    let value = || -> Result<Value, ParameterError> {
        match parameters.value(wish) {
            Some(v) if v.is_array() => parameters.numbers(wish).map(Value),
            _ => parameters.number(wish).map(Value::from),
        }
    };
    match wish {
        "to" => value().map(Wanted::To),
        "by" => value().map(Wanted::By),
        "scale" => parameters.number(wish).map(Wanted::Scale),
        "at_least" => value().map(Wanted::AtLeast),
        "at_most" => value().map(Wanted::AtMost),
        _ if parameters.flag("keep")? => Ok(Wanted::Keep),
        _ => Err(parameters.error("keep", "only true makes sense; leave the constraint out to let it go")),
    }
}
