//! What holds and moves things, as recipes write it.

use loftsman_kernel::functional::ShapeNames;
use loftsman_kernel::plugin::{
    OperationError, ParameterError, Parameters, Registry, SceneShapes, functional_from, nearest,
};
use loftsman_kernel::shape::Location;
use loftsman_kernel::{Point, Vector};

use super::declared::{ALL, FORCE, KINDS, PULL};
use crate::constraint::{
    Force, Hold, Pull, Spot, double_sliding, fixed, holds, knot, sliding, sliding_curvature, sliding_tangent,
    tied,
};
use crate::error::check;
use crate::path::Path;

/// What tables are read by.
pub(super) struct Words<'a> {
    pub(super) registry: &'a Registry,
    /// When all ends; 0 where nothing moves, and rest is looked for at once: paths are at their ends then.
    pub(super) seconds: f64,
}

pub(super) fn constraint(
    table: &Parameters,
    names: &mut SceneShapes<'_>,
    words: &Words<'_>,
) -> Result<Hold, OperationError> {
    let kind = table.text("kind")?.to_owned();
    let (from, until) = times(table)?;
    let found = match KINDS.iter().find(|own| own.name == kind) {
        Some(own) => {
            table.check(own.fields.iter().chain(&ALL))?;
            own_kind(&kind, table, names, words, from, until)?
        }
        None => other_kind(&kind, table, names, words)?,
    };
    let found = match table.has("name") {
        true => found.called(table.text("name")?),
        false => found,
    };
    Ok(found.during(from, until))
}

fn own_kind(
    kind: &str,
    table: &Parameters,
    names: &mut SceneShapes<'_>,
    words: &Words<'_>,
    from: f64,
    until: f64,
) -> Result<Hold, OperationError> {
    let body = body(table, "object", names)?;
    let mut found = match kind {
        "fixed" => fixed(table.location("at")?),
        "sliding" => sliding(table.location("near")?),
        "knot" => knot(table.location("near")?, table.location("at")?),
        "double-sliding" => double_sliding(pair(table, "near")?),
        "tied" => {
            let spot =
                |at: &str, near: &str, body: usize| -> Result<Spot, ParameterError> {
                    match (table.has(at), table.has(near)) {
                        (true, false) => Ok(Spot::at(body, table.location(at)?)),
                        (false, true) => Ok(Spot::near(body, table.location(near)?)),
                        _ => Err(table
                            .error(at, format!("give \"{at}\", or \"{near}\" for a location that slides"))),
                    }
                };
            let other = self::body(table, "other", names)?;
            return Ok(tied(spot("at", "near", body)?, spot("other_at", "other_near", other)?));
        }
        "sliding-tangent" => {
            let (near, direction) = (table.location("near")?, table.vector("direction")?);
            if direction == Vector::zeros() {
                let problem = "the first derivative is to be the zero vector: the curve would stand still there; give a direction, as long as the \
                               derivative is to be";
                return Err(table.error("direction", problem).into());
            }
            match table.has("to") {
                true => sliding(near).tangent(direction),
                false => sliding_tangent(near, direction),
            }
        }
        _ if table.has("to") => sliding(table.location("near")?).curvature(table.vector("curvature")?),
        _ => sliding_curvature(table.location("near")?, table.vector("curvature")?),
    };
    if table.has("to") {
        found = found.to(path(table, from, until, words)?);
    }
    if table.has("axis") {
        found = found.axes(axes(table)?);
    }
    Ok(found.on(body))
}

/// Two locations, in a list.
fn pair(table: &Parameters, name: &str) -> Result<[Location; 2], ParameterError> {
    let list = table.list(name)?;
    if list.len() != 2 {
        let problem =
            "two locations are needed, one for each side: [a, b] on a curve, [[u, v], [u, v]] on a surface";
        return Err(table.error(name, problem));
    }
    let one = |side: usize| {
        let field = format!("{name}[{side}]");
        Parameters::empty(table.path()).with(&field, list[side].clone()).location(&field)
    };
    Ok([one(0)?, one(1)?])
}

/// One coordinate, or a list of some.
fn axes(table: &Parameters) -> Result<[bool; 3], ParameterError> {
    let list = match table.value("axis") {
        Some(value) if value.is_array() => table.list("axis")?.iter().collect(),
        one => Vec::from_iter(one),
    };
    let mut axes = [false; 3];
    for one in &list {
        match one.as_str().and_then(|name| ["x", "y", "z"].iter().position(|axis| *axis == name)) {
            Some(axis) if !axes[axis] => axes[axis] = true,
            Some(_) => return Err(table.error("axis", format!("{one} is listed twice"))),
            None => {
                let problem = format!("{one} is no axis: give \"x\", \"y\" or \"z\", or a list of these");
                return Err(table.error("axis", problem));
            }
        }
    }
    if list.is_empty() {
        return Err(table.error("axis", "the list is empty: name an axis, or leave it out for all"));
    }
    Ok(axes)
}

