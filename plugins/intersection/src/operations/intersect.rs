//! `intersect`: where a curve or polyline meets another, a surface or itself.

use loftsman_kernel::Error;
use loftsman_kernel::Point;
use loftsman_kernel::mesh::Cloud;
use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, Parameters, StepReport, object_name,
};
use loftsman_kernel::scene::{Geometry, Scene};
use loftsman_kernel::shape::Location;
use loftsman_kernel::text::a;
use serde_json::{Map, Value, json};

use super::{NAME, add_beside, as_curve, base_name, place, told, tolerance};
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
                "the only curve or polyline",
                "a curve or polyline, or a surface where the other is one of these",
            ),
            Field::optional(
                "with",
                "text",
                "itself",
                "the other: a curve, a polyline or a surface, placed as the object is",
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
            help: "where a curve or polyline meets another, a surface or itself: the points become a cloud, what runs together a curve",
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
        let object = &object_name(
            scene,
            parameters,
            |g| matches!(g, Geometry::Curve(_) | Geometry::Polyline(_)),
            "curve or polyline",
        )?;
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
        let fits =
            |g: &Geometry| matches!(g, Geometry::Curve(_) | Geometry::Polyline(_) | Geometry::Surface(_));
        for (name, geometry) in [(object.as_str(), first.geometry()), (with, second.geometry())] {
            if !fits(geometry) {
                return Err(cannot(name, geometry));
            }
        }
        let of =
            |name: &str, geometry| as_curve(geometry).map_err(|e| Error::Invalid(format!("\"{name}\": {e}")));
        let pair = [of(object, first.geometry())?, of(with, second.geometry())?];
        let (found, curve) = match (&pair[0], &pair[1], first.geometry(), second.geometry()) {
            (Some(a), ..) if object == with => (self_intersections(a, &options)?, a),
            (Some(a), Some(b), ..) => (curves(a, b, &options)?, a),
            (Some(a), None, _, Geometry::Surface(b)) | (None, Some(a), Geometry::Surface(b), _) => {
                (curve_surface(a, b, &options)?, a)
            }
            (.., other) => return Err(cannot(with, other)),
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
            numbers: numbers(&found),
            notes,
            ..StepReport::default()
        })
    }
}

/// What is refused, and what does it.
fn cannot(name: &str, geometry: &Geometry) -> OperationError {
    Error::Invalid(format!(
        "\"{name}\" is {}: a curve or polyline is intersected with another, or with a surface (a trimmed surface: untrim it first; \
         a mesh or a surface by a plane: section)",
        a(geometry.kind())
    ))
    .into()
}

/// All that was found, unrounded.
fn numbers(found: &Intersections) -> Map<String, Value> {
    let with = |with: Option<Location>| match with {
        Some(Location::Curve(s)) => json!(s),
        Some(Location::Surface(u, v)) => json!([u, v]),
        _ => Value::Null,
    };
    let point = |p: &Point| json!([p.x + 0.0, p.y + 0.0, p.z + 0.0]);
    let kind = |contact| if contact == Contact::Crossing { "cross" } else { "touch" };
    let meetings = found.meetings.iter().map(|m| {
        json!({
            "kind": kind(m.contact),
            "point": point(&m.point),
            "at": m.at,
            "with": with(m.with),
            "distance": m.distance,
        })
    });
    let overlaps = found.overlaps.iter().map(|o| {
        json!({
            "from": o.range.0,
            "to": o.range.1,
            "with": o.with.map(|ends| ends.map(|end| with(Some(end)))),
            "points": o.points.map(|p| point(&p)),
            "distance": o.distance,
        })
    });
    let undecided =
        found.undecided.iter().map(|u| json!({ "from": u.range.0, "to": u.range.1, "near": point(&u.near) }));
    let mut numbers = Map::new();
    numbers.insert("meetings".into(), meetings.collect());
    numbers.insert("overlaps".into(), overlaps.collect());
    numbers.insert("undecided".into(), undecided.collect());
    numbers.insert("tolerance".into(), found.tolerance.into());
    numbers
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
