//! Everything that a scene shows, instance by instance, where it is in the world.

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::fmt;
use std::sync::Arc;

use nalgebra::Matrix4;

use super::definition::{Sound, instance, transforms};
use super::list::{Objects, after};
use super::{Definition, Geometry, Hidden, Object, Scene};
use crate::error::{Error, Result};

/// How many objects formats place at most that have no instances and write what each of them shows.
pub const MOST_PLACED: u64 = 1_000_000;

/// How many bytes of names, statements and frames an object of a flat scene may take beside its geometry, on average.
const COPIED: u64 = 1024;

/// How many bytes of an object are not shared between those that show it.
fn copied(object: &Object) -> u64 {
    let points = object.animation.iter().flat_map(|a| &a.frames).map(Vec::len).sum::<usize>();
    let texts = texts(&object.statements);
    let names = object.materials.iter().map(String::len).sum::<usize>();
    (object.name().len() + names + texts + points * size_of::<crate::Point>()) as u64
}

fn texts(statements: &[(String, String)]) -> usize {
    statements.iter().map(|(key, text)| key.len() + text.len()).sum()
}

/// The instances by which an object is shown, from the scene inwards: none for an object of the scene itself. A copy costs
/// nothing, however deep it is.
#[derive(Clone, Default)]
pub struct Path<'a>(Option<Arc<Step<'a>>>);

struct Step<'a> {
    instance: &'a Object,
    above: Path<'a>,
    depth: usize,
}

impl<'a> Path<'a> {
    /// How many instances there are on the way.
    pub fn depth(&self) -> usize {
        self.0.as_ref().map_or(0, |step| step.depth)
    }

    /// The instances, the innermost first.
    pub fn inside_out(&self) -> impl Iterator<Item = &'a Object> + '_ {
        std::iter::successors(self.0.as_deref(), |step| step.above.0.as_deref()).map(|step| step.instance)
    }

    fn within(&self, instance: &'a Object) -> Self {
        Self(Some(Arc::new(Step { instance, above: self.clone(), depth: self.depth() + 1 })))
    }
}

impl fmt::Debug for Path<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}", self.to_string())
    }
}

impl fmt::Display for Path<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut names: Vec<&str> = self.inside_out().map(Object::name).collect();
        names.reverse();
        f.write_str(&names.join("/"))
    }
}

/// One step after the other: a path may be longer than a stack is deep.
impl Drop for Step<'_> {
    fn drop(&mut self) {
        let mut next = self.above.0.take();
        while let Some(mut step) = next.and_then(Arc::into_inner) {
            next = step.above.0.take();
        }
    }
}

/// An object as it is shown once.
#[derive(Debug, Clone)]
pub struct Placed<'a> {
    /// The object: of the scene, or of a definition.
    pub object: &'a Object,
    /// From the object's coordinates to the scene's; `None` where they are the same.
    pub to_world: Option<Matrix4<f64>>,
    /// The instances by which it is shown.
    pub path: Path<'a>,
    /// What it is on a layer of.
    layers: Layers<'a>,
}

/// The layers of a scene, and which of them are hidden.
#[derive(Clone)]
struct Layers<'a> {
    scene: &'a Scene,
    hidden: Arc<Hidden<'a>>,
}

impl fmt::Debug for Layers<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.scene.layers.iter()).finish()
    }
}

impl Placed<'_> {
    /// Its colour: its own, or where nothing of its own says how it looks, that of the nearest instance that has one, or else
    /// that of its layer.
    pub fn color(&self) -> Option<[f64; 4]> {
        let by_layer =
            || if self.object.has_look() { None } else { self.layers.scene.layer_color(self.layer()) };
        self.stated_color().or_else(by_layer)
    }

    /// The same, layers aside.
    fn stated_color(&self) -> Option<[f64; 4]> {
        let above = || self.path.inside_out().find_map(|instance| instance.color);
        self.object.color.or_else(|| if self.object.has_look() { None } else { above() })
    }

    /// Its layer: its own, or that of the nearest instance that is on one. Where its own is seen, but an instance on the way
    /// is on a hidden layer, which hides all that it shows: that one.
    pub fn layer(&self) -> Option<&str> {
        let above = || self.path.inside_out().filter_map(|instance| instance.layer.as_deref());
        let hidden = &self.layers.hidden;
        let own = self.object.layer.as_deref();
        if hidden.is_empty() || own.is_some_and(|layer| hidden.contains(layer)) {
            return own.or_else(|| above().next());
        }
        above().find(|layer| hidden.contains(layer)).or(own).or_else(|| above().next())
    }

    /// Whether it is on a hidden layer, or an instance that shows it is.
    pub fn is_hidden(&self) -> bool {
        self.layer().is_some_and(|layer| self.layers.hidden.contains(layer))
    }
}

