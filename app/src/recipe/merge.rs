//! The operation `merge`: a file's objects join the scene. It lives here since only the app knows files.

use std::path::Path;

use loftsman_kernel::plugin::{
    Context, Declaration, Field, FormatErrorKind, Operation, OperationError, ParameterError, Parameters,
    StepReport,
};
use loftsman_kernel::scene::{Scene, Side};
use serde_json::{Map, Value, json};

use super::inputs::embed_pictures;
use crate::convert::Conversion;
use crate::error::Error;
use crate::file::Input;
use crate::file::input::Content;

/// What a field takes that names files: [relative to the recipe](relative).
const FILES: &str = "file or [file, …]";

/// The operation `merge`: the objects of one or more files join the scene, in its unit and with its axis up
/// ([`Scene::merge`]). In a recipe their names are relative to it, elsewhere to where the program runs.
#[derive(Debug, Clone, Copy, Default)]
pub struct Merge;

impl Operation for Merge {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[
            Field::required("file", FILES, "any readable format; relative to the recipe"),
            Field::optional(
                "unit",
                "unit",
                "what the file says",
                "of the file's numbers, where its format has none (OBJ, points)",
            ),
            Field::optional("read", "{ option = value, … }", "none", "options of the file's format"),
        ];
        Declaration {
            name: "merge",
            help: "add the objects of another file, in the scene's unit and with its axis up; names that are taken get a number, and are reported",
            fields: FIELDS,
        }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        p: &Parameters,
        context: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        p.check(self.declaration().fields)?;
        let files = names(p, "file")?;
        if files.is_empty() {
            return Err(p.error("file", "no file is named: one at least is needed").into());
        }
        let conversion = Conversion::from_parameters(&Parameters::new(
            Value::Object(p.without(&["file"]).into_map()),
            p.path(),
        )?)?;
        let mut merged = scene.clone();
        let mut notes = Vec::new();
        let mut files_told = Vec::with_capacity(files.len());
        for (number, file) in files.iter().enumerate() {
            context.observer.proceed("files", number as u64, files.len() as u64)?;
            let place = if files.len() == 1 { "file".to_owned() } else { format!("file[{number}]") };
            let refused = |error: Error| -> OperationError {
                if error.is_cancelled() {
                    return OperationError::Cancelled;
                }
                let option = matches!(&error, Error::Format(error) if error.kind == FormatErrorKind::Option);
                p.error(if option { "read" } else { &place }, error.to_string()).into()
            };
            let input = Input::open(file).map_err(refused)?;
            let content = conversion.read(&input, context.observer, context.registry).map_err(refused)?;
            let Content { scene: mut other, report, format } = content;
            let count = other.objects().len();
            let objects = if count == 1 { "1 object".to_owned() } else { format!("{count} objects") };
            let name = Path::new(file).file_name().map_or(file.into(), |name| name.to_string_lossy());
            notes.push(format!("{objects} of {name} ({})", format.name));
            for (what, reasons) in [("read otherwise", &report.approximated), ("left out", &report.left_out)]
            {
                for (reason, number) in reasons {
                    notes.push(format!("{number} of {} {what}: {reason}", report.entities));
                }
            }
            notes.extend(report.notes);
            notes.extend(embed_pictures(&mut other, &input, None).map_err(refused)?);
            let told = merged.merge(&other).map_err(|e| p.error(&place, e.to_string()))?;
            notes.extend(told.notes(|side| match side {
                Side::First => "give the recipe a `unit`",
                // The recipe's own is that of its inputs and its numbers.
                Side::Other => "give this step a `unit`",
            }));
            let renamed = told.objects.iter().map(|(old, new)| (old.clone(), json!(new)));
            files_told.push(json!({
                "file": name,
                "format": format.name,
                "objects": count,
                "renamed": renamed.collect::<Map<String, Value>>(),
                "left_out": report.left_out.values().sum::<usize>(),
            }));
        }
        *scene = merged;
        let numbers = [("files".to_owned(), files_told.into())].into_iter().collect();
        Ok(StepReport { op: "merge".into(), notes, numbers, ..StepReport::default() })
    }
}

/// The files that a field names.
fn names(p: &Parameters, field: &str) -> Result<Vec<String>, ParameterError> {
    match p.value(field) {
        Some(Value::Array(list)) => list
            .iter()
            .enumerate()
            .map(|(k, file)| match file {
                Value::String(file) => Ok(file.clone()),
                _ => Err(p.error(&format!("{field}[{k}]"), "a file name is needed here")),
            })
            .collect(),
        _ => Ok(vec![p.text(field)?.to_owned()]),
    }
}

/// The names of files in the fields of a step, as they were written, by the declaration of its operation.
pub(super) fn files<'s>(step: &'s Value, declared: &[Field]) -> Vec<&'s str> {
    let fields = declared.iter().filter(|field| field.takes == FILES);
    let values = fields.filter_map(|field| step.get(field.name));
    values
        .flat_map(|value| match value {
            Value::Array(list) => list.iter().filter_map(Value::as_str).collect(),
            value => value.as_str().into_iter().collect::<Vec<_>>(),
        })
        .collect()
}

/// The fields of a step with each name of a file replaced by where it is.
pub(super) fn relative(
    parameters: Parameters,
    declared: &[Field],
    place: impl Fn(&str) -> String,
) -> Result<Parameters, ParameterError> {
    if !declared.iter().any(|field| field.takes == FILES) {
        return Ok(parameters);
    }
    let path = parameters.path().to_owned();
    let mut map = parameters.into_map();
    for field in declared.iter().filter(|field| field.takes == FILES) {
        let one = |value: &mut Value| {
            if let Value::String(name) = value {
                *name = place(name);
            }
        };
        match map.get_mut(field.name) {
            Some(Value::Array(list)) => list.iter_mut().for_each(one),
            Some(value) => one(value),
            None => {}
        }
    }
    Parameters::new(Value::Object(map), path)
}
