//! Primitives of a mesh, put together as one shape with material slots.

use std::collections::{BTreeMap, HashMap};
use std::ops::Range;
use std::rc::Rc;
use std::sync::Arc;

use loftsman_kernel::mesh::{Cloud, Mesh, Polyline};
use loftsman_kernel::plugin::{Fate, FormatError, ReadReport};
use loftsman_kernel::scene::Geometry;
use loftsman_kernel::{Point, Vector};

use super::body::Bodies;
use super::file::{File, clip};
use super::schema;
use crate::words::{MESH_DATA, TARGET_NAMES, frame_name};

/// A shape of the file, in its own unit and axes.
#[derive(Debug, Clone, Default)]
pub(super) struct Shape {
    /// A mesh, polyline or cloud; a group where there is nothing.
    pub(super) geometry: Option<Arc<Geometry>>,
    /// The material of the file in each slot.
    pub(super) slots: Vec<Option<usize>>,
    /// For each morph target, what it adds to each point.
    pub(super) targets: Rc<[Vec<Vector>]>,
}

/// What a mesh of the file holds: its faces and lines, and its loose points, which need an object of their own beside
/// those.
#[derive(Debug, Clone, Default)]
pub(super) struct Content {
    pub(super) name: Option<String>,
    pub(super) main: Shape,
    pub(super) points: Shape,
    pub(super) weights: Vec<f64>,
    /// What other programs noted of it.
    pub(super) statements: Vec<(String, String)>,
}

/// An attribute that the kernel has a layer for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Attribute {
    Normal,
    Tangent,
    Uv(usize),
    Color,
}

impl Attribute {
    /// More sets of texture coordinates than any file has.
    const SETS: usize = 16;

    fn of(name: &str) -> Option<Self> {
        Some(match name {
            "NORMAL" => Self::Normal,
            "TANGENT" => Self::Tangent,
            "COLOR_0" => Self::Color,
            _ => {
                let set: usize = name.strip_prefix("TEXCOORD_")?.parse().ok()?;
                return (set < Self::SETS).then_some(Self::Uv(set));
            }
        })
    }
}

/// The vertices of one `POSITION` accessor.
pub(super) struct Block {
    pub(super) first: usize,
    pub(super) count: usize,
}

/// A primitive that was put in.
pub(super) struct Part {
    pub(super) block: usize,
    /// Its corners among all corners of faces.
    pub(super) corners: Range<usize>,
    pub(super) has_lines: bool,
    /// The accessors of its attributes.
    pub(super) layers: BTreeMap<Attribute, usize>,
    pub(super) targets: Vec<Option<usize>>,
    /// Attributes other than positions that its morph targets have.
    further: usize,
}

/// The shape as far as it is put together.
#[derive(Default)]
pub(super) struct Builder {
    pub(super) points: Vec<Point>,
    pub(super) blocks: Vec<Block>,
    /// The block of a `POSITION` accessor.
    by_accessor: HashMap<usize, usize>,
    pub(super) parts: Vec<Part>,
    pub(super) corners: Vec<u32>,
    face_slots: Vec<u32>,
    slots: Vec<Option<usize>>,
    line_corners: Vec<u32>,
    line_starts: Vec<usize>,
    /// The single strip or loop, or the list of lines that are one, where there is nothing else.
    chain: Option<(Vec<u32>, bool)>,
    /// Triangles that use a vertex twice.
    flat: usize,
    /// Vertices left over at the end of lists of triangles or lines.
    left_over: usize,
}

