//! Lists of things that are found by name.

use std::collections::HashMap;

use crate::error::{Error, Result};

/// Something that has a name.
pub trait Named {
    /// What kind of thing it is, for messages: `"material"`.
    const KIND: &'static str;

    /// Its name.
    fn name(&self) -> &str;
}

/// Things in an order, found by their names, which are unique and not empty.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedList<T> {
    items: Vec<T>,
    index: HashMap<String, usize>,
}

impl<T> Default for NamedList<T> {
    fn default() -> Self {
        Self { items: Vec::new(), index: HashMap::new() }
    }
}

impl<T: Named> NamedList<T> {
    /// Adds a thing at the end and says where it is.
    ///
    /// # Errors
    /// When its name is empty or taken; use [`unique_name`](Self::unique_name) for names from elsewhere.
    pub fn add(&mut self, item: T) -> Result<usize> {
        let name = item.name();
        if name.is_empty() {
            return Err(Error::Invalid(format!("{} has an empty name: give it one", T::KIND)));
        }
        if self.index.contains_key(name) {
            return Err(Error::Invalid(format!("two {}s are named \"{name}\": rename one", T::KIND)));
        }
        let at = self.items.len();
        self.index.insert(name.to_owned(), at);
        self.items.push(item);
        Ok(at)
    }

    /// The thing of a name, if there is one.
    pub fn get(&self, name: &str) -> Option<&T> {
        self.index.get(name).map(|&i| &self.items[i])
    }

    /// The thing of a name, if there is one, to be changed all but its name.
    pub(crate) fn get_mut(&mut self, name: &str) -> Option<&mut T> {
        self.index.get(name).map(|&i| &mut self.items[i])
    }

    /// Where the thing of a name is.
    pub fn position(&self, name: &str) -> Option<usize> {
        self.index.get(name).copied()
    }

    /// All of them, in their order.
    pub fn as_slice(&self) -> &[T] {
        &self.items
    }

    /// All of them, in their order.
    pub fn iter(&self) -> std::slice::Iter<'_, T> {
        self.items.iter()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.items.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.items.is_empty()
    }

    /// `wanted` itself if it is free, or with `.001`, `.002`, … behind it; the kind for an empty one.
    pub fn unique_name(&self, wanted: &str) -> String {
        unique_name(wanted, T::KIND, |name| self.index.contains_key(name))
    }
}

impl<'a, T> IntoIterator for &'a NamedList<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.items.iter()
    }
}

/// `wanted` (or `unnamed`, for an empty one) if it is free, or with `.001`, `.002`, … behind it.
pub(crate) fn unique_name(wanted: &str, unnamed: &str, is_taken: impl Fn(&str) -> bool) -> String {
    let base = if wanted.is_empty() { unnamed } else { wanted };
    if !is_taken(base) {
        return base.to_owned();
    }
    // Doubling, then halving: a file with 100,000 equal names must not cost their square.
    let taken = |number: u64| is_taken(&format!("{base}.{number:03}"));
    let mut high = 1_u64;
    while taken(high) {
        high *= 2;
    }
    let mut low = high / 2;
    while low + 1 < high {
        let middle = low + (high - low) / 2;
        if taken(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    format!("{base}.{high:03}")
}
