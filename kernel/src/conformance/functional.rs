//! Whether a functional is one: its rows against finite differences, against its value and against what it says of itself.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::{Lcg, Verdict, guarded};
use crate::error::{Error, Result};
use crate::functional::{
    Equation, Functional, Linearity, Shapes, Store, equations_of, linearize_of, rows_of, value_of,
};
use crate::shape::{Derivative, Location, Shape};
use crate::spline::{Curve, Space, Surface};
use crate::{Point, Vector};

/// Shapes to ask a functional of: a clamped cubic, a floating quintic, a periodic and a rational curve, with knots of
/// all sorts; and, for functionals of surfaces, a bicubic patch, one that is periodic, a rational one.
pub fn sample_shapes(surfaces: bool) -> Vec<Box<dyn Shape>> {
    let mut random = Lcg::new(7);
    let mut points = |n: usize| -> Vec<Point> {
        (0..n)
            .map(|i| {
                let t = i as f64 / n as f64 * std::f64::consts::TAU;
                Point::new(3.0 * t.cos(), 2.0 * t.sin(), 0.3 * (2.0 * t).sin())
                    + Vector::new(random.next(), random.next(), random.next()) * 0.2
            })
            .collect()
    };
    let spaces = [
        Space::clamped(3, &[0.0, 0.4, 1.0, 1.5, 1.7, 2.0]),
        Space::open(5, (0..16).map(|i| 0.4 * f64::from(i) - 2.0 + 0.03 * f64::from(i % 3)).collect()),
        Space::periodic(3, vec![0.0, 0.3, 0.5, 0.9, 1.2, 1.5, 1.6, 1.9, 2.0]),
        Space::clamped(2, &[0.0, 0.7, 1.4, 2.0]),
    ];
    let mut shapes: Vec<Box<dyn Shape>> = Vec::new();
    for (k, space) in spaces.into_iter().flatten().enumerate() {
        let n = space.len();
        let weights = (k == 3).then(|| (0..n).map(|i| 1.0 + 0.3 * (i % 3) as f64).collect::<Vec<_>>());
        if !surfaces {
            if let Ok(curve) = Curve::build(space, points(n), weights) {
                shapes.push(Box::new(curve));
            }
            continue;
        }
        let Ok(v) = Space::clamped(2, &[0.0, 1.0, 2.0]) else { continue };
        let net: Vec<Point> = (0..v.len())
            .flat_map(|j| points(n).into_iter().map(move |p| p + Vector::z() * j as f64))
            .collect();
        // Rows along u: v is the fast index.
        let net: Vec<Point> = (0..n * v.len()).map(|k| net[(k % v.len()) * n + k / v.len()]).collect();
        let weights = weights.map(|_| (0..net.len()).map(|i| 1.0 + 0.2 * (i % 4) as f64).collect());
        if let Ok(surface) = Surface::build(space, v, net, weights) {
            shapes.push(Box::new(surface));
        }
    }
    shapes
}

/// Checks a functional on shapes (as many as it looks at):
///
/// * it says the same when it is asked twice, appends as many equations as it says, about control vertices that there are,
///   writes as many values, all finite, and gives values and rows together as it does apart;
/// * what it says of itself is so: a linear one has the same rows wherever the shapes are, and its value is these rows times
///   vertices plus constants; a multilinear one is linear in each axis while the others are held, whatever the axis; a vector
///   has an equation for each axis; its location is on one of the shapes;
/// * its value changes as its rows say, by central differences in random directions, where the shapes are and elsewhere;
/// * the value that it has can be asked of it.
///
/// Whatever is wrong with it is told in words; a panic in it counts as a failure (where panics unwind).
pub fn functional_conformance(functional: &dyn Functional, shapes: &[Box<dyn Shape>]) -> Verdict {
    guarded(|verdict| suite(functional, shapes, verdict))
}

/// What a functional gives at one state of the shapes.
struct State {
    store: Store,
    value: Vec<f64>,
}

