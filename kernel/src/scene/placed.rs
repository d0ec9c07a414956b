//! Everything that a scene shows, instance by instance, where it is in the world.

#[cfg(test)]
mod tests;

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
