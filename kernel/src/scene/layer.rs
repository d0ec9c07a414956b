//! Layers: what objects are on, with a colour and whether it is seen.

use std::collections::{HashMap, HashSet};

use super::{Definition, Geometry, Object, Scene};
use crate::error::{Error, Result};
use crate::named::{Named, NamedList};

/// A layer of a scene, which objects name. Layers lie below one another; an object is on one at most.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    name: String,
    /// Red, green, blue, alpha, each 0 to 1: of what is on it and has no colour of its own, nor from an instance that shows it.
    pub color: Option<[f64; 4]>,
    /// Whether what is on it is seen. Where not, nothing is that is on it or on a layer below it, whatever those say.
    pub visible: bool,
    /// The name of the layer it lies below.
    pub parent: Option<String>,
}

impl Layer {
    /// A layer with a name that is seen, and nothing else.
    pub fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), color: None, visible: true, parent: None }
    }

    /// The same layer, of this colour.
    #[must_use]
    pub fn colored(self, color: [f64; 4]) -> Self {
        Self { color: Some(color), ..self }
    }

    /// The same layer, hidden.
    #[must_use]
    pub fn hidden(self) -> Self {
        Self { visible: false, ..self }
    }

    /// The same layer, below another one.
    #[must_use]
    pub fn below(self, parent: impl Into<String>) -> Self {
        Self { parent: Some(parent.into()), ..self }
    }

    /// Its name, unique among the layers of its scene, never empty there.
    pub fn name(&self) -> &str {
        &self.name
    }
}

impl Named for Layer {
    const KIND: &'static str = "layer";

    fn name(&self) -> &str {
        &self.name
    }
}

/// Checks that every layer lies below one that exists, and none below itself, however far up. `O(layers)`.
///
/// # Errors
/// With the names of the layers at fault.
pub fn check_layers(layers: &NamedList<Layer>) -> Result<()> {
    let above = above(layers)?;
    // 0: not seen, 1: on the way, 2: sound.
    let mut state = vec![0_u8; above.len()];
    for start in 0..above.len() {
        let mut way = Vec::new();
        let mut at = Some(start);
        while let Some(i) = at.filter(|&i| state[i] < 2) {
            if state[i] == 1 {
                let from = way.iter().position(|&w| w == i).unwrap_or_default();
                return Err(circle(way[from..].iter().chain([&i]).map(|&w| layers.as_slice()[w].name())));
            }
            state[i] = 1;
            way.push(i);
            at = above[i];
        }
        way.into_iter().for_each(|i| state[i] = 2);
    }
    Ok(())
}

/// The number of the layer that each one lies below.
fn above(layers: &NamedList<Layer>) -> Result<Vec<Option<usize>>> {
    let number = |layer: &Layer| {
        let Some(parent) = layer.parent.as_deref() else { return Ok(None) };
        let missing = || {
            let name = layer.name();
            Error::Invalid(format!("the layer \"{parent}\", below which \"{name}\" lies, does not exist"))
        };
        layers.position(parent).map(Some).ok_or_else(missing)
    };
    layers.iter().map(number).collect()
}

fn circle<'a>(names: impl Iterator<Item = &'a str>) -> Error {
    let names: Vec<String> = names.map(|name| format!("\"{name}\"")).collect();
    let way = match names.as_slice() {
        [first, .., last] if names.len() > 8 => format!("{first} → … ({} more) → {last}", names.len() - 2),
        _ => names.join(" → "),
    };
    Error::Invalid(format!("the layers are cyclic: {way}; take the parent of one of them away"))
}

/// Which layers are hidden: themselves, or one above them.
#[derive(Debug, Clone, Default)]
pub struct Hidden<'a>(HashSet<&'a str>);

impl<'a> Hidden<'a> {
    pub(super) fn of(layers: &'a NamedList<Layer>) -> Self {
        let mut known: HashMap<&str, bool> = HashMap::with_capacity(layers.len());
        for layer in layers {
            let mut way = Vec::new();
            let mut at = Some(layer);
            // What is met again on its own way is hidden by none of those in the circle, which a check refuses.
            let hidden = loop {
                let Some(next) = at else { break false };
                if let Some(&known) = known.get(next.name()) {
                    break known;
                }
                if !next.visible {
                    known.insert(next.name(), true);
                    break true;
                }
                known.insert(next.name(), false);
                way.push(next.name());
                at = next.parent.as_deref().and_then(|parent| layers.get(parent));
            };
            for name in way {
                known.insert(name, hidden);
            }
        }
        Self(known.into_iter().filter_map(|(name, hidden)| hidden.then_some(name)).collect())
    }

    /// Whether a layer is hidden.
    pub fn contains(&self, layer: &str) -> bool {
        self.0.contains(layer)
    }

    /// Whether an object of the scene itself, or of a definition that is seen, is on one.
    pub fn hides(&self, object: &Object) -> bool {
        object.layer.as_deref().is_some_and(|layer| self.contains(layer))
    }

