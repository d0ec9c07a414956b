//! The operation `sew`.

use loftsman_kernel::brep::Flaw;
use loftsman_kernel::error::Error;
use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, Parameters, StepReport, object_names,
};
use loftsman_kernel::scene::{Geometry, Scene};
use loftsman_kernel::text::{a, counted};

use super::sew_parts;
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
        let has_faces =
            |g: &Geometry| matches!(g, Geometry::Brep(_) | Geometry::Surface(_) | Geometry::Trimmed(_));
        let names = object_names(scene, p, "objects", has_faces)?;
        let Some(first) = names.first() else {
            return Err(p.error("objects", "is empty: name what is to be sewn").into());
        };
        for name in &names {
            scene.object(name).map_err(|e| p.error("objects", e.to_string()))?;
        }
        // Where all stand alike and as large as they are what is made stands there too, else in the scene by itself.
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
        let tessellator = context.registry.tessellator();
        let tessellator = tessellator.ok_or_else(|| Error::Invalid("no tessellator is registered".into()))?;
        let mut parts = loftsman_kernel::brep::Parts::default();
        for (name, geometry) in names.iter().zip(&geometries) {
            let before = parts.faces.len();
            super::gather::gather(&mut parts, geometry, near).map_err(named(name))?;
            let count = parts.faces.len() - before;
            let object = scene.object(name)?;
            for face in &mut parts.faces[before..] {
                face.color = face.color.or(object.color);
                if count == 1 {
                    face.name.get_or_insert_with(|| object.label().to_owned());
                }
            }
        }
        let faces = parts.faces.len();
        let sewn = sew_parts(parts, near, tessellator)?;
        let quantity = |length: f64| scene.unit.quantity(length, 1);
        let mut notes = vec![if sewn.joined == 0 && sewn.open.is_empty() {
            format!("{}: every edge is that of two already", counted(faces, "face[|s]"))
        } else if sewn.joined == 0 {
            format!(
                "{}: no two edges are within {} of one another",
                counted(faces, "face[|s]"),
                quantity(near)
            )
        } else {
            format!(
                "{}: {} joined, {} apart at most where it was measured",
                counted(faces, "face[|s]"),
                counted(sewn.joined, "pair[|s] of edges [is|are]"),
                quantity(sewn.gap)
            )
        }];
        let mut say = |count: usize, text: &str| {
            if count > 0 {
                notes.push(counted(count, text));
            }
        };
        say(sewn.brep.solids().len(), "shell[|s] close[s|] and [is a solid|are solids]");
        say(
            sewn.brep.solids().iter().map(|solid| solid.voids.len()).sum(),
            "closed shell[|s] within another [is|are] what is hollow in it",
        );
        say(sewn.cut, "place[|s] where an edge was cut at a vertex of another");
        say(sewn.short, "edge[|s] no longer than the tolerance [is|are] left out");
        say(sewn.turned, "face[|s] turned over");
        let mut warnings = Vec::new();
        if !sewn.open.is_empty() {
            let named: Vec<String> = sewn.open.iter().take(5).map(usize::to_string).collect();
            let more = if sewn.open.len() > named.len() { ", …" } else { "" };
            let next = match sewn.next {
                Some(next) => format!("; the next ends that may be one are {} apart", quantity(next)),
                None => String::new(),
            };
            notes.push(format!(
                "open at {} (number {}{more}){next}",
                counted(sewn.open.len(), "edge[|s]"),
                named.join(", ")
            ));
        }
        if sewn.one_sided > 0 {
            let text = "shell[|s] [has|have] one side only, as a Möbius band: no way to turn [its|their] faces fits; parts that touch one another are sewn by themselves";
            warnings.push(counted(sewn.one_sided, text));
        }
        if sewn.unknown > 0 {
            let text = "shell[|s] close[s|], but what is outside could not be told, so that [it is|they are] no solid[|s]";
            warnings.push(counted(sewn.unknown, text));
        }
        warnings.extend(Flaw::told(&sewn.flaws));
        let joined = [
            ("faces", sewn.brep.face_count()),
            ("joined", sewn.joined),
            ("open", sewn.open.len()),
            ("solids", sewn.brep.solids().len()),
            ("turned", sewn.turned),
        ];
        let name = free_name(scene, p, &format!("{first} sewn"))?;
        let mut object = like(scene, first, &name, sewn.brep.into());
        if !alike {
            (object.parent, object.transform) = (None, None);
        }
        // Faces have the colours of what they come from.
        object.color = None;
        let mut changed = scene.clone();
        changed.add(object)?;
        if !(p.has("keep") && p.flag("keep")?) {
            for name in &names {
                changed.remove(name)?;
            }
        }
        *scene = changed;
        let mut report =
            StepReport { op: "sew".into(), object: Some(name), notes, warnings, ..StepReport::default() };
        report.numbers.extend(joined.map(|(word, count)| (word.into(), count.into())));
        report.numbers.insert("gap".into(), sewn.gap.into());
        report.numbers.insert("tolerance".into(), near.into());
        Ok(report)
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