/// Reads a mesh. Its primitives, and what of them is left out, are counted once; its path is `meshes[index]`. An animation
/// `moves` its morph targets, or a node `bends` it by weights of its own.
pub(super) fn read(
    file: &File<'_>,
    index: usize,
    moves: bool,
    bends: bool,
    bodies: &mut Bodies,
    report: &mut ReadReport,
) -> Result<Content, FormatError> {
    let path = format!("meshes[{index}]");
    let raw: schema::Mesh<'_> = file.entry("meshes", &file.root.meshes, index)?;
    let mut statements = Vec::new();
    super::report::keep(raw.extras, "mesh", &[TARGET_NAMES], MESH_DATA, &mut statements, report);
    if moves && raw.extras.is_some_and(|extras| has_names(extras.get())) {
        report.count(Fate::LeftOut, "names of morph targets that are frames now");
    }
    super::report::extensions(raw.extensions.as_ref(), "mesh", report);
    let targets = Targets::of(&raw, moves, bends);
    let (main, points) =
        bodies.shapes(&raw, targets, report, |report| shapes(file, &path, &raw, targets, report))?;
    Ok(Content { name: raw.name, main, points, weights: raw.weights.unwrap_or_default(), statements })
}

/// The primitives of a mesh put together: its faces and lines, and its loose points.
fn shapes(
    file: &File<'_>,
    path: &str,
    raw: &schema::Mesh<'_>,
    targets: Targets,
    report: &mut ReadReport,
) -> Result<(Shape, Shape), FormatError> {
    let mode = |p: &schema::Primitive<'_>| p.mode.map_or(4, |m| m.0);
    let only_points = raw.primitives.iter().all(|p| mode(p) == 0);
    let single = raw.primitives.len() == 1;
    let (mut main, mut loose) = (Builder::default(), Builder::default());
    for (k, primitive) in raw.primitives.iter().enumerate() {
        let path = format!("{path}.primitives[{k}]");
        let mode = mode(primitive);
        if mode > 6 {
            return Err(file.fail(format!("{path}.mode"), format!("the mode {mode} does not exist")));
        }
        let builder = if mode == 0 && !only_points { &mut loose } else { &mut main };
        builder.primitive(file, &path, primitive, mode, single, report)?;
    }
    let main = main.finish(file, path, targets, report)?;
    // What is an object of its own beside the faces has no frames.
    let still = Targets { moves: false, bends: targets.bends || targets.moves };
    Ok((main, loose.finish(file, path, still, report)?))
}

/// What is done with morph targets: an animation makes frames of them, weights bend the shape once.
#[derive(Debug, Clone, Copy)]
pub(super) struct Targets {
    moves: bool,
    bends: bool,
}

impl Targets {
    /// Of a mesh that an animation `moves` or a node `bends`; weights of its own bend it too.
    pub(super) fn of(mesh: &schema::Mesh<'_>, moves: bool, bends: bool) -> Self {
        Self { moves, bends: bends || mesh.weights.iter().flatten().any(|&w| w != 0.0) }
    }
}

/// Whether the extras of a mesh name morph targets otherwise than our writer does.
fn has_names(extras: &str) -> bool {
    let names = serde_json::from_str::<serde_json::Value>(extras).ok();
    let names = names.as_ref().and_then(|extras| extras.get(TARGET_NAMES)).and_then(|names| names.as_array());
    names.is_some_and(|names| {
        names.iter().enumerate().any(|(k, name)| name.as_str() != Some(frame_name(k).as_str()))
    })
}