/// All that a scene shows, made by [`Scene::placed`].
#[derive(Debug)]
pub struct Placements<'a> {
    scene: &'a Scene,
    of_scene: Vec<Option<Matrix4<f64>>>,
    of_definitions: HashMap<&'a str, Vec<Option<Matrix4<f64>>>>,
    open: Vec<Level<'a>>,
    layers: Layers<'a>,
    left: u64,
}

/// A list of objects that is being gone through.
#[derive(Debug)]
struct Level<'a> {
    /// The definition's name; none for the scene itself.
    of: Option<&'a str>,
    list: &'a Objects,
    next: usize,
    above: Option<Matrix4<f64>>,
    path: Path<'a>,
}

impl<'a> Iterator for Placements<'a> {
    type Item = Placed<'a>;

    fn next(&mut self) -> Option<Placed<'a>> {
        loop {
            let level = self.open.last_mut()?;
            let at = level.next;
            let Some(object) = level.list.as_slice().get(at) else {
                self.open.pop();
                continue;
            };
            level.next += 1;
            let own = match level.of {
                None => self.of_scene.get(at),
                Some(name) => self.of_definitions.get(name).and_then(|list| list.get(at)),
            };
            let placed = Placed {
                object,
                to_world: after(level.above, own.copied().flatten()),
                path: level.path.clone(),
                layers: self.layers.clone(),
            };
            if let Some(definition) = self.scene.shown_by(object) {
                self.open.push(Level {
                    of: Some(definition.name()),
                    list: &definition.list,
                    next: 0,
                    above: placed.to_world,
                    path: placed.path.within(object),
                });
            }
            self.left = self.left.saturating_sub(1);
            return Some(placed);
        }
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let left = usize::try_from(self.left).unwrap_or(usize::MAX);
        (left, Some(left))
    }
}

impl Scene {
    /// How many objects the scene shows: its own, and for each instance what it shows, instances of instances too. At
    /// most `u64::MAX`. `O(objects)` of the scene and its definitions, whatever the number.
    ///
    /// # Errors
    /// When a definition does not exist or shows itself.
    pub fn placed_count(&self) -> Result<u64> {
        Ok(Sound::of(self)?.count(self))
    }

