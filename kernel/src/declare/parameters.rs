//! The fields of a recipe step, constraint or option, read with errors that name the place.

use serde_json::{Map, Value};

use super::declaration::{Field, hint};
use crate::shape::Location;
use crate::{Point, Vector};

/// A field that is missing, unknown or of the wrong kind.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{path}: {problem}")]
pub struct ParameterError {
    /// Where: `step[0].constraints[2].at`.
    pub path: String,
    /// What is wrong and what to do.
    pub problem: String,
}

/// Named values, and the path that leads to them.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameters {
    map: Map<String, Value>,
    path: String,
}

type Result<T> = std::result::Result<T, ParameterError>;

impl Default for Parameters {
    /// No options.
    fn default() -> Self {
        Self::empty("options")
    }
}

impl Parameters {
    /// The fields of a table (a JSON object) found at `path`.
    ///
    /// # Errors
    /// When `value` is not a table.
    pub fn new(value: Value, path: impl Into<String>) -> Result<Self> {
        let path = path.into();
        match value {
            Value::Object(map) => Ok(Self { map, path }),
            other => {
                Err(ParameterError { problem: format!("{} where a table is needed", short(&other)), path })
            }
        }
    }

    /// No fields at all.
    pub fn empty(path: impl Into<String>) -> Self {
        Self { map: Map::new(), path: path.into() }
    }

    /// The table with one more field, or another value of one.
    #[must_use]
    pub fn with(mut self, name: impl Into<String>, value: impl Into<Value>) -> Self {
        self.map.insert(name.into(), value.into());
        self
    }

    /// The same with points, each `[x, y, z]`.
    #[must_use]
    pub fn with_points(self, name: impl Into<String>, points: &[Point]) -> Self {
        self.with(name, points.iter().map(|p| Value::from(p.coords.as_slice())).collect::<Vec<_>>())
    }

    /// The fields and their values, as a table.
    pub fn into_map(self) -> Map<String, Value> {
        self.map
    }

    /// Where the table was found.
    pub fn path(&self) -> &str {
        &self.path
    }