fn suite(functional: &dyn Functional, shapes: &[Box<dyn Shape>], verdict: &mut Verdict) -> Option<()> {
    let name = functional.describe();
    verdict.check(!name.is_empty(), || "it does not describe itself".into());
    verdict.check(functional.describe() == name, || format!("{name}: two names"));
    let bound: Option<Arc<dyn Functional>> =
        verdict.take(functional.bind(&view(shapes)), |e| format!("{name} cannot be bound: {e}"))?;
    let functional = bound.as_deref().unwrap_or(functional);
    let count = verdict.take(equations_of(functional), |e| format!("{name}: {e}"))?;
    verdict.check(count > 0, || format!("{name} has no equations"));
    if count == 0 {
        return None;
    }
    verdict.check(functional.equations() == count, || format!("{name}: two numbers of equations"));
    let here = verdict.take(state(functional, shapes, count), |e| format!("{name} cannot be asked: {e}"))?;
    let again =
        verdict.take(state(functional, shapes, count), |e| format!("{name} cannot be asked twice: {e}"))?;
    verdict.check(again.value == here.value, || format!("{name}: two values"));
    let same = again.store.equations().eq(here.store.equations());
    verdict.check(same, || format!("{name}: the rows differ when asked twice"));
    claims(functional, shapes, &here.value, verdict, &name);
    together(functional, shapes, &here, verdict, &name);

    let total = view(shapes).vertex_count();
    let size = (0..total).map(|v| view(shapes).vertex(v).coords.amax()).fold(0.0, f64::max);
    let mut random = Lcg::new(3);
    let mut direction = || -> Vec<Vector> {
        (0..total).map(|_| Vector::new(random.next(), random.next(), random.next())).collect()
    };
    match functional.linearity() {
        Linearity::Linear => {
            agrees_with_rows(shapes, &here, verdict, &name);
            for step in [0.03, 1.0, 10.0] {
                let elsewhere = moved(shapes, &direction(), step * size);
                let there = verdict.take(state(functional, &elsewhere, count), |e| {
                    format!("{name} is linear, but elsewhere: {e}")
                })?;
                let change = difference(&here.store, &there.store);
                verdict.check(change <= 1e-11, || {
                    format!("{name} says that it is linear, but its rows change by {change:.1e} of themselves with the shapes")
                });
                agrees_with_rows(&elsewhere, &there, verdict, &name);
            }
        }
        Linearity::Multilinear => {
            for axis in 0..3 {
                let along: Vec<Vector> = direction().iter().map(|d| Vector::ith(axis, d[axis])).collect();
                in_one_axis(functional, shapes, &here, &along, size, axis, verdict, &name)?;
            }
        }
        Linearity::Nonlinear => {}
    }
    for _ in 0..8 {
        differences(functional, shapes, &here, &direction(), size, verdict, &name);
    }
    // Rows may be right where the shapes are and nowhere else.
    let elsewhere = moved(shapes, &direction(), 0.02 * size);
    if let Ok(there) = state(functional, &elsewhere, count) {
        for _ in 0..3 {
            differences(functional, &elsewhere, &there, &direction(), size, verdict, &name);
        }
    }
    Some(())
}

/// What it says of itself, but for its linearity.
fn claims(
    functional: &dyn Functional,
    shapes: &[Box<dyn Shape>],
    value: &[f64],
    verdict: &mut Verdict,
    name: &str,
) {
    let three = !functional.is_vector() || value.len() == 3;
    verdict.check(three, || {
        format!("{name} says that it is a vector, but has {} equations, not one for each axis", value.len())
    });
    let target = if functional.is_condition() { vec![0.0; value.len()] } else { value.to_vec() };
    let asked = functional.check_target(value, &target);
    verdict.check(asked.is_ok(), || format!("{name} refuses the value that it has: {asked:?}"));
    if let Some(all) = functional.complete(&value[..1]) {
        verdict.check(all.len() == value.len() || value.len() == 1, || {
            format!("{name} completes one number to {} where it has {} equations", all.len(), value.len())
        });
    }
    if let Some((shape, at)) = functional.location() {
        let there = view(shapes).stencil(shape, at, Derivative::POSITION);
        verdict.check(there.is_ok(), || {
            format!("{name} is at {at} of shape {shape}, where nothing is: {there:?}")
        });
    }
    if let Some(at) = functional.location().map(|(_, at)| at).filter(|at| functional.moved(*at).is_some()) {
        moves(functional, shapes, value, at, verdict, name);
    }
    for companion in functional.companions() {
        let own = companion.describe();
        verdict.check(!own.is_empty() && own != name, || {
            format!("{name} is its own companion, or that has no name")
        });
        let asked = match companion.bind(&view(shapes)) {
            Ok(bound) => {
                let companion = bound.as_deref().unwrap_or(companion.as_ref());
                equations_of(companion).and_then(|count| state(companion, shapes, count).map(|_| ()))
            }
            Err(error) => Err(error),
        };
        verdict.check(asked.is_ok(), || {
            format!("{name} has a companion that cannot be asked, {own}: {asked:?}")
        });
    }
}

