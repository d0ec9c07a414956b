//! A scene: named objects with units, an up axis, colours, layers and a hierarchy.

mod geometry;
mod object;

use std::collections::HashMap;
use std::sync::Arc;

use crate::Point;
use crate::connection::Connection;
use crate::error::{Error, Result};
use crate::material::{Image, Material};
use crate::named::{Named, NamedList};
use crate::spline::{Curve, Surface};

pub use self::geometry::Geometry;
pub use self::object::Object;
pub use crate::animation::Animation;
pub use crate::unit::{Unit, Up};

/// Named objects, their unit and their up axis.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scene {
    /// The unit of all lengths.
    pub unit: Unit,
    /// The axis that points up.
    pub up: Up,
    /// The materials that objects name.
    pub materials: NamedList<Material>,
    /// The pictures that materials' textures name.
    pub images: NamedList<Image>,
    /// What a format said of the whole beyond all this, word for word, for the same format.
    pub statements: Vec<(String, String)>,
    objects: Vec<Object>,
    connections: Vec<Connection>,
    index: HashMap<String, usize>,
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
        &self.objects
    }

    /// The object of a name, if there is one.
    pub fn get(&self, name: &str) -> Option<&Object> {
        self.index.get(name).map(|&i| &self.objects[i])
    }

    /// Where among the [`objects`](Self::objects) the one of a name is.
    pub fn position(&self, name: &str) -> Option<usize> {
        self.index.get(name).copied()
    }

    /// The object of a name.
    ///
    /// # Errors
    /// When there is none; the error lists the nearest name that there is.
    pub fn object(&self, name: &str) -> Result<&Object> {
        self.get(name).ok_or_else(|| self.missing(name))
    }

    /// The object of a name, to be changed.
    ///
    /// # Errors
    /// As for [`object`](Self::object).
    pub fn object_mut(&mut self, name: &str) -> Result<&mut Object> {
        match self.index.get(name) {
            Some(&i) => Ok(&mut self.objects[i]),
            None => Err(self.missing(name)),
        }
    }

    /// The curve of a name.
    ///
    /// # Errors
    /// When there is no such object or it is not a curve.
    pub fn curve(&self, name: &str) -> Result<&Curve> {
        match self.object(name)?.geometry() {
            Geometry::Curve(curve) => Ok(curve),
            other => Err(Error::Invalid(format!("\"{name}\" is a {}, not a curve", other.kind()))),
        }
    }

    /// The surface of a name.
    ///
    /// # Errors
    /// When there is no such object or it is not a surface.
    pub fn surface(&self, name: &str) -> Result<&Surface> {
        match self.object(name)?.geometry() {
            Geometry::Surface(surface) => Ok(surface),
            other => Err(Error::Invalid(format!("\"{name}\" is a {}, not a surface", other.kind()))),
        }
    }

    /// Adds an object at the end.
    ///
    /// # Errors
    /// When its name is empty or taken; use [`unique_name`](Self::unique_name) for names from elsewhere.
    pub fn add(&mut self, object: Object) -> Result<()> {
        if object.name.is_empty() {
            return Err(Error::Invalid("an object has an empty name: give it one".into()));
        }
        if self.index.contains_key(&object.name) {
            let name = &object.name;
            return Err(Error::Invalid(format!("two objects are named \"{name}\": rename one")));
        }
        self.index.insert(object.name.clone(), self.objects.len());
        self.objects.push(object);
        Ok(())
    }

    /// Gives an object another name; what hangs under it follows.
    ///
    /// # Errors
    /// When there is no such object, or the new name is empty or taken.
    pub fn rename(&mut self, name: &str, new: &str) -> Result<()> {
        let Some(&at) = self.index.get(name) else { return Err(self.missing(name)) };
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
        new.clone_into(&mut self.objects[at].name);
        for object in &mut self.objects {
            if object.parent.as_deref() == Some(name) {
                object.parent = Some(new.to_owned());
            }
        }
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
        if !self.index.contains_key(name) {
            return Err(self.missing(name));
        }
        self.retain(|object| object.name() != name).pop().ok_or_else(|| self.missing(name))
    }

    /// Takes all objects out that are not to be kept, and their connections, and gives them in their order. What hung
    /// under one of them hangs under the next object up that was kept. `O(objects)`, however many go.
    pub fn retain(&mut self, keep: impl Fn(&Object) -> bool) -> Vec<Object> {
        let (kept, gone): (Vec<_>, Vec<_>) = std::mem::take(&mut self.objects).into_iter().partition(keep);
        self.objects = kept;
        if gone.is_empty() {
            return gone;
        }
        self.index = self.objects.iter().enumerate().map(|(i, o)| (o.name.clone(), i)).collect();
        let mut above: HashMap<&str, Option<&str>> =
            gone.iter().map(|o| (o.name.as_str(), o.parent.as_deref())).collect();
        for object in &mut self.objects {
            let parent = object.parent.as_deref().and_then(|parent| above.get_key_value(parent));
            if let Some((&parent, _)) = parent {
                object.parent = first_kept(parent, &mut above).map(str::to_owned);
            }
        }
        self.connections.retain(|c| c.sides().iter().all(|side| !above.contains_key(side.object.as_str())));
        gone
    }

    /// `wanted` itself if it is free, or with `.001`, `.002`, … behind it; `"object"` for an empty one.
    pub fn unique_name(&self, wanted: &str) -> String {
        crate::named::unique_name(wanted, "object", |name| self.index.contains_key(name))
    }

    /// The corners of the axis-parallel box around all points that objects are kept as (control vertices
    /// included), in each object's own coordinates; `None` for an empty scene.
    pub fn bounds(&self) -> Option<(Point, Point)> {
        let mut points = self.objects.iter().flat_map(|o| o.geometry().points());
        let first = *points.next()?;
        Some(points.fold((first, first), |(low, high), p| (low.inf(p), high.sup(p))))
    }

    /// Checks what objects name: every parent, material and picture exists, meshes pass their own
    /// [`check`](Mesh::check), connections are between surfaces, and no object hangs under itself, however far up.
    ///
    /// # Errors
    /// With the names of the objects at fault.
    pub fn check(&self) -> Result<()> {
        self.check_hierarchy()?;
        self.check_contents()
    }

    /// Checks that every parent exists and no object hangs under itself, however far up. `O(objects)`.
    ///
    /// # Errors
    /// With the names of the objects at fault.
    pub fn check_hierarchy(&self) -> Result<()> {
        // 0: not seen, 1: on the way up from where we started, 2: known to reach a root.
        let mut state = vec![0_u8; self.objects.len()];
        for start in 0..self.objects.len() {
            let mut path = Vec::new();
            let mut at = start;
            while state[at] != 2 {
                if state[at] == 1 {
                    let name = &self.objects[at].name;
                    return Err(Error::Invalid(format!(
                        "the hierarchy is cyclic: \"{name}\" hangs under itself; take one parent away"
                    )));
                }
                state[at] = 1;
                path.push(at);
                let Some(parent) = &self.objects[at].parent else { break };
                at = *self.index.get(parent).ok_or_else(|| {
                    let name = &self.objects[at].name;
                    Error::Invalid(format!("the parent \"{parent}\" of \"{name}\" does not exist"))
                })?;
            }
            for i in path {
                state[i] = 2;
            }
        }
        self.connections.iter().try_for_each(|connection| connection.check(self))
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
        for object in &self.objects {
            let name = &object.name;
            if let Some(missing) = object.materials.iter().find(|m| self.materials.get(m).is_none()) {
                let problem = format!("the material \"{missing}\" of \"{name}\" does not exist");
                return Err(Error::Invalid(problem));
            }
            if let Geometry::Mesh(mesh) = object.geometry() {
                mesh.check().map_err(|e| Error::Invalid(format!("\"{name}\": {e}")))?;
                let slots = object.materials.len().max(1);
                if let Some((face, slot)) =
                    mesh.materials.iter().enumerate().find(|&(_, &s)| s as usize >= slots)
                {
                    let problem =
                        format!("face {face} of \"{name}\" has material slot {slot} of only {slots}");
                    return Err(Error::Invalid(problem));
                }
            }
        }
        Ok(())
    }

    fn missing(&self, name: &str) -> Error {
        let names = self.objects.iter().map(|o| o.name.as_str());
        let hint = match crate::plugin::nearest(name, names) {
            Some(near) => format!("; did you mean \"{near}\"?"),
            None if self.objects.is_empty() => "; the scene is empty".to_owned(),
            None => {
                let some: Vec<_> = self.objects.iter().take(8).map(|o| format!("\"{}\"", o.name)).collect();
                let more = if self.objects.len() > 8 { ", …" } else { "" };
                format!("; there are {}{more}", some.join(", "))
            }
        };
        Error::Invalid(format!("there is no object \"{name}\"{hint}"))
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
