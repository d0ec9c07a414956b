//! A recipe's text as a table of values, TOML and JSON alike.

use std::fmt;
use std::sync::Arc;

use loftsman_kernel::text::{json_problem, unmarked};
use serde::de::{DeserializeSeed, Deserializer, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Number, Value};

use super::place;
use crate::recipe_error::RecipeError;

type Result<T, E = Box<RecipeError>> = std::result::Result<T, E>;

/// The text of a recipe, kept so that errors can say where in it they are.
#[derive(Debug, Clone)]
pub(super) struct Text {
    name: String,
    text: Arc<str>,
    json: bool,
}

impl Text {
    /// The text of a file. JSON where the name ends so, or where the text starts with a brace (no TOML does).
    pub(super) fn new(name: &str, bytes: &[u8]) -> Result<Self> {
        let bytes = unmarked(bytes);
        let text = std::str::from_utf8(bytes).map_err(|e| {
            let byte = e.valid_up_to();
            let line = bytes[..byte].iter().filter(|&&b| b == b'\n').count() + 1;
            let start = bytes[..byte].iter().rposition(|&b| b == b'\n').map_or(0, |n| n + 1);
            RecipeError::at(name, "", "not UTF-8 text; save the recipe as UTF-8")
                .in_line(Some((line, byte - start + 1)))
        })?;
        let lower = name.to_lowercase();
        let json =
            lower.ends_with(".json") || (!lower.ends_with(".toml") && text.trim_start().starts_with('{'));
        Ok(Self { name: name.to_owned(), text: text.into(), json })
    }

    /// The table that the text describes. Both parsers bound the depth of nesting.
    pub(super) fn table(&self) -> Result<Value> {
        if self.json { self.parse_json() } else { self.parse_toml() }
    }

    /// The same error with the line and column of its path.
    pub(super) fn locate(&self, mut error: Box<RecipeError>) -> Box<RecipeError> {
        if error.position.is_none() && !error.path.is_empty() {
            let byte = if self.json {
                place::in_json(&self.text, &error.path)
            } else {
                place::in_toml(&self.text, &error.path)
            };
            error.position = byte.map(|b| place::line_and_column(&self.text, b));
        }
        error
    }

    fn parse_json(&self) -> Result<Value> {
        let mut deserializer = serde_json::Deserializer::from_str(&self.text);
        Strict.deserialize(&mut deserializer).and_then(|v| deserializer.end().map(|()| v)).map_err(|e| {
            let problem = json_problem(&self.text, &e);
            let position = (e.line() > 0).then(|| (e.line(), e.column().max(1)));
            RecipeError::at(&self.name, "", problem).in_line(position)
        })
    }

    fn parse_toml(&self) -> Result<Value> {
        let table = self.text.parse::<toml::Table>().map_err(|e| {
            let position = e.span().map(|s| place::line_and_column(&self.text, s.start));
            let problem = e.message().trim().replace('\n', "; ");
            let instead = e.span().and_then(|span| instead(&self.text, span.start));
            let problem = instead.map(|instead| format!("{problem}: {instead}")).unwrap_or(problem);
            RecipeError::at(&self.name, "", problem).in_line(position)
        })?;
        let fail = |path: String, problem: &str| self.locate(RecipeError::at(&self.name, path, problem));
        from_toml(toml::Value::Table(table), String::new()).map_err(|(path, problem)| fail(path, problem))
    }
}

/// What to write instead of what TOML does not take at a place: paths as Windows has them, and numbers that begin with a point.
fn instead(text: &str, at: usize) -> Option<String> {
    let start = text.get(..at)?.rfind('\n').map_or(0, |n| n + 1);
    let line = text.get(start..)?.lines().next()?;
    let (_, value) = line.split_once('=')?;
    let value = value.trim();
    if value.starts_with('"') && value.contains('\\') {
        return Some(
            "in double quotes \\ begins a sign of its own: write / in paths, or put them in single quotes"
                .to_owned(),
        );
    }
    let number: String = value.chars().take_while(|c| c.is_ascii_digit() || "+-.eE_".contains(*c)).collect();
    let (sign, digits) = match number.strip_prefix(['-', '+']) {
        Some(digits) => (&number[..1], digits),
        None => ("", number.as_str()),
    };
    (digits.starts_with('.') && digits.len() > 1).then(|| format!("write {sign}0{digits}"))
}

/// A TOML value as a JSON one: TOML also has dates and infinite numbers, which no field takes.
fn from_toml(value: toml::Value, path: String) -> Result<Value, (String, &'static str)> {
    Ok(match value {
        toml::Value::String(text) => Value::String(text),
        toml::Value::Integer(number) => Value::from(number),
        toml::Value::Float(number) => Value::Number(
            Number::from_f64(number).ok_or((path, "every number must be finite; write a finite one"))?,
        ),
        toml::Value::Boolean(flag) => Value::Bool(flag),
        toml::Value::Datetime(_) => {
            return Err((path, "no field takes a date; put it in quotes if it is a text"));
        }
        toml::Value::Array(list) => Value::Array(
            list.into_iter()
                .enumerate()
                .map(|(i, v)| from_toml(v, format!("{path}[{i}]")))
                .collect::<Result<_, _>>()?,
        ),
        toml::Value::Table(table) => Value::Object(
            table
                .into_iter()
                .map(|(name, v)| {
                    let inner = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
                    Ok((name, from_toml(v, inner)?))
                })
                .collect::<Result<_, _>>()?,
        ),
    })
}

