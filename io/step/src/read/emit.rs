//! From products to the objects of a scene: each on its place, what is shown more than once as a definition.

use std::collections::BTreeSet;

use loftsman_kernel::plugin::{FormatError, ReadOptions};
use loftsman_kernel::scene::{Definition, Geometry, Layer, Object, Scene, Up};
use nalgebra::Matrix4;

use super::entity::{Problem, entity, kind};
use super::items::{Item, Items};
use super::place::Space;
use super::product::{Node, Products, Role, representation, units};
use super::report::Account;
use super::style::Styles;
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
}

/// Where something is put.
struct Spot<'n> {
    name: &'n str,
    label: &'n str,
    parent: Option<&'n str>,
    transform: Option<Matrix4<f64>>,
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
        let (items, marks, shown, definitions) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { file, products, styles, contexts, account, stem, items, marks, shown, definitions }
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
        self.shown = self.which_show();
        let mut scene = Scene::new();
        scene.unit = self.contexts.unit();
        scene.up = Up::Z;
        // Names first: definitions show one another, in any order.
        let mut names = Scene::new();
        for (node, found) in nodes.iter().enumerate() {
            let is_one =
                self.shown[node] && (found.uses > 1 || found.uses > 0 && found.role == Role::Definition);
            let name = names.unique_name(self.name(&found.name));
            if is_one {
                names.add(Object::new(name.clone(), Geometry::Group))?;
            }
            self.definitions.push(is_one.then_some(name));
        }
        for node in 0..nodes.len() {
            if let Some(name) = self.definitions[node].clone() {
                let mut list = Definition::new(name);
                self.body(&mut list, node)?;
                scene.define(list)?;
            }
        }
        let mut all = Definition::new("scene");
        for (node, found) in nodes.iter().enumerate() {
            if found.uses == 0 && self.shown[node] && found.role == Role::Scene {
                self.children(&mut all, node, None, 0)?;
            } else if found.uses == 0 && self.shown[node] {
                let name = self.name(&found.name).to_owned();
                let label = found.label.clone();
                let spot = Spot { name: &name, label: &label, parent: None, transform: None };
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
            let spot = Spot { name: &called, label: &called, parent: None, transform: None };
            put(list, item, &spot)?;
        }
        self.children(list, node, None, 0)
    }

    /// A node as objects: one, or a group with what is in it and below it.
    fn place(
        &mut self,
        list: &mut Definition,
        node: usize,
        spot: &Spot<'_>,
        depth: usize,
    ) -> Result<(), FormatError> {
        let mut items = std::mem::take(&mut self.items[node]);
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
                let group = Item { name: String::new(), geometry: Geometry::Group, color, layer };
                put(list, group, spot)?
            }
        };
        for item in items {
            let called = if item.name.is_empty() { head.clone() } else { item.name.clone() };
            put(list, item, &Spot { name: &called, label: &called, parent: Some(&head), transform: None })?;
        }
        self.children(list, node, Some(&head), depth)
    }

    fn children(
        &mut self,
        list: &mut Definition,
        node: usize,
        parent: Option<&str>,
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
            match self.definitions[child.node].clone() {
                Some(definition) => {
                    let name = called(&child.name, &definition);
                    let label = called(&child.label, &name);
                    let geometry = Geometry::Instance(definition);
                    let item = Item { name: String::new(), geometry, color: None, layer: None };
                    put(list, item, &Spot { name: &name, label: &label, parent, transform })?;
                }
                None => {
                    let name = called(&of.name, self.name(&child.name));
                    let label = called(&of.label, &name);
                    let spot = Spot { name: &name, label: &label, parent, transform };
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
    let mut object = Object::new(name.clone(), item.geometry).labelled(spot.label);
    object.color = item.color;
    object.layer = item.layer;
    object.parent = spot.parent.map(str::to_owned);
    object.transform = spot.transform;
    list.add(object)?;
    Ok(name)
}