impl Builder {
    fn primitive(
        &mut self,
        file: &File<'_>,
        path: &str,
        primitive: &schema::Primitive<'_>,
        mode: u64,
        single: bool,
        report: &mut ReadReport,
    ) -> Result<(), FormatError> {
        super::report::extras(primitive.extras, "primitive", report);
        if primitive.extensions.as_ref().is_some_and(|e| e.contains_key("KHR_draco_mesh_compression")) {
            let problem = "its vertices are compressed (KHR_draco_mesh_compression), which is not read: write the file \
                           again without compression (gltf-transform: `gltf-transform copy in.glb out.glb`)";
            return Err(file.fail(path, problem));
        }
        super::report::extensions(primitive.extensions.as_ref(), "primitive", report);
        let Some(position) = primitive.attributes.get("POSITION") else {
            report.count(Fate::LeftOut, "primitive without positions");
            return Ok(());
        };
        let block = self.block(file, path, position.index())?;
        let (first, count) = (self.blocks[block].first, self.blocks[block].count);
        let sequence = match primitive.indices {
            Some(indices) => file.indices(indices.index(), count, &format!("{path}.indices"))?,
            None => {
                file.take(path, count, 4)?;
                (0..u32::try_from(count).unwrap_or(u32::MAX)).collect()
            }
        };
        if sequence.is_empty() {
            report.count(Fate::LeftOut, "primitive without vertices");
            return Ok(());
        }
        let mut layers = BTreeMap::new();
        for (name, accessor) in &primitive.attributes {
            match Attribute::of(name) {
                Some(attribute) => _ = layers.insert(attribute, accessor.index()),
                None if name == "POSITION" => {}
                None => {
                    let what = clip(name);
                    report.count(
                        Fate::LeftOut,
                        &format!("attribute {what}: Loftsman has nothing to keep it in"),
                    );
                }
            }
        }
        let targets = primitive.targets.iter().map(|t| t.get("POSITION").map(|a| a.index())).collect();
        let further =
            primitive.targets.iter().flat_map(BTreeMap::keys).filter(|&name| name != "POSITION").count();
        let before = self.corners.len();
        file.take(path, sequence.len(), 16)?;
        let base = first as u32;
        match mode {
            0 => {}
            1..=3 => {
                // A list of lines in a file of ours is a mesh of lines: polylines are strips there.
                let chains = mode != 1 || !file.is_ours();
                self.lines(&sequence, mode, base, single && layers.is_empty() && chains);
            }
            _ => {
                let slot = self.slot(primitive.material.map(schema::Whole::index));
                self.faces(&sequence, mode, base);
                self.face_slots.resize(self.corners.len() / 3, slot);
            }
        }
        if mode < 4 && primitive.material.is_some() && self.slots.is_empty() {
            // Lines and points have the first material; faces that come later have their own slots.
            self.slot(primitive.material.map(schema::Whole::index));
        }
        let corners = before..self.corners.len();
        self.parts.push(Part { block, corners, has_lines: mode < 4, layers, targets, further });
        report.count(Fate::Kept, "");
        Ok(())
    }

