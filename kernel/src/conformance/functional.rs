//! Whether a functional is one: its rows against finite differences, its value against its rows.

use super::{Lcg, Verdict};
use crate::functional::{Equation, Functional, Linearity, Shapes, Store};
use crate::shape::Shape;
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

/// Checks a functional on shapes (as many as it looks at): it appends as many equations as it says; its value changes
/// as its rows say, by central differences in random directions (exactly, where it is linear); it is finite, and asking
/// twice gives the same.
pub fn functional_conformance(functional: &dyn Functional, shapes: &[Box<dyn Shape>]) -> Verdict {
    let mut verdict = Verdict::default();
    let name = functional.describe();
    verdict.check(!name.is_empty(), || "it does not describe itself".into());
    let bound = match functional.bind(&view(shapes)) {
        Ok(bound) => bound,
        Err(error) => {
            verdict.check(false, || format!("{name} cannot be bound: {error}"));
            return verdict;
        }
    };
    let functional = bound.as_deref().unwrap_or(functional);
    let count = functional.equations();
    verdict.check(count > 0, || format!("{name} has no equations"));
    let mut store = Store::default();
    let rows = functional.rows(&view(shapes), &mut store.rows(&view(shapes)));
    if let Err(error) = rows {
        verdict.check(false, || format!("{name} has no rows: {error}"));
        return verdict;
    }
    let width = |e: Equation<'_>| if matches!(e, Equation::Alike { .. }) { 3 } else { 1 };
    let found: usize = (0..store.blocks()).map(|i| width(store.block(i))).sum();
    verdict.check(found == count, || format!("{name} appends {found} equations and says {count}"));
    let Some(value) = value_of(functional, shapes, count) else {
        verdict.check(false, || format!("{name} has no finite value"));
        return verdict;
    };
    verdict.check(value_of(functional, shapes, count).as_ref() == Some(&value), || {
        format!("{name}: two values")
    });

    let total = view(shapes).vertex_count();
    let size = (0..total).map(|v| view(shapes).vertex(v).coords.amax()).fold(0.0, f64::max);
    let mut random = Lcg::new(3);
    for _ in 0..8 {
        let direction: Vec<Vector> =
            (0..total).map(|_| Vector::new(random.next(), random.next(), random.next())).collect();
        let slopes = slopes(&store, &direction);
        // Central differences are exact for linear functionals; for others h² and ε/h balance at ε^(1/3).
        let linear = functional.linearity() == Linearity::Linear;
        let step = if linear { size } else { 6e-6 * size };
        let (Some(up), Some(down)) = (
            value_of(functional, &moved(shapes, &direction, step), count),
            value_of(functional, &moved(shapes, &direction, -step), count),
        ) else {
            verdict.check(false, || format!("{name} has no finite value beside the shapes as they are"));
            continue;
        };
        for k in 0..count {
            let difference = (up[k] - down[k]) / (2.0 * step);
            let scale = slopes[k].abs().max(value[k].abs() / size).max(up[k].abs() / size).max(1e-3);
            let tolerance = if linear { 1e-12 } else { 1e-7 } * scale.max(up[k].abs() / step * 1e-3);
            verdict.check((difference - slopes[k]).abs() <= tolerance, || {
                format!("{name}, equation {k}: rows say {:e}, differences {difference:e}", slopes[k])
            });
        }
    }
    verdict
}

fn view(shapes: &[Box<dyn Shape>]) -> Shapes<'_> {
    Shapes::new(shapes.iter().map(AsRef::as_ref))
}

fn value_of(functional: &dyn Functional, shapes: &[Box<dyn Shape>], count: usize) -> Option<Vec<f64>> {
    let mut out = vec![f64::NAN; count];
    functional.value(&view(shapes), &mut out).ok()?;
    out.iter().all(|v| v.is_finite()).then_some(out)
}

fn moved(shapes: &[Box<dyn Shape>], direction: &[Vector], step: f64) -> Vec<Box<dyn Shape>> {
    let mut moved: Vec<Box<dyn Shape>> = shapes.iter().map(|s| s.boxed()).collect();
    let vertices = moved.iter_mut().flat_map(|s| s.control_vertices_mut().iter_mut());
    for (vertex, d) in vertices.zip(direction) {
        *vertex += d * step;
    }
    moved
}

/// Rows times a direction, constants left out.
fn slopes(store: &Store, direction: &[Vector]) -> Vec<f64> {
    let mut out = Vec::new();
    for i in 0..store.blocks() {
        match store.block(i) {
            Equation::Alike { vertices, coefficients, .. } => {
                let sum = vertices
                    .iter()
                    .zip(coefficients)
                    .fold(Vector::zeros(), |s, (&v, &c)| s + direction[v] * c);
                out.extend(sum.iter());
            }
            Equation::Coupled { vertices, vectors, .. } => {
                out.push(vertices.iter().zip(vectors).map(|(&v, a)| a.dot(&direction[v])).sum());
            }
        }
    }
    out
}
