//! Objects of definitions as an instance shows them: found by their path, edited in the scene, and put back.

use std::collections::{HashMap, HashSet};

use nalgebra::Matrix4;

use super::definition::instance;
use super::list::{Objects, after};
use super::{Definition, Geometry, Object, Scene};
use crate::error::{Error, Result};

/// An object of a definition, and the instances by which it is shown.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Within {
    /// The path that leads there, `instance/object`: its name in a [flat](Scene::flattened) scene.
    pub path: String,
    /// The names of the instances, from the scene inwards.
    pub instances: Vec<String>,
    /// The definition.
    pub definition: String,
    /// Its object.
    pub object: String,
}

impl Scene {
    /// The object of a definition that a path `instance/object` leads to, through as many instances as it names.
    /// `O(objects)` for each character of the path at most.
    pub fn within(&self, path: &str) -> Option<Within> {
        // Names may have strokes themselves: each place in the path at which a definition was entered is tried once.
        let mut tried: HashSet<(&str, usize)> = HashSet::new();
        let mut open: Vec<(Option<&Definition>, &str, Vec<&str>)> = vec![(None, path, Vec::new())];
        while let Some((definition, rest, way)) = open.pop() {
            let list = definition.map_or(self.objects(), Definition::objects);
            if let Some((definition, object)) = definition.and_then(|d| Some((d, d.get(rest)?))) {
                return Some(Within {
                    path: path.to_owned(),
                    instances: way.into_iter().map(str::to_owned).collect(),
                    definition: definition.name().to_owned(),
                    object: object.name().to_owned(),
                });
            }
            for object in list.iter().rev() {
                let Some(shown) = instance(object).and_then(|name| self.definitions.get(name)) else {
                    continue;
                };
                let below = rest.strip_prefix(object.name()).and_then(|rest| rest.strip_prefix('/'));
                if let Some(below) = below.filter(|below| tried.insert((shown.name(), below.len()))) {
                    let way = way.iter().copied().chain([object.name()]).collect();
                    open.push((Some(shown), below, way));
                }
            }
        }
        None
    }

    /// The object of a name: one of the scene, or one of a definition by its [path](Self::within).
    pub fn find(&self, name: &str) -> Option<&Object> {
        self.get(name).or_else(|| {
            let within = self.within(name)?;
            self.definitions.get(&within.definition)?.get(&within.object)
        })
    }

    /// How often each definition is shown, all instances of instances counted; at most `u64::MAX`. `O(objects)`.
    ///
    /// # Errors
    /// As for [`check_definitions`](Self::check_definitions).
    pub fn times_shown(&self) -> Result<HashMap<&str, u64>> {
        self.check_definitions()?;
        let position = |object: &Object| self.definitions.position(instance(object)?);
        let count = self.definitions.len();
        let (mut times, mut left) = (vec![0_u64; count], vec![0_usize; count]);
        for at in self.objects().iter().filter_map(position) {
            times[at] = times[at].saturating_add(1);
        }
        let lists: Vec<Vec<usize>> =
            self.definitions.iter().map(|d| d.objects().iter().filter_map(position).collect()).collect();
        lists.iter().flatten().for_each(|&at| left[at] += 1);
        // What nobody shows any more is known.
        let mut known: Vec<usize> = (0..count).filter(|&at| left[at] == 0).collect();
        while let Some(at) = known.pop() {
            for &shown in &lists[at] {
                times[shown] = times[shown].saturating_add(times[at]);
                left[shown] -= 1;
                if left[shown] == 0 {
                    known.push(shown);
                }
            }
        }
        Ok(self.definitions.iter().map(Definition::name).zip(times).collect())
    }

    /// Makes an object of a definition one of its own, shown by these instances and no others: each definition on the way that
    /// is shown more than once is copied (`wheel` to `wheel.001`), and the instance on the way shows the copy. Geometry is
    /// shared until it is changed. Gives where the object is then.
    ///
    /// # Errors
    /// When there is no such object, or the definitions are unsound.
    pub fn make_unique(&mut self, within: &Within) -> Result<Within> {
        let mut unique = within.clone();
        let mut above: Option<String> = None;
        for name in &within.instances {
            let list = self.list_of(above.as_deref())?;
            let shows = instance(list.object(name)?).map(str::to_owned);
            let shown = shows.ok_or_else(|| Error::Invalid(format!("\"{name}\" is no instance")))?;
            let often = self.times_shown()?.get(shown.as_str()).copied().unwrap_or_default();
            let mut own = shown.clone();
            if often > 1 {
                own = self.definitions.unique_name(&shown);
                let copy = self.definition(&shown)?.clone().named(own.as_str());
                self.define(copy)?;
                let geometry = Geometry::Instance(own.clone());
                match &above {
                    None => self.list.object_mut(name)?.set_geometry(geometry),
                    Some(above) => self.definition_mut(above)?.object_mut(name)?.set_geometry(geometry),
                }
            }
            above = Some(own);
        }
        unique.definition = above.unwrap_or_default();
        self.definition(&unique.definition)?.object(&unique.object)?;
        Ok(unique)
    }

