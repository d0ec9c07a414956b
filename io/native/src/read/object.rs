//! Objects and the document around them.

use std::collections::HashMap;
use std::sync::Arc;

use loftsman_kernel::connection::Connection;
use loftsman_kernel::named::Named;
use loftsman_kernel::plugin::{FormatErrorKind, ReadOptions, hint};
use loftsman_kernel::scene::{Animation, Geometry, Object, Scene, Unit, Up};
use loftsman_kernel::text::clip;
use nalgebra::Matrix4;
use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess};

use super::brep::BrepTable;
use super::definition::{DefinitionsSeed, Earlier, InstanceTable, Into, ObjectsSeed, SameTable};
use super::geometry::{
    AnimationTable, CloudTable, FormedCurveTable, FormedSurfaceTable, GroupTable, PolylineTable,
};
use super::layer::LayerTable;
use super::lists::{Count, Fixed, List, Text};
use super::material::{ImageTable, MaterialTable, NamedSeed, statements};
use super::mesh::MeshTable;
use super::shape::ShapeSeed;
use super::table::{Table, TableSeed, need};
use super::trail::Trail;
use super::trimmed::{ConnectionSeed, TrimmedTable};
use crate::VERSION;

/// An object.
pub(super) struct ObjectTable<'s> {
    earlier: Earlier<'s>,
    options: &'s ReadOptions<'s>,
    name: Option<String>,
    label: Option<String>,
    geometry: Option<(&'static str, Arc<Geometry>)>,
    color: Option<[f64; 4]>,
    materials: Vec<String>,
    layer: Option<String>,
    parent: Option<String>,
    transform: Option<Matrix4<f64>>,
    animation: Option<Animation>,
    statements: Vec<(String, String)>,
}

impl<'s> ObjectTable<'s> {
    /// The table of an object that stands behind others.
    pub(super) fn new(earlier: Earlier<'s>, options: &'s ReadOptions<'s>) -> Self {
        Self {
            earlier,
            options,
            name: None,
            label: None,
            geometry: None,
            color: None,
            materials: Vec::new(),
            layer: None,
            parent: None,
            transform: None,
            animation: None,
            statements: Vec::new(),
        }
    }
}

impl<'de> Table<'de> for ObjectTable<'_> {
    type Out = Object;
    const WHAT: &'static str = "an object";
    const FIELDS: &'static [&'static str] = &[
        "name",
        "label",
        "curve",
        "surface",
        "trimmed",
        "brep",
        "mesh",
        "polyline",
        "cloud",
        "group",
        "shape",
        "instance",
        "same_as",
        "color",
        "materials",
        "layer",
        "parent",
        "transform",
        "animation",
        "statements",
    ];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        match name {
            "name" => {
                let name: String = map.next_value()?;
                trail.set_object(Some(&clip(&name)));
                self.name = Some(name);
            }
            "label" => self.label = Some(map.next_value()?),
            "color" => {
                self.color = Some(map.next_value_seed(Fixed { trail, what: "[red, green, blue, alpha]" })?);
            }
            "materials" => {
                let what = "names of materials";
                self.materials = map.next_value_seed(List { trail, what, item: Text })?;
            }
            "layer" => self.layer = Some(map.next_value()?),
            "parent" => self.parent = Some(map.next_value()?),
            "transform" => self.transform = Some(map.next_value_seed(TransformSeed(trail))?),
            "animation" => {
                let seed = TableSeed { trail, table: AnimationTable::default() };
                self.animation = Some(map.next_value_seed(seed)?);
            }
            "statements" => self.statements = statements(map, trail)?,
            geometry => {
                if let Some((other, _)) = self.geometry {
                    let problem = format!(
                        "the object has a \"{other}\" and a \"{geometry}\": give each geometry an object of its own"
                    );
                    return Err(trail.refuse(problem));
                }
                self.geometry = Some((geometry, self.read_geometry(geometry, map, trail)?));
            }
        }
        Ok(())
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<Object, E> {
        let name = need::<Self, _, _>(self.name, "name", trail)?;
        let Some((_, geometry)) = self.geometry else {
            let problem = "the object has no geometry: give it a \"curve\", \"surface\", \"trimmed\", \"brep\", \"mesh\", \"polyline\", \
                           \"cloud\", \"shape\", \"instance\", \"same_as\", or \"group\": {} if others only hang under it";
            return Err(trail.refuse_table("", problem));
        };
        let count = geometry.points().len();
        let fitting = self.animation.iter().filter(|a| !a.fits(&geometry));
        if let Some((frame, points)) =
            fitting.flat_map(|a| a.frames.iter().enumerate()).find(|(_, f)| f.len() != count)
        {
            let problem = format!(
                "the frame has {} points, the object {count}: a frame moves every point",
                points.len()
            );
            return Err(trail.refuse_table(format!("animation.frames[{frame}]"), problem));
        }
        let mut object = Object::sharing(name, geometry);
        object.label = self.label;
        object.color = self.color;
        object.materials = self.materials;
        object.layer = self.layer;
        object.parent = self.parent;
        object.transform = self.transform;
        object.animation = self.animation;
        object.statements = self.statements;
        Ok(object)
    }
}

