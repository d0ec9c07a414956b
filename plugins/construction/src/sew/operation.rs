//! The operation `sew`.

use loftsman_kernel::brep::Parts;
use loftsman_kernel::error::Error;
use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, Parameters, StepReport, object_names,
};
use loftsman_kernel::scene::{Geometry, Scene};
use loftsman_kernel::text::a;

use super::gather::{Healed, gather};
use super::hint::rounded_up;
use super::told::{Told, told};
use super::{Sewn, sew_parts};
use crate::fields::{NAME, free_name, length, like, named};

/// A tolerance is between rounding and what leaves something of the faces, as parts of the size of all.
const LEAST: f64 = 1e-14;
const MOST: f64 = 0.1;
/// Without a tolerance edges are one that are as near as this part of the size of all.
const NEAR: f64 = 1e-6;

/// The operation `sew`: [`sew`](super::sew()) of objects, which become one.
#[derive(Debug, Clone, Copy, Default)]
pub struct Sew;

impl Operation for Sew {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[
            Field::required(
                "objects",
                "[name, …]",
                "surfaces, trimmed surfaces and breps; \"part*\" is all that begin so",
            ),
            Field::optional(
                "tolerance",
                "length",
                "1e-6 of the size of all",
                "how far edges may be from one another that become one",
            ),
            Field::optional("keep", "true | false", "false", "leave the objects in the scene beside it"),
            NAME,
        ];
        Declaration {
            name: "sew",
            help: "make faces that lie beside one another one brep: edges within a tolerance become one, faces look to one side, what closes becomes a solid; reports the widest gap closed and what is still open",
            fields: FIELDS,
        }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        p: &Parameters,
        context: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        p.check(self.declaration().fields)?;
        let asked = Asked::of(scene, p)?;
        let tessellator = context.registry.tessellator();
        let tessellator = tessellator.ok_or_else(|| Error::Invalid("no tessellator is registered".into()))?;
        let (parts, healed) = asked.gathered(scene)?;
        let faces = parts.faces.len();
        let sewn = sew_parts(parts, asked.near, healed, tessellator)?;
        let told = told(&sewn, faces, asked.near, &|length| scene.unit.quantity(length, 1));
        let numbers = [
            ("faces", sewn.brep.face_count()),
            ("joined", sewn.joined),
            ("open", sewn.open.len()),
            ("solids", sewn.brep.solids().len()),
            ("turned", sewn.turned),
            ("short", sewn.short),
            ("twice", sewn.twice),
            ("inverted", sewn.inverted),
        ];
        let lengths = [
            ("gap", Some(sewn.gap)),
            ("tolerance", Some(asked.near)),
            ("next", sewn.next.map(rounded_up)),
            ("closes", sewn.closes.map(rounded_up)),
        ];
        let name = asked.put(scene, p, sewn)?;
        let Told { notes, warnings } = told;
        let mut report =
            StepReport { op: "sew".into(), object: Some(name), notes, warnings, ..StepReport::default() };
        report.numbers.extend(numbers.map(|(word, count)| (word.into(), count.into())));
        let lengths = lengths.into_iter().filter_map(|(word, length)| Some((word.into(), length?.into())));
        report.numbers.extend(lengths);
        Ok(report)
    }
}

/// What is to be sewn.
struct Asked {
    names: Vec<String>,
    geometries: Vec<Geometry>,
    /// Where all stand alike and as large as they are what is made stands there too, else in the scene by itself.
    alike: bool,
    near: f64,
}