    /// Puts an object of a definition among those of the scene, by its path and where it is in the world, so that it can be
    /// worked on as they are. [`put_back`](Self::put_back) takes it out again.
    ///
    /// # Errors
    /// When there is no such object, it has no shape, its path is taken, or the hierarchy is broken.
    pub fn lift(&mut self, within: &Within) -> Result<()> {
        self.check_hierarchy()?;
        let mut map: Option<Matrix4<f64>> = None;
        let mut above: Option<&str> = None;
        for name in &within.instances {
            let list = self.list_of(above)?;
            map = after(map, self.map_in(list, name)?);
            let shown = instance(list.object(name)?);
            above = Some(shown.ok_or_else(|| Error::Invalid(format!("\"{name}\" is no instance")))?);
        }
        let list = self.list_of(Some(&within.definition))?;
        let object = list.object(&within.object)?;
        if matches!(object.geometry(), Geometry::Group | Geometry::Instance(_)) {
            let kind = crate::text::a(&object.geometry().noun());
            return Err(Error::Invalid(format!(
                "\"{}\" is {kind} of the definition \"{}\", not a shape",
                within.path, within.definition
            )));
        }
        let mut lifted = object.renamed(within.path.as_str());
        lifted.transform = after(map, self.map_in(list, &within.object)?);
        lifted.parent = None;
        self.add(lifted)
    }

    /// Takes an object that was [lifted](Self::lift) out of the scene again, and gives its geometry and its animation to the
    /// object of the definition.
    ///
    /// # Errors
    /// When it is not there any more, or no shape any more.
    pub fn put_back(&mut self, within: &Within) -> Result<()> {
        let (path, definition) = (&within.path, &within.definition);
        let gone = || {
            Error::Invalid(format!(
                "\"{path}\" is an object of the definition \"{definition}\": its shape can be changed there, but it cannot be \
                 taken out or named anew"
            ))
        };
        let changed = self.get(path).ok_or_else(gone)?.clone();
        // First there, so that nothing is lost where that fails.
        let object = self.definition_mut(definition)?.object_mut(&within.object)?;
        object.share_geometry(changed.shared_geometry().clone());
        object.animation = changed.animation;
        self.remove(path).map(drop)
    }

    fn list_of(&self, definition: Option<&str>) -> Result<&Objects> {
        Ok(match definition {
            None => &self.list,
            Some(name) => &self.definition(name)?.list,
        })
    }

