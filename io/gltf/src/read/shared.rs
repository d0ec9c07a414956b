//! Meshes that several nodes show: read once, and one geometry for all that show it alike.

use std::collections::HashMap;
use std::rc::Rc;
use std::sync::Arc;

use loftsman_kernel::Point;
use loftsman_kernel::mesh::Layer;
use loftsman_kernel::plugin::{FormatError, ReadReport};
use loftsman_kernel::scene::Geometry;

use super::body::Bodies;
use super::file::File;
use super::mesh::{self, Content, Shape, Targets};
use super::schema;
use crate::extras::fingerprint;

/// What nodes want of a mesh.
#[derive(Debug, Clone, Copy, Default)]
struct Uses {
    /// How many still want it.
    left: usize,
    /// Whether an animation moves its morph targets, and whether a node has weights of its own for them.
    moves: bool,
    bends: bool,
}

/// A mesh that was read.
struct Known {
    content: Rc<Content>,
    /// What nodes show of it, by the weights of its morph targets and whether it is without tangents.
    shown: HashMap<(Vec<u64>, bool), Shown>,
    /// The fingerprint of its vertices, once somebody has asked.
    fingerprint: Option<Option<String>>,
    /// The exact spline that the last node with one has instead.
    exact: Option<Arc<Geometry>>,
}

/// What a node shows of a mesh: its faces and lines, and its loose points.
#[derive(Clone)]
pub(super) struct Shown {
    pub(super) main: Option<Arc<Geometry>>,
    pub(super) points: Option<Arc<Geometry>>,
}

/// The meshes of a file.
#[derive(Default)]
pub(super) struct Meshes {
    uses: HashMap<usize, Uses>,
    known: HashMap<usize, Known>,
    /// By the fingerprint of the vertices that show it, whatever meshes have them: the exact spline of the first node with one.
    exact: HashMap<String, Arc<Geometry>>,
    bodies: Bodies,
}

