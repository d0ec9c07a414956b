//! Recipes: an input, steps, outputs; written in TOML or JSON with the same fields.
//!
//! ```toml
//! input  = "section.obj"                     # any readable format; relative to the recipe
//! output = ["section.glb", "section.svg"]    # any writable format, or a picture of before and after
//!
//! [[step]]
//! op = "edit"
//! object = "section"
//! constraints = [{ kind = "position", at = 0.25, by = [0.0, 0.2, 0.0] }]
//! ```

mod aftermath;
mod changes;
mod closest;
mod deviation;
pub(crate) mod elsewhere;
mod failed;
mod inputs;
mod merge;
mod parse;
mod place;
mod report;
mod run;
mod within;

use std::path::{Component, Path, PathBuf};

use loftsman_kernel::plugin::{Field, Parameters, Registry};
use serde_json::Value;

pub use crate::recipe_error::RecipeError;
pub use merge::Merge;
pub use report::{InputReport, OutputReport, RunReport};
pub(crate) use run::with_points;
pub use run::{Applied, Runner};

use crate::error::{Error, Result};
use crate::file::Input;
use crate::picture::Look;
use loftsman_kernel::plugin::Source;

/// What every constraint takes beside its kind's own fields.
pub const WISHES: &[Field] = &[
    Field::required("kind", "name", "what is asked; `loftsman plugins constraints` lists the kinds"),
    Field::optional(
        "to",
        "number, or a list of as many as the kind has",
        "one wish is needed",
        "this value: [x, y, z] for a position or derivative of any shape; a number for a length (of curves), an area (in closed planar curves), a volume (in closed surfaces and solids)",
    ),
    Field::optional(
        "by",
        "number, or a list of as many as the kind has",
        "one wish is needed",
        "this change of its value, on any shape",
    ),
    Field::optional("scale", "number", "one wish is needed", "so many times its value, on any shape"),
    Field::optional("keep", "true", "one wish is needed", "its value as it is, on any shape"),
    Field::optional(
        "at_least",
        "number, or a list of as many as the kind has",
        "one wish is needed",
        "no less than this, on any shape, where the solver takes bounds",
    ),
    Field::optional(
        "at_most",
        "number, or a list of as many as the kind has",
        "one wish is needed",
        "no more than this, on any shape",
    ),
    Field::optional(
        "axis",
        "\"x\" | \"y\" | \"z\"",
        "all",
        "only this coordinate, of kinds whose value is a vector: position and derivative (of any shape), vertex (of any control net), centroid (of what is closed)",
    ),
];

/// The fields of a recipe, beside its steps' own.
pub const FIELDS: &[Field] = &[
    Field::optional(
        "input",
        "file or [file, …]",
        "an empty scene",
        "any readable format; relative to the recipe; several become one scene, in the unit and with the up axis of the first",
    ),
    Field::optional("output", "file or [file, …]", "[]", "any writable format, .svg and .png for pictures"),
    Field::optional(
        "step",
        "[step, …]",
        "[]",
        "what to do, in this order; `op` names the operation, and `unique = true` edits one instance only",
    ),
    Field::optional(
        "create_folders",
        "true | false",
        "false",
        "make the folders of the outputs where missing",
    ),
    Field::optional(
        "unit",
        "unit",
        "what the files say",
        "of the input's numbers where its format has none (OBJ, points), else of the outputs'",
    ),
    Field::optional("up", "\"x\" | \"y\" | \"z\" | \"keep\"", "the format's", "the up axis of the outputs"),
    Field::optional("tolerance", "length or \"percent%\"", "\"0.1%\"", "of tessellated splines"),
    Field::optional(
        "read",
        "{ option = value, … }",
        "none",
        "options of the input's format, of several inputs of those in the first one's",
    ),
    Field::optional("write", "{ format = { option = value, … }, … }", "none", "options of output formats"),
    Field::optional(
        "picture",
        "{ title, view, panel, combs, … }",
        "before and after",
        "how .svg and .png outputs look: `loftsman plugins picture`",
    ),
];

/// A recipe: what to read, what to do, what to write.
#[derive(Debug, Clone)]
pub struct Recipe {
    /// The file it came from, as messages name it.
    name: String,
    /// The folder that its paths are relative to.
    folder: PathBuf,
    text: parse::Text,
    /// The files to read, as they were written; an empty scene where there is none, one scene of several.
    pub inputs: Vec<String>,
    /// The files to write, as they were written.
    pub outputs: Vec<String>,
    /// Whether missing folders of outputs are made.
    pub create_folders: bool,
    /// Everything that is asked of reading and writing.
    pub conversion: crate::convert::Conversion,
    /// How pictures among the outputs look.
    pub look: Look,
    /// The steps' tables, each with its `op`.
    pub steps: Vec<Value>,
}

