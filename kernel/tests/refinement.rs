//! Changes of representation against OpenCASCADE and SciPy (`golden/refinement.json`, made by `refinement.py` beside
//! it), and over the magnitudes 1e-9 … 1e9 of coordinates and parameters.
#![allow(missing_docs, clippy::unwrap_used, clippy::expect_used, reason = "tests")]

use loftsman_kernel::Point;
use loftsman_kernel::spline::{Curve, Space};
use serde_json::Value;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn points(value: &Value) -> Vec<Point> {
    value.as_array().unwrap().iter().map(numbers).map(|p| Point::new(p[0], p[1], p[2])).collect()
}

/// A curve as OpenCASCADE tells it. The knots of a periodic one are counted at its end, so that its first pole is
/// some vertex of ours: vertices are then compared up to where they start.
fn curve(told: &Value) -> Curve {
    let degree = told["degree"].as_u64().unwrap() as usize;
    let runs: Vec<(f64, usize)> = told["knots"]
        .as_array()
        .unwrap()
        .iter()
        .map(|k| (k[0].as_f64().unwrap(), k[1].as_u64().unwrap() as usize))
        .collect();
    let flat = |runs: &[(f64, usize)]| -> Vec<f64> {
        runs.iter().flat_map(|&(k, m)| std::iter::repeat_n(k, m)).collect()
    };
    let (vertices, weights) = (points(&told["points"]), numbers(&told["weights"]));
    let space = if told["periodic"].as_bool().unwrap() {
        let mut knots = vec![runs[0].0];
        knots.extend(flat(&runs[1..]));
        Space::periodic(degree, knots).unwrap()
    } else {
        Space::open(degree, flat(&runs)).unwrap()
    };
    let rational = weights.iter().any(|&w| w != 1.0);
    Curve::build(space, vertices, rational.then_some(weights)).unwrap()
}

fn rotated(curve: &Curve, by: usize) -> Curve {
    let (space, mut points, mut weights) = curve.clone().into_parts();
    points.rotate_left(by);
    if let Some(weights) = &mut weights {
        weights.rotate_left(by);
    }
    Curve::build(space, points, weights).unwrap()
}

/// The largest difference of knots, vertices and weights.
fn difference(a: &Curve, b: &Curve) -> f64 {
    assert_eq!((a.degree(), a.points().len()), (b.degree(), b.points().len()));
    let knots = a.space().knots().iter().zip(b.space().knots()).map(|(s, t)| (s - t).abs());
    let points = a.points().iter().zip(b.points()).map(|(p, q)| (p - q).norm());
    let weights = |c: &Curve| c.weights().map_or(vec![1.0; c.points().len()], <[f64]>::to_vec);
    let weights = weights(a).into_iter().zip(weights(b)).map(|(v, w)| (v - w).abs());
    knots.chain(points).chain(weights).fold(0.0, f64::max)
}

#[test]
fn opencascade_has_the_same_vertices() {
    let golden: Value = serde_json::from_str(include_str!("golden/refinement.json")).unwrap();
    let cases = golden["cases"].as_array().unwrap();
    assert!(cases.len() >= 10);
    let (mut periodic, mut compared) = (0, 0);
    for (i, case) in cases.iter().enumerate() {
        let mut input = curve(&case["input"]);
        // Their periodic curve is the one of our rotations that their opened curve shows.
        if input.is_periodic() {
            periodic += 1;
            let opened = curve(&case["opened"]);
            let same = |c: &Curve| {
                [0.1, 0.4, 0.9].iter().all(|s| {
                    let u = s * c.space().length();
                    (c.point(u).unwrap() - opened.point(u).unwrap()).norm() < 1e-12
                })
            };
            let n = input.points().len();
            input = (0..n).map(|by| rotated(&input, by)).find(same).expect("no rotation fits");
        }
        let new = case["new"].as_f64().unwrap();
        let times = if input.degree() > 1 { 2 } else { 1 };
        let inserted = input.insert_knots(&vec![new; times]).unwrap();
        let raised = input.elevate(2).unwrap();
        for (name, ours) in [("inserted", inserted), ("raised", raised)] {
            let Some(theirs) = case.get(name).map(curve) else { continue };
            compared += 1;
            let turns = if input.is_periodic() { theirs.points().len() } else { 1 };
            let best =
                (0..turns).map(|by| difference(&ours, &rotated(&theirs, by))).fold(f64::INFINITY, f64::min);
            assert!(best < 2e-13, "case {i}, {name}: {best}");
        }
        let part = numbers(&case["part"]);
        let best = difference(&input.between(part[0], part[1]).unwrap(), &curve(&case["part_curve"]));
        assert!(best < 1e-12, "case {i}, part: {best}");
    }
    assert!(periodic >= 4 && compared >= 18);
}

