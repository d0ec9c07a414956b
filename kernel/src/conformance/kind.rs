//! Whether a kind of shape is one: what it writes it reads, its shapes are linear in their vertices, its triangles are
//! near.

use std::sync::Arc;

use serde_json::Value;

use super::declaration::named;
use super::format::places;
use super::{Lcg, Verdict, guarded};
use crate::Point;
use crate::mesh::distance::{from_segment, from_triangle};
use crate::plugin::{Chord, CustomShape, Drawn, Faceted, Fineness, Parameters, ShapeKind, Splines};
use crate::shape::{Derivative, Location, Shape};

/// Places of each parameter that are looked at, and one more.
const PLACES: usize = 24;

/// Checks a kind of shape on samples of it: what it declares; that what it writes (through text, too) has the fields
/// that it declares, is read as the same shape to the last bit, and is written alike again; that fields which are
/// missing, unknown or of another kind are refused with their place, or make a finite shape; that the values of a
/// shape are sums of its control vertices whose coefficients add up to 1, and locations of another number of
/// parameters, or beyond the domain, are refused; that its segments or triangles, of one state or of several, are as
/// near as they say, by sampling; and that its exact splines, if it has some, are where it is.
pub fn kind_conformance(kind: &Arc<dyn ShapeKind>, samples: &[Box<dyn Shape>]) -> Verdict {
    guarded(|verdict| {
        let declaration = kind.declaration();
        named(&declaration, verdict);
        let name = declaration.name;
        let own = declaration.fields.iter().any(|field| field.name == "kind");
        verdict.check(!own, || {
            format!("{name}: the field \"kind\" is reserved, it says which kind a shape is of")
        });
        verdict.check(!samples.is_empty(), || format!("{name}: there is no sample to check it on"));
        for sample in samples {
            let custom = CustomShape::new(Arc::clone(kind), sample.clone());
            let custom = verdict.take(custom, |e| format!("{name}: a sample is none of its shapes: {e}"))?;
            written(verdict, kind, &custom)?;
            linear(verdict, name, sample.as_ref());
            near(verdict, &custom, sample.as_ref())?;
        }
        Some(())
    })
}

fn written(verdict: &mut Verdict, kind: &Arc<dyn ShapeKind>, custom: &CustomShape) -> Option<()> {
    let declaration = kind.declaration();
    let name = declaration.name;
    let fields = verdict.take(custom.fields(), |e| format!("{name} is not written: {e}"))?;
    verdict.take(fields.check(declaration.fields), |e| {
        format!("{name} writes other fields than it declares: {e}")
    })?;
    let text = Value::Object(fields.clone().into_map()).to_string();
    let parsed = serde_json::from_str::<Value>(&text).ok();
    verdict.check(parsed.as_ref() == Some(&Value::Object(fields.clone().into_map())), || {
        format!("{name} writes what is another as text: {text:.200}")
    });
    let parsed = Parameters::new(parsed.unwrap_or_default(), "shape").unwrap_or_else(|_| fields.clone());
    let again = verdict
        .take(CustomShape::read(kind, &parsed), |e| format!("{name} does not read what it writes: {e}"))?;
    verdict.check(again == *custom, || format!("{name}: what was read is written otherwise"));
    let (before, after) = (custom.shape().ok()?, again.shape().ok()?);
    verdict.check(before.domain() == after.domain(), || format!("{name}: what was read has another domain"));
    let bits = |shape: &dyn Shape| -> Vec<[u64; 3]> {
        shape.control_vertices().iter().map(|p| [p.x, p.y, p.z].map(f64::to_bits)).collect()
    };
    verdict
        .check(bits(before) == bits(after), || format!("{name}: what was read has other control vertices"));
    let differs = places(before, PLACES).into_iter().find(|&at| {
        let value = |shape: &dyn Shape| shape.value(at, Derivative::POSITION).ok();
        value(before) != value(after)
    });
    verdict.check(differs.is_none(), || {
        format!(
            "{name}: what was read is elsewhere at {}",
            differs.map_or(String::new(), |at| at.to_string())
        )
    });
    refused(verdict, kind, &parsed);
    Some(())
}

