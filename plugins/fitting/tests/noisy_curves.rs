//! Curves fitted to few noisy points without an energy: what is handed out is no farther from the points than what was given, and is as far as told.

#![allow(clippy::unwrap_used, reason = "tests")]

use std::f64::consts::TAU;

use loftsman_fitting::{CloudFit, FitError};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

use crate::common::evaluator::Spline;
use crate::common::families::Random;

/// A curve of degree 1 to 5, clamped or periodic, with uneven knots or even ones, moved away from points with noise of another.
fn case(seed: u64) -> (Curve, Vec<Point>) {
    let mut r = Random::new(seed);
    let degree = 1 + seed as usize % 5;
    let periodic = r.unit() < 0.4;
    let n = degree + r.whole(2, 9);
    let space = if periodic {
        Space::periodic_uniform(degree, n).unwrap()
    } else {
        let mut inner: Vec<f64> = (0..n - degree - 1).map(|_| r.unit()).collect();
        inner.sort_by(f64::total_cmp);
        let knots = vec![0.0; degree + 1].into_iter().chain(inner).chain(vec![1.0; degree + 1]);
        Space::open(degree, knots.collect()).unwrap()
    };
    let mut walk = 0.0;
    let vertices: Vec<Vector> = (0..n)
        .map(|k| {
            let t = k as f64 / n as f64;
            walk += r.normal();
            if periodic {
                Vector::new(3.0 * (TAU * t).cos(), 2.0 * (TAU * t).sin(), 0.0)
                    + Vector::new(r.normal(), r.normal(), r.normal()) * 0.2
            } else {
                Vector::new(k as f64, walk, 0.3 * r.normal())
            }
        })
        .collect();
    let size = vertices.iter().fold(0.0_f64, |m, v| m.max(v.norm()));
    let known = Curve::new(space.clone(), vertices.iter().copied().map(Point::from).collect()).unwrap();
    let noise = size * r.pick(&[0.003, 0.01, 0.03, 0.1]);
    let away = size * r.pick(&[0.03, 0.1]);
    let mut near = |v: Vector, by: f64| Point::from(v + Vector::new(r.normal(), r.normal(), r.normal()) * by);
    let start = Curve::new(space, vertices.iter().map(|v| near(*v, away)).collect()).unwrap();
    let mut q = Random::new(seed ^ 0x77);
    let (from, to) = known.domain();
    let points = (0..n * q.whole(2, 8))
        .map(|_| known.point(from + (to - from) * q.unit()).unwrap().coords)
        .map(|p| near(p, noise))
        .collect();
    (start, points)
}

/// The root of the mean of the squared distances, by an evaluator of the tests.
fn rms(curve: &Curve, points: &[Point], each: usize) -> f64 {
    let spline = Spline::of(curve, 1.0);
    let samples = spline.samples(each);
    let sum: f64 = points.iter().map(|p| spline.distance(&samples, p.coords).powi(2)).sum();
    (sum / points.len() as f64).sqrt()
}

/// How far any place went from where it began, as part of the diagonal of the box of points and control vertices.
fn went(start: &Curve, fitted: &Curve, points: &[Point]) -> f64 {
    let all = || start.points().iter().chain(points);
    let side = |k: usize| {
        all().map(|p| p[k]).fold(f64::MIN, f64::max) - all().map(|p| p[k]).fold(f64::MAX, f64::min)
    };
    let (from, to) = start.domain();
    let at = |c: &Curve, k: usize| c.point(from + (to - from) * k as f64 / 2000.0).unwrap();
    let most = (0..=2000).map(|k| (at(fitted, k) - at(start, k)).norm()).fold(0.0, f64::max);
    most / Vector::new(side(0), side(1), side(2)).norm()
}

#[test]
fn what_is_handed_out_is_never_worse_and_as_far_as_told() {
    let (mut refused, mut far) = (0, 0.0_f64);
    for seed in 0..120 {
        let (start, points) = case(seed);
        let fitted = match CloudFit::new(&start).to(&points) {
            Ok(fitted) => fitted,
            Err(FitError::Undetermined { .. }) => {
                refused += 1;
                continue;
            }
            Err(error) => panic!("{seed}: {error}"),
        };
        let report = fitted.report();
        let reach = went(&start, fitted.shape(), &points);
        let (before, after) = (rms(&start, &points, 60), rms(fitted.shape(), &points, 2000));
        assert!((before - report.before).abs() <= 1e-6 * before, "{seed}: {before:e} {:e}", report.before);
        assert!(after <= before * (1.0 + 1e-9), "{seed}: {before:e} -> {after:e}");
        assert!((after - report.rms).abs() <= 1e-9 * after, "{seed}: {after:e}, told {:e}", report.rms);
        far = far.max(reach);
    }
    println!("{refused} refused, farthest {far:.1} diagonals");
    // Measured at many places of each piece, and a little more between them.
    assert!(refused <= 30 && far <= 10.1, "{refused} {far}");
}