/// Any JSON value, but no field twice: the second would silently win.
struct Strict;

impl<'de> DeserializeSeed<'de> for Strict {
    type Value = Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Value, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Strict {
    type Value = Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a JSON value")
    }

    fn visit_bool<E>(self, v: bool) -> Result<Value, E> {
        Ok(Value::Bool(v))
    }

    fn visit_i64<E>(self, v: i64) -> Result<Value, E> {
        Ok(v.into())
    }

    fn visit_u64<E>(self, v: u64) -> Result<Value, E> {
        Ok(v.into())
    }

    fn visit_f64<E>(self, v: f64) -> Result<Value, E> {
        Ok(Number::from_f64(v).map_or(Value::Null, Value::Number))
    }

    fn visit_str<E>(self, v: &str) -> Result<Value, E> {
        Ok(Value::String(v.to_owned()))
    }

    fn visit_string<E>(self, v: String) -> Result<Value, E> {
        Ok(Value::String(v))
    }

    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<Value, A::Error> {
        let mut list = Vec::new();
        while let Some(value) = sequence.next_element_seed(Strict)? {
            list.push(value);
        }
        Ok(Value::Array(list))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut access: A) -> Result<Value, A::Error> {
        let mut map = Map::new();
        while let Some(name) = access.next_key::<String>()? {
            if map.contains_key(&name) {
                let problem = format!("the field \"{name}\" is given twice; keep one");
                return Err(serde::de::Error::custom(problem));
            }
            let value = access.next_value_seed(Strict)?;
            map.insert(name, value);
        }
        Ok(Value::Object(map))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(name: &str, text: &str) -> Result<Value> {
        Text::new(name, text.as_bytes())?.table()
    }

    #[test]
    fn both_syntaxes_give_the_same_table() {
        let toml =
            parse("a.toml", "input = 'x'\n[[step]]\nop = 'edit'\nat = [0.25, 1]\nkeep = true\n").unwrap();
        let json =
            parse("a.json", r#"{"input": "x", "step": [{"op": "edit", "at": [0.25, 1], "keep": true}]}"#)
                .unwrap();
        assert_eq!(toml, json);
        assert_eq!(parse("-", "{}").unwrap(), Value::Object(Map::new()));
    }

    #[test]
    fn syntax_errors_have_a_position() {
        let position = |name, text| parse(name, text).unwrap_err().position;
        assert_eq!(position("a.toml", "input = 'x'\nstep = [\n"), Some((2, 9)));
        assert_eq!(position("a.json", "{\n  \"step\": [}"), Some((2, 12)));
        assert_eq!(position("a.json", "{\n\"a\": 1,\n\"a\": 2}").map(|p| p.0), Some(3));
        assert_eq!(position("a.toml", "a = 1\na = 2").map(|p| p.0), Some(2));
        assert_eq!(position("a.toml", "a = [1, nan]"), Some((1, 9)));
        let error = Text::new("a.toml", b"input = 'x'\n\xff").unwrap_err();
        assert_eq!(error.position, Some((2, 1)));
    }

    #[test]
    fn what_json_cannot_hold_is_said() {
        let problem =
            |text: &str| Text::new("r.json", text.as_bytes()).unwrap().table().unwrap_err().to_string();
        for (value, part) in [
            ("NaN", "NaN is not a number"),
            ("-Infinity", "-Infinity is not a number"),
            ("1e999", "too large"),
            ("[", "ends in the middle"),
        ] {
            let text = format!("{{ \"step\": [\n{{ \"by\": {value}");
            let message = problem(&text);
            assert!(message.contains(part) && message.contains("line 2"), "{value}: {message}");
        }
    }

    #[test]
    fn deep_nesting_is_an_error_not_an_overflow() {
        for depth in [1_000, 200_000] {
            let open = "[".repeat(depth);
            for (name, text) in [
                ("a.json", open.clone()),
                ("a.json", format!("{open}{}", "]".repeat(depth))),
                ("a.json", "{\"a\":".repeat(depth)),
                ("a.toml", format!("a = {open}")),
                ("a.toml", format!("a = {open}{}", "]".repeat(depth))),
                ("a.toml", format!("a = {}", "{a=".repeat(depth))),
                ("a.toml", format!("{}a = 1", "a.".repeat(depth))),
                ("a.toml", format!("[{}a]", "a.".repeat(depth))),
                ("a.toml", open.clone()),
            ] {
                assert!(parse(name, &text).is_err(), "{name} {}", &text[..20]);
            }
        }
    }
}
