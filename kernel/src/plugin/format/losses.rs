//! What a scene loses on its way into the files of a format: from the declaration alone, so that it can be told beforehand, and
//! is told in the same words afterwards.

use std::collections::{BTreeMap, HashSet};

use super::declaration::{Holds, MeshPart, UnitRule};
use super::options::WriteOptions;
use crate::mesh::Mesh;
use crate::named::Named;
use crate::scene::{Definition, Geometry, Object, Scene, Unit};
use crate::spline::Space;
use crate::text::{clip, counted};

/// Of so many names of statements that are left out each is told, of more the first.
const NAMED: usize = 3;

impl MeshPart {
    /// Whether a mesh has it.
    fn is_in(self, mesh: &Mesh) -> bool {
        match self {
            Self::Polygons => mesh.faces().any(|face| face.len() > 3),
            Self::Normals => !mesh.normals.is_empty(),
            Self::Uvs => !mesh.uvs.is_empty(),
            Self::Colors => !mesh.colors.is_empty(),
            Self::Lines => mesh.face_count() > 0 && mesh.lines().next().is_some(),
            Self::Corners => mesh.differs_at_points(),
            Self::CornerColors => mesh.colors_differ_at_points(),
            Self::Tangents => !mesh.tangents.is_empty(),
            Self::FurtherUvs => !mesh.more_uvs.is_empty(),
            Self::Groups => !mesh.groups.is_empty(),
            Self::Smoothing => !mesh.smoothing.is_empty(),
            Self::BareLines => mesh.face_count() == 0 && mesh.lines().next().is_some(),
            Self::BarePoints => mesh.face_count() == 0 && mesh.lines().next().is_none(),
        }
    }

    /// What becomes of it where the format has no such thing.
    fn fate(self) -> &'static str {
        match self {
            Self::Polygons => "[has|have] faces of more than three corners, which are cut into triangles",
            Self::Normals => "[has|have] normals, which are left out",
            Self::Uvs => "[has|have] texture coordinates, which are left out",
            Self::Colors => "[has|have] colours of points, which are left out",
            Self::Lines => "[has|have] lines beside faces, which are left out",
            Self::Corners => {
                "[has|have] values that differ between the faces at a point: such points are doubled"
            }
            Self::CornerColors => {
                "[has|have] colours that differ between the faces at a point: one of them goes out"
            }
            Self::Tangents => "[has|have] tangents, which are left out",
            Self::FurtherUvs => "[has|have] further texture coordinates, which are left out",
            Self::Groups => "[has|have] groups of faces, which are left out",
            Self::Smoothing => "[has|have] smoothing groups, which are left out",
            Self::BareLines => {
                "[is|are] lines without faces, each chain of which is read as a polyline of its own"
            }
            Self::BarePoints => "[is|are] points without faces, read as [a cloud|clouds]",
        }
    }
}

impl Holds {
    /// Why a scene cannot be written at all, if the format refuses one of which nothing would go out.
    pub fn refusal(&self, scene: &Scene) -> Option<String> {
        let holds = |o: &&Object| self.exactly(o.geometry()) || self.tessellates(o.geometry());
        let refused = self.refuses_nothing && !shown(scene).iter().any(holds);
        refused.then(|| {
            format!(
                "there is no {} in the scene, and such a file holds nothing else: choose another format, or make some first (tessellate and sample make lines of curves)",
                [self.exact, self.tessellated].concat().join(" and no ")
            )
        })
    }

