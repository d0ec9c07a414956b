//! Reading: bytes to a scene, or one error that says where and what.

mod brep;
mod definition;
mod geometry;
mod layer;
mod lists;
mod material;
mod mesh;
mod object;
mod shape;
mod table;
mod trail;
mod trimmed;

use loftsman_kernel::plugin::{FormatError, FormatErrorKind, Place, ReadOptions, utf8};
use loftsman_kernel::scene::Scene;
use loftsman_kernel::text::json_problem;
use serde::de::DeserializeSeed;

use object::DocumentTable;
use table::TableSeed;
use trail::{Problem, Trail};

/// The scene of a document.
pub(crate) fn document(bytes: &[u8], options: &ReadOptions<'_>) -> Result<Scene, FormatError> {
    let text = decode(bytes)?;
    let trail = Trail::default();
    let mut scene = Scene::new();
    let mut json = serde_json::Deserializer::from_str(text);
    let table = DocumentTable::new(&mut scene, options);
    let result = TableSeed { trail: &trail, table }.deserialize(&mut json).and_then(|()| json.end());
    match result {
        Ok(()) => Ok(scene),
        Err(error) => Err(explain(text, &error, trail)),
    }
}

/// The text of the bytes: UTF-8, with or without a byte order mark.
fn decode(bytes: &[u8]) -> Result<&str, FormatError> {
    let text = utf8(bytes, 0)?;
    if text.trim().is_empty() {
        return Err(FormatError::whole("the file is empty: a document starts with { \"loftsman\": 1, … }"));
    }
    Ok(text)
}

/// The error of the parser in our words, with path, line and object.
fn explain(text: &str, error: &serde_json::Error, trail: Trail) -> FormatError {
    if let Some(stopped) = trail.stopped() {
        return stopped;
    }
    let (path, object, problem) = trail.into_parts();
    let (line, column) = (error.line(), error.column());
    let Problem { text, at_end, kind } = problem.unwrap_or_else(|| Problem {
        text: json_problem(text, error),
        at_end: false,
        kind: FormatErrorKind::Malformed,
    });
    let place = if path.is_empty() { Place::Line(line.max(1)) } else { Place::Path(path) };
    let text = match (&place, at_end) {
        (Place::Line(_), _) => format!("{text} (column {column})"),
        (_, false) => format!("{text} (line {line}, column {column})"),
        // The reader stands behind the table, not at the entry that the path names.
        (_, true) => format!("{text} (before line {line}, column {column})"),
    };
    let error = FormatError::new(place, text).as_kind(kind);
    match object {
        Some(name) => error.of(name),
        None => error,
    }
}