impl ObjectTable<'_> {
    fn read_geometry<'de, A: MapAccess<'de>>(
        &self,
        kind: &str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<Arc<Geometry>, A::Error> {
        Ok(Arc::new(match kind {
            "same_as" => {
                let same = map.next_value_seed(TableSeed { trail, table: SameTable::default() })?;
                return self.earlier.geometry(&same, trail);
            }
            "curve" => map.next_value_seed(TableSeed { trail, table: FormedCurveTable::default() })?.into(),
            "trimmed" => map.next_value_seed(TableSeed { trail, table: TrimmedTable::default() })?.into(),
            "surface" => {
                map.next_value_seed(TableSeed { trail, table: FormedSurfaceTable::default() })?.into()
            }
            "brep" => map.next_value_seed(TableSeed { trail, table: BrepTable::default() })?.into(),
            "mesh" => map.next_value_seed(TableSeed { trail, table: MeshTable::default() })?.into(),
            "polyline" => map.next_value_seed(TableSeed { trail, table: PolylineTable::default() })?.into(),
            "cloud" => map.next_value_seed(TableSeed { trail, table: CloudTable::default() })?.into(),
            "shape" => map.next_value_seed(ShapeSeed { trail, options: self.options })?.into(),
            "instance" => map.next_value_seed(TableSeed { trail, table: InstanceTable::default() })?,
            _ => {
                map.next_value_seed(TableSeed { trail, table: GroupTable })?;
                Geometry::Group
            }
        }))
    }
}

/// Four rows of four numbers, the last `[0, 0, 0, 1]`.
struct TransformSeed<'t>(&'t Trail);

impl<'de> DeserializeSeed<'de> for TransformSeed<'_> {
    type Value = Matrix4<f64>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Matrix4<f64>, D::Error> {
        let trail = self.0;
        let item = Fixed::<4> { trail, what: "a row of four numbers" };
        let rows = List { trail, what: "four rows of four numbers", item }.deserialize(deserializer)?;
        let Ok(rows) = <[[f64; 4]; 4]>::try_from(rows.as_slice()) else {
            return Err(trail.refuse(format!("{} rows where a transform has 4", rows.len())));
        };
        let matrix = Matrix4::from_fn(|i, j| rows[i][j]);
        if rows[3] != [0.0, 0.0, 0.0, 1.0] {
            let problem = "the last row of a transform must be [0, 0, 0, 1]; \
                           if the translation stands there, write the matrix the other way round (rows first)";
            return Err(trail.refuse(problem));
        }
        Ok(matrix)
    }
}

