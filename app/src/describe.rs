//! What is in a scene: for each object its type and the facts that people ask first.

use std::collections::HashMap;

use loftsman_kernel::nalgebra::Matrix4;
use loftsman_kernel::scene::{Definition, Geometry, Object, Scene, Standing, Unit, Up};

pub use crate::facts::{Degree, FaceFacts, ObjectFacts, OffEdge, OpenEdge, OwnFacts};
use crate::facts::{faces, is_false};
use crate::placed::{Placed, instances};

/// The facts about a scene.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct SceneFacts {
    /// The unit of all lengths.
    pub unit: Unit,
    /// The axis that points up.
    pub up: Up,
    /// The layers: those that are listed, and behind them those that objects only name.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub layers: Vec<LayerFacts>,
    /// Each object.
    pub objects: Vec<ObjectFacts>,
    /// The definitions that instances show.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub definitions: Vec<DefinitionFacts>,
    /// How many objects are shown, instances and all that they show, where there are definitions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shown: Option<u64>,
    /// What all Breps that are shown have together, each instance counted; where there are some.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub totals: Option<Totals>,
}

/// What Breps have together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
pub struct Totals {
    /// How many Breps there are.
    pub breps: u64,
    /// Their solids.
    pub solids: u64,
    /// Their faces.
    pub faces: u64,
    /// Their edges.
    pub edges: u64,
}

impl Totals {
    fn of(objects: &[Object], defined: &HashMap<&str, Self>) -> Self {
        objects.iter().fold(Self::default(), |sum, object| match object.geometry() {
            Geometry::Brep(brep) => sum.with(Self {
                breps: 1,
                solids: brep.solids().len() as u64,
                faces: brep.face_count() as u64,
                edges: brep.edge_count() as u64,
            }),
            Geometry::Instance(of) => sum.with(defined.get(of.as_str()).copied().unwrap_or_default()),
            _ => sum,
        })
    }

    fn with(self, other: Self) -> Self {
        Self {
            breps: self.breps.saturating_add(other.breps),
            solids: self.solids.saturating_add(other.solids),
            faces: self.faces.saturating_add(other.faces),
            edges: self.edges.saturating_add(other.edges),
        }
    }

    /// Nothing where there are no Breps.
    fn some(self) -> Option<Self> {
        (self.breps > 0).then_some(self)
    }
}

/// The facts about a layer.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct LayerFacts {
    /// Its name.
    pub name: String,
    /// Red, green, blue, alpha.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub color: Option<[f64; 4]>,
    /// Whether it is hidden, be it by a layer above it.
    #[serde(skip_serializing_if = "is_false")]
    pub hidden: bool,
    /// The layer below which it lies.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parent: Option<String>,
    /// How many objects are on it, those of definitions among them.
    pub objects: usize,
}

/// The facts about a definition.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct DefinitionFacts {
    /// Its name.
    pub name: String,
    /// Each of its objects.
    pub objects: Vec<ObjectFacts>,
    /// What the Breps have together that it shows; where there are some.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub totals: Option<Totals>,
}

/// The facts about a scene and each of its objects.
pub fn describe(scene: &Scene) -> SceneFacts {
    told(scene, false)
}

/// The same with each face of each Brep ([`ObjectFacts::face_list`]).
pub fn describe_faces(scene: &Scene) -> SceneFacts {
    told(scene, true)
}

