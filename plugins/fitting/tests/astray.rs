//! Curves go where the points go, whatever the points: measured by an evaluator of the test's own.

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail the test")]

use crate::common::evaluator::{extent, holds};
use crate::common::families::{Member, Random, airfoil, member};
use loftsman_fitting::{Corners, Fit, FitError, FittedCurve, Parametrization, Target};
use loftsman_kernel::edit::Ask;
use loftsman_kernel::functional::{derivative, tangent};
use loftsman_kernel::{Point, Vector};

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

    /// No more refusals than these.
    fn expect(&self, astray: usize, not_met: usize, other: usize) {
        let found = [self.astray, self.not_met, self.other];
        assert!(
            self.fitted > 0 && self.astray <= astray && self.not_met <= not_met && self.other <= other,
            "{} fitted; refused {found:?}:\n{}",
            self.fitted,
            self.refused.join("\n")
        );
    }
}

fn points_of(text: &str) -> Vec<Point> {
    let point = |line: &str| {
        let v: Vec<f64> = line.split_whitespace().map(|w| w.parse().unwrap()).collect();
        Point::new(v[0], v[1], v[2])
    };
    text.lines().map(point).collect()
}

#[test]
fn the_reported_ones() {
    let noisy = points_of(include_str!("data/noisy.xyz"));
    let zigzags = [include_str!("data/zigzag20.xyz"), include_str!("data/zigzag30.xyz")].map(points_of);
    for degree in 1..=7 {
        // 120 points of a unit circle with noise of 0.3 %: 2π and a little.
        let fitted = Fit::new(degree, Target::Relative(1e-4)).curve(&noisy).unwrap();
        holds(&fitted, &noisy, false, "noisy");
        assert!(fitted.met && fitted.length < 6.9, "degree {degree}: {}", fitted.length);
        for points in &zigzags {
            let fitted = Fit::new(degree, Target::Relative(1e-4)).curve(points).unwrap();
            holds(&fitted, points, false, "zigzag");
            assert!(fitted.length < 1.3 * fitted.polygon_length, "degree {degree}: {}", fitted.length);
        }
    }
    // Ten corners of a star of size 80.
    let star: Vec<Point> = (0..10)
        .map(|i| (std::f64::consts::TAU * f64::from(i) / 10.0, if i % 2 == 0 { 40.0 } else { 16.0 }))
        .map(|(a, r)| Point::new(r * a.cos(), r * a.sin(), 0.0))
        .collect();
    for degree in 1..=7 {
        for closed in [true, false] {
            for corners in [Corners::None, Corners::Auto, Corners::Angle(0.5)] {
                let fit = Fit { closed, corners, ..Fit::new(degree, Target::Tolerance(0.1)) };
                let fitted = fit.curve(&star).unwrap();
                holds(&fitted, &star, closed, "star");
                assert!(
                    fitted.length < 1.3 * fitted.polygon_length,
                    "degree {degree} {closed}: {}",
                    fitted.length
                );
                if corners != Corners::None {
                    assert_eq!(fitted.corners.len(), if closed { 10 } else { 8 });
                    assert!((fitted.length / fitted.polygon_length - 1.0).abs() < 1e-9);
                }
            }
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
    tally.expect(0, 0, 0);
}

/// A request of any kind; `limited`: with a number of vertices, which may be more than the points bear, or fewer than
/// the tolerance needs.
fn request(member: &Member, seed: u64, limited: bool) -> Fit {
    let mut r = Random::new(!seed);
    let degree = r.whole(1, 7);
    let m = member.points.len();
    let corners = r.pick(&[Corners::None, Corners::None, Corners::Auto, Corners::Angle(0.6)]);
    let target = match (limited, r.whole(0, 2)) {
        (true, 0 | 1) => Target::Vertices(r.whole((degree + 1).max(4).min(m), m)),
        (true, _) => {
            Target::AtMost { tolerance: 0.05 * extent(&member.points), vertices: (degree + 1 + m / 2).min(m) }
        }
        (false, 0) => Target::Relative(1e-4),
        (false, 1) => Target::Relative(10.0_f64.powf(r.between(-6.0, -1.0))),
        (false, _) => Target::Tolerance(extent(&member.points) * 10.0_f64.powf(r.between(-5.0, -1.0))),
    };
    let ways = [Parametrization::ChordLength, Parametrization::Centripetal, Parametrization::Uniform];
    Fit {
        closed: member.closed,
        corrections: r.whole(0, 5),
        smooth: r.whole(0, 3) > 0,
        parameters: ways[r.pick(&[0, 0, 1, 2])].clone(),
        corners: if limited { Corners::None } else { corners },
        ..Fit::new(degree, target)
    }
}

fn tally(seeds: std::ops::Range<u64>, limited: bool) -> Tally {
    let mut tally = Tally::default();
    for seed in seeds {
        let member = member(seed);
        let fit = request(&member, seed, limited);
        let what = format!("{} (seed {seed}, {fit:?})", member.kind);
        tally.add(fit.curve(&member.points), &member, &what);
    }
    tally
}

#[test]
fn every_degree_tolerance_and_parametrization() {
    tally(1000..1480, false).expect(2, 0, 0);
}

#[test]
fn numbers_of_vertices_are_met_or_refused() {
    // As many vertices as points may not be had (uniform parameters of repeated points, degree 7 of uneven ones), nor
    // every tolerance with half as many.
    tally(2000..2240, true).expect(4, 40, 12);
}

#[test]
fn degree_25_is_refused_or_right() {
    let mut tally = Tally::default();
    for seed in 3000..3064 {
        let member = member(seed);
        let fit = Fit { closed: member.closed, ..Fit::new(25, Target::Relative(1e-3)) };
        tally.add(fit.curve(&member.points), &member, &format!("{} (seed {seed})", member.kind));
    }
    // Open sets of fewer than 26 points are too few.
    tally.expect(4, 4, 24);
}

#[test]
fn directions_held_at_the_ends() {
    let mut tally = Tally::default();
    for seed in 4000..4160 {
        let member = Member { closed: false, ..member(seed) };
        let (first, last) = (member.points[0], member.points[member.points.len() - 1]);
        let Some(next) = member.points.iter().find(|p| **p != first) else { continue };
        let mut fit = Fit::new(3 + (seed % 3) as usize, Target::Relative(1e-2));
        let along = *next - first;
        fit.constraints = vec![if seed % 2 == 0 {
            tangent(0.0).direction(<[f64; 3]>::from(along.normalize())).hold()
        } else {
            let speed = fit_length(&member.points);
            derivative(0.0, 1).to(<[f64; 3]>::from(along.normalize() * speed))
        }];
        let what = format!("{} (seed {seed}, degree {})", member.kind, fit.degree);
        if let Ok(fitted) = &fit.curve(&member.points) {
            let start = fitted.curve.derivative(0.0, 1).unwrap();
            assert!(start.cross(&along).norm() <= 1e-6 * start.norm() * along.norm(), "{what}");
            assert!(
                (fitted.curve.point(1.0).unwrap() - last).norm() <= 1e-9 * extent(&member.points),
                "{what}"
            );
            assert!(
                fitted.length <= 3.0 * fitted.polygon_length,
                "{what}: {}",
                fitted.length / fitted.polygon_length
            );
            assert!(fitted.max_error <= fitted.tolerance.unwrap() * (1.0 + 1e-9), "{what}");
            tally.fitted += 1;
        } else {
            tally.add(fit.curve(&member.points), &member, &what);
        }
    }
    tally.expect(4, 8, 4);
}

fn fit_length(points: &[Point]) -> f64 {
    points.windows(2).map(|w| (w[1] - w[0]).norm()).sum()
}

#[test]
fn corners_of_stars_are_kept_and_round_noses_are_none() {
    for spikes in 3..=15_usize {
        for each in [1, 4, 9] {
            let tip = |i: usize| {
                let (a, r) = (
                    std::f64::consts::PI * i as f64 / spikes as f64,
                    if i.is_multiple_of(2) { 1.0 } else { 0.5 },
                );
                Vector::new(r * a.cos(), r * a.sin(), 0.0)
            };
            let points: Vec<Point> = (0..2 * spikes * each)
                .map(|k| tip(k / each).lerp(&tip(k / each + 1), (k % each) as f64 / each as f64).into())
                .collect();
            let fit =
                Fit { closed: true, corners: Corners::Angle(0.5), ..Fit::new(3, Target::Relative(1e-4)) };
            let fitted = fit.curve(&points).unwrap();
            let wanted: Vec<usize> = (0..2 * spikes).map(|i| i * each).collect();
            let turns = |i: usize| (tip(i + 1) - tip(i)).angle(&(tip(i + 2) - tip(i + 1)));
            if turns(0).min(turns(1)) > 0.5 {
                assert_eq!(fitted.corners, wanted, "{spikes} spikes, {each} points a side");
                assert!((fitted.length / fitted.polygon_length - 1.0).abs() < 1e-6);
                for &k in &fitted.corners {
                    assert!((fitted.curve.point(fitted.parameters[k]).unwrap() - points[k]).norm() < 1e-14);
                }
            }
            holds(&fitted, &points, true, "star");
        }
    }
    let (mut r, mut coarse) = (Random::new(7), 0);
    for case in 0..120 {
        let half = r.whole(10, 80);
        let points = airfoil(&mut r, half);
        for corners in [Corners::Auto, Corners::Angle(0.6), Corners::Angle(1.0)] {
            let fit = Fit { closed: true, corners, ..Fit::new(3, Target::Relative(1e-3)) };
            let fitted = fit.curve(&points).unwrap();
            let nose = fitted.corners.iter().any(|&k| points[k].x < 0.5);
            // Three points of a nose on a coarse section are a corner, as far as anybody can tell.
            assert!(half < 20 || !nose, "section {case} of {half}, {corners:?}: {:?}", fitted.corners);
            coarse += usize::from(nose);
            if case % 10 == 0 {
                holds(&fitted, &points, true, "section");
            }
        }
    }
    assert!(coarse <= 4, "{coarse} of 360 sections have a corner at their nose");
}

#[test]
fn corners_open_closed_weighted_and_held() {
    // An L with rounded legs: one corner inside.
    let mut points: Vec<Point> =
        (0..40).map(|i| f64::from(i) / 40.0).map(|t| Point::new(t, 0.2 * (3.0 * t).sin(), 0.0)).collect();
    let knee = Point::new(1.0, 0.2 * 3.0_f64.sin(), 0.0);
    points.extend(
        (0..=40).map(|i| f64::from(i) / 40.0).map(|t| knee + Vector::new(-0.1 * (2.0 * t).sin(), t, 0.3 * t)),
    );
    for degree in 1..=7 {
        let base = Fit { corners: Corners::Auto, ..Fit::new(degree, Target::Relative(1e-4)) };
        let fitted = base.curve(&points).unwrap();
        holds(&fitted, &points, false, "L");
        assert_eq!(fitted.corners, [40]);
        assert!(fitted.curve.space().multiplicity(fitted.parameters[40]) == degree);
        let counted = Fit {
            target: Target::Vertices(2 * degree + 11),
            weights: Some(vec![2.0; points.len()]),
            ..base.clone()
        };
        let counted = counted.curve(&points).unwrap();
        assert_eq!(counted.curve.points().len(), 2 * degree + 11);
        holds(&counted, &points, false, "L, counted");
        let closed = Fit { closed: true, ..base.clone() }.curve(&points).unwrap();
        assert!(closed.curve.is_periodic() && closed.corners.contains(&40) && closed.corners.len() == 3);
        holds(&closed, &points, true, "L, closed");
        if degree > 1 {
            let mut held = base.clone();
            held.constraints = vec![derivative(0.0, 1).to([2.0, 0.5, 0.0])];
            let start = held.curve(&points).unwrap().curve.derivative(0.0, 1).unwrap();
            assert!((start - Vector::new(2.0, 0.5, 0.0)).norm() < 1e-9);
            held.constraints = vec![derivative(fitted.parameters[40], 1).to([2.0, 0.5, 0.0])];
            assert!(matches!(held.curve(&points), Err(FitError::Constraint { .. })));
        }
    }
}
