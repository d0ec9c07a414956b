//! A scene: named objects with units, an up axis, colours, layers and a hierarchy.

mod animation;
pub mod connection;
mod definition;
mod geometry;
mod joined;
mod layer;
mod list;
mod merge;
mod object;
mod placed;
pub mod placement;
mod standing;
mod time;
mod within;

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use self::definition::Sound;
use self::list::Objects;
use crate::Point;
use crate::error::{Error, Result};
use crate::material::{Image, Material};
use crate::named::{Named, NamedList};
use crate::scene::connection::Connection;
use crate::spline::{Curve, Surface};
use crate::text::a;

pub use self::definition::Definition;
pub use self::geometry::Geometry;
pub(crate) use self::geometry::{CURVE_OF_POLYLINE, LINES_OF_MESH};
pub use self::joined::Joined;
pub use self::layer::{Hidden, Layer, check_layers};
pub use self::merge::{Merged, Side};
pub use self::object::Object;
pub use self::placed::{MOST_PLACED, Path, Placed, Placements};
pub use self::standing::{Standing, similarity};
pub use self::within::Within;
pub use crate::unit::{Length, Unit, Up};
pub use animation::Animation;

/// Named objects, their unit and their up axis.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scene {
    /// The unit of all lengths; of a file that does not say it, [unknown](Unit::Unknown).
    pub unit: Unit,
    /// The axis that points up.
    pub up: Up,
    /// The layers that objects name, as far as there is more to say of them than that ([`all_layers`](Self::all_layers)).
    pub layers: NamedList<Layer>,
    /// The materials that objects name.
    pub materials: NamedList<Material>,
    /// The pictures that materials' textures name.
    pub images: NamedList<Image>,
    /// What a format said of the whole beyond all this, word for word, for the same format.
    pub statements: Vec<(String, String)>,
    definitions: NamedList<Definition>,
    list: Objects,
    connections: Vec<Connection>,
}

impl Scene {
    /// An empty scene in metres, z up.
    pub fn new() -> Self {
        Self::default()
    }

    /// What was said of the whole under this heading, first.
    pub fn statement(&self, heading: &str) -> Option<&str> {
        self.statements.iter().find(|(known, _)| known == heading).map(|(_, text)| text.as_str())
    }

    /// The objects, in their order.
    pub fn objects(&self) -> &[Object] {
        self.list.as_slice()
    }

    /// The object of a name, if there is one.
    pub fn get(&self, name: &str) -> Option<&Object> {
        self.list.get(name)
    }

    /// Where among the [`objects`](Self::objects) the one of a name is.
    pub fn position(&self, name: &str) -> Option<usize> {
        self.list.position(name)
    }

    /// The object of a name.
    ///
    /// # Errors
    /// When there is none; the error lists the nearest name that there is.
    pub fn object(&self, name: &str) -> Result<&Object> {
        self.list.object(name)
    }

    /// The object of a name, to be changed.
    ///
    /// # Errors
    /// As for [`object`](Self::object).
    pub fn object_mut(&mut self, name: &str) -> Result<&mut Object> {
        self.list.object_mut(name)
    }

    /// The curve of a name.
    ///
    /// # Errors
    /// When there is no such object or it is not a curve.
    pub fn curve(&self, name: &str) -> Result<&Curve> {
        match self.object(name)?.geometry() {
            Geometry::Curve(curve) => Ok(curve),
            other => Err(Error::Invalid(format!("\"{name}\" is {}", other.other_than("a curve")))),
        }
    }

    /// The surface of a name.
    ///
    /// # Errors
    /// When there is no such object or it is not a surface.
    pub fn surface(&self, name: &str) -> Result<&Surface> {
        match self.object(name)?.geometry() {
            Geometry::Surface(surface) => Ok(surface),
            other => Err(Error::Invalid(format!("\"{name}\" is {}, not a surface", a(&other.noun())))),
        }
    }

    /// Adds an object at the end.
    ///
    /// # Errors
    /// When its name is empty or taken; use [`unique_name`](Self::unique_name) for names from elsewhere.
    pub fn add(&mut self, object: Object) -> Result<()> {
        self.list.add(object)
    }

    /// Gives an object another name, which is its label too; what hangs under it follows.
    ///
    /// # Errors
    /// When there is no such object, or the new name is empty or taken.
    pub fn rename(&mut self, name: &str, new: &str) -> Result<()> {
        self.list.rename(name, new)?;
        for connection in &mut self.connections {
            connection.rename(name, new);
        }
        Ok(())
    }

