//! Fair shapes against dense linear algebra (`golden/fair.py` made `golden/fair.json`).

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail the test")]

use loftsman_fairing::{Datum, EnergySum, Fair, FairReport, bend, data, near, stretch, variation};
use loftsman_kernel::edit::Ask;
use loftsman_kernel::functional::{derivative, tangent};
use loftsman_kernel::shape::{Location, Shape};
use loftsman_kernel::solve::{DenseLu, HouseholderQr, Sparse};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};
use serde_json::Value;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

fn points(value: &Value) -> Vec<Point> {
    value.as_array().unwrap().iter().map(|v| Point::from(Vector::from_vec(numbers(v)))).collect()
}

fn space(degree: &Value, knots: &Value, periodic: &Value) -> Space {
    let (degree, knots) = (degree.as_u64().unwrap() as usize, numbers(knots));
    if periodic.as_bool().unwrap() { Space::periodic(degree, knots) } else { Space::open(degree, knots) }
        .unwrap()
}

fn location(at: &Value) -> Location {
    at.as_f64().map_or_else(|| <[f64; 2]>::try_from(numbers(at)).unwrap().into(), Location::from)
}

fn energy(case: &Value) -> EnergySum {
    let mut sum: Option<EnergySum> = None;
    for term in case["energy"].as_array().unwrap() {
        let one = match term[0].as_str().unwrap() {
            "stretch" => stretch(),
            "bend" => bend(),
            "variation" => variation(),
            _ => near(),
        };
        let one = term[1].as_f64().unwrap() * one;
        sum = Some(match sum {
            None => one,
            Some(sum) => sum + one,
        });
    }
    let places = case["data"].as_array().unwrap().iter().map(|d| Datum {
        at: location(&d[0]),
        to: Vector::from_vec(numbers(&d[1])).into(),
        weight: d[2].as_f64().unwrap(),
    });
    if places.len() > 0 { sum.unwrap() + data(places) } else { sum.unwrap() }
}

fn fair<S: Shape + Clone>(shape: &S, case: &Value, number: usize) -> (Vec<Point>, FairReport) {
    let lock = numbers(&case["lock"]).into_iter().map(|v| v as i64);
    let mut fair = Fair::new(shape).energy(energy(case)).lock(lock);
    for asked in case["constraints"].as_array().unwrap() {
        let (at, wanted) = (location(&asked[1]), Vector::from_vec(numbers(&asked[3])));
        fair = fair.ask(match (asked[0].as_str().unwrap(), at) {
            ("tangent", Location::Curve(u)) => tangent(u).direction(wanted).hold(),
            (_, Location::Curve(u)) => derivative(u, asked[2].as_u64().unwrap() as usize).to(wanted),
            (_, at) => {
                let orders = [asked[2][0].as_u64().unwrap() as usize, asked[2][1].as_u64().unwrap() as usize];
                derivative(at, orders).to(wanted)
            }
        });
    }
    // Whatever solver meets the constraints, the fair shape is the same.
    let done = match number % 4 {
        0 => fair.solve(),
        1 => fair.solve_with(HouseholderQr),
        2 => fair.solve_with(Sparse),
        _ => fair.solve_with(DenseLu),
    };
    let done = done.unwrap();
    (done.shape().control_vertices().to_vec(), done.report().clone())
}

#[test]
fn within_a_distance_the_energy_is_nearly_the_least() {
    let golden: Value = serde_json::from_str(include_str!("golden/within.json")).unwrap();
    let cases = golden.as_array().unwrap();
    assert!(cases.len() >= 49);
    for (number, case) in cases.iter().enumerate() {
        let weights = case["weights"].as_array().map(|_| numbers(&case["weights"]));
        let space = space(&case["degree"], &case["knots"], &case["periodic"]);
        let curve = Curve::build(space, points(&case["points"]), weights).unwrap();
        let (distance, least) = (case["distance"].as_f64().unwrap(), case["least"].as_f64().unwrap());
        let mut fair = Fair::new(&curve).energy(energy(case)).within(distance);
        for asked in case["constraints"].as_array().unwrap() {
            let order = asked[2].as_u64().unwrap() as usize;
            fair = fair.ask(derivative(asked[1].as_f64().unwrap(), order).keep());
        }
        let fair = fair.solve().unwrap();
        let report = fair.report();
        let far =
            curve.points().iter().zip(fair.shape().points()).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        assert!(far <= distance && report.farthest <= distance, "case {number}: {far}, {report}");
        // The reference is certified to a billionth.
        assert!(report.energy_after >= least * (1.0 - 2e-9), "case {number}: {least}, {report}");
        assert!(report.energy_after <= 1.0011 * least, "case {number}: {least}, {report}");
        assert!(report.residual < 1e-12 && report.gap <= 1.1e-3, "case {number}: {report}");
    }
}

#[test]
fn curves_and_surfaces_agree_with_dense_algebra() {
    let golden: Value = serde_json::from_str(include_str!("golden/fair.json")).unwrap();
    let cases = golden.as_array().unwrap();
    assert!(cases.len() >= 80);
    let mut worst = 0.0_f64;
    for (number, case) in cases.iter().enumerate() {
        let vertices = points(&case["points"]);
        let (fair, report) = if case["degree"].is_array() {
            let along = |k: usize| space(&case["degree"][k], &case["knots"][k], &case["periodic"][k]);
            fair(&Surface::new(along(0), along(1), vertices).unwrap(), case, number)
        } else {
            let weights = case["weights"].as_array().map(|_| numbers(&case["weights"]));
            let space = space(&case["degree"], &case["knots"], &case["periodic"]);
            fair(&Curve::build(space, vertices, weights).unwrap(), case, number)
        };
        let expected = points(&case["fair"]);
        let size = expected.iter().fold(1.0, |m: f64, p| m.max(p.coords.amax()));
        let far = fair.iter().zip(&expected).map(|(a, b)| (a - b).amax()).fold(0.0, f64::max) / size;
        assert!(far < 1e-10, "case {number}: {far:e} away, {report}, {case}");
        worst = worst.max(far);
        let (before, after) = (case["before"].as_f64().unwrap(), case["after"].as_f64().unwrap());
        assert!((report.energy_before - before).abs() <= 1e-9 * before, "case {number}: {report}");
        assert!(
            (report.energy_after - after).abs() <= 1e-9 * after + 1e-16 * before,
            "case {number}: {report}"
        );
        assert!(report.residual < 1e-12 * size, "case {number}: {report}");
    }
    println!("{} cases, the worst {worst:e} away", cases.len());
}
