//! Objects that share a geometry share what shows it: its vertices are written once, and so is its mesh.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use loftsman_kernel::plugin::{Chord, Fineness, FormatError, Written};
use loftsman_kernel::scene::{Geometry, Object};
use nalgebra::Matrix4;

use super::Writer;
use super::animation::Moves;
use super::frame::Frame;
use super::object::Shown;
use super::shape::Shaped;
use crate::extras::ExtrasFields;
use crate::words::{MATERIAL, MESH_DATA, MESH_NAME};

/// What is drawn of an object.
pub(super) enum Drawn {
    /// Nothing: a group, or what is left out.
    Nothing,
    /// Nothing, but its exact spline is in extras.
    Unseen(Box<ExtrasFields>),
    /// A mesh of the document, moved by its frame, and what is noted beside it.
    Mesh(usize, Frame, Box<ExtrasFields>),
}

/// What the vertices of an object depend on, where it does not move and nothing is baked into them.
#[derive(Clone, PartialEq, Eq, Hash)]
struct ShapeKey {
    /// [`Object::geometry_id`].
    geometry: usize,
    /// The slots that need tangents, and their sets of texture coordinates.
    maps: BTreeMap<u32, u32>,
    /// How finely a spline is cut.
    fineness: Option<(bool, [u64; 3])>,
}

/// What a mesh depends on, but for its name.
#[derive(Clone, PartialEq, Eq, Hash)]
struct MeshKey<'a> {
    shape: ShapeKey,
    materials: &'a [String],
    color: Option<[u64; 4]>,
    extras: Option<&'a str>,
    /// What it says of having no material.
    bare: Option<&'a str>,
}

/// A mesh of the document, and what is said of an object that it shows.
struct Known {
    mesh: usize,
    frame: Frame,
    noted: ExtrasFields,
    report: Written,
    /// Whether an object says that its mesh is called so.
    stated: bool,
}

/// What was written of geometry that objects share.
#[derive(Default)]
pub(super) struct Shared<'a> {
    shapes: HashMap<ShapeKey, (Shaped, ExtrasFields, Written)>,
    known: Vec<Known>,
    /// By its name, for objects that say how their mesh is called; without one, the first, for those that do not.
    meshes: HashMap<(MeshKey<'a>, Option<&'a str>), usize>,
}

impl<'a> Writer<'a, '_> {
    /// What is drawn of an object, moved by `rest`: what was drawn of another one, where that is the same.
    pub(super) fn drawn(
        &mut self,
        index: usize,
        object: &'a Object,
        rest: &Matrix4<f64>,
        stretch: f64,
        report: &mut Written,
    ) -> Result<Drawn, FormatError> {
        let Some(shape) = self.shape_key(object, rest, stretch) else {
            return match self.shape(object, rest, stretch, report)? {
                Shown::Nothing => Ok(Drawn::Nothing),
                Shown::Unseen(own) => Ok(Drawn::Unseen(own)),
                Shown::Shaped(shaped, moves, own) => {
                    self.as_mesh(index, object, *shaped, moves, *own, report)
                }
            };
        };
        let key = MeshKey {
            shape,
            materials: &object.materials,
            color: self.scene.color_of(object).map(|color| color.map(f64::to_bits)),
            extras: object.statement(MESH_DATA),
            bare: object.statement(MATERIAL),
        };
        let called = object.statement(MESH_NAME);
        let by_name = (key, called);
        if let Some(known) = self.shared.meshes.get(&by_name).and_then(|&at| self.shared.known.get_mut(at)) {
            known.stated |= called.is_some();
            // A mesh that nobody has named is not called after one of those who show it.
            if let Some(mesh) = self.meshes.get_mut(known.mesh)
                && !known.stated
                && mesh.name != object.label()
            {
                mesh.name.clear();
            }
            copy_report(&known.report, report);
            return Ok(Drawn::Mesh(known.mesh, known.frame, Box::new(known.noted.clone())));
        }
        let (shaped, own) = match self.shared.shapes.get(&by_name.0.shape) {
            Some((shaped, own, said)) => {
                copy_report(said, report);
                (shaped.clone(), own.clone())
            }
            None => match self.shape(object, rest, stretch, report)? {
                Shown::Nothing => return Ok(Drawn::Nothing),
                Shown::Unseen(own) => return Ok(Drawn::Unseen(own)),
                Shown::Shaped(shaped, _, own) => {
                    let known = ((*shaped).clone(), (*own).clone(), report.clone());
                    self.shared.shapes.insert(by_name.0.shape.clone(), known);
                    (*shaped, *own)
                }
            },
        };
        let drawn = self.as_mesh(index, object, shaped, None, own, report)?;
        if let Drawn::Mesh(mesh, frame, noted) = &drawn {
            let at = self.shared.known.len();
            let (noted, report) = ((**noted).clone(), report.clone());
            let stated = called.is_some();
            self.shared.known.push(Known { mesh: *mesh, frame: *frame, noted, report, stated });
            let (key, _) = by_name;
            self.shared.meshes.insert((key.clone(), Some(called.unwrap_or(object.label()))), at);
            self.shared.meshes.entry((key, None)).or_insert(at);
        }
        Ok(drawn)
    }

    fn as_mesh(
        &mut self,
        index: usize,
        object: &'a Object,
        shaped: Shaped,
        moves: Option<Moves<'a>>,
        mut noted: ExtrasFields,
        report: &mut Written,
    ) -> Result<Drawn, FormatError> {
        let frame = shaped.frame;
        let mesh = self.mesh(index, object, shaped, moves, &mut noted, report)?;
        Ok(Drawn::Mesh(mesh, frame, Box::new(noted)))
    }

    /// `None` where nobody else can have the same.
    fn shape_key(&self, object: &Object, rest: &Matrix4<f64>, stretch: f64) -> Option<ShapeKey> {
        let is_shared = Arc::strong_count(object.shared_geometry()) > 1;
        let stands = object.animation.is_none() && *rest == Matrix4::identity();
        let shows = !matches!(object.geometry(), Geometry::Group);
        // What is cut as what is beside it is there once.
        let apart = !is_shared || self.beside(object).is_none();
        (is_shared && stands && shows && apart).then(|| ShapeKey {
            geometry: object.geometry_id(),
            maps: self.materials.normal_maps(&object.materials),
            fineness: match object.geometry() {
                Geometry::Curve(_)
                | Geometry::Surface(_)
                | Geometry::Trimmed(_)
                | Geometry::Brep(_)
                | Geometry::Custom(_) => Some(bits(self.fineness(object, stretch, false), stretch)),
                _ => None,
            },
        })
    }
}

/// What was said of another object, of this one.
fn copy_report(said: &Written, report: &mut Written) {
    let object = std::mem::take(&mut report.object);
    *report = Written { object, ..said.clone() };
}

/// What decides how a spline is cut and what the report says of it, by the bits: it speaks of the scene's lengths.
fn bits(fineness: Fineness, stretch: f64) -> (bool, [u64; 3]) {
    let (is_relative, chord) = match fineness.chord {
        Chord::Relative(fraction) => (true, fraction),
        Chord::Absolute(length) => (false, length),
    };
    (is_relative, [chord, fineness.angle, stretch].map(f64::to_bits))
}
