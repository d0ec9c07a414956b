//! Colours that parts have where one occurrence shows them, and nowhere else.

use std::collections::{BTreeMap, HashSet};

use super::entity::{Problem, entity, kind};
use super::product::{Child, Node, Products, representation};
use super::report::Account;
use super::style::{Styles, Within};
use crate::part21::File;

/// Gives occurrences the colours that are said of what they show in their contexts. O(colours + occurrences).
pub(crate) fn color(
    file: &File<'_>,
    products: &mut Products,
    styles: &mut Styles,
    account: &mut Account<'_, '_>,
) {
    let mut asked: BTreeMap<u64, Vec<Within>> = BTreeMap::new();
    let mut everywhere = Vec::new();
    for within in std::mem::take(&mut styles.within) {
        match products.occurrence(within.context) {
            Some(usage) => asked.entry(usage).or_default().push(within),
            None => everywhere.push(within),
        }
    }
    styles.everywhere(everywhere);
    if asked.is_empty() {
        return;
    }
    let counts: Vec<usize> = products.nodes.iter().map(|node| own_items(file, node)).collect();
    for child in products.nodes.iter_mut().flat_map(|node| &mut node.children) {
        let Some(said) = asked.remove(&child.number) else { continue };
        match one_color(file, &said, counts[child.node]) {
            Ok(color) => {
                child.color = Some(color);
                styles.read.extend(said.iter().map(|within| within.number));
            }
            Err(why) => {
                account.problems(said.iter().map(|within| Problem::new(within.number, why)).collect());
            }
        }
    }
}

/// The colour of all that an occurrence shows, or why there is no such colour.
fn one_color(file: &File<'_>, said: &[Within], count: usize) -> Result<[f64; 4], &'static str> {
    let face = |within: &Within| kind(file, within.item).ends_with(b"FACE");
    if said.iter().any(face) {
        return Err(
            "it colours a face of one occurrence: faces have the same colours wherever their part is shown",
        );
    }
    let items: HashSet<u64> = said.iter().map(|within| within.item).collect();
    if items.len() < count {
        return Err("it colours some of what one occurrence shows: an instance has one colour for all of it");
    }
    match said {
        [first, others @ ..] if others.iter().all(|within| within.color == first.color) => Ok(first.color),
        _ => Err("it is one of several colours of one occurrence: an instance has one colour for all of it"),
    }
}

/// How many items a product has itself, where nothing else is in it; 0 otherwise.
fn own_items(file: &File<'_>, node: &Node) -> usize {
    if !node.children.is_empty() {
        return 0;
    }
    let items = node.representations.iter().filter_map(|&number| {
        let found = entity(file, number).ok()?;
        representation(&found).ok()?.references(1).ok()
    });
    items.flatten().filter(|&item| kind(file, item) != b"AXIS2_PLACEMENT_3D").count()
}

/// The colours of parts that go to their instances, where one of these has a colour of its own: what an instance shows has
/// its own colour before that of the instance. `own` is the colour of a part that is a single thing and a definition.
pub(crate) fn lifted(nodes: &[Node], own: impl Fn(usize) -> Option<[f64; 4]>) -> Vec<Option<[f64; 4]>> {
    // What an occurrence of a colour shows, however far below.
    let mut reached = vec![false; nodes.len()];
    let colored = |child: &&Child| child.color.is_some();
    let mut waiting: Vec<usize> =
        nodes.iter().flat_map(|node| node.children.iter().filter(colored)).map(|child| child.node).collect();
    while let Some(node) = waiting.pop() {
        if !std::mem::replace(&mut reached[node], true) {
            waiting.extend(nodes[node].children.iter().map(|child| child.node));
        }
    }
    reached.iter().enumerate().map(|(node, &reached)| own(node).filter(|_| reached)).collect()
}

/// Whether anything in each node keeps a colour whatever an instance of the node has.
pub(crate) fn keeping(nodes: &[Node], keeps: impl Fn(usize) -> bool) -> Vec<bool> {
    let mut parents = vec![Vec::new(); nodes.len()];
    for (node, found) in nodes.iter().enumerate() {
        found.children.iter().for_each(|child| parents[child.node].push((node, child.color.is_some())));
    }
    let mut keeping: Vec<bool> = (0..nodes.len()).map(keeps).collect();
    let mut waiting = Vec::new();
    for node in 0..nodes.len() {
        for &(parent, colored) in &parents[node] {
            keeping[parent] |= colored;
        }
    }
    waiting.extend((0..nodes.len()).filter(|&node| keeping[node]));
    while let Some(node) = waiting.pop() {
        for &(parent, _) in &parents[node] {
            if !std::mem::replace(&mut keeping[parent], true) {
                waiting.push(parent);
            }
        }
    }
    keeping
}
