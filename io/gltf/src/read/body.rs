//! Meshes that are the same but for their names and materials: put together once.

use std::collections::HashMap;
use std::fmt::Write as _;

use loftsman_kernel::plugin::{Fate, FormatError, ReadReport};

use super::mesh::{Shape, Targets};
use super::schema;

/// The shapes of a mesh: its faces and lines, and its loose points.
type Shapes = (Shape, Shape);

/// What was put together of the primitives of a mesh.
struct Body {
    shapes: Shapes,
    /// The material of each primitive.
    materials: Vec<Option<usize>>,
    /// What was said of them.
    report: ReadReport,
}

/// The bodies that more than one mesh has, as long as there are such meshes to come.
#[derive(Default)]
pub(super) struct Bodies {
    left: HashMap<String, usize>,
    known: HashMap<String, Body>,
}

impl Bodies {
    /// Notes that a mesh will be read.
    pub(super) fn expect(&mut self, mesh: &schema::Mesh<'_>, targets: Targets) {
        *self.left.entry(key(mesh, targets)).or_default() += 1;
    }

    /// The shapes of a mesh: those of an earlier one with the mesh's own materials, or what `put` puts together.
    pub(super) fn shapes(
        &mut self,
        mesh: &schema::Mesh<'_>,
        targets: Targets,
        report: &mut ReadReport,
        put: impl FnOnce(&mut ReadReport) -> Result<Shapes, FormatError>,
    ) -> Result<Shapes, FormatError> {
        let key = key(mesh, targets);
        let left = self.left.get_mut(&key).map_or(0, |left| {
            *left = left.saturating_sub(1);
            *left
        });
        let materials: Vec<Option<usize>> = materials(mesh).collect();
        if let Some(body) = self.known.get(&key) {
            // Materials are alike in the same places: one goes over into one. Lines and points without a material have no slot for one, and are asked anew.
            let now: HashMap<_, _> = body.materials.iter().copied().zip(materials).collect();
            let has_faces = has_faces(mesh);
            let only_points = mesh.primitives.iter().all(|primitive| mode(primitive) == 0);
            let dressed = |shape: &Shape, is_loose: bool| {
                let slots = if has_faces && !is_loose {
                    shape.slots.iter().map(|slot| now.get(slot).copied().unwrap_or(*slot)).collect()
                } else {
                    let is_own = |primitive: &&schema::Primitive<'_>| {
                        if is_loose { mode(primitive) == 0 } else { only_points || mode(primitive) != 0 }
                    };
                    let first = mesh.primitives.iter().filter(is_own).find_map(|p| p.material);
                    first.map(|material| Some(material.index())).into_iter().collect()
                };
                Shape { slots, ..shape.clone() }
            };
            let shapes = (dressed(&body.shapes.0, false), dressed(&body.shapes.1, true));
            say_again(&body.report, report);
            if left == 0 {
                self.known.remove(&key);
            }
            return Ok(shapes);
        }
        let mut own = ReadReport::default();
        let shapes = put(&mut own)?;
        say_again(&own, report);
        report.notes.append(&mut own.notes);
        if left > 0 {
            self.known.insert(key, Body { shapes: shapes.clone(), materials, report: own });
        }
        Ok(shapes)
    }
}

fn mode(primitive: &schema::Primitive<'_>) -> u64 {
    primitive.mode.map_or(4, |mode| mode.0)
}

fn has_faces(mesh: &schema::Mesh<'_>) -> bool {
    mesh.primitives.iter().any(|primitive| mode(primitive) >= 4)
}

fn materials(mesh: &schema::Mesh<'_>) -> impl Iterator<Item = Option<usize>> {
    mesh.primitives.iter().map(|primitive| primitive.material.map(schema::Whole::index))
}

/// All that the shapes of a mesh depend on, and what is said of them; materials by where they are the same.
fn key(mesh: &schema::Mesh<'_>, targets: Targets) -> String {
    let mut slots: HashMap<Option<usize>, usize> = HashMap::new();
    let mut key = format!("{targets:?}");
    let has_faces = has_faces(mesh);
    for (primitive, material) in mesh.primitives.iter().zip(materials(mesh)) {
        let next = slots.len();
        let slot = *slots.entry(material).or_insert(next);
        let extensions: Vec<_> = primitive.extensions.iter().flat_map(|e| e.keys()).collect();
        // Beside faces the material of lines is one of the slots that they count, or none is.
        let counts = has_faces && mode(primitive) < 4 && material.is_some();
        let schema::Primitive { attributes, indices, mode, targets, extras, .. } = primitive;
        // Writing to a string cannot fail.
        let _ = write!(
            key,
            "{attributes:?} {indices:?} {mode:?} {targets:?} {extensions:?} {} {slot} {counts};",
            extras.is_some()
        );
    }
    key
}

/// Counts once more what was counted.
fn say_again(said: &ReadReport, report: &mut ReadReport) {
    report.count_many(Fate::Kept, "", said.kept);
    for (fate, reasons) in [(Fate::Approximated, &said.approximated), (Fate::LeftOut, &said.left_out)] {
        for (reason, &count) in reasons {
            report.count_many(fate, reason, count);
        }
    }
}
