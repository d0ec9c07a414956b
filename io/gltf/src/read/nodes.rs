//! Nodes as objects: hierarchy, transforms, meshes, frames; each led back to where it was.

use std::collections::HashMap;
use std::sync::Arc;

use loftsman_kernel::material::Material;
use loftsman_kernel::named::Named;
use loftsman_kernel::placement::Change;
use loftsman_kernel::plugin::{Fate, FormatError, ReadOptions, ReadReport};
use loftsman_kernel::scene::{Animation, Geometry, Object, Scene, Unit, Up};
use loftsman_kernel::text::{clip, counted};
use nalgebra::Matrix4;

use super::animation::{self, Track};
use super::file::File;
use super::material::Look;
use super::noted::{Beside, Frames, exact, own};
use super::schema;
use super::shared::Meshes;
use super::tree::Tree;
use crate::extras::{ExtrasFields, Loose, matrix};
use crate::place::Numbers;
use crate::words::{COLOR, DATA, EXTRAS, MATERIAL, MESH_NAME, NONE, PLACEMENT, UNNAMED};

/// How far a noted transform may be from what the node says, relative to its largest number: single precision, as other
/// programs pass transforms on.
const AGREES: f64 = 2e-6;

/// Reads the nodes of the scene that is shown into `scene`, in the file's unit and axes at first; the result is in those
/// that were noted.
pub(super) fn read(
    file: &File<'_>,
    mut scene: Scene,
    frames: Frames,
    looks: &[Look],
    options: &ReadOptions<'_>,
    report: &mut ReadReport,
) -> Result<Scene, FormatError> {
    let noted = frames.of_scene;
    let tree = Tree::of(file, &mut scene, report)?;
    let tracks = animation::tracks(file, report)?;
    let change = Change::between((scene.unit, scene.up), noted);
    let mut meshes = Meshes::default();
    for &node in &tree.nodes {
        if let Some(mesh) = tree.mesh[node] {
            meshes.want(mesh, tracks.contains_key(&node), tree.bends[node]);
        }
    }
    meshes.compare(file);
    let unused = (0..file.root.meshes.len()).filter(|&mesh| !meshes.is_wanted(mesh)).count();
    report.count_many(Fate::LeftOut, "mesh that no node of the scene shows", unused);
    let mut reader = Reader {
        file,
        options,
        looks,
        tracks: &tracks,
        frames,
        change,
        meshes,
        last: None,
        alone: 0,
        bare: Vec::new(),
        places: HashMap::new(),
    };
    let mut names: HashMap<usize, String> = HashMap::new();
    let mut found = Vec::with_capacity(tree.nodes.len());
    for (done, &node) in tree.nodes.iter().enumerate() {
        options.observer.proceed("reading nodes", done as u64, tree.nodes.len() as u64)?;
        found.push(reader.node(node, &mut scene, report)?);
    }
    if reader.alone > 0 {
        report.notes.push(counted(
            reader.alone,
            "exact spline[|s] [has|have] no lines or faces in the file any more (as Blender exports curves, unless told to write \
             loose edges): [it is|they are] taken as [it was|they were] written",
        ));
    }
    report.notes.extend(left_behind(&reader.bare));
    // First all names, so that those of nodes come before those made up for their points.
    let mut taken = Scene::new();
    let (mut renamed, mut example) = (0_usize, None);
    for (&node, part) in tree.nodes.iter().zip(&found) {
        let name = taken.unique_name(&part.name);
        if name != part.name {
            renamed += 1;
            example.get_or_insert_with(|| (part.name.clone(), name.clone()));
        }
        let fail = |e: loftsman_kernel::Error| file.fail(format!("nodes[{node}]"), e.to_string());
        taken.add(Object::new(name.as_str(), Geometry::Group)).map_err(fail)?;
        names.insert(node, name);
    }
    if let Some((old, new)) = example {
        let nodes = if renamed == 1 { "one node has the name" } else { "nodes have the names" };
        let count = if renamed == 1 { String::new() } else { format!("{renamed} ") };
        report.notes.push(format!(
            "{count}{nodes} of another: objects have names of their own, so that \"{old}\" becomes \"{new}\""
        ));
    }
    let group = Arc::new(Geometry::Group);
    let mut exact = Vec::new();
    let mut loose = Vec::new();
    for (&node, part) in tree.nodes.iter().zip(found) {
        let path = || format!("nodes[{node}]");
        let fail = |e: loftsman_kernel::Error| file.fail(path(), e.to_string());
        let name = names.get(&node).cloned().unwrap_or_default();
        let mut object = Object::sharing(&name, part.geometry.unwrap_or_else(|| Arc::clone(&group)));
        let parent = tree.parent[node];
        object.parent = parent.and_then(|p| names.get(&p).cloned());
        object.transform = reader.transform(node, parent, &part.map, part.own.as_ref());
        let by_layer = part.own.as_ref().is_some_and(|own| own.by_layer);
        object.layer = part.own.and_then(|own| own.layer);
        object.label = Some(part.name).filter(|label| *label != name);
        object.animation = part.animation;
        object.statements = part.statements;
        if let Some(numbers) = part.numbers
            && object.transform.unwrap_or_else(Matrix4::identity) == part.map
        {
            let text = serde_json::to_string(&numbers).map_err(|e| file.fail(path(), e.to_string()))?;
            object.statements.push((PLACEMENT.to_owned(), text));
        }
        let is_unnamed = object.statement(UNNAMED).is_some();
        if let Some(mesh) = part.mesh_name.filter(|mesh| is_unnamed || mesh != object.label()) {
            object.statements.push((MESH_NAME.to_owned(), mesh));
        }
        object.materials = part.materials;
        let of_layer =
            object.layer.as_deref().filter(|_| by_layer).and_then(|layer| scene.layers.get(layer)?.color);
        object.color = part.color.filter(|color| !of_layer.is_some_and(|layer| is_shade(color, &layer)));
        if let Some((points, slots)) = part.points {
            loose.push((name, points, slots));
        }
        if let Some(spline) = part.exact {
            exact.push((scene.objects().len(), spline));
        }
        scene.add(object).map_err(fail)?;
    }
    for (above, points, slots) in loose {
        let name = scene.unique_name(&format!("{above} points"));
        let mut object = Object::sharing(name, points);
        object.parent = Some(above);
        (object.color, object.materials) = reader.appearance(&slots, &mut scene)?;
        scene.add(object).map_err(|e| file.fail("nodes", e.to_string()))?;
    }
    finish(file, scene, noted, &change, exact, report)
}