/// Any kind of constraint that is registered and linear: it keeps its value, or gets one.
fn other_kind(
    kind: &str,
    table: &Parameters,
    names: &mut SceneShapes<'_>,
    words: &Words<'_>,
) -> Result<Hold, OperationError> {
    let Ok(declared) = words.registry.find_functional(kind, table.path()) else {
        let own = KINDS.iter().map(|own| own.name);
        let hint = match nearest(kind, own.clone()) {
            Some(near) => format!("did you mean \"{near}\"?"),
            None => {
                format!("known: {}, and all linear kinds of constraint", own.collect::<Vec<_>>().join(", "))
            }
        };
        return Err(table.error("kind", format!("there is no constraint \"{kind}\"; {hint}")).into());
    };
    // A kind may have a field of its own by the name of one of these: then it is the kind's, as in edits.
    let own = |name: &str| declared.fields.iter().any(|field| field.name == name);
    if table.has("near") && !own("near") {
        let problem = match own("at") {
            true => format!(
                "\"{kind}\" holds at a location that stays: give `at`; what slides are kinds with a field `near` of their own"
            ),
            false => format!(
                "\"{kind}\" is asked of the whole shape, and has no location that could slide: leave `near` out"
            ),
        };
        return Err(table.error("near", problem).into());
    }
    let rest: Vec<&str> =
        ["from", "until", "name", "to", "keep", "axis"].into_iter().filter(|name| !own(name)).collect();
    let functional = functional_from(words.registry, &table.without(&rest), names)?;
    let mut found = holds(functional);
    if table.has("keep") && !own("keep") && !table.flag("keep")? {
        return Err(table
            .error("keep", "only true makes sense; leave the constraint out to let it go")
            .into());
    }
    if table.has("to") && !own("to") {
        let value = match table.value("to") {
            Some(value) if value.is_number() => vec![table.number("to")?],
            _ => table.numbers("to")?,
        };
        found = found.value(value);
    }
    if table.has("axis") {
        found = found.axes(axes(table)?);
    }
    Ok(found)
}

fn body(table: &Parameters, field: &str, names: &mut SceneShapes<'_>) -> Result<usize, ParameterError> {
    if !table.has(field) {
        return Ok(0);
    }
    names.shape(table.text(field)?).map_err(|e| table.error(field, e.to_string()))
}

/// The times between which something holds.
fn times(table: &Parameters) -> Result<(f64, f64), ParameterError> {
    let from = table.number_or("from", 0.0)?;
    let until = if table.has("until") { table.number("until")? } else { f64::INFINITY };
    if from < 0.0 {
        return Err(table.error("from", format!("{from} s is before the start: give 0 or more")));
    }
    if until <= from {
        return Err(table.error("until", format!("{until} s is not after {from} s")));
    }
    Ok((from, until))
}

/// A place, or places from one time to another; `arrive` is when the last is reached.
fn path(table: &Parameters, from: f64, until: f64, words: &Words<'_>) -> Result<Path, OperationError> {
    let until = until.min(words.seconds);
    let several = table.list("to")?.first().is_some_and(|first| !first.is_number());
    let points: Vec<Point> = if several { table.points("to")? } else { vec![table.point("to")?] };
    // What comes after the end never acts, which is told of all of those alike.
    let arrive = if table.has("arrive") { table.number("arrive")? } else { until.max(from) };
    if arrive < from {
        return Err(table.error("arrive", format!("{arrive} s is before {from} s, when it starts")).into());
    }
    if points.is_empty() {
        return Err(table.error("to", "a path needs at least one point").into());
    }
    let arrive = if words.seconds > 0.0 { arrive.max(from) } else { from };
    Ok(Path::new(points, from, arrive)?)
}

pub(super) fn pull(
    table: &Parameters,
    names: &mut SceneShapes<'_>,
    words: &Words<'_>,
) -> Result<Pull, OperationError> {
    table.check(&PULL)?;
    let (from, until) = times(table)?;
    let to = path(table, from, until, words)?;
    let stiffness = table.number("stiffness")?;
    check("the stiffness of a pull", stiffness, false)
        .map_err(|error| table.error("stiffness", error.to_string()))?;
    let pull = crate::constraint::pull(table.location("at")?, to, stiffness);
    Ok(pull.on(body(table, "object", names)?).during(from, until))
}

pub(super) fn force(table: &Parameters, names: &mut SceneShapes<'_>) -> Result<Force, OperationError> {
    table.check(&FORCE)?;
    let (from, until) = times(table)?;
    let value: Vector = table.vector("force")?;
    let force = crate::constraint::force(table.location("at")?, value);
    Ok(force.on(body(table, "object", names)?).during(from, until))
}
