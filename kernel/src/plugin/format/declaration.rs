//! What a format declares: its name and options, and what its files say and hold.

use std::collections::BTreeMap;
use std::fmt;

use super::error::FormatError;
use crate::declare::{Field, Parameters};
use crate::scene::{Definition, Geometry, Object, Scene, Unit, Up};

/// What a format is called, which way it goes, and what it holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct FormatDeclaration {
    /// Its name: `"obj"`.
    pub name: &'static str,
    /// One line of help.
    pub help: &'static str,
    /// File extensions without the dot, lower case; compound ones (`"loft.json"`) too. The first is the usual one.
    pub extensions: &'static [&'static str],
    /// Whether it can be read.
    pub reads: bool,
    /// Whether it can be written.
    pub writes: bool,
    /// Whether the main file is text that can go through a pipe.
    pub plain: bool,
    /// Options of its own, for reading and writing. The help of one that only reading or only writing has begins with
    /// `"reading: "` or `"writing: "`; on the other way it is refused.
    pub options: &'static [Field],
    /// What its files say and hold.
    pub holds: Holds,
}

/// Whether files of a format say in which unit their numbers are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum UnitRule {
    /// All have this one.
    Fixed(Unit),
    /// Each says its own.
    Stated,
    /// None says it.
    None,
}

/// What the files of a format say and hold. What they do not is converted, shown one by one, baked in, cut into triangles or left
/// out on the way out, and the report says so.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct Holds {
    /// The unit of lengths.
    pub unit: UnitRule,
    /// The axis that points up in all of its files; `None` where each says its own, or any does.
    pub up: Option<Up>,
    /// The kinds of geometry that go out exactly, by their names in documents (`"curve"`, `"mesh"`, `"group"`, `"instance"`, …; shapes
    /// of plug-ins are `"shape"`).
    pub exact: &'static [&'static str],
    /// The kinds that go out as segments or triangles.
    pub tessellated: &'static [&'static str],
    /// Transforms, and which object hangs under which.
    pub hierarchy: bool,
    /// Layers: their names, colours, which are hidden, and which lies below which.
    pub layers: bool,
    /// Colours of objects.
    pub colors: bool,
    /// Names that objects have in common: their labels.
    pub labels: bool,
    /// Materials.
    pub materials: bool,
    /// Frames of animations.
    pub animation: bool,
    /// Which edges of surfaces are said to be one.
    pub connections: bool,
    /// How statements begin that it keeps word for word; `""` is the beginning of all.
    pub statements: &'static [&'static str],
    /// Whether numbers are rounded to single precision.
    pub single_precision: bool,
}

impl Holds {
    /// Numbers without a unit, and nothing else: for formats that name the few things that they hold.
    pub const NOTHING: Self = Self {
        unit: UnitRule::None,
        up: None,
        exact: &[],
        tessellated: &[],
        hierarchy: false,
        layers: false,
        colors: false,
        labels: false,
        materials: false,
        animation: false,
        connections: false,
        statements: &[],
        single_precision: false,
    };

    /// Everything that a scene can be.
    pub const EVERYTHING: Self = Self {
        unit: UnitRule::Stated,
        exact: &["group", "instance", "curve", "surface", "trimmed", "mesh", "polyline", "cloud", "shape"],
        hierarchy: true,
        layers: true,
        colors: true,
        labels: true,
        materials: true,
        animation: true,
        connections: true,
        statements: &[""],
        ..Self::NOTHING
    };

    /// Whether a geometry goes out exactly, wherever that can be.
    pub fn exactly(&self, geometry: &Geometry) -> bool {
        self.exact.contains(&kind(geometry))
    }

    /// Whether a geometry goes out as segments or triangles.
    pub fn tessellates(&self, geometry: &Geometry) -> bool {
        self.tessellated.contains(&kind(geometry))
    }

    /// Whether there are instances.
    pub(super) fn instances(&self) -> bool {
        self.exact.contains(&"instance")
    }

    /// What would be lost of a scene, a line for each kind of thing: what a conversion to the format would leave out, or change.
    pub fn losses(&self, scene: &Scene) -> Vec<String> {
        let mut kinds: BTreeMap<(&str, &str), usize> = BTreeMap::new();
        for object in objects(scene) {
            let geometry = object.geometry();
            let fate = match geometry {
                _ if self.exactly(geometry) => continue,
                _ if self.tessellates(geometry) => "becomes segments or triangles",
                Geometry::Instance(_) => "is written object by object",
                _ => "is left out",
            };
            *kinds.entry((geometry.kind(), fate)).or_default() += 1;
        }
        let mut lost: Vec<String> =
            kinds.into_iter().map(|((kind, fate), count)| format!("{kind} {fate} ({count})")).collect();
        if self.single_precision && objects(scene).any(|o| !o.geometry().points().is_empty()) {
            lost.push("coordinates are rounded to single precision".to_owned());
        }
        if let (UnitRule::Fixed(unit), Unit::Unknown) = (self.unit, scene.unit) {
            lost.push(format!("the unit is unknown: numbers would go out unchanged, in {}", unit.name()));
        }
        lost.extend(self.lost(scene));
        lost
    }

