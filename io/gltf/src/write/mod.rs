//! The writer: one node an object, one mesh with a primitive a material where it has something to show, which objects share
//! that share their geometry.

mod animation;
mod bin;
mod frame;
mod left_out;
mod material;
mod mesh;
mod nodes;
mod object;
mod schema;
mod shape;
mod shared;
mod tangent;

use loftsman_kernel::text::short;
use std::borrow::Cow;

use loftsman_kernel::placement::Change;
use loftsman_kernel::plugin::{Cuts, FormatError, Outgoing, Sink, WriteOptions, WriteReport, Written};
use loftsman_kernel::scene::{Object, Scene, Unit, Up};
use nalgebra::{Matrix4, Translation3};
use serde_json::{Map, Value, json};

use self::animation::Keys;
use self::bin::{Bin, emit, is_text};
use self::material::Materials;
use self::schema::{Asset, Mesh, Node, Root, Scene as SceneNodes};
use self::shared::{Drawn, Shared};
use crate::extras::{ExtrasFields, LayerFields, rows};
use crate::place::{Numbers, Placement};
use crate::words::{
    ASSET_DATA, COPYRIGHT, DATA, EXTRAS, MATERIAL, MESH_DATA, MESH_NAME, PLACEMENT, PREFIX, SCENE_DATA,
    SCENE_NAME, UNNAMED, UNNAMED_IMAGE,
};

/// Writes a scene.
pub(crate) fn write(outgoing: &Outgoing<'_>, sink: &mut dyn Sink) -> Result<WriteReport, FormatError> {
    let meshes_only = outgoing.options.own.flag("meshes-only")?;
    let (unit, up) = (outgoing.unit, outgoing.up);
    let as_usual = (unit, up) == (Unit::Metre, Up::Y);
    // In glTF's own unit and axes numbers are changed as they are poured, and the file notes what they were; else a
    // reader takes them for metres and y up, and so does this.
    let scene = if as_usual { Cow::Borrowed(outgoing.scene()) } else { outgoing.converted()? };
    let scene = scene.as_ref();
    let change = Change::between((scene.unit, scene.up), (unit, up));
    // Lengths that are asked for, and told, are in the unit of the scene as it came.
    let grown = if as_usual { 1.0 } else { outgoing.scale() };
    let mut writer = Writer {
        scene,
        options: outgoing.options,
        meshes_only,
        change,
        back: Change::between((unit, up), (scene.unit, scene.up)),
        noted: if as_usual { (scene.unit, scene.up) } else { (Unit::Metre, Up::Y) },
        bin: Bin::default(),
        materials: Materials::new(scene, outgoing.options.pictures, is_text(sink.name())),
        meshes: Vec::new(),
        shared: Shared::default(),
        keys: Keys::default(),
        rounding: 0.0,
        grown,
        cuts: outgoing.cuts(scene, grown)?,
    };
    let (nodes, report) = writer.scene(outgoing)?;
    let Writer { bin, materials, meshes, keys, rounding, .. } = writer;
    let said =
        |heading: &str| scene.statement(heading).and_then(|text| serde_json::from_str::<Value>(text).ok());
    let mut notes = notes(scene, rounding / change.scale);
    if up != Up::Y {
        notes.push(format!(
            "coordinates go out with {} up, as asked for, and programs take them for y up, as glTF has it, this one too: leave the axis out to have them turned",
            up.name()
        ));
    }
    let mut of_asset = said(ASSET_DATA);
    let mut noted = Map::new();
    if as_usual && !change.is_none() {
        noted.insert("unit".to_owned(), json!(scene.unit));
        noted.insert("up".to_owned(), json!(scene.up));
    }
    if !scene.layers.is_empty() {
        noted.insert("layers".to_owned(), json!(LayerFields::of(&scene.layers)));
    }
    if !noted.is_empty() && !with(&mut of_asset, EXTRAS, noted.into()) {
        notes.push("what other programs noted of the asset is left out".to_owned());
    }
    let generator = concat!("Loftsman ", env!("CARGO_PKG_VERSION")).to_owned();
    let copyright = scene.statement(COPYRIGHT).map(str::to_owned);
    let asset = Asset { version: "2.0", generator, copyright, extras: of_asset };
    let mut root = Root { asset, extras: said(DATA), meshes, ..Root::default() };
    let (mut of_materials, pictures) = materials.finish(&mut root);
    of_materials.dedup();
    notes.extend(of_materials);
    let (nodes, top, numbers) = nodes;
    root.nodes = nodes;
    root.animations = keys.finish(&numbers);
    // A scene must have nodes; a document need not have a scene.
    if !top.is_empty() {
        root.scene = Some(0);
        let name = scene.statement(SCENE_NAME).map(str::to_owned);
        root.scenes.push(SceneNodes { name, nodes: top, extras: said(SCENE_DATA) });
    }
    emit(root, bin, sink)?;
    for (name, bytes) in pictures {
        sink.picture(&name, &bytes)?;
    }
    Ok(WriteReport { objects: report, notes, ..WriteReport::default() })
}

