//! Few steps bring curves of every family near to points beside them: what a step may not exceed is measured on the shape, not on control vertices,
//! which go thousands of sizes at the ends of knots that are not clamped.

#![allow(clippy::unwrap_used, reason = "tests")]

use loftsman_fitting::{CloudFit, CloudFitted, DerivativeEnergy};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

use crate::common::families::Random;

/// A curve of degree 1 to 7, clamped, floating or periodic, every other one rational.
fn curve(seed: u64, r: &mut Random) -> Curve {
    let degree = 1 + seed as usize % 7;
    let n = degree + r.whole(2, 7);
    let mut at = 0.0;
    let mut next = |r: &mut Random| {
        at += r.between(0.25, 2.0);
        at
    };
    let space = match seed % 3 {
        0 => {
            let (first, inner) = (next(r), (0..n - degree - 1).map(|_| next(r)).collect::<Vec<f64>>());
            let last = next(r);
            let knots = vec![first; degree + 1].into_iter().chain(inner).chain(vec![last; degree + 1]);
            Space::open(degree, knots.collect()).unwrap()
        }
        1 => Space::open(degree, (0..n + degree + 1).map(|_| next(r)).collect()).unwrap(),
        _ => Space::periodic(degree, (0..=n).map(|_| next(r)).collect()).unwrap(),
    };
    let mut unit = || r.between(-1.0, 1.0);
    let points = (0..n).map(|_| Point::new(unit(), unit(), unit())).collect();
    let weights = (seed % 2 == 1).then(|| (0..n).map(|_| r.between(0.25, 4.0)).collect());
    Curve::build(space, points, weights).unwrap()
}

fn fitted(curve: &Curve, away: Vector, steps: usize, r: &mut Random) -> CloudFitted<Curve> {
    let (from, to) = curve.domain();
    let points: Vec<Point> = (0..30).map(|_| curve.point(r.between(from, to)).unwrap() + away).collect();
    CloudFit::new(curve).energy(1e-12, DerivativeEnergy(1)).iterations(steps).to(&points).unwrap()
}

#[test]
fn four_steps_bring_curves_of_every_family_near() {
    let mut most = 0.0_f64;
    for seed in 0..126 {
        let mut r = Random::new(seed);
        let curve = curve(seed, &mut r);
        let fitted = fitted(&curve, Vector::new(0.01, -0.02, 0.005), 4, &mut r);
        let report = fitted.report();
        println!("{seed}: {:.1e} {report}", report.rms / report.before);
        assert!(report.rms < 0.5 * report.before, "{seed}: {report}");
        most = most.max(report.rms / report.before);
    }
    println!("{most}");
}

/// What is a hundred sizes away is reached all the same.
#[test]
fn points_far_away_are_reached() {
    for seed in 0..21 {
        let mut r = Random::new(seed);
        let curve = curve(seed, &mut r);
        let fitted = fitted(&curve, Vector::new(100.0, -200.0, 0.0), 100, &mut r);
        let report = fitted.report();
        println!("{seed}: {:.1e} {report}", report.rms / report.before);
        assert!(report.rms < 1e-2 * report.before, "{seed}: {report}");
    }
}