/// The document: fills a scene.
pub(super) struct DocumentTable<'s> {
    scene: &'s mut Scene,
    options: &'s ReadOptions<'s>,
    version: bool,
    objects: bool,
    connections: Vec<Connection>,
}

impl<'s> DocumentTable<'s> {
    /// The table that fills `scene`.
    pub(super) fn new(scene: &'s mut Scene, options: &'s ReadOptions<'s>) -> Self {
        Self { scene, options, version: false, objects: false, connections: Vec::new() }
    }
}

impl<'de> Table<'de> for DocumentTable<'_> {
    type Out = ();
    const WHAT: &'static str = "a document";
    const FIELDS: &'static [&'static str] = &[
        "loftsman",
        "unit",
        "up",
        "statements",
        "layers",
        "images",
        "materials",
        "definitions",
        "objects",
        "connections",
    ];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        match name {
            "loftsman" => {
                let version = map.next_value_seed(Count)?;
                if version != VERSION {
                    let hint =
                        if version > VERSION { "get a newer program" } else { "there is no such version" };
                    let problem = format!(
                        "version {version} of the format; this program reads version {VERSION}: {hint}"
                    );
                    return Err(trail.refuse_as(FormatErrorKind::Unsupported, problem));
                }
                self.version = true;
            }
            "unit" => {
                let name: String = map.next_value()?;
                self.scene.unit = Unit::from_name(&name).ok_or_else(|| {
                    let known: Vec<_> = Unit::ALL.iter().map(|(name, _)| *name).collect();
                    unknown("unit", &name, &[&known, &[Unit::UNKNOWN, "0.3 m"][..]].concat(), trail)
                })?;
            }
            "up" => {
                let name: String = map.next_value()?;
                self.scene.up = Up::from_name(&name)
                    .ok_or_else(|| unknown("up axis", &name, &Up::ALL.map(|(name, _)| name), trail))?;
            }
            "connections" => {
                let item = ConnectionSeed(trail);
                let what = "connections { first, second }";
                self.connections = map.next_value_seed(List { trail, what, item })?;
            }
            "statements" => self.scene.statements = statements(map, trail)?,
            "layers" => {
                let (list, table) = (&mut self.scene.layers, LayerTable::default);
                map.next_value_seed(NamedSeed { trail, what: "layers", list, table })?;
            }
            "images" => {
                let (list, table) = (&mut self.scene.images, ImageTable::default);
                map.next_value_seed(NamedSeed { trail, what: "images", list, table })?;
            }
            "materials" => {
                let (list, table) = (&mut self.scene.materials, MaterialTable::default);
                map.next_value_seed(NamedSeed { trail, what: "materials", list, table })?;
            }
            "definitions" => {
                map.next_value_seed(DefinitionsSeed { trail, scene: self.scene, options: self.options })?;
            }
            _ => {
                self.objects = true;
                let into = Into::Scene(self.scene);
                let seed = ObjectsSeed { trail, into, options: self.options };
                map.next_value_seed(seed)?;
                trail.set_object(None);
            }
        }
        Ok(())
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<(), E> {
        need::<Self, _, _>(self.version.then_some(()), "loftsman", trail)?;
        need::<Self, _, _>(self.objects.then_some(()), "objects", trail)?;
        for (i, connection) in self.connections.into_iter().enumerate() {
            self.scene
                .connect(connection)
                .map_err(|defect| trail.refuse_table(format!("connections[{i}]"), defect.to_string()))?;
        }
        check_hierarchy(self.scene, trail)?;
        super::layer::check(self.scene, trail)?;
        check_names(self.scene, trail)
    }
}