    /// Whether none is.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl Scene {
    /// The layers: those that are listed, and behind them those that objects only name, in the order in which they do
    /// (objects of definitions first). `O(objects)`.
    pub fn all_layers(&self) -> NamedList<Layer> {
        let mut all = self.layers.clone();
        let defined = self.definitions().iter().flat_map(Definition::objects);
        for name in defined.chain(self.objects()).filter_map(|object| object.layer.as_deref()) {
            if all.get(name).is_none() {
                // Only an empty name is refused, and that is no layer.
                let _ = all.add(Layer::new(name));
            }
        }
        all
    }

    /// Which layers are hidden. `O(layers)`.
    pub fn hidden_layers(&self) -> Hidden<'_> {
        Hidden::of(&self.layers)
    }

    /// The colour that an object of a list shows: its own, or where nothing of its own says how it looks, that of its layer.
    pub fn color_of(&self, object: &Object) -> Option<[f64; 4]> {
        object
            .color
            .or_else(|| if object.has_look() { None } else { self.layer_color(object.layer.as_deref()) })
    }

    /// The colour of a layer.
    pub(super) fn layer_color(&self, layer: Option<&str>) -> Option<[f64; 4]> {
        self.layers.get(layer?)?.color
    }

    /// How many objects with a shape are on hidden layers, those of definitions among them, each once.
    pub fn hidden_count(&self) -> usize {
        let hidden = self.hidden_layers();
        if hidden.is_empty() {
            return 0;
        }
        let defined = self.definitions().iter().flat_map(Definition::objects);
        let shows = |o: &&Object| !matches!(o.geometry(), Geometry::Group) && hidden.hides(o);
        defined.chain(self.objects()).filter(shows).count()
    }

    /// The same scene without definitions where nothing has a shape that is on a hidden layer, or shown by an instance that is:
    /// what is to be seen. What is hidden remains as a group, so that what hangs under it is where it was.
    ///
    /// # Errors
    /// As for [`flattened`](Self::flattened).
    pub fn seen(&self, limit: u64) -> Result<std::borrow::Cow<'_, Self>> {
        let mut flat = self.flattened(limit)?;
        let hidden = self.hidden_layers();
        if hidden.is_empty() {
            return Ok(flat);
        }
        flat.to_mut().empty(|object| hidden.hides(object))?;
        Ok(flat)
    }

    /// Makes groups of the objects that are to have no shape, frames or connections any more; all else of them stays.
    ///
    /// # Errors
    /// None that could be provoked.
    pub fn empty(&mut self, which: impl Fn(&Object) -> bool) -> Result<()> {
        let group = std::sync::Arc::new(Geometry::Group);
        let names: Vec<String> =
            self.objects().iter().filter(|o| which(o)).map(|o| o.name().to_owned()).collect();
        for name in &names {
            self.replace_shared(name, std::sync::Arc::clone(&group))?;
        }
        Ok(())
    }

    /// Gives the colours of layers to the objects that show them, for those who know no layers. `O(objects)`.
    ///
    /// # Errors
    /// None that could be provoked.
    pub fn color_by_layer(&mut self) -> Result<()> {
        let colors = self.objects().iter().map(|o| (o.name().to_owned(), self.color_of(o)));
        for (name, color) in colors.filter(|(_, color)| color.is_some()).collect::<Vec<_>>() {
            self.object_mut(&name)?.color = color;
        }
        Ok(())
    }

    /// How many layers have a colour.
    pub fn colored_layers(&self) -> usize {
        self.layers.iter().filter(|layer| layer.color.is_some()).count()
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix4;

    use super::*;
    use crate::Point;
    use crate::mesh::Cloud;

    fn dot(name: &str, layer: Option<&str>) -> Object {
        let mut object = Object::new(name, Cloud { points: vec![Point::origin()] }.into());
        object.layer = layer.map(str::to_owned);
        object
    }

    fn list(scene: &mut Scene, name: &str, parent: Option<&str>, visible: bool) {
        let layer = Layer { parent: parent.map(str::to_owned), visible, ..Layer::new(name) };
        scene.layers.add(layer).unwrap();
    }

    #[test]
    fn hidden_layers_hide_all_that_lies_below_them_however_far() {
        let mut scene = Scene::new();
        // Listed from the bottom up.
        let count = 20_000;
        for i in 0..count {
            let parent = (i + 1 < count).then(|| format!("{}", i + 1));
            list(&mut scene, &format!("{i}"), parent.as_deref(), i != count / 2);
        }
        check_layers(&scene.layers).unwrap();
        let hidden = scene.hidden_layers();
        for i in 0..count {
            assert_eq!(hidden.contains(&format!("{i}")), i <= count / 2, "{i}");
        }
        assert!(!hidden.contains("unlisted"));
    }

    #[test]
    fn layers_exist_and_make_no_circle() {
        let mut scene = Scene::new();
        list(&mut scene, "a", Some("b"), true);
        let problem = |scene: &Scene| scene.check().unwrap_err().to_string();
        assert!(problem(&scene).contains("\"b\", below which \"a\" lies"), "{}", problem(&scene));
        list(&mut scene, "b", Some("c"), false);
        list(&mut scene, "c", Some("b"), true);
        let said = problem(&scene);
        assert!(said.contains("cyclic: \"b\" → \"c\" → \"b\"; take the parent"), "{said}");
        // Asked all the same, a circle ends.
        assert!(scene.hidden_layers().contains("a"));
        let mut long = Scene::new();
        for i in 0..5_000 {
            list(&mut long, &format!("{i}"), Some(&format!("{}", (i + 1) % 5_000)), true);
        }
        assert!(problem(&long).contains("\"0\" → … (4999 more) → \"0\""), "{}", problem(&long));
        assert!(long.hidden_layers().is_empty());
        assert!(scene.layers.add(Layer::new("a")).is_err() && scene.layers.add(Layer::new("")).is_err());
    }

    #[test]
    fn what_is_named_is_listed_behind_what_is_listed() {
        let mut scene = Scene::new();
        list(&mut scene, "walls", None, true);
        let mut part = Definition::new("part");
        part.add(dot("p", Some("steel"))).unwrap();
        scene.define(part).unwrap();
        scene.add(dot("a", Some("doors"))).unwrap();
        scene.add(dot("b", Some("walls"))).unwrap();
        let all = scene.all_layers();
        assert_eq!(all.iter().map(Layer::name).collect::<Vec<_>>(), ["walls", "steel", "doors"]);
        assert!(all.iter().all(|layer| layer.visible && layer.color.is_none()));
    }

    #[test]
    fn a_hidden_instance_hides_what_it_shows_and_the_other_does_not() {
        let mut scene = Scene::new();
        list(&mut scene, "off", None, false);
        list(&mut scene, "below", Some("off"), true);
        list(&mut scene, "on", None, true);
        let mut part = Definition::new("part");
        part.add(dot("own", Some("on"))).unwrap();
        part.add(dot("none", None)).unwrap();
        part.add(dot("never", Some("below"))).unwrap();
        scene.define(part).unwrap();
        for (name, layer) in [("seen", "on"), ("unseen", "below")] {
            let mut instance = Object::new(name, Geometry::Instance("part".into()));
            instance.layer = Some(layer.into());
            instance.transform = Some(Matrix4::identity());
            scene.add(instance).unwrap();
        }
        let mut under = dot("under", None);
        under.parent = Some("hidden".into());
        scene.add(dot("hidden", Some("off"))).unwrap();
        scene.add(under).unwrap();
        let seen = scene.seen(100).unwrap();
        seen.check().unwrap();
        let shapes: Vec<&str> =
            seen.objects().iter().filter(|o| !o.geometry().points().is_empty()).map(Object::name).collect();
        assert_eq!(shapes, ["seen/own", "seen/none", "under"]);
        assert_eq!(seen.objects().len(), scene.flattened(100).unwrap().objects().len());
        assert_eq!(scene.hidden_count(), 3);
        let hidden: Vec<bool> = scene.placed(100).unwrap().map(|p| p.is_hidden()).collect();
        assert_eq!(hidden, [false, false, false, true, true, true, true, true, true, false]);
        let layers: Vec<_> = scene.placed(100).unwrap().map(|p| p.layer().unwrap_or("").to_owned()).collect();
        assert_eq!(layers, ["on", "on", "on", "below", "below", "below", "below", "below", "off", ""]);
    }

    #[test]
    fn a_layer_gives_its_colour_to_what_has_none() {
        let (red, blue) = ([1.0, 0.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]);
        let mut scene = Scene::new();
        scene.layers.add(Layer { color: Some(red), ..Layer::new("red") }).unwrap();
        let mut part = Definition::new("part");
        part.add(dot("by layer", Some("red"))).unwrap();
        part.add(dot("none", None)).unwrap();
        scene.define(part).unwrap();
        let mut instance = Object::new("plain", Geometry::Instance("part".into()));
        instance.layer = Some("red".into());
        scene.add(instance.renamed("blue")).unwrap();
        scene.object_mut("blue").unwrap().color = Some(blue);
        scene.add(instance).unwrap();
        let mut own = dot("own", Some("red"));
        own.color = Some(blue);
        scene.add(own).unwrap();
        let mut made = dot("of wood", Some("red"));
        made.materials = vec!["wood".into()];
        scene.add(made).unwrap();
        let shown: Vec<_> = scene.placed(100).unwrap().map(|p| (p.object.name(), p.color())).collect();
        let expected = [
            ("blue", Some(blue)),
            ("by layer", Some(blue)),
            ("none", Some(blue)),
            ("plain", Some(red)),
            ("by layer", Some(red)),
            ("none", Some(red)),
            ("own", Some(blue)),
            ("of wood", None),
        ];
        assert_eq!(shown, expected);
        // Flat, what has its colour by layer still has it so.
        let flat = scene.flattened(100).unwrap();
        let found: Vec<_> = flat.objects().iter().map(|o| flat.color_of(o)).collect();
        assert_eq!(found, expected.map(|(_, color)| color));
        assert_eq!(flat.object("plain/none").unwrap().color, None);
    }
}
