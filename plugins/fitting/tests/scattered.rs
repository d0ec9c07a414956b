//! Corners of points that scatter: all that are there and no others, whatever the scatter, the size, the spacing and where the chain begins.

#![allow(clippy::unwrap_used, reason = "tests")]

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use loftsman_fitting::{Corners, Fit, FittedCurve, Target};
use loftsman_kernel::{Point, Vector};

use crate::common::families::Random;

/// Points of an outline of lines and an arc, 0.7 to 1.2 apart, and where its four corners of 90° are.
fn outline() -> (Vec<Vector>, [usize; 4]) {
    let mut points = Vec::new();
    let mut line = |a: (f64, f64), b: (f64, f64), n: u32| {
        points.extend(
            (0..n)
                .map(|i| f64::from(i) / f64::from(n))
                .map(|t| Vector::new(a.0 + (b.0 - a.0) * t, a.1 + (b.1 - a.1) * t, 0.0)),
        );
    };
    line((0.0, 0.0), (40.0, 0.0), 60);
    for (from, to, n) in [((40.0, 20.0), (20.0, 20.0), 30), ((20.0, 20.0), (20.0, 35.0), 25)] {
        line(from, to, n);
    }
    line((20.0, 35.0), (0.0, 35.0), 30);
    line((0.0, 35.0), (0.0, 0.0), 50);
    let arc = (0..60).map(|i| PI * f64::from(i) / 60.0 - FRAC_PI_2);
    let arc: Vec<Vector> =
        arc.map(|a| Vector::new(40.0 + 10.0 * a.cos(), 10.0 + 10.0 * a.sin(), 0.0)).collect();
    points.splice(60..60, arc);
    (points, [0, 150, 175, 205])
}

/// The points off by normal deviates, a seed each.
fn stirred(points: &[Vector], deviation: f64, solid: bool, seed: u64) -> Vec<Vector> {
    let mut r = Random::new(seed);
    let mut off = |on: bool| if on { deviation * r.normal() } else { 0.0 };
    points.iter().map(|p| p + Vector::new(off(true), off(true), off(solid))).collect()
}

fn fitted(points: &[Vector], size: f64, closed: bool, tolerance: f64) -> FittedCurve {
    let points: Vec<Point> = points.iter().map(|p| Point::from(p * size)).collect();
    let fit = Fit { closed, corners: Corners::Auto, ..Fit::new(3, Target::Tolerance(tolerance * size)) };
    fit.curve(&points).unwrap()
}

/// Whether the corners are those and no others, by no more than so many points.
fn are(found: &[usize], wanted: &[usize], n: usize, within: usize) -> bool {
    let near =
        |&k: &usize, all: &[usize]| all.iter().any(|&w| k.abs_diff(w).min(n - k.abs_diff(w)) <= within);
    found.len() == wanted.len()
        && found.iter().all(|k| near(k, wanted))
        && wanted.iter().all(|k| near(k, found))
}