/// Adds a field to what other programs noted; `false` where that is no table, and gave way.
fn with(extras: &mut Option<Value>, key: &str, value: Value) -> bool {
    if let Some(Value::Object(fields)) = extras {
        fields.insert(key.to_owned(), value);
        return true;
    }
    extras.replace(json!({ key: value })).is_none()
}

/// Whether a statement of the whole or of an object is one that our reader makes.
fn is_ours(key: &str, text: &str) -> bool {
    match key {
        PLACEMENT => serde_json::from_str::<Numbers>(text).is_ok(),
        DATA | MESH_DATA | SCENE_DATA | ASSET_DATA => serde_json::from_str::<Value>(text).is_ok(),
        MESH_NAME | SCENE_NAME | COPYRIGHT | UNNAMED | UNNAMED_IMAGE | MATERIAL => true,
        _ => false,
    }
}

fn notes(scene: &Scene, rounding: f64) -> Vec<String> {
    let unit = scene.unit.name();
    let mut report = WriteReport::default();
    if rounding > 0.0 {
        report.notes.push(format!(
            "coordinates are rounded by at most {rounding} {unit}: glTF has single precision",
            rounding = short(rounding)
        ));
    }
    let broken = |list: &[(String, String)]| {
        list.iter().filter(|(key, text)| key.starts_with(PREFIX) && !is_ours(key, text)).count()
    };
    let broken =
        broken(&scene.statements) + scene.objects().iter().map(|o| broken(&o.statements)).sum::<usize>();
    report.say(broken, "statement[|s] headed \"gltf\" [is|are] no JSON or unknown, and [is|are] left out");
    report.notes
}

struct Writer<'a, 'o> {
    scene: &'a Scene,
    options: &'o WriteOptions<'o>,
    meshes_only: bool,
    /// From the scene's unit and axes to the file's, and back.
    change: Change,
    back: Change,
    /// What nodes say that their own numbers are in.
    noted: (Unit, Up),
    bin: Bin<'a>,
    materials: Materials<'a>,
    meshes: Vec<Mesh>,
    shared: Shared<'a>,
    keys: Keys,
    /// By how much a coordinate was rounded, in the file's unit.
    rounding: f64,
    /// What lengths of the scene as it came are multiplied by in the one that is written.
    grown: f64,
    /// How finely each object is cut.
    cuts: Cuts,
}

/// What hangs over an object: what its parent's node could not hold, in the file's unit and axes.
#[derive(Clone, Copy)]
struct Above {
    /// What was baked into the points above, or moved away from them.
    rest: Matrix4<f64>,
    /// By how much all nodes so far may stretch a length.
    stretch: f64,
}

/// Nodes in the file's order, those at the top, and each object's number.
type Nodes = (Vec<Node>, Vec<usize>, Vec<Option<usize>>);

