//! Constraints as recipes write them: a kind with its fields, one wish, perhaps an axis.

use std::sync::Arc;

use super::{Field, ParameterError, Parameters, Registry};
use crate::edit::{Axis, Constraint, Value, Wanted};
use crate::functional::{Functional, ShapeNames};

/// The words that say what is wanted. A kind may have a field of its own by such a name (`orthogonal` … `to`); then
/// the word is the kind's.
const WISHES: [&str; 6] = ["to", "by", "scale", "keep", "at_least", "at_most"];

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
/// which needs none).
pub fn constraint_from(
    registry: &Registry,
    parameters: &Parameters,
    names: &mut dyn ShapeNames,
) -> Result<Constraint, ParameterError> {
    let kind = parameters.text("kind")?.to_owned();
    let declaration = registry.find_functional(&kind, parameters.path())?;
    let own = |name: &str| declaration.fields.iter().any(|f| f.name == name);
    let given: Vec<&str> = WISHES.into_iter().filter(|w| parameters.has(w) && !own(w)).collect();
    let known: Vec<Field> = declaration
        .fields
        .iter()
        .copied()
        .chain(["kind", "axis"].into_iter().chain(WISHES).map(|name| Field::optional(name, "", "", "")))
        .collect();
    parameters.check(&known)?;
    let mut rest = vec!["kind", "axis"];
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
        [wish] => wanted(parameters, wish)?,
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