    /// What is lost of a scene that is written with these options, a line for each kind of thing.
    pub(super) fn losses(&self, scene: &Scene, options: &WriteOptions<'_>) -> Vec<String> {
        let objects = shown(scene);
        let mut lost = self.lost_kinds(&objects, options);
        let count = |kept: bool, has: &dyn Fn(&Object) -> bool| {
            if kept { 0 } else { objects.iter().filter(|object| has(object)).count() }
        };
        let mut say = |count: usize, what: &str| {
            if count > 0 {
                lost.push(counted(count, what));
            }
        };
        if objects.iter().any(|o| matches!(o.geometry(), Geometry::Mesh(_)) && self.exactly(o.geometry())) {
            for part in self.missing_parts() {
                let has = |o: &Object| matches!(o.geometry(), Geometry::Mesh(mesh) if part.is_in(mesh));
                say(count(false, &has), &format!("mesh[|es] {}", part.fate()));
            }
        }
        let is_simple = |o: &Object| matches!(o.geometry(), Geometry::Curve(c) if !is_bezier(c.space()));
        say(
            count(self.knots || !self.exact.contains(&"curve"), &is_simple),
            "curve[|s] [goes|go] out in Bézier form: the same shape[|s] with more control vertices, open where [it was|they were] periodic",
        );
        let opened = |o: &Object| self.exactly(o.geometry()) && is_unclamped(o.geometry());
        say(
            count(self.unclamped || !self.knots, &opened),
            "[curve or surface is|curves or surfaces are] clamped: the same shape[|s] with more control vertices, open where [it was|they were] periodic",
        );
        say(
            count(self.hierarchy, &|o| o.transform.is_some()),
            "transform[|s] [is|are] baked in: the format has none",
        );
        say(
            count(self.hierarchy, &|o| o.parent.is_some()),
            "object[|s] [loses its|lose their] place in the hierarchy",
        );
        say(
            count(self.animation, &|o| o.animation.is_some()),
            "animation[|s] [is|are] left out: the frame that the object is in goes out",
        );
        say(
            count(self.colors, &|o| o.color.is_some()),
            "[colour of an object is|colours of objects are] left out",
        );
        say(count(self.layers, &|o| o.layer.is_some()), "layer name[|s] [is|are] left out");
        say(
            count(self.labels, &|o| o.label.is_some()),
            "label[|s] [is|are] left out: names must differ in the format",
        );
        let hidden = if self.hides { 0 } else { scene.hidden_count() };
        say(
            hidden,
            "[object is on a hidden layer and goes|objects are on hidden layers and go] out as all others: other programs show them",
        );
        if !self.layer_trees {
            // A format without layers may give their colours to the objects.
            match (self.layers, self.colors) {
                (true, true) => {
                    say(
                        scene.colored_layers(),
                        "[colour of a layer becomes that of what is on it|colours of layers become those of what is on them]",
                    );
                }
                (false, true) => {}
                (_, false) => {
                    say(scene.colored_layers(), "[colour of a layer is|colours of layers are] left out");
                }
            }
            let below = scene.layers.iter().filter(|layer| layer.parent.is_some()).count();
            say(
                if self.layers { below } else { 0 },
                "layer[|s] [loses its|lose their] place below [another|others]",
            );
        }
        let (materials, images, definitions) = unused(scene, &objects);
        let all = scene.materials.iter().count();
        if !self.materials {
            let shown = if self.base_colors { all - materials } else { 0 };
            say(
                shown,
                "material[|s] [goes|go] out as [its|their] base colour[|s]: all else that [it says|they say] is left out",
            );
            say(all - shown, "material[|s] [is|are] left out");
            say(scene.images.iter().count(), "picture[|s] [is|are] left out");
        } else if !self.unused {
            let lost = if self.unused_materials { 0 } else { materials };
            say(lost, "material[|s] that no object has [is|are] lost");
            say(images, "picture[|s] that nothing shows [is|are] lost");
        }
        if !self.unused {
            say(definitions, "definition[|s] that nothing shows [is|are] lost");
        }
        let connections = if self.connections { 0 } else { scene.connections().len() };
        say(connections, "connection[|s] of surfaces [is|are] left out");
        lost.extend(self.lost_statements(scene, &objects));
        if self.single_precision && objects.iter().any(|o| !o.geometry().points().is_empty()) {
            lost.push("coordinates are rounded to single precision".to_owned());
        }
        lost.extend(self.lost_unit(scene.unit, options.unit));
        lost
    }

    /// A line for each kind of geometry that the format has not.
    fn lost_kinds(&self, objects: &[&Object], options: &WriteOptions<'_>) -> Vec<String> {
        let mut kinds: BTreeMap<(&str, &str), usize> = BTreeMap::new();
        for geometry in objects.iter().map(|object| object.geometry()) {
            // Shapes of plug-ins draw themselves.
            let cuts = options.tessellator.is_some() || matches!(geometry, Geometry::Custom(_));
            let fate = match (self.tessellates(geometry) && cuts, self.carries(geometry)) {
                (true, _) if self.exactly(geometry) => {
                    "goes out exactly and as triangles, both of which others read"
                }
                _ if self.exactly(geometry) => continue,
                _ if geometry.is_unknown() => "is left out: its plug-in is not here",
                (true, false) => "becomes segments or triangles",
                (true, true) => "becomes segments or triangles; the exact one goes along for Loftsman",
                (false, true) => "goes along for Loftsman: other programs see nothing of it",
                _ if matches!(geometry, Geometry::Instance(_)) => "is written object by object",
                _ if self.splines_of_shapes && is_splines(geometry) => "goes out as the splines that it is",
                _ if matches!(geometry, Geometry::Custom(_)) => {
                    "is left out: make splines or triangles of it first (operations patches and tessellate)"
                }
                _ => "is left out",
            };
            *kinds.entry((geometry.kind(), fate)).or_default() += 1;
        }
        kinds.into_iter().map(|((kind, fate), count)| format!("{kind} {fate} ({count})")).collect()
    }

