//! From products to the objects of a scene: each on its place, what is shown more than once as a definition.

use std::collections::BTreeSet;
use std::sync::Arc;

use loftsman_kernel::plugin::{FormatError, ReadOptions};
use loftsman_kernel::scene::{Definition, Geometry, Layer, Object, Scene, Up};
use nalgebra::Matrix4;

use super::entity::{Problem, entity, kind};
use super::items::{Item, Items};
use super::occurrence;
use super::place::Space;
use super::product::{Node, Products, Role, representation, units};
use super::report::Account;
use super::style::Styles;
use super::twice;
use super::units::Contexts;
use crate::layers;
use crate::part21::File;

/// How deep products may hang under one another within one definition.
const DEEPEST: usize = 200;

/// Makes the scene.
pub(crate) struct Emitter<'r, 'a, 'f> {
    file: &'r File<'f>,
    products: &'r Products,
    styles: &'r Styles,
    contexts: &'a mut Contexts,
    account: &'a mut Account<'r, 'f>,
    /// What things are called that have no name.
    stem: &'r str,
    /// What each node holds itself.
    items: Vec<Vec<Item>>,
    /// The colour and the layer of a node's placement, which stand for those of a group.
    marks: Vec<(Option<[f64; 4]>, Option<String>)>,
    /// Whether anything is in a node or below it.
    shown: Vec<bool>,
    /// The definition of each node that is shown more than once.
    definitions: Vec<Option<String>>,
    /// The colours of definitions that go to their instances.
    lifted: Vec<Option<[f64; 4]>>,
}

/// Where something is put.
struct Spot<'n> {
    name: &'n str,
    label: &'n str,
    parent: Option<&'n str>,
    transform: Option<Matrix4<f64>>,
    /// The colour of the occurrence of a part that this is, before all others.
    color: Option<[f64; 4]>,
    /// The colour of an occurrence of what this is in: of what has none else.
    around: Option<[f64; 4]>,
    /// What it is called where it is used, if that is nothing that its name or label says.
    occurrence: Option<&'n str>,
}

impl<'n> Spot<'n> {
    fn new(name: &'n str, label: &'n str, parent: Option<&'n str>) -> Self {
        Self { name, label, parent, transform: None, color: None, around: None, occurrence: None }
    }
}

impl<'r, 'a, 'f> Emitter<'r, 'a, 'f> {
    pub(crate) fn new(
        file: &'r File<'f>,
        products: &'r Products,
        styles: &'r Styles,
        contexts: &'a mut Contexts,
        account: &'a mut Account<'r, 'f>,
        stem: &'r str,
    ) -> Self {
        Self {
            file,
            products,
            styles,
            contexts,
            account,
            stem,
            items: Vec::new(),
            marks: Vec::new(),
            shown: Vec::new(),
            definitions: Vec::new(),
            lifted: Vec::new(),
        }
    }

    /// The scene of all products.
    pub(crate) fn scene(mut self, options: &ReadOptions<'_>) -> Result<Scene, FormatError> {
        let nodes = &self.products.nodes;
        for (done, node) in nodes.iter().enumerate() {
            options.observer.proceed("reading", done as u64, nodes.len() as u64)?;
            self.marks.push((None, None));
            let items = self.items_of(node);
            self.items.push(items);
        }
        twice::leave_out(self.file, nodes, &mut self.items, self.account);
        self.shown = self.which_show();
        let mut scene = Scene::new();
        scene.unit = self.contexts.unit();
        scene.up = Up::Z;
        // Names first: definitions show one another, in any order.
        let mut names = Scene::new();
        for (node, found) in nodes.iter().enumerate() {
            let is_one = self.shown[node]
                && !self.is_shared(node)
                && (found.uses > 1 || found.uses > 0 && found.role == Role::Definition);
            let name = names.unique_name(self.name(&found.name));
            if is_one {
                names.add(Object::new(name.clone(), Geometry::Group))?;
            }
            self.definitions.push(is_one.then_some(name));
        }
        self.lift();
        let mut order: Vec<usize> = (0..nodes.len()).collect();
        // In files that were written here the numbers of their products are in the order of definitions.
        if self.file.header.system == crate::SYSTEM {
            order.sort_by_key(|&node| nodes[node].product);
        }
        for node in order {
            if let Some(name) = self.definitions[node].clone() {
                let mut list = Definition::new(name);
                self.body(&mut list, node)?;
                scene.define(list)?;
            }
        }
        let mut all = Definition::new("scene");
        for (node, found) in nodes.iter().enumerate() {
            if found.uses == 0 && self.shown[node] && found.role == Role::Scene {
                self.children(&mut all, node, &Spot::new("", "", None), 0)?;
            } else if found.uses == 0 && self.shown[node] {
                let name = self.name(&found.name).to_owned();
                let label = found.label.clone();
                let spot = Spot::new(&name, &label, None);
                self.place(&mut all, node, &spot, 0)?;
            }
        }
        // Layers above that hide what is seen by itself; nothing needs to be on them.
        let mut hiding = BTreeSet::new();
        for (name, about) in &self.styles.named {
            let said = layers::parse(about);
            let visible = !self.styles.hidden.contains(name);
            if !visible || said.is_some() {
                let said = said.unwrap_or_default();
                if !visible && said.seen {
                    hiding.extend(said.parent.clone());
                }
                let mut layer = Layer::new(name.clone());
                (layer.color, layer.visible, layer.parent) = (said.color, visible || said.seen, said.parent);
                scene.layers.add(layer)?;
            }
        }
        layers::untie(&mut scene, &hiding)?;
        for object in all.objects() {
            let mut object = object.clone();
            layers::take_color(&scene, &mut object);
            scene.add(object)?;
        }
        Ok(scene)
    }