    /// The names of the fields that are there.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.map.keys().map(String::as_str)
    }

    /// Whether a field is there.
    pub fn has(&self, name: &str) -> bool {
        self.map.contains_key(name)
    }

    /// The raw value of a field.
    pub fn value(&self, name: &str) -> Option<&Value> {
        self.map.get(name)
    }

    /// An error at a field of this table (or at the table, where `name` is empty).
    pub fn error(&self, name: &str, problem: impl Into<String>) -> ParameterError {
        ParameterError { path: self.path_of(name), problem: problem.into() }
    }

    /// Refuses fields that are not among `fields`, and misses required ones.
    ///
    /// # Errors
    /// Naming the field, and the nearest right name.
    pub fn check<'f>(&self, fields: impl IntoIterator<Item = &'f Field> + Clone) -> Result<()> {
        for name in self.names() {
            if fields.clone().into_iter().all(|f| f.name != name) {
                // A functional may take over a wish: a normal has a "to" of its own.
                let mut known: Vec<&str> = Vec::new();
                for field in fields.clone() {
                    if !known.contains(&field.name) {
                        known.push(field.name);
                    }
                }
                let hint = hint(name, known.iter().copied(), || match known[..] {
                    [] => "no fields are taken here".to_owned(),
                    _ => format!("known here: {}", known.join(", ")),
                });
                return Err(self.error("", format!("unknown field \"{}\"; {hint}", clip(name))));
            }
        }
        for field in fields {
            if field.default.is_none() && !self.has(field.name) {
                let Field { name, takes, help, .. } = field;
                return Err(self.error("", format!("the field \"{name}\" is missing: {takes}, {help}")));
            }
        }
        Ok(())
    }

    /// A number.
    ///
    /// # Errors
    /// When it is missing, not a number or not finite.
    pub fn number(&self, name: &str) -> Result<f64> {
        let value = self.need(name)?;
        number_of(value).ok_or_else(|| self.error(name, format!("{} where a number is needed", short(value))))
    }

    /// A number, or a default where the field is left out.
    ///
    /// # Errors
    /// When it is there and not a finite number.
    pub fn number_or(&self, name: &str, default: f64) -> Result<f64> {
        if self.has(name) { self.number(name) } else { Ok(default) }
    }

    /// A whole number.
    ///
    /// # Errors
    /// When it is missing or not a whole number.
    pub fn integer(&self, name: &str) -> Result<i64> {
        let value = self.need(name)?;
        integer_of(value).ok_or_else(|| {
            self.error(name, format!("{} where a whole number is needed{}", short(value), meant(value)))
        })
    }

    /// A whole number that is not negative.
    ///
    /// # Errors
    /// When it is missing, not a whole number or negative.
    pub fn count(&self, name: &str) -> Result<usize> {
        usize::try_from(self.integer(name)?)
            .map_err(|_| self.error(name, "a negative number where a count is needed"))
    }

    /// A count, or a default where the field is left out.
    ///
    /// # Errors
    /// When it is there and not a count.
    pub fn count_or(&self, name: &str, default: usize) -> Result<usize> {
        if self.has(name) { self.count(name) } else { Ok(default) }
    }

    /// Whole numbers.
    ///
    /// # Errors
    /// When it is missing or not a list of whole numbers.
    pub fn integers(&self, name: &str) -> Result<Vec<i64>> {
        self.list(name)?
            .iter()
            .enumerate()
            .map(|(i, v)| {
                integer_of(v).ok_or_else(|| {
                    self.error(
                        &format!("{name}[{i}]"),
                        format!("{} where a whole number is needed", short(v)),
                    )
                })
            })
            .collect()
    }

    /// Numbers.
    ///
    /// # Errors
    /// When it is missing or not a list of finite numbers.
    pub fn numbers(&self, name: &str) -> Result<Vec<f64>> {
        self.list(name)?
            .iter()
            .enumerate()
            .map(|(i, v)| {
                number_of(v).ok_or_else(|| {
                    self.error(&format!("{name}[{i}]"), format!("{} where a number is needed", short(v)))
                })
            })
            .collect()
    }

    /// A text.
    ///
    /// # Errors
    /// When it is missing or not a text.
    pub fn text(&self, name: &str) -> Result<&str> {
        let value = self.need(name)?;
        value.as_str().ok_or_else(|| self.error(name, format!("{} where a text is needed", short(value))))
    }

    /// A text, or a default where the field is left out.
    ///
    /// # Errors
    /// When it is there and not a text.
    pub fn text_or<'a>(&'a self, name: &str, default: &'a str) -> Result<&'a str> {
        if self.has(name) { self.text(name) } else { Ok(default) }
    }

    /// One of several words.
    ///
    /// # Errors
    /// When it is missing or none of them; the error suggests the nearest.
    pub fn choice<T: Copy>(&self, name: &str, choices: &[(&str, T)]) -> Result<T> {
        let text = self.text(name)?;
        if let Some((_, value)) = choices.iter().find(|(word, _)| *word == text) {
            return Ok(*value);
        }
        let words: Vec<&str> = choices.iter().map(|(word, _)| *word).collect();
        let hint = hint(text, words.iter().copied(), || format!("choose one of {}", words.join(", ")));
        Err(self.error(name, format!("unknown word \"{}\"; {hint}", clip(text))))
    }

    /// The same, or a default where the field is not there.
    ///
    /// # Errors
    /// As for [`choice`](Self::choice).
    pub fn choice_or<T: Copy>(&self, name: &str, choices: &[(&str, T)], default: T) -> Result<T> {
        if self.has(name) { self.choice(name, choices) } else { Ok(default) }
    }

    /// True or false; false where the field is left out.
    ///
    /// # Errors
    /// When it is there and neither.
    pub fn flag(&self, name: &str) -> Result<bool> {
        match self.value(name) {
            None => Ok(false),
            Some(Value::Bool(flag)) => Ok(*flag),
            Some(other) => Err(self.error(name, format!("{} where true or false is needed", short(other)))),
        }
    }

    /// A vector `[x, y, z]`.
    ///
    /// # Errors
    /// When it is missing or not three finite numbers.
    pub fn vector(&self, name: &str) -> Result<Vector> {
        let value = self.need(name)?;
        vector_of(value)
            .ok_or_else(|| self.error(name, format!("{} where [x, y, z] is needed", short(value))))
    }

    /// A point `[x, y, z]`.
    ///
    /// # Errors
    /// As for [`vector`](Self::vector).
    pub fn point(&self, name: &str) -> Result<Point> {
        self.vector(name).map(Point::from)
    }

    /// Points `[[x, y, z], …]`.
    ///
    /// # Errors
    /// When it is missing or one is not three finite numbers.
    pub fn points(&self, name: &str) -> Result<Vec<Point>> {
        self.list(name)?
            .iter()
            .enumerate()
            .map(|(i, v)| {
                vector_of(v).map(Point::from).ok_or_else(|| {
                    self.error(&format!("{name}[{i}]"), format!("{} where [x, y, z] is needed", short(v)))
                })
            })
            .collect()
    }

    /// A location: a number on a curve, `[u, v]` on a surface.
    ///
    /// # Errors
    /// When it is missing or neither.
    pub fn location(&self, name: &str) -> Result<Location> {
        let value = self.need(name)?;
        let location = match value {
            Value::Array(pair) if pair.len() == 2 => {
                number_of(&pair[0]).zip(number_of(&pair[1])).map(|(u, v)| Location::Surface(u, v))
            }
            Value::Object(_) => return self.table(name)?.place_on_faces(),
            other => number_of(other).map(Location::Curve),
        };
        location.ok_or_else(|| {
            self.error(
                name,
                format!("{} where a location is needed: a parameter u, [u, v] on a surface, or {{ closest = [x, y, z] }}", short(value)),
            )
        })
    }

    /// A location of a surface of many faces: `{ vertex = 7 }`, or `{ face = 12, uv = [0.5, 0.5] }`.
    fn place_on_faces(&self) -> Result<Location> {
        const FIELDS: &[Field] = &[
            Field::optional(
                "vertex",
                "whole number",
                "this or face is needed",
                "a control vertex: where it has most influence",
            ),
            Field::optional("face", "whole number", "this or vertex is needed", "a face"),
            Field::optional("uv", "[u, v]", "[0.5, 0.5]", "the place on the face"),
            // Whoever knows the object has put its parameters in the place of this one before.
            Field::optional(
                "closest",
                "[x, y, z]",
                "a place by numbers",
                "the place that is nearest to a point",
            ),
        ];
        self.check(FIELDS)?;
        let number = |name: &str| {
            let found = self.count(name)?;
            u32::try_from(found).map_err(|_| self.error(name, format!("{found} is more than there can be")))
        };
        match (self.has("vertex"), self.has("face")) {
            (true, false) if !self.has("uv") => Ok(Location::Vertex(number("vertex")?)),
            (false, true) => {
                let uv = if self.has("uv") { self.numbers("uv")? } else { vec![0.5, 0.5] };
                let [u, v] = uv[..] else {
                    return Err(self.error("uv", format!("{} numbers where [u, v] is needed", uv.len())));
                };
                Ok(Location::Face(number("face")?, u, v))
            }
            _ => Err(self.error(
                "",
                "a place is { vertex = number }, { face = number, uv = [u, v] }, or { closest = [x, y, z] } alone",
            )),
        }
    }

    /// A list.
    ///
    /// # Errors
    /// When it is missing or not a list.
    pub fn list(&self, name: &str) -> Result<&[Value]> {
        let value = self.need(name)?;
        match value {
            Value::Array(list) => Ok(list),
            Value::Object(_) => {
                Err(self
                    .error(name, "a table where a list is needed: write [{ … }], with brackets around it"))
            }
            other => Err(self.error(name, format!("{} where a list is needed", short(other)))),
        }
    }

    /// A table inside this one.
    ///
    /// # Errors
    /// When it is missing or not a table.
    pub fn table(&self, name: &str) -> Result<Self> {
        Self::new(self.need(name)?.clone(), self.path_of(name))
    }

    /// A list of tables inside this one; empty where the field is left out.
    ///
    /// # Errors
    /// When it is there and not a list of tables.
    pub fn tables(&self, name: &str) -> Result<Vec<Self>> {
        if !self.has(name) {
            return Ok(Vec::new());
        }
        self.list(name)?
            .iter()
            .enumerate()
            .map(|(i, v)| Self::new(v.clone(), format!("{}[{i}]", self.path_of(name))))
            .collect()
    }

    /// The same table without some of its fields.
    #[must_use]
    pub fn without(&self, names: &[&str]) -> Self {
        let map = self.map.iter().filter(|(k, _)| !names.contains(&k.as_str()));
        Self { map: map.map(|(k, v)| (k.clone(), v.clone())).collect(), path: self.path.clone() }
    }

    fn need(&self, name: &str) -> Result<&Value> {
        self.value(name).ok_or_else(|| self.error("", format!("the field \"{name}\" is missing")))
    }

    fn path_of(&self, name: &str) -> String {
        match (self.path.is_empty(), name.is_empty()) {
            (_, true) => self.path.clone(),
            (true, false) => name.to_owned(),
            (false, false) => format!("{}.{name}", self.path),
        }
    }
}

