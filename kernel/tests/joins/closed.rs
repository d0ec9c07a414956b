//! Closed edges: periodic ones, revolutions whose seams lie elsewhere, poles.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use loftsman_kernel::solve::Automatic;
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};

use super::family::Random;
use super::{Pair, solvers};

/// A tube about z over `[low, high]`, its vertices turned by `turn` of its vertices.
fn tube(random: &mut Random, around: Space, (low, high): (f64, f64), turn: f64, backwards: bool) -> Surface {
    let over = Space::clamped_uniform(3, 4).unwrap();
    let (n, m) = (around.len(), over.len());
    let points = (0..n * m)
        .map(|k| {
            let angle = TAU * ((k / m) as f64 / n as f64 + turn) * if backwards { -1.0 } else { 1.0 };
            let z = low + (high - low) * (k % m) as f64 / (m - 1) as f64;
            let r = 2.0 + random.between(-0.05, 0.05);
            Point::new(r * angle.cos(), r * angle.sin(), z)
        })
        .collect();
    Surface::new(around, over, points).unwrap()
}

/// Uniform periodic edges that start elsewhere, and run the other way: they are brought together where they lie.
#[test]
fn periodic_edges_start_where_they_are_nearest() {
    let mut random = Random::new(5);
    let mut count = 0;
    for degree in 1..=5 {
        for turn in 0..8 {
            for backwards in [false, true] {
                let around = || Space::periodic_uniform(degree, 8).unwrap();
                let a = tube(&mut random, around(), (0.0, 1.0), 0.0, false);
                let b = tube(&mut random, around(), (1.1, 2.0), f64::from(turn) / 8.0, backwards);
                for order in 0..=2 {
                    let pair = Pair { a: a.clone(), b: b.clone(), edges: ("v1", "v0"), order };
                    let done = pair.solve(pair.join(), Arc::new(Automatic)).unwrap();
                    // Function i has its middle (p + 1)/2 knots after knot i: backwards that comes in twice.
                    let shift = f64::from(turn) / 8.0;
                    let middle = (degree as f64 + 1.0) / 8.0;
                    let there = |x: f64| {
                        let y = if backwards { -shift + middle - x } else { x - shift };
                        y - y.floor()
                    };
                    let apart = done.apart(there);
                    assert!(
                        apart.iter().all(|a| *a <= 1e-12),
                        "degree {degree}, {turn} {backwards}: {apart:?}"
                    );
                    // It did not twist: no vertex went further than the gap (some way, where derivatives agree).
                    let moved = pair.a.points().iter().zip(done.a.points());
                    assert!(moved.fold(0.0_f64, |m, (p, q)| m.max((p - q).norm())) < 0.5);
                    count += 1;
                }
            }
        }
    }
    assert_eq!(count, 240);
}

#[test]
fn periodic_edges_of_unlike_knots_are_refused_and_nested_ones_joined() {
    let mut random = Random::new(6);
    let around = |n| Space::periodic_uniform(3, n).unwrap();
    for (n, m, fits) in [(6, 12, true), (8, 6, false), (7, 9, false), (5, 10, true), (6, 9, false)] {
        for order in 0..=2 {
            let a = tube(&mut random, around(n), (0.0, 1.0), 0.0, false);
            let b = tube(&mut random, around(m), (1.1, 2.0), 0.0, false);
            let pair = Pair { a, b, edges: ("v1", "v0"), order };
            for solver in solvers().into_iter().take(4) {
                match pair.solve(pair.join(), solver) {
                    Ok(done) => {
                        let seen = done.witnessed(&pair, &pair.join());
                        assert!(seen <= 1e-13, "{n} {m} C{order}: {seen:e}");
                        // Every second of 8 or 6 knots, every third of 9 is one of the other's: two or three spans.
                        assert!(fits || (n, m) != (7, 9), "{n} {m}");
                    }
                    Err(error) => {
                        assert!(
                            !fits && error.to_string().contains("closed and have unlike knots"),
                            "{error}"
                        );
                    }
                }
            }
        }
    }
}

/// A clamped edge that is closed, and a periodic one: the clamped one stays closed.
#[test]
fn a_clamped_closed_edge_with_a_periodic_one() {
    let mut random = Random::new(7);
    for turn in 0..6 {
        let ring = tube(&mut random, Space::periodic_uniform(3, 6).unwrap(), (0.0, 1.0), 0.0, false);
        let other = tube(
            &mut random,
            Space::periodic_uniform(3, 6).unwrap(),
            (1.1, 2.0),
            f64::from(turn) / 6.0,
            false,
        );
        for clamped_first in [false, true] {
            for order in 0..=1 {
                let pair = if clamped_first {
                    Pair { a: ring.to_clamped().unwrap(), b: other.clone(), edges: ("v1", "v0"), order }
                } else {
                    Pair { a: ring.clone(), b: other.to_clamped().unwrap(), edges: ("v1", "v0"), order }
                };
                for solver in solvers().into_iter().take(4) {
                    let by = solver.name().to_owned();
                    let done = pair.solve(pair.join(), solver).unwrap();
                    let there = |x: f64| {
                        let y = x - f64::from(turn) / 6.0;
                        y - y.floor()
                    };
                    let apart = done.apart(there);
                    assert!(apart.iter().all(|a| *a <= 1e-11), "turn {turn} {clamped_first} {by}: {apart:?}");
                }
            }
        }
    }
}