    /// What happens to a unit that is not known, that the file cannot say, or that is not the format's.
    fn lost_unit(&self, unit: Unit, asked: Option<Unit>) -> Option<String> {
        if let (Some(asked), UnitRule::Fixed(fixed)) = (asked, self.unit)
            && asked != fixed
            && asked != Unit::Unknown
            && unit != Unit::Unknown
        {
            return Some(format!(
                "numbers go out in the unit {}, as asked for, and other programs take them for {}, as the format has it: leave the unit out to have them converted",
                asked.name(),
                fixed.name()
            ));
        }
        let target = match (asked, self.unit) {
            (Some(unit), _) => Some((unit, "as asked for")),
            (None, UnitRule::Fixed(unit)) => Some((unit, "as the format has it")),
            _ => None,
        };
        match target.filter(|(target, _)| unit == Unit::Unknown && *target != Unit::Unknown) {
            Some((target, whose)) => Some(format!(
                "the unit of the scene is unknown: its numbers go out unchanged, in {}, {whose}; name the unit of the \
                 input if it is another",
                target.name()
            )),
            None => (self.unit == UnitRule::None && unit != Unit::Unknown)
                .then(|| "the format has no unit: other programs must be told it".to_owned()),
        }
    }

    /// A line on the statements that are not of this format, with what the first of them are called.
    fn lost_statements(&self, scene: &Scene, objects: &[&Object]) -> Option<String> {
        let own = objects.iter().flat_map(|object| &object.statements);
        let of_materials = scene.materials.iter().flat_map(|material| &material.statements);
        let all = scene.statements.iter().chain(own).chain(of_materials).map(|(key, _)| key.as_str());
        let foreign: Vec<&str> =
            all.filter(|key| !self.statements.iter().any(|start| key.starts_with(start))).collect();
        let what = counted(foreign.len(), "statement[|s] of other formats [is|are] left out");
        let mut names: Vec<&str> = Vec::new();
        for key in &foreign {
            if !names.contains(key) && names.len() <= NAMED {
                names.push(key);
            }
        }
        let more = if names.len() > NAMED { ", …" } else { "" };
        names.truncate(NAMED);
        (!foreign.is_empty()).then(|| {
            let names: Vec<String> = names.into_iter().map(clip).collect();
            format!("{what} ({}{more})", names.join(", "))
        })
    }
}

/// The objects of a scene and of the definitions that it shows, each once.
fn shown(scene: &Scene) -> Vec<&Object> {
    let mut objects: Vec<&Object> = scene.objects().iter().collect();
    let mut seen: HashSet<&str> = HashSet::new();
    let mut at = 0;
    while let Some(object) = objects.get(at) {
        at += 1;
        if let Geometry::Instance(of) = object.geometry()
            && let Some(definition) = scene.definitions().get(of)
            && seen.insert(definition.name())
        {
            objects.extend(Definition::objects(definition));
        }
    }
    objects
}

/// How many materials no object of these has, pictures no material of theirs shows, and definitions none of them shows.
fn unused(scene: &Scene, objects: &[&Object]) -> (usize, usize, usize) {
    let used: HashSet<&str> = objects.iter().flat_map(|o| &o.materials).map(String::as_str).collect();
    let (with, without): (Vec<_>, Vec<_>) = scene.materials.iter().partition(|m| used.contains(m.name()));
    let shown: HashSet<&str> =
        with.iter().flat_map(|m| m.textures.values()).map(|texture| texture.image.as_str()).collect();
    let images = scene.images.iter().filter(|image| !shown.contains(image.name())).count();
    let names: HashSet<&str> = objects
        .iter()
        .filter_map(|o| match o.geometry() {
            Geometry::Instance(of) => Some(of.as_str()),
            _ => None,
        })
        .collect();
    let definitions = scene.definitions().iter().filter(|d| !names.contains(d.name())).count();
    (without.len(), images, definitions)
}

/// Whether a spline, or one that it is made of, has knots that are not clamped.
fn is_unclamped(geometry: &Geometry) -> bool {
    match geometry {
        Geometry::Curve(curve) => !curve.is_clamped(),
        Geometry::Surface(surface) => !surface.is_clamped(),
        Geometry::Trimmed(trimmed) => !trimmed.surface().is_clamped(),
        Geometry::Brep(brep) => {
            let surfaces = (0..brep.face_count()).filter_map(|face| brep.surface(face));
            let curves = (0..brep.edge_count()).filter_map(|edge| brep.curve(edge));
            surfaces.into_iter().any(|surface| !surface.is_clamped())
                || curves.into_iter().any(|curve| !curve.is_clamped())
        }
        _ => false,
    }
}

/// Whether a space is that of Bézier segments: all knots as often as the degree.
fn is_bezier(space: &Space) -> bool {
    let knots = space.breakpoints();
    let inner = knots.get(1..knots.len().saturating_sub(1)).unwrap_or_default();
    !space.is_periodic()
        && space.is_clamped()
        && inner.iter().all(|&u| space.multiplicity(u) >= space.degree())
}

/// Whether it is a shape of a plug-in that is splines exactly.
fn is_splines(geometry: &Geometry) -> bool {
    matches!(geometry, Geometry::Custom(custom) if custom.splines().is_some())
}
