//! What is asked beside a range is asked of the whole curve, while only the range's part may change.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests may fail the test")]

use loftsman_area_volume::{area, area_of, centroid, length};
use loftsman_fine_tuning::{FineTune, FineTuneError, alpha_of, alpha_space};
use loftsman_kernel::edit::{Ask, Axis};
use loftsman_kernel::functional::{derivative, position, vertex};
use loftsman_kernel::spline::algebra::Function;
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

/// Numbers in [0, 1), always the same.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// A plane loop: periodic, or clamped with both ends in one point.
fn ring(degree: usize, n: usize, size: f64, periodic: bool, random: &mut Random) -> Curve {
    let mut knots = vec![0.0];
    (0..n).for_each(|k| knots.push(knots[k] + 0.5 + random.next()));
    let point = |i: usize, random: &mut Random| {
        let (sin, cos) = (std::f64::consts::TAU * i as f64 / n as f64).sin_cos();
        let r = size * (0.8 + 0.4 * random.next());
        Point::new(3.0 * r * cos, 2.0 * r * sin, 0.0)
    };
    let points: Vec<Point> = (0..n).map(|i| point(i, random)).collect();
    if periodic {
        return Curve::new(Space::periodic(degree, knots).unwrap(), points).unwrap();
    }
    let mut points = points;
    points[n - 1] = points[0];
    Curve::new(Space::clamped_uniform(degree, n).unwrap(), points).unwrap()
}

/// α over a part, with enough values for ends, derivatives and more.
fn alpha_on(degree: usize, (a, b): (f64, f64), random: &mut Random) -> Function<f64> {
    let at = |i: usize| if i == 14 { b } else { a + (b - a) * i as f64 / 14.0 };
    let space = Space::clamped(degree, &(0..=14).map(at).collect::<Vec<_>>()).unwrap();
    let values = (0..space.len()).map(|_| 0.8 + 0.4 * random.next()).collect();
    Function::new(space, values).unwrap()
}

fn polyline_length(curve: &Curve) -> f64 {
    let (a, b) = curve.domain();
    let at = |k: u32| curve.point(a + (b - a) * f64::from(k) / 200_000.0).unwrap();
    (0..200_000).map(|k| (at(k + 1) - at(k)).norm()).sum()
}

/// Outside of the range every bit is as it is in a tuning without constraints, which leaves the given curve there.
fn outside_is_the_same(given: &FineTune, tuned: &Curve, (a, b): (f64, f64), case: u64) {
    let plain = given.solve().unwrap();
    let (start, end) = tuned.domain();
    assert_eq!(plain.curve().space(), tuned.space(), "{case}");
    for k in 0..=200 {
        let u = start + (end - start) * f64::from(k) / 200.0;
        if u < a || u > b {
            assert_eq!(plain.curve().point(u).unwrap(), tuned.point(u).unwrap(), "{case}: outside at {u}");
        }
    }
}

/// Areas and centroids of loops, of which a part is tuned: of all degrees and sizes, periodic and clamped.
#[test]
fn areas_and_centroids_of_the_whole() {
    let (mut done, mut refused) = (0, 0);
    for case in 0..84 {
        let random = &mut Random(case);
        let (degree, periodic) = (1 + (case as usize) % 7, case % 2 == 0);
        let size = [1.0, 1e-9, 1e9][case as usize % 3];
        let curve = ring(degree, 10 + (case as usize) % 5, size, periodic, random);
        let (start, end) = curve.domain();
        let a = start + (end - start) * 0.4 * random.next();
        let b = a + (end - start) * (0.35 + 0.2 * random.next());
        let asked = alpha_on(2 + (case as usize) % 3, (a, b), random);
        let plain = FineTune::new(&curve, asked).between(a, b).continuity((case % 3) as u8);
        let of_area = plain.clone().ask(area().scale(1.02));
        // A centroid kept as well takes more than a part's α does without tangents that turn round.
        let both = case % 4 == 3;
        let tune = if both { of_area.ask(centroid().axis(Axis::X).keep()).any_sign() } else { of_area };
        let tuned = match tune.solve() {
            Ok(tuned) => tuned,
            Err(FineTuneError::NoPositive { .. } | FineTuneError::Edit(_)) => {
                refused += 1;
                continue;
            }
            Err(error) => panic!("{case}: {error}"),
        };
        done += 1;
        let (was, is) = (area_of(&curve).unwrap(), area_of(tuned.curve()).unwrap());
        assert!((is - 1.02 * was).abs() < 1e-9 * was.abs(), "{case}: {was} {is}");
        outside_is_the_same(&plain, tuned.curve(), (a, b), case);
        for s in [0.1, 0.45, 0.8] {
            let u = a + s * (b - a);
            let wanted = curve.derivative(u, 1).unwrap() * tuned.alpha().value(u).unwrap();
            let off = (tuned.curve().derivative(u, 1).unwrap() - wanted).norm();
            assert!(off < 1e-9 * size, "{case}: {off:e}");
        }
        assert!(tuned.report().change >= plain.solve().unwrap().report().change * (1.0 - 1e-9), "{case}");
    }
    assert!(done >= 78, "{done} done, {refused} refused");
}

