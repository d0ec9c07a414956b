//! Entities as the reader asks for them: by place, with their parameters typed, and what is wrong in words.

use std::cell::RefCell;

use crate::text::{Entry, File, Params, Value, decode};

/// Why an entity cannot be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Problem {
    /// The place of the entity at fault.
    pub(crate) place: usize,
    /// What is wrong with it.
    pub(crate) text: String,
}

/// What was asked for, or why not.
pub(crate) type Got<T> = Result<T, Problem>;

impl Problem {
    pub(crate) fn new(place: usize, text: impl Into<String>) -> Self {
        Self { place, text: text.into() }
    }
}

/// How often entities may lie in one another where they can contain their own kind.
pub(crate) const DEEPEST: usize = 24;

/// That what lies in one another comes to an end.
pub(crate) fn deeper(place: usize, depth: usize) -> Got<usize> {
    if depth < DEEPEST {
        return Ok(depth + 1);
    }
    Err(Problem::new(place, format!("it lies in itself, or more than {DEEPEST} deep in others of its kind")))
}

/// An error of the kernel, of an entity.
pub(crate) trait At<T> {
    /// Names the entity.
    fn at(self, place: usize) -> Got<T>;
}

impl<T> At<T> for loftsman_kernel::Result<T> {
    fn at(self, place: usize) -> Got<T> {
        self.map_err(|error| Problem::new(place, error.to_string()))
    }
}

/// A file of which entities are taken, with what was taken.
pub(crate) struct Reader<'r, 'f> {
    pub(crate) file: &'r File<'f>,
    /// The entities that were looked at since the list was last emptied.
    used: RefCell<Vec<usize>>,
    /// Curves that were passed over, as they are computed anew.
    aside: RefCell<Vec<usize>>,
    /// What became another one than it is, and why.
    changed: RefCell<Vec<Problem>>,
}

/// An entity with its parameters.
pub(crate) struct Entity<'r, 'f> {
    pub(crate) place: usize,
    pub(crate) entry: &'r Entry,
    file: &'r File<'f>,
    params: Params,
}

impl<'r, 'f> Reader<'r, 'f> {
    pub(crate) fn new(file: &'r File<'f>) -> Self {
        Self { file, used: RefCell::default(), aside: RefCell::default(), changed: RefCell::default() }
    }

    /// A length of the file, for people.
    pub(crate) fn told(&self, length: f64) -> String {
        self.file.global.length.unit().quantity(length, 1)
    }

    /// An entity, which is looked at.
    pub(crate) fn entity(&self, place: usize) -> Got<Entity<'r, 'f>> {
        self.used.borrow_mut().push(place);
        self.glance(place)
    }

    /// An entity that is not taken by being looked at.
    pub(crate) fn glance(&self, place: usize) -> Got<Entity<'r, 'f>> {
        let params = self.file.params(place).map_err(|text| Problem::new(place, text))?;
        Ok(Entity { place, entry: self.file.entry(place), file: self.file, params })
    }

    /// An entity of one of these types.
    pub(crate) fn of(&self, place: usize, kinds: &[u32], what: &str) -> Got<Entity<'r, 'f>> {
        let kind = self.file.entry(place).kind;
        if kinds.contains(&kind) {
            return self.entity(place);
        }
        Err(Problem::new(place, format!("it is of type {kind} where {what} is needed")))
    }

    /// What was looked at since this was last asked.
    pub(crate) fn take_used(&self) -> Vec<usize> {
        std::mem::take(&mut self.used.borrow_mut())
    }

    /// Passes over a curve, with all that it is made of.
    pub(crate) fn set_aside(&self, place: usize) {
        self.aside.borrow_mut().push(place);
    }

    pub(crate) fn take_aside(&self) -> Vec<usize> {
        std::mem::take(&mut self.aside.borrow_mut())
    }

    /// Says that an entity comes in as another one.
    pub(crate) fn change(&self, place: usize, text: &str) {
        self.changed.borrow_mut().push(Problem::new(place, text));
    }

    pub(crate) fn take_changed(&self) -> Vec<Problem> {
        std::mem::take(&mut self.changed.borrow_mut())
    }
}