    /// Where surfaces meet.
    pub fn connections(&self) -> &[Connection] {
        &self.connections
    }

    /// Notes that two surfaces meet.
    ///
    /// # Errors
    /// When one of them is no surface of this scene.
    pub fn connect(&mut self, connection: Connection) -> Result<()> {
        connection.check(self)?;
        self.connections.push(connection);
        Ok(())
    }

    /// Forgets the connections of an object.
    fn disconnect(&mut self, name: &str) {
        self.connections.retain(|c| c.sides().iter().all(|side| side.object != name));
    }

    /// Puts a new geometry in the place of an object's old one. Everything else of the object stays, but its animation
    /// goes where the geometry is another one, since its frames are of the old ([`reshape`](Self::reshape) takes them
    /// along), and its connections where it is no surface any more.
    ///
    /// # Errors
    /// When there is no such object.
    pub fn replace(&mut self, name: &str, geometry: impl Into<Geometry>) -> Result<()> {
        self.replace_shared(name, Arc::new(geometry.into()))
    }

    /// As [`replace`](Self::replace), sharing the new geometry with whoever else holds it.
    ///
    /// # Errors
    /// When there is no such object.
    pub fn replace_shared(&mut self, name: &str, geometry: Arc<Geometry>) -> Result<()> {
        let object = self.object_mut(name)?;
        let same = Arc::ptr_eq(object.shared_geometry(), &geometry);
        if object.animation.is_some() && !same && *object.geometry() != *geometry {
            object.animation = None;
        }
        object.share_geometry(geometry);
        if !matches!(object.geometry(), Geometry::Surface(_) | Geometry::Trimmed(_)) {
            self.disconnect(name);
        }
        Ok(())
    }

    /// Takes an object out, and its connections. What hung under it hangs under its parent then.
    ///
    /// # Errors
    /// When there is no such object.
    pub fn remove(&mut self, name: &str) -> Result<Object> {
        self.list.object(name)?;
        let missing = || Error::Invalid(format!("there is no object \"{name}\""));
        self.retain(|object| object.name() != name).pop().ok_or_else(missing)
    }

    /// Takes all objects out that are not to be kept, and their connections, and gives them in their order. What hung
    /// under one of them hangs under the next object up that was kept. `O(objects)`, however many go.
    pub fn retain(&mut self, keep: impl Fn(&Object) -> bool) -> Vec<Object> {
        let gone = self.list.retain(keep);
        let names: HashSet<&str> = gone.iter().map(Object::name).collect();
        self.connections.retain(|c| c.sides().iter().all(|side| !names.contains(side.object.as_str())));
        gone
    }

    /// The definitions, in their order.
    pub fn definitions(&self) -> &NamedList<Definition> {
        &self.definitions
    }

    /// Adds a definition at the end.
    ///
    /// # Errors
    /// When its name is empty or taken.
    pub fn define(&mut self, definition: Definition) -> Result<()> {
        self.definitions.add(definition).map(drop)
    }

    /// The definition of a name.
    ///
    /// # Errors
    /// When there is none.
    pub fn definition(&self, name: &str) -> Result<&Definition> {
        self.definitions.get(name).ok_or_else(|| undefined(name))
    }

    /// The definition of a name, to be changed wherever it is shown.
    ///
    /// # Errors
    /// When there is none.
    pub fn definition_mut(&mut self, name: &str) -> Result<&mut Definition> {
        self.definitions.get_mut(name).ok_or_else(|| undefined(name))
    }

    /// Each object's map into the scene's coordinates; the hierarchy must have been checked.
    pub(crate) fn transforms(&self) -> Vec<Option<nalgebra::Matrix4<f64>>> {
        self.list.transforms()
    }

    /// All that is said of the whole, around other objects, without definitions and connections.
    pub(crate) fn around(&self) -> Self {
        Self {
            unit: self.unit,
            up: self.up,
            layers: self.layers.clone(),
            materials: self.materials.clone(),
            images: self.images.clone(),
            statements: self.statements.clone(),
            ..Self::default()
        }
    }

    /// `wanted` itself if it is free, or with `.001`, `.002`, … behind it; `"object"` for an empty one.
    pub fn unique_name(&self, wanted: &str) -> String {
        self.list.unique_name(wanted)
    }

