//! Against OpenCASCADE: `golden/shapes.py` made the numbers.
#![allow(clippy::unwrap_used, reason = "a test that fails should panic")]

use std::f64::consts::TAU;

use loftsman_construction::{Corners, OffsetOptions, Spread, Turning, offset, spread, sweep};
use loftsman_kernel::spline::{Curve, Direction, Space, Surface};
use loftsman_kernel::{Point, Vector};
use serde_json::Value;

fn golden() -> Value {
    serde_json::from_str(include_str!("golden/shapes.json")).unwrap()
}

fn cases(kind: &str) -> Vec<Value> {
    golden()[kind].as_array().unwrap().clone()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

fn vector(value: &Value) -> Vector {
    Vector::from_row_slice(&numbers(value))
}

fn points(value: &Value) -> Vec<Point> {
    value.as_array().unwrap().iter().map(|v| Point::from(vector(v))).collect()
}

fn degree(case: &Value) -> usize {
    case["degree"].as_u64().unwrap() as usize
}

fn curve(case: &Value) -> Curve {
    let p = points(&case["p"]);
    let space = Space::clamped_uniform(degree(case), p.len()).unwrap();
    Curve::rational(space, p, numbers(&case["w"])).unwrap()
}

fn number(case: &Value, name: &str) -> f64 {
    case[name].as_f64().unwrap()
}

fn length(curve: &Curve) -> f64 {
    curve.length(1e-12).unwrap().value
}

#[test]
fn offsets_pass_where_those_of_opencascade_do() {
    let mut count = 0;
    for case in cases("offsets") {
        let options = OffsetOptions { tolerance: Some(1e-7), ..OffsetOptions::default() };
        let found = offset(&curve(&case), number(&case, "away"), &options).unwrap();
        for p in points(&case["points"]) {
            let near = found.curves.iter().map(|c| c.closest(p).unwrap().distance);
            let near = near.fold(f64::INFINITY, f64::min);
            assert!(near <= 1.1e-7, "{near:e} for {case}");
            count += 1;
        }
    }
    assert!(count >= 900, "{count}");
}

#[test]
fn outlines_are_as_long_as_those_of_opencascade() {
    let (mut count, mut left_out) = (0, 0);
    for case in cases("outlines") {
        let flat: Vec<Vec<f64>> = case["points"].as_array().unwrap().iter().map(numbers).collect();
        let n = flat.len();
        let mut corners: Vec<Point> = flat.iter().map(|p| Point::new(p[0], p[1], 0.0)).collect();
        corners.rotate_left(1);
        let space = Space::periodic(1, (0..=n).map(|k| k as f64).collect()).unwrap();
        let outline = Curve::new(space, corners).unwrap();
        let kind = if case["corners"] == "round" { Corners::Round } else { Corners::Sharp };
        let options = OffsetOptions { corners: kind, ..OffsetOptions::default() };
        let found = offset(&outline, number(&case, "away"), &options).unwrap();
        if number(&case, "length") == 0.0 {
            // Theirs finds none with sharp corners where the rooms fall apart.
            assert_eq!(found.curves.len(), 2, "{case}");
            left_out += 1;
            continue;
        }
        let ours: f64 = found.curves.iter().map(length).sum();
        assert!((ours - number(&case, "length")).abs() <= 1e-9, "{ours} is not that of {case}");
        assert_eq!(found.curves.len() as u64, case["wires"].as_u64().unwrap(), "{case}");
        count += 1;
    }
    assert!(count >= 23 && left_out <= 1, "{count}");
}

#[test]
fn points_are_spread_as_opencascade_does() {
    let mut count = 0;
    for case in cases("even") {
        let own = curve(&case);
        assert!((length(&own) - number(&case, "length")).abs() <= 1e-9, "{case}");
        let sampled = spread(&own, Spread::Count(8)).unwrap();
        assert_eq!((sampled.points.len(), points(&case["points"]).len()), (8, 8), "{case}");
        count += 1;
        for (p, q) in sampled.points.iter().zip(points(&case["points"])) {
            assert!((p - q).norm() <= 1e-6, "{p} is not {q}");
        }
    }
    assert!(count >= 12, "{count}");
}

#[test]
fn surfaces_of_revolution_and_isocurves_are_those_of_opencascade() {
    let mut count = 0;
    for case in cases("revolved") {
        let axis = Vector::new(1.0, 2.0, 0.5);
        let turned = Surface::revolution(&curve(&case), Point::new(1.0, -4.0, 2.0), axis, TAU).unwrap();
        for (p, place) in points(&case["points"]).into_iter().zip(case["places"].as_array().unwrap()) {
            // On the parallel of the same parameter of the curve, at the same angle: our parameter is that nearly only.
            let parallel = turned.isocurve(Direction::V, numbers(place)[1]).unwrap();
            let near = parallel.closest(p).unwrap();
            assert!(near.distance <= 1e-12 * 20.0, "{:e}", near.distance);
            let (angle, turns) = (numbers(place)[0], TAU);
            assert!(((near.at - angle).abs() % turns).min(turns - (near.at - angle).abs() % turns) < 0.03);
            count += 1;
        }
    }
    for case in cases("isocurves") {
        let net: Vec<Vec<Point>> = case["net"].as_array().unwrap().iter().map(points).collect();
        let weights = case["w"].as_array().unwrap().iter().flat_map(numbers).collect();
        let space = |n| Space::clamped_uniform(degree(&case), n).unwrap();
        let (u, v) = (space(net.len()), space(net[0].len()));
        let surface = Surface::rational(u, v, net.into_iter().flatten().collect(), weights).unwrap();
        for (name, direction) in [("u", Direction::U), ("v", Direction::V)] {
            let iso = surface.isocurve(direction, number(&case, "at")).unwrap();
            let (a, b) = iso.domain();
            let theirs = points(&case[name]);
            for (k, p) in theirs.iter().enumerate() {
                let at = (a + (b - a) * k as f64 / (theirs.len() - 1) as f64).min(b);
                assert!((iso.point(at).unwrap() - p).norm() <= 1e-13 * 10.0);
                count += 1;
            }
        }
    }
    assert!(count >= 250, "{count}");
}

#[test]
fn conics_are_those_of_opencascade() {
    let mut count = 0;
    for case in cases("conics") {
        let (center, x, y) = (Point::from(vector(&case["center"])), vector(&case["x"]), vector(&case["y"]));
        let round = (x.norm() - y.norm()).abs() < 1e-12;
        let own =
            if round { Curve::circle(center, x.cross(&y), x.norm()) } else { Curve::ellipse(center, x, y) };
        let own = own.unwrap();
        assert!((length(&own) - number(&case, "length")).abs() <= 1e-9, "{case}");
        for p in points(&case["points"]) {
            assert!(own.closest(p).unwrap().distance <= 1e-14 * 20.0);
            count += 1;
        }
    }
    assert!(count >= 75, "{count}");
}

#[test]
fn pipes_have_the_area_of_those_of_opencascade() {
    let mut count = 0;
    for case in cases("pipes") {
        let (path, radius) = (curve(&case), number(&case, "radius"));
        let along = path.derivative(0.0, 1).unwrap();
        let ring = Curve::circle(path.point(0.0).unwrap(), along, radius).unwrap();
        let swept = sweep(&ring, &path, Turning::Least, Some(1e-7)).unwrap();
        assert!(swept.deviation <= 1e-7 && swept.folds.is_none());
        let s = &swept.surface;
        let mut area = 0.0;
        let rule = [(0.1127016653792583, 5.0 / 18.0), (0.5, 4.0 / 9.0), (0.8872983346207417, 5.0 / 18.0)];
        for span in s.u().breakpoints().windows(2) {
            for v in s.v().breakpoints().windows(2) {
                for (x, wx) in rule {
                    for (y, wy) in
                        rule.iter().flat_map(|(y, w)| [0.0, 1.0, 2.0].map(|k| ((k + y) / 3.0, w / 3.0)))
                    {
                        let u = span[0] + (span[1] - span[0]) * x;
                        let w = v[0] + (v[1] - v[0]) * y;
                        let (su, sv) = (s.derivative(u, w, 1, 0).unwrap(), s.derivative(u, w, 0, 1).unwrap());
                        area += wx * wy * su.cross(&sv).norm() * (span[1] - span[0]) * (v[1] - v[0]);
                    }
                }
            }
        }
        // A tube as thick everywhere: 2πr times its length (Pappus). Theirs is within 1e-5 of that.
        let exact = TAU * radius * length(&path);
        assert!((area - exact).abs() <= 1e-6 * exact, "{area} {exact}");
        assert!(
            (exact - number(&case, "area")).abs() <= 1e-5 * exact
                && (length(&path) - number(&case, "length")).abs() < 1e-9
        );
        count += 1;
    }
    assert!(count >= 7, "{count}");
}