impl Recipe {
    /// Reads a recipe; `-` is the standard input.
    ///
    /// # Errors
    /// When it cannot be read or is malformed; the error has line, column and path.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let input = Input::open(path)?;
        let folder = path.parent().unwrap_or_else(|| Path::new(""));
        Self::parse(Source::name(&input), input.bytes(), folder)
    }

    /// The same; a file that is no recipe but of a format that a registry reads is told so.
    ///
    /// # Errors
    /// As for [`read`](Self::read).
    pub fn read_beside(path: impl AsRef<Path>, registry: &Registry) -> Result<Self> {
        let path = path.as_ref();
        let input = Input::open(path)?;
        let (name, folder) = (Source::name(&input), path.parent().unwrap_or_else(|| Path::new("")));
        Self::parse(name, input.bytes(), folder).map_err(|error| {
            let other = Self::other(name, input.bytes(), registry);
            other.map_or(error, |problem| RecipeError::at(name, "", problem).into())
        })
    }

    /// What to say of a file that is no recipe but of one of the formats that are read.
    fn other(name: &str, bytes: &[u8], registry: &Registry) -> Option<String> {
        let table = parse::Text::new(name, bytes).and_then(|text| text.table()).ok();
        let fields = table.as_ref().and_then(Value::as_object);
        if fields.is_some_and(|fields| FIELDS.iter().any(|field| fields.contains_key(field.name))) {
            return None;
        }
        let format = registry.format_of(name).filter(|format| format.declaration().reads)?;
        Some(format!(
            "this is no recipe but a file of the format {}: a recipe, in TOML or JSON, names it as its `input`; `loftsman info {name}` says what is in it",
            format.declaration().name
        ))
    }

    /// The recipe of some text: JSON where the name ends so or the text starts with a brace, else TOML. Its paths
    /// are relative to `folder`.
    ///
    /// # Errors
    /// When it is malformed; the error has line, column and path.
    pub fn parse(name: &str, bytes: &[u8], folder: impl AsRef<Path>) -> Result<Self> {
        let text = parse::Text::new(name, bytes)?;
        let table = text.table()?;
        let recipe = Self::from_table(name, folder.as_ref(), &text, table)
            .map_err(|e| text.locate(RecipeError::at(name, e.path, e.problem)))?;
        Ok(recipe)
    }

    fn from_table(
        name: &str,
        folder: &Path,
        text: &parse::Text,
        table: Value,
    ) -> std::result::Result<Self, loftsman_kernel::plugin::ParameterError> {
        let fields = Parameters::new(table, "")?;
        if fields.has("loftsman") && !fields.has("step") {
            return Err(fields.error(
                "",
                "this is a document, not a recipe: name it as a recipe's input, or look at it with `loftsman info` and `loftsman plot`",
            ));
        }
        fields.check(FIELDS)?;
        let (inputs, outputs) = (files(&fields, "input")?, files(&fields, "output")?);
        let mut steps = Vec::new();
        if fields.value("step").is_some_and(Value::is_object) {
            return Err(
                fields.error("step", "a table where a list is needed: write [[step]], with two brackets")
            );
        }
        for step in fields.tables("step")? {
            step.text("op")?;
            steps.push(step.names().filter_map(|n| Some((n.to_owned(), step.value(n)?.clone()))).collect());
        }
        Ok(Self {
            name: name.to_owned(),
            folder: folder.to_path_buf(),
            text: text.clone(),
            inputs,
            outputs,
            create_folders: fields.flag("create_folders")?,
            conversion: crate::convert::Conversion::from_parameters(&fields)?,
            look: if fields.has("picture") {
                Look::from_parameters(&fields.table("picture")?)?
            } else {
                Look::default()
            },
            steps,
        })
    }

    /// The file it came from, as messages name it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Where a file that it names is: relative paths are relative to the recipe's folder. `a/b/../c` becomes `a/c` where
    /// that is the same place (no link is in between), for shorter messages.
    pub fn resolve(&self, file: &str) -> PathBuf {
        let long = self.folder.join(file);
        let mut short = PathBuf::new();
        for part in long.components() {
            let up = part == Component::ParentDir
                && matches!(short.components().next_back(), Some(Component::Normal(_)));
            if up && !short.is_symlink() {
                short.pop();
            } else if part != Component::CurDir {
                short.push(part);
            }
        }
        // A folder by itself has a name, too.
        if short.as_os_str().is_empty() { Component::CurDir.as_os_str().into() } else { short }
    }

    fn error(&self, path: impl Into<String>, problem: impl Into<String>) -> Error {
        self.text.locate(RecipeError::at(&self.name, path, problem)).into()
    }
}

/// The files that a field names: one, or a list.
fn files(
    fields: &Parameters,
    name: &str,
) -> std::result::Result<Vec<String>, loftsman_kernel::plugin::ParameterError> {
    match fields.value(name) {
        None => Ok(Vec::new()),
        Some(Value::Array(list)) => list
            .iter()
            .enumerate()
            .map(|(i, file)| match file {
                Value::String(file) => Ok(file.clone()),
                _ => Err(fields.error(&format!("{name}[{i}]"), "a file name is needed here")),
            })
            .collect(),
        Some(_) => Ok(vec![fields.text(name)?.to_owned()]),
    }
}