/// That nodes came back without their lines or points, and how they would not.
fn left_behind(bare: &[(String, Loose)]) -> Option<String> {
    const NAMED: usize = 8;
    if bare.is_empty() {
        return None;
    }
    let named: Vec<String> = bare.iter().take(NAMED).map(|(name, _)| format!("\"{}\"", clip(name))).collect();
    let more = if bare.len() > NAMED { format!(" and {} more", bare.len() - NAMED) } else { String::new() };
    let has = |what: Loose| bare.iter().any(|(_, loose)| *loose == what);
    let (what, panel) = match (has(Loose::Lines), has(Loose::Points)) {
        (true, true) => ("lines or points", "\"Loose Edges\" and \"Loose Points\""),
        (true, false) => ("lines", "\"Loose Edges\""),
        _ => ("points", "\"Loose Points\""),
    };
    Some(format!(
        "{}: written from here with {what}, of which the program that passed the file on kept nothing, so that empty groups are read (Blender does that unless told otherwise: \
         when exporting, tick {panel} under Data > Mesh)",
        named.join(", ") + &more
    ))
}

/// The whole scene in the unit and axes that were noted, splines exactly as they were.
fn finish(
    file: &File<'_>,
    scene: Scene,
    noted: (Unit, Up),
    change: &Change,
    exact: Vec<(usize, Exact)>,
    report: &mut ReadReport,
) -> Result<Scene, FormatError> {
    let fail = |e: loftsman_kernel::Error| file.fail("asset.extras", e.to_string());
    let names: Vec<String> = scene.objects().iter().map(|o| o.name().to_owned()).collect();
    let transforms: Vec<_> = scene.objects().iter().map(|o| o.transform).collect();
    let mut scene = if change.is_none() {
        scene
    } else {
        report
            .notes
            .push(format!("the file notes that it was made in {}: it is read as such", noted.0.name()));
        // Transforms are in that unit already.
        let mut changed = scene.converted(noted.0, noted.1).map_err(fail)?.into_owned();
        for (name, transform) in names.iter().zip(transforms) {
            changed.object_mut(name).map_err(fail)?.transform = transform;
        }
        changed
    };
    for (at, spline) in exact {
        let object = scene.object_mut(&names[at]).map_err(fail)?;
        object.animation = spline.animation;
        object.share_geometry(spline.geometry);
    }
    Ok(scene)
}