/// Moved to where it is, it has the value that it has, and comes to rest; its value changes along its location as it says, by
/// differences.
fn moves(
    functional: &dyn Functional,
    shapes: &[Box<dyn Shape>],
    value: &[f64],
    at: Location,
    verdict: &mut Verdict,
    name: &str,
) {
    let value_at = |to: Location| -> Option<Vec<f64>> {
        let moved = functional.moved(to)?;
        let mut out = vec![0.0; value.len()];
        let asked = value_of(moved.as_ref(), &view(shapes), &mut out);
        (asked.is_ok() && !moved.floats()).then_some(out)
    };
    verdict.check(value_at(at).as_deref() == Some(value), || {
        format!("{name} has another value, or still floats, when it is moved to where it is")
    });
    let (Some((shape, _)), mut along) = (functional.location(), vec![0.0; value.len()]) else { return };
    let Ok(domain) = view(shapes).get(shape).map(|shape| shape.domain()) else { return };
    for (k, interval) in domain.iter().enumerate().take(at.parameters()) {
        let order = Derivative { u: usize::from(k == 0), v: usize::from(k == 1) };
        let step = 1e-6 * (interval.end - interval.start);
        if !(step > 0.0 && step.is_finite()) {
            continue;
        }
        let by = |step: f64| match at {
            Location::Curve(u) => Location::Curve(u + step),
            Location::Surface(u, v) if k == 0 => Location::Surface(u + step, v),
            Location::Surface(u, v) => Location::Surface(u, v + step),
            Location::Face(face, u, v) if k == 0 => Location::Face(face, u + step, v),
            Location::Face(face, u, v) => Location::Face(face, u, v + step),
            Location::Vertex(vertex) => Location::Vertex(vertex),
        };
        let (Some(below), Some(above)) = (value_at(by(-step)), value_at(by(step))) else { continue };
        let told = functional.along(&view(shapes), order, &mut along);
        rows_along(functional, shapes, order, &along, verdict, name);
        verdict.check(told.is_ok(), || format!("{name} moves, but does not say how it changes: {told:?}"));
        let size = along.iter().chain(value).fold(0.0_f64, |m, v| m.max(v.abs()));
        // From one side or the other: a knot may be there.
        for (((a, b), told), here) in above.iter().zip(&below).zip(&along).zip(value) {
            let sides = [(a - here) / step, (here - b) / step];
            let near = sides.iter().any(|found| (found - told).abs() <= 1e-4 * (size + found.abs()));
            verdict
                .check(near, || format!("{name} changes by {} along its location and says {told}", sides[0]));
        }
    }
}

/// The rows along its location say of the control vertices as they are what it says, and of a linear one they are how its rows change: of control vertices
/// elsewhere they say what it says there.
fn rows_along(
    functional: &dyn Functional,
    shapes: &[Box<dyn Shape>],
    order: Derivative,
    along: &[f64],
    verdict: &mut Verdict,
    name: &str,
) {
    let Some(moved_here) = functional.location().and_then(|(_, at)| functional.moved(at)) else { return };
    if moved_here.linearity() != Linearity::Linear {
        return;
    }
    let mut store = Store::default();
    let told = functional.along_rows(&view(shapes), order, &mut store.rows(&view(shapes)));
    verdict.check(told.is_ok(), || format!("{name} moves, but does not say how its rows change: {told:?}"));
    if told.is_err() {
        return;
    }
    let blocks = store.equations_from(0);
    verdict.check(blocks == along.len(), || {
        format!("{name} has {} equations, and {blocks} rows of changes along its location", along.len())
    });
    if blocks != along.len() {
        return;
    }
    let mut random = Lcg::new(5);
    let total = view(shapes).vertex_count();
    let way: Vec<Vector> =
        (0..total).map(|_| Vector::new(random.next(), random.next(), random.next())).collect();
    for step in [0.0, 1.0] {
        let there = moved(shapes, &way, step);
        let (mut by_rows, mut told) = (vec![0.0; along.len()], vec![0.0; along.len()]);
        store.evaluate(&view(&there), &mut by_rows);
        if functional.along(&view(&there), order, &mut told).is_err() {
            continue;
        }
        let sizes = magnitudes(&store, &view(&there));
        for ((by_rows, told), size) in by_rows.iter().zip(&told).zip(sizes) {
            verdict.check((by_rows - told).abs() <= 1e-11 * size.max(told.abs()), || {
                format!("{name} changes by {told} along its location, by its rows of that by {by_rows}")
            });
        }
    }
}