    /// The map from an object into the coordinates of its list; the hierarchy must have been checked.
    fn map_in(&self, list: &Objects, name: &str) -> Result<Option<Matrix4<f64>>> {
        let mut map = None;
        let mut at = Some(list.object(name)?);
        while let Some(object) = at {
            map = after(object.transform, map);
            at = object.parent.as_deref().and_then(|parent| list.get(parent));
        }
        Ok(map)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Cloud;
    use crate::scene::placement::transform_point;
    use crate::{Point, Vector};

    fn shows(name: &str, of: &str, x: f64) -> Object {
        let mut object = Object::new(name, Geometry::Instance(of.into()));
        object.transform = Some(Matrix4::new_translation(&Vector::new(x, 0.0, 0.0)));
        object
    }

    fn dot(name: &str) -> Object {
        Object::new(name, Cloud { points: vec![Point::origin()] }.into())
    }

    /// Two wheels of two bolts; names with strokes.
    fn scene() -> Scene {
        let mut scene = Scene::new();
        let mut wheel = Definition::new("wheel");
        wheel.add(shows("bolt", "bolt", 1.0)).unwrap();
        wheel.add(shows("bolt/2", "bolt", 2.0)).unwrap();
        let mut rim = dot("rim");
        rim.parent = Some("bolt".into());
        wheel.add(rim).unwrap();
        scene.define(wheel).unwrap();
        let mut bolt = Definition::new("bolt");
        bolt.add(dot("head")).unwrap();
        bolt.add(dot("2/head")).unwrap();
        scene.define(bolt).unwrap();
        scene.add(shows("left", "wheel", 10.0)).unwrap();
        scene.add(shows("right", "wheel", 20.0)).unwrap();
        scene.check().unwrap();
        scene
    }

    /// The first point of each shape that is shown, by its path.
    fn points(scene: &Scene) -> Vec<(String, f64)> {
        let shapes = scene.placed(1000).unwrap().filter(|p| !p.object.geometry().points().is_empty());
        shapes
            .map(|p| {
                let map = p.to_world.unwrap_or_else(Matrix4::identity);
                let at = transform_point(&map, &p.object.geometry().points()[0]);
                (format!("{}/{}", p.path, p.object.name()), at.x)
            })
            .collect()
    }

    fn change(scene: &mut Scene, within: &Within) {
        scene.lift(within).unwrap();
        scene.check().unwrap();
        let Geometry::Cloud(cloud) = scene.object_mut(&within.path).unwrap().geometry_mut() else { panic!() };
        cloud.points[0].x += 0.5;
        scene.put_back(within).unwrap();
        scene.check().unwrap();
    }

    #[test]
    fn every_path_of_a_flat_scene_leads_to_its_object() {
        let scene = scene();
        for placed in scene.placed(1000).unwrap().filter(|p| p.path.depth() > 0) {
            let path = format!("{}/{}", placed.path, placed.object.name());
            let within = scene.within(&path).unwrap();
            // "left/bolt/2/head" is two: the first in the list of the wheel.
            if path.ends_with("bolt/2/head") {
                assert_eq!((within.instances.len(), within.object.as_str()), (2, "2/head"));
                continue;
            }
            let names: Vec<_> = placed.path.inside_out().map(|o| o.name().to_owned()).collect();
            assert_eq!(within.instances.iter().rev().cloned().collect::<Vec<_>>(), names);
            assert_eq!(within.object, placed.object.name());
            assert!(scene.find(&path).is_some_and(|object| object.name() == placed.object.name()));
        }
        for wrong in ["", "/", "left", "left/", "left/rom", "wheel/rim", "left/bolt/", "left//rim"] {
            assert_eq!(scene.within(wrong), None, "{wrong}");
        }
        let times = scene.times_shown().unwrap();
        assert_eq!((times["wheel"], times["bolt"]), (2, 4));
    }

    #[test]
    fn a_change_of_one_is_a_change_of_all_unless_it_is_made_unique() {
        for path in ["left/rim", "right/bolt/head"] {
            let mut all = scene();
            let within = all.within(path).unwrap();
            let before = points(&all);
            change(&mut all, &within);
            let moved = |scene: &Scene| -> Vec<String> {
                let now = points(scene);
                assert_eq!(now.len(), before.len());
                let pairs = before.iter().zip(now);
                pairs.filter(|(a, b)| **a != *b).map(|(_, (name, _))| name).collect()
            };
            assert_eq!(moved(&all).len(), if path == "left/rim" { 2 } else { 4 });
            let mut one = scene();
            let within = one.within(path).unwrap();
            let unique = one.make_unique(&within).unwrap();
            assert_eq!(points(&one), before);
            assert_eq!(one.times_shown().unwrap()[unique.definition.as_str()], 1);
            assert_eq!(one.within(path).unwrap(), unique);
            change(&mut one, &unique);
            assert_eq!(moved(&one), [path]);
            // Unique already: nothing is copied.
            let count = one.definitions().len();
            assert_eq!(one.make_unique(&unique).unwrap(), unique);
            assert_eq!(one.definitions().len(), count);
        }
    }

    #[test]
    fn what_is_lifted_is_where_it_was_and_must_be_there_to_be_put_back() {
        let mut scene = scene();
        let within = scene.within("right/rim").unwrap();
        scene.lift(&within).unwrap();
        let lifted = scene.object("right/rim").unwrap();
        assert_eq!(lifted.transform.unwrap()[(0, 3)], 21.0);
        assert!(scene.lift(&within).is_err());
        scene.remove("right/rim").unwrap();
        let said = scene.put_back(&within).unwrap_err().to_string();
        assert!(said.contains("the definition \"wheel\"") && said.contains("taken out"), "{said}");
        let instance = scene.within("right/bolt").unwrap();
        assert!(scene.lift(&instance).unwrap_err().to_string().contains("not a shape"));
    }

    #[test]
    fn paths_that_could_mean_millions_are_found_out_soon() {
        let mut scene = Scene::new();
        for k in 0..30 {
            let mut definition = Definition::new(format!("{k}"));
            for name in ["a", "a/a", "a/a/a"] {
                definition.add(shows(name, &format!("{}", (k + 1).min(29)), 0.0)).unwrap();
            }
            if k == 29 {
                definition = Definition::new("29");
                definition.add(dot("end")).unwrap();
            }
            scene.define(definition).unwrap();
        }
        scene.add(shows("a", "0", 0.0)).unwrap();
        assert_eq!(scene.within(&"a/".repeat(60)), None);
        assert!(scene.within(&format!("{}end", "a/".repeat(45))).is_some());
        assert_eq!(scene.times_shown().unwrap()["29"], 3_u64.pow(29));
    }
}
