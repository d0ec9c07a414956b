//! Where in a recipe's text a path leads: `step[0].constraints[2].at` as a byte.
//!
//! The text has been parsed before, so what is read here is well formed and of bounded depth. Where the path's
//! end does not exist (a missing field), the innermost table that does is the place.

use toml::de::{DeTable, DeValue};

/// A step of a path: a field's name, or a number in a list.
#[derive(Debug, PartialEq)]
enum Segment<'a> {
    Name(&'a str),
    Index(usize),
}

fn segments(path: &str) -> Vec<Segment<'_>> {
    path.split(['.', '[']).filter(|s| !s.is_empty()).map(segment).collect()
}

fn segment(text: &str) -> Segment<'_> {
    match text.strip_suffix(']').and_then(|n| n.parse().ok()) {
        Some(index) => Segment::Index(index),
        None => Segment::Name(text),
    }
}

/// Line and column, both counted from 1; columns in characters.
pub(super) fn line_and_column(text: &str, byte: usize) -> (usize, usize) {
    let before = text.get(..byte).unwrap_or(text);
    let start = before.rfind('\n').map_or(0, |n| n + 1);
    (before.matches('\n').count() + 1, before[start..].chars().count() + 1)
}

/// The byte of a path in TOML.
pub(super) fn in_toml(text: &str, path: &str) -> Option<usize> {
    let table = DeTable::parse(text).ok()?;
    let (mut at, mut found) = (DeValue::Table(table.into_inner()), None);
    for segment in segments(path) {
        let next = match (at, segment) {
            (DeValue::Table(table), Segment::Name(name)) => {
                let Some((_, value)) = table.into_iter().find(|(key, _)| key.get_ref() == name) else {
                    break;
                };
                value
            }
            (DeValue::Array(list), Segment::Index(index)) => {
                let Some(value) = list.into_iter().nth(index) else { break };
                value
            }
            _ => break,
        };
        found = Some(next.span().start);
        at = next.into_inner();
    }
    found
}

/// The byte of a path in JSON.
pub(super) fn in_json(text: &str, path: &str) -> Option<usize> {
    let mut scan = Scan { bytes: text.as_bytes(), at: 0 };
    let mut found = None;
    scan.blank();
    for segment in segments(path) {
        if !scan.enter(&segment) {
            break;
        }
        found = Some(scan.at);
    }
    found
}

/// Reads along well-formed JSON.
struct Scan<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Scan<'_> {
    fn peek(&self) -> u8 {
        self.bytes.get(self.at).copied().unwrap_or(0)
    }

    fn blank(&mut self) {
        while self.peek().is_ascii_whitespace() {
            self.at += 1;
        }
    }

    /// From the start of a table or list to the start of one of its values.
    fn enter(&mut self, segment: &Segment<'_>) -> bool {
        let open = self.peek();
        let table = open == b'{';
        if !table && open != b'[' {
            return false;
        }
        self.at += 1;
        for count in 0.. {
            self.blank();
            if matches!(self.peek(), b'}' | b']' | 0) {
                return false;
            }
            let mut here = *segment == Segment::Index(count) && !table;
            if table {
                let start = self.at;
                self.value();
                let name: Option<String> = serde_json::from_slice(&self.bytes[start..self.at]).ok();
                here = name.is_some_and(|n| *segment == Segment::Name(&n));
                self.blank();
                self.at += 1; // the colon
                self.blank();
            }
            if here {
                return true;
            }
            self.value();
            self.blank();
            if self.peek() == b',' {
                self.at += 1;
            }
        }
        false
    }

    /// Past a value of any kind.
    fn value(&mut self) {
        let mut depth = 0_usize;
        loop {
            match self.peek() {
                0 => return,
                b'"' => {
                    self.at += 1;
                    while !matches!(self.peek(), b'"' | 0) {
                        self.at += if self.peek() == b'\\' { 2 } else { 1 };
                    }
                    self.at += 1;
                }
                b'{' | b'[' => {
                    depth += 1;
                    self.at += 1;
                }
                b'}' | b']' if depth > 0 => {
                    depth -= 1;
                    self.at += 1;
                }
                b',' | b'}' | b']' if depth == 0 => return,
                b':' if depth == 0 => return,
                _ => {
                    self.at += 1;
                    continue;
                }
            }
            self.at = self.at.min(self.bytes.len());
            if depth == 0 {
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_lead_to_lines() {
        let toml = "input = 'x'\n[[step]]\nop = 'edit'\nconstraints = [\n  { at = 1 },\n  { at = 'é', by = 2 },\n]\n";
        let json = "{\"input\": \"a]\\\"}\",\n\"step\": [{\"op\": \"edit\",\n\"constraints\": [\n  {\"at\": 1},\n  {\"at\": \"é\", \"by\": -2e3}]}]}";
        for (text, place) in [(toml, in_toml as fn(&str, &str) -> Option<usize>), (json, in_json)] {
            let starts = |path: &str, expected: &str| {
                let byte = place(text, path).unwrap();
                assert!(text[byte..].starts_with(expected), "{path}: {}", &text[byte..]);
            };
            starts("step[0].constraints[1].by", if text == toml { "2 }" } else { "-2e3" });
            starts("step[0].constraints[0].at", "1");
            starts("step[0].constraints[0].missing", "{");
            starts("step[0].op", if text == toml { "'edit'" } else { "\"edit\"" });
            assert_eq!(place(text, "nothing"), None);
        }
        assert_eq!(line_and_column(toml, in_toml(toml, "step[0].constraints[1].by").unwrap()), (6, 20));
    }
}