#[test]
fn scipy_has_the_same_vertices_for_floating_curves() {
    let golden: Value = serde_json::from_str(include_str!("golden/refinement.json")).unwrap();
    let cases = golden["floating"].as_array().unwrap();
    assert_eq!(cases.len(), 3);
    for case in cases {
        let degree = case["degree"].as_u64().unwrap() as usize;
        let make = |v: &Value| {
            Curve::new(Space::open(degree, numbers(&v["knots"])).unwrap(), points(&v["points"])).unwrap()
        };
        let inserted = make(case).insert_knots(&[case["new"].as_f64().unwrap(); 2]).unwrap();
        assert!(difference(&inserted, &make(&case["inserted"])) < 1e-13);
    }
}

/// Every change of representation, at the sizes of atoms and of planets: nothing but the scale may show.
#[test]
fn magnitudes_of_coordinates_and_parameters_change_nothing() {
    let wave = |i: usize| Point::new((i as f64).sin(), (1.7 * i as f64).cos(), 0.3 * i as f64);
    for size in [1e-9, 1e-3, 1e3, 1e9] {
        for length in [1e-9, 1e9] {
            for (periodic, degree) in [(false, 3), (true, 3), (false, 5), (true, 4)] {
                let knots: Vec<f64> =
                    (0..=12).map(|i| length * (i as f64 + 0.2 * (i as f64).sin())).collect();
                let space =
                    if periodic { Space::periodic(degree, knots) } else { Space::clamped(degree, &knots) }
                        .unwrap();
                let vertices: Vec<Point> = (0..space.len()).map(|i| wave(i) * size).collect();
                let weights = (0..space.len()).map(|i| 1.0 + 0.5 * (i as f64).cos()).collect();
                for curve in [
                    Curve::new(space.clone(), vertices.clone()),
                    Curve::rational(space.clone(), vertices.clone(), weights),
                ] {
                    let curve = curve.unwrap();
                    let (a, b) = curve.domain();
                    let u = a + 0.37 * (b - a);
                    let finer = curve.insert_knots(&[u, u, a + 0.6 * (b - a)]).unwrap();
                    let parts = curve.to_clamped().unwrap().split(u).unwrap();
                    let same = [
                        finer.clone(),
                        finer.remove_knots(1e-11 * size).unwrap().shape,
                        curve.elevate(2).unwrap(),
                        curve.bezier_form().unwrap(),
                        parts[0].join(&parts[1], 0.0).unwrap().shape,
                        curve.to_clamped().unwrap(),
                        curve.reverse().unwrap().reverse().unwrap(),
                        curve.reparametrise(0.0, 1.0).unwrap().reparametrise(a, b).unwrap(),
                    ];
                    for (i, other) in same.iter().enumerate() {
                        for k in 0..=40 {
                            let u = (a + (b - a) * f64::from(k) / 40.0).min(b);
                            let distance = (curve.point(u).unwrap() - other.point(u).unwrap()).norm();
                            assert!(
                                distance < 1e-11 * size,
                                "{i}: {distance} at {u}, size {size}, length {length}"
                            );
                        }
                    }
                    assert_eq!(same[1].points().len(), curve.points().len(), "size {size}, length {length}");
                    if periodic {
                        let closed = curve.to_clamped().unwrap().to_periodic(1e-11 * size).unwrap();
                        assert_eq!(
                            (closed.continuity, closed.shape.points().len()),
                            (degree - 1, curve.points().len())
                        );
                    }
                }
            }
        }
    }
}