/// Whether a colour of a material is that of a layer, to single precision, as other programs pass it on.
fn is_shade(color: &[f64; 4], layer: &[f64; 4]) -> bool {
    color.iter().zip(layer).all(|(x, y)| (x - y.clamp(0.0, 1.0)).abs() <= AGREES)
}

/// An exact spline and its exact frames.
struct Exact {
    geometry: Arc<Geometry>,
    animation: Option<Animation>,
}

/// What a node became, still without its place.
struct Part {
    name: String,
    geometry: Option<Arc<Geometry>>,
    color: Option<[f64; 4]>,
    materials: Vec<String>,
    animation: Option<Animation>,
    statements: Vec<(String, String)>,
    mesh_name: Option<String>,
    /// Its loose points and their slots.
    points: Option<(Arc<Geometry>, Vec<Option<usize>>)>,
    map: Matrix4<f64>,
    /// The numbers of the map, where they do not follow from it.
    numbers: Option<Numbers>,
    own: Option<ExtrasFields>,
    exact: Option<Exact>,
}

struct Reader<'r, 'a> {
    file: &'r File<'a>,
    options: &'r ReadOptions<'r>,
    looks: &'r [Look],
    tracks: &'r HashMap<usize, Track>,
    frames: Frames,
    change: Change,
    meshes: Meshes,
    /// The exact spline of the last node without a mesh.
    last: Option<Arc<Geometry>>,
    /// How many nodes have an exact spline and no longer the mesh that showed it.
    alone: usize,
    /// The nodes that had lines or points, and nothing any more.
    bare: Vec<(String, Loose)>,
    /// For nodes whose object is in its own coordinates again: from those to the node's.
    places: HashMap<usize, Matrix4<f64>>,
}

