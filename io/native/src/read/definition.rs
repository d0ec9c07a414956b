//! Definitions, instances of them, and geometry that an object shares with one before it.

use std::sync::Arc;

use loftsman_kernel::plugin::{Cancelled, ReadOptions, hint};
use loftsman_kernel::scene::{Definition, Geometry, Object, Scene};
use loftsman_kernel::text::clip;
use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Visitor};

use super::material::statements;
use super::object::ObjectTable;
use super::table::{Table, TableSeed, need};
use super::trail::Trail;

/// What stands before an object in a document.
#[derive(Clone, Copy)]
pub(super) struct Earlier<'s> {
    scene: &'s Scene,
    /// The definition whose object it is.
    own: Option<&'s Definition>,
}

impl Earlier<'_> {
    /// The geometry of an object of the same list, or of a definition that came before.
    pub(super) fn geometry<E: Error>(&self, same: &Same, trail: &Trail) -> Result<Arc<Geometry>, E> {
        let name = same.object.as_str();
        let of = same.definition.as_deref().map(|of| {
            let missing = || trail.refuse(format!("there is no definition \"{}\" before this", clip(of)));
            self.scene.definitions().get(of).ok_or_else(missing)
        });
        let (found, objects) = match of.transpose()?.or(self.own) {
            Some(definition) => (definition.get(name), definition.objects()),
            None => (self.scene.get(name), self.scene.objects()),
        };
        found.map(|object| Arc::clone(object.shared_geometry())).ok_or_else(|| {
            let hint = hint(name, objects.iter().map(Object::name), || {
                "an object has the same geometry as one that stands before it".to_owned()
            });
            trail.refuse(format!("there is no object \"{}\" before this; {hint}", clip(name)))
        })
    }
}

/// `"same_as"`: the object whose geometry another one has too.
#[derive(Default)]
pub(super) struct SameTable {
    object: Option<String>,
    definition: Option<String>,
}

/// An object whose geometry another one has too.
pub(super) struct Same {
    object: String,
    definition: Option<String>,
}

impl<'de> Table<'de> for SameTable {
    type Out = Same;
    const WHAT: &'static str = "what names an object with the same geometry";
    const FIELDS: &'static [&'static str] = &["object", "definition"];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        _: &Trail,
    ) -> Result<(), A::Error> {
        let text = Some(map.next_value()?);
        if name == "object" {
            self.object = text;
        } else {
            self.definition = text;
        }
        Ok(())
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<Same, E> {
        let object = need::<Self, _, _>(self.object, "object", trail)?;
        Ok(Same { object, definition: self.definition })
    }
}

/// `"instance"`: the definition that is shown.
#[derive(Default)]
pub(super) struct InstanceTable(Option<String>);

impl<'de> Table<'de> for InstanceTable {
    type Out = Geometry;
    const WHAT: &'static str = "an instance";
    const FIELDS: &'static [&'static str] = &["definition"];

    fn field<A: MapAccess<'de>>(&mut self, _: &'static str, map: &mut A, _: &Trail) -> Result<(), A::Error> {
        self.0 = Some(map.next_value()?);
        Ok(())
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<Geometry, E> {
        need::<Self, _, _>(self.0, "definition", trail).map(Geometry::Instance)
    }
}

/// A definition.
struct DefinitionTable<'s> {
    scene: &'s Scene,
    options: &'s ReadOptions<'s>,
    name: Option<String>,
    definition: Definition,
    objects: bool,
}

impl<'de> Table<'de> for DefinitionTable<'_> {
    type Out = Definition;
    const WHAT: &'static str = "a definition";
    const FIELDS: &'static [&'static str] = &["name", "statements", "objects"];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        match name {
            "name" => self.name = Some(map.next_value()?),
            "statements" => self.definition.statements = statements(map, trail)?,
            _ => {
                self.objects = true;
                let into = Into::Definition(self.scene, &mut self.definition);
                map.next_value_seed(ObjectsSeed { trail, into, options: self.options })?;
                trail.set_object(None);
            }
        }
        Ok(())
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<Definition, E> {
        let name = need::<Self, _, _>(self.name, "name", trail)?;
        need::<Self, _, _>(self.objects.then_some(()), "objects", trail)?;
        Ok(self.definition.named(name))
    }
}

/// The list of definitions: each goes into the scene as soon as it is read.
pub(super) struct DefinitionsSeed<'s, 't> {
    pub(super) trail: &'t Trail,
    pub(super) scene: &'s mut Scene,
    pub(super) options: &'s ReadOptions<'s>,
}

impl<'de> DeserializeSeed<'de> for DefinitionsSeed<'_, '_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for DefinitionsSeed<'_, '_> {
    type Value = ();

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "a list of definitions")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<(), A::Error> {
        let Self { trail, scene, options } = self;
        for index in 0.. {
            let definition = Definition::new("");
            let table = DefinitionTable { scene, options, name: None, definition, objects: false };
            let Some(found) = trail.index(index, list.next_element_seed(TableSeed { trail, table }))? else {
                break;
            };
            let added = scene.define(found).map_err(|defect| trail.refuse_table("name", defect.to_string()));
            trail.index(index, added)?;
        }
        Ok(())
    }
}

/// Where objects go that are read.
pub(super) enum Into<'s> {
    /// The scene.
    Scene(&'s mut Scene),
    /// A definition, behind those that the scene has.
    Definition(&'s Scene, &'s mut Definition),
}

impl Into<'_> {
    fn earlier(&self) -> Earlier<'_> {
        match self {
            Self::Scene(scene) => Earlier { scene, own: None },
            Self::Definition(scene, own) => Earlier { scene, own: Some(own) },
        }
    }

    fn add(&mut self, object: Object) -> loftsman_kernel::Result<()> {
        match self {
            Self::Scene(scene) => scene.add(object),
            Self::Definition(_, definition) => definition.add(object),
        }
    }
}

/// A list of objects: each goes to its place as soon as it is read.
pub(super) struct ObjectsSeed<'s, 't> {
    pub(super) trail: &'t Trail,
    pub(super) into: Into<'s>,
    pub(super) options: &'s ReadOptions<'s>,
}

impl<'de> DeserializeSeed<'de> for ObjectsSeed<'_, '_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for ObjectsSeed<'_, '_> {
    type Value = ();

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "a list of objects")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<(), A::Error> {
        let Self { trail, mut into, options } = self;
        for index in 0.. {
            if options.observer.cancelled() {
                return Err(trail.stop(Cancelled));
            }
            options.limits.check_entities(index).map_err(|e| trail.stop(e))?;
            trail.set_object(None);
            let seed = TableSeed { trail, table: ObjectTable::new(into.earlier(), options) };
            let Some(object) = trail.index(index, list.next_element_seed(seed))? else { break };
            let added = into.add(object).map_err(|defect| trail.refuse_table("name", defect.to_string()));
            trail.index(index, added)?;
        }
        Ok(())
    }
}
