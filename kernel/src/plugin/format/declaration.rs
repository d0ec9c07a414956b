//! What a format declares: its name and options, and what its files say and hold.

use std::fmt;

use super::error::FormatError;
use crate::declare::{Field, Parameters};
use crate::scene::{Geometry, Unit, Up};

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

/// What a mesh may have beside points, triangles and a normal, texture coordinates and a colour at each point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum MeshPart {
    /// Faces of more than three corners.
    Polygons,
    /// Normals.
    Normals,
    /// Texture coordinates.
    Uvs,
    /// Colours of points.
    Colors,
    /// Lines beside faces.
    Lines,
    /// Normals, tangents and texture coordinates that differ between the faces at a point.
    Corners,
    /// Colours that do.
    CornerColors,
    /// Tangents.
    Tangents,
    /// Texture coordinates beside the first ones.
    FurtherUvs,
    /// Named groups of faces.
    Groups,
    /// Smoothing groups.
    Smoothing,
    /// Lines without faces.
    BareLines,
    /// Points without faces and lines.
    BarePoints,
}

impl MeshPart {
    /// All of them.
    pub const ALL: &'static [Self] = &[
        Self::Polygons,
        Self::Normals,
        Self::Uvs,
        Self::Colors,
        Self::Lines,
        Self::Corners,
        Self::CornerColors,
        Self::Tangents,
        Self::FurtherUvs,
        Self::Groups,
        Self::Smoothing,
        Self::BareLines,
        Self::BarePoints,
    ];

    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Polygons => "polygons",
            Self::Normals => "normals",
            Self::Uvs => "texture coordinates",
            Self::Colors => "colours of points",
            Self::Lines => "lines beside faces",
            Self::Corners => "values by corner",
            Self::CornerColors => "colours by corner",
            Self::Tangents => "tangents",
            Self::FurtherUvs => "further texture coordinates",
            Self::Groups => "groups",
            Self::Smoothing => "smoothing groups",
            Self::BareLines => "meshes of lines",
            Self::BarePoints => "meshes of points",
        }
    }
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
    /// The kinds that go out as segments or triangles; those that go out exactly as well do both.
    pub tessellated: &'static [&'static str],
    /// The kinds that go along exactly beside that, or alone, for Loftsman to read: other programs see nothing of them.
    pub carried: &'static [&'static str],
    /// Whether shapes of plug-ins that are splines exactly go out as these.
    pub splines_of_shapes: bool,
    /// What meshes keep.
    pub meshes: &'static [MeshPart],
    /// Whether curves keep their knots; else they go out in Bézier form.
    pub knots: bool,
    /// Knots that are not clamped: of closed curves and surfaces, and of those that float.
    pub unclamped: bool,
    /// Transforms, and which object hangs under which.
    pub hierarchy: bool,
    /// Layers: their names, and which are hidden.
    pub layers: bool,
    /// The colours of layers, and which lies below which.
    pub layer_trees: bool,
    /// Whether other programs hide what is on hidden layers.
    pub hides: bool,
    /// Colours of objects.
    pub colors: bool,
    /// Names that objects have in common: their labels.
    pub labels: bool,
    /// Materials.
    pub materials: bool,
    /// Of materials the base colours, where it has none: as colours of objects, and of the faces of meshes.
    pub base_colors: bool,
    /// Materials, pictures and definitions that nothing uses.
    pub unused: bool,
    /// Whether materials that no object has are kept, where other things that nothing shows are not.
    pub unused_materials: bool,
    /// Frames of animations.
    pub animation: bool,
    /// Which edges of surfaces are said to be one.
    pub connections: bool,
    /// How statements begin that it keeps word for word; `""` is the beginning of all.
    pub statements: &'static [&'static str],
    /// Whether numbers are rounded to single precision.
    pub single_precision: bool,
    /// Whether a scene of which no object would go out is refused.
    pub refuses_nothing: bool,
}

impl Holds {
    /// Numbers without a unit, and nothing else: for formats that name the few things that they hold.
    pub const NOTHING: Self = Self {
        unit: UnitRule::None,
        up: None,
        exact: &[],
        tessellated: &[],
        carried: &[],
        splines_of_shapes: false,
        meshes: &[],
        knots: false,
        unclamped: false,
        hierarchy: false,
        layers: false,
        layer_trees: false,
        hides: false,
        colors: false,
        labels: false,
        materials: false,
        base_colors: false,
        unused: false,
        unused_materials: false,
        animation: false,
        connections: false,
        statements: &[],
        single_precision: false,
        refuses_nothing: false,
    };

    /// Everything that a scene can be.
    pub const EVERYTHING: Self = Self {
        unit: UnitRule::Stated,
        exact: &[
            "group", "instance", "curve", "surface", "trimmed", "brep", "mesh", "polyline", "cloud", "shape",
        ],
        meshes: MeshPart::ALL,
        knots: true,
        unclamped: true,
        hierarchy: true,
        layers: true,
        layer_trees: true,
        hides: true,
        colors: true,
        labels: true,
        materials: true,
        unused: true,
        unused_materials: true,
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

    /// Whether a geometry goes along for Loftsman alone.
    pub(super) fn carries(&self, geometry: &Geometry) -> bool {
        self.carried.contains(&kind(geometry))
    }

    /// Whether there are instances.
    pub(super) fn instances(&self) -> bool {
        self.exact.contains(&"instance")
    }
}

impl fmt::Display for Holds {
    /// In words: `curve, mesh exactly; surface as segments or triangles; no layers, animation; m, y up`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} exactly", self.exact.join(", "))?;
        if !self.tessellated.is_empty() {
            write!(f, "; {} as segments or triangles", self.tessellated.join(", "))?;
        }
        if !self.carried.is_empty() {
            write!(f, "; {} exactly for Loftsman to read", self.carried.join(", "))?;
        }
        let all = [
            (self.hierarchy, "hierarchy"),
            (self.layers, "layers"),
            (self.colors, "colours of objects"),
            (self.labels, "labels"),
            (self.materials, "materials"),
            (self.animation, "animation"),
            (self.connections, "connections"),
            (self.knots || !self.exact.contains(&"curve"), "knots of curves"),
        ];
        let mut without: Vec<&str> = all.iter().filter(|(has, _)| !has).map(|(_, what)| *what).collect();
        if self.exact.contains(&"mesh") {
            without.extend(self.missing_parts().map(MeshPart::name));
        }
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

impl Holds {
    /// What meshes do not keep. Where they keep no such values at all, those that differ by corner are not told apart from these.
    pub(super) fn missing_parts(&self) -> impl Iterator<Item = MeshPart> + use<> {
        let (meshes, has) = (self.meshes, |part: MeshPart| self.meshes.contains(&part));
        let corners = has(MeshPart::Normals) || has(MeshPart::Uvs);
        let colors = has(MeshPart::Colors);
        MeshPart::ALL.iter().copied().filter(move |part| match part {
            MeshPart::Corners if !corners => false,
            MeshPart::CornerColors if !colors => false,
            part => !meshes.contains(part),
        })
    }
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