    /// The block of a `POSITION` accessor, read if it is new.
    fn block(&mut self, file: &File<'_>, path: &str, accessor: usize) -> Result<usize, FormatError> {
        if let Some(&block) = self.by_accessor.get(&accessor) {
            return Ok(block);
        }
        let user = format!("{path}.attributes.POSITION");
        let elements = file.elements(accessor, &user)?;
        if elements.components != 3 {
            return Err(file.fail(
                &user,
                format!("positions of {} numbers; they must be of type VEC3", elements.components),
            ));
        }
        let first = self.points.len();
        let positions = file.vectors::<3>(&elements, 0.0, &user)?;
        if let Some(at) = positions.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
            let problem =
                format!("vertex {at} is {:?} (used by {user}): every number must be finite", positions[at]);
            return Err(file.fail(format!("accessors[{accessor}]"), problem));
        }
        if u32::try_from(first + positions.len()).is_err() {
            return Err(file.fail(path, "the mesh has more vertices than 32 bits can number: split it"));
        }
        self.points.extend(positions.into_iter().map(Point::from));
        self.blocks.push(Block { first, count: self.points.len() - first });
        self.by_accessor.insert(accessor, self.blocks.len() - 1);
        Ok(self.blocks.len() - 1)
    }

    fn slot(&mut self, material: Option<usize>) -> u32 {
        let known = self.slots.iter().position(|&m| m == material);
        known.unwrap_or_else(|| {
            self.slots.push(material);
            self.slots.len() - 1
        }) as u32
    }

    /// The triangles of a list, strip or fan (glTF 2.0, §3.7.2.1).
    fn faces(&mut self, sequence: &[u32], mode: u64, base: u32) {
        let mut push = |t: [u32; 3]| {
            if t[0] != t[1] && t[1] != t[2] && t[2] != t[0] {
                self.corners.extend(t.map(|i| base + i));
            } else {
                // Strips turn corners by triangles without area: those are no loss.
                self.flat += usize::from(mode == 4);
            }
        };
        match mode {
            4 => {
                let triangles = sequence.chunks_exact(3);
                self.left_over += triangles.remainder().len();
                triangles.for_each(|t| push([t[0], t[1], t[2]]));
            }
            5 => {
                for (i, t) in sequence.windows(3).enumerate() {
                    push(if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[0], t[2], t[1]] });
                }
            }
            _ => {
                for pair in sequence[1..].windows(2) {
                    push([pair[0], pair[1], sequence[0]]);
                }
            }
        }
    }

    /// The chains of a list, loop or strip of lines. `alone`: there is nothing else in the mesh.
    fn lines(&mut self, sequence: &[u32], mode: u64, base: u32, alone: bool) {
        if self.line_starts.is_empty() {
            self.line_starts.push(0);
        }
        if mode == 1 {
            let pairs = sequence.chunks_exact(2);
            self.left_over += pairs.remainder().len();
            let mut end = None;
            for pair in pairs {
                // Segments that go on where the last one ended are one chain.
                if end == Some(pair[0]) {
                    self.line_corners.push(base + pair[1]);
                    if let Some(last) = self.line_starts.last_mut() {
                        *last = self.line_corners.len();
                    }
                } else {
                    self.line_corners.extend([base + pair[0], base + pair[1]]);
                    self.line_starts.push(self.line_corners.len());
                }
                end = Some(pair[1]);
            }
            if alone {
                self.chain = chain_of(sequence);
            }
            return;
        }
        if sequence.len() < 2 {
            self.left_over += sequence.len();
            return;
        }
        let comes_back = sequence.len() > 2 && sequence.first() == sequence.last();
        self.line_corners.extend(sequence.iter().map(|i| base + i));
        if mode == 2 {
            self.line_corners.push(base + sequence[0]);
        }
        self.line_starts.push(self.line_corners.len());
        if alone {
            let open = if mode == 3 && comes_back { &sequence[..sequence.len() - 1] } else { sequence };
            self.chain = Some((open.to_vec(), mode == 2 || comes_back));
        }
    }

    fn finish(
        mut self,
        file: &File<'_>,
        path: &str,
        wanted: Targets,
        report: &mut ReadReport,
    ) -> Result<Shape, FormatError> {
        if self.flat > 0 {
            report.count_many(Fate::LeftOut, "triangle that uses a vertex twice", self.flat);
        }
        if self.left_over > 0 {
            report.count_many(Fate::LeftOut, "vertex left over at the end of a primitive", self.left_over);
        }
        if self.parts.is_empty() {
            return Ok(Shape::default());
        }
        let count = self.parts.iter().map(|p| p.targets.len()).max().unwrap_or(0);
        if !wanted.moves {
            let reason = "morph target that nothing animates: the shape is as the weights say";
            report.count_many(Fate::LeftOut, reason, count);
        } else {
            let reason = "normals, tangents or other attributes of a morph target: only points have frames";
            report.count_many(Fate::LeftOut, reason, self.parts.iter().map(|p| p.further).sum());
        }
        let mut targets =
            if wanted.moves || wanted.bends { self.targets(file, path, count)? } else { Vec::new() };
        let slots = std::mem::take(&mut self.slots);
        let has_layers = self.parts.iter().any(|p| !p.layers.is_empty());
        if self.corners.is_empty() && self.line_corners.is_empty() && !has_layers {
            let geometry = Some(Arc::new(Geometry::Cloud(Cloud { points: self.points })));
            return Ok(Shape { geometry, slots, targets: targets.into() });
        }
        if let Some((order, closed)) = self.chain.take()
            && is_permutation(&order, self.points.len())
        {
            let points = order.iter().map(|&i| self.points[i as usize]).collect();
            for target in &mut targets {
                *target = order.iter().map(|&i| target[i as usize]).collect();
            }
            return Ok(Shape {
                geometry: Some(Arc::new(Geometry::Polyline(Polyline { points, closed }))),
                slots,
                targets: targets.into(),
            });
        }
        let normals = self.layer(file, path, Attribute::Normal, 0.0, report, Vector::from)?;
        let tangents = self.layer(file, path, Attribute::Tangent, 1.0, report, |t: [f64; 4]| t)?;
        let colors = self.layer(file, path, Attribute::Color, 1.0, report, |c: [f64; 4]| c)?;
        let sets = self.parts.iter().flat_map(|p| p.layers.keys());
        let sets = sets.filter_map(|a| if let Attribute::Uv(set) = a { Some(set + 1) } else { None });
        let sets = sets.max().unwrap_or(0);
        let mut uvs = Vec::new();
        for set in 0..sets {
            // Up here, down there.
            uvs.push(
                self.layer(file, path, Attribute::Uv(set), 0.0, report, |[u, v]: [f64; 2]| [u, 1.0 - v])?,
            );
        }
        file.take(path, self.corners.len() / 3, size_of::<usize>())?;
        let starts = (0..=self.corners.len() / 3).map(|f| 3 * f).collect();
        let fail = |e: loftsman_kernel::Error| file.fail(path, e.to_string());
        let mut mesh = Mesh::from_parts(self.points, self.corners, starts).map_err(fail)?;
        mesh.set_lines(self.line_corners, self.line_starts).map_err(fail)?;
        (mesh.normals, mesh.tangents, mesh.colors) = (normals, tangents, colors);
        let mut uvs = uvs.into_iter();
        mesh.uvs = uvs.next().unwrap_or_default();
        mesh.more_uvs = uvs.collect();
        if slots.len() > 1 {
            mesh.materials = self.face_slots;
        }
        Ok(Shape { geometry: Some(Arc::new(Geometry::Mesh(mesh))), slots, targets: targets.into() })
    }
}

