//! What all parts of the reader share: the document, its bytes, and the budget.

use std::cell::Cell;
use std::fmt::Display;

use loftsman_kernel::plugin::{FormatError, FormatErrorKind, Place};
use loftsman_kernel::text::{clip_to, json_problem};
use serde::Deserialize;

use super::buffers::Buffers;
use super::schema::{Raw, Root};

/// A file with its parsed document.
pub(super) struct File<'a> {
    pub(super) root: Root<'a>,
    pub(super) buffers: Buffers<'a>,
    pub(super) budget: Budget,
}

impl File<'_> {
    /// Whether it is as our writer wrote it: other programs that pass on what we noted put their own name there.
    pub(super) fn is_ours(&self) -> bool {
        let generator = self.root.asset.as_ref().and_then(|asset| asset.generator);
        generator.is_some_and(|name| name.get().starts_with("\"Loftsman "))
    }
}

/// How much memory a scene may take: a multiple of what the file brings, so that a few bytes that ask for billions
/// of vertices, or thousands of nodes that each ask for all of them, are refused before they are allocated.
pub(super) struct Budget {
    all: u64,
    left: Cell<u64>,
}

impl Budget {
    /// How many bytes of scene one byte of file may become. The largest honest factor of a single mesh is about 5
    /// (16-bit positions become doubles); the rest is for meshes that several nodes show, each bent in its own way.
    const FACTOR: u64 = 64;
    /// What any file may take.
    const LEAST: u64 = 64 << 20;

    /// The budget of a file of so many bytes, buffers included.
    pub(super) fn of(bytes: u64) -> Self {
        let all = bytes.saturating_mul(Self::FACTOR).max(Self::LEAST);
        Self { all, left: Cell::new(all) }
    }
}

impl File<'_> {
    /// An error at a path of the document.
    pub(super) fn fail(&self, path: impl Display, problem: impl Into<String>) -> FormatError {
        FormatError::new(Place::Path(path.to_string()), problem)
    }

    /// Takes memory for `count` things of `size` bytes from the budget.
    pub(super) fn take(&self, path: impl Display, count: usize, size: usize) -> Result<(), FormatError> {
        let Budget { all, left } = &self.budget;
        let wanted = (count as u64).saturating_mul(size as u64);
        let Some(rest) = left.get().checked_sub(wanted) else {
            let problem = format!(
                "{count} elements need {} MB more, beyond {} times what the file has itself ({} MB in all): \
                 the counts are wrong, or too many nodes bend the same mesh; split the file",
                wanted >> 20,
                Budget::FACTOR,
                all >> 20
            );
            return Err(self.fail(path, problem).as_kind(FormatErrorKind::Limit));
        };
        left.set(rest);
        Ok(())
    }

    /// The entry `index` of a list that is kept as text.
    pub(super) fn entry<'a, T: Deserialize<'a>>(
        &self,
        list: &str,
        entries: &[Raw<'a>],
        index: usize,
    ) -> Result<T, FormatError> {
        let Some(entry) = entries.get(index) else { return Err(self.missing(list, index, entries.len())) };
        parse(&format!("{list}[{index}]"), entry.get())
    }

    /// The error for an index beyond the end of a list.
    pub(super) fn missing(&self, list: &str, index: usize, count: usize) -> FormatError {
        let problem = match count {
            0 => format!("it is referred to, but the file has no {list}"),
            _ => format!("it is referred to, but the last of the {list} is {}", count - 1),
        };
        self.fail(format!("{list}[{index}]"), problem)
    }
}

/// Parses JSON; an error has the path of the spot, below `above` where that is not empty.
pub(super) fn parse<'a, T: Deserialize<'a>>(above: &str, text: &'a str) -> Result<T, FormatError> {
    let mut json = serde_json::Deserializer::from_str(text);
    let value = serde_path_to_error::deserialize(&mut json);
    let error = match value {
        Ok(value) => match json.end() {
            Ok(()) => return Ok(value),
            Err(error) => (String::new(), error),
        },
        Err(error) => (error.path().to_string(), error.into_inner()),
    };
    let (below, error) = error;
    // A path ends with "?" where the parser did not come to know where it was.
    let below = below.trim_end_matches('?').trim_end_matches('.');
    let dot = if above.is_empty() || below.is_empty() || below.starts_with('[') { "" } else { "." };
    let problem = plain(json_problem(text, &error));
    let (problem, place) = if above.is_empty() {
        let at = format!("{problem} (line {}, column {})", error.line(), error.column());
        (at, if below.is_empty() { Place::Line(error.line().max(1)) } else { Place::Path(below.to_owned()) })
    } else {
        (problem, Place::Path(format!("{above}{dot}{below}")))
    };
    Err(FormatError::new(place, problem))
}

/// What the parser says of a value, in words of the format and not of the program that reads it.
fn plain(problem: String) -> String {
    if let Some(field) = problem.strip_prefix("missing field `").and_then(|rest| rest.strip_suffix('`')) {
        return format!("the field \"{field}\" is missing, which is needed here");
    }
    let kinds = ["invalid type: ", "invalid value: "];
    let rest = kinds.into_iter().find_map(|kind| problem.strip_prefix(kind));
    let Some((found, expected)) = rest.and_then(|rest| rest.rsplit_once(", expected ")) else {
        return problem;
    };
    let needed = match expected {
        "a sequence" => "a list".to_owned(),
        "a string" => "a text".to_owned(),
        "f64" | "f32" => "a number".to_owned(),
        "u8" | "u16" | "u32" | "u64" | "usize" => "a whole number from 0".to_owned(),
        "a map" => "a table { … }".to_owned(),
        text if text.starts_with("struct ") => "a table { … }".to_owned(),
        other => other.to_owned(),
    };
    format!("{needed} is needed here, and this is {}", self::found(found))
}

/// A value as the parser tells it, in words of the format.
fn found(value: &str) -> String {
    let quoted = |kind: &str| value.strip_prefix(kind).map(|rest| rest.trim_matches('`'));
    if let Some(number) = quoted("integer ").or_else(|| quoted("floating point ")) {
        return format!("the number {number}");
    }
    if let Some(word) = quoted("boolean ") {
        return word.to_owned();
    }
    match value {
        "map" => "a table { … }".to_owned(),
        "sequence" => "a list".to_owned(),
        "null" => "nothing (null)".to_owned(),
        other => {
            other.strip_prefix("string ").map_or_else(|| other.to_owned(), |text| format!("the text {text}"))
        }
    }
}

/// The start of a text, on one line: what a file says may be a megabyte long.
pub(super) fn clip(text: &str) -> String {
    clip_to(160, text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_parser_says_is_said_in_plain_words() {
        let told = |problem: &str| plain(problem.to_owned());
        let number = "invalid type: integer `3`, expected struct Primitive";
        assert_eq!(told(number), "a table { … } is needed here, and this is the number 3");
        let word = "invalid type: string \"a, expected b\", expected a sequence";
        assert_eq!(told(word), "a list is needed here, and this is the text \"a, expected b\"");
        assert_eq!(told("missing field `buffers`"), "the field \"buffers\" is missing, which is needed here");
        let table = "invalid type: map, expected a sequence";
        assert_eq!(told(table), "a list is needed here, and this is a table { … }");
        assert_eq!(told("anything else"), "anything else");
    }
}
