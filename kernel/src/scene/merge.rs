//! Two scenes in one.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use super::{Definition, Geometry, Object, Scene};
use crate::error::Result;
use crate::material::{Image, Material};
use crate::named::{NamedList, unique_name};
use crate::unit::Up;

/// What a scene took over from another one, and under which names.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Merged {
    /// Objects whose names were taken: as they were called, and as they are called now.
    pub objects: Vec<(String, String)>,
    /// Definitions, materials and pictures of which there were others by the same name: what they are, and both names.
    pub others: Vec<(&'static str, String, String)>,
    /// Layers of which both scenes say something else: the first scene's word holds.
    pub layers: Vec<String>,
    /// Which of the units is unknown where the other is not, so that numbers stayed as they are.
    pub without_unit: Option<Side>,
    /// The axis that is up in the other scene and that which is up in this one, where all was turned because they differ.
    pub turned: Option<[Up; 2]>,
}

/// One of the two scenes of a merge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The one that takes over what the other holds.
    First,
    /// The one that is taken over.
    Other,
}

impl Scene {
    /// Takes over everything that another scene holds, in this scene's unit and with its axis up
    /// ([`converted`](Self::converted)).
    ///
    /// An object whose name is taken gets another one ([`unique_name`](Self::unique_name)) and keeps the old as its label.
    /// Materials and pictures that are the same in both are one; those that only share a name, and definitions that do,
    /// are renamed. Layers of one name are one. `O(objects + points)`; geometry is shared where unit and axis are the same.
    ///
    /// # Errors
    /// When the other scene is not sound ([`check`](Self::check)), or a coordinate overflows in this scene's unit; this
    /// scene stays as it was.
    pub fn merge(&mut self, other: &Self) -> Result<Merged> {
        other.check()?;
        let without_unit = match (self.unit.metres(), other.unit.metres()) {
            (None, Some(_)) => Some(Side::First),
            (Some(_), None) => Some(Side::Other),
            _ => None,
        };
        let turned = (self.up != other.up).then_some([other.up, self.up]);
        let mut told = Merged { without_unit, turned, ..Merged::default() };
        let other = other.converted(self.unit, self.up)?;
        let mut scene = self.clone();
        for layer in &other.layers {
            match scene.layers.get(layer.name()) {
                None => drop(scene.layers.add(layer.clone())?),
                Some(own) if own == layer => {}
                Some(_) => told.layers.push(layer.name().to_owned()),
            }
        }
        let images = scene.take_images(&other.images, &mut told)?;
        let materials = scene.take_materials(&other.materials, &images, &mut told)?;
        let mut definitions = HashMap::new();
        let mut taken: HashSet<String> = scene.definitions().iter().map(|d| d.name().to_owned()).collect();
        for definition in other.definitions() {
            let name = unique_name(definition.name(), "definition", |name| taken.contains(name));
            taken.insert(name.clone());
            told.rename("definition", definition.name(), &name);
            definitions.insert(definition.name().to_owned(), name);
        }
        let mapped = |object: &Object, name: &str, parents: &HashMap<String, String>| {
            let mut new = object.renamed(name);
            if name != object.name() || object.label.is_some() {
                new = new.labelled(object.label());
            }
            new.parent = object.parent.as_ref().map(|p| parents.get(p).unwrap_or(p).clone());
            for material in &mut new.materials {
                if let Some(now) = materials.get(material) {
                    material.clone_from(now);
                }
            }
            if let Geometry::Instance(of) = object.geometry()
                && let Some(now) = definitions.get(of).filter(|now| *now != of)
            {
                new.share_geometry(Arc::new(Geometry::Instance(now.clone())));
            }
            new
        };
        let same = HashMap::new();
        // What one shows comes before it.
        for definition in in_order(&other) {
            let name = definitions.get(definition.name()).map_or(definition.name(), String::as_str);
            let mut new = Definition::new(name);
            new.statements.clone_from(&definition.statements);
            for object in definition.objects() {
                new.add(mapped(object, object.name(), &same))?;
            }
            scene.define(new)?;
        }
        let mut names = HashMap::new();
        let mut taken: HashSet<String> = HashSet::new();
        for object in other.objects() {
            let is_taken = |name: &str| scene.get(name).is_some() || taken.contains(name);
            let name = unique_name(object.name(), "object", is_taken);
            taken.insert(name.clone());
            if name != object.name() {
                told.objects.push((object.name().to_owned(), name.clone()));
            }
            names.insert(object.name().to_owned(), name);
        }
        for object in other.objects() {
            let name = names.get(object.name()).map_or(object.name(), String::as_str);
            scene.add(mapped(object, name, &names))?;
        }
        for connection in other.connections() {
            let mut connection = connection.clone();
            for side in [&mut connection.first, &mut connection.second] {
                if let Some(now) = names.get(&side.object) {
                    side.object.clone_from(now);
                }
            }
            scene.connect(connection)?;
        }
        for (heading, text) in &other.statements {
            if scene.statement(heading).is_none() {
                scene.statements.push((heading.clone(), text.clone()));
            }
        }
        *self = scene;
        Ok(told)
    }

