//! Primitives of a mesh, put together as one shape with material slots.

use std::collections::{BTreeMap, HashMap};
use std::ops::Range;

use loftsman_kernel::mesh::{Cloud, Layer, Mesh, NONE, Polyline};
use loftsman_kernel::plugin::{Fate, FormatError, ReadReport};
use loftsman_kernel::scene::Geometry;
use loftsman_kernel::{Point, Vector};

use super::file::{File, clip};
use super::schema;

/// A shape of the file, in its own unit and axes.
#[derive(Debug, Clone, Default)]
pub(super) struct Shape {
    /// A mesh, polyline or cloud; a group where there is nothing.
    pub(super) geometry: Option<Geometry>,
    /// The material of the file in each slot.
    pub(super) slots: Vec<Option<usize>>,
    /// For each morph target, what it adds to each point.
    pub(super) targets: Vec<Vec<Vector>>,
}

/// What a mesh of the file holds: its faces and lines, and its loose points, which need an object of their own beside
/// those.
#[derive(Debug, Clone, Default)]
pub(super) struct Content {
    pub(super) name: Option<String>,
    pub(super) main: Shape,
    pub(super) points: Shape,
    pub(super) weights: Vec<f64>,
}

/// An attribute that the kernel has a layer for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Attribute {
    Normal,
    Uv(usize),
    Color,
}

impl Attribute {
    /// More sets of texture coordinates than any file has.
    const SETS: usize = 16;

    fn of(name: &str) -> Option<Self> {
        Some(match name {
            "NORMAL" => Self::Normal,
            "COLOR_0" => Self::Color,
            _ => {
                let set: usize = name.strip_prefix("TEXCOORD_")?.parse().ok()?;
                return (set < Self::SETS).then_some(Self::Uv(set));
            }
        })
    }
}

/// The vertices of one `POSITION` accessor.
struct Block {
    first: usize,
    count: usize,
}

/// A primitive that was put in.
struct Part {
    block: usize,
    /// Its corners among all corners of faces.
    corners: Range<usize>,
    has_lines: bool,
    /// The accessors of its attributes.
    layers: BTreeMap<Attribute, usize>,
    targets: Vec<Option<usize>>,
}

/// The shape as far as it is put together.
#[derive(Default)]
struct Builder {
    points: Vec<Point>,
    blocks: Vec<Block>,
    /// The block of a `POSITION` accessor.
    by_accessor: HashMap<usize, usize>,
    parts: Vec<Part>,
    corners: Vec<u32>,
    face_slots: Vec<u32>,
    slots: Vec<Option<usize>>,
    line_corners: Vec<u32>,
    line_starts: Vec<usize>,
    /// The single strip or loop, where there is nothing else.
    chain: Option<(Vec<u32>, bool)>,
    /// Triangles that use a vertex twice.
    flat: usize,
    /// Vertices left over at the end of lists of triangles or lines.
    left_over: usize,
}

