//! Which nodes the scene that is shown has, and what hangs under what.

use loftsman_kernel::plugin::{Fate, FormatError, ReadReport};
use loftsman_kernel::scene::{Object, Scene};

use super::file::File;
use super::schema;
use crate::words::{SCENE_DATA, SCENE_NAME};

/// Which nodes there are, and what hangs under what.
pub(super) struct Tree {
    /// Those of the scene, ascending.
    pub(super) nodes: Vec<usize>,
    pub(super) parent: Vec<Option<usize>>,
    pub(super) mesh: Vec<Option<usize>>,
    /// Whether a node bends its mesh by weights of its own.
    pub(super) bends: Vec<bool>,
}

impl Tree {
    pub(super) fn of(
        file: &File<'_>,
        scene: &mut Scene,
        report: &mut ReadReport,
    ) -> Result<Self, FormatError> {
        let count = file.root.nodes.len();
        let mut tree = Self {
            nodes: Vec::new(),
            parent: vec![None; count],
            mesh: vec![None; count],
            bends: vec![false; count],
        };
        let mut seen = vec![false; count];
        let (roots, list) = roots(file, scene, report)?;
        let mut open: Vec<(usize, Option<usize>)> = roots.into_iter().rev().map(|r| (r, None)).collect();
        while let Some((node, parent)) = open.pop() {
            let path = match parent {
                Some(parent) => format!("nodes[{parent}].children"),
                None => list.clone(),
            };
            if node >= count {
                return Err(file.fail(path, format!("the node {node} does not exist; there are {count}")));
            }
            if std::mem::replace(&mut seen[node], true) {
                let problem = format!(
                    "the node {node} is there twice, or hangs under itself: a node has one place in a scene; give each \
                     place a node of its own"
                );
                return Err(file.fail(path, problem));
            }
            // An object with its name and its place in tables, and what is known of it until it is one.
            file.take(&path, 1, size_of::<Object>() + 512)?;
            let raw: schema::Node<'_> = file.entry("nodes", &file.root.nodes, node)?;
            tree.parent[node] = parent;
            tree.mesh[node] = raw.mesh.map(schema::Whole::index);
            tree.bends[node] = raw.weights.is_some();
            tree.nodes.push(node);
            open.extend(raw.children.iter().rev().map(|c| (c.index(), Some(node))));
        }
        report.count_many(Fate::LeftOut, "node outside of the scene that is shown", count - tree.nodes.len());
        tree.nodes.sort_unstable();
        Ok(tree)
    }
}

/// The nodes at the top of the scene that is shown, and where they are listed: of the default scene, else of the first;
/// in a file without scenes those that hang under no other.
fn roots(
    file: &File<'_>,
    shows: &mut Scene,
    report: &mut ReadReport,
) -> Result<(Vec<usize>, String), FormatError> {
    let scenes = file.root.scenes.len();
    if scenes > 0 {
        let shown = file.root.scene.map_or(0, schema::Whole::index);
        report.count_many(Fate::LeftOut, "scene besides the one that is shown", scenes - 1);
        let scene: schema::Scene<'_> = file.entry("scenes", &file.root.scenes, shown)?;
        super::report::keep(scene.extras, "scene", &[], SCENE_DATA, &mut shows.statements, report);
        shows.statements.extend(scene.name.map(|name| (SCENE_NAME.to_owned(), name)));
        super::report::extensions(scene.extensions.as_ref(), "scene", report);
        let nodes = scene.nodes.into_iter().map(schema::Whole::index).collect();
        return Ok((nodes, format!("scenes[{shown}].nodes")));
    }
    if let Some(scene) = file.root.scene {
        let problem = format!("it is the scene {}, and the document has none", scene.index());
        return Err(file.fail("scene", problem));
    }
    let count = file.root.nodes.len();
    let mut hangs = vec![false; count];
    for node in 0..count {
        let raw: schema::Node<'_> = file.entry("nodes", &file.root.nodes, node)?;
        for child in raw.children {
            if let Some(flag) = hangs.get_mut(child.index()) {
                *flag = true;
            }
        }
    }
    let roots: Vec<usize> = (0..count).filter(|&n| !hangs[n]).collect();
    if roots.is_empty() && count > 0 {
        return Err(file.fail("nodes", "every node hangs under another: the hierarchy is cyclic"));
    }
    Ok((roots, "nodes".to_owned()))
}