fn unknown<E: Error>(what: &str, name: &str, known: &[&'static str], trail: &Trail) -> E {
    let hint = hint(name, known.iter().copied(), || format!("known are {}", known.join(", ")));
    trail.refuse(format!("unknown {what} \"{}\"; {hint}", clip(name)))
}

/// Every parent exists, and nothing hangs under itself.
fn check_hierarchy<E: Error>(scene: &Scene, trail: &Trail) -> Result<(), E> {
    for (i, object) in scene.objects().iter().enumerate() {
        if let Some(parent) = object.parent.as_deref().filter(|parent| scene.get(parent).is_none()) {
            trail.set_object(Some(&clip(object.name())));
            let hint = hint(parent, scene.objects().iter().map(Object::name), || {
                "add it, or take the field away".to_owned()
            });
            let problem = format!("there is no object \"{}\" to hang under; {hint}", clip(parent));
            return Err(trail.refuse_table(format!("objects[{i}].parent"), problem));
        }
    }
    for (i, object) in scene.objects().iter().enumerate() {
        if let Geometry::Instance(name) = object.geometry()
            && scene.definitions().get(name).is_none()
        {
            trail.set_object(Some(&clip(object.name())));
            let hint = hint(name, scene.definitions().iter().map(Named::name), || {
                "add it to the document's definitions".to_owned()
            });
            let problem = format!("there is no definition \"{}\"; {hint}", clip(name));
            return Err(trail.refuse_table(format!("objects[{i}].instance.definition"), problem));
        }
    }
    scene.check_definitions().map_err(|defect| trail.refuse_table("definitions", defect.to_string()))?;
    scene.check_hierarchy().map_err(|defect| trail.refuse_table("objects", defect.to_string()))
}

fn missing<'a>(what: &str, name: &str, known: impl Iterator<Item = &'a str>) -> String {
    let hint = hint(name, known, || format!("add it to the document's {what}s, or take it away here"));
    format!("there is no {what} \"{}\"; {hint}", clip(name))
}

/// Every material and image that is named exists, and every face's material is among its object's.
fn check_names<E: Error>(scene: &Scene, trail: &Trail) -> Result<(), E> {
    for (i, material) in scene.materials.iter().enumerate() {
        for texture in material.textures.values() {
            if scene.images.get(&texture.image).is_none() {
                let known = scene.images.iter().map(Named::name);
                let place = format!("materials[{i}].textures");
                return Err(trail.refuse_table(place, missing("image", &texture.image, known)));
            }
        }
    }
    let mut slots = HashMap::new();
    for (i, object) in scene.objects().iter().enumerate() {
        check_object(scene, object, &format!("objects[{i}]"), &mut slots, trail)?;
    }
    for (i, definition) in scene.definitions().iter().enumerate() {
        for (k, object) in definition.objects().iter().enumerate() {
            check_object(scene, object, &format!("definitions[{i}].objects[{k}]"), &mut slots, trail)?;
        }
    }
    Ok(())
}

/// Every material that an object names exists, and every face's is among them; `slots` has the largest of each geometry that
/// was looked at before.
fn check_object<E: Error>(
    scene: &Scene,
    object: &Object,
    at: &str,
    slots: &mut HashMap<usize, u32>,
    trail: &Trail,
) -> Result<(), E> {
    for (k, name) in object.materials.iter().enumerate() {
        if scene.materials.get(name).is_none() {
            trail.set_object(Some(&clip(object.name())));
            let known = scene.materials.iter().map(Named::name);
            return Err(trail.refuse_table(format!("{at}.materials[{k}]"), missing("material", name, known)));
        }
    }
    if let Geometry::Mesh(mesh) = object.geometry() {
        let largest = slots
            .entry(object.geometry_id())
            .or_insert_with(|| mesh.materials.iter().copied().max().unwrap_or(0));
        let count = object.materials.len().max(1);
        if *largest as usize >= count
            && let Some((face, slot)) = mesh.materials.iter().enumerate().find(|&(_, &s)| s as usize >= count)
        {
            trail.set_object(Some(&clip(object.name())));
            let problem = format!("entry {slot} of the object's materials, which are {count}: count from 0");
            return Err(trail.refuse_table(format!("{at}.mesh.materials[{face}]"), problem));
        }
    }
    Ok(())
}
