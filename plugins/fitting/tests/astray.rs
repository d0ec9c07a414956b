//! Curves go where the points go, whatever the points: measured by an evaluator of the test's own.

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail the test")]

mod common;

use common::evaluator::{Spline, length, polygon};
use common::families::{KINDS, Member, Random, member};
use loftsman_fitting::{Corners, Fit, FitError, FittedCurve, Parametrization, Target};
use loftsman_kernel::{Point, Vector};

/// Longer than this many times their polygon curves are to be refused.
const LONGEST: f64 = 2.0;

fn size(points: &[Point]) -> f64 {
    points.iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()))
}

/// Everything that a fit says of its curve, measured again.
fn holds(fitted: &FittedCurve, points: &[Point], closed: bool, what: &str) {
    let size = size(points);
    let spline = Spline::of(&fitted.curve, size);
    let samples =
        spline.samples(if fitted.curve.points().len() < 60 { 16 * (1 + fitted.curve.degree()) } else { 24 });
    let line: Vec<Vector> = samples.iter().map(|s| s.1).collect();
    let (long, chain) = (length(&line), polygon(points, closed, size));
    assert!(long <= LONGEST * chain + 1e-12, "{what}: {long} long, the polygon {chain}");
    assert!(
        (long - fitted.length / size).abs() <= 0.02 * long + 1e-12,
        "{what}: says {:e}, is {long}",
        fitted.length / size
    );
    assert!((chain - fitted.polygon_length / size).abs() <= 1e-9 * chain);
    // Distances at the parameters, and the true ones from dense samples.
    let (mut worst, mut nearest) = (0.0_f64, 0.0_f64);
    for (u, point) in fitted.parameters.iter().zip(points) {
        let q = point.coords / size;
        let there = (spline.at(*u) - q).norm();
        worst = worst.max(there);
        nearest = nearest.max(spline.distance(&samples, q).min(there));
    }
    let rounding = 1e-13 * (1.0 + spread(points, size).recip());
    assert!(
        (worst - fitted.max_error / size).abs() <= rounding + 1e-9 * worst,
        "{what}: {worst:e} {:e}",
        fitted.max_error / size
    );
    assert!(fitted.distance <= fitted.max_error * (1.0 + 1e-9));
    assert!(
        (nearest - fitted.distance / size).abs() <= 1e-6 * worst + rounding,
        "{what}: {nearest:e} {:e}",
        fitted.distance / size
    );
    if let (true, Some(tolerance)) = (fitted.met, fitted.tolerance) {
        assert!(worst * size <= tolerance * (1.0 + 1e-6) + rounding * size, "{what}: {worst:e}");
    }
    for w in fitted.parameters.windows(2) {
        assert!(w[0] <= w[1], "{what}: the order of the points is lost");
    }
}

fn extent(points: &[Point]) -> f64 {
    spread(points, size(points)) * size(points)
}

/// The extent of points in units of `size`.
fn spread(points: &[Point], size: f64) -> f64 {
    points.iter().fold(0.0_f64, |m, p| m.max(((p - points[0]) / size).amax()))
}

/// What came of many fits.
#[derive(Default)]
struct Tally {
    fitted: usize,
    astray: usize,
    not_met: usize,
    other: usize,
    long: f64,
    refused: Vec<String>,
}

impl Tally {
    fn add(&mut self, result: Result<FittedCurve, FitError>, member: &Member, what: &str) {
        match result {
            Ok(fitted) => {
                self.fitted += 1;
                self.long = self.long.max(fitted.length / fitted.polygon_length);
                holds(&fitted, &member.points, member.closed, what);
            }
            Err(error) => {
                match error {
                    FitError::Astray { .. } => self.astray += 1,
                    FitError::NotMet { .. } => self.not_met += 1,
                    _ => self.other += 1,
                }
                self.refused.push(format!("{what}: {error}"));
            }
        }
    }

    fn show(&self, name: &str) {
        println!(
            "{name}: {} fitted, {} astray, {} not met, {} other; longest {:.3}",
            self.fitted, self.astray, self.not_met, self.other, self.long
        );
        for line in self.refused.iter().filter(|l| !l.contains("shared out") && !l.contains("the tolerance"))
        {
            println!("    {line}");
        }
    }
}

#[test]
fn hundreds_of_sets_of_points_by_default() {
    let mut tally = Tally::default();
    for seed in 0..480 {
        let member = member(seed);
        let fit = Fit { closed: member.closed, ..Fit::new(3, Target::Relative(1e-4)) };
        tally.add(fit.curve(&member.points), &member, &format!("{} (seed {seed})", member.kind));
    }
    tally.show("default");
}

#[test]
fn every_degree_tolerance_and_parametrization() {
    let mut tally = Tally::default();
    for seed in 1000..1640 {
        let member = member(seed);
        let mut r = Random::new(!seed);
        let degree = r.whole(1, 7);
        let target = match r.whole(0, 4) {
            0 => Target::Relative(1e-4),
            1 => Target::Relative(10.0_f64.powf(r.between(-6.0, -1.0))),
            2 => Target::Tolerance(extent(&member.points) * 10.0_f64.powf(r.between(-5.0, -1.0))),
            3 => Target::Vertices(r.whole((degree + 1).max(4), member.points.len().max(9))),
            _ => Target::AtMost {
                tolerance: 0.05 * extent(&member.points),
                vertices: degree + 1 + member.points.len() / 2,
            },
        };
        let fit = Fit {
            closed: member.closed,
            corrections: r.whole(0, 5),
            smooth: r.whole(0, 3) > 0,
            parameters: r
                .pick(&[0, 0, 1, 2])
                .min(2)
                .try_into()
                .map(|k: u8| {
                    [Parametrization::ChordLength, Parametrization::Centripetal, Parametrization::Uniform]
                        [k as usize]
                        .clone()
                })
                .unwrap(),
            corners: r.pick(&[Corners::None, Corners::None, Corners::Auto, Corners::Angle(0.6)]),
            ..Fit::new(degree, target)
        };
        let what = format!(
            "{} (seed {seed}, degree {degree}, {target:?}, {:?}, {:?})",
            member.kind, fit.parameters, fit.corners
        );
        tally.add(fit.curve(&member.points), &member, &what);
    }
    tally.show("every");
    let _ = KINDS;
}
#[test]
fn debug() {
    let m = member(1447);
    for smooth in [true, false] {
        for corners in [Corners::Auto, Corners::None] {
            let fit = Fit {
                closed: m.closed,
                corners,
                smooth,
                best_effort: true,
                ..Fit::new(1, Target::Relative(1e-4))
            };
            println!("{:?}", fit.curve(&m.points).map(|f| (f.corners, f.remarks, f.length, f.interpolated)));
        }
    }
    for k in 34..44 {
        println!("{k} {:?}", m.points[k] - m.points[k - 1]);
    }
}
