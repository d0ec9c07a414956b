//! Steps that edit an object of a definition, as an instance shows it: it is put among the objects of the scene for the step,
//! and back afterwards. One place for all operations, whoever wrote them.

use loftsman_kernel::plugin::{ParameterError, Parameters, StepReport};
use loftsman_kernel::scene::{Scene, Within};
use serde_json::Value;

/// The field of a step that makes an object of a definition unique before it is edited.
pub(super) const UNIQUE: &str = "unique";

/// The objects of definitions that a step names.
pub(super) struct Lifted(Vec<Within>);

impl Lifted {
    /// Puts the objects of definitions that the fields `object` and `objects` of a step name, at any depth, into the scene,
    /// each made unique before where that is asked for.
    ///
    /// # Errors
    /// When two names are of one object, one is of no shape, or there is nothing to make unique.
    pub(super) fn lift(
        scene: &mut Scene,
        fields: &Parameters,
        unique: bool,
        report: &mut Vec<String>,
    ) -> Result<Self, ParameterError> {
        let mut names = Vec::new();
        for name in fields.names() {
            collect(name, fields.value(name), &mut names);
        }
        // What is no name of anything is for the operation to say.
        names.retain(|name| scene.get(name).is_none() && scene.within(name).is_some());
        if unique && names.is_empty() {
            let problem = "the step names no object of a definition by its path, \"instance/object\": every other object is \
                           unique already; leave this out";
            return Err(fields.error(UNIQUE, problem));
        }
        let mut lifted: Vec<Within> = Vec::new();
        for name in &names {
            let fail = |e: loftsman_kernel::Error| fields.error("", e.to_string());
            let Some(mut within) = scene.within(name) else { continue };
            if unique {
                within = scene.make_unique(&within).map_err(fail)?;
                report.push(format!(
                    "\"{name}\" is edited here alone: it is of the definition \"{}\"",
                    within.definition
                ));
            } else {
                let times = scene.times_shown().map_err(fail)?;
                let times = times.get(within.definition.as_str()).copied().unwrap_or_default();
                if times > 1 {
                    report.push(format!(
                        "\"{name}\" is of the definition \"{}\", which is shown {times} times: all of them are edited \
                         (unique = true edits this one)",
                        within.definition
                    ));
                }
            }
            let same = |w: &&Within| (&w.definition, &w.object) == (&within.definition, &within.object);
            if let Some(other) = lifted.iter().find(same) {
                return Err(fields.error(
                    "",
                    format!(
                        "\"{}\" and \"{name}\" are one object of the definition \"{}\": give unique = true, which makes two \
                         of them, or name one",
                        other.path, within.definition
                    ),
                ));
            }
            scene.lift(&within).map_err(fail)?;
            lifted.push(within);
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
        notes: Vec<String>,
    ) -> Result<(), ParameterError> {
        for within in &self.0 {
            scene.put_back(within).map_err(|e| fields.error("", e.to_string()))?;
        }
        report.notes.extend(notes);
        Ok(())
    }
}

/// The names that the fields `object` and `objects` of a table hold, and of the tables in it.
fn collect(field: &str, value: Option<&Value>, names: &mut Vec<String>) {
    match value {
        Some(Value::String(name)) if matches!(field, "object" | "objects") && !names.contains(name) => {
            names.push(name.clone());
        }
        Some(Value::Array(list)) => list.iter().for_each(|value| collect(field, Some(value), names)),
        Some(Value::Object(table)) => {
            table.iter().for_each(|(field, value)| collect(field, Some(value), names));
        }
        _ => {}
    }
}