impl Meshes {
    /// Looks which of the meshes that nodes want are the same but for their materials.
    pub(super) fn compare(&mut self, file: &File<'_>) {
        for (&mesh, uses) in &self.uses {
            // What cannot be parsed is an error when it is read.
            if let Ok(raw) = file.entry::<schema::Mesh<'_>>("meshes", &file.root.meshes, mesh) {
                self.bodies.expect(&raw, Targets::of(&raw, uses.moves, uses.bends));
            }
        }
    }

    /// Notes that a node shows a mesh.
    pub(super) fn want(&mut self, mesh: usize, moves: bool, bends: bool) {
        let uses = self.uses.entry(mesh).or_default();
        uses.left += 1;
        uses.moves |= moves;
        uses.bends |= bends;
    }

    /// Whether a node shows it.
    pub(super) fn is_wanted(&self, mesh: usize) -> bool {
        self.uses.contains_key(&mesh)
    }

    /// The content of a mesh, read where no node before has asked for it.
    pub(super) fn content(
        &mut self,
        file: &File<'_>,
        mesh: usize,
        report: &mut ReadReport,
    ) -> Result<Rc<Content>, FormatError> {
        if let Some(known) = self.known.get(&mesh) {
            return Ok(Rc::clone(&known.content));
        }
        let uses = self.uses.get(&mesh).copied().unwrap_or_default();
        let content = Rc::new(mesh::read(file, mesh, uses.moves, uses.bends, &mut self.bodies, report)?);
        let known =
            Known { content: Rc::clone(&content), shown: HashMap::new(), fingerprint: None, exact: None };
        self.known.insert(mesh, known);
        Ok(content)
    }

    /// The fingerprint of the vertices of a mesh that was read.
    pub(super) fn fingerprint(&mut self, mesh: usize) -> Option<String> {
        let known = self.known.get_mut(&mesh)?;
        let main = known.content.main.geometry.as_ref();
        let single = |p: &Point| [p.x as f32, p.y as f32, p.z as f32];
        let found = || main.map(|geometry| fingerprint(geometry.points().iter().map(single)));
        known.fingerprint.get_or_insert_with(found).clone()
    }

    /// The exact spline of a node: that of the node before it with this mesh, where it is the same, or of the first one shown by the same vertices. (In another
    /// material the mesh is another.)
    pub(super) fn exact(&mut self, mesh: usize, shown_by: Option<&str>, spline: Geometry) -> Arc<Geometry> {
        let of_mesh = self.known.get(&mesh).and_then(|known| known.exact.as_ref());
        let alike = shown_by.and_then(|by| self.exact.get(by));
        let same = of_mesh.into_iter().chain(alike).find(|same| ***same == spline);
        let spline = same.map_or_else(|| Arc::new(spline), Arc::clone);
        if let Some(by) = shown_by {
            self.exact.entry(by.to_owned()).or_insert_with(|| Arc::clone(&spline));
        }
        if let Some(known) = self.known.get_mut(&mesh) {
            known.exact = Some(Arc::clone(&spline));
        }
        spline
    }

    /// What a node shows of a mesh that was read, with its morph targets as far as the weights say, and without tangents if
    /// it `drops` them. Nodes that ask for the same have the same geometry.
    pub(super) fn shown(
        &mut self,
        file: &File<'_>,
        path: &str,
        mesh: usize,
        weights: &[f64],
        drops: bool,
    ) -> Result<Shown, FormatError> {
        let Some(known) = self.known.get_mut(&mesh) else { return Ok(Shown { main: None, points: None }) };
        let content = &known.content;
        let count = content.main.targets.len().max(content.points.targets.len());
        let bits = |&weight: &f64| if weight == 0.0 { 0 } else { weight.to_bits() };
        let mut bends: Vec<u64> = weights.iter().take(count).map(bits).collect();
        while bends.last() == Some(&0) {
            bends.pop();
        }
        let key = (bends, drops);
        if let Some(shown) = known.shown.get(&key) {
            return Ok(shown.clone());
        }
        let is_copy = !key.0.is_empty() || drops;
        if is_copy && !known.shown.is_empty() {
            let points = content.main.geometry.iter().map(|g| g.points().len()).sum::<usize>();
            // Roughly what a vertex of a triangle mesh with normals and texture coordinates takes.
            file.take(format!("meshes[{mesh}]"), points, 160)?;
        }
        let mut main = bent(file, path, &content.main, weights)?;
        let points = bent(file, path, &content.points, weights)?;
        if let Some(Geometry::Mesh(mesh)) = main.as_mut().filter(|_| drops).map(Arc::make_mut) {
            mesh.tangents = Layer::none();
        }
        let shown = Shown { main, points };
        known.shown.insert(key, shown.clone());
        Ok(shown)
    }

    /// Notes that a node has what it wants of a mesh, which goes with the last.
    pub(super) fn done(&mut self, mesh: usize) {
        if let Some(uses) = self.uses.get_mut(&mesh) {
            uses.left = uses.left.saturating_sub(1);
            if uses.left == 0 {
                self.known.remove(&mesh);
            }
        }
    }
}

/// A shape with its points moved by its morph targets as far as the weights say; itself where they do not move it.
fn bent(
    file: &File<'_>,
    path: &str,
    shape: &Shape,
    weights: &[f64],
) -> Result<Option<Arc<Geometry>>, FormatError> {
    let mut shared = shape.geometry.clone();
    if !weights.iter().zip(shape.targets.iter()).any(|(&weight, _)| weight != 0.0) {
        return Ok(shared);
    }
    let points: &mut [Point] = match shared.as_mut().map(Arc::make_mut) {
        Some(Geometry::Mesh(mesh)) => mesh.points_mut(),
        Some(Geometry::Polyline(line)) => &mut line.points,
        Some(Geometry::Cloud(cloud)) => &mut cloud.points,
        _ => return Ok(shared),
    };
    for (&weight, moves) in weights.iter().zip(shape.targets.iter()) {
        if weight != 0.0 {
            points.iter_mut().zip(moves).for_each(|(p, m)| *p += m * weight);
        }
    }
    if points.iter().all(|p| p.iter().all(|x| x.is_finite())) {
        return Ok(shared);
    }
    Err(file.fail(path, "its weights move points to infinity"))
}