    /// Everything that the scene shows, one after the other and nothing kept: each object with its map to the world and the
    /// instances by which it is shown. An instance comes itself, and then what it shows; all else is in the order of the
    /// lists.
    ///
    /// Takes memory for the scene and its definitions, not for what they show, and no stack.
    ///
    /// # Errors
    /// When the hierarchy is broken ([`check_hierarchy`](Self::check_hierarchy)), or there are more than `limit`, instances
    /// included (the error has both numbers): a few definitions that show each other twice are millions.
    pub fn placed(&self, limit: u64) -> Result<Placements<'_>> {
        self.check_hierarchy()?;
        let left = self.placed_count()?;
        if left > limit {
            let count = if left == u64::MAX { "more than 10^19".to_owned() } else { left.to_string() };
            return Err(Error::Invalid(format!(
                "its instances show {count} objects, and at most {limit} are placed one by one: show fewer, or write a \
                 format that has instances"
            )));
        }
        let level = Level { of: None, list: &self.list, next: 0, above: None, path: Path::default() };
        Ok(Placements {
            scene: self,
            of_scene: self.list.transforms(),
            of_definitions: transforms(self),
            open: vec![level],
            layers: Layers { scene: self, hidden: Arc::new(self.hidden_layers()) },
            left,
        })
    }

    /// The definition that an object shows, if it is an instance.
    fn shown_by(&self, object: &Object) -> Option<&Definition> {
        instance(object).and_then(|name| self.definitions.get(name))
    }

    /// The same scene without definitions: each instance is a group, and under it is what it shows, by the name
    /// `instance/object`. Geometry is shared, so that an instance costs no more than its objects' names and transforms. The
    /// scene itself where it has no definitions.
    ///
    /// Colours, as far as layers do not give them, and layers are those of [`Placed`]; what is said of a definition is said of each group.
    ///
    /// # Errors
    /// As for [`placed`](Self::placed); also when names, statements and frames, which are not shared, would take more than
    /// a kilobyte an object.
    pub fn flattened(&self, limit: u64) -> Result<Cow<'_, Self>> {
        if self.definitions.is_empty() {
            return Ok(Cow::Borrowed(self));
        }
        let all: Vec<Placed<'_>> = self.placed(limit)?.collect();
        // The objects of the scene itself keep their names.
        let mut names: HashSet<String> = self.objects().iter().map(|o| o.name().to_owned()).collect();
        let mut named: Vec<String> = Vec::with_capacity(all.len());
        // For each the number of the instance that shows it, and each number by that and the name.
        let mut under: Vec<Option<usize>> = Vec::with_capacity(all.len());
        let mut known: HashMap<(Option<usize>, &str), usize> = HashMap::with_capacity(all.len());
        let mut labels: Vec<Option<String>> = Vec::with_capacity(all.len());
        let mut way: Vec<usize> = Vec::new();
        let mut spent = 0_u64;
        for (number, placed) in all.iter().enumerate() {
            let name = placed.object.name();
            way.truncate(placed.path.depth());
            let shows = way.last().copied();
            named.push(match shows {
                None => name.to_owned(),
                Some(at) => {
                    let wanted = format!("{}/{name}", named[at]);
                    let name = crate::named::unique_name(&wanted, "object", |name| names.contains(name));
                    names.insert(name.clone());
                    name
                }
            });
            let of_definition = self.shown_by(placed.object).map_or(0, |d| texts(&d.statements));
            under.push(shows);
            let label = label(&all, &under, number);
            let taken = (named[number].len() + label.as_ref().map_or(0, String::len) + of_definition) as u64;
            labels.push(label);
            spent = spent.saturating_add(taken).saturating_add(copied(placed.object));
            if spent > limit.saturating_mul(COPIED) {
                return Err(Error::Invalid(format!(
                    "the names, statements and frames of what its instances show are more than {} MB: show fewer, or \
                     write a format that has instances",
                    limit.saturating_mul(COPIED) >> 20
                )));
            }
            known.insert((shows, name), number);
            if instance(placed.object).is_some() {
                way.push(number);
            }
        }
        let mut scene = self.around();
        let group = Arc::new(Geometry::Group);
        for (number, placed) in all.iter().enumerate() {
            let is_instance = instance(placed.object).is_some();
            let geometry = if is_instance { &group } else { placed.object.shared_geometry() };
            let mut object = placed.object.renamed(named[number].as_str());
            if let Some(label) = &labels[number] {
                object = object.labelled(label);
            }
            object.share_geometry(Arc::clone(geometry));
            if let Some(definition) = self.shown_by(placed.object) {
                object.statements.extend(definition.statements.iter().cloned());
            }
            object.color = if is_instance { object.color } else { placed.stated_color() };
            object.layer = placed.layer().map(str::to_owned);
            let parent =
                placed.object.parent.as_deref().and_then(|parent| known.get(&(under[number], parent)));
            object.parent = parent.copied().or(under[number]).map(|at| named[at].clone());
            scene.list.add(object)?;
        }
        for connection in self.connections() {
            scene.connect(connection.clone())?;
        }
        Ok(Cow::Owned(scene))
    }
}