    fn take_images(
        &mut self,
        images: &NamedList<Image>,
        told: &mut Merged,
    ) -> Result<HashMap<String, String>> {
        let mut names = HashMap::new();
        for image in images {
            let name = crate::named::Named::name(image);
            let mut new = name.to_owned();
            if self.images.get(name) != Some(image) {
                new = self.images.unique_name(name);
                told.rename("picture", name, &new);
                self.images.add(Image::new(&new, image.data.clone()))?;
            }
            names.insert(name.to_owned(), new);
        }
        Ok(names)
    }

    fn take_materials(
        &mut self,
        materials: &NamedList<Material>,
        images: &HashMap<String, String>,
        told: &mut Merged,
    ) -> Result<HashMap<String, String>> {
        let mut names = HashMap::new();
        for material in materials {
            let name = crate::named::Named::name(material);
            let mut material = material.clone();
            for texture in material.textures.values_mut() {
                if let Some(now) = images.get(&texture.image) {
                    texture.image.clone_from(now);
                }
            }
            let mut new = name.to_owned();
            if self.materials.get(name) != Some(&material) {
                new = self.materials.unique_name(name);
                told.rename("material", name, &new);
                self.materials.add(material.renamed(&new))?;
            }
            names.insert(name.to_owned(), new);
        }
        Ok(names)
    }
}

impl Merged {
    fn rename(&mut self, what: &'static str, old: &str, new: &str) {
        if old != new {
            self.others.push((what, old.to_owned(), new.to_owned()));
        }
    }

    /// What there is to say, for reports; so many names at most are told one by one. Where a unit is missing, `remedy` is what to do.
    pub fn notes(&self, remedy: impl FnOnce(Side) -> &'static str) -> Vec<String> {
        const TOLD: usize = 5;
        let mut notes = Vec::new();
        let mut renamed = |what: &str, pairs: Vec<(&String, &String)>| {
            for (old, new) in pairs.iter().take(TOLD) {
                notes.push(format!("the {what} \"{old}\" is \"{new}\" here: its name was taken"));
            }
            if pairs.len() > TOLD {
                notes.push(format!("… and {} more of which names were taken", pairs.len() - TOLD));
            }
        };
        renamed("object", self.objects.iter().map(|(old, new)| (old, new)).collect());
        for what in ["definition", "material", "picture"] {
            let of_kind = self.others.iter().filter(|(kind, ..)| *kind == what);
            renamed(what, of_kind.map(|(_, old, new)| (old, new)).collect());
        }
        for layer in &self.layers {
            notes.push(format!(
                "the layer \"{layer}\" is in both files: colour and visibility are the first one's"
            ));
        }
        if let Some(axes) = self.turned {
            let [there, here] = axes.map(|up| up.name());
            notes.push(format!("turned: {there} is up in the file, and {here} here"));
        }
        if let Some(side) = self.without_unit {
            let whose = match side {
                Side::First => "what was there before",
                Side::Other => "the file",
            };
            let remedy = remedy(side);
            notes.push(format!("{whose} has no unit: the numbers of both are taken as they are; {remedy}"));
        }
        notes
    }
}