/// Value and rows at once are what they are apart.
fn together(
    functional: &dyn Functional,
    shapes: &[Box<dyn Shape>],
    here: &State,
    verdict: &mut Verdict,
    name: &str,
) {
    let (mut store, mut value) = (Store::default(), vec![0.0; here.value.len()]);
    let shapes = view(shapes);
    match linearize_of(functional, &shapes, &mut store.rows(&shapes), &mut value) {
        Err(error) => verdict.check(false, || format!("{name} cannot be linearized: {error}")),
        Ok(()) => {
            let scale = here.value.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
            let near = value.iter().zip(&here.value).all(|(a, b)| (a - b).abs() <= 1e-10 * scale);
            verdict.check(near, || format!("{name}: {value:?} with its rows, {:?} alone", here.value));
            let change = difference(&here.store, &store);
            verdict.check(change <= 1e-10, || format!("{name}: its rows with the value are not those alone"));
        }
    }
}

/// A linear functional's value is its rows times vertices plus constants.
fn agrees_with_rows(shapes: &[Box<dyn Shape>], here: &State, verdict: &mut Verdict, name: &str) {
    let mut product = vec![0.0; here.value.len()];
    let shapes = view(shapes);
    here.store.evaluate(&shapes, &mut product);
    let sizes = magnitudes(&here.store, &shapes);
    for (k, size) in sizes.iter().enumerate() {
        verdict.check((product[k] - here.value[k]).abs() <= 1e-12 * size.max(here.value[k].abs()), || {
            format!("{name}, equation {k}: its value is {:e}, its rows give {:e}", here.value[k], product[k])
        });
    }
}

/// Along one axis a multilinear functional is linear, however far.
#[allow(clippy::too_many_arguments, reason = "a step of the suite, with all that it looks at")]
fn in_one_axis(
    functional: &dyn Functional,
    shapes: &[Box<dyn Shape>],
    here: &State,
    along: &[Vector],
    size: f64,
    axis: usize,
    verdict: &mut Verdict,
    name: &str,
) -> Option<()> {
    let letter = ["x", "y", "z"][axis];
    for step in [size, -3.0 * size] {
        let elsewhere = moved(shapes, along, step);
        let there = verdict.take(state(functional, &elsewhere, here.value.len()), |e| {
            format!("{name} is multilinear, but elsewhere: {e}")
        })?;
        let (before, after) = (slopes(&here.store, along), slopes(&there.store, along));
        for (k, (before, after)) in before.iter().zip(&after).enumerate() {
            let scale = before.abs().max(here.value[k].abs() / size).max(there.value[k].abs() / size);
            verdict.check((before - after).abs() <= 1e-9 * scale, || {
                format!(
                    "{name} says that it is multilinear, but its derivative along {letter} changes along {letter}, from \
                     {before:e} to {after:e}"
                )
            });
            let change = there.value[k] - here.value[k] - step * before;
            verdict.check(change.abs() <= 1e-9 * scale * step.abs(), || {
                format!(
                    "{name} says that it is multilinear, but along {letter} its value is off by {change:e}"
                )
            });
        }
    }
    Some(())
}

/// The value changes as the rows say.
fn differences(
    functional: &dyn Functional,
    shapes: &[Box<dyn Shape>],
    here: &State,
    direction: &[Vector],
    size: f64,
    verdict: &mut Verdict,
    name: &str,
) {
    let (slopes, value) = (slopes(&here.store, direction), &here.value);
    // Central differences are exact for linear functionals; for others h² and ε/h balance at ε^(1/3).
    let linear = functional.linearity() == Linearity::Linear;
    let step = if linear { size } else { 6e-6 * size };
    let at = |step: f64| value_at(functional, &moved(shapes, direction, step), value.len());
    let (up, down) = match (at(step), at(-step)) {
        (Ok(up), Ok(down)) => (up, down),
        (Err(error), _) | (_, Err(error)) => {
            return verdict
                .check(false, || format!("{name} has no value beside the shapes as they are: {error}"));
        }
    };
    for k in 0..value.len() {
        let difference = (up[k] - down[k]) / (2.0 * step);
        let scale = slopes[k].abs().max(value[k].abs() / size).max(up[k].abs() / size).max(1e-3);
        let tolerance = if linear { 1e-12 } else { 1e-7 } * scale.max(up[k].abs() / step * 1e-3);
        verdict.check((difference - slopes[k]).abs() <= tolerance, || {
            format!("{name}, equation {k}: rows say {:e}, differences {difference:e}", slopes[k])
        });
    }
}

