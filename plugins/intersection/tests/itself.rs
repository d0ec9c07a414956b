//! Curves that meet themselves.
#![allow(clippy::unwrap_used, reason = "a test that fails should panic")]

use loftsman_intersection::{Contact, Intersections, Options, self_intersections};
use loftsman_kernel::shape::Location;
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

fn found(curve: &Curve) -> Intersections {
    let found = self_intersections(curve, &Options::default()).unwrap();
    assert!(found.is_complete());
    for m in &found.meetings {
        let s = m.with.map_or(f64::NAN, |with| if let Location::Curve(s) = with { s } else { f64::NAN });
        assert!(m.at < s && (curve.point(m.at).unwrap() - curve.point(s).unwrap()).norm() <= found.tolerance);
    }
    found
}

#[test]
fn loops_cross_and_what_only_passes_does_not() {
    for scale in [1.0, 1e-9, 1e9] {
        let p = |x: f64, y: f64| Point::new(x, y, 0.0) * scale;
        let bezier = |points: Vec<Point>| Curve::bezier(points).unwrap();
        let one = found(&bezier(vec![p(0.0, 0.0), p(3.0, 3.0), p(-2.0, 3.0), p(1.0, 0.0)]));
        assert!(one.meetings.len() == 1 && one.meetings[0].contact == Contact::Crossing, "{one:#?}");
        let none = found(&bezier(vec![p(0.0, 0.0), p(1.0, 3.0), p(2.0, 3.0), p(3.0, 0.0)]));
        assert!(none.meetings.is_empty() && none.overlaps.is_empty());
        // A cusp and a circle meet nobody.
        let cusp = found(&bezier(vec![p(0.0, 0.0), p(1.0, 1.0), p(0.0, 1.0), p(1.0, 0.0)]));
        assert!(cusp.meetings.is_empty() && cusp.overlaps.is_empty(), "{cusp:#?}");
        let ring = Curve::circle(p(1.0, 2.0), Vector::z(), scale).unwrap();
        for ring in [ring.to_periodic(0.0).unwrap().shape, ring] {
            let none = found(&ring);
            assert!(none.meetings.is_empty() && none.overlaps.is_empty(), "{none:#?}");
        }
    }
}

#[test]
fn a_star_crosses_itself_five_times() {
    let corner = |k: usize| {
        let a = std::f64::consts::TAU * (2 * k) as f64 / 5.0;
        Point::new(a.cos(), a.sin(), 0.0)
    };
    for degree in [1, 2, 3] {
        let space = Space::periodic_uniform(degree, 5).unwrap();
        let star = Curve::new(space, (0..5).map(corner).collect()).unwrap();
        for star in [star.to_clamped().unwrap(), star] {
            let five = found(&star);
            assert_eq!((five.meetings.len(), five.overlaps.len()), (5, 0), "{degree}: {five:#?}");
        }
    }
}

#[test]
fn what_goes_back_the_same_way_runs_together() {
    let points = [0.0, 2.0, 1.0].map(|x| Point::new(x, 0.0, 0.0)).to_vec();
    let there_and_back = Curve::new(Space::clamped(1, &[0.0, 1.0, 2.0]).unwrap(), points).unwrap();
    let both = found(&there_and_back);
    assert_eq!((both.meetings.len(), both.overlaps.len()), (0, 1), "{both:#?}");
    assert!((both.overlaps[0].range.0 - 0.5).abs() < 1e-6 && (both.overlaps[0].range.1 - 1.0).abs() < 1e-6);
}

#[test]
fn torn_curves_cross_as_two_do() {
    let points =
        [[0.0, 0.0], [2.0, 2.0], [0.0, 2.0], [2.0, 0.0]].map(|[x, y]| Point::new(x, y, 0.0)).to_vec();
    let torn = Curve::new(Space::open(1, vec![0.0, 0.0, 1.0, 1.0, 2.0, 2.0]).unwrap(), points).unwrap();
    let one = found(&torn);
    assert!(one.meetings.len() == 1 && (one.meetings[0].point - Point::new(1.0, 1.0, 0.0)).norm() < 1e-14);
}

