//! Objects that are found by name and hang under one another: what a scene has, and each of its definitions.

use std::collections::HashMap;

use nalgebra::Matrix4;

use super::object::Object;
use crate::error::{Error, Result};

/// Objects in an order, found by their names, which are unique and not empty.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Objects {
    items: Vec<Object>,
    index: HashMap<String, usize>,
}

impl Objects {
    pub(super) fn as_slice(&self) -> &[Object] {
        &self.items
    }

    pub(super) fn position(&self, name: &str) -> Option<usize> {
        self.index.get(name).copied()
    }

    pub(super) fn get(&self, name: &str) -> Option<&Object> {
        self.position(name).map(|at| &self.items[at])
    }

    pub(super) fn object(&self, name: &str) -> Result<&Object> {
        self.get(name).ok_or_else(|| self.missing(name))
    }

    pub(super) fn object_mut(&mut self, name: &str) -> Result<&mut Object> {
        match self.position(name) {
            Some(at) => Ok(&mut self.items[at]),
            None => Err(self.missing(name)),
        }
    }

    pub(super) fn add(&mut self, object: Object) -> Result<()> {
        let name = object.name();
        if name.is_empty() {
            return Err(Error::Invalid("an object has an empty name: give it one".into()));
        }
        if self.index.contains_key(name) {
            return Err(Error::Invalid(format!("two objects are named \"{name}\": rename one")));
        }
        self.index.insert(name.to_owned(), self.items.len());
        self.items.push(object);
        Ok(())
    }

    /// Gives an object another name; what hangs under it follows.
    pub(super) fn rename(&mut self, name: &str, new: &str) -> Result<()> {
        let Some(at) = self.position(name) else { return Err(self.missing(name)) };
        if name == new {
            return Ok(());
        }
        if new.is_empty() {
            return Err(Error::Invalid(format!("\"{name}\" cannot be renamed to an empty name")));
        }
        if self.index.contains_key(new) {
            return Err(Error::Invalid(format!("\"{name}\" cannot be renamed: \"{new}\" is taken")));
        }
        self.index.remove(name);
        self.index.insert(new.to_owned(), at);
        new.clone_into(&mut self.items[at].name);
        self.items[at].label = None;
        for object in &mut self.items {
            if object.parent.as_deref() == Some(name) {
                object.parent = Some(new.to_owned());
            }
        }
        Ok(())
    }

    /// Takes out what is not to be kept; what hung under it hangs under the next object up that was.
    pub(super) fn retain(&mut self, keep: impl Fn(&Object) -> bool) -> Vec<Object> {
        let (kept, gone): (Vec<_>, Vec<_>) = std::mem::take(&mut self.items).into_iter().partition(keep);
        self.items = kept;
        if gone.is_empty() {
            return gone;
        }
        self.index = self.items.iter().enumerate().map(|(i, o)| (o.name.clone(), i)).collect();
        let mut above: HashMap<&str, Option<&str>> =
            gone.iter().map(|o| (o.name(), o.parent.as_deref())).collect();
        for object in &mut self.items {
            let parent = object.parent.as_deref().and_then(|parent| above.get_key_value(parent));
            if let Some((&parent, _)) = parent {
                object.parent = first_kept(parent, &mut above).map(str::to_owned);
            }
        }
        gone
    }

    pub(super) fn unique_name(&self, wanted: &str) -> String {
        crate::named::unique_name(wanted, "object", |name| self.index.contains_key(name))
    }

    /// How far down objects hang under one another, 1 where none does. Checks that every parent exists and no object hangs under
    /// itself, however far up. `O(objects)`.
    pub(super) fn depth(&self) -> Result<usize> {
        const ON_THE_WAY: usize = usize::MAX;
        // 0: not seen.
        let mut known = vec![0; self.items.len()];
        for start in 0..self.items.len() {
            let mut path = Vec::new();
            let mut at = Some(start);
            while let Some(i) = at.filter(|&i| matches!(known[i], 0 | ON_THE_WAY)) {
                let object = &self.items[i];
                let name = object.name();
                if known[i] == ON_THE_WAY {
                    return Err(Error::Invalid(format!(
                        "the hierarchy is cyclic: \"{name}\" hangs under itself; take one parent away"
                    )));
                }
                known[i] = ON_THE_WAY;
                path.push(i);
                let above = object.parent.as_ref().map(|parent| {
                    let missing = || format!("the parent \"{parent}\" of \"{name}\" does not exist");
                    self.position(parent).ok_or_else(|| Error::Invalid(missing()))
                });
                at = above.transpose()?;
            }
            let mut depth = at.map_or(0, |i| known[i]);
            for i in path.into_iter().rev() {
                depth += 1;
                known[i] = depth;
            }
        }
        Ok(known.into_iter().max().unwrap_or(0))
    }

    /// Each object's map into the coordinates that all of them are in: the product of the transforms from it up to its
    /// root; `None` where no object on that way has one. The hierarchy must have been checked.
    pub(super) fn transforms(&self) -> Vec<Option<Matrix4<f64>>> {
        let mut world: Vec<Option<Option<Matrix4<f64>>>> = vec![None; self.items.len()];
        for start in 0..self.items.len() {
            let mut way = Vec::new();
            let mut at = Some(start);
            while let Some(i) = at.filter(|&i| world[i].is_none()) {
                way.push(i);
                at = self.items[i].parent.as_deref().and_then(|parent| self.position(parent));
            }
            let mut above = at.and_then(|i| world[i]).flatten();
            for i in way.into_iter().rev() {
                above = after(above, self.items[i].transform);
                world[i] = Some(above);
            }
        }
        world.into_iter().map(Option::flatten).collect()
    }

    fn missing(&self, name: &str) -> Error {
        let names = self.items.iter().map(Object::name);
        let hint = match crate::declare::nearest(name, names) {
            Some(near) => format!("; did you mean \"{near}\"?"),
            None if self.items.is_empty() => "; the scene is empty".to_owned(),
            None if self.items.len() == 1 => format!("; the only one is \"{}\"", self.items[0].name),
            None => {
                let some: Vec<_> = self.items.iter().take(8).map(|o| format!("\"{}\"", o.name)).collect();
                let more = if self.items.len() > 8 { ", …" } else { "" };
                format!("; there are {}{more}", some.join(", "))
            }
        };
        Error::Invalid(format!("there is no object \"{name}\"{hint}"))
    }
}

/// One map after another, where there are any.
pub(super) fn after(above: Option<Matrix4<f64>>, own: Option<Matrix4<f64>>) -> Option<Matrix4<f64>> {
    match (above, own) {
        (Some(above), Some(own)) => Some(above * own),
        (above, own) => above.or(own),
    }
}

/// The next object up from one that went which did not, and a shorter way to it for all that were met; none where
/// objects that went hang under each other in a circle.
fn first_kept<'a>(name: &'a str, above: &mut HashMap<&'a str, Option<&'a str>>) -> Option<&'a str> {
    let mut way = Vec::new();
    let mut at = Some(name);
    while let Some(next) = at.and_then(|name| above.get_mut(name)) {
        way.extend(at);
        at = next.take();
    }
    for name in way {
        above.insert(name, at);
    }
    at
}