/// The label in a flat scene, `instance/object` by the labels of both; `None` where neither has one.
fn label(all: &[Placed<'_>], under: &[Option<usize>], number: usize) -> Option<String> {
    let own = all[number].object;
    let above = all[number].path.inside_out().any(|instance| instance.label.is_some());
    if own.label.is_none() && !above {
        return None;
    }
    let way = std::iter::successors(Some(number), |&at| under[at]);
    let mut names: Vec<&str> = way.map(|at| all[at].object.label()).collect();
    names.reverse();
    Some(names.join("/"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Cloud;
    use crate::scene::placement::transform_point;
    use crate::scene::{Unit, Up};
    use crate::{Point, Vector};

    fn instance_of(name: &str, of: &str, by: Option<Matrix4<f64>>) -> Object {
        let mut object = Object::new(name, Geometry::Instance(of.into()));
        object.transform = by;
        object
    }

    fn dot(name: &str) -> Object {
        Object::new(name, Cloud { points: vec![Point::new(1.0, 0.0, 0.0)] }.into())
    }

    fn shift(x: f64, y: f64, z: f64) -> Option<Matrix4<f64>> {
        Some(Matrix4::new_translation(&Vector::new(x, y, z)))
    }

    /// A wheel has a rim and two bolts, a car a body and two wheels under it, one of them turned and twice as large.
    fn cars() -> Scene {
        let mut scene = Scene::new();
        let mut bolt = Definition::new("bolt");
        bolt.add(dot("head")).unwrap();
        let mut wheel = Definition::new("wheel");
        let mut rim = dot("rim");
        rim.parent = Some("hub".into());
        wheel.add(rim).unwrap();
        let mut hub = Object::new("hub", Geometry::Group);
        hub.transform = shift(0.0, 0.0, 5.0);
        wheel.add(hub).unwrap();
        for (k, x) in [(1, 10.0), (2, 20.0)] {
            let mut bolt = instance_of(&format!("bolt {k}"), "bolt", shift(x, 0.0, 0.0));
            bolt.parent = Some("hub".into());
            bolt.color = (k == 2).then_some([1.0, 0.0, 0.0, 1.0]);
            wheel.add(bolt).unwrap();
        }
        // Used before it is defined: the order of definitions does not matter.
        scene.define(wheel).unwrap();
        scene.define(bolt).unwrap();
        scene.add(dot("body")).unwrap();
        scene.add(instance_of("left", "wheel", shift(0.0, 100.0, 0.0))).unwrap();
        // (x, y, z) → (-2 y, 2 x, 2 z + 1000).
        #[rustfmt::skip]
        let turned = Matrix4::new(
            0.0, -2.0, 0.0, 0.0,
            2.0,  0.0, 0.0, 0.0,
            0.0,  0.0, 2.0, 1000.0,
            0.0,  0.0, 0.0, 1.0,
        );
        let mut right = instance_of("right", "wheel", Some(turned));
        right.parent = Some("body".into());
        right.layer = Some("wheels".into());
        scene.add(right).unwrap();
        scene.check().unwrap();
        scene
    }

    /// By hand: (1, 0, 0) goes by the bolt's shift, the hub's, and that of the wheel.
    const PLACES: [(&str, &str, Option<[f64; 3]>); 13] = [
        ("", "body", Some([1.0, 0.0, 0.0])),
        ("", "left", None),
        ("left", "rim", Some([1.0, 100.0, 5.0])),
        ("left", "hub", None),
        ("left", "bolt 1", None),
        ("left/bolt 1", "head", Some([11.0, 100.0, 5.0])),
        ("left", "bolt 2", None),
        ("left/bolt 2", "head", Some([21.0, 100.0, 5.0])),
        ("", "right", None),
        ("right", "rim", Some([0.0, 2.0, 1010.0])),
        ("right", "hub", None),
        ("right/bolt 1", "head", Some([0.0, 22.0, 1010.0])),
        ("right/bolt 2", "head", Some([0.0, 42.0, 1010.0])),
    ];

    #[test]
    fn instances_show_their_objects_where_matrices_by_hand_say() {
        let scene = cars();
        let mut found: Vec<_> = scene.placed(15).unwrap().collect();
        assert_eq!((found.len(), scene.placed_count().unwrap()), (15, 15));
        assert_eq!(scene.placed(15).unwrap().size_hint(), (15, Some(15)));
        // The bolts of the right wheel come as those of the left do.
        found.retain(|p| !(p.path.to_string() == "right" && p.object.name().starts_with("bolt")));
        for (placed, (path, name, at)) in found.iter().zip(PLACES) {
            assert_eq!((placed.path.to_string().as_str(), placed.object.name()), (path, name));
            assert_eq!(placed.path.depth(), path.split('/').filter(|p| !p.is_empty()).count());
            if let Some([x, y, z]) = at {
                let p = placed.object.geometry().points()[0];
                let p = placed.to_world.map_or(p, |map| transform_point(&map, &p));
                assert_eq!(p, Point::new(x, y, z), "{path}/{name}");
            }
        }
        let red: Vec<_> = found.iter().filter(|p| p.color().is_some()).map(|p| p.path.to_string()).collect();
        assert_eq!(red, ["left", "left/bolt 2", "right/bolt 2"]);
        assert_eq!(found.iter().filter(|p| p.layer() == Some("wheels")).count(), 5);
    }

    #[test]
    fn a_flat_scene_shows_the_same_and_shares_geometry() {
        let scene = cars();
        let flat = scene.flattened(100).unwrap();
        flat.check().unwrap();
        assert!(flat.definitions().is_empty() && flat.objects().len() == 15);
        let maps = flat.world_transforms().unwrap();
        for (placed, (object, map)) in scene.placed(100).unwrap().zip(flat.objects().iter().zip(maps)) {
            let within = if placed.path.depth() > 0 { format!("{}/", placed.path) } else { String::new() };
            assert_eq!(object.name(), format!("{within}{}", placed.object.name()));
            assert_eq!(map, placed.to_world, "{}", object.name());
            let points = placed.object.geometry().points();
            assert_eq!(object.geometry().points(), points);
            assert!(points.is_empty() || object.geometry_id() == placed.object.geometry_id());
        }
        let head = flat.object("right/bolt 2/head").unwrap();
        assert_eq!((head.color, head.layer.as_deref()), (Some([1.0, 0.0, 0.0, 1.0]), Some("wheels")));
        assert_eq!(head.parent.as_deref(), Some("right/bolt 2"));
        assert_eq!(flat.object("right/bolt 2").unwrap().parent.as_deref(), Some("right/hub"));
        assert_eq!(flat.object("right").unwrap().parent.as_deref(), Some("body"));
        // Labels go along, with those of the instances.
        let mut labelled = scene.clone();
        let wheel = labelled.definition_mut("wheel").unwrap();
        for name in ["bolt 1", "bolt 2"] {
            wheel.object_mut(name).unwrap().label = Some("bolt".into());
        }
        labelled.object_mut("body").unwrap().label = Some("car".into());
        let flat = labelled.flattened(100).unwrap();
        let labels = |name: &str| flat.object(name).unwrap().label();
        assert_eq!((labels("right/bolt 2/head"), labels("right/bolt 1")), ("right/bolt/head", "right/bolt"));
        assert_eq!((labels("body"), labels("right/rim")), ("car", "right/rim"));
        assert_eq!(flat.object("right/rim").unwrap().label, None);
        // A name that is taken already.
        let mut scene = scene;
        scene.add(dot("left/rim")).unwrap();
        let flat = scene.flattened(100).unwrap();
        assert!(flat.get("left/rim").is_some() && flat.get("left/rim.001").is_some());
        assert_eq!(flat.get("left/rim").unwrap().parent, None);
        // Definitions go along into another unit.
        let there = scene.converted(Unit::Millimetre, Up::Y).unwrap();
        for (a, b) in scene.placed(100).unwrap().zip(there.placed(100).unwrap()) {
            let Some(p) = a.object.geometry().points().first() else { continue };
            let at = |placed: &Placed<'_>, p: &Point| placed.to_world.map_or(*p, |m| transform_point(&m, p));
            let (p, q) = (at(&a, p), at(&b, &b.object.geometry().points()[0]));
            assert!((Point::new(p.x, p.z, -p.y) * 1000.0 - q).norm() < 1e-9, "{p} {q}");
        }
    }

    #[test]
    fn circles_and_what_is_missing_are_refused_by_name() {
        let mut scene = cars();
        scene.definition_mut("bolt").unwrap().add(instance_of("inner", "wheel", None)).unwrap();
        let error = scene.check().unwrap_err().to_string();
        assert!(error.contains("\"wheel\" → \"bolt\" → \"wheel\""), "{error}");
        assert!(scene.placed(100).is_err() && scene.flattened(100).is_err() && scene.placed_count().is_err());
        let mut scene = cars();
        scene.definition_mut("bolt").unwrap().add(instance_of("nut", "nut", None)).unwrap();
        let error = scene.check().unwrap_err().to_string();
        assert!(
            error.contains("in the definition \"bolt\": \"nut\" shows the definition \"nut\""),
            "{error}"
        );
        let mut scene = Scene::new();
        scene.add(instance_of("a", "b", None)).unwrap();
        assert!(scene.check().unwrap_err().to_string().contains("\"a\" shows the definition \"b\""));
        let mut definition = Definition::new("b");
        let mut lost = dot("lost");
        lost.parent = Some("a".into());
        definition.add(lost).unwrap();
        scene.define(definition).unwrap();
        let error = scene.check().unwrap_err().to_string();
        assert!(error.contains("in the definition \"b\": the parent \"a\" of \"lost\""), "{error}");
        assert!(scene.define(Definition::new("b")).is_err() && scene.define(Definition::new("")).is_err());
        assert!(scene.definition("c").is_err());
    }

    #[test]
    fn doubling_is_counted_and_not_done() {
        // Each shows the one before it twice: 2^100 dots.
        let mut scene = Scene::new();
        for k in 0..100 {
            let mut definition = Definition::new(format!("{k}"));
            if k == 0 {
                definition.add(dot("dot")).unwrap();
            } else {
                let below = format!("{}", k - 1);
                definition.add(instance_of("a", &below, shift(1.0, 0.0, 0.0))).unwrap();
                definition.add(instance_of("b", &below, None)).unwrap();
            }
            scene.define(definition).unwrap();
        }
        scene.add(instance_of("all", "99", None)).unwrap();
        scene.check().unwrap();
        assert_eq!(scene.placed_count().unwrap(), u64::MAX);
        let error = scene.placed(1_000_000).unwrap_err().to_string();
        assert!(error.contains("more than 10^19") && error.contains("1000000"), "{error}");
        scene.object_mut("all").unwrap().set_geometry(Geometry::Instance("3".into()));
        // 8 dots and 1 + 2 + 4 + 8 instances.
        assert_eq!(scene.placed_count().unwrap(), 8 + 15);
        assert!(scene.placed(22).unwrap_err().to_string().contains("show 23 objects"));
        assert_eq!(scene.placed(23).unwrap().count(), 23);
    }

    #[test]
    fn nesting_may_be_deeper_than_a_stack() {
        let (deep, mut scene) = (100_000, Scene::new());
        for k in 0..deep {
            let mut definition = Definition::new(format!("{k}"));
            let next = if k + 1 < deep {
                instance_of("i", &format!("{}", k + 1), shift(1.0, 0.0, 0.0))
            } else {
                dot("d")
            };
            definition.add(next).unwrap();
            scene.define(definition).unwrap();
        }
        scene.add(instance_of("top", "0", None)).unwrap();
        scene.check().unwrap();
        let last = scene.placed(1_000_000).unwrap().last().unwrap();
        assert_eq!((last.object.name(), last.path.depth()), ("d", deep));
        assert_eq!(last.to_world.unwrap()[(0, 3)], (deep - 1) as f64);
        assert_eq!(last.path.inside_out().count(), deep);
        // Their names would be the square of that.
        assert!(scene.flattened(1_000).is_err());
        assert!(scene.flattened(200_000).unwrap_err().to_string().contains("names"));
        // Of the first, the paths that lead to all others go with the last of them.
        drop(last);
        assert!(format!("{:?}", scene.placed(1_000_000).unwrap().nth(1000).unwrap().path).len() > 1000);
    }

    /// What says nothing of its looks has the colour of the nearest instance; a colour, a material or coloured points of its own
    /// are something.
    #[test]
    fn colours_come_from_above_where_nothing_of_ones_own_is_said() {
        let [red, blue] = [[1.0, 0.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]];
        let mut scene = Scene::new();
        let mut bolt = Definition::new("bolt");
        bolt.add(dot("plain")).unwrap();
        let mut own = dot("own");
        own.color = Some(blue);
        bolt.add(own).unwrap();
        let mut steel = dot("steel");
        steel.materials = vec!["steel".into()];
        bolt.add(steel).unwrap();
        scene.define(bolt).unwrap();
        let mut shown = instance_of("shown", "bolt", None);
        shown.color = Some(red);
        scene.add(shown).unwrap();
        let colors: Vec<_> =
            scene.placed(9).unwrap().map(|p| (p.object.name().to_owned(), p.color())).collect();
        let color = |name: &str| colors.iter().find(|(n, _)| n == name).unwrap().1;
        assert_eq!((color("plain"), color("own"), color("steel")), (Some(red), Some(blue), None));
    }
}
