//! Reading: bytes to a scene, or one error that says where and what.

mod definition;
mod geometry;
mod lists;
mod material;
mod mesh;
mod object;
mod shape;
mod table;
mod trail;
mod trimmed;

use loftsman_kernel::plugin::{FormatError, Place, ReadOptions};
use loftsman_kernel::scene::Scene;
use serde::de::DeserializeSeed;
use serde_json::error::Category;

use object::DocumentTable;
use table::TableSeed;
pub(crate) use table::clip;
use trail::Trail;

/// The scene of a document.
pub(crate) fn document(file: &str, bytes: &[u8], options: &ReadOptions<'_>) -> Result<Scene, FormatError> {
    let text = decode(file, bytes)?;
    let trail = Trail::default();
    let mut scene = Scene::new();
    let mut json = serde_json::Deserializer::from_str(text);
    let table = DocumentTable::new(&mut scene, options);
    let result = TableSeed { trail: &trail, table }.deserialize(&mut json).and_then(|()| json.end());
    match result {
        Ok(()) => Ok(scene),
        Err(error) => Err(explain(file, text, &error, trail)),
    }
}

/// The text of the bytes: UTF-8, with or without a byte order mark.
fn decode<'b>(file: &str, bytes: &'b [u8]) -> Result<&'b str, FormatError> {
    if bytes.starts_with(&[0xFF, 0xFE]) || bytes.starts_with(&[0xFE, 0xFF]) {
        let problem = "the text is UTF-16, a document is UTF-8: save it again as UTF-8";
        return Err(FormatError::new(file, Place::Byte(0), problem));
    }
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    if bytes.trim_ascii().is_empty() {
        let problem = "the file is empty: a document starts with { \"loftsman\": 1, … }";
        return Err(FormatError::new(file, Place::File, problem));
    }
    std::str::from_utf8(bytes).map_err(|error| {
        let good = &bytes[..error.valid_up_to()];
        let line = 1 + good.iter().filter(|&&b| b == b'\n').count();
        let problem = format!(
            "byte {} is not UTF-8: this is no text, or one in another encoding; save it as UTF-8",
            good.len()
        );
        FormatError::new(file, Place::Line(line), problem)
    })
}

/// The error of the parser in our words, with path, line and object.
fn explain(file: &str, text: &str, error: &serde_json::Error, trail: Trail) -> FormatError {
    let (path, object, problem) = trail.into_parts();
    let (line, column) = (error.line(), error.column());
    let (text, at_end) = match problem {
        Some(problem) => (problem.text, problem.at_end),
        None => (parser_problem(text, error), false),
    };
    let place = if path.is_empty() { Place::Line(line.max(1)) } else { Place::Path(path) };
    let text = match (&place, at_end) {
        (Place::Line(_), _) => format!("{text} (column {column})"),
        (_, false) => format!("{text} (line {line}, column {column})"),
        // The reader stands behind the table, not at the entry that the path names.
        (_, true) => format!("{text} (before line {line}, column {column})"),
    };
    let error = FormatError::new(file, place, text);
    match object {
        Some(name) => error.of(name),
        None => error,
    }
}

/// What the JSON parser found, and what to do.
fn parser_problem(text: &str, error: &serde_json::Error) -> String {
    let message = error.to_string();
    // The position goes into the place.
    let message = message.rsplit_once(" at line ").map_or(message.as_str(), |(message, _)| message);
    if error.classify() == Category::Eof {
        return format!("the file ends in the middle ({message}): it was cut off; get it again as a whole");
    }
    if let Some(word) = not_a_number(text, error.line(), error.column()) {
        return format!(
            "{word} is not a number that JSON can hold: every number must be finite; write a finite one"
        );
    }
    match message {
        "number out of range" => {
            "the number is too large: every number must be finite, at most 1.8e308".to_owned()
        }
        "recursion limit exceeded" => {
            "the brackets are nested too deeply for a document; close those before".to_owned()
        }
        message if error.classify() == Category::Syntax => {
            format!("this is not JSON: {}", clip_message(message))
        }
        message => clip_message(message),
    }
}

/// `NaN`, `Infinity` and the like where a value should be.
fn not_a_number(text: &str, line: usize, column: usize) -> Option<&str> {
    let line = text.split('\n').nth(line.checked_sub(1)?)?;
    // The parser may stand on the word's first letter or behind it.
    let bytes = line.as_bytes();
    let word = |b: &u8| b.is_ascii_alphanumeric() || *b == b'-' || *b == b'+';
    let at = column.min(bytes.len());
    let start = at - bytes[..at].iter().rev().take_while(|b| word(b)).count();
    let end = at + bytes[at..].iter().take_while(|b| word(b)).count();
    let found = line.get(start..end)?;
    let plain = found.trim_start_matches(['-', '+']).to_ascii_lowercase();
    matches!(plain.as_str(), "nan" | "inf" | "infinity").then_some(found)
}

/// serde quotes the text it found in full, which may be a megabyte.
fn clip_message(message: &str) -> String {
    if message.chars().count() <= 200 {
        return message.to_owned();
    }
    match message.rsplit_once(", expected ") {
        Some((start, expected)) => format!("{}, expected {}", clip(start), expected),
        None => clip(message),
    }
}
