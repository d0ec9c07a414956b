//! The hierarchy as nodes with numbers.

use std::collections::HashMap;

use loftsman_kernel::scene::{Geometry, Object, Scene};

use super::Nodes;
use super::schema::Node;

/// Which objects hang under which.
pub(super) struct Tree {
    pub(super) roots: Vec<usize>,
    pub(super) children: Vec<Vec<usize>>,
}

impl Tree {
    pub(super) fn of(scene: &Scene) -> Self {
        let objects = scene.objects();
        let mut tree = Self { roots: Vec::new(), children: vec![Vec::new(); objects.len()] };
        let index: HashMap<&str, usize> = objects.iter().enumerate().map(|(i, o)| (o.name(), i)).collect();
        for (i, object) in objects.iter().enumerate() {
            match object.parent.as_deref().and_then(|name| index.get(name)) {
                Some(&parent) => tree.children[parent].push(i),
                None => tree.roots.push(i),
            }
        }
        tree
    }
}

/// Leaves out the nodes of objects that could not be written and have nothing below them that was, and numbers the
/// others.
pub(super) fn number(nodes: Vec<Node>, tree: &Tree, objects: &[Object]) -> Nodes {
    let mut shown: Vec<bool> = nodes
        .iter()
        .zip(objects)
        .map(|(node, object)| {
            node.mesh.is_some() || node.is_unseen || matches!(object.geometry(), Geometry::Group)
        })
        .collect();
    // From the leaves up: what hangs under it keeps a node.
    let mut order = Vec::with_capacity(objects.len());
    let mut open = tree.roots.clone();
    while let Some(index) = open.pop() {
        order.push(index);
        open.extend(&tree.children[index]);
    }
    for &index in order.iter().rev() {
        shown[index] = shown[index] || tree.children[index].iter().any(|&child| shown[child]);
    }
    let mut numbers = vec![None; objects.len()];
    let mut next = 0;
    for (number, _) in numbers.iter_mut().zip(&shown).filter(|(_, shown)| **shown) {
        *number = Some(next);
        next += 1;
    }
    let mut kept = Vec::with_capacity(next);
    for (index, mut node) in nodes.into_iter().enumerate().filter(|(index, _)| shown[*index]) {
        node.children = tree.children[index].iter().filter_map(|&child| numbers[child]).collect();
        kept.push(node);
    }
    let top = tree.roots.iter().filter_map(|&root| numbers[root]).collect();
    (kept, top, numbers)
}
