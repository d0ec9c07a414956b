//! Evaluation against OpenCASCADE and SciPy (`golden/evaluation.json`, made by `evaluation.py` beside it): points,
//! derivatives, lengths, curvatures, closest points.
#![allow(missing_docs, clippy::unwrap_used, clippy::expect_used, reason = "tests")]

use loftsman_kernel::spline::curvature::CurveFrame;
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};
use serde_json::Value;

fn numbers(value: &Value) -> Vec<f64> {
    list(value).iter().map(number).collect()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn list(value: &Value) -> &[Value] {
    value.as_array().unwrap()
}

fn vector(value: &Value) -> Vector {
    Vector::from_row_slice(&numbers(value))
}

fn vectors(value: &Value) -> Vec<Vector> {
    list(value).iter().map(vector).collect()
}

fn points(value: &Value) -> Vec<Point> {
    vectors(value).into_iter().map(Point::from).collect()
}

fn space(told: &Value) -> Space {
    let degree = told["degree"].as_u64().unwrap() as usize;
    let make = if told["periodic"].as_bool().unwrap() { Space::periodic } else { Space::open };
    make(degree, numbers(&told["knots"])).unwrap()
}

fn weights(told: &Value) -> Option<Vec<f64>> {
    (!told.is_null()).then(|| numbers(told))
}

fn golden() -> Value {
    serde_json::from_str(include_str!("golden/evaluation.json")).unwrap()
}

fn curves(golden: &Value) -> Vec<(&Value, Curve)> {
    let make = |told: &Value| {
        Curve::build(space(&told["space"]), points(&told["points"]), weights(&told["weights"])).unwrap()
    };
    let all: Vec<_> = list(&golden["curves"]).iter().map(|told| (told, make(told))).collect();
    assert!(all.len() >= 24, "{} curves", all.len());
    assert!(all.iter().filter(|(_, c)| c.is_periodic()).count() >= 10);
    assert!(all.iter().filter(|(_, c)| c.weights().is_some()).count() >= 12);
    all
}

fn surfaces(golden: &Value) -> Vec<(&Value, Surface)> {
    let make = |told: &Value| {
        let net = points(&told["points"]);
        Surface::build(space(&told["u"]), space(&told["v"]), net, weights(&told["weights"])).unwrap()
    };
    let all: Vec<_> = list(&golden["surfaces"]).iter().map(|told| (told, make(told))).collect();
    assert!(all.len() >= 8, "{} surfaces", all.len());
    assert!(all.iter().filter(|(_, s)| s.u().is_periodic()).count() >= 4);
    all
}

/// How large a derivative of this order can be: the net's size times `p (p-1) …` over the shortest span's length, an
/// order at a time. What is small beside it is small by cancellation.
fn scale(space: &Space, order: usize) -> f64 {
    let shortest = space.breakpoints().windows(2).map(|b| b[1] - b[0]).fold(f64::INFINITY, f64::min);
    (0..order).map(|k| (space.degree().saturating_sub(k)).max(1) as f64 / shortest).product()
}

fn size(points: &[Point]) -> f64 {
    points.iter().fold(0.0, |m, p| m.max(p.coords.amax()))
}

#[test]
fn points_and_derivatives_of_curves() {
    let golden = golden();
    let mut compared = 0;
    for (case, (told, curve)) in curves(&golden).into_iter().enumerate() {
        for sample in list(&told["samples"]) {
            let u = number(&sample["u"]);
            for (order, expected) in vectors(&sample["derivatives"]).into_iter().enumerate() {
                let found = curve.derivative(u, order).unwrap();
                let scale = scale(curve.space(), order) * size(curve.points());
                assert!(
                    (found - expected).norm() <= 1e-12 * scale,
                    "curve {case} at {u}, order {order}: {found}, not {expected}"
                );
                compared += 1;
            }
        }
    }
    assert!(compared >= 500, "{compared}");
}

#[test]
fn curvature_and_torsion_of_curves() {
    let golden = golden();
    let mut compared = 0;
    for (case, (told, curve)) in curves(&golden).into_iter().enumerate() {
        for sample in list(&told["samples"]) {
            let Some(expected) = sample.get("curvature").map(number) else { continue };
            let u = number(&sample["u"]);
            let (curvature, torsion) = match curve.frame(u).unwrap() {
                CurveFrame::Bent { curvature, torsion, .. } => (curvature, torsion),
                CurveFrame::Straight { .. } => (0.0, 0.0),
                CurveFrame::Singular => panic!("curve {case} at {u} has a tangent"),
            };
            let wrong = (curvature - expected).abs();
            assert!(wrong <= 1e-9 * expected, "curve {case} at {u}: {curvature}, not {expected}");
            if let Some(expected) = sample.get("torsion").map(number) {
                let wrong = (torsion - expected).abs();
                assert!(wrong <= 1e-9 * expected.abs().max(curvature), "curve {case} at {u}: {torsion}");
            }
            compared += 1;
        }
    }
    assert!(compared >= 130, "{compared}");
}

#[test]
fn lengths_of_curves() {
    let golden = golden();
    for (case, (told, curve)) in curves(&golden).into_iter().enumerate() {
        let (found, expected) = (curve.length(1e-11).unwrap(), number(&told["length"]));
        assert!(found.reached);
        assert!((found.value - expected).abs() <= 1e-9 * expected, "curve {case}: {found:?}, not {expected}");
    }
}

/// Whether a point found at `distance` is as close as the reference's: no farther by 1e-9 of it, nor closer, which
/// would mean that the reference missed a place or that ours is not on the shape.
fn as_close(distance: f64, expected: f64) -> bool {
    (distance - expected).abs() <= 1e-9 * expected
}

#[test]
fn closest_points() {
    let golden = golden();
    let mut compared = 0;
    for (case, (told, curve)) in curves(&golden).into_iter().enumerate() {
        for asked in list(&told["closest"]) {
            let (to, expected) = (Point::from(vector(&asked["to"])), number(&asked["distance"]));
            let found = curve.closest(to).unwrap();
            assert!(as_close(found.distance, expected), "curve {case}: {found:?}, not {expected}");
            assert!(as_close((curve.point(found.at).unwrap() - to).norm(), expected));
            compared += 1;
        }
    }
    for (case, (told, surface)) in surfaces(&golden).into_iter().enumerate() {
        for asked in list(&told["closest"]) {
            let (to, expected) = (Point::from(vector(&asked["to"])), number(&asked["distance"]));
            let found = surface.closest(to).unwrap();
            assert!(as_close(found.distance, expected), "surface {case}: {found:?}, not {expected}");
            assert!(as_close((surface.point(found.at.0, found.at.1).unwrap() - to).norm(), expected));
            compared += 1;
        }
    }
    assert!(compared >= 96, "{compared}");
}

#[test]
fn points_derivatives_and_curvatures_of_surfaces() {
    let golden = golden();
    let mut compared = 0;
    for (case, (told, surface)) in surfaces(&golden).into_iter().enumerate() {
        for sample in list(&told["samples"]) {
            let at = numbers(&sample["at"]);
            let (u, v) = (at[0], at[1]);
            for (orders, expected) in list(&sample["orders"]).iter().zip(vectors(&sample["derivatives"])) {
                let (a, b) = (orders[0].as_u64().unwrap() as usize, orders[1].as_u64().unwrap() as usize);
                let found = surface.derivative(u, v, a, b).unwrap();
                let scale = scale(surface.u(), a) * scale(surface.v(), b) * size(surface.points());
                assert!(
                    (found - expected).norm() <= 1e-12 * scale,
                    "surface {case} at {at:?}, orders {a} and {b}: {found}, not {expected}"
                );
                compared += 1;
            }
            let found = surface.curvature(u, v).unwrap().unwrap();
            assert!((found.normal - vector(&sample["normal"])).norm() <= 1e-9, "surface {case}: {found:?}");
            // Relative to the larger principal curvature: the mean of opposite ones cancels, as does their product.
            let largest = found.principal[0].abs().max(found.principal[1].abs());
            let (gaussian, mean) = (number(&sample["gaussian"]), number(&sample["mean"]));
            assert!(
                (found.gaussian - gaussian).abs() <= 1e-9 * largest * largest,
                "surface {case}: {found:?}"
            );
            assert!((found.mean - mean).abs() <= 1e-9 * largest, "surface {case}: {found:?}");
        }
    }
    assert!(compared >= 400, "{compared}");
}
