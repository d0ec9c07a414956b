//! Entities as the reader asks for them: by number, with their attributes typed, and what is wrong in words.

use crate::part21::{Entity, File, Kind, Part, Value, decode};

/// Why an entity cannot be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Problem {
    /// The entity at fault.
    pub(crate) number: u64,
    /// What is wrong with it.
    pub(crate) text: String,
}

/// What was asked for, or why not.
pub(crate) type Got<T> = Result<T, Problem>;

impl Problem {
    pub(crate) fn new(number: u64, text: impl Into<String>) -> Self {
        Self { number, text: text.into() }
    }
}

/// How often entities may lie in one another where they can contain their own kind.
pub(crate) const DEEPEST: usize = 24;

/// That what lies in one another comes to an end.
pub(crate) fn deeper(number: u64, depth: usize) -> Got<usize> {
    if depth < DEEPEST {
        return Ok(depth + 1);
    }
    Err(Problem::new(number, format!("it lies in itself, or more than {DEEPEST} deep in others of its kind")))
}

/// An error of the kernel, of an entity.
pub(crate) trait At<T> {
    /// Names the entity.
    fn at(self, number: u64) -> Got<T>;
}

impl<T> At<T> for loftsman_kernel::Result<T> {
    fn at(self, number: u64) -> Got<T> {
        self.map_err(|error| Problem::new(number, error.to_string()))
    }
}

/// The entity of a number, parsed.
pub(crate) fn entity<'f>(file: &File<'f>, number: u64) -> Got<Entity<'f>> {
    let Some(place) = file.place(number) else {
        return Err(Problem::new(number, "it is named, but is not in the file"));
    };
    file.parse(place).map_err(|fault| Problem::new(number, fault.problem))
}

/// The type of the entity of a number; empty where there is none, or it is of several.
pub(crate) fn kind<'f>(file: &File<'f>, number: u64) -> &'f [u8] {
    match file.place(number).map(|place| file.kind(place)) {
        Some(Kind::One(name)) => name,
        _ => b"",
    }
}

impl<'f> Entity<'f> {
    /// The types that it is of, for messages.
    pub(crate) fn kinds(&self) -> String {
        let names: Vec<_> = self.parts.iter().map(|part| String::from_utf8_lossy(part.name)).collect();
        names.join(" ")
    }

    /// The part of one type.
    pub(crate) fn part(&self, name: &str) -> Option<&Part<'f>> {
        self.parts.iter().find(|part| part.name == name.as_bytes())
    }

    /// The attributes of one type.
    pub(crate) fn of(&self, name: &str) -> Got<Args<'_, 'f>> {
        match self.part(name) {
            Some(part) => Ok(Args { number: self.number, values: &part.values }),
            None => Err(Problem::new(self.number, format!("it is {} where {name} is needed", self.kinds()))),
        }
    }

    /// The attributes of an entity of one type.
    pub(crate) fn args(&self) -> Args<'_, 'f> {
        Args { number: self.number, values: self.parts.first().map_or(&[], |part| &part.values) }
    }

    /// The type, where there is one only; empty where there are several.
    pub(crate) fn only(&self) -> &'f [u8] {
        match &self.parts[..] {
            [part] => part.name,
            _ => b"",
        }
    }
}

/// Attributes by their places.
#[derive(Clone, Copy)]
pub(crate) struct Args<'e, 'f> {
    pub(crate) number: u64,
    pub(crate) values: &'e [Value<'f>],
}

impl<'e, 'f> Args<'e, 'f> {
    fn value(&self, index: usize) -> Got<&'e Value<'f>> {
        self.values.get(index).ok_or_else(|| {
            let (count, needed) = (self.values.len(), index + 1);
            Problem::new(self.number, format!("it has {count} attributes where {needed} or more are needed"))
        })
    }

    fn other<T>(&self, index: usize, needed: &str) -> Got<T> {
        let found = self.value(index)?.what();
        Err(Problem::new(self.number, format!("attribute {} is {found} where {needed} is needed", index + 1)))
    }

    /// The number of another entity.
    pub(crate) fn reference(&self, index: usize) -> Got<u64> {
        match self.value(index)? {
            Value::Reference(number) => Ok(*number),
            _ => self.other(index, "an entity"),
        }
    }

    /// The number of another entity, where one is given.
    pub(crate) fn optional(&self, index: usize) -> Got<Option<u64>> {
        match self.values.get(index) {
            None | Some(Value::Omitted | Value::Derived) => Ok(None),
            Some(_) => self.reference(index).map(Some),
        }
    }

    /// A list.
    pub(crate) fn list(&self, index: usize) -> Got<&'e [Value<'f>]> {
        match self.value(index)? {
            Value::List(values) => Ok(values),
            _ => self.other(index, "a list"),
        }
    }

    /// A list of entities.
    pub(crate) fn references(&self, index: usize) -> Got<Vec<u64>> {
        let all = self.list(index)?.iter().map(|value| match value {
            Value::Reference(number) => Some(*number),
            _ => None,
        });
        all.collect::<Option<_>>().map_or_else(|| self.other(index, "a list of entities"), Ok)
    }

    /// A number.
    pub(crate) fn real(&self, index: usize) -> Got<f64> {
        real(self.value(index)?).map_or_else(|| self.other(index, "a number"), Ok)
    }

    /// A list of numbers.
    pub(crate) fn reals(&self, index: usize) -> Got<Vec<f64>> {
        let all = self.list(index)?.iter().map(real).collect::<Option<_>>();
        all.map_or_else(|| self.other(index, "a list of numbers"), Ok)
    }

    /// A count.
    pub(crate) fn count(&self, index: usize) -> Got<usize> {
        whole(self.value(index)?).map_or_else(|| self.other(index, "a whole number"), Ok)
    }

    /// A list of counts.
    pub(crate) fn counts(&self, index: usize) -> Got<Vec<usize>> {
        let all = self.list(index)?.iter().map(whole).collect::<Option<_>>();
        all.map_or_else(|| self.other(index, "a list of whole numbers"), Ok)
    }

    /// `.T.` or `.F.`.
    pub(crate) fn flag(&self, index: usize) -> Got<bool> {
        match self.value(index)? {
            Value::Enumeration(b"T" | b"TRUE") => Ok(true),
            Value::Enumeration(b"F" | b"FALSE") => Ok(false),
            _ => self.other(index, ".T. or .F."),
        }
    }

    /// A text; empty where it says nothing: none is given, or one that writers put there for want of another.
    pub(crate) fn name(&self, index: usize) -> String {
        match self.values.get(index) {
            Some(Value::Text(raw)) => {
                let text = decode(raw);
                let text = text.trim();
                if ["NONE", "Unknown"].contains(&text) { String::new() } else { text.to_owned() }
            }
            _ => String::new(),
        }
    }
}

/// A value as a number.
pub(crate) fn real(value: &Value<'_>) -> Option<f64> {
    match value {
        Value::Real(number) => Some(*number),
        Value::Integer(number) => Some(*number as f64),
        // A measure of a named type: LENGTH_MEASURE(2.5).
        Value::Typed(_, values) => match &values[..] {
            [Value::Real(number)] => Some(*number),
            [Value::Integer(number)] => Some(*number as f64),
            _ => None,
        },
        _ => None,
    }
}

fn whole(value: &Value<'_>) -> Option<usize> {
    match value {
        Value::Integer(number) => usize::try_from(*number).ok(),
        Value::Real(number) if *number >= 0.0 && number.fract() == 0.0 && *number < 1e15 => {
            Some(*number as usize)
        }
        _ => None,
    }
}