fn view(shapes: &[Box<dyn Shape>]) -> Shapes<'_> {
    Shapes::new(shapes.iter().map(AsRef::as_ref))
}

fn state(functional: &dyn Functional, shapes: &[Box<dyn Shape>], count: usize) -> Result<State> {
    let mut store = Store::default();
    rows_of(functional, &view(shapes), &mut store.rows(&view(shapes)))?;
    Ok(State { store, value: value_at(functional, shapes, count)? })
}

fn value_at(functional: &dyn Functional, shapes: &[Box<dyn Shape>], count: usize) -> Result<Vec<f64>> {
    let mut out = vec![0.0; count];
    value_of(functional, &view(shapes), &mut out)?;
    match out.iter().find(|v| !v.is_finite()) {
        None => Ok(out),
        Some(bad) => Err(Error::Invalid(format!("its value is {bad}"))),
    }
}

fn moved(shapes: &[Box<dyn Shape>], direction: &[Vector], step: f64) -> Vec<Box<dyn Shape>> {
    let mut moved: Vec<Box<dyn Shape>> = shapes.iter().map(|s| s.boxed()).collect();
    let vertices = moved.iter_mut().flat_map(|s| s.control_vertices_mut().iter_mut());
    for (vertex, d) in vertices.zip(direction) {
        *vertex += d * step;
    }
    moved
}

/// The coefficients of each scalar equation, `(vertex, vector)` with repeated vertices summed.
fn scalar_rows(store: &Store) -> Vec<BTreeMap<usize, Vector>> {
    let mut all = Vec::new();
    for equation in store.equations() {
        match equation {
            Equation::Alike { vertices, coefficients, .. } => {
                for axis in 0..3 {
                    all.push(
                        vertices.iter().zip(coefficients).map(|(&v, &c)| (v, Vector::ith(axis, c))).collect(),
                    );
                }
            }
            Equation::Coupled { vertices, vectors, .. } => {
                let mut row: BTreeMap<usize, Vector> = BTreeMap::new();
                for (&v, a) in vertices.iter().zip(vectors) {
                    *row.entry(v).or_insert_with(Vector::zeros) += a;
                }
                all.push(row);
            }
        }
    }
    all
}

/// By how much rows differ, relative to the largest coefficient of each; infinite where there are other ones.
fn difference(a: &Store, b: &Store) -> f64 {
    let (a, b) = (scalar_rows(a), scalar_rows(b));
    if a.len() != b.len() {
        return f64::INFINITY;
    }
    let mut worst = 0.0_f64;
    for (a, b) in a.iter().zip(&b) {
        let size = a.values().chain(b.values()).fold(0.0, |m: f64, v| m.max(v.amax()));
        for vertex in a.keys().chain(b.keys()) {
            let zero = Vector::zeros();
            let change = a.get(vertex).unwrap_or(&zero) - b.get(vertex).unwrap_or(&zero);
            if change.amax() > 0.0 {
                worst = worst.max(change.amax() / size);
            }
        }
    }
    worst
}

/// `Σ |coefficient| |vertex|` and the constant of each scalar equation: what its rounding errors are measured by.
fn magnitudes(store: &Store, shapes: &Shapes<'_>) -> Vec<f64> {
    let constants = store.equations().flat_map(|equation| match equation {
        Equation::Alike { constant, .. } => vec![constant.x, constant.y, constant.z],
        Equation::Coupled { constant, .. } => vec![constant],
    });
    let size = |row: &BTreeMap<usize, Vector>| -> f64 {
        row.iter().map(|(&v, a)| a.lp_norm(1) * shapes.vertex(v).coords.amax()).sum()
    };
    scalar_rows(store).iter().zip(constants).map(|(row, constant)| size(row) + constant.abs()).collect()
}

/// Rows times a direction, constants left out.
fn slopes(store: &Store, direction: &[Vector]) -> Vec<f64> {
    let along = |(&v, a): (&usize, &Vector)| direction.get(v).map_or(0.0, |d| a.dot(d));
    scalar_rows(store).iter().map(|row| row.iter().map(along).sum()).collect()
}