/// The length of an open curve, by an independent sum of chords.
#[test]
fn the_length_of_the_whole() {
    let random = &mut Random(7);
    let points = (0..12).map(|i| Point::new(f64::from(i), 3.0 * random.next(), 2.0 * random.next()));
    let curve = Curve::new(Space::clamped_uniform(3, 12).unwrap(), points.collect()).unwrap();
    let alpha = alpha_on(2, (2.3, 6.7), random);
    let plain = FineTune::new(&curve, alpha).between(2.3, 6.7);
    let tuned = plain.clone().ask(length().scale(1.01)).solve().unwrap();
    let (was, is) = (polyline_length(&curve), polyline_length(tuned.curve()));
    assert!((is - 1.01 * was).abs() < 1e-8 * was, "{was} {is}");
    outside_is_the_same(&plain, tuned.curve(), (2.3, 6.7), 0);
}

/// A point inside of the range: what the part by itself has, for the end, the derivatives and the point are all equations of α.
#[test]
fn points_inside_are_those_of_the_part() {
    for degree in 2..=6 {
        let random = &mut Random(degree as u64);
        let n = degree + 9;
        let points = (0..n).map(|i| Point::new(i as f64, 2.0 * random.next(), random.next())).collect();
        let curve = Curve::new(Space::floating_uniform(degree, n).unwrap(), points).unwrap();
        let (start, end) = curve.domain();
        let (a, b) = (start + 0.2 * (end - start), start + 0.8 * (end - start));
        let alpha = alpha_on(2, (a, b), random);
        let at = 0.5 * (a + b) + 0.01;
        let to = curve.point(at).unwrap() + Vector::new(0.02, -0.03, 0.01);
        let whole = FineTune::new(&curve, alpha.clone()).between(a, b).through(at, to).solve().unwrap();
        assert!((whole.curve().point(at).unwrap() - to).norm() < 1e-11);
        let part = curve.between(a, b).unwrap();
        let alone = FineTune::new(&part, alpha).continuity(2).through(at, to).solve().unwrap();
        let pairs = whole.alpha().coefficients().iter().zip(alone.alpha().coefficients());
        let off = pairs.fold(0.0_f64, |m, (x, y)| m.max((x - y).abs()));
        assert!(off < 1e-8, "{degree}: {off:e}");
    }
}

/// Outside of the range nothing moves: what is there already holds, what is not is a contradiction that is named.
#[test]
fn what_is_outside_is_constant() {
    let random = &mut Random(3);
    let curve = ring(3, 12, 1.0, true, random);
    let (_, end) = curve.domain();
    let (a, b) = (0.3 * end, 0.7 * end);
    let alpha = alpha_on(2, (a, b), random);
    let tune = FineTune::new(&curve, alpha).between(a, b);
    let there = curve.point(0.1 * end).unwrap();
    let plain = tune.solve().unwrap();
    let tuned = tune.clone().through(0.1 * end, there).ask(derivative(0.9 * end, 1).keep()).solve().unwrap();
    let pairs = plain.curve().points().iter().zip(tuned.curve().points());
    assert!(pairs.fold(0.0_f64, |m, (p, q)| m.max((p - q).norm())) < 1e-10);
    let error = tune.clone().through(0.1 * end, there + Vector::x()).solve().unwrap_err().to_string();
    assert!(error.contains("through[0]"), "{error}");
    let moved = position(0.9 * end).by(Vector::new(0.0, 0.1, 0.0)).called("the tail");
    let error = tune.clone().ask(moved).solve().unwrap_err().to_string();
    assert!(error.contains("the tail"), "{error}");
    // Control vertices are the tuned curve's: the first is far from the range.
    assert!(tune.clone().ask(vertex(0).keep()).solve().is_ok());
}

/// All of a period, and all of an open curve, said as a range.
#[test]
fn a_range_that_is_the_whole() {
    for periodic in [true, false] {
        let random = &mut Random(11);
        let curve = ring(3, 13, 1.0, periodic, random);
        let (start, end) = curve.domain();
        let count = alpha_space(&curve).unwrap().len();
        let alpha = alpha_of(&curve, (0..count).map(|_| 0.9 + 0.2 * random.next()).collect()).unwrap();
        let tuned = FineTune::new(&curve, alpha).between(start, end).continuity(1).ask(area().keep());
        let tuned = tuned.solve().unwrap();
        let (was, is) = (area_of(&curve).unwrap(), area_of(tuned.curve()).unwrap());
        assert!((is - was).abs() < 1e-10 * was.abs(), "{was} {is}");
    }
}