/// What is wrong with fields has its place, and nothing that is not finite comes through.
fn refused(verdict: &mut Verdict, kind: &Arc<dyn ShapeKind>, good: &Parameters) {
    let declaration = kind.declaration();
    let name = declaration.name;
    let mut look = |fields: Parameters, what: String| match CustomShape::read(kind, &fields) {
        Ok(_) => false,
        Err(error) => {
            let placed = error.path.starts_with("shape") && !error.problem.is_empty();
            verdict.check(placed, || format!("{name} refuses {what} without place or reason: {error}"));
            true
        }
    };
    let mut missed = Vec::new();
    if !look(good.clone().with("no such field", 1.0), "an unknown field".into()) {
        missed.push("takes a field that it does not declare".to_owned());
    }
    for field in declaration.fields {
        let own = field.name;
        if field.default.is_none() && !look(good.without(&[own]), format!("a missing \"{own}\"")) {
            missed.push(format!("does not miss the field \"{own}\""));
        }
        let list = good.value(own).and_then(Value::as_array).cloned().unwrap_or_default();
        let mut wrong: Vec<Value> = vec![
            Value::Null,
            true.into(),
            "nonsense".into(),
            (-1e300).into(),
            Value::Array(Vec::new()),
            serde_json::json!([[[]], {}, null]),
            serde_json::json!({ "a": 1 }),
        ];
        wrong.push(list[..list.len() / 2].into());
        wrong.push(list.iter().map(|_| Value::Null).collect());
        let mut any = false;
        for value in wrong {
            let what = format!("{value:.60} as \"{own}\"");
            any |= look(good.clone().with(own, value), what);
        }
        if !any {
            missed.push(format!("takes anything as \"{own}\""));
        }
    }
    for missed in missed {
        verdict.check(false, || format!("{name} {missed}"));
    }
}

/// Values are sums over the vertices, and go along with them.
fn linear(verdict: &mut Verdict, name: &str, shape: &dyn Shape) {
    let size = shape.control_vertices().iter().fold(f64::MIN_POSITIVE, |m, p| m.max(p.coords.amax()));
    for at in places(shape, 6) {
        let stencil = match shape.stencil(at, Derivative::POSITION) {
            Ok(stencil) => stencil,
            Err(error) => return verdict.check(false, || format!("{name} has no value at {at}: {error}")),
        };
        let sum: f64 = stencil.coefficients().iter().sum();
        verdict.check((sum - 1.0).abs() <= 1e-9, || {
            format!("{name}: the coefficients at {at} add up to {sum}, not 1: it does not go along with its vertices")
        });
        let inside = stencil.vertices().iter().all(|&v| v < shape.control_vertices().len());
        verdict.check(inside, || format!("{name}: the row at {at} names a vertex that is not there"));
        let value = shape.value(at, Derivative::POSITION);
        let apart = value.map(|v| (v - stencil.apply(shape.control_vertices())).amax());
        verdict.check(apart.as_ref().is_ok_and(|apart| *apart <= 1e-12 * size), || {
            format!("{name}: its value at {at} is not the sum of its vertices: {apart:?}")
        });
    }
    let domain = shape.domain();
    let beyond = |interval: usize| {
        let i = &domain[interval];
        i.end + (i.end - i.start)
    };
    let open = domain.iter().all(|interval| !interval.periodic);
    let wrong = match domain.len() {
        1 => [Some(Location::Surface(domain[0].start, 0.0)), open.then(|| Location::Curve(beyond(0)))],
        _ if shape.faces().is_some() => {
            [Some(Location::Curve(domain[0].start)), open.then(|| Location::Face(0, beyond(0), beyond(1)))]
        }
        _ => [Some(Location::Curve(domain[0].start)), open.then(|| Location::Surface(beyond(0), beyond(1)))],
    };
    for at in wrong.into_iter().flatten() {
        let refused = shape.stencil(at, Derivative::POSITION).is_err();
        verdict.check(refused, || format!("{name} has a value at {at}, which is no place of it"));
    }
}

