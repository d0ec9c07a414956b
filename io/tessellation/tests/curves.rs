//! Polylines against their curves: deviation both ways, angle, closedness, sizes, degenerate curves.

#![allow(clippy::unwrap_used, reason = "a test may stop at what should not be")]

use loftsman_kernel::mesh::Polyline;
use loftsman_kernel::plugin::{Chord, Fineness, Tessellator};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};
use loftsman_tessellation::Adaptive;
use proptest::prelude::*;

fn fineness(chord: Chord, degrees: f64) -> Fineness {
    Fineness { chord, angle: degrees.to_radians() }
}

fn circle(radius: f64, centre: Vector) -> Curve {
    let h = 0.5_f64.sqrt();
    let corners = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)]
        .map(|(x, y)| Point::from(centre + Vector::new(f64::from(x), f64::from(y), 0.0) * radius));
    let knots = vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0];
    let weights = vec![1.0, h, 1.0, h, 1.0, h, 1.0, h, 1.0];
    Curve::rational(Space::open(2, knots).unwrap(), corners.to_vec(), weights).unwrap()
}

fn to_segment(p: &Point, a: &Point, b: &Point) -> f64 {
    let ab = b - a;
    let t =
        if ab.norm_squared() > 0.0 { ((p - a).dot(&ab) / ab.norm_squared()).clamp(0.0, 1.0) } else { 0.0 };
    (p - (a + ab * t)).norm()
}

/// The largest distance of curve points from their chord, and of chord points from the curve (by samples of the
/// same stretch).
fn deviation(curve: &Curve, cuts: &[f64]) -> (f64, f64) {
    let (mut out, mut back) = (0.0_f64, 0.0_f64);
    for pair in cuts.windows(2) {
        let samples: Vec<Point> = (0..=32)
            .map(|k| curve.point(pair[0] + (pair[1] - pair[0]) * f64::from(k) / 32.0).unwrap())
            .collect();
        let (a, b) = (samples[0], samples[32]);
        out = samples.iter().map(|p| to_segment(p, &a, &b)).fold(out, f64::max);
        for k in 0..=8 {
            let q = a + (b - a) * (f64::from(k) / 8.0);
            let near = samples.windows(2).map(|s| to_segment(&q, &s[0], &s[1])).fold(f64::MAX, f64::min);
            back = back.max(near);
        }
    }
    (out, back)
}

fn largest_turn(line: &Polyline) -> f64 {
    line.points.windows(3).map(|p| (p[1] - p[0]).angle(&(p[2] - p[1]))).fold(0.0, f64::max)
}

#[test]
fn a_circle_meets_chord_and_angle_with_few_points_at_any_size() {
    for size in [1e-9, 1.0, 1e9] {
        let curve = circle(size, Vector::zeros());
        for tolerance in [1e-2, 1e-4, 1e-6] {
            let fineness = fineness(Chord::Absolute(tolerance * size), 15.0);
            let cuts = Adaptive::default().curve_parameters(&curve, &fineness).unwrap();
            let (out, back) = deviation(&curve, &cuts);
            assert!(out <= tolerance * size && back <= tolerance * size * 1.001, "{out} {back} {tolerance}");
            let line = Adaptive::default().curve(&curve, &fineness).unwrap();
            assert!(line.closed && line.points.len() == cuts.len() - 1);
            assert!(largest_turn(&line) <= 15_f64.to_radians());
            // The least number of chords of a circle: π / acos(1 - tolerance), or a whole turn over the angle.
            let least = (std::f64::consts::PI / (1.0 - tolerance).acos()).max(24.0);
            let count = line.points.len() as f64;
            assert!(count >= least.floor() && count <= 1.02 * least + 1.0, "{count} {least}");
            // All about equally far.
            let lengths: Vec<f64> = line.points.windows(2).map(|p| (p[1] - p[0]).norm()).collect();
            let (short, long) = lengths.iter().fold((f64::MAX, 0.0_f64), |(s, l), x| (s.min(*x), l.max(*x)));
            assert!(long < 1.2 * short, "{short} {long}");
        }
    }
}

#[test]
fn far_from_the_origin_the_relative_tolerance_still_holds() {
    let curve = circle(1.0, Vector::new(1e6, -1e6, 1e6));
    let cuts = Adaptive::default().curve_parameters(&curve, &fineness(Chord::Relative(1e-5), 90.0)).unwrap();
    assert!(deviation(&curve, &cuts).0 <= 1e-5 * 8_f64.sqrt());
}

#[test]
fn straight_curves_need_one_segment_a_span_however_they_are_run_through() {
    let points = [0.0, 0.1, 0.15, 0.9, 1.0].map(|x| Point::new(x, 2.0 * x, -x)).to_vec();
    let line = Adaptive::default()
        .curve(&Curve::bezier(points).unwrap(), &fineness(Chord::Relative(1e-9), 1.0))
        .unwrap();
    assert_eq!(line.points.len(), 2);
}