impl Asked {
    fn of(scene: &Scene, p: &Parameters) -> Result<Self, OperationError> {
        let has_faces =
            |g: &Geometry| matches!(g, Geometry::Brep(_) | Geometry::Surface(_) | Geometry::Trimmed(_));
        let names = object_names(scene, p, "objects", has_faces)?;
        let Some(first) = names.first() else {
            return Err(p.error("objects", "is empty: name what is to be sewn").into());
        };
        for name in &names {
            scene.object(name).map_err(|e| p.error("objects", e.to_string()))?;
        }
        let standing = scene.standing(first)?;
        let mut alike = !standing.changes_size();
        for name in &names {
            alike &= scene.standing(name)? == standing;
        }
        let geometries = placed(scene, p, &names, alike)?;
        let size = size(&geometries);
        let near = if p.has("tolerance") { length(p, "tolerance")? } else { NEAR * size };
        let reach =
            geometries.iter().flat_map(Geometry::points).map(|q| q.coords.amax()).fold(size, f64::max);
        if !(near > LEAST * reach && near < MOST * size) {
            let problem = format!(
                "{near} is no tolerance for what is {size} large: give one above rounding and below a tenth of the size"
            );
            return Err(p.error("tolerance", problem).into());
        }
        Ok(Self { names, geometries, alike, near })
    }

    /// The faces of all of it, in the colours of what they come from, and called so where that is one face.
    fn gathered(&self, scene: &Scene) -> Result<(Parts, Healed), OperationError> {
        let (mut parts, mut healed) = (Parts::default(), Healed::default());
        for (name, geometry) in self.names.iter().zip(&self.geometries) {
            let before = parts.faces.len();
            gather(&mut parts, geometry, self.near, &mut healed).map_err(named(name))?;
            let count = parts.faces.len() - before;
            let object = scene.object(name)?;
            for face in &mut parts.faces[before..] {
                face.color = face.color.or(object.color);
                if count == 1 {
                    face.name.get_or_insert_with(|| object.label().to_owned());
                }
            }
        }
        Ok((parts, healed))
    }

    /// Puts what was made in the place of what it was made of; its name.
    fn put(&self, scene: &mut Scene, p: &Parameters, sewn: Sewn) -> Result<String, OperationError> {
        let first = self.names.first().map(String::as_str).unwrap_or_default();
        let name = free_name(scene, p, &format!("{first} sewn"))?;
        let mut object = like(scene, first, &name, sewn.brep.into());
        if !self.alike {
            (object.parent, object.transform) = (None, None);
        }
        // Faces have the colours of what they come from.
        object.color = None;
        let mut changed = scene.clone();
        changed.add(object)?;
        if !(p.has("keep") && p.flag("keep")?) {
            for name in &self.names {
                changed.remove(name)?;
            }
        }
        *scene = changed;
        Ok(name)
    }
}

/// The geometries of objects: as they are, where all stand alike, else as they stand in the scene.
fn placed(
    scene: &Scene,
    p: &Parameters,
    names: &[String],
    alike: bool,
) -> Result<Vec<Geometry>, OperationError> {
    let mut all = Vec::with_capacity(names.len());
    for name in names {
        let geometry = scene.object(name)?.geometry();
        match geometry {
            Geometry::Brep(brep) if !brep.solids().is_empty() => {
                let problem = format!("\"{name}\" is a solid already, and nothing of it open: leave it out");
                return Err(p.error("objects", problem).into());
            }
            Geometry::Brep(_) | Geometry::Surface(_) | Geometry::Trimmed(_) => {}
            other => {
                let problem = format!(
                    "\"{name}\" is {}, which has no faces to sew: name surfaces, trimmed surfaces and breps",
                    a(&other.noun())
                );
                return Err(p.error("objects", problem).into());
            }
        }
        all.push(if alike {
            geometry.clone()
        } else {
            scene.standing(name)?.seen(geometry).map_err(named(name))?.into_owned()
        });
    }
    Ok(all)
}

/// The largest side of the box around all control vertices.
fn size(geometries: &[Geometry]) -> f64 {
    let mut points = geometries.iter().flat_map(|geometry| geometry.points());
    let Some(first) = points.next().copied() else { return 0.0 };
    let (low, high) = points.fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
    (high - low).amax()
}