/// Whether every index below `count` is there, once.
/// The vertices of lines, two each, that are one chain, in its order, and whether it comes back: so other programs write a polyline, their edges in
/// any order. It begins at the end that is numbered first, or, where it has none, at its first vertex, along that one's first line.
fn chain_of(pairs: &[u32]) -> Option<(Vec<u32>, bool)> {
    let count = pairs.iter().max().map_or(0, |&most| most as usize + 1);
    // More vertices than lines have ends are not in one chain, however large their numbers.
    if count > pairs.len() {
        return None;
    }
    let mut beside: Vec<[Option<u32>; 2]> = vec![[None; 2]; count];
    for pair in pairs.chunks_exact(2) {
        for (from, to) in [(pair[0], pair[1]), (pair[1], pair[0])] {
            let free = beside[from as usize].iter_mut().find(|to| to.is_none())?;
            *free = Some(to);
        }
    }
    let start = beside.iter().position(|next| next[1].is_none());
    let closed = start.is_none();
    let mut order = vec![start.unwrap_or(0) as u32];
    let mut before = None;
    while let Some(&at) = order.last() {
        let [first, second] = beside[at as usize];
        let next = if before.is_some() && first == before { second } else { first };
        before = Some(at);
        match next {
            Some(next) if Some(&next) != order.first() && order.len() < count => order.push(next),
            _ => break,
        }
    }
    (order.len() == count && count > if closed { 2 } else { 1 }).then_some((order, closed))
}

fn is_permutation(order: &[u32], count: usize) -> bool {
    let mut seen = vec![false; count];
    order.len() == count
        && count > 1
        && order.iter().all(|&i| seen.get_mut(i as usize).is_some_and(|s| !std::mem::replace(s, true)))
}
