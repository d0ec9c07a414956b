//! A measured blade section: sharp nose, open trailing edge, uneven points.

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail the test")]

use loftsman_fitting::{Fit, FittedCurve, Target};
use loftsman_kernel::Point;

fn section() -> Vec<Point> {
    let numbers = |line: &str| -> Option<Point> {
        let mut words = line.split_whitespace().map(str::parse::<f64>);
        let (x, y) = (words.next()?.ok()?, words.next()?.ok()?);
        words.next().is_none().then(|| Point::new(x, y, 0.0))
    };
    // The first row is the reference point.
    include_str!("data/IEA-15-240-RWT_AF20_Coords.txt").lines().filter_map(numbers).skip(1).collect()
}

fn turn(a: Point, b: Point, c: Point) -> f64 {
    let (u, v) = (b - a, c - b);
    (u.x * v.y - u.y * v.x).atan2(u.dot(&v))
}

fn samples(fitted: &FittedCurve, count: usize) -> Vec<Point> {
    (0..=count).map(|i| fitted.curve.point(i as f64 / count as f64).unwrap()).collect()
}

#[test]
fn one_ten_thousandth_of_the_chord_without_wiggles() {
    let points = section();
    assert_eq!(points.len(), 200);
    let fitted = Fit::new(3, Target::Tolerance(1e-4)).curve(&points).unwrap();
    assert!(fitted.met && fitted.max_error <= 1e-4 && fitted.rms_error <= 5e-5);
    assert!(!fitted.interpolated);
    assert!(fitted.curve.points().len() <= 45, "{} vertices", fitted.curve.points().len());
    assert_eq!(fitted.curve.points()[0], points[0]);
    assert_eq!(fitted.curve.points().last(), points.last());
    // Not by the fit's own measure: every point has a sample of the curve near it.
    let line = samples(&fitted, 40_000);
    for point in &points {
        let nearest = line.iter().map(|p| (p - point).norm()).fold(f64::INFINITY, f64::min);
        assert!(nearest <= 1.02e-4, "{nearest:e}");
    }
    // Nor does the curve leave the points between them: no farther than the tolerance and the sag of an arc as
    // curved as the section over the longest step, 0.024² · 3 / 8.
    for p in line.iter().step_by(20) {
        let off = points
            .windows(2)
            .map(|w| {
                let along = ((p - w[0]).dot(&(w[1] - w[0])) / (w[1] - w[0]).norm_squared()).clamp(0.0, 1.0);
                (p - w[0].coords.lerp(&w[1].coords, along)).coords.norm()
            })
            .fold(f64::INFINITY, f64::min);
        assert!(off < 3.2e-4, "{off:e} at {p}");
    }
    // A curve that swings between its points turns more than their polygon does.
    let total = |p: &[Point]| p.windows(3).map(|w| turn(w[0], w[1], w[2]).abs()).sum::<f64>();
    let (curve, polygon) = (total(&line), total(&points));
    assert!(curve <= polygon, "turns by {curve}, the points by {polygon}");
    // Around the nose, where the points have a corner of seven degrees, it turns one way only.
    let nose: Vec<Point> = line.iter().copied().filter(|p| p.x < 0.05).collect();
    assert!(nose.len() > 1000);
    assert!(nose.windows(3).all(|w| turn(w[0], w[1], w[2]) < 0.0));
}

#[test]
fn smoothing_takes_turning_away_and_keeps_the_tolerance() {
    let points = section();
    let rough = Fit { smooth: false, ..Fit::new(3, Target::Relative(1e-4)) }.curve(&points).unwrap();
    let fine = Fit::new(3, Target::Relative(1e-4)).curve(&points).unwrap();
    let total =
        |f: &FittedCurve| samples(f, 20_000).windows(3).map(|w| turn(w[0], w[1], w[2]).abs()).sum::<f64>();
    assert!(fine.max_error <= fine.tolerance.unwrap());
    assert!(total(&fine) < total(&rough));
}

#[test]
fn every_degree_and_tolerance_is_met_and_more_is_not_needed_for_less() {
    let points = section();
    for degree in [1, 2, 3, 4, 5, 7] {
        let mut before = 0;
        for tolerance in [3e-3, 1e-3, 3e-4, 1e-4] {
            let fitted = Fit::new(degree, Target::Tolerance(tolerance)).curve(&points).unwrap();
            assert!(fitted.max_error <= tolerance, "degree {degree}, {tolerance}");
            let count = fitted.curve.points().len();
            assert!(
                count + 3 >= before && count < 150,
                "degree {degree}, {tolerance}: {count} after {before}"
            );
            before = count;
        }
    }
}

#[test]
fn a_given_number_of_vertices_is_given() {
    let points = section();
    let mut before = f64::INFINITY;
    for vertices in [8, 16, 24, 40, 80] {
        let fitted = Fit::new(3, Target::Vertices(vertices)).curve(&points).unwrap();
        assert_eq!(fitted.curve.points().len(), vertices);
        assert!(fitted.max_error < before, "{vertices} vertices: {:e} after {before:e}", fitted.max_error);
        before = fitted.max_error;
    }
    let closed = Fit { closed: true, ..Fit::new(3, Target::Vertices(40)) }.curve(&points).unwrap();
    assert!(closed.curve.is_periodic() && closed.curve.points().len() == 40);
}
