//! `intersect`: where a curve or polyline meets another, a surface or itself.

use loftsman_kernel::Error;
use loftsman_kernel::Point;
use loftsman_kernel::mesh::Cloud;
use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, Parameters, StepReport, object_name,
};
use loftsman_kernel::scene::{Geometry, Scene, Unit};
use loftsman_kernel::shape::Location;
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::text::{a, without_rounding};
use serde_json::{Map, Value, json};

use super::{Beside, NAME, add_beside, as_curve, base_name, place, told, tolerance};
use crate::{
    Contact, Intersections, Meeting, Options, curve_surface, curves, gap_of_curve_and_surface, gap_of_curves,
    self_intersections,
};

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
            Field::optional("with", "text", "itself", "the other: a curve, a polyline or a surface"),
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
        if parameters.value("with").is_some_and(|with| with.is_object()) {
            let problem = "the name of an object is needed; what a plane cuts is found by the operation section (at, normal)";
            return Err(parameters.error("with", problem).into());
        }
        let with = parameters.text_or("with", object)?;
        let name = base_name(parameters, object, "meetings")?;
        let options = Options { tolerance: tolerance(parameters)? };
        let found =
            |field: &str, name: &str| scene.object(name).map_err(|e| parameters.error(field, e.to_string()));
        let (first, second) = (found("object", object)?, found("with", with)?);
        let fits =
            |g: &Geometry| matches!(g, Geometry::Curve(_) | Geometry::Polyline(_) | Geometry::Surface(_));
        for (name, geometry) in [(object.as_str(), first.geometry()), (with, second.geometry())] {
            if !fits(geometry) {
                return Err(cannot(name, geometry));
            }
        }
        let brought = scene.in_frame_of(with, object)?;
        let other = brought.as_ref().unwrap_or(second.geometry());
        let of =
            |name: &str, geometry| as_curve(geometry).map_err(|e| Error::Invalid(format!("\"{name}\": {e}")));
        let pair = [of(object, first.geometry())?, of(with, other)?];
        let (found, curve) = match (&pair[0], &pair[1], first.geometry(), other) {
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
        // What runs along another that turns back does so more than once, and is made once.
        let mut parts: Vec<(f64, f64)> = Vec::new();
        let mut ranges: Vec<(f64, f64)> = found.overlaps.iter().map(|o| o.range).collect();
        ranges.sort_by(|x, y| x.0.total_cmp(&y.0));
        for (from, to) in ranges {
            match parts.last_mut() {
                Some(last) if from <= last.1 => last.1 = last.1.max(to),
                _ => parts.push((from, to)),
            }
        }
        for (from, to) in parts {
            geometries.push(curve.between(from, to)?.into());
        }
        let who = if object == with { "it" } else { "they" };
        let ends = Ends::of(&pair, object == with)?;
        let sizes = Sizes::of([first.geometry(), other]);
        let mut notes = notes(&found, who, &ends, &sizes, scene.unit);
        if brought.is_some() {
            notes.push(format!(
                "\"{with}\" is placed otherwise than \"{object}\": places and lengths are told in the coordinates of \"{object}\""
            ));
        }
        if brought.is_none() && scene.standing(object)?.to_world().is_some() {
            notes.push(format!(
                "\"{object}\" is placed by a transform: places, lengths and the tolerance are in its own coordinates"
            ));
        }
        let mut numbers = numbers(&found, &ends);
        // How near they come is asked of two that were shown to be apart.
        let apart = found.meetings.is_empty() && found.overlaps.is_empty() && found.is_complete();
        let gap = match (&pair[0], &pair[1], first.geometry(), other) {
            _ if !apart || object == with => None,
            (Some(a), Some(b), ..) => gap_of_curves(a, b)?,
            (Some(a), None, _, Geometry::Surface(b)) | (None, Some(a), Geometry::Surface(b), _) => {
                gap_of_curve_and_surface(a, b)?
            }
            _ => None,
        };
        if let Some(gap) = gap {
            let what = if gap.least { "the nearest places" } else { "the nearest places that were found" };
            let (far, at) = (scene.unit.quantity(gap.distance, 1), place(&gap.point));
            notes.push(format!("{what} are {far} apart, at {at}"));
            numbers.insert("gap".into(), gap.distance.into());
        }
        let beside = |geometry| Beside { name: name.clone(), geometry, layer: None };
        add_beside(scene, object, geometries.into_iter().map(beside).collect())?;
        Ok(StepReport {
            op: "intersect".into(),
            object: Some(object.to_owned()),
            numbers,
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
        a(&geometry.noun())
    ))
    .into()
}

