//! Definitions: what a scene shows more than once.

use std::collections::HashMap;

use nalgebra::Matrix4;

use super::Scene;
use super::geometry::Geometry;
use super::list::Objects;
use super::object::Object;
use crate::error::{Error, Result};
use crate::named::Named;

/// A named list of objects with a hierarchy of its own, which a scene shows wherever an object is an
/// [instance](Geometry::Instance) of it: a part of an assembly, a block of a drawing, a symbol.
///
/// Definitions have instances of other definitions among their objects, to any depth, but none of themselves. Their
/// objects name the materials of the scene. A change of an object of a definition changes it everywhere.
#[derive(Debug, Clone, PartialEq)]
pub struct Definition {
    name: String,
    /// What a format said of it beyond its objects, word for word, for the same format.
    pub statements: Vec<(String, String)>,
    pub(super) list: Objects,
}

impl Definition {
    /// A definition without objects.
    pub fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), statements: Vec::new(), list: Objects::default() }
    }

    /// The same definition under another name.
    #[must_use]
    pub fn named(self, name: impl Into<String>) -> Self {
        Self { name: name.into(), ..self }
    }

    /// Its name, unique among the definitions of its scene, never empty there.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its objects, in their order. Their names are unique within it; their parents are among them.
    pub fn objects(&self) -> &[Object] {
        self.list.as_slice()
    }

    /// Its object of a name, if there is one.
    pub fn get(&self, name: &str) -> Option<&Object> {
        self.list.get(name)
    }

    /// Its object of a name.
    ///
    /// # Errors
    /// When there is none; the error lists the nearest name that there is.
    pub fn object(&self, name: &str) -> Result<&Object> {
        self.list.object(name)
    }

    /// Its object of a name, to be changed wherever the definition is shown.
    ///
    /// # Errors
    /// As for [`object`](Self::object).
    pub fn object_mut(&mut self, name: &str) -> Result<&mut Object> {
        self.list.object_mut(name)
    }

    /// Adds an object at the end.
    ///
    /// # Errors
    /// When its name is empty, or taken within the definition.
    pub fn add(&mut self, object: Object) -> Result<()> {
        self.list.add(object).map_err(|e| self.at_fault(&e))
    }

    /// `wanted` itself if it is free within the definition, or with `.001`, `.002`, … behind it.
    pub fn unique_name(&self, wanted: &str) -> String {
        self.list.unique_name(wanted)
    }

    pub(super) fn at_fault(&self, error: &Error) -> Error {
        Error::Invalid(format!("in the definition \"{}\": {error}", self.name))
    }
}

impl Named for Definition {
    const KIND: &'static str = "definition";

    fn name(&self) -> &str {
        &self.name
    }
}

/// The definitions of a scene, known to be sound: they exist, and none shows itself.
pub(super) struct Sound {
    /// How many objects each shows, itself and all that its instances show; at most `u64::MAX`.
    counts: Vec<u64>,
}

impl Sound {
    /// Checks the definitions of a scene and what its objects show. `O(objects)`, however deep they nest.
    pub(super) fn of(scene: &Scene) -> Result<Self> {
        let definitions = scene.definitions.as_slice();
        // 0: not seen, 1: being counted, 2: counted.
        let mut state = vec![0_u8; definitions.len()];
        let mut counts = vec![0_u64; definitions.len()];
        for start in 0..definitions.len() {
            if state[start] != 0 {
                continue;
            }
            state[start] = 1;
            let mut open = vec![(start, 0)];
            while let Some((at, next)) = open.last_mut() {
                let definition = &definitions[*at];
                let Some(object) = definition.objects().get(*next) else {
                    state[*at] = 2;
                    open.pop();
                    continue;
                };
                let inner = shown(scene, object).map_err(|e| definition.at_fault(&e))?;
                match inner.map(|inner| (inner, state[inner])) {
                    Some((inner, 0)) => {
                        state[inner] = 1;
                        open.push((inner, 0));
                        continue;
                    }
                    Some((inner, 1)) => {
                        let from = open.iter().position(|&(at, _)| at == inner).unwrap_or_default();
                        let names = open[from..].iter().map(|&(at, _)| definitions[at].name());
                        return Err(circle(names.chain([definitions[inner].name()])));
                    }
                    Some((inner, _)) => counts[*at] = counts[*at].saturating_add(counts[inner]),
                    None => {}
                }
                counts[*at] = counts[*at].saturating_add(1);
                *next += 1;
            }
        }
        scene.objects().iter().try_for_each(|object| shown(scene, object).map(drop))?;
        Ok(Self { counts })
    }

    /// How many objects a scene shows, instances and what they show; at most `u64::MAX`.
    pub(super) fn count(&self, scene: &Scene) -> u64 {
        let inner = |object: &Object| instance(object).and_then(|name| scene.definitions.position(name));
        let counts = scene.objects().iter().map(|object| inner(object).map_or(0, |at| self.counts[at]));
        counts.fold(0, |sum, count| sum.saturating_add(count).saturating_add(1))
    }
}

/// The name of the definition that an object shows.
pub(super) fn instance(object: &Object) -> Option<&str> {
    if let Geometry::Instance(name) = object.geometry() { Some(name) } else { None }
}

/// Where among the definitions the one is that an object shows, if it is an instance.
fn shown(scene: &Scene, object: &Object) -> Result<Option<usize>> {
    let Some(definition) = instance(object) else { return Ok(None) };
    let found = scene.definitions.position(definition);
    let missing = || {
        let name = object.name();
        Error::Invalid(format!("\"{name}\" shows the definition \"{definition}\", which does not exist"))
    };
    found.map(Some).ok_or_else(missing)
}

fn circle<'a>(names: impl Iterator<Item = &'a str>) -> Error {
    let names: Vec<String> = names.map(|name| format!("\"{name}\"")).collect();
    let way = match names.as_slice() {
        [first, .., last] if names.len() > 8 => format!("{first} → … ({} more) → {last}", names.len() - 2),
        _ => names.join(" → "),
    };
    Error::Invalid(format!("the definitions are cyclic: {way}; take one of these instances away"))
}

/// The maps from the objects of each definition into its coordinates.
pub(super) fn transforms(scene: &Scene) -> HashMap<&str, Vec<Option<Matrix4<f64>>>> {
    scene.definitions.iter().map(|d| (d.name(), d.list.transforms())).collect()
}