impl Entity<'_, '_> {
    /// How many parameters there are, beside the type.
    pub(crate) fn len(&self) -> usize {
        self.params.len().saturating_sub(1)
    }

    fn other<T>(&self, index: usize, needed: &str) -> Got<T> {
        let found = match self.params.value(index) {
            Value::Omitted => "nothing".to_owned(),
            Value::Number(number) => number.to_string(),
            Value::Text(_) => "a text".to_owned(),
            Value::Other(raw) => {
                format!("\"{}\"", loftsman_kernel::text::clip(&String::from_utf8_lossy(raw)))
            }
        };
        Err(Problem::new(self.place, format!("parameter {index} is {found} where {needed} is needed")))
    }

    /// A number; 0 where none stands.
    pub(crate) fn real(&self, index: usize) -> Got<f64> {
        match self.params.value(index) {
            Value::Number(number) => Ok(number),
            Value::Omitted => Ok(0.0),
            _ => self.other(index, "a number"),
        }
    }

    /// A number, where one stands.
    pub(crate) fn optional(&self, index: usize) -> Got<Option<f64>> {
        match self.params.value(index) {
            Value::Omitted => Ok(None),
            _ => self.real(index).map(Some),
        }
    }

    /// That there are parameters up to this one.
    pub(crate) fn has(&self, last: usize) -> Got<()> {
        if last <= self.len() {
            return Ok(());
        }
        let found = self.len();
        Err(Problem::new(self.place, format!("it has {found} parameters where {last} are needed")))
    }

    /// So many numbers.
    pub(crate) fn reals(&self, from: usize, count: usize) -> Got<Vec<f64>> {
        self.has(from.saturating_add(count).saturating_sub(1))?;
        (from..from + count).map(|index| self.real(index)).collect()
    }

    /// Three numbers.
    pub(crate) fn triple(&self, from: usize) -> Got<[f64; 3]> {
        Ok([self.real(from)?, self.real(from + 1)?, self.real(from + 2)?])
    }

    /// A whole number; 0 where none stands.
    pub(crate) fn whole(&self, index: usize) -> Got<i64> {
        match self.params.value(index) {
            Value::Omitted => Ok(0),
            Value::Number(number) if number.fract() == 0.0 && number.abs() < 1e15 => Ok(number as i64),
            _ => self.other(index, "a whole number"),
        }
    }

    /// A count: of things that each take so many parameters, of which there must be as many.
    pub(crate) fn count(&self, index: usize, each: usize) -> Got<usize> {
        let count = self.whole(index)?;
        let Ok(count) = usize::try_from(count) else { return self.other(index, "a count") };
        if count.saturating_mul(each) > self.len() {
            let found = self.len();
            let text = format!("parameter {index} says {count}, but there are only {found} parameters");
            return Err(Problem::new(self.place, text));
        }
        Ok(count)
    }

    /// The place of another entity.
    pub(crate) fn pointer(&self, index: usize) -> Got<usize> {
        match self.pointed(index)? {
            Some(place) if place == self.place => {
                Err(Problem::new(self.place, format!("parameter {index} names the entity itself")))
            }
            Some(place) => Ok(place),
            None => self.other(index, "the number of an entity"),
        }
    }

    /// The place of another entity, where one is named. Signs say what it is for in some types.
    pub(crate) fn pointed(&self, index: usize) -> Got<Option<usize>> {
        let number = self.whole(index)?.abs();
        if number == 0 {
            return Ok(None);
        }
        self.file.place(number).map(Some).ok_or_else(|| {
            Problem::new(self.place, format!("parameter {index} names D{number}, which is not in the file"))
        })
    }

    /// Places of so many entities.
    pub(crate) fn pointers(&self, from: usize, count: usize) -> Got<Vec<usize>> {
        let one = |index| match self.pointed(index)? {
            // What lies in itself is told, or left out, by those that hold many.
            Some(place) => Ok(place),
            None => self.pointer(index),
        };
        (from..from.saturating_add(count)).map(one).collect()
    }

    /// A text; empty where none stands.
    pub(crate) fn text(&self, index: usize) -> String {
        match self.params.value(index) {
            Value::Text(raw) => decode(raw).trim().to_owned(),
            _ => String::new(),
        }
    }
}