/// All that was found, unrounded.
fn numbers(found: &Intersections, ends: &Ends) -> Map<String, Value> {
    let with = |with: Option<Location>| match with {
        Some(Location::Curve(s)) => json!(s),
        Some(Location::Surface(u, v)) => json!([u, v]),
        _ => Value::Null,
    };
    let point = |p: &Point| json!([p.x + 0.0, p.y + 0.0, p.z + 0.0]);
    let kind = |m: &Meeting| match ends.how(m) {
        How::Ends => "ends",
        How::End => "end",
        How::Crosses => "cross",
        How::Touches => "touch",
    };
    let meetings = found.meetings.iter().map(|m| {
        json!({
            "kind": kind(m),
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
    numbers.insert("distance".into(), found.distance().into());
    numbers.insert("tolerance".into(), found.tolerance.into());
    numbers
}

/// How shapes meet at a place.
#[derive(Clone, Copy, PartialEq)]
enum How {
    /// End on end.
    Ends,
    /// One ends there, on the other.
    End,
    Crosses,
    Touches,
}

/// Where the curves of a pair end: not where they are closed.
struct Ends([Option<(f64, f64)>; 2]);

impl Ends {
    fn of(pair: &[Option<Curve>; 2], itself: bool) -> Result<Self, Error> {
        let of = |curve: &Option<Curve>| -> Result<Option<(f64, f64)>, Error> {
            let Some(curve) = curve else { return Ok(None) };
            let (a, b) = curve.domain();
            let closed = curve.is_periodic()
                || (curve.point(a)? - curve.point(b)?).norm() <= CLOSED * size(curve.points());
            Ok((!closed).then_some((a, b)))
        };
        let first = of(&pair[0])?;
        let second = if itself { first } else { of(&pair[1])? };
        // A surface beside a curve has no ends of this kind, whichever of both comes first.
        Ok(Self(if pair[0].is_none() { [second, None] } else { [first, second] }))
    }

    /// What ends there passes through nothing, whatever the angle.
    fn how(&self, meeting: &Meeting) -> How {
        let at = |ends: Option<(f64, f64)>, at: f64| {
            ends.is_some_and(|(a, b)| (at - a).abs().min((at - b).abs()) <= CLOSED * (b - a))
        };
        let other = matches!(meeting.with, Some(Location::Curve(s)) if at(self.0[1], s));
        match (at(self.0[0], meeting.at), other, meeting.contact) {
            (true, true, _) => How::Ends,
            (false, false, Contact::Crossing) => How::Crosses,
            (false, false, Contact::Touching) => How::Touches,
            _ => How::End,
        }
    }
}

/// Ends no further apart than this part of the size, or of the domain, are one.
const CLOSED: f64 = 1e-9;

fn size(points: &[Point]) -> f64 {
    let first = points.first().copied().unwrap_or_default();
    points.iter().map(|p| (p - first).amax()).fold(0.0, f64::max)
}

/// What lengths and parameters are rounded at.
struct Sizes {
    /// The largest coordinate.
    length: f64,
    /// The largest knot of each direction.
    at: f64,
    with: [f64; 2],
}

impl Sizes {
    fn of(pair: [&Geometry; 2]) -> Self {
        let largest = |space: &Space| {
            let (a, b) = space.domain();
            a.abs().max(b.abs())
        };
        let of = |geometry: &Geometry| match geometry {
            Geometry::Curve(curve) => [largest(curve.space()), 0.0],
            Geometry::Surface(surface) => [largest(surface.u()), largest(surface.v())],
            other => [other.points().len() as f64, 0.0],
        };
        let points = pair.iter().flat_map(|geometry| geometry.points().iter().map(|p| p.coords.amax()));
        let (curve, other) =
            if matches!(pair[0], Geometry::Surface(_)) { (pair[1], pair[0]) } else { (pair[0], pair[1]) };
        Self { length: points.fold(0.0, f64::max), at: of(curve)[0], with: of(other) }
    }
}

fn notes(found: &Intersections, who: &str, ends: &Ends, sizes: &Sizes, unit: Unit) -> Vec<String> {
    let at = |at: f64| told(without_rounding(at, sizes.at));
    let on = |with: Location| match with {
        Location::Curve(s) => Some(told(without_rounding(s, sizes.with[0]))),
        Location::Surface(u, v) => {
            let [u, v] =
                [(u, sizes.with[0]), (v, sizes.with[1])].map(|(x, size)| told(without_rounding(x, size)));
            Some(format!("[{u}, {v}]"))
        }
        _ => None,
    };
    let beside =
        |with: Option<Location>| with.and_then(on).map_or(String::new(), |with| format!(" and {with}"));
    let mut notes = Vec::new();
    if found.meetings.is_empty() && found.overlaps.is_empty() {
        let how = if who == "it" { "it does not meet itself" } else { "they do not meet" };
        notes.push(format!("{how} within {}", unit.quantity(found.tolerance, 1)));
    }
    for m in &found.meetings {
        let how = match (ends.how(m), who) {
            (How::Ends, "it") => "its ends meet",
            (How::End, "it") => "it ends on itself",
            (How::Crosses, "it") => "it crosses itself",
            (How::Touches, "it") => "it touches itself",
            (How::Ends, _) => "they meet end on end",
            (How::End, _) => "one ends on the other",
            (How::Crosses, _) => "they cross",
            (How::Touches, _) => "they touch",
        };
        notes.push(format!("{how} at {}, parameters {}{}", place(&m.point), at(m.at), beside(m.with)));
    }
    for o in &found.overlaps {
        let how = if who == "it" { "it runs together with itself" } else { "they run together" };
        let there = o.with.and_then(|[from, to]| {
            Some(format!(
                " and {} to {} of {}",
                on(from)?,
                on(to)?,
                if who == "it" { "itself" } else { "the other" }
            ))
        });
        notes.push(format!(
            "{how} from {} to {} of the curve{}",
            at(o.range.0),
            at(o.range.1),
            there.unwrap_or_default()
        ));
    }
    for u in &found.undecided {
        notes.push(format!(
            "undecided: between {} and {} of the curve there may be more meetings; a larger tolerance tells",
            at(u.range.0),
            at(u.range.1)
        ));
    }
    // What is only rounding is not told.
    let apart = without_rounding(found.distance(), sizes.length);
    if apart > 0.0 {
        let meet = if who == "it" { "meets itself" } else { "meet" };
        notes.push(format!("largest distance where {who} {meet}: {}", unit.quantity(apart, 1)));
    }
    notes
}