/// Spheres and cylinders whose seams lie a quarter (or more) of a turn apart: exact circles, weights alike.
#[test]
fn revolutions_join_along_their_circles() {
    let axis = Vector::z();
    let mut count = 0;
    for quarter in 0..4 {
        let seam = f64::from(quarter) * PI / 2.0;
        let out = Vector::new(seam.cos(), seam.sin(), 0.0);
        // From the equator up to the pole, and a cylinder below with a gap.
        let meridian = Curve::elliptic_arc(Point::origin(), out * 1.02, axis, 0.0, PI / 2.0).unwrap();
        let wall = Curve::line(Point::new(1.0, 0.0, -2.0), Point::new(1.0, 0.0, -0.1)).unwrap();
        for sweep in [PI, 1.5 * PI, TAU] {
            if sweep < TAU && quarter > 0 {
                continue;
            }
            let dome = Surface::revolution(&meridian, Point::origin(), axis, sweep).unwrap();
            let cylinder = Surface::revolution(&wall, Point::origin(), axis, sweep).unwrap();
            for order in 0..=2 {
                let pair = Pair { a: cylinder.clone(), b: dome.clone(), edges: ("v1", "v0"), order };
                for solver in solvers().into_iter().take(4) {
                    let by = solver.name().to_owned();
                    let done = pair.solve(pair.join(), solver).unwrap();
                    let there = |x: f64| {
                        let y = x - f64::from(quarter) / 4.0;
                        if y < 0.0 { y + 1.0 } else { y }
                    };
                    let apart = done.apart(there);
                    assert!(
                        apart.iter().all(|a| *a <= 1e-12),
                        "seam {quarter}, sweep {sweep}, {by}: {apart:?}"
                    );
                    let moved = pair.a.points().iter().zip(done.a.points());
                    assert!(moved.fold(0.0_f64, |m, (p, q)| m.max((p - q).norm())) < 2.5);
                    count += 1;
                }
            }
        }
    }
    assert_eq!(count, (3 + 1 + 1 + 1) * 3 * 4);
}

/// Edges that are points: two poles meet, also with unlike weights; a pole and a circle too, the weights alike.
#[test]
fn poles() {
    let axis = Vector::z();
    let meridian = Curve::elliptic_arc(Point::origin(), Vector::x(), axis, 0.0, PI / 2.0).unwrap();
    let dome = Surface::revolution(&meridian, Point::origin(), axis, TAU).unwrap();
    let side = Curve::line(Point::new(0.0, 0.0, 1.2), Point::new(1.0, 0.0, 2.0)).unwrap();
    let cone = Surface::revolution(&side, Point::origin(), axis, TAU).unwrap();
    let (u, v, points, weights) = cone.clone().into_parts();
    let mut weights = weights.unwrap();
    weights.iter_mut().enumerate().for_each(|(i, w)| *w *= 1.0 + 0.1 * (i / 2 % 3) as f64);
    let unlike = Surface::rational(u, v, points, weights).unwrap();
    for solver in solvers().into_iter().take(4) {
        for order in 0..=1 {
            let pair = Pair { a: dome.clone(), b: cone.clone(), edges: ("v1", "v0"), order };
            let done = pair.solve(pair.join(), Arc::clone(&solver)).unwrap();
            assert!(done.witnessed(&pair, &pair.join()) <= 1e-13);
            assert!(done.apart(|x| x).iter().all(|a| *a <= 1e-12));
            let pair = Pair { b: unlike.clone(), ..pair };
            match pair.solve(pair.join(), Arc::clone(&solver)) {
                Ok(done) => assert!(order == 0 && done.apart(|x| x)[0] <= 1e-12),
                Err(error) => {
                    assert!(order == 1 && error.to_string().contains("shrunk to a point"), "{error}");
                }
            }
        }
        let pair = Pair { a: dome.clone(), b: cone.clone(), edges: ("v1", "v1"), order: 0 };
        let done = pair.solve(pair.join(), Arc::clone(&solver)).unwrap();
        assert!(done.apart(|x| x)[0] <= 1e-12 || done.apart(|x| 1.0 - x)[0] <= 1e-12);
        let pair = Pair { b: unlike.clone(), ..pair };
        assert!(pair.solve(pair.join(), solver).unwrap_err().to_string().contains("shrunk to a point"));
    }
}