    fn name(&self, name: &'r str) -> &'r str {
        if name.is_empty() { self.stem } else { name }
    }

    /// Whether a node is a geometry that objects share, as files say that were written here.
    fn is_shared(&self, node: usize) -> bool {
        let found = &self.products.nodes[node];
        found.role == Role::Shared && found.children.is_empty() && self.items[node].len() == 1
    }

    /// Gives the colours of parts to their instances, where some of these have other ones, and tells which have no effect.
    fn lift(&mut self) {
        let nodes = &self.products.nodes;
        if nodes.iter().flat_map(|node| &node.children).all(|child| child.color.is_none()) {
            return;
        }
        self.lifted = occurrence::lifted(nodes, |node| match &self.items[node][..] {
            [only] if self.definitions[node].is_some() && nodes[node].children.is_empty() => only.color,
            _ => None,
        });
        let keeps = |node: usize| self.items[node].iter().any(|item| item.color.is_some());
        let keeping = occurrence::keeping(nodes, keeps);
        for (items, _) in self.items.iter_mut().zip(&self.lifted).filter(|(_, lifted)| lifted.is_some()) {
            items.iter_mut().for_each(|item| item.color = None);
        }
        let children = nodes.iter().flat_map(|node| &node.children);
        let without = children.filter(|child| {
            let is_part = self.definitions[child.node].is_none() && nodes[child.node].children.is_empty();
            let goes_to_all = is_part || self.lifted[child.node].is_some() || !keeping[child.node];
            child.color.is_some() && !goes_to_all
        });
        let text = "its colour goes only to what in it has no colour of its own here";
        let told: Vec<_> = without.map(|child| self.account.told(child.number, text)).collect();
        told.into_iter().for_each(|note| self.account.note(note));
    }

    /// Which nodes show anything, themselves or below.
    fn which_show(&self) -> Vec<bool> {
        let nodes = &self.products.nodes;
        let mut parents = vec![Vec::new(); nodes.len()];
        for (node, found) in nodes.iter().enumerate() {
            found.children.iter().for_each(|child| parents[child.node].push(node));
        }
        let holds = |(items, node): (&Vec<Item>, &Node)| !items.is_empty() || node.role == Role::Group;
        let mut shown: Vec<bool> = self.items.iter().zip(nodes).map(holds).collect();
        let mut waiting: Vec<usize> = (0..nodes.len()).filter(|&node| shown[node]).collect();
        while let Some(node) = waiting.pop() {
            for &parent in &parents[node] {
                if !std::mem::replace(&mut shown[parent], true) {
                    waiting.push(parent);
                }
            }
        }
        shown
    }

    /// What a node holds itself.
    fn items_of(&mut self, node: &Node) -> Vec<Item> {
        let mut found: Vec<Item> = Vec::new();
        for &number in &node.representations {
            let listed = entity(self.file, number).and_then(|found| {
                let args = representation(&found)?;
                Ok((args.references(1)?, args.optional(2)?))
            });
            let (numbers, context) = match listed {
                Ok(listed) => listed,
                Err(problem) => {
                    self.account.problems(vec![problem]);
                    continue;
                }
            };
            let units = match units(self.file, number, self.contexts) {
                Ok(units) => units,
                // Without units numbers are what they are; what is wrong with the context is said.
                Err(problem) => {
                    self.account.problems(vec![problem]);
                    self.contexts.miss(number);
                    super::place::Units::default()
                }
            };
            let places = numbers.iter().filter(|number| kind(self.file, **number) == b"AXIS2_PLACEMENT_3D");
            for &place in places {
                if let Some((color, layer)) = self.marks.last_mut() {
                    *color = color.or_else(|| self.styles.color(place));
                    *layer = layer.take().or_else(|| self.styles.layer(place).cloned());
                }
            }
            let space = Space { file: self.file, units };
            let mut items = Items::new(space, self.styles, self.account);
            items.all(&numbers, None, 0);
            let layer = self.styles.layer(number);
            let color = self.styles.color(number);
            for mut item in items.found {
                item.layer = item.layer.or_else(|| layer.cloned());
                item.color = item.color.or(color);
                found.push(item);
            }
            self.account.keep_alone(&[number]);
            self.account.keep_whole(context.as_slice());
        }
        found
    }

    /// The objects of a definition.
    fn body(&mut self, list: &mut Definition, node: usize) -> Result<(), FormatError> {
        let name = self.name(&self.products.nodes[node].name).to_owned();
        for item in std::mem::take(&mut self.items[node]) {
            let called = if item.name.is_empty() { name.clone() } else { item.name.clone() };
            put(list, item, &Spot::new(&called, &called, None))?;
        }
        self.children(list, node, &Spot::new("", "", None), 0)
    }

    /// A node as objects: one, or a group with what is in it and below it.
    fn place(
        &mut self,
        list: &mut Definition,
        node: usize,
        spot: &Spot<'_>,
        depth: usize,
    ) -> Result<(), FormatError> {
        let mut items = if self.is_shared(node) {
            self.items[node].clone()
        } else {
            std::mem::take(&mut self.items[node])
        };
        let own = &self.products.nodes[node];
        let below = own.role == Role::Group || own.children.iter().any(|child| self.shown[child.node]);
        let head = match items.len() {
            1 => put(list, items.remove(0), spot)?,
            // Several without anything around them need no group.
            _ if !below && spot.parent.is_none() && spot.transform.is_none() => {
                for item in items {
                    let called = if item.name.is_empty() { spot.name.to_owned() } else { item.name.clone() };
                    put(list, item, &Spot { name: &called, label: &called, ..*spot })?;
                }
                return Ok(());
            }
            _ => {
                let (color, layer) = self.marks[node].clone();
                let geometry = Arc::new(Geometry::Group);
                let group = Item { name: String::new(), geometry, color, layer, tessellation: None };
                put(list, group, &Spot { color: None, around: None, ..*spot })?
            }
        };
        for item in items {
            let called = if item.name.is_empty() { head.clone() } else { item.name.clone() };
            let (color, around) = (spot.color, spot.around);
            put(list, item, &Spot { color, around, ..Spot::new(&called, &called, Some(&head)) })?;
        }
        let around = spot.color.or(spot.around);
        self.children(list, node, &Spot { around, ..Spot::new("", "", Some(&head)) }, depth)
    }

    /// What is in a node, under the parent that is given and in the colour around where it has none else.
    fn children(
        &mut self,
        list: &mut Definition,
        node: usize,
        under: &Spot<'_>,
        depth: usize,
    ) -> Result<(), FormatError> {
        let products = self.products;
        for child in &products.nodes[node].children {
            if !self.shown[child.node] {
                continue;
            }
            if depth >= DEEPEST {
                let text = format!("products hang more than {DEEPEST} deep under one another");
                self.account.problems(vec![Problem::new(child.number, text)]);
                continue;
            }
            let of = &products.nodes[child.node];
            let transform = Some(child.place).filter(|place| *place != Matrix4::identity());
            let called =
                |own: &str, other: &str| if own.is_empty() { other.to_owned() } else { own.to_owned() };
            let (color, around) = (child.color, under.around);
            let (parent, occurrence) = (under.parent, None);
            match self.definitions[child.node].clone() {
                Some(definition) => {
                    let name = called(&child.name, &definition);
                    let label = called(&child.label, &name);
                    let geometry = Arc::new(Geometry::Instance(definition));
                    let lifted = self.lifted.get(child.node).copied().flatten();
                    let item = Item {
                        name: String::new(),
                        geometry,
                        color: lifted,
                        layer: None,
                        tessellation: None,
                    };
                    let spot =
                        Spot { name: &name, label: &label, parent, transform, color, around, occurrence };
                    put(list, item, &spot)?;
                }
                None if self.is_shared(child.node) => {
                    let name = called(&child.name, self.name(&of.name));
                    let label = called(&child.label, &name);
                    let spot =
                        Spot { name: &name, label: &label, parent, transform, color, around, occurrence };
                    self.place(list, child.node, &spot, depth + 1)?;
                }
                None => {
                    let name = called(&of.name, self.name(&child.name));
                    let label = called(&of.label, &name);
                    let own = child.label.as_str();
                    let occurrence = Some(own)
                        .filter(|own| !own.is_empty() && ![name.as_str(), label.as_str()].contains(own));
                    let spot =
                        Spot { name: &name, label: &label, parent, transform, color, around, occurrence };
                    self.place(list, child.node, &spot, depth + 1)?;
                }
            }
        }
        Ok(())
    }
}

/// Adds an object, under a name of its own, which is given back.
fn put(list: &mut Definition, item: Item, spot: &Spot<'_>) -> Result<String, FormatError> {
    let name = list.unique_name(spot.name);
    let mut object = Object::sharing(name.clone(), item.geometry).labelled(spot.label);
    object.color = spot.color.or(item.color).or(spot.around);
    object.statements.extend(spot.occurrence.map(|own| (crate::OCCURRENCE.to_owned(), own.to_owned())));
    object.layer = item.layer;
    object.parent = spot.parent.map(str::to_owned);
    object.transform = spot.transform;
    list.add(object)?;
    Ok(name)
}
