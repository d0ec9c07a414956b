//! Steps that edit an object of a definition, as an instance shows it: it is put among the objects of the scene for the step,
//! and back afterwards. One place for all operations, whoever wrote them.

use loftsman_kernel::plugin::{ParameterError, Parameters, StepReport};
use loftsman_kernel::scene::{Geometry, Object, Scene, Within};
use serde_json::Value;

/// The field of a step that makes an object of a definition unique before it is edited.
pub(super) const UNIQUE: &str = "unique";

/// The objects of definitions that a step names.
pub(super) struct Lifted(Vec<One>);

/// An object of a definition that is among those of the scene for a step.
struct One {
    within: Within,
    /// What it was, and what it moved by.
    before: Object,
    /// What to say where the step changes it, and what where it does not.
    changed: Option<String>,
    unchanged: Option<String>,
}

impl Lifted {
    /// Puts the objects of definitions that a step names, at any depth, into the scene, each made unique before where that is asked for.
    ///
    /// # Errors
    /// When two names are of one object, one is of no shape, or there is nothing to make unique.
    pub(super) fn lift(scene: &mut Scene, fields: &Parameters, unique: bool) -> Result<Self, ParameterError> {
        let mut names = Vec::new();
        for name in fields.names() {
            collect(scene, name, fields.value(name), &mut names);
        }
        if unique && names.is_empty() {
            let problem = "the step names no object of a definition by its path, \"instance/object\": every other object is \
                           unique already; leave this out";
            return Err(fields.error(UNIQUE, problem));
        }
        let mut lifted: Vec<One> = Vec::new();
        for name in &names {
            let fail = |e: loftsman_kernel::Error| fields.error("", e.to_string());
            let Some(mut within) = scene.within(name) else { continue };
            let (changed, unchanged) = if unique {
                let shown = within.definition.clone();
                within = scene.make_unique(&within).map_err(fail)?;
                let own = &within.definition;
                let changed = format!("\"{name}\" is edited here alone: it is of the definition \"{own}\"");
                let unchanged = format!(
                    "\"{name}\" is of a definition of its own, \"{own}\", though the step has not changed it: without unique = true it is that of \"{shown}\""
                );
                (Some(changed), Some(unchanged))
            } else {
                let times = scene.times_shown().map_err(fail)?;
                let times = times.get(within.definition.as_str()).copied().unwrap_or_default();
                let changed = (times > 1).then(|| {
                    format!(
                        "\"{name}\" is of the definition \"{}\", which is shown {times} times: all of them are edited \
                         (unique = true edits this one)",
                        within.definition
                    )
                });
                (changed, None)
            };
            let same = |one: &&One| {
                let other = &one.within;
                (&other.definition, &other.object) == (&within.definition, &within.object)
            };
            if let Some(other) = lifted.iter().find(same) {
                return Err(fields.error(
                    "",
                    format!(
                        "\"{}\" and \"{name}\" are one object of the definition \"{}\": give unique = true, which makes two \
                         of them, or name one",
                        other.within.path, within.definition
                    ),
                ));
            }
            scene.lift(&within).map_err(fail)?;
            let before = scene.object(&within.path).map_err(fail)?.clone();
            lifted.push(One { within, before, changed, unchanged });
        }
        Ok(Self(lifted))
    }

    /// Puts them back.
    ///
    /// # Errors
    /// When the step has taken one out, or renamed it.
    pub(super) fn put_back(
        self,
        scene: &mut Scene,
        fields: &Parameters,
        report: &mut StepReport,
    ) -> Result<(), ParameterError> {
        for One { within, before, changed, unchanged } in self.0 {
            let is_changed = scene.get(&within.path).is_none_or(|now| differ(&before, now));
            scene.put_back(&within).map_err(|e| fields.error("", e.to_string()))?;
            report.notes.extend(if is_changed { changed } else { unchanged });
        }
        Ok(())
    }
}

/// Whether a step has changed an object's shape or its frames. `O(1)` where it has not touched its geometry.
fn differ(before: &Object, now: &Object) -> bool {
    let same = std::sync::Arc::ptr_eq(before.shared_geometry(), now.shared_geometry());
    !(same || before.geometry() == now.geometry()) || before.animation != now.animation
}

/// Fields whose texts name no object that there is.
const OTHERS: [&str; 6] = ["name", "to", "layer", "file", "kind", "label"];

/// The objects of definitions that a field names by their path, whatever it is called, and the fields of the tables in it. What is no name of anything
/// is for the operation to say; what is no shape, too, where it is not said to be the object of the step.
fn collect(scene: &Scene, field: &str, value: Option<&Value>, names: &mut Vec<String>) {
    match value {
        Some(Value::String(name)) if !OTHERS.contains(&field) => {
            let object = matches!(field, "object" | "objects");
            let found = || {
                scene.get(name).is_none() && scene.within(name).is_some_and(|w| object || is_shape(scene, &w))
            };
            if !names.contains(name) && found() {
                names.push(name.clone());
            }
        }
        Some(Value::Array(list)) => list.iter().for_each(|value| collect(scene, field, Some(value), names)),
        Some(Value::Object(table)) => {
            table.iter().for_each(|(field, value)| collect(scene, field, Some(value), names));
        }
        _ => {}
    }
}

/// Whether what a path leads to is a shape, and not a group or another instance.
fn is_shape(scene: &Scene, within: &Within) -> bool {
    let definition = scene.definitions().get(&within.definition);
    let object = definition.and_then(|definition| definition.get(&within.object));
    object.is_some_and(|object| !matches!(object.geometry(), Geometry::Group | Geometry::Instance(_)))
}