impl Reader<'_, '_> {
    fn node(&mut self, node: usize, scene: &mut Scene, report: &mut ReadReport) -> Result<Part, FormatError> {
        let file = self.file;
        let path = format!("nodes[{node}]");
        let raw: schema::Node<'_> = file.entry("nodes", &file.root.nodes, node)?;
        super::report::extensions(raw.extensions.as_ref(), "node", report);
        let mut statements = Vec::new();
        super::report::keep(raw.extras, "node", &[EXTRAS], DATA, &mut statements, report);
        if raw.camera.is_some_and(|c| c.index() >= file.root.cameras.len())
            || raw.skin.is_some_and(|s| s.index() >= file.root.skins.len())
        {
            return Err(file.fail(path, "it refers to a camera or skin that does not exist"));
        }
        let map = local(file, &path, &raw)?;
        let numbers = Some(numbers(&raw)).filter(|numbers| numbers.differ(&map));
        let own = raw.extras.and_then(|extras| own(&path, extras.get(), report));
        let is_unnamed = raw.name.as_ref().is_none_or(|name| name.is_empty());
        let mut part = Part {
            name: raw.name.unwrap_or_default(),
            geometry: None,
            color: None,
            materials: Vec::new(),
            animation: None,
            statements,
            mesh_name: None,
            points: None,
            map,
            numbers,
            own,
            exact: None,
        };
        if let Some(mesh) = raw.mesh {
            let mesh = mesh.index();
            let content = self.meshes.content(file, mesh, report)?;
            let noted = content.statements.iter().map(|(_, text)| text.len()).sum::<usize>();
            file.take(format!("meshes[{mesh}].extras"), noted, 1)?;
            file.take(format!("meshes[{mesh}].name"), content.name.as_deref().map_or(0, str::len), 4)?;
            if part.name.is_empty() {
                part.name = content.name.clone().unwrap_or_default();
            }
            part.mesh_name = content.name.clone().filter(|name| !name.is_empty());
            part.statements.extend(content.statements.iter().cloned());
            if let Some(own) = part.own.as_ref().filter(|own| own.is_exact()) {
                let beside = Beside::Mesh(self.meshes.fingerprint(mesh).filter(|_| own.shown_by.is_some()));
                let shown_by = own.shown_by.clone();
                let spline = exact(own, beside, &self.frames.change(own), self.options, report);
                part.exact = spline.map(|(spline, animation)| Exact {
                    geometry: self.meshes.exact(mesh, shown_by.as_deref(), spline),
                    animation,
                });
            }
            if part.exact.is_none()
                && let (Some(track), Some(geometry)) = (self.tracks.get(&node), &content.main.geometry)
            {
                part.animation = track.frames(file, geometry.points(), &content.main.targets, report)?;
                let noted = part.own.as_ref().and_then(|own| own.rate);
                if let (Some(animation), Some(rate)) = (&mut part.animation, noted)
                    && (rate - animation.rate).abs() <= 1e-3 * rate
                {
                    animation.rate = rate;
                }
            }
            // Our own weights only show the start of an animation.
            let ours = part.animation.is_some() && part.own.as_ref().is_some_and(|own| own.starts_at_first);
            let weights = raw.weights.as_deref().unwrap_or(&content.weights);
            let weights = if ours { &[] } else { weights };
            let drops = part.own.as_ref().is_some_and(|own| own.made_tangents);
            let shown = self.meshes.shown(file, &path, mesh, weights, drops)?;
            self.meshes.done(mesh);
            (part.color, part.materials) = self.appearance(&content.main.slots, scene)?;
            // Colours of vertices get a material here, where they have none in the file.
            let colored =
                matches!(shown.main.as_deref(), Some(Geometry::Mesh(mesh)) if !mesh.colors.is_empty());
            if colored && content.main.slots == [None] {
                part.statements.push((MATERIAL.to_owned(), NONE.to_owned()));
            }
            if part.color.is_none() && !part.materials.is_empty() {
                part.color = part.own.as_ref().and_then(|own| own.color);
            }
            part.geometry = shown.main;
            part.points = shown.points.map(|points| (points, content.points.slots.clone()));
        }
        if raw.mesh.is_none() {
            // A spline that could not be shown, or whose mesh another program did not pass on.
            let spline = part
                .own
                .as_ref()
                .and_then(|own| exact(own, Beside::Nothing, &self.frames.change(own), self.options, report));
            let was_shown = part.own.as_ref().is_some_and(|own| own.shown_by.is_some());
            self.alone += usize::from(spline.is_some() && was_shown);
            part.exact = spline.map(|(spline, animation)| {
                let geometry = match &self.last {
                    Some(same) if **same == spline => Arc::clone(same),
                    _ => Arc::clone(self.last.insert(Arc::new(spline))),
                };
                Exact { geometry, animation }
            });
            part.color = part.own.as_ref().and_then(|own| own.color);
            if let Some(loose) = part.own.as_ref().and_then(|own| own.loose) {
                self.bare.push((part.name.clone(), loose));
            }
        }
        if part.name.is_empty() {
            part.name = format!("node {node}");
        }
        if is_unnamed {
            part.statements.push((UNNAMED.to_owned(), part.name.clone()));
        }
        if part.exact.is_some() || part.geometry.is_none() {
            let place = part.own.as_ref().and_then(|own| matrix(own.place.as_ref()?));
            if let Some(place) = place.filter(|p| p.try_inverse().is_some()) {
                self.places.insert(node, place);
            }
        }
        report.count(Fate::Kept, "");
        Ok(part)
    }

    /// The colour or the materials of an object with these slots.
    fn appearance(
        &self,
        slots: &[Option<usize>],
        scene: &mut Scene,
    ) -> Result<(Option<[f64; 4]>, Vec<String>), FormatError> {
        let mut looks = Vec::with_capacity(slots.len());
        for slot in slots {
            looks.push(match slot {
                None => Look::Nothing,
                Some(material) => match self.looks.get(*material) {
                    Some(look) => look.clone(),
                    None => return Err(self.file.missing("materials", *material, self.looks.len())),
                },
            });
        }
        match looks.as_slice() {
            [] | [Look::Nothing] => return Ok((None, Vec::new())),
            [Look::Color(_, color)] => return Ok((Some(*color), Vec::new())),
            _ => {}
        }
        let mut names = Vec::with_capacity(looks.len());
        for look in looks {
            let material = match look {
                Look::Material(name) => {
                    names.push(name);
                    continue;
                }
                // One of several: written again it is a colour as before.
                Look::Color(name, color) => {
                    let mut paint = Material::new(name, color);
                    paint.double_sided = true;
                    paint.statements.push((MATERIAL.to_owned(), COLOR.to_owned()));
                    paint
                }
                // As glTF has it where a primitive names no material.
                Look::Nothing => {
                    let mut usual = Material::new("default", [1.0; 4]);
                    (usual.metallic, usual.roughness) = (1.0, 1.0);
                    usual.statements.push((MATERIAL.to_owned(), NONE.to_owned()));
                    usual
                }
            };
            let known = scene.materials.get(material.name()).is_some_and(|m| *m == material);
            let name = material.name().to_owned();
            if known {
                names.push(name);
                continue;
            }
            let free = scene.materials.unique_name(&name);
            let mut renamed = Material::new(&free, material.base_color);
            (renamed.metallic, renamed.roughness) = (material.metallic, material.roughness);
            renamed.double_sided = material.double_sided;
            renamed.statements = material.statements;
            scene.materials.add(renamed).map_err(|e| self.file.fail("materials", e.to_string()))?;
            names.push(free);
        }
        Ok((None, names))
    }