impl<'a> Writer<'a, '_> {
    fn scene(&mut self, outgoing: &Outgoing<'_>) -> Result<(Nodes, Vec<Written>), FormatError> {
        let scene = self.scene;
        let objects = scene.objects();
        let tree = nodes::Tree::of(scene);
        let mut all: Vec<Node> = (0..objects.len()).map(|_| Node::default()).collect();
        let mut written: Vec<Option<Written>> = vec![None; objects.len()];
        // Parents before their children: each hands down what its own node could not hold.
        let start = Above { rest: Matrix4::identity(), stretch: 1.0 };
        let mut open: Vec<(usize, Above)> = tree.roots.iter().rev().map(|&i| (i, start)).collect();
        let mut done = 0;
        while let Some((index, above)) = open.pop() {
            outgoing.proceed(done, objects.len())?;
            done += 1;
            let object = &objects[index];
            let named = |e: FormatError| e.of(object.name());
            let (node, below, report) = self.object(index, object, above).map_err(named)?;
            all[index] = node;
            written[index] = Some(report);
            open.extend(tree.children[index].iter().rev().map(|&child| (child, below)));
        }
        let nodes = nodes::number(all, &tree, objects);
        Ok((nodes, written.into_iter().flatten().collect()))
    }

    fn object(
        &mut self,
        index: usize,
        object: &'a Object,
        above: Above,
    ) -> Result<(Node, Above, Written), FormatError> {
        let identity = Matrix4::identity();
        let own = object.transform.map_or(above.rest, |own| above.rest * self.change.of_transform(&own));
        // A transform with shear, which glTF forbids, is baked into the points.
        let (mut placement, rest) = match self.as_read(object, &above.rest).or_else(|| Placement::of(&own)) {
            Some(placement) => (placement, identity),
            None => (Placement::none(), own),
        };
        let stretch = above.stretch * placement.scale.amax();
        let mut report = Written::kept(object, "nothing");
        // What has no name in the file that it comes from has none here, unless it was given one since.
        let is_unnamed = object.statement(UNNAMED) == Some(object.label());
        let name = if is_unnamed { String::new() } else { object.label().to_owned() };
        let mut node = Node { name, ..Node::default() };
        node.extras = object.statement(DATA).and_then(|text| serde_json::from_str(text).ok());
        let mut noted = ExtrasFields::default();
        let mut place = rest;
        let drawn = self.drawn(index, object, &rest, stretch, &mut report)?;
        if let Drawn::Unseen(fields) = drawn {
            noted = *fields;
            node.is_unseen = true;
        } else if let Drawn::Mesh(mesh, frame, fields) = drawn {
            // The node moves the shape to where it belongs; what hangs under the node must not follow.
            let centre = frame.centre;
            placement.translation +=
                if rest == identity { own.fixed_view::<3, 3>(0, 0) * centre } else { centre };
            place = Translation3::from(-centre).to_homogeneous() * rest;
            noted = *fields;
            self.rounding = self.rounding.max(frame.rounding() * stretch);
            node.mesh = Some(mesh);
        }
        if rest != identity {
            let reason =
                "its transform shears or flattens, which glTF's nodes cannot: it is baked into the points";
            report.change(reason);
        }
        if !placement.translation.iter().all(|t| (*t as f32).is_finite()) {
            let [x, y, z] = placement.translation.into();
            return Err(FormatError::whole(format!(
                "it is at ({x:e}, {y:e}, {z:e}), beyond single precision, which glTF has: choose another unit"
            )));
        }
        if placement.linear.is_some() {
            node.matrix = Some(placement.columns());
        } else {
            (node.translation, node.rotation, node.scale) =
                (placement.shift(), placement.turn(), placement.stretch());
        }
        if !place.iter().chain(above.rest.iter()).all(|x| x.is_finite()) {
            return Err(FormatError::whole("its transforms together overflow: scale them down"));
        }
        self.note(object, &placement, &place, &above.rest, node.mesh.is_some(), &mut noted);
        if noted != ExtrasFields::default() {
            let text = serde_json::to_string(&noted).map_err(std::io::Error::from)?;
            if !with(&mut node.extras, EXTRAS, text.into()) {
                report.change("what other programs noted of it is left out");
            }
        }
        Ok((node, Above { rest: place, stretch }, report))
    }

    /// The placement in the numbers of the file that the object comes from, where it has not been moved since.
    fn as_read(&self, object: &Object, above: &Matrix4<f64>) -> Option<Placement> {
        let numbers: Numbers = serde_json::from_str(object.statement(PLACEMENT)?).ok()?;
        let placement = numbers.placement()?;
        let is_here = |map: Matrix4<f64>| {
            map.iter().all(|x| (*x as f32).is_finite())
                && self.back.of_transform(&map) == object.transform.unwrap_or_else(Matrix4::identity)
        };
        (*above == Matrix4::identity() && is_here(placement.matrix())).then_some(placement)
    }

    /// What the reader cannot see from the node itself.
    fn note(
        &self,
        object: &Object,
        placement: &Placement,
        place: &Matrix4<f64>,
        above: &Matrix4<f64>,
        has_mesh: bool,
        noted: &mut ExtrasFields,
    ) {
        let identity = Matrix4::identity();
        let moved = *place != identity || *above != identity;
        if moved {
            noted.place = Some(rows(place));
        }
        let seen = self.back.of_transform(&placement.matrix());
        match object.transform {
            Some(transform) if moved || transform != seen => noted.transform = Some(rows(&transform)),
            // What is none must be none again.
            None if moved => noted.transform = Some(rows(&identity)),
            _ => {}
        }
        if noted.is_exact() || noted.transform.is_some() {
            (noted.unit, noted.up) = (Some(self.noted.0), Some(self.noted.1));
        }
        noted.layer.clone_from(&object.layer);
        if !has_mesh || !object.materials.is_empty() {
            noted.color = object.color.filter(|c| c.iter().all(|x| x.is_finite()));
        }
        noted.by_layer = has_mesh && object.color.is_none() && self.scene.color_of(object).is_some();
    }
}