    /// What is lost beside the shapes of objects: a line for each thing that a scene has and the format has not.
    pub(super) fn lost(&self, scene: &Scene) -> Vec<String> {
        let count = |kept: bool, has: fn(&Object) -> bool| {
            if kept { 0 } else { objects(scene).filter(|object| has(object)).count() }
        };
        let foreign = |list: &[(String, String)]| {
            let kept = |key: &str| self.statements.iter().any(|start| key.starts_with(start));
            list.iter().filter(|(key, _)| !kept(key)).count()
        };
        let statements = foreign(&scene.statements)
            + objects(scene).map(|o| foreign(&o.statements)).sum::<usize>()
            + scene.materials.iter().map(|m| foreign(&m.statements)).sum::<usize>();
        let materials = if self.materials { 0 } else { scene.materials.iter().count() };
        let connections = if self.connections { 0 } else { scene.connections().len() };
        let hidden = if self.layers { 0 } else { scene.hidden_count() };
        // A format without layers may give their colours to the objects.
        let layer_colors = if self.layers || self.colors { 0 } else { scene.colored_layers() };
        let of_objects = [
            (
                count(self.hierarchy, |o| o.transform.is_some()),
                "transform(s) are baked in: the format has none",
            ),
            (count(self.hierarchy, |o| o.parent.is_some()), "object(s) lose their place in the hierarchy"),
            (
                count(self.animation, |o| o.animation.is_some()),
                "animation(s) are left out: the frame that the object is in goes out",
            ),
            (count(self.colors, |o| o.color.is_some()), "colour(s) of objects are left out"),
            (count(self.layers, |o| o.layer.is_some()), "layer name(s) are left out"),
            (
                count(self.labels, |o| o.label.is_some()),
                "label(s) are left out: names must differ in the format",
            ),
            (hidden, "object(s) on hidden layers go out as all others: the format cannot hide them"),
            (layer_colors, "colour(s) of layers are left out"),
            (materials, "material(s) are left out"),
            (connections, "connection(s) of surfaces are left out"),
            (statements, "statement(s) of other formats are left out"),
        ];
        let some = of_objects.into_iter().filter(|(count, _)| *count > 0);
        let mut lost: Vec<String> = some.map(|(count, what)| format!("{count} {what}")).collect();
        if self.unit == UnitRule::None {
            lost.push("the file has no unit: a reader must know it".to_owned());
        }
        lost
    }
}

impl fmt::Display for Holds {
    /// In words: `curve, mesh exactly; surface as segments or triangles; no layers, animation; m, y up`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} exactly", self.exact.join(", "))?;
        if !self.tessellated.is_empty() {
            write!(f, "; {} as segments or triangles", self.tessellated.join(", "))?;
        }
        let all = [
            (self.hierarchy, "hierarchy"),
            (self.layers, "layers"),
            (self.colors, "colours of objects"),
            (self.labels, "labels"),
            (self.materials, "materials"),
            (self.animation, "animation"),
            (self.connections, "connections"),
        ];
        let without: Vec<&str> = all.iter().filter(|(has, _)| !has).map(|(_, what)| *what).collect();
        if !without.is_empty() {
            write!(f, "; no {}", without.join(", "))?;
        }
        match self.unit {
            UnitRule::Fixed(unit) => write!(f, "; in {}", unit.name())?,
            UnitRule::Stated => write!(f, "; in any unit")?,
            UnitRule::None => write!(f, "; no unit")?,
        }
        if let Some(up) = self.up {
            write!(f, "; {} up", up.name())?;
        }
        if self.single_precision {
            write!(f, "; single precision")?;
        }
        Ok(())
    }
}

/// The objects of a scene, those of its definitions first.
fn objects(scene: &Scene) -> impl Iterator<Item = &Object> {
    scene.definitions().iter().flat_map(Definition::objects).chain(scene.objects())
}

/// The name of a kind of geometry in declarations.
fn kind(geometry: &Geometry) -> &str {
    if matches!(geometry, Geometry::Custom(_)) { "shape" } else { geometry.kind() }
}

impl FormatDeclaration {
    /// The options that reading has.
    pub fn reading_options(&self) -> impl Iterator<Item = &'static Field> + Clone {
        self.options.iter().filter(|option| !option.help.starts_with("writing: "))
    }

    /// The options that writing has.
    pub fn writing_options(&self) -> impl Iterator<Item = &'static Field> + Clone {
        self.options.iter().filter(|option| !option.help.starts_with("reading: "))
    }

    /// Refuses options that the format has not.
    pub(super) fn check(
        &self,
        own: &Parameters,
        known: impl Iterator<Item = &'static Field> + Clone,
    ) -> Result<(), FormatError> {
        own.check(known).map_err(|mut error| {
            error.path = format!("an option of the format {}: {}", self.name, error.path);
            error.into()
        })
    }
}