    /// The corners of the axis-parallel box around all points that objects are kept as (control vertices
    /// included), in each object's own coordinates; `None` for an empty scene.
    pub fn bounds(&self) -> Option<(Point, Point)> {
        let mut points = self.objects().iter().flat_map(|o| o.geometry().points());
        let first = *points.next()?;
        Some(points.fold((first, first), |(low, high), p| (low.inf(p), high.sup(p))))
    }

    /// Checks what objects name: every parent, material and picture exists, meshes pass their own
    /// [`check`](crate::mesh::Mesh::check), connections are between surfaces, and no object hangs under itself, nor a layer
    /// lies below itself, however far up.
    ///
    /// # Errors
    /// With the names of the objects at fault.
    pub fn check(&self) -> Result<()> {
        self.check_hierarchy()?;
        check_layers(&self.layers)?;
        self.check_contents()
    }

    /// Checks that every parent exists and no object hangs under itself, however far up; and the
    /// [definitions](Self::check_definitions). `O(objects)`.
    ///
    /// # Errors
    /// With the names of the objects at fault.
    pub fn check_hierarchy(&self) -> Result<()> {
        self.list.depth()?;
        self.check_definitions()?;
        self.connections.iter().try_for_each(|connection| connection.check(self))
    }

    /// Checks that every definition that is shown exists, that none shows itself, however far down, and the hierarchy of
    /// each. `O(objects)`.
    ///
    /// # Errors
    /// With the names of the definitions and objects at fault.
    pub fn check_definitions(&self) -> Result<()> {
        for definition in &self.definitions {
            definition.list.depth().map_err(|e| definition.at_fault(&e))?;
        }
        Sound::of(self).map(drop)
    }

    /// How far down objects hang under one another, in the scene or any of its definitions: 1 where none does. `O(objects)`.
    ///
    /// # Errors
    /// As for [`check_hierarchy`](Self::check_hierarchy).
    pub fn depth(&self) -> Result<usize> {
        let lists = self.definitions.iter().map(|definition| &definition.list).chain([&self.list]);
        lists.map(Objects::depth).try_fold(0, |most, depth| Ok(most.max(depth?)))
    }

    fn check_contents(&self) -> Result<()> {
        for material in &self.materials {
            for texture in material.textures.values() {
                if self.images.get(&texture.image).is_none() {
                    let (name, image) = (material.name(), &texture.image);
                    let problem = format!("the image \"{image}\" of the material \"{name}\" does not exist");
                    return Err(Error::Invalid(problem));
                }
            }
        }
        let mut slots = HashMap::new();
        self.objects().iter().try_for_each(|object| self.check_object(object, &mut slots))?;
        for definition in &self.definitions {
            let mut objects = definition.objects().iter();
            objects
                .try_for_each(|object| self.check_object(object, &mut slots))
                .map_err(|e| definition.at_fault(&e))?;
        }
        Ok(())
    }

    /// Checks what an object names, and its geometry, if that is not among those whose largest slot is known.
    fn check_object(&self, object: &Object, slots: &mut HashMap<usize, u32>) -> Result<()> {
        let name = object.name();
        if let Some(missing) = object.materials.iter().find(|m| self.materials.get(m).is_none()) {
            return Err(Error::Invalid(format!("the material \"{missing}\" of \"{name}\" does not exist")));
        }
        let Geometry::Mesh(mesh) = object.geometry() else { return Ok(()) };
        let known = slots.get(&object.geometry_id()).copied();
        let largest = match known {
            Some(largest) => largest,
            None => {
                mesh.check().map_err(|e| Error::Invalid(format!("\"{name}\": {e}")))?;
                mesh.materials.iter().copied().max().unwrap_or(0)
            }
        };
        slots.insert(object.geometry_id(), largest);
        let count = object.materials.len().max(1);
        if largest as usize >= count {
            let found = mesh.materials.iter().enumerate().find(|&(_, &slot)| slot as usize >= count);
            let (face, slot) = found.map_or((0, largest), |(face, &slot)| (face, slot));
            return Err(Error::Invalid(format!(
                "face {face} of \"{name}\" has material slot {slot} of only {count}"
            )));
        }
        Ok(())
    }
}

fn undefined(name: &str) -> Error {
    Error::Invalid(format!("there is no definition \"{name}\""))
}