    /// The transform of an object, in the unit and axes that were noted: what the node says, led back to the
    /// coordinates that the object and its parent have; exactly what was noted where that agrees.
    fn transform(
        &self,
        node: usize,
        parent: Option<usize>,
        map: &Matrix4<f64>,
        own: Option<&ExtrasFields>,
    ) -> Option<Matrix4<f64>> {
        let mut map = *map;
        // The largest number that may have been rounded on the way.
        let shift = |m: &Matrix4<f64>| m.fixed_view::<3, 1>(0, 3).amax();
        let mut size = shift(&map);
        if let Some(back) = parent.and_then(|p| self.places.get(&p)).and_then(|m| m.try_inverse()) {
            map = back * map;
            size = size.max(shift(&back));
        }
        if let Some(place) = self.places.get(&node) {
            map *= place;
            size = size.max(shift(place));
        }
        let map = self.change.of_transform(&map);
        let slack = 1e-12 * size.max(shift(&map)) * self.change.scale;
        let near = |noted: &Matrix4<f64>| {
            let (a, b) = (map.fixed_view::<3, 3>(0, 0), noted.fixed_view::<3, 3>(0, 0));
            let (s, t) = (map.fixed_view::<3, 1>(0, 3), noted.fixed_view::<3, 1>(0, 3));
            (a - b).amax() <= AGREES * b.amax() && (s - t).amax() <= AGREES * t.amax() + slack
        };
        let noted = own.and_then(|own| {
            let noted = matrix(own.transform.as_ref()?)?;
            Some(self.frames.change(own).of_transform(&noted))
        });
        let noted = noted.filter(near);
        // No transform is noted as one that does nothing.
        Some(noted.unwrap_or(map)).filter(|map| *map != Matrix4::identity())
    }
}

/// The numbers of the node's own map.
fn numbers(raw: &schema::Node<'_>) -> Numbers {
    Numbers { matrix: raw.matrix, translation: raw.translation, rotation: raw.rotation, scale: raw.scale }
}

/// The node's own map.
fn local(file: &File<'_>, path: &str, raw: &schema::Node<'_>) -> Result<Matrix4<f64>, FormatError> {
    let map = if let Some(matrix) = raw.matrix {
        if raw.translation.is_some() || raw.rotation.is_some() || raw.scale.is_some() {
            let problem = "a node has either a matrix, or a translation, rotation and scale: take one away";
            return Err(file.fail(path, problem));
        }
        let map = Matrix4::from_column_slice(&matrix);
        if [0, 1, 2, 3].map(|j| map[(3, j)]) != [0.0, 0.0, 0.0, 1.0] {
            return Err(
                file.fail(format!("{path}.matrix"), "its last row is not 0 0 0 1: it is no affine map")
            );
        }
        map
    } else {
        let rotation = raw.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
        let size = rotation.iter().map(|x| x * x).sum::<f64>();
        // Far from length 1 it is no rounding; the standard allows none.
        if !(size > 0.25 && size < 4.0) {
            let problem = format!("{rotation:?} is not of length 1: a rotation is a unit quaternion");
            return Err(file.fail(format!("{path}.rotation"), problem));
        }
        let numbers = numbers(raw);
        numbers.placement().map_or_else(Matrix4::identity, |placement| placement.matrix())
    };
    if map.iter().all(|x| x.is_finite()) {
        Ok(map)
    } else {
        Err(file.fail(path, "its transform is not finite"))
    }
}