#[test]
fn a_wiggle_between_samples_is_not_missed() {
    // Antisymmetric about the middle: midpoint and quarter points are all near the chord.
    let points = [0.0, 1.0, -1.0, 1.0, -1.0, 0.0].iter().enumerate();
    let points = points.map(|(i, y)| Point::new(i as f64, *y, 0.0)).collect();
    let curve = Curve::bezier(points).unwrap();
    let cuts = Adaptive::default().curve_parameters(&curve, &fineness(Chord::Absolute(1e-3), 180.0)).unwrap();
    assert!(cuts.len() > 6 && deviation(&curve, &cuts).0 <= 1e-3);
}

#[test]
fn cusps_and_corners_end() {
    let cusp = [(0.0, 0.0), (1.0, 1.0), (0.0, 1.0), (1.0, 0.0)].map(|(x, y)| Point::new(x, y, 0.0)).to_vec();
    let line = Adaptive::default()
        .curve(&Curve::bezier(cusp).unwrap(), &fineness(Chord::Relative(1e-3), 5.0))
        .unwrap();
    assert!(line.points.len() < 300, "{}", line.points.len());
    let square =
        [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| Point::new(x, y, 0.0)).to_vec();
    let square = Curve::new(Space::periodic_uniform(1, 4).unwrap(), square).unwrap();
    let line = Adaptive::default().curve(&square, &Fineness::default()).unwrap();
    assert!(line.closed && line.points.len() == 4);
}

#[test]
fn knots_that_bend_nothing_cost_no_points() {
    let points: Vec<Point> =
        (0..200).map(|i| Point::new(f64::from(i), (f64::from(i) / 60.0).sin() * 20.0, 0.0)).collect();
    let curve = Curve::new(Space::clamped_uniform(3, 200).unwrap(), points).unwrap();
    let cuts = Adaptive::default().curve_parameters(&curve, &fineness(Chord::Absolute(1.0), 90.0)).unwrap();
    assert!(cuts.len() < 12, "{} points for 197 spans", cuts.len());
    assert!(deviation(&curve, &cuts).0 <= 1.0);
}

#[test]
fn a_curve_that_breaks_keeps_both_ends() {
    let points =
        [[0.0, 0.0], [1.0, 0.0], [1.0, 5.0], [2.0, 5.0]].map(|[x, y]| Point::new(x, y, 0.0)).to_vec();
    let curve =
        Curve::new(Space::open(1, vec![0.0, 0.0, 1.0, 1.0, 2.0, 2.0]).unwrap(), points.clone()).unwrap();
    let line = Adaptive::default().curve(&curve, &Fineness::default()).unwrap();
    assert_eq!(line.points, points);
}

#[test]
fn what_cannot_be_met_is_refused_by_name() {
    let curve = circle(1.0, Vector::zeros());
    let say = |f: Fineness, budget: usize| Adaptive { budget }.curve(&curve, &f).unwrap_err().to_string();
    assert!(say(fineness(Chord::Absolute(0.0), 15.0), 10).contains("chord tolerance of 0"));
    assert!(say(fineness(Chord::Relative(f64::NAN), 15.0), 10).contains("NaN"));
    assert!(say(fineness(Chord::Relative(1e-3), -1.0), 10).contains("angle"));
    assert!(say(fineness(Chord::Absolute(1e-6), 15.0), 100).contains("1e-6"));
    assert!(say(fineness(Chord::Absolute(1e-17), 15.0), 100).contains("resolve"));
    let point = Curve::bezier(vec![Point::origin(); 4]).unwrap();
    assert!(
        Adaptive::default().curve(&point, &Fineness::default()).unwrap_err().to_string().contains("coincide")
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn random_curves_are_met(
        degree in 1_usize..7,
        extra in 0_usize..6,
        periodic in any::<bool>(),
        numbers in prop::collection::vec(-1.0_f64..1.0, 60),
        weights in prop::collection::vec(0.1_f64..10.0, 16),
        rational in any::<bool>(),
        exponent in 1_i32..5,
    ) {
        let n = degree + 2 + extra;
        let points: Vec<Point> = (0..n).map(|i| Point::new(i as f64 * 0.1 + numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2])).collect();
        let space = if periodic { Space::periodic_uniform(degree, n) } else { Space::clamped_uniform(degree, n) };
        let curve = Curve::build(space.unwrap(), points, rational.then(|| weights[..n].to_vec())).unwrap();
        let tolerance = 10_f64.powi(-exponent);
        let tessellator = Adaptive::default();
        let cuts = tessellator.curve_parameters(&curve, &fineness(Chord::Absolute(tolerance), 20.0)).unwrap();
        let (out, back) = deviation(&curve, &cuts);
        prop_assert!(out <= tolerance * (1.0 + 1e-9), "{out} > {tolerance}");
        prop_assert!(back <= tolerance * 1.01, "{back} > {tolerance}");
        let line = tessellator.curve(&curve, &fineness(Chord::Absolute(tolerance), 20.0)).unwrap();
        prop_assert_eq!(line.closed, periodic);
    }
}