/// The definitions of a scene, those that others show before these.
fn in_order(scene: &Scene) -> Vec<&Definition> {
    let mut done: HashSet<&str> = HashSet::new();
    let mut order = Vec::new();
    for definition in scene.definitions() {
        let mut stack = vec![(definition, false)];
        while let Some((definition, entered)) = stack.pop() {
            if entered {
                order.push(definition);
                continue;
            }
            if !done.insert(definition.name()) {
                continue;
            }
            stack.push((definition, true));
            for object in definition.objects() {
                if let Geometry::Instance(of) = object.geometry()
                    && let Some(shown) = scene.definitions().get(of)
                {
                    stack.push((shown, false));
                }
            }
        }
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Point;
    use crate::conformance::{sample_assembly, sample_scene};
    use crate::mesh::Cloud;
    use crate::scene::{Layer, Unit};

    #[test]
    fn a_scene_taken_twice_is_there_twice() {
        for sample in [sample_scene(), sample_assembly()] {
            let mut scene = sample.clone();
            let told = scene.merge(&sample).unwrap();
            scene.check().unwrap();
            let count = sample.objects().len();
            assert_eq!(scene.objects().len(), 2 * count);
            assert_eq!(told.objects.len(), count);
            assert_eq!(scene.materials.len(), sample.materials.len(), "the same materials are one");
            for (first, second) in scene.objects()[..count].iter().zip(&scene.objects()[count..]) {
                assert_eq!(second.label(), first.label());
                assert!(second.name().starts_with(first.name()));
                if let Some(parent) = &first.parent {
                    assert_eq!(second.parent.as_deref(), Some(format!("{parent}.001").as_str()));
                }
            }
            assert_eq!(scene.placed_count().unwrap(), 2 * sample.placed_count().unwrap());
            assert!(!told.notes(|_| "").is_empty());
        }
    }

    #[test]
    fn units_and_axes_become_the_first_ones() {
        let mut first = Scene::new();
        let mut second = Scene::new();
        (second.unit, second.up) = (Unit::Millimetre, Up::Y);
        let cloud = Cloud { points: vec![Point::new(1000.0, 2000.0, 3000.0)] };
        second.add(Object::new("cloud", cloud.into())).unwrap();
        let told = first.merge(&second).unwrap();
        assert_eq!(first.object("cloud").unwrap().geometry().points()[0], Point::new(1.0, -3.0, 2.0));
        assert_eq!(told, Merged { turned: Some([Up::Y, Up::Z]), ..Merged::default() });
        assert_eq!(told.notes(|_| ""), ["turned: y is up in the file, and z here"]);
        second.unit = Unit::Unknown;
        let told = first.merge(&second).unwrap();
        assert_eq!(told.without_unit, Some(Side::Other));
        let notes = told.notes(|side| if side == Side::Other { "say it" } else { "not this" });
        assert!(
            notes.iter().any(|note| note.starts_with("the file has no unit") && note.ends_with("; say it"))
        );
        second.unit = Unit::Metre;
        first.unit = Unit::Unknown;
        assert_eq!(first.merge(&second).unwrap().without_unit, Some(Side::First));
    }

    #[test]
    fn what_only_shares_a_name_is_renamed() {
        let with = |color: f64| {
            let mut scene = Scene::new();
            scene.materials.add(Material::new("paint", [color, 0.0, 0.0, 1.0])).unwrap();
            scene.layers.add(Layer::new("frames").colored([color, 0.0, 0.0, 1.0])).unwrap();
            let mut object = Object::new("cloud", Cloud { points: vec![Point::origin()] }.into());
            object.materials.push("paint".into());
            scene.add(object).unwrap();
            scene
        };
        let mut scene = with(0.5);
        let told = scene.merge(&with(0.75)).unwrap();
        assert_eq!(told.others, [("material", "paint".to_owned(), "paint.001".to_owned())]);
        assert_eq!(told.layers, ["frames"]);
        assert_eq!(scene.object("cloud.001").unwrap().materials, ["paint.001"]);
        assert_eq!(scene.layers.get("frames").unwrap().color, Some([0.5, 0.0, 0.0, 1.0]));
    }
}