fn told(scene: &Scene, with_faces: bool) -> SceneFacts {
    let mut placed = Placed::of(scene);
    let shown_by = instances(scene, &mut placed);
    let mut all = |objects: &[Object], maps: &[Option<Matrix4<f64>>]| -> Vec<ObjectFacts> {
        let facts = objects.iter().zip(maps).map(|(object, map)| {
            let shape = placed.facts(object.geometry_id(), object.geometry(), map.as_ref());
            let face_list = match object.geometry() {
                Geometry::Brep(brep) if with_faces => faces(brep, map.as_ref()),
                _ => Vec::new(),
            };
            ObjectFacts {
                face_list,
                name: object.name().to_owned(),
                label: object.label.clone(),
                parent: object.parent.clone(),
                layer: object.layer.clone(),
                color: object.color,
                transformed: object.transform.is_some(),
                frames: object.animation.as_ref().map(|a| a.frames.len()),
                resized: Standing::by(*map).changes_size(),
                ..shape
            }
        });
        facts.collect()
    };
    let totals = totals(scene);
    let of = |name: &str| totals.get(name).copied().and_then(Totals::some);
    let definitions = scene.definitions().iter();
    let definitions: Vec<_> = definitions
        .map(|d| DefinitionFacts {
            name: d.name().to_owned(),
            objects: all(d.objects(), &maps(d.objects())),
            totals: of(d.name()),
        })
        .collect();
    // A hierarchy that is broken places nothing.
    let maps = scene.world_transforms().unwrap_or_else(|_| vec![None; scene.objects().len()]);
    let mut objects = all(scene.objects(), &maps);
    for object in objects.iter_mut().filter(|object| object.shows.is_some()) {
        if let Some(OwnFacts { measures, bounds }) = shown_by.get(&object.name) {
            (object.measures, object.bounds) = (measures.clone(), *bounds);
        }
    }
    let shown = if definitions.is_empty() { None } else { scene.placed_count().ok() };
    let totals = Totals::of(scene.objects(), &totals).some();
    SceneFacts { unit: scene.unit, up: scene.up, layers: layers(scene), objects, definitions, shown, totals }
}

/// From the coordinates of each object of a definition to those of the definition. `O(objects)`.
fn maps(objects: &[Object]) -> Vec<Option<Matrix4<f64>>> {
    let index: HashMap<&str, usize> = objects.iter().zip(0..).map(|(o, i)| (o.name(), i)).collect();
    let parent = |i: usize| objects[i].parent.as_deref().and_then(|name| index.get(name)).copied();
    let mut known: Vec<Option<Option<Matrix4<f64>>>> = vec![None; objects.len()];
    for first in 0..objects.len() {
        let mut way = vec![first];
        // A hierarchy without an end has no place.
        while let Some(above) = way.last().and_then(|&i| parent(i))
            && known[above].is_none()
            && way.len() <= objects.len()
        {
            way.push(above);
        }
        while let Some(i) = way.pop() {
            let above = parent(i).and_then(|above| known[above]).flatten();
            let own = objects[i].transform;
            known[i] = Some(match (above, own) {
                (Some(above), Some(own)) => Some(above * own),
                (above, own) => above.or(own),
            });
        }
    }
    known.into_iter().map(Option::flatten).collect()
}

/// The definition that an object shows.
fn shows(object: &Object) -> Option<&str> {
    match object.geometry() {
        Geometry::Instance(of) => Some(of),
        _ => None,
    }
}

/// What each definition shows of Breps: those that it shows first. `O(objects)` but for the depth to which definitions show one another.
fn totals(scene: &Scene) -> HashMap<&str, Totals> {
    let definitions: HashMap<&str, &Definition> = scene.definitions().iter().map(|d| (d.name(), d)).collect();
    let mut known: HashMap<&str, Totals> = HashMap::new();
    for first in scene.definitions().iter() {
        // Scenes let no definition show itself, so that this ends.
        let mut open = vec![first];
        while let Some(&definition) = open.last() {
            let mut next: Vec<&str> = definition.objects().iter().filter_map(shows).collect();
            next.sort_unstable();
            next.dedup();
            let before = open.len();
            if !known.contains_key(definition.name()) {
                let unknown = next.into_iter().filter(|name| !known.contains_key(name));
                open.extend(unknown.filter_map(|name| definitions.get(name)));
            }
            if open.len() == before {
                known.insert(definition.name(), Totals::of(definition.objects(), &known));
                open.pop();
            }
        }
    }
    known
}

fn layers(scene: &Scene) -> Vec<LayerFacts> {
    let mut counts: HashMap<&str, usize> = HashMap::new();
    let defined = scene.definitions().iter().flat_map(Definition::objects);
    for layer in defined.chain(scene.objects()).filter_map(|object| object.layer.as_deref()) {
        *counts.entry(layer).or_default() += 1;
    }
    let hidden = scene.hidden_layers();
    let all = scene.all_layers();
    let facts = all.iter().map(|layer| LayerFacts {
        name: layer.name().to_owned(),
        color: layer.color,
        hidden: hidden.contains(layer.name()),
        parent: layer.parent.clone(),
        objects: counts.get(layer.name()).copied().unwrap_or_default(),
    });
    facts.collect()
}