/// Segments or triangles are as near as they say, in one state and in two; splines are where the shape is.
fn near(verdict: &mut Verdict, custom: &CustomShape, shape: &dyn Shape) -> Option<()> {
    let name = custom.kind().to_owned();
    let mut random = Lcg::new(3);
    let points = shape.control_vertices();
    let size = points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max);
    let moved: Vec<Point> = points.iter().map(|p| p.map(|c| c + 0.2 * size * random.next())).collect();
    let chord = 2e-3 * size;
    let fineness = Fineness { chord: Chord::Absolute(chord), ..Fineness::default() };
    let one = verdict.take(custom.tessellate(&fineness), |e| format!("{name} is not tessellated: {e}"))?;
    let frames = [points.to_vec(), moved];
    let two = custom.tessellate_frames(&frames, &fineness);
    let two = verdict.take(two, |e| format!("{name} is not tessellated in two states: {e}"))?;
    for (faceted, states) in [(&one, &frames[..1]), (&two, &frames[..])] {
        verdict.check(faceted.error <= chord, || {
            format!("{name} is tessellated {} away, {chord} was asked for", faceted.error)
        });
        for (state, points) in states.iter().enumerate() {
            let custom = verdict
                .take(custom.with_points(points), |e| format!("{name} does not take other vertices: {e}"))?;
            let shape = custom.shape().ok()?;
            let values =
                places(shape, PLACES).into_iter().filter_map(|at| shape.value(at, Derivative::POSITION).ok());
            let apart = values.map(|value| apart(&value.into(), faceted, state)).fold(0.0, f64::max);
            verdict.check(apart <= 1.5 * chord, || {
                format!("{name}: a place of it is {apart} away from its tessellation, {chord} was asked for")
            });
        }
    }
    for wrong in [0.0, -1.0, f64::NAN] {
        let refused = custom.tessellate(&Fineness { chord: Chord::Absolute(wrong), ..fineness }).is_err();
        verdict.check(refused, || format!("{name} is tessellated within {wrong}"));
    }
    let Some(splines) = custom.splines() else { return Some(()) };
    let splines: Vec<&dyn Shape> = match &splines {
        Splines::Curves(curves) => curves.iter().map(|c| c as &dyn Shape).collect(),
        Splines::Surfaces(surfaces) => surfaces.iter().map(|s| s as &dyn Shape).collect(),
    };
    exact(verdict, &name, &splines, &one, shape);
    Some(())
}

/// The splines lie on the tessellation and reach as far as the shape.
fn exact(verdict: &mut Verdict, name: &str, splines: &[&dyn Shape], faceted: &Faceted, shape: &dyn Shape) {
    let values = |shape: &dyn Shape| -> Vec<Point> {
        let all = places(shape, PLACES).into_iter();
        all.filter_map(|at| Some(Point::from(shape.value(at, Derivative::POSITION).ok()?))).collect()
    };
    let found: Vec<Point> = splines.iter().flat_map(|spline| values(*spline)).collect();
    let away = found.iter().map(|p| apart(p, faceted, 0)).fold(0.0, f64::max);
    let most = 1.5 * faceted.tolerance;
    verdict.check(!found.is_empty() && away <= most, || {
        format!("{name}: its exact splines are {away} away from its tessellation")
    });
    let bounds = |points: &[Point]| {
        let start = (Point::from([f64::INFINITY; 3]), Point::from([f64::NEG_INFINITY; 3]));
        points.iter().fold(start, |(low, high), p| (low.inf(p), high.sup(p)))
    };
    let (own, theirs) = (bounds(&values(shape)), bounds(&found));
    // The same box, to what lies between the places that are looked at.
    let between = 0.1 * (own.1 - own.0).norm();
    let off = (own.0 - theirs.0).amax().max((own.1 - theirs.1).amax());
    verdict.check(off <= between, || {
        format!("{name}: its exact splines reach {off} further than it, or less far")
    });
}

/// The distance of a point from segments or triangles in a state.
fn apart(p: &Point, faceted: &Faceted, state: usize) -> f64 {
    let points = &faceted.states[state];
    match &faceted.drawn {
        Drawn::Line(line) => {
            let back = line.closed.then(|| [points[points.len() - 1], points[0]]);
            let pairs = points.windows(2).map(|pair| [pair[0], pair[1]]).chain(back);
            pairs.map(|[a, b]| from_segment(p, &a, &b)).fold(f64::INFINITY, f64::min)
        }
        Drawn::Mesh(mesh) => {
            let fans =
                mesh.faces().flat_map(|face| (1..face.len() - 1).map(|k| [face[0], face[k], face[k + 1]]));
            let triangles = fans.map(|triangle| triangle.map(|k| points[k as usize]));
            triangles.map(|triangle| from_triangle(p, &triangle)).fold(f64::INFINITY, f64::min)
        }
    }
}