/// A part over the seam of a closed curve is the same as one of the curve begun elsewhere; what is outside does not move, and the period stays where it was.
#[test]
fn a_range_over_the_seam() {
    let mut cases = 0;
    for degree in 2..=5 {
        for seed in 0..6 {
            let random = &mut Random(100 * degree as u64 + seed);
            let curve = ring(degree, 12, [1e-6, 1.0, 1e6][seed as usize % 3], true, random);
            let (start, end) = curve.domain();
            let knots = curve.space().breakpoints();
            // At knots, between them, once round, to the seam's own knot.
            let (a, b) = match seed {
                0 => (knots[8], end + (knots[3] - start)),
                1 => (0.5 * (knots[9] + knots[10]), end + 0.3 * (knots[1] - start)),
                2 => (knots[5], knots[5] + (end - start)),
                3 => (end - 0.4 * (end - knots[11]), end + 1.7),
                4 => (knots[7] + 0.1, end + (knots[1] - start)),
                _ => (0.2 * start + 0.8 * end, end + 0.2 * (end - start)),
            };
            let alpha = alpha_on(degree - 1, (a, b), random);
            let tuned = FineTune::new(&curve, alpha.clone()).between(a, b);
            let middle = 0.47 * a + 0.53 * b;
            let inside = middle - if middle > end { end - start } else { 0.0 };
            let bent = loftsman_kernel::functional::curvature(inside).scale(1.1);
            let tunes = [tuned.clone(), tuned.clone().ask(area().keep()), tuned.ask(bent)];
            for (k, tune) in tunes.iter().enumerate() {
                let case = format!("degree {degree}, {seed}, {k}");
                let found = tune.solve().unwrap_or_else(|error| panic!("{case}: {error}"));
                let found = found.curve();
                assert_eq!((found.domain(), found.is_periodic()), ((start, end), true), "{case}");
                let size = curve.points().iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()));
                let mut most = 0.0_f64;
                for i in 0..400 {
                    let u = start + (end - start) * (f64::from(i) + 0.3) / 400.0;
                    let moved = (found.point(u).unwrap() - curve.point(u).unwrap()).norm();
                    let outside = u < a && u > b - (end - start);
                    assert!(!outside || moved < 1e-13 * size, "{case}: {u} moved by {moved:e}");
                    most = most.max(moved);
                }
                assert!(most > 1e-5 * size, "{case}: {most:e}");
                if k == 1 {
                    let (was, is) = (area_of(&curve).unwrap(), area_of(found).unwrap());
                    assert!((was - is).abs() < 1e-10 * was.abs(), "{case}: {was} {is}");
                }
                if k == 2 {
                    let bend = |c: &Curve| {
                        c.derivative(inside, 2).unwrap().cross(&c.derivative(inside, 1).unwrap()).norm()
                            / c.derivative(inside, 1).unwrap().norm().powi(3)
                    };
                    assert!(
                        (bend(found) / bend(&curve) - 1.1).abs() < 1e-8,
                        "{case}: {}",
                        bend(found) / bend(&curve)
                    );
                }
                if k == 0 && seed != 2 {
                    // On the other side, so that neither is at the seam.
                    let other = curve.started_at(0.5 * (b - (end - start) + a)).unwrap();
                    let lag = if other.domain().0 > a { end - start } else { 0.0 };
                    let shifted = |t: &f64| t + lag;
                    let space =
                        Space::open(degree - 1, alpha.space().knots().iter().map(shifted).collect()).unwrap();
                    let moved = Function::new(space, alpha.coefficients().to_vec()).unwrap();
                    let there =
                        FineTune::new(&other, moved.clone()).between(a + lag, b + lag).solve().unwrap();
                    for i in 0..200 {
                        let u = start + (end - start) * f64::from(i) / 200.0;
                        let off = (there.curve().point(u).unwrap() - found.point(u).unwrap()).norm();
                        assert!(off < 1e-10 * size, "{case}: {u}, {off:e}");
                    }
                }
                cases += 1;
            }
        }
    }
    assert_eq!(cases, 72);
    // What is given round the whole period goes over the seam, too; and what cannot be is told.
    let curve = ring(3, 12, 1.0, true, &mut Random(5));
    let (start, end) = curve.domain();
    let values: Vec<f64> = (0..12).map(|k| 1.0 + 0.1 * f64::from(k % 4)).collect();
    let alpha = alpha_of(&curve, values).unwrap();
    let tuned = FineTune::new(&curve, alpha.clone()).between(end - 3.0, end + 3.5).solve().unwrap();
    assert_eq!(tuned.curve().domain(), (start, end));
    let text =
        |a: f64, b: f64| FineTune::new(&curve, alpha.clone()).between(a, b).solve().unwrap_err().to_string();
    assert!(text(end - 3.0, start + 2.0).contains("over the seam"), "{}", text(end - 3.0, start + 2.0));
    assert!(text(end - 3.0, 2.0 * end).contains("once round"), "{}", text(end - 3.0, 2.0 * end));
    let open = Function::constant(Space::clamped(2, &curve.space().breakpoints()).unwrap(), 1.1).unwrap();
    let error = FineTune::new(&curve, open).between(end - 3.0, end + 2.0).solve().unwrap_err().to_string();
    assert!(error.contains("not periodic"), "{error}");
}
