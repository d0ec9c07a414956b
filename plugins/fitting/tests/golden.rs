//! Interpolation and least squares against scipy (`golden/fits.py` made `golden/fits.json`).

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail the test")]

use loftsman_fitting::{Ends, Interpolation, LeastSquares, Parametrization};
use loftsman_kernel::spline::Space;
use loftsman_kernel::{Point, Vector};
use serde_json::Value;

fn golden() -> Value {
    serde_json::from_str(include_str!("golden/fits.json")).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

fn vectors(value: &Value) -> Vec<Vector> {
    value.as_array().unwrap().iter().map(|v| Vector::from_vec(numbers(v))).collect()
}

fn points(value: &Value) -> Vec<Point> {
    vectors(value).into_iter().map(Point::from).collect()
}

#[test]
fn interpolation_agrees_with_scipy() {
    let golden = golden();
    let cases = golden["interpolation"].as_array().unwrap();
    assert!(cases.len() >= 17);
    for case in cases {
        let kind = case["ends"].as_str().unwrap();
        let degree = case["degree"].as_u64().unwrap() as usize;
        let through = Interpolation {
            closed: kind == "closed",
            parameters: Parametrization::Given(numbers(&case["parameters"])),
            ends: match kind {
                "not-a-knot" => Ends::NotAKnot,
                "natural" => Ends::Natural,
                "derivatives" => {
                    Ends::Derivatives { start: vectors(&case["start"]), end: vectors(&case["end"]) }
                }
                _ => Ends::Averaged,
            },
            ..Interpolation::new(degree)
        }
        .curve(&points(&case["points"]))
        .unwrap();
        let at = numbers(&case["at"]);
        for (u, value) in at.iter().zip(vectors(&case["values"])) {
            let error = (through.curve.point(*u).unwrap().coords - value).norm();
            assert!(error < 1e-12, "{kind} degree {degree} at {u}: {error:e}");
        }
        if !case["second"].is_null() {
            let second = vectors(&case["second"]);
            let size = second.iter().fold(0.0_f64, |m, v| m.max(v.norm()));
            for (u, value) in at.iter().zip(second) {
                let error = (through.curve.derivative(*u, 2).unwrap() - value).norm();
                // The last sample of a closed curve is seen from the other side of the seam: the same there.
                assert!(error < 1e-10 * size, "{kind} degree {degree}, second derivative at {u}: {error:e}");
            }
        }
    }
}

#[test]
fn least_squares_agrees_with_scipy() {
    let golden = golden();
    let cases = golden["least_squares"].as_array().unwrap();
    assert!(cases.len() >= 8);
    for case in cases {
        let degree = case["degree"].as_u64().unwrap() as usize;
        let mut fit = LeastSquares::new(Space::open(degree, numbers(&case["knots"])).unwrap());
        fit.weights = (!case["weights"].is_null()).then(|| numbers(&case["weights"]));
        let fitted = fit.curve(&numbers(&case["parameters"]), &points(&case["points"])).unwrap();
        // scipy solves normal equations: its own error is the condition squared times rounding.
        for (vertex, expected) in fitted.curve.points().iter().zip(points(&case["vertices"])) {
            assert!(
                (vertex - expected).norm() < 1e-11 * fitted.condition,
                "degree {degree}: {vertex} {expected}"
            );
        }
    }
}