#[test]
fn all_corners_of_an_outline_and_no_others() {
    let (exact, corners) = outline();
    let n = exact.len();
    let mut wrong = Vec::new();
    for (deviation, tolerance) in [
        (0.003, 0.02),
        (0.01, 0.05),
        (0.02, 0.1),
        (0.05, 0.2),
        (0.1, 0.4),
        (0.1, 0.6),
        (0.2, 0.8),
        (0.3, 1.2),
        (0.3, 2.0),
    ] {
        for seed in 0..8 {
            let (roll, solid) = ([0, 20, 150][seed as usize % 3], seed % 2 == 1);
            let size = [1.0, 1e-9, 1e9][seed as usize % 3];
            let mut points = stirred(&exact, deviation, solid, seed);
            points.rotate_left(roll);
            let found = fitted(&points, size, true, tolerance);
            let places: Vec<usize> = found.corners.iter().map(|k| (k + roll) % n).collect();
            if !are(&places, &corners, n, 3) {
                wrong.push((deviation, tolerance, seed, places));
            }
            let Some(scatter) = found.scatter else {
                // From point to point it turns by less than that says anything.
                assert!(deviation < 0.025);
                continue;
            };
            let told = scatter.deviation / size;
            // In space both directions that are normal to the curve count.
            let true_one = if solid { deviation * 2_f64.sqrt() } else { deviation };
            assert!((told / true_one - 1.0).abs() < 0.25, "{told} of {true_one}");
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

#[test]
fn what_is_round_has_none() {
    let ring = |a: f64, b: f64, n: u32| -> Vec<Vector> {
        let angle = (0..n).map(|i| TAU * f64::from(i) / f64::from(n));
        angle.map(|t| Vector::new(a * t.cos(), b * t.sin(), 0.0)).collect()
    };
    // A square with sides of 20 and round corners of radius 6.
    let fillet = |i: u32| -> Vec<Vector> {
        let turned = |v: Vector| match i {
            0 => v,
            1 => Vector::new(-v.y, v.x, 0.0),
            2 => -v,
            _ => Vector::new(v.y, -v.x, 0.0),
        };
        let side = (0..12).map(|k| Vector::new(10.0, -4.0 + 8.0 * f64::from(k) / 12.0, 0.0));
        let arc = (0..14).map(|k| FRAC_PI_2 * f64::from(k) / 14.0);
        let arc = arc.map(|a| Vector::new(4.0 + 6.0 * a.cos(), 4.0 + 6.0 * a.sin(), 0.0));
        side.chain(arc).map(turned).collect()
    };
    let square: Vec<Vector> = (0..4).flat_map(fillet).collect();
    let mut wrong = Vec::new();
    for (name, points) in [
        ("circle", ring(10.0, 10.0, 90)),
        ("ellipse", ring(20.0, 8.0, 140)),
        ("slim ellipse", ring(40.0, 6.0, 400)),
        ("square", square),
    ] {
        for deviation in [0.03, 0.06, 0.1, 0.2] {
            for seed in 0..6 {
                let points = stirred(&points, deviation, seed % 2 == 1, seed);
                // A nose of radius 0.9 is a corner, as far as anybody can tell.
                if name == "slim ellipse" && deviation > 0.1 {
                    continue;
                }
                let found = fitted(&points, 1.0, true, 4.0 * deviation);
                if !found.corners.is_empty() {
                    wrong.push((name, deviation, seed, found.corners));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

#[test]
fn angles_spacing_and_many_points() {
    let mut wrong = Vec::new();
    for turn in [75.0_f64, 90.0, 120.0, 150.0] {
        for many in [60_u32, 600, 20_000] {
            for seed in 0..4 {
                // An open wedge with sides of 30, points spaced unevenly, and a bow in one side.
                let mut r = Random::new(seed + 100);
                let out = turn.to_radians();
                let mut along: Vec<f64> = (0..many).map(|_| 30.0 * r.unit()).collect();
                along.extend([0.0, 30.0]);
                along.sort_by(f64::total_cmp);
                let first = along.iter().rev().map(|&x| Vector::new(-x, 0.02 * x * x, 0.0));
                let second = along[1..].iter().map(|&x| Vector::new(out.cos(), out.sin(), 0.0) * x);
                let points: Vec<Vector> = first.chain(second).collect();
                let deviation = 0.15;
                let points = stirred(&points, deviation, seed % 2 == 1, seed);
                let tolerance = 6.0 * deviation;
                let found = fitted(&points, 1.0, false, tolerance);
                let corner = many as usize + 1;
                let near = |k: usize| (points[k] - points[corner]).norm() < 8.0 * deviation;
                if found.corners.len() != 1 || !near(found.corners[0]) {
                    wrong.push((turn, many, seed, found.corners, found.scatter));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// A turn of 60° is one more or less: it is told as doubtful, whichever way it went.
#[test]
fn what_scatter_leaves_in_doubt_is_told() {
    let out = 58_f64.to_radians();
    for seed in 0..6 {
        let first = (0..40).map(|i| Vector::new(f64::from(i) - 40.0, 0.0, 0.0));
        let second = (0..40).map(|i| Vector::new(out.cos(), out.sin(), 0.0) * f64::from(i));
        let points: Vec<Vector> = first.chain(second).collect();
        let found = fitted(&stirred(&points, 0.2, false, seed), 1.0, false, 0.8);
        let doubtful = found.scatter.unwrap().doubtful;
        assert!(
            doubtful.iter().any(|d| d.point.abs_diff(40) <= 3),
            "{seed}: {doubtful:?} {:?}",
            found.corners
        );
        assert!(doubtful.iter().all(|d| d.taken == found.corners.contains(&d.point)));
    }
}

/// What does not scatter, or by more than the tolerance, is looked at from point to point.
#[test]
fn points_that_do_not_scatter_are_taken_as_they_are() {
    let (exact, corners) = outline();
    let found = fitted(&exact, 1.0, true, 0.2);
    assert_eq!((found.corners.as_slice(), found.scatter), (corners.as_slice(), None));
}

/// Two arcs of radius 20 and 25 that meet at a corner, from point 60 on, curving on to either side, or two lines: the sharper the turn the more they look like the flanks of a nose.
#[test]
fn sharp_corners_are_no_noses() {
    let mut wrong = Vec::new();
    for degrees in [90.0_f64, 110.0, 125.0, 140.0, 150.0] {
        for bent in [-1.0, 0.0, 1.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let before = (0..60).map(|i| {
                let t = 1.5 * f64::from(i - 60) / 60.0;
                if bent == 0.0 {
                    Vector::new(20.0 * t, 0.0, 0.0)
                } else {
                    Vector::new(20.0 * t.sin(), 20.0 * (1.0 - t.cos()), 0.0)
                }
            });
            let after = (0..=60).map(|i| {
                let t = 1.4 * f64::from(i) / 60.0;
                let [x, y] = if bent == 0.0 {
                    [25.0 * t, 0.0]
                } else {
                    [25.0 * t.sin(), 25.0 * bent * (1.0 - t.cos())]
                };
                Vector::new(cos * x - sin * y, sin * x + cos * y, 0.0)
            });
            let exact: Vec<Vector> = before.chain(after).collect();
            for deviation in [0.04, 0.08, 0.12] {
                for seed in 0..14 {
                    let points = stirred(&exact, deviation, false, seed);
                    let found = fitted(&points, [1.0, 1e-9, 1e9][seed as usize % 3], false, 0.4);
                    if !are(&found.corners, &[60], exact.len(), 4) {
                        wrong.push((degrees, bent, deviation, seed, found.corners));
                    }
                }
            }
        }
    }
    // One of them has points so far off beside the corner that no two parabolas follow them.
    assert!(wrong.len() <= 1, "{} of 630: {wrong:?}", wrong.len());
}

/// A gear of 8 teeth, turned in space: its 32 corners, where even noise of half the tolerance goes to all sides (in two directions normal to the curve, so that in all it is more than half
/// of it).
#[test]
fn scatter_in_space_counts_by_directions() {
    let mut exact = Vec::new();
    let mut corners = Vec::new();
    for tooth in 0..16 {
        let angle = |part: f64| TAU * (f64::from(tooth) + part) / 16.0;
        let (own, other) = if tooth % 2 == 0 { (30.0, 22.0) } else { (22.0, 30.0) };
        let at = |r: f64, a: f64| Vector::new(r * a.cos(), 0.6 * r * a.sin(), 0.8 * r * a.sin());
        corners.push(exact.len());
        exact.extend((0..16).map(|i| at(own, angle(f64::from(i) / 16.0))));
        corners.push(exact.len());
        exact.extend((0..12).map(|i| at(own + (other - own) * f64::from(i) / 12.0, angle(1.0))));
    }
    let mut wrong = Vec::new();
    for tolerance in [0.1, 0.2] {
        for seed in 0..30 {
            let mut random = Random::new(seed);
            let mut off = || tolerance * (random.unit() - 0.5);
            let points: Vec<Vector> = exact.iter().map(|p| p + Vector::new(off(), off(), off())).collect();
            let found = fitted(&points, [1.0, 1e-9, 1e9][seed as usize % 3], true, tolerance);
            if !are(&found.corners, &corners, exact.len(), 2) {
                wrong.push((tolerance, seed, found.corners.len()));
            }
        }
    }
    assert!(wrong.is_empty(), "{} of 60: {wrong:?}", wrong.len());
}

/// Everyday outlines, open and closed, at noise of an eighth to a quarter of the tolerance: all corners that are there and no others.
#[test]
fn everyday_outlines() {
    let polar = |n: u32, turns: f64, r: &dyn Fn(f64) -> f64| -> Vec<Vector> {
        let angle = (0..n).map(|i| TAU * turns * f64::from(i) / f64::from(n));
        angle.map(|t| Vector::new(r(t) * t.cos(), r(t) * t.sin(), 0.0)).collect()
    };
    // Tips turn by 128° and 137°; between them the star of 4 turns by 38°, which is no corner, that of 6 by 77°.
    let star = |tips: u32, inner: f64, each: u32, every: u32| -> (Vec<Vector>, Vec<usize>) {
        let at = |j: u32| {
            let (r, a) =
                (if j.is_multiple_of(2) { 30.0 } else { inner }, PI * f64::from(j) / f64::from(tips));
            Vector::new(r * a.cos(), r * a.sin(), 0.0)
        };
        let side = |j: u32| (0..each).map(move |i| at(j).lerp(&at(j + 1), f64::from(i) / f64::from(each)));
        (
            (0..2 * tips).flat_map(side).collect(),
            (0..2 * tips / every).map(|j| (j * every * each) as usize).collect(),
        )
    };
    // Two arcs that meet in two tips, each turning by a right angle or more.
    let lens = |half: f64| -> (Vec<Vector>, Vec<usize>) {
        let r = 20.0 / half.sin();
        let arc = |from: f64, sign: f64| {
            (0..70)
                .map(move |i| from + half * (1.0 - f64::from(i) / 35.0))
                .map(move |a| Vector::new(r * a.cos(), r * (a.sin() - sign * half.cos()), 0.0))
        };
        (arc(FRAC_PI_2, 1.0).chain(arc(-FRAC_PI_2, -1.0)).collect(), vec![0, 70])
    };
    let helix = (0..400).map(|i| 0.04 * f64::from(i));
    let helix = helix.map(|t| Vector::new(15.0 * t.cos(), 15.0 * t.sin(), 2.0 * t)).collect();
    let shapes = [
        ("wavy", true, (polar(400, 1.0, &|t| 20.0 + 4.0 * (3.0 * t + 1.0).cos()), Vec::new())),
        ("circle", true, (polar(250, 1.0, &|_| 20.0), Vec::new())),
        ("spiral", false, (polar(600, 3.0, &|t| 3.0 + t), Vec::new())),
        ("helix", false, (helix, Vec::new())),
        ("star of 4", true, star(4, 14.0, 25, 2)),
        ("star of 6", true, star(6, 14.0, 25, 1)),
        ("lens", true, lens(0.6)),
        ("thick lens", true, lens(0.78)),
    ];
    let mut wrong = Vec::new();
    for (name, closed, (exact, corners)) in &shapes {
        for tolerance in [0.1, 0.4] {
            for share in [0.125, 0.25] {
                for seed in 0..12 {
                    let points = stirred(exact, share * tolerance, seed % 2 == 1, seed);
                    let found = fitted(&points, [1.0, 1e-9, 1e9][seed as usize % 3], *closed, tolerance);
                    if !are(&found.corners, corners, exact.len(), 4) {
                        wrong.push((name, tolerance, share, seed, found.corners));
                    }
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} of 384: {wrong:?}", wrong.len());
}