#[test]
fn no_crossing_of_chords_is_missed() {
    let mut state = 3_u64;
    let mut next = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut count = 0;
    for case in 0..40 {
        let degree = 1 + case % 7;
        let n = degree + 4 + case % 5;
        let space = match case % 3 {
            0 => Space::clamped_uniform(degree, n).unwrap(),
            1 => Space::floating_uniform(degree, n).unwrap(),
            _ => Space::periodic_uniform(degree, n).unwrap(),
        };
        let points = (0..n).map(|_| Point::new(4.0 * next(), 4.0 * next(), 0.0)).collect();
        let weights = (case % 2 == 0).then(|| (0..n).map(|_| 0.3 + 2.0 * next()).collect());
        let curve = Curve::build(space, points, weights).unwrap();
        let all = found(&curve);
        let (a, b) = curve.domain();
        let chords: Vec<Point> =
            (0..=2000).map(|k| curve.point((a + (b - a) * f64::from(k) / 2000.0).min(b)).unwrap()).collect();
        let side = |o: &Point, e: &Point, p: &Point| (e - o).cross(&(p - o)).z;
        let mut crossings = 0;
        for (i, x) in chords.windows(2).enumerate() {
            for (j, y) in chords.windows(2).enumerate().skip(i + 2) {
                let seam = i == 0 && j == 1999 && curve.is_periodic();
                if !seam
                    && side(&x[0], &x[1], &y[0]) * side(&x[0], &x[1], &y[1]) < 0.0
                    && side(&y[0], &y[1], &x[0]) * side(&y[0], &y[1], &x[1]) < 0.0
                {
                    crossings += 1;
                    let near =
                        all.meetings.iter().map(|m| (m.point - x[0]).norm()).fold(f64::INFINITY, f64::min);
                    assert!(near < 0.05, "case {case}: {near} at {}", x[0]);
                }
            }
        }
        assert_eq!(all.meetings.len(), crossings, "case {case}: {all:#?}");
        count += crossings;
    }
    assert!(count >= 50, "{count}");
}

/// A curve that goes back and forth on a straight line: where it runs over itself is found to the ends, which are where it turns back, and without much work.
/// A place of the line that is passed `k` times is passed `k (k - 1) / 2` times by the overlaps at least: once for each pair.
#[test]
fn a_curve_folded_on_a_straight_line_runs_together_with_itself() {
    let along = [-1.1, 0.7, -2.4, -0.7, 1.0, -1.2, 0.6, -1.5, 1.0, -1.1, 0.6, 0.8];
    let knots =
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 3.0, 4.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0];
    for (way, degree) in [([1.0, 0.3, 0.0], 6), ([0.2, -1.0, 0.7], 6), ([1.0, 0.0, 0.0], 6)] {
        let points = along.map(|x| Point::from(Vector::from(way) * x)).to_vec();
        let curve = Curve::new(Space::open(degree, knots.to_vec()).unwrap(), points).unwrap();
        let begin = std::time::Instant::now();
        let found = self_intersections(&curve, &Options::default()).unwrap();
        assert!(begin.elapsed().as_secs() < 60, "{:?}", begin.elapsed());
        assert!(found.is_complete() && !found.overlaps.is_empty(), "{found:#?}");
        let length = Vector::from(way).norm();
        let place = |u: f64| curve.point(u).unwrap().coords.dot(&Vector::from(way)) / (length * length);
        // How often the curve passes a place, by the signs at many parameters.
        for k in 0..8 {
            let x = -0.9 + 0.2113 * k as f64;
            let many = 20_000;
            let passes = |from: f64, to: f64| {
                let side = |j: usize| place(from + (to - from) * j as f64 / many as f64) > x;
                (0..many).filter(|&j| side(j) != side(j + 1)).count()
            };
            let all = passes(0.0, 5.0);
            let over: usize = found.overlaps.iter().map(|o| passes(o.range.0, o.range.1)).sum();
            let wanted = all * all.saturating_sub(1) / 2;
            assert!(over >= wanted, "{x}: {all} passes, {over} of {wanted}");
        }
    }
}