/// Reads a mesh. Its primitives, and what of them is left out, are counted once; its path is `meshes[index]`.
pub(super) fn read(
    file: &File<'_>,
    index: usize,
    with_targets: bool,
    report: &mut ReadReport,
) -> Result<Content, FormatError> {
    let path = format!("meshes[{index}]");
    let raw: schema::Mesh<'_> = file.entry("meshes", &file.root.meshes, index)?;
    super::report::extras(raw.extras, "mesh", report);
    super::report::extensions(raw.extensions.as_ref(), "mesh", report);
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
    let finish =
        |builder: Builder, report: &mut ReadReport| builder.finish(file, &path, with_targets, report);
    Ok(Content {
        name: raw.name,
        main: finish(main, report)?,
        points: finish(loose, report)?,
        weights: raw.weights.unwrap_or_default(),
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
        let before = self.corners.len();
        file.take(path, sequence.len(), 16)?;
        let base = first as u32;
        match mode {
            0 => {}
            1..=3 => self.lines(&sequence, mode, base, single && layers.is_empty()),
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
        self.parts.push(Part { block, corners, has_lines: mode < 4, layers, targets });
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
            return;
        }
        if sequence.len() < 2 {
            self.left_over += sequence.len();
            return;
        }
        let comes_back = sequence.len() > 3 && sequence.first() == sequence.last();
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
        with_targets: bool,
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
        let mut targets = if with_targets { self.targets(file, path)? } else { Vec::new() };
        let slots = std::mem::take(&mut self.slots);
        let has_layers = self.parts.iter().any(|p| !p.layers.is_empty());
        if self.corners.is_empty() && self.line_corners.is_empty() && !has_layers {
            let geometry = Some(Geometry::Cloud(Cloud { points: self.points }));
            return Ok(Shape { geometry, slots, targets });
        }
        if let Some((order, closed)) = self.chain.take()
            && is_permutation(&order, self.points.len())
        {
            let points = order.iter().map(|&i| self.points[i as usize]).collect();
            for target in &mut targets {
                *target = order.iter().map(|&i| target[i as usize]).collect();
            }
            return Ok(Shape {
                geometry: Some(Geometry::Polyline(Polyline { points, closed })),
                slots,
                targets,
            });
        }
        let normals = self.layer(file, path, Attribute::Normal, 0.0, report, Vector::from)?;
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
        (mesh.normals, mesh.colors) = (normals, colors);
        let mut uvs = uvs.into_iter();
        mesh.uvs = uvs.next().unwrap_or_default();
        mesh.more_uvs = uvs.collect();
        if slots.len() > 1 {
            mesh.materials = self.face_slots;
        }
        Ok(Shape { geometry: Some(Geometry::Mesh(mesh)), slots, targets })
    }

    /// What each morph target adds to each point.
    fn targets(&self, file: &File<'_>, path: &str) -> Result<Vec<Vec<Vector>>, FormatError> {
        let count = self.parts.iter().map(|p| p.targets.len()).max().unwrap_or(0);
        let mut targets = Vec::new();
        for k in 0..count {
            let user = format!("{path}: morph target {k}");
            file.take(&user, self.points.len(), size_of::<Vector>())?;
            let mut moves = vec![Vector::zeros(); self.points.len()];
            for part in &self.parts {
                let Some(&Some(accessor)) = part.targets.get(k) else { continue };
                let block = &self.blocks[part.block];
                let values = attribute::<3>(file, accessor, block.count, 0.0, &user)?;
                let Some(values) = values else {
                    return Err(file.fail(user, "it has numbers that are not finite"));
                };
                for (slot, value) in moves[block.first..].iter_mut().zip(values) {
                    *slot = Vector::from(value);
                }
            }
            targets.push(moves);
        }
        Ok(targets)
    }

    /// A layer: by points where every vertex has one value, else by corners.
    fn layer<const N: usize, T: Clone>(
        &self,
        file: &File<'_>,
        path: &str,
        attribute_of: Attribute,
        fill: f64,
        report: &mut ReadReport,
        value: impl Fn([f64; N]) -> T,
    ) -> Result<Layer<T>, FormatError> {
        let user = format!("{path}: {attribute_of:?}");
        // The values of each accessor, read once; `None` where they are not finite.
        let mut read: BTreeMap<(usize, usize), Option<Vec<T>>> = BTreeMap::new();
        let mut broken = 0;
        for part in &self.parts {
            let Some(&accessor) = part.layers.get(&attribute_of) else { continue };
            let count = self.blocks[part.block].count;
            if let std::collections::btree_map::Entry::Vacant(slot) = read.entry((part.block, accessor)) {
                let values = attribute::<N>(file, accessor, count, fill, &user)?;
                broken += usize::from(values.is_none());
                slot.insert(values.map(|v| v.into_iter().map(&value).collect()));
            }
        }
        if broken > 0 {
            let reason = format!("attribute with numbers that are not finite ({attribute_of:?})");
            report.count_many(Fate::LeftOut, &reason, broken);
        }
        let of = |part: &Part| {
            let accessor = part.layers.get(&attribute_of)?;
            let key = (part.block, *accessor);
            read.get(&key)?.as_ref().map(|values| (key, values))
        };
        if self.parts.iter().all(|p| of(p).is_none()) {
            return Ok(Layer::none());
        }
        let mut by_block: Vec<Option<(usize, usize)>> = vec![None; self.blocks.len()];
        let one_a_point = self.parts.iter().all(|part| match (of(part), by_block[part.block]) {
            (None, _) => false,
            (Some((key, _)), Some(known)) => key == known,
            (Some((key, _)), None) => {
                by_block[part.block] = Some(key);
                true
            }
        });
        if one_a_point {
            let mut values = Vec::with_capacity(self.points.len());
            for key in by_block.into_iter().flatten() {
                values.extend(read.remove(&key).flatten().unwrap_or_default());
            }
            return Ok(Layer::per_point(values));
        }
        // Values in the order in which corners use them first, each once: unused ones are of no use.
        let (mut values, mut corners) = (Vec::new(), vec![NONE; self.corners.len()]);
        let mut places: HashMap<((usize, usize), u32), u32> = HashMap::new();
        let mut at_lines = 0;
        for part in &self.parts {
            let Some((key, list)) = of(part) else { continue };
            at_lines += usize::from(part.has_lines);
            let first = self.blocks[part.block].first as u32;
            for corner in part.corners.clone() {
                let vertex = self.corners[corner] - first;
                corners[corner] = *places.entry((key, vertex)).or_insert_with(|| {
                    values.push(list[vertex as usize].clone());
                    values.len() as u32 - 1
                });
            }
        }
        if at_lines > 0 {
            let reason = format!("attribute of lines whose faces differ in it ({attribute_of:?})");
            report.count_many(Fate::LeftOut, &reason, at_lines);
        }
        Ok(Layer::per_corner(values, corners))
    }
}

/// The values of an attribute of `count` vertices; `None` where some are not finite.
fn attribute<const N: usize>(
    file: &File<'_>,
    accessor: usize,
    count: usize,
    fill: f64,
    user: &str,
) -> Result<Option<Vec<[f64; N]>>, FormatError> {
    let elements = file.elements(accessor, user)?;
    if elements.count != count {
        let problem = format!(
            "{} elements for {count} vertices (used by {user}): there must be one each",
            elements.count
        );
        return Err(file.fail(format!("accessors[{accessor}]"), problem));
    }
    // Colours may lack alpha, all else has all its components.
    let fits = elements.components == N || N == 4 && elements.components == 3;
    if !fits {
        let found = elements.components;
        let problem = format!("elements of {found} numbers where {N} are needed (used by {user})");
        return Err(file.fail(format!("accessors[{accessor}]"), problem));
    }
    let elements = if N == 4 { elements.normalized() } else { elements };
    let values = file.vectors::<N>(&elements, fill, user)?;
    Ok(values.iter().flatten().all(|x| x.is_finite()).then_some(values))
}

/// Whether every index below `count` is there, once.
fn is_permutation(order: &[u32], count: usize) -> bool {
    let mut seen = vec![false; count];
    order.len() == count
        && count > 1
        && order.iter().all(|&i| seen.get_mut(i as usize).is_some_and(|s| !std::mem::replace(s, true)))
}
