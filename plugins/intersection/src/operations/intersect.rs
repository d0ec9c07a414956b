//! `intersect`: where a curve meets a curve, a surface or itself.

use loftsman_kernel::Error;
use loftsman_kernel::mesh::Cloud;
use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, Parameters, StepReport, object_name,
};
use loftsman_kernel::scene::{Geometry, Scene};
use loftsman_kernel::shape::Location;
use loftsman_kernel::text::a;

use super::{NAME, add_beside, base_name, place, told, tolerance};
use crate::{Contact, Intersections, Options, curve_surface, curves, self_intersections};

/// The operation `intersect`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Intersect;

impl Operation for Intersect {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[
            Field::optional(
                "object",
                "text",
                "the only curve",
                "a curve, or a surface where the other is a curve",
            ),
            Field::optional(
                "with",
                "text",
                "itself",
                "the other: a curve or a surface, placed as the object is",
            ),
            Field::optional(
                "tolerance",
                "length",
                "1e-9 of the size",
                "two points no further apart than this count as one",
            ),
            NAME,
        ];
        Declaration {
            name: "intersect",
            help: "where a curve meets a curve, a surface or itself: the points become a cloud, what runs together a curve",
            fields: FIELDS,
        }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        parameters: &Parameters,
        _context: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        parameters.check(self.declaration().fields)?;
        let object = &object_name(scene, parameters, |g| matches!(g, Geometry::Curve(_)), "curve")?;
        let with = parameters.text_or("with", object)?;
        let name = base_name(parameters, object, "meetings")?;
        let options = Options { tolerance: tolerance(parameters)? };
        let found =
            |field: &str, name: &str| scene.object(name).map_err(|e| parameters.error(field, e.to_string()));
        let (first, second) = (found("object", object)?, found("with", with)?);
        if first.parent != second.parent || first.transform != second.transform {
            return Err(parameters
                .error("with", format!("\"{with}\" is placed otherwise than \"{object}\": give both the same parent and transform"))
                .into());
        }
        let (found, curve) = match (first.geometry(), second.geometry()) {
            (Geometry::Curve(a), _) if object == with => (self_intersections(a, &options)?, a),
            (Geometry::Curve(a), Geometry::Curve(b)) => (curves(a, b, &options)?, a),
            (Geometry::Curve(a), Geometry::Surface(b)) | (Geometry::Surface(b), Geometry::Curve(a)) => {
                (curve_surface(a, b, &options)?, a)
            }
            (Geometry::Curve(_) | Geometry::Surface(_), other) | (other, _) => {
                let name = if std::ptr::eq(other, second.geometry()) { with } else { object };
                let problem = format!(
                    "\"{name}\" is {}: a curve is intersected with a curve or a surface (a trimmed surface: untrim it first; \
                     a mesh or a surface by a plane: section)",
                    a(other.kind())
                );
                return Err(Error::Invalid(problem).into());
            }
        };
        let mut geometries: Vec<Geometry> = Vec::new();
        if !found.meetings.is_empty() {
            geometries.push(Cloud { points: found.meetings.iter().map(|m| m.point).collect() }.into());
        }
        for overlap in &found.overlaps {
            geometries.push(curve.between(overlap.range.0, overlap.range.1)?.into());
        }
        let who = if object == with { "it" } else { "they" };
        let notes = notes(&found, who);
        add_beside(scene, object, &name, geometries)?;
        Ok(StepReport {
            op: "intersect".into(),
            object: Some(object.to_owned()),
            residual: Some(found.distance()),
            notes,
            ..StepReport::default()
        })
    }
}

fn notes(found: &Intersections, who: &str) -> Vec<String> {
    let beside = |with: Option<Location>| match with {
        Some(Location::Curve(s)) => format!(" and {}", told(s)),
        Some(Location::Surface(u, v)) => format!(" and [{}, {}]", told(u), told(v)),
        _ => String::new(),
    };
    let mut notes = Vec::new();
    if found.meetings.is_empty() && found.overlaps.is_empty() {
        let how = if who == "it" { "it does not meet itself" } else { "they do not meet" };
        notes.push(format!("{how} within {}", told(found.tolerance)));
    }
    for m in &found.meetings {
        let how = match (m.contact, who) {
            (Contact::Crossing, "it") => "it crosses itself",
            (Contact::Touching, "it") => "it touches itself",
            (Contact::Crossing, _) => "they cross",
            (Contact::Touching, _) => "they touch",
        };
        notes.push(format!("{how} at {}, parameters {}{}", place(&m.point), told(m.at), beside(m.with)));
    }
    for o in &found.overlaps {
        let how = if who == "it" { "it runs together with itself" } else { "they run together" };
        notes.push(format!("{how} from {} to {} of the curve", told(o.range.0), told(o.range.1)));
    }
    for u in &found.undecided {
        notes.push(format!(
            "undecided: between {} and {} of the curve there may be more meetings; a larger tolerance tells",
            told(u.range.0),
            told(u.range.1)
        ));
    }
    notes
}