fn number_of(value: &Value) -> Option<f64> {
    value.as_f64().filter(|n| n.is_finite())
}

fn integer_of(value: &Value) -> Option<i64> {
    value.as_i64().or_else(|| {
        let number = value.as_f64()?;
        (number.fract() == 0.0 && number.abs() < 9e15).then_some(number as i64)
    })
}

fn vector_of(value: &Value) -> Option<Vector> {
    let list = value.as_array()?;
    if list.len() != 3 {
        return None;
    }
    Some(Vector::new(number_of(&list[0])?, number_of(&list[1])?, number_of(&list[2])?))
}

fn clip(text: &str) -> String {
    if text.chars().count() > 60 {
        text.chars().take(57).chain("...".chars()).collect()
    } else {
        text.to_owned()
    }
}

/// The number that a text where one is needed probably means: `: write 2` for `"2"` and for `"G2"`.
fn meant(value: &Value) -> String {
    let Value::String(text) = value else { return String::new() };
    let text = text.trim();
    let number = text.strip_prefix(['G', 'g', 'C', 'c']).unwrap_or(text);
    number.parse::<i64>().map(|number| format!(": write {number}")).unwrap_or_default()
}

fn short(value: &Value) -> String {
    match value {
        Value::Array(list) if list.len() > 8 => format!("a list of {}", list.len()),
        Value::Object(_) => "a table".to_owned(),
        other => clip(&other.to_string()),
    }
}
